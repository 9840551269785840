//! Case files: what loads, what is refused and in which words, and the way back to TOML.

use undula::problem::builtin::builtin_cases;
use undula::problem::case::*;
use undula::problem::expression::Expression;
use undula::problem::fit::MeshNames;

fn sets(overrides: &[&str]) -> Vec<String> {
    overrides.iter().map(|s| s.to_string()).collect()
}

fn builtin(name: &str, overrides: &[&str]) -> Case {
    match Case::builtin(name, &sets(overrides)) {
        Ok(case) => case,
        Err(e) => panic!("{name} {overrides:?}:\n{e}"),
    }
}

/// The messages for `text`, one per line.
fn wrong(text: &str, overrides: &[&str]) -> String {
    match Case::from_toml(text, "own.toml", &sets(overrides)) {
        Ok(_) => panic!("should be refused:\n{text}\n{overrides:?}"),
        Err(e) => e.to_string(),
    }
}

fn wrong_builtin(name: &str, overrides: &[&str]) -> String {
    match Case::builtin(name, &sets(overrides)) {
        Ok(_) => panic!("should be refused: {name} {overrides:?}"),
        Err(e) => e.to_string(),
    }
}

const FLUID: &str =
    "[mesh]\ngenerator = \"schaefer-turek\"\n[fluid]\ndensity = 1\nkinematic-viscosity = 1e-3\n";

/// Names of the built-in channel with beam.
fn turek_hron() -> MeshNames {
    let one = |name: &str, region: &str| (name.to_string(), vec![region.to_string()]);
    MeshNames {
        regions: sets(&["fluid", "solid"]),
        boundaries: vec![
            one("inflow", "fluid"),
            one("outflow", "fluid"),
            one("walls", "fluid"),
            one("cylinder", "fluid"),
            one("clamp", "solid"),
            one("interface", "fluid"),
        ],
    }
}

#[test]
fn every_builtin_case_loads_and_survives_the_way_back() {
    assert_eq!(builtin_cases().len(), 12);
    for shipped in builtin_cases() {
        let case = builtin(shipped.name, &[]);
        assert_eq!(case.name, shipped.name);
        assert!(!case.title.is_empty());
        assert_eq!(case.notes(), &[] as &[String], "{}", shipped.name);
        let again = Case::from_toml(&case.to_toml(), "case.toml", &[]);
        assert_eq!(again.as_ref(), Ok(&case), "{}\n{}", shipped.name, case.to_toml());
    }
}

#[test]
fn builtin_cases_fit_their_mesh() {
    let without_clamp = MeshNames {
        regions: sets(&["fluid"]),
        boundaries: turek_hron()
            .boundaries
            .into_iter()
            .filter(|(n, _)| n != "clamp" && n != "interface")
            .collect(),
    };
    for shipped in builtin_cases() {
        let case = builtin(shipped.name, &[]);
        let names = if shipped.name.starts_with("dfg") { without_clamp.clone() } else { turek_hron() };
        assert_eq!(case.check_mesh(&names), Ok(()), "{}", shipped.name);
    }
}

#[test]
fn fsi3_is_the_published_problem() {
    let case = builtin("fsi3", &[]);
    let (fluid, solid) = (case.fluid.clone().unwrap(), case.solid.clone().unwrap());
    assert_eq!((fluid.density, fluid.kinematic_viscosity), (1000.0, 1e-3));
    assert_eq!((solid.density, solid.mu, solid.lambda), (1000.0, 2e6, 8e6));
    let Some(Condition::Velocity([vx, vy])) = case.boundary.get("inflow") else { panic!() };
    assert!((vx.eval(&[0.0, 0.205, 0.0], 10.0) - 3.0).abs() < 1e-14);
    assert!((vx.eval(&[0.0, 0.205, 0.0], 1.0) - 1.5).abs() < 1e-14);
    assert_eq!(vy, &Expression::constant(0.0));
    let time = case.time.clone().unwrap();
    assert_eq!(time.scheme, TimeScheme::ShiftedCrankNicolson { shift: 1.0 });
    assert_eq!((time.step, time.end), (Expression::constant(0.005), 10.0));
    assert!((case.theta().unwrap() - 0.505).abs() < 1e-15);
    let names: Vec<&str> = case.functional.iter().map(|(n, _)| n.as_str()).collect();
    assert_eq!(names, ["drag", "lift", "ux_A", "uy_A"]);
    assert_eq!(case.mesh.refine, 1);
    assert_eq!(case.output.leading.as_deref(), Some("uy_A"));
}

#[test]
fn defaults() {
    let case = Case::from_toml(FLUID, "own.toml", &[]).unwrap();
    assert_eq!(case.name, "own");
    assert_eq!(case.newton.rate_max, 0.2);
    assert_eq!(case.newton.tolerance, 1e-8);
    assert_eq!(case.newton.max_steps, 30);
    assert!(case.newton.extrapolate);
    assert_eq!(case.newton.jacobian, JacobianKind::Automatic);
    assert_eq!(
        case.motion,
        MotionSpec { model: MotionModel::PseudoElastic, poisson: 0.0, offset: 0.01, exponent: 2.0 }
    );
    assert_eq!(case.space.pressure, PressureElement::P1dc);
    assert_eq!(case.space.quadrature, 3);
    assert!(case.output.deformed && case.time.is_none() && case.solid.is_none());
}

#[test]
fn overrides_reach_every_key() {
    let case = builtin(
        "fsi3",
        &[
            "time.step=0.01",
            "time.step = 0.02",
            "mesh.refine=2",
            "fluid.kinematic-viscosity=1e-2",
            "functional.drag.component=y",
            "functional.energy={ kind = \"energy\", term = \"elastic\" }",
            "boundary.inflow.velocity=[\"y*(0.41-y)\", 0]",
            "solid.body-force=[0, \"-2*ramp(t, 1)\"]",
            "time.scheme=crank-nicolson",
            "motion.model=harmonic",
            "newton.jacobian=analytic",
            "output.leading=lift",
            "title=a title with = and blanks",
        ],
    );
    let time = case.time.unwrap();
    assert_eq!((time.step, time.scheme), (Expression::constant(0.02), TimeScheme::CrankNicolson));
    assert_eq!(case.mesh.refine, 2);
    assert_eq!(case.fluid.unwrap().kinematic_viscosity, 0.01);
    assert!(matches!(case.functional[0].1, FunctionalSpec::Force { component: 1, .. }));
    assert_eq!(case.functional[4].1, FunctionalSpec::Energy(EnergyKind::Elastic));
    assert_eq!(case.motion.model, MotionModel::Harmonic);
    assert_eq!(case.newton.jacobian, JacobianKind::Analytic);
    assert_eq!(case.title, "a title with = and blanks");
    assert_eq!(case.record.notes, ["time.shift has no effect: the scheme is another one"]);
}

#[test]
fn stationary_and_back() {
    let still = builtin("fsi3", &["time.scheme=stationary"]);
    assert!(still.time.is_none());
    assert_eq!(still.at_time, 10.0);
    let moving = builtin("fsi1", &["time.scheme=backward-euler", "time.step=0.1", "time.end=20"]);
    assert_eq!(moving.time.unwrap().scheme, TimeScheme::BackwardEuler);
    assert_eq!(
        wrong_builtin("fsi1", &["time.scheme=crank-nicolson"]),
        "--set time.scheme=crank-nicolson: time.step: missing: the time step [s]; for a stationary case set time.scheme = \"stationary\"\n\
         --set time.scheme=crank-nicolson: time.end: missing: the last time [s]; for a stationary case set time.scheme = \"stationary\""
    );
    assert_eq!(
        wrong_builtin("fsi3", &["time=none"]),
        "fsi3.toml:23:12: boundary.inflow.velocity = [\"1.5*2.0*y*(0.41-y)/(0.41/2)^2*ramp(t,2)\", 0]: \
         depends on t, but the case is stationary: give time.end, the time [s] at which it is taken"
    );
}

#[test]
fn a_body_left_out_takes_its_boundaries_and_functionals_along() {
    let case = builtin("fsi1", &["solid=none"]);
    assert!(case.solid.is_none());
    assert_eq!(case.functional.len(), 2);
    assert_eq!(case.notes()[0], "functional.ux_A is left out: there is no [solid]");
    assert_eq!(case.check_mesh(&turek_hron()), Ok(()));
    let case = builtin("fsi1", &["fluid=none"]);
    assert_eq!(case.functional.len(), 2);
    assert_eq!(case.check_mesh(&turek_hron()), Ok(()));
    let own = Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap();
    assert_eq!(own, case);
}

#[test]
fn young_and_poisson_are_moduli_too() {
    let text = "[mesh]\ngenerator = \"turek-hron\"\n[solid]\ndensity = 1000\nyoung = 1.4e6\npoisson = 0.4\n";
    let solid = Case::from_toml(text, "own.toml", &[]).unwrap().solid.unwrap();
    assert!((solid.mu - 0.5e6).abs() < 1e-6 && (solid.lambda - 2e6).abs() < 1e-5);
}
