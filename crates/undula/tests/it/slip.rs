//! Boundaries that let pass nothing but the motion along them: planes of symmetry and walls without friction, straight,
//! inclined and curved.

use crate::common::sets;
use std::f64::consts::PI;
use undula::case::Case;
use undula::physics::SolidLaw;
use undula::simulation::Simulation;
use undula::verification::jacobians;
use undula::{CaseBuilder, Mesh};

/// The mesh of a box of `cells`, whose nodes are moved by `place`; a solid where `region` is not negative.
pub fn mesh(
    upper: [f64; 2],
    lower: [f64; 2],
    cells: [usize; 2],
    region: &str,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> Mesh<2> {
    let solid = "[solid]\ndensity = 1\nmu = 1\nlambda = 1\n";
    let fluid = "[fluid]\ndensity = 1\nkinematic-viscosity = 1\n";
    let (region, bodies) = match region {
        "1" => ("region = { solid = \"1\" }".to_string(), solid.to_string()),
        "-1" => (String::new(), fluid.to_string()),
        both => (format!("region = {{ solid = \"{both}\" }}"), [solid, fluid].concat()),
    };
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = {lower:?}\nupper = {upper:?}\ncells = {cells:?}\n{region}\n{bodies}"
    );
    let sides = ["left", "right", "bottom", "top"].map(|side| {
        format!("boundary.{side}.condition={}", if side == "right" { "traction-free" } else { "no-slip" })
    });
    let mut mesh = Case::from_toml(&text, "box.toml", &sides).unwrap().build_mesh().unwrap();
    for x in &mut mesh.nodes {
        *x = place(*x);
    }
    mesh
}

fn finish(simulation: &mut Simulation) {
    simulation.step().unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
}

/// v, u of all nodes by place.
fn nodes(case: Case) -> Vec<([f64; 2], [f64; 2], [f64; 2])> {
    let mut simulation = Simulation::new(case, 1).unwrap();
    finish(&mut simulation);
    let fields = simulation.fields();
    let both = fields.velocity().into_iter().zip(fields.displacement());
    fields.coordinates().iter().zip(both).map(|(x, (v, u))| (*x, v, u)).collect()
}

/// A beam on the axis of a channel that is symmetric to it, or its upper half, turned by an angle.
fn channel(half: bool, angle: f64, in_time: bool, more: &[(&str, &str)]) -> Case {
    let (s, c) = angle.sin_cos();
    let lower = if half { 0.0 } else { -1.0 };
    let turn = |x: [f64; 2]| [c * x[0] - s * x[1], s * x[0] + c * x[1]];
    let region = "min(min(x + 1, 1.5 - x), 0.25 - abs(y))";
    let mesh = mesh([3.0, 1.0], [0.0, lower], [6, if half { 4 } else { 8 }], region, turn);
    channel_on(mesh, half, angle, in_time, more)
}

/// The same on any mesh of it.
fn channel_on(mesh: Mesh<2>, half: bool, angle: f64, in_time: bool, more: &[(&str, &str)]) -> Case {
    let (s, c) = angle.sin_cos();
    // The height above the axis in the turned system, and the speed along it.
    let height = format!("abs({c}*y - {s}*x)");
    let speed = format!("if({height} > 0.25, ({height} - 0.25)*(1 - {height})*6, 0)");
    let inflow = [format!("{speed}*{c}"), format!("{speed}*{s}")];
    let case = CaseBuilder::new("channel")
        .mesh(mesh)
        .set("fluid.density", 1.0)
        .set("fluid.kinematic-viscosity", 0.05)
        .set("solid.density", 2.0)
        .set("solid.mu", 20.0)
        .set("solid.lambda", 40.0)
        .set("boundary.left.condition", "velocity")
        .set("boundary.left.velocity", inflow)
        .set("boundary.right.condition", "do-nothing")
        .set("boundary.top.condition", "no-slip")
        .set("boundary.bottom.condition", if half { "symmetry" } else { "no-slip" })
        // By default that comes from the extent of the domain.
        .set("motion.offset", 0.1)
        .set("newton.tolerance", 1e-12);
    let case = if in_time {
        case.set("time.step", 0.1).set("time.end", 0.5).set("linear.precision", "double")
    } else {
        case
    };
    more.iter().fold(case, |case, (key, value)| case.set(key, *value)).build().unwrap()
}

fn gap(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// Half of a symmetric problem has the solution of the whole one: fluid, solid, interface and extension, stationary by
/// Newton and in time by the condensed system, every motion of the mesh; also where the axis is inclined.
#[test]
fn half_and_whole_problem_are_equal() {
    let models: [&[(&str, &str)]; 4] = [
        &[],
        &[("motion.model", "harmonic")],
        &[("newton.linearization", "newton"), ("linear.solver", "faer")],
        &[("motion.model", "biharmonic")],
    ];
    for in_time in [false, true] {
        for more in models {
            let whole = nodes(channel(false, 0.0, in_time, more));
            let biharmonic = more.iter().any(|(_, value)| *value == "biharmonic");
            for angle in [0.0f64, 0.4].into_iter().filter(|angle| !biharmonic || *angle == 0.0) {
                let (s, c) = angle.sin_cos();
                let back = |x: [f64; 2]| [c * x[0] + s * x[1], c * x[1] - s * x[0]];
                let half = nodes(channel(true, angle, in_time, more));
                let (mut size, mut worst) = (0.0f64, 0.0f64);
                for (x, v, u) in half {
                    let twin =
                        whole.iter().find(|twin| gap(twin.0, back(x)) < 1e-9).expect("a node of the whole");
                    size = size.max(u[0].hypot(u[1]));
                    let here = gap(twin.1, back(v)).max(gap(twin.2, back(u)));
                    worst = worst.max(here);
                }
                assert!(size > 1e-3, "{size}");
                assert!(worst < 1e-9, "in time: {in_time}, {more:?}, angle {angle}: {worst:e}");
            }
        }
    }
}

/// The upper half in triangles, turned by an angle.
fn triangles(angle: f64) -> Mesh<2> {
    let (s, c) = angle.sin_cos();
    let back = |x: [f64; 2]| [c * x[0] + s * x[1], c * x[1] - s * x[0]];
    let at = |i: u32, j: u32| {
        let x = [0.5 * f64::from(i), 0.25 * f64::from(j)];
        [c * x[0] - s * x[1], s * x[0] + c * x[1]]
    };
    let points = (0..5).flat_map(|j| (0..7).map(move |i| at(i, j))).collect();
    let square = |i: u32, j: u32| {
        let n = |i: u32, j: u32| i + 7 * j;
        [[n(i, j), n(i + 1, j), n(i + 1, j + 1)], [n(i, j), n(i + 1, j + 1), n(i, j + 1)]]
    };
    let cells: Vec<[u32; 3]> = (0..4).flat_map(|j| (0..6).flat_map(move |i| square(i, j))).collect();
    let region = |x: [f64; 2]| if back(x)[0] < 1.5 && back(x)[1] < 0.25 { "solid" } else { "fluid" };
    let side = |x: [f64; 2]| match back(x) {
        [x, _] if x < 1e-9 => "left",
        [x, _] if x > 3.0 - 1e-9 => "right",
        [_, y] if y < 1e-9 => "bottom",
        _ => "top",
    };
    Mesh::from_cells(points, &cells, region, side).unwrap()
}

/// An inclined axis of symmetry is one parallel to x, on triangles, too: stationary and condensed.
#[test]
fn an_inclined_axis_is_an_axis_on_triangles() {
    let (s, c) = 0.4f64.sin_cos();
    let back = |x: [f64; 2]| [c * x[0] + s * x[1], c * x[1] - s * x[0]];
    let pair = [("space.velocity", "P2"), ("space.pressure", "P1")];
    for in_time in [false, true] {
        let straight = nodes(channel_on(triangles(0.0), true, 0.0, in_time, &pair));
        for (x, v, u) in nodes(channel_on(triangles(0.4), true, 0.4, in_time, &pair)) {
            let twin = straight.iter().find(|twin| gap(twin.0, back(x)) < 1e-9).expect("the same node");
            let worst = gap(twin.1, back(v)).max(gap(twin.2, back(u)));
            assert!(worst < 1e-9, "in time: {in_time}: {worst:e} at {x:?}");
        }
    }
}

/// The second unknown of the biharmonic extension is mirrored along axes only.
#[test]
fn biharmonic_extensions_refuse_inclined_mirrors() {
    let case = channel(true, 0.4, false, &[("motion.model", "biharmonic")]);
    let message = Simulation::new(case, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("motion.model") && message.contains("inclined or curved"), "{message}");
}

/// All Jacobians with directions that are no axes.
#[test]
fn jacobians_hold_inclined_directions() {
    let mut simulation = Simulation::new(channel(true, 0.4, true, &[]), 1).unwrap();
    let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 3 }).unwrap();
    assert!(report.agrees(), "{report}");
}

/// A fluid that turns like a rigid body, v = ω r, between walls without friction on two circles: nothing but the pressure
/// ½ ρ ω² r² acts on them. Curved walls with the normals of the elements keep the order of the space.
#[test]
fn curved_walls_let_a_rotation_pass() {
    let error = |n: usize| {
        let polar = |x: [f64; 2]| [x[0] * (0.5 * PI * x[1]).cos(), x[0] * (0.5 * PI * x[1]).sin()];
        let case = CaseBuilder::new("ring")
            .mesh(mesh([2.0, 1.0], [1.0, 0.0], [n, 2 * n], "-1", polar))
            .set("fluid.density", 1.0)
            .set("fluid.kinematic-viscosity", 0.1)
            .set("boundary.left.condition", "slip")
            .set("boundary.right.condition", "slip")
            .set("boundary.bottom.condition", "velocity")
            .set("boundary.bottom.velocity", ["-y", "x"])
            // σ n = −p n with n = −e₁.
            .set("boundary.top.condition", "traction")
            .set("boundary.top.traction", ["0.5*(x^2 + y^2)", "0"])
            .set("newton.tolerance", 1e-12)
            .build()
            .unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        finish(&mut simulation);
        let sum = simulation
            .fields()
            .integrate(|at| (at.velocity[0] + at.x[1]).powi(2) + (at.velocity[1] - at.x[0]).powi(2));
        sum.sqrt()
    };
    let errors = [error(2), error(4), error(8)];
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 2.4, "{errors:?}, order {order}");
    }
    assert!(errors[2] < 1e-4, "{errors:?}");
}

/// A quarter of a tube in plane strain under an inner pressure: `law`, μ and λ.
fn tube(n: usize, law: SolidLaw, [mu, lambda, p]: [f64; 3]) -> Case {
    let polar = |x: [f64; 2]| [x[0] * (0.5 * PI * x[1]).cos(), x[0] * (0.5 * PI * x[1]).sin()];
    let case = CaseBuilder::new("tube")
        .mesh(mesh([2.0, 1.0], [1.0, 0.0], [n, 2 * n], "1", polar))
        .set("solid.density", 1.0)
        .set("solid.law", law.name())
        .set("solid.mu", mu)
        .set("boundary.left.condition", "pressure")
        .set("boundary.left.pressure", p)
        .set("boundary.right.condition", "traction-free")
        .set("boundary.bottom.condition", "symmetry")
        .set("boundary.top.condition", "symmetry")
        .set("newton.tolerance", 1e-12);
    let case = if law.is_incompressible() { case } else { case.set("solid.lambda", lambda) };
    case.build().unwrap()
}

fn inner(case: Case) -> f64 {
    let mut simulation = Simulation::new(case, 1).unwrap();
    finish(&mut simulation);
    let at = |x: [f64; 2]| simulation.fields().at(x).unwrap().displacement;
    let (a, b) = (at([1.0, 0.0]), at([0.0, 1.0]));
    assert!(
        a[1].abs() < 1e-12 && b[0].abs() < 1e-12 && (a[0] - b[1]).abs() < 1e-9 * a[0].abs(),
        "{a:?} {b:?}"
    );
    a[0]
}

/// Lamé: u_r = C r + D/r with 2 (λ + μ) C = p a²/(b² − a²), 2 μ D = p a² b²/(b² − a²).
#[test]
fn a_thick_walled_tube_is_that_of_lame() {
    let (mu, lambda, p) = (3.0, 4.0, 0.1);
    let factor = p / 3.0;
    let exact = factor / (2.0 * (lambda + mu)) + factor * 4.0 / (2.0 * mu);
    let error = |n| (inner(tube(n, SolidLaw::Linear, [mu, lambda, 1e-6])) * 1e5 - exact).abs();
    let errors = [error(2), error(4), error(8)];
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1]).log2() > 3.5, "{errors:?}");
    }
    assert!(errors[2] < 1e-5 * exact, "{errors:?}, {exact}");
}

/// A tube that keeps its volume: r² = R² + c, and p = ∫ μ (λ² − 1/λ²) dr/r with λ = r/R; large strain.
#[test]
fn an_incompressible_tube_is_blown_up() {
    let (mu, c) = (3.0, 0.44f64);
    let n = 20_000;
    let (a, b) = ((1.0 + c).sqrt(), (4.0 + c).sqrt());
    let slope = |r: f64| {
        let square = r * r / (r * r - c);
        mu * (square - 1.0 / square) / r
    };
    let h = (b - a) / f64::from(n);
    let p: f64 = (0..n).map(|i| slope(a + (f64::from(i) + 0.5) * h) * h).sum();
    let error = |n| (inner(tube(n, SolidLaw::IncompressibleNeoHookean, [mu, 0.0, p])) - (a - 1.0)).abs();
    let errors = [error(4), error(8)];
    assert!((errors[0] / errors[1]).log2() > 3.0, "{errors:?}");
    assert!(errors[1] < 1e-5, "{errors:?}");
}

/// A bar of every law that is drawn between two planes of symmetry: F = diag(a, b), P₁₁ given, P₂₂ = 0.
#[test]
fn a_bar_of_every_law_is_drawn() {
    let (mu, lambda, c2, a) = (3.0, 4.0, 0.4, 1.3f64);
    let laws = [
        SolidLaw::StVenantKirchhoff,
        SolidLaw::Linear,
        SolidLaw::NeoHookean,
        SolidLaw::MooneyRivlin,
        SolidLaw::IncompressibleNeoHookean,
        SolidLaw::IncompressibleMooneyRivlin,
    ];
    for law in laws {
        let (b, end) = if law.is_incompressible() {
            // σ₁₁ − σ₂₂ = 2 (c₁ + c₂) (a² − 1/a²) in plane strain, and 2 (c₁ + c₂) = μ.
            (1.0 / a, mu * (a - a.powi(-3)))
        } else {
            let stress = |b: f64| {
                let grad = undula::math::Tensor([[a - 1.0, 0.0], [0.0, b - 1.0]]);
                law.material(mu, lambda, c2).stress::<2>(&grad)
            };
            let (mut low, mut high) = (0.5, 1.5);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if stress(middle).0[1][1] < 0.0 { low = middle } else { high = middle }
            }
            (low, stress(low).0[0][0])
        };
        let case = CaseBuilder::new("bar")
            .set("mesh.generator", "box")
            .set("mesh.lower", [0.0, 0.0])
            .set("mesh.upper", [1.0, 1.0])
            .set("mesh.cells", [2, 2])
            .set("mesh.region.solid", "1")
            .set("solid.density", 1.0)
            .set("solid.law", law.name())
            .set("solid.mu", mu)
            .set("boundary.left.condition", "symmetry")
            .set("boundary.bottom.condition", "symmetry")
            .set("boundary.right.condition", "traction")
            .set("boundary.right.traction", [end, 0.0])
            .set("boundary.top.condition", "traction-free")
            .set("newton.tolerance", 1e-12);
        let case = if law.is_incompressible() { case } else { case.set("solid.lambda", lambda) };
        let case = if law.is_mooney_rivlin() { case.set("solid.c2", c2) } else { case };
        for (x, _, u) in nodes(case.build().unwrap()) {
            let expected = [(a - 1.0) * x[0], (b - 1.0) * x[1]];
            assert!(gap(u, expected) < 1e-8, "{}: {u:?} for {expected:?} at {x:?}", law.name());
        }
    }
}

/// A plane of symmetry does not hold a body along it.
#[test]
fn bodies_that_slide_away_are_refused() {
    let body = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [2,2]\nregion = { solid = \"1\" }\n\
                [solid]\ndensity = 1\nmu = 3\nlambda = 4\n[boundary.left]\ncondition = \"symmetry\"\n[boundary.right]\n\
                condition = \"traction-free\"\n[boundary.top]\ncondition = \"traction\"\ntraction = [0, 1]\n\
                [boundary.bottom]\ncondition = \"traction-free\"\n";
    let case = |more: &[&str]| Case::from_toml(body, "body.toml", &sets(more)).unwrap();
    let message = Simulation::new(case(&[]), 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("nothing holds") && message.contains("(0, 1)"), "{message}");
    assert!(Simulation::new(case(&["boundary.bottom.condition=slip"]), 1).is_ok());
    let message = case(&[]).build_stepper(1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("nothing holds"), "{message}");
}
