//! Prescribed pressure on a boundary, against closed forms.

use crate::common::{SCHEMES, channel_between, sets, wrong};
use undula::case::Case;
use undula::math::Vector;
use undula::operators::pressure::pressure;
use undula::operators::{DataTime, End, Operator, StepView};
use undula::physics::SolidLaw;
use undula::physics::StepRule;
use undula::simulation::Simulation;
use undula::space::Region;
use undula::verification::jacobians;

/// Poiseuille's flow between two plates with ρ = 1, ν = 0.1, L = 4 m, H = 1 m: Q = Δp H³/(12 μ L) = 2/3 m²/s for 3.2 Pa.
fn channel(a: &str, more: &[&str]) -> Case {
    let left = format!("condition = \"pressure\"\npressure = \"3.2*{a} + 7\"");
    let forces = "[functional.inlet]\nkind = \"force\"\non = [\"left\"]\ncomponent = \"x\"\n\
                  [functional.walls]\nkind = \"force\"\non = [\"top\", \"bottom\"]\ncomponent = \"x\"\n";
    channel_between([4, 2], [&left, "condition = \"pressure\"\npressure = 7"], forces, more)
}

fn finish(simulation: &mut Simulation) {
    simulation.step().unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
}

#[test]
fn poiseuille_between_two_pressures_is_exact() {
    let elements: [&[&str]; 4] = [
        &[],
        &["space.velocity=Q3", "space.pressure=P2dc"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["boundary.left.at=reference", "boundary.right.at=reference"],
    ];
    for more in elements {
        let mut simulation = Simulation::new(channel("1", more), 1).unwrap();
        let row = simulation.step().unwrap();
        let fields = simulation.fields();
        for (x, v) in fields.coordinates().iter().zip(fields.velocity()) {
            let gap = (v[0] - 4.0 * x[1] * (1.0 - x[1])).abs().max(v[1].abs());
            assert!(gap < 1e-10, "{more:?}: {v:?} at {x:?}");
        }
        let p = fields.at([1.0, 0.3]).unwrap().pressure;
        assert!((p - 9.4).abs() < 1e-9, "{more:?}: {p}");
        // The force on the walls is that of the pressure drop; the pressure at the inlet pushes with 10.2 N/m.
        assert!((row["walls"] - 3.2).abs() < 1e-9, "{}", row["walls"]);
        assert!((row["inlet"] + 10.2).abs() < 1e-9, "{}", row["inlet"]);
    }
}

/// A flow that grows like t with the body force that it needs is exact in every scheme.
#[test]
fn pressures_follow_time_in_every_scheme() {
    for scheme in SCHEMES {
        let more = [scheme, "time.step=0.1", "time.end=0.5", "fluid.body-force=[\"4*y*(1-y)\",0]"];
        let mut simulation = Simulation::new(channel("t", &more), 1).unwrap();
        finish(&mut simulation);
        let mean = simulation.fields().integrate(|at| at.velocity[0]) / 4.0;
        assert!((mean - 1.0 / 3.0).abs() < 1e-9, "{scheme}: {mean}");
    }
}

/// Womersley's flow between two plates under p = 3.2 cos(ω t): mode n of sin(nπy) follows ȧ = g(t) − λ a with
/// λ = ν n² π², and has 8/(n² π²) of the mean velocity. At t = 2 s the start is forgotten up to e⁻²⁰.
#[test]
fn womersley_flow_has_the_order_of_the_scheme() {
    let (omega, nu, t): (f64, f64, f64) = (7.0, 1.0, 2.0);
    let mode = |n: f64, t: f64| {
        let lambda = nu * (n * std::f64::consts::PI).powi(2);
        let a =
            0.8 * (lambda * (omega * t).cos() + omega * (omega * t).sin()) / (lambda.powi(2) + omega.powi(2));
        8.0 / (n * std::f64::consts::PI).powi(2) * a
    };
    let exact = |t: f64| (0..4000).map(|i| mode(f64::from(2 * i + 1), t)).sum::<f64>();
    for (scheme, order) in [("crank-nicolson", 2.0), ("bdf2", 2.0), ("backward-euler", 1.0)] {
        let error = |steps: usize| {
            let (scheme, step) = (format!("time.scheme={scheme}"), format!("time.step={}", t / steps as f64));
            let more = [
                "fluid.kinematic-viscosity=1",
                "space.velocity=Q4",
                "space.pressure=P3dc",
                "mesh.cells=[1,6]",
                "time.end=2",
                &scheme,
                &step,
            ];
            let mut simulation = Simulation::new(channel(&format!("cos({omega}*t)"), &more), 1).unwrap();
            // A quarter of a period is 0.22 s: amplitude and phase of the error.
            let mut sum = 0.0;
            while !simulation.finished() {
                let t = simulation.step().unwrap().time;
                if [1.75, 2.0].iter().any(|at| (t - at).abs() < 1e-9) {
                    let mean = simulation.fields().integrate(|at| at.velocity[0]) / 4.0;
                    sum += (mean - exact(t)).powi(2);
                }
            }
            sum.sqrt()
        };
        let (coarse, fine) = (error(160), error(320));
        let found = (coarse / fine).abs().log2();
        assert!((found - order).abs() < 0.1, "{scheme}: {coarse:e}, {fine:e}, order {found}");
        assert!(fine.abs() < if order == 2.0 { 3e-5 } else { 2e-3 }, "{scheme}: {fine:e}");
    }
}

/// u = (a x, 0) of a body between two plates of pressure p: P₂₂ = −p (1 + a) where the load follows the surface, which is
/// longer by 1 + a, else P₂₂ = −p. P₁₁ is the traction at its end.
#[test]
fn a_bar_of_every_law_between_pressures() {
    let (mu, lambda, c2, a) = (3.0, 4.0, 0.4, 0.3);
    let laws = [SolidLaw::StVenantKirchhoff, SolidLaw::Linear, SolidLaw::NeoHookean, SolidLaw::MooneyRivlin];
    for (law, follows, in_time) in
        laws.into_iter().flat_map(|law| [(law, true, false), (law, true, true), (law, false, false)])
    {
        let stress = law.material(mu, lambda, c2).stress::<2>(&undula::math::Tensor([[a, 0.0], [0.0, 0.0]]));
        let area = if follows { 1.0 + a } else { 1.0 };
        let (p, end) = (-stress.0[1][1] / area, stress.0[0][0]);
        let name = law.name();
        let c2 = if law.is_mooney_rivlin() { format!("c2 = {c2}") } else { String::new() };
        let at = if follows { "current" } else { "reference" };
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
law = "{name}"
mu = {mu}
lambda = {lambda}
{c2}
[boundary.left]
condition = "clamped"
[boundary.right]
condition = "traction"
traction = [{end}, 0]
[boundary.top]
condition = "pressure"
pressure = {p}
at = "{at}"
[boundary.bottom]
condition = "pressure"
pressure = {p}
at = "{at}"
[newton]
tolerance = 1e-12
"#
        );
        // In time the body comes to rest with large steps; the condensed matrix has kθ times the stiffness of the load.
        let more: &[&str] = if in_time {
            &[
                "time.scheme=backward-euler",
                "time.step=1000",
                "time.end=20000",
                "newton.linearization=condensed",
            ]
        } else {
            &[]
        };
        let case = Case::from_toml(&text, "bar.toml", &sets(more)).unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        finish(&mut simulation);
        for (x, u) in simulation.fields().coordinates().iter().zip(simulation.fields().displacement()) {
            let gap = (u[0] - a * x[0]).abs().max(u[1].abs());
            assert!(gap < 1e-9, "{name}, {at}, in time: {in_time}: {u:?} at {x:?}");
        }
    }
}

/// ∫ J F⁻ᵀ n over a curve is the perpendicular of its chord in the current domain, whatever the shape.
#[test]
fn the_load_is_that_of_the_chord() {
    let case = arch(&[]);
    let simulation = Simulation::new(case, 1).unwrap();
    let assembler = &simulation.stepper.assembler;
    let space = &assembler.space;
    let mut state = assembler.zero();
    for (u, x) in state.u.chunks_exact_mut(2).zip(&space.nodes.points) {
        u.copy_from_slice(&[0.3 * (2.0 * x[0] + x[1]).sin(), 0.4 * x[0] * x[0] - 0.2 * x[1]]);
    }
    let boundary = space.mesh.boundary("top").unwrap();
    let sides: Vec<_> =
        space.mesh.facets.iter().filter(|f| f.boundary == boundary).map(|f| f.side()).collect();
    let mut load = pressure(space, Region::Solid, boundary, (Box::new(|_, _| 2.0), true), 3);
    load.set_data(&DataTime { end: End::New, time: 0.0, load: 1.0 }).unwrap();
    let step = StepView { rule: StepRule::STATIONARY, new: &state, old: &state };
    let force: Vector<f64, 2> = load.force_through(&step, &sides);
    let corner = |x: [f64; 2]| {
        let node = space.nodes.points.iter().position(|p| *p == x).unwrap();
        [x[0] + state.u[2 * node], x[1] + state.u[2 * node + 1]]
    };
    let (a, b) = (corner([0.0, 0.1]), corner([1.0, 0.1]));
    // From left to right the outer normal is on the left: n ds = (−dy, dx).
    let expected = [-2.0 * (b[1] - a[1]), 2.0 * (b[0] - a[0])];
    for i in 0..2 {
        assert!((force.0[i] - expected[i]).abs() < 1e-13, "{force:?} for {expected:?}");
    }
}

/// A beam that a pressure rolls up.
fn arch(more: &[&str]) -> Case {
    let text = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 0.1]
cells = [8, 1]
region = { solid = "1" }
[solid]
density = 1
mu = 1e3
lambda = 1e3
[boundary.left]
condition = "clamped"
[boundary.right]
condition = "traction-free"
[boundary.top]
condition = "pressure"
pressure = 1.0
[boundary.bottom]
condition = "traction-free"
[newton]
tolerance = 1e-10
"#;
    Case::from_toml(text, "arch.toml", &sets(more)).unwrap()
}

/// With the derivative of the load Newton's method converges quadratically, and the solution is that of the other
/// linearisations. A load of 1 Pa lowers the tip by more than half of the length.
#[test]
fn newton_is_quadratic_under_a_load_that_follows() {
    let tip = |more: &[&str]| {
        let mut simulation = Simulation::new(arch(more), 1).unwrap();
        let mut row = simulation.step().unwrap();
        while !simulation.finished() {
            row = simulation.step().unwrap();
        }
        (simulation.fields().at([1.0, 0.05]).unwrap().displacement, row.newton_steps)
    };
    let (exact, steps) = tip(&["newton.linearization=newton", "newton.rate-max=0"]);
    assert!(exact[1] < -0.5, "{exact:?}");
    let (dead, _) = tip(&["boundary.top.at=reference"]);
    assert!((dead[0] - exact[0]).hypot(dead[1] - exact[1]) > 0.02, "{dead:?}, {exact:?}");
    assert!(steps < 30, "{steps}");
    let long = ["time.scheme=backward-euler", "time.step=1000", "time.end=30000"];
    let (condensed, _) = tip(&long);
    assert!((condensed[0] - exact[0]).hypot(condensed[1] - exact[1]) < 1e-6, "{condensed:?}, {exact:?}");
}

/// All Jacobians of fluid and solid with pressures on their outer boundaries.
#[test]
fn jacobians_have_the_stiffness_of_the_load() {
    let more = [
        "boundary.outflow.condition=pressure",
        "boundary.outflow.pressure=3e3*t",
        "mesh.refine=0",
        "time.scheme=crank-nicolson",
    ];
    let mut simulation = Simulation::new(crate::common::builtin("fsi3", &more), 1).unwrap();
    let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 1 }).unwrap();
    assert!(report.agrees(), "{report}");
    let mut simulation = Simulation::new(arch(&["time.step=0.1", "time.end=1"]), 1).unwrap();
    let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 2 }).unwrap();
    assert!(report.agrees(), "{report}");
}

#[test]
fn pressures_are_checked() {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [1,1]\n[fluid]\ndensity = 1\n\
                kinematic-viscosity = 1\n[boundary.left]\ncondition = \"pressure\"\n";
    let message = wrong(text, &[]);
    assert!(message.contains("boundary.left.pressure: missing: expression of x, y, t"), "{message}");
    let message = wrong(text, &["boundary.left.pressure=[1, 2]"]);
    assert!(message.contains("a number or an expression in quotes"), "{message}");
    let message = wrong(text, &["boundary.left.pressure=1", "boundary.left.at=now"]);
    assert!(message.contains("expected one of `current`, `reference`"), "{message}");
    let message = wrong(text, &["boundary.left.pressure=3*t"]);
    assert!(message.contains("boundary.left.pressure") && message.contains("time.end"), "{message}");
    let case = channel("1", &["boundary.top.pressure=1", "boundary.left.velocity=[0,0]"]);
    let notes = case.notes().join("\n");
    assert!(notes.contains("boundary.top.pressure has no effect: it is for `pressure`"), "{notes}");
    assert!(notes.contains("boundary.left.velocity has no effect: it is for `velocity`"), "{notes}");
    // Infinite at a place, and in the course of time.
    let case = channel("1", &["boundary.left.pressure=1/(y-0.5)"]);
    let message = Simulation::new(case, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("boundary.left.pressure") && message.contains("finite"), "{message}");
    let case = channel("1", &["boundary.left.pressure=1/(t-0.2)^2", "time.step=0.1", "time.end=10"]);
    let mut simulation = Simulation::new(case, 1).unwrap();
    simulation.step().unwrap();
    let message = simulation.step().err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("boundary.left.pressure") && message.contains("t = 0.2"), "{message}");
    let again = Case::from_toml(&channel("1", &[]).to_toml(), "again.toml", &[]).unwrap();
    assert_eq!(again.boundary, channel("1", &[]).boundary);
}
