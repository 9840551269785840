//! Boundaries whose displacement is given: solids that are pulled, walls of the fluid that move.

use crate::common::{SCHEMES, sets, wrong};
use undula::CaseBuilder;
use undula::case::Case;
use undula::simulation::Simulation;
use undula::verification::jacobians;

fn finish(simulation: &mut Simulation) {
    simulation.step().unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
}

fn square() -> CaseBuilder {
    CaseBuilder::new("square")
        .set("mesh.generator", "box")
        .set("mesh.lower", [0.0, 0.0])
        .set("mesh.upper", [1.0, 1.0])
        .set("mesh.cells", [3, 3])
        .set("newton.tolerance", 1e-12)
}

/// A solid whose whole boundary follows u = t A x has this u and v = A x inside, in every scheme.
#[test]
fn a_body_follows_its_boundary() {
    for scheme in SCHEMES {
        let mut case = square()
            .set("mesh.region.solid", "1")
            .set("solid.density", 1e-10)
            .set("solid.law", "neo-hookean")
            .set("solid.mu", 3.0)
            .set("solid.lambda", 4.0)
            .set("time.step", 0.1)
            .set("time.end", 0.5)
            .set("time.scheme", scheme.split('=').nth(1).unwrap());
        for side in ["left", "right", "top", "bottom"] {
            case = case
                .set(&format!("boundary.{side}.condition"), "displacement")
                .set(&format!("boundary.{side}.displacement"), ["t*(0.4*x + 0.2*y)", "-0.3*t*y"]);
        }
        let mut simulation = Simulation::new(case.build().unwrap(), 1).unwrap();
        finish(&mut simulation);
        let fields = simulation.fields();
        for ((x, u), v) in fields.coordinates().iter().zip(fields.displacement()).zip(fields.velocity()) {
            let rate = [0.4 * x[0] + 0.2 * x[1], -0.3 * x[1]];
            let on_side = x.iter().any(|x| *x == 0.0 || *x == 1.0);
            for i in 0..2 {
                assert!((u[i] - 0.5 * rate[i]).abs() < 1e-7, "{scheme}: {u:?} at {x:?}");
                assert!(!on_side || (v[i] - rate[i]).abs() < 1e-12, "{scheme}: {v:?} at {x:?}");
            }
        }
    }
}

/// A roller: a component is given, the other one free. The same state as under the traction that belongs to it.
#[test]
fn a_component_may_be_free() {
    let body = |end: (&str, [&str; 2])| {
        let case = square()
            .set("mesh.region.solid", "1")
            .set("solid.density", 1.0)
            .set("solid.law", "neo-hookean")
            .set("solid.mu", 3.0)
            .set("solid.lambda", 4.0)
            .set("boundary.left.condition", "symmetry")
            .set("boundary.bottom.condition", "displacement")
            .set("boundary.bottom.displacement", ["free", "0"])
            .set("boundary.top.condition", "traction-free")
            .set("boundary.right.condition", end.0)
            .set(&format!("boundary.right.{}", end.0), end.1)
            .build()
            .unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        simulation.step().unwrap();
        simulation.fields().at([1.0, 1.0]).unwrap().displacement
    };
    let drawn = body(("displacement", ["0.3", "free"]));
    assert_eq!(drawn[0], 0.3);
    let grad = |b: f64| undula::math::Tensor([[0.3, 0.0], [0.0, b]]);
    let law = undula::physics::SolidLaw::NeoHookean.material(3.0, 4.0, 0.0);
    let stress = law.stress::<2>(&grad(drawn[1]));
    assert!(stress.0[1][1].abs() < 1e-8, "{stress:?}");
    let pulled = body(("traction", [&stress.0[0][0].to_string(), "0"]));
    assert!((pulled[0] - 0.3).abs() < 1e-8 && (pulled[1] - drawn[1]).abs() < 1e-8, "{pulled:?}, {drawn:?}");
}

/// A piston in a channel without friction: v = g'(t), p = ρ g''(t) (L − x − u).
fn piston(g: &str, more: &[(&str, &str)]) -> Case {
    let case = CaseBuilder::new("piston")
        .set("mesh.generator", "box")
        .set("mesh.lower", [0.0, 0.0])
        .set("mesh.upper", [2.0, 0.5])
        .set("mesh.cells", [8, 2])
        .set("fluid.density", 3.0)
        .set("fluid.kinematic-viscosity", 0.1)
        .set("boundary.left.condition", "displacement")
        .set("boundary.left.displacement", [g, "0"])
        .set("boundary.top.condition", "slip")
        .set("boundary.bottom.condition", "slip")
        .set("boundary.right.condition", "do-nothing")
        .set("time.step", 0.1)
        .set("time.end", 1.0)
        .set("newton.tolerance", 1e-12);
    more.iter()
        .fold(case, |case, (key, value)| match value.parse::<f64>() {
            Ok(number) if number.fract() != 0.0 => case.set(key, number),
            Ok(number) => case.set(key, number as u32),
            Err(_) => case.set(key, *value),
        })
        .build()
        .unwrap()
}

#[test]
fn a_piston_displaces_what_it_sweeps() {
    for scheme in SCHEMES {
        let scheme = scheme.split('=').nth(1).unwrap();
        for model in ["pseudo-elastic", "harmonic", "jacobian-stiffened"] {
            let case = piston("0.7*t", &[("time.scheme", scheme), ("motion.model", model)]);
            let mut simulation = Simulation::new(case, 1).unwrap();
            finish(&mut simulation);
            for v in simulation.fields().velocity() {
                let gap = (v[0] - 0.7).abs().max(v[1].abs());
                assert!(gap < 1e-8, "{scheme}, {model}: {v:?}");
            }
            let balance = simulation.balance.as_ref().unwrap();
            let (mass, swept) = (balance.mass(), balance.swept());
            assert!(mass.unwrap() < 1e-9 && swept.unwrap() < 1e-9, "{scheme}, {model}: {mass:?}, {swept:?}");
        }
    }
}

/// What flows out, summed by the trapezoidal rule, is what the piston has swept, to second order in the step.
#[test]
fn a_piston_that_accelerates_sweeps_with_second_order() {
    let gap = |steps: u32| {
        let step = 1.0 / f64::from(steps);
        let case = piston("0.3*(1 - cos(2*t))", &[("time.step", &step.to_string())]);
        let mut simulation = Simulation::new(case, 1).unwrap();
        let (mut sum, mut before) = (0.0, 0.0);
        while !simulation.finished() {
            simulation.step().unwrap();
            let now = simulation.fields().at([2.0, 0.25]).unwrap().velocity[0];
            sum += 0.5 * step * (before + now);
            before = now;
        }
        let speed = 0.6 * 2.0f64.sin();
        for v in simulation.fields().velocity() {
            assert!((v[0] - speed).abs().max(v[1].abs()) < 1e-8, "{v:?} for {speed}");
        }
        (sum - 0.3 * (1.0 - 2.0f64.cos())).abs()
    };
    let (coarse, fine) = (gap(10), gap(20));
    assert!((coarse / fine).log2() > 1.95, "{coarse:e}, {fine:e}");
}

/// The mesh follows a wall that moves by more than a cell in a step.
#[test]
fn a_fast_wall_does_not_fold_its_neighbours() {
    let more = [("time.step", "0.25"), ("time.max-halvings", "0"), ("mesh.refine", "1")];
    let mut simulation = Simulation::new(piston("0.3*(1 - cos(2*t))", &more), 1).unwrap();
    finish(&mut simulation);
    let speed = 0.6 * 2.0f64.sin();
    assert!(simulation.fields().velocity().iter().all(|v| (v[0] - speed).abs() < 1e-8));
}

/// A box that moves as a whole is a box at rest in an accelerated frame: the force on its walls is ρ g'' |Ω|.
#[test]
fn a_box_that_is_shaken_holds_its_fluid() {
    let mut case = square().set("fluid.density", 3.0).set("fluid.kinematic-viscosity", 0.1);
    for side in ["left", "right", "top", "bottom"] {
        case = case
            .set(&format!("boundary.{side}.condition"), "displacement")
            .set(&format!("boundary.{side}.displacement"), ["0.4*t^2", "0"]);
    }
    let case = case
        .set("functional.force.kind", "force")
        .set("functional.force.on", ["left", "right", "top", "bottom"])
        .set("functional.force.component", "x")
        .set("time.step", 0.1)
        .set("time.end", 1.0)
        .build()
        .unwrap();
    let mut simulation = Simulation::new(case, 1).unwrap();
    let mut row = simulation.step().unwrap();
    while !simulation.finished() {
        row = simulation.step().unwrap();
    }
    assert!((row["force"] + 3.0 * 0.8).abs() < 1e-6, "{}", row["force"]);
    assert!(simulation.fields().velocity().iter().all(|v| (v[0] - 0.8).abs().max(v[1].abs()) < 1e-7));
}

#[test]
fn jacobians_beside_a_moving_wall_agree() {
    let mut simulation = Simulation::new(piston("0.05*t", &[]), 1).unwrap();
    let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 5 }).unwrap();
    assert!(report.agrees(), "{report}");
}

#[test]
fn displacements_are_checked() {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [1,1]\n[fluid]\ndensity = 1\n\
                kinematic-viscosity = 1\n[boundary.left]\ncondition = \"displacement\"\n";
    let message = wrong(text, &[]);
    assert!(message.contains("boundary.left.displacement: missing"), "{message}");
    let message = wrong(text, &["boundary.left.displacement=[\"free\", \"free\"]"]);
    assert!(message.contains("one component at least that is not free"), "{message}");
    let message = wrong(text, &["boundary.left.displacement=[\"fre\", 0]"]);
    assert!(message.contains("boundary.left.displacement"), "{message}");
    let message = wrong(text, &["boundary.left.displacement=[\"t\", 0]"]);
    assert!(message.contains("time.end"), "{message}");
    let moved = piston("0.1*cos(t)", &[]);
    let message = Simulation::new(moved, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(
        message.contains("boundary.left.displacement") && message.contains("0 at the start"),
        "{message}"
    );
    let case = piston("0.7*t", &[]);
    let again = Case::from_toml(&case.to_toml(), "again.toml", &sets(&[])).unwrap();
    assert_eq!(again.boundary, case.boundary);
}
