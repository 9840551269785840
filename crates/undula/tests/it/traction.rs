//! Prescribed force per area on a boundary, against closed forms.

use crate::common::{self, SCHEMES, sets, wrong};
use undula::case::Case;
use undula::simulation::Simulation;
use undula::verification::newmark::newmark;
use undula::verification::unit_square::errors;

/// Poiseuille's flow between two plates, driven by the tractions at both ends: with ρ = 1, ν = 0.1 and v = 4 y (1 − y) a
/// the pressure falls by 3.2 a, and σ n has the shear stress ±0.1 · 4 (1 − 2 y) a besides. a is 1 or t.
pub fn channel(a: &str, more: &[&str]) -> Case {
    let forces = r#"
[functional.inlet]
kind = "force"
on = ["left"]
component = "x"
[functional.walls]
kind = "force"
on = ["top", "bottom"]
component = "x"
"#;
    let (inlet, outlet) = (format!("3.2*{a}"), "0".into());
    let shear = |sign: &str| format!("{sign}0.4*(1-2*y)*{a}");
    common::channel([4, 2], [inlet, shear("-")], [outlet, shear("")], forces, more)
}

/// Mean velocity, and forces on the inlet and the walls.
fn flow(simulation: &mut Simulation) -> [f64; 3] {
    let mut row = simulation.step().unwrap();
    while !simulation.finished() {
        row = simulation.step().unwrap();
    }
    [simulation.fields().integrate(|at| at.velocity[0]) / 4.0, row["inlet"], row["walls"]]
}

fn close(found: [f64; 3], expected: [f64; 3], what: &str) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9 * expected.abs(), "{what}: {found} for {expected}");
    }
}

#[test]
fn tractions_drive_a_channel() {
    let elements: [&[&str]; 4] = [
        &[],
        &["space.velocity=Q3", "space.pressure=P2dc"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["space.velocity=P2-bubble", "space.pressure=P1dc"],
    ];
    for elements in elements {
        let mut simulation = Simulation::new(channel("1", elements), 1).unwrap();
        close(flow(&mut simulation), [2.0 / 3.0, -3.2, 3.2], &format!("{elements:?}"));
        let p = simulation.fields().at([1.0, 0.5]).unwrap().pressure;
        assert!((p - 2.4).abs() < 1e-9, "{elements:?}: {p}");
    }
}

/// A flow that grows like t with the body force that it needs is exact in every scheme; forces are those at the middle of
/// the last step where the scheme has them there.
#[test]
fn tractions_follow_time_in_every_scheme() {
    for scheme in SCHEMES {
        let more = [
            scheme,
            "time.step=0.1",
            "time.end=0.5",
            "fluid.body-force=[\"4*y*(1-y)\",0]",
            "newton.linearization=newton",
        ];
        let mut simulation = Simulation::new(channel("t", &more), 1).unwrap();
        let found = flow(&mut simulation);
        let t = simulation.stepper.force_time();
        close(found, [0.5 * 2.0 / 3.0, -3.2 * t, 3.2 * t], scheme);
    }
}

/// u = (a x, b x) has constant stress, so that constant tractions P N on three sides hold it, whatever the size of the
/// strain: St. Venant-Kirchhoff, P = F (λ tr E I + 2 μ E).
#[test]
fn tractions_hold_a_large_homogeneous_strain() {
    let (a, b, mu, lambda) = (0.2, 0.3, 3.0, 4.0);
    let f = [[1.0 + a, 0.0], [b, 1.0]];
    let product = |x: [[f64; 2]; 2], y: [[f64; 2]; 2]| -> [[f64; 2]; 2] {
        std::array::from_fn(|i| std::array::from_fn(|j| x[i][0] * y[0][j] + x[i][1] * y[1][j]))
    };
    let square = product([[f[0][0], f[1][0]], [f[0][1], f[1][1]]], f);
    let e: [[f64; 2]; 2] =
        std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (square[i][j] - f64::from(i == j))));
    let trace = e[0][0] + e[1][1];
    let stress = std::array::from_fn(|i| {
        std::array::from_fn(|j| lambda * trace * f64::from(i == j) + 2.0 * mu * e[i][j])
    });
    let p = product(f, stress);
    let text = format!(
        r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 1]
cells = [2, 2]
region = {{ solid = "1" }}
[solid]
density = 1
mu = {mu}
lambda = {lambda}
[boundary.left]
condition = "clamped"
[boundary.right]
condition = "traction"
traction = [{}, {}]
[boundary.top]
condition = "traction"
traction = [{}, {}]
[boundary.bottom]
condition = "traction"
traction = [{}, {}]
[newton]
tolerance = 1e-12
"#,
        p[0][0], p[1][0], p[0][1], p[1][1], -p[0][1], -p[1][1]
    );
    for linearization in ["newton", "condensed"] {
        // Stationary solutions have the whole Jacobian; in time the body comes to rest with large steps.
        let more: &[&str] = if linearization == "newton" {
            &[]
        } else {
            &["time.scheme=backward-euler", "time.step=1000", "time.end=20000"]
        };
        let mut more = more.to_vec();
        let set = format!("newton.linearization={linearization}");
        more.push(&set);
        let case = Case::from_toml(&text, "body.toml", &sets(&more)).unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        simulation.step().unwrap();
        while !simulation.finished() {
            simulation.step().unwrap();
        }
        for (x, u) in simulation.fields().coordinates().iter().zip(simulation.fields().displacement()) {
            let gap = (u[0] - a * x[0]).abs().max((u[1] - b * x[0]).abs());
            assert!(gap < 1e-9, "{linearization}: {u:?} at {x:?}");
        }
    }
}

#[test]
fn tractions_are_read_like_velocities() {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [1,1]\n[fluid]\ndensity = 1\n\
                kinematic-viscosity = 1\n[boundary.left]\ncondition = \"traction\"\n";
    let message = wrong(text, &[]);
    assert!(message.contains("boundary.left.traction") && message.contains("two expressions"), "{message}");
    let message = wrong(text, &["boundary.left.traction=[1]"]);
    assert!(message.contains("two expressions"), "{message}");
    let message = wrong(text, &["boundary.left.traction=[\"1/0\",0]"]);
    assert!(message.contains("boundary.left.traction") && message.contains("finite"), "{message}");
    let case = channel("1", &["boundary.left.velocity=[0,0]"]);
    assert!(
        case.notes().iter().any(|note| note.contains("boundary.left.velocity has no effect")),
        "{:?}",
        case.notes()
    );
    // Infinite at a place, and at a time.
    let case = channel("1", &["boundary.left.traction=[\"1/(y-0.5)\",0]"]);
    let message = Simulation::new(case, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("boundary.left.traction") && message.contains("finite"), "{message}");
    let again = Case::from_toml(&channel("1", &[]).to_toml(), "again.toml", &[]).unwrap();
    assert_eq!(again.boundary, channel("1", &[]).boundary);
}

/// Where a load would be left out, or taken at one time alone, it is refused.
#[test]
fn comparisons_that_have_no_loads_refuse_them() {
    let message =
        errors(&channel("1", &["mesh.upper=[1,1]"])).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("boundary.left.condition"), "{message}");
    let body = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [2,2]\nregion = { solid = \"1\" }\n\
                [solid]\ndensity = 1\nmu = 3\nlambda = 4\n[boundary.left]\ncondition = \"clamped\"\n[boundary.right]\n\
                condition = \"traction\"\ntraction = [0, \"1e-3*t\"]\n[boundary.top]\ncondition = \"traction-free\"\n\
                [boundary.bottom]\ncondition = \"traction-free\"\n[time]\nstep = 0.1\nend = 0.5\n";
    let case = |more: &[&str]| Case::from_toml(body, "body.toml", &sets(more)).unwrap();
    let message = newmark(&case(&[]), 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("constant traction"), "{message}");
    let beside = newmark(&case(&["boundary.right.traction=[0,1e-3]"]), 1).unwrap();
    assert!(beside.difference < 1e-6, "{}", beside.difference);
}
