//! Case files: what they mean, and the way back to TOML.

use crate::common::{FLUID, builtin, sets, turek_hron, wrong_builtin};
use undula::case::builtin::builtin_cases;
use undula::case::expression::Expression;
use undula::case::*;
use undula::mesh::generate::{cook, dfg_3d, fsi_box, hexahedra, rectangle, schaefer_turek, tube};
use undula::setup::names::MeshNames;
use undula::space::Walls;

#[test]
fn every_builtin_case_loads_and_survives_the_way_back() {
    assert_eq!(builtin_cases().len(), 25);
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
    let without_beam = MeshNames::of(&schaefer_turek(0));
    for shipped in builtin_cases() {
        let case = builtin(shipped.name, &[]);
        let names = match shipped.name {
            "rotor" | "flap" | "cavity" | "tube-2d" | "cylinder" | "pump" | "valve" => {
                MeshNames::of(&case.build_mesh().unwrap())
            }
            name if name.starts_with("dfg-2d") => without_beam.clone(),
            name if name.starts_with("dfg-3d") => MeshNames::of(&dfg_3d(0).extruded(0.41, 1).unwrap()),
            "cook" => MeshNames::of(&cook(0).extruded(1e-3, 1).unwrap()),
            "fsi-box" => MeshNames::of(&fsi_box(0, 1).unwrap()),
            "land" => {
                let mut mesh = hexahedra([0.0; 3], [1.0; 3], [1; 3], 0).unwrap();
                mesh.regions = vec!["solid".into()];
                MeshNames::of(&mesh)
            }
            "tube" => MeshNames::of(&tube([0.05, 0.005, 0.001], [20, 8, 1], 0).unwrap()),
            _ => turek_hron(),
        };
        assert_eq!(case.check_mesh(&names), Ok(()), "{}", shipped.name);
    }
}

#[test]
fn fsi3_is_the_published_problem() {
    let case = builtin("fsi3", &[]);
    let (fluid, solid) = (case.fluids[0].clone(), case.solids[0].clone());
    assert_eq!((fluid.density, fluid.kinematic_viscosity), (1000.0, 1e-3));
    assert_eq!((solid.density, solid.mu, solid.lambda), (1000.0, 2e6, 8e6));
    let Some(Condition::Velocity(vector)) = case.boundary.get("inflow") else { panic!() };
    let [vx, vy] = &vector[..] else { panic!() };
    assert!((vx.eval(&[0.0, 0.205, 0.0], 10.0) - 3.0).abs() < 1e-14);
    assert!((vx.eval(&[0.0, 0.205, 0.0], 1.0) - 1.5).abs() < 1e-14);
    assert_eq!(vy, &Expression::constant(0.0));
    let time = case.time.clone().unwrap();
    assert_eq!(time.scheme, Scheme::ShiftedCrankNicolson { shift: 2.0 });
    assert_eq!((time.step, time.end), (Expression::constant(0.005), 10.0));
    assert!((case.theta().unwrap() - 0.51).abs() < 1e-15);
    let names: Vec<&str> = case.functional.iter().map(|(n, _)| n.as_str()).collect();
    assert_eq!(names, ["drag", "lift", "ux_A", "uy_A"]);
    assert_eq!(case.mesh.refine, 1);
    assert_eq!(case.output.leading.as_deref(), Some("uy_A"));
}

#[test]
fn defaults() {
    let case = Case::from_toml(FLUID, "own.toml", &[]).unwrap();
    assert_eq!(case.name, "own");
    assert_eq!(case.newton.settings.rate_max, None);
    assert_eq!(case.newton.settings.tolerance, 1e-8);
    assert_eq!(case.newton.settings.max_steps, 30);
    assert!(case.newton.extrapolate);
    assert_eq!(case.newton.jacobian, Tangent::Automatic);
    assert_eq!(
        case.motion,
        MotionSpec {
            model: MotionModel::PseudoElastic,
            poisson: 0.0,
            offset: None,
            exponent: 2.0,
            scale: None,
            lagged: false,
            hinged: false,
            walls: Walls::Fixed,
        }
    );
    assert_eq!(case.space.pressure, PressureElement::Pdc(1));
    assert_eq!(case.space.quadrature, 3);
    assert!(case.output.deformed && case.time.is_none() && case.solids.is_empty());
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
            "motion.poisson=.3",
        ],
    );
    let time = case.time.unwrap();
    assert_eq!((time.step, time.scheme), (Expression::constant(0.02), Scheme::CrankNicolson));
    assert_eq!(case.mesh.refine, 2);
    assert_eq!(case.fluids[0].kinematic_viscosity, 0.01);
    assert!(matches!(case.functional[0].1, FunctionalSpec::Force { component: 1, .. }));
    assert_eq!(case.functional[4].1, FunctionalSpec::Energy(Integral::Elastic));
    assert_eq!((case.motion.model, case.motion.poisson), (MotionModel::Harmonic, 0.3));
    assert_eq!(case.newton.jacobian, Tangent::Analytic);
    assert_eq!(case.title, "a title with = and blanks");
    assert_eq!(case.record.notes, ["time.shift has no effect: the scheme is another one"]);
}

#[test]
fn stationary_and_back() {
    let still = builtin("fsi3", &["time.scheme=stationary"]);
    assert!(still.time.is_none());
    assert_eq!(still.at_time, 10.0);
    let moving = builtin("fsi1", &["time.scheme=backward-euler", "time.step=0.1", "time.end=20"]);
    assert_eq!(moving.time.unwrap().scheme, Scheme::BackwardEuler);
    assert_eq!(
        wrong_builtin("fsi1", &["time.scheme=crank-nicolson"]),
        "--set time.scheme=crank-nicolson: time.step: missing: the time step [s]; for a stationary case set time.scheme = \"stationary\"\n\
         --set time.scheme=crank-nicolson: time.end: missing: the last time [s]; for a stationary case set time.scheme = \"stationary\""
    );
    assert_eq!(
        wrong_builtin("fsi3", &["time=none"]),
        "fsi3.toml:27:12: boundary.inflow.velocity = [\"1.5*2.0*y*(0.41-y)/(0.41/2)^2*ramp(t,2)\", 0]: \
         depends on t, but the case is stationary: give time.end, the time [s] at which it is taken"
    );
}

#[test]
fn a_body_left_out_takes_its_boundaries_and_functionals_along() {
    let case = builtin("fsi1", &["solid=none"]);
    assert!(case.solids.is_empty());
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
    let solid = Case::from_toml(text, "own.toml", &[]).unwrap().solids.remove(0);
    assert!((solid.mu - 0.5e6).abs() < 1e-6 && (solid.lambda - 2e6).abs() < 1e-5);
}

#[test]
fn a_box_with_a_solid_survives_the_way_back() {
    let text = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [2, 1.5]
cells = [8, 6]
region = { solid = "0.1 - abs(x-1)" }
[fluid]
density = 1
kinematic-viscosity = 1e-30
body-force = [1e9, "2*pi"]
[solid]
density = 1
mu = 1
lambda = 0
[time]
scheme = "theta"
theta = 0.75
step = "if(t<1, 0.01, 0.1)"
start = -1
end = 3
[boundary.top]
condition = "traction-free"
[functional.e]
kind = "energy"
term = "dissipation"
[functional.r]
kind = "rotation"
[functional.f]
kind = "force"
on = "interface"
component = "x"
method = "surface-integral"
coefficient = [0.2, 0.1]
"#;
    let case = Case::from_toml(text, "folder/own case.toml", &[]).unwrap();
    assert_eq!(case.name, "own_case");
    assert_eq!(Case::from_toml(&case.to_toml(), "case.toml", &[]).as_ref(), Ok(&case), "{}", case.to_toml());
    assert_eq!(case.fluids[0].body_force[1].source(), "2*pi");
}

#[test]
fn a_mesh_file_is_looked_for_beside_the_case() {
    let text = FLUID.replace("generator = \"schaefer-turek\"", "file = \"meshes/own.msh\"");
    let case = Case::from_toml(&text, "/cases/own.toml", &[]).unwrap();
    assert_eq!(case.mesh.source, MeshSource::File("/cases/meshes/own.msh".into()));
    assert_eq!(Case::from_toml(&case.to_toml(), "/out/case.toml", &[]), Ok(case));
    let case = Case::from_toml(&text, "/cases/own.toml", &sets(&["mesh.file=/other.msh"])).unwrap();
    assert_eq!(case.mesh.source, MeshSource::File("/other.msh".into()));
}

#[test]
fn names_come_from_the_facets() {
    let mut mesh = rectangle([0.0; 2], [3.0, 2.0], [3, 2], 0).unwrap();
    mesh.assign_region("solid", |[x, y]| 1.0 - x.max(y)).unwrap();
    mesh.assign_region("rock", |[_, y]| y - 1.0).unwrap();
    mesh.mark_interface("fluid", "solid").unwrap();
    mesh.mark_sides("rock", &["fluid", "solid"]).unwrap();
    mesh.boundaries.push("unused".into());
    let names = MeshNames::of(&mesh);
    assert_eq!(names.regions, sets(&["fluid", "solid", "rock"]));
    for (name, regions) in [
        ("bottom", &["solid", "fluid"][..]),
        ("left", &["solid", "rock"]),
        ("interface", &["fluid"]),
        ("rock", &["fluid", "solid"]),
        ("unused", &[]),
    ] {
        let (_, found) = names.boundaries.iter().find(|(n, _)| n == name).unwrap();
        let (mut found, mut regions) = (found.clone(), sets(regions));
        found.sort();
        regions.sort();
        assert_eq!(found, regions, "{name}");
    }
    assert!(names.outer.iter().all(|(name, _)| name != "rock" && name != "interface"));
    let parts: Vec<(&str, &[usize])> =
        names.components.iter().map(|c| (c.region.as_str(), &c.touches[..])).collect();
    assert_eq!(parts, [("solid", &[1, 2][..]), ("fluid", &[0, 2]), ("rock", &[0, 1])]);
    assert_eq!(
        (&names.components[1].lower[..], &names.components[1].upper[..]),
        (&[1.0, 0.0][..], &[3.0, 1.0][..])
    );
}

#[test]
fn every_scheme_reads_back() {
    let mut cases: Vec<Vec<&str>> = crate::common::SCHEMES.iter().map(|scheme| vec![*scheme]).collect();
    for motion in ["secant", "midpoint", "galerkin"] {
        cases.push(vec![match motion {
            "secant" => "time.domain-motion=secant",
            "midpoint" => "time.domain-motion=midpoint",
            _ => "time.domain-motion=galerkin",
        }]);
    }
    cases.push(vec!["time.scheme=rannacher", "time.rannacher-steps=4", "time.rannacher-interval=0.5"]);
    cases.push(vec![
        "time.adaptive.tolerance=1e-4",
        "time.adaptive.max-step=0.02",
        "output.fields-interval=0.1",
    ]);
    for overrides in cases {
        let case = builtin("fsi3", &overrides);
        assert_eq!(Case::from_toml(&case.to_toml(), "case.toml", &[]), Ok(case), "{overrides:?}");
    }
}
