//! The programs in `examples` do what they say, and the front of the library has its names.
#![allow(dead_code)]

use std::fs;
use std::path::Path;
use undula::{CaseBuilder, Deformation, Error, Mesh, Scalar, Simulation, StoredEnergy};

#[path = "../../examples/own_functional.rs"]
mod own_functional;
#[path = "../../examples/own_material.rs"]
mod own_material;
#[path = "../../examples/own_mesh.rs"]
mod own_mesh;
#[path = "../../examples/step_by_step.rs"]
mod step_by_step;
#[path = "../../examples/sweep.rs"]
mod sweep;

use own_material::Tissue;

const MU: f64 = 0.5e6;
const LAMBDA: f64 = 2e6;

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} is not {b}");
}

#[test]
fn a_loop_of_its_own_stops_at_an_event() {
    let found = step_by_step::fall(0.02, 0.02, 0).unwrap();
    assert!(found.tip <= -0.02 && found.tip > -0.03, "{}", found.tip);
    // Under g = 2 m/s² a free fall of 20 mm takes 0.14 s; the beam holds its tip back only little.
    assert!(found.time > 0.1 && found.time < 0.25, "{}", found.time);
    assert!(found.fastest > 0.1 && found.fastest < 0.4, "{}", found.fastest);
    near(found.lowest, found.tip, 0.05);
}

#[test]
fn an_own_functional_is_a_column() {
    let rows = own_functional::rows(4, 0).unwrap();
    assert_eq!(rows.len(), 4);
    for row in &rows {
        assert!(row["energy"] > 0.0 && row["speed_behind"] > 0.0);
        near(row["energy_own"], row["energy"], 1e-12);
        assert_eq!(row.names().last().unwrap(), "speed_behind");
    }
}

#[test]
#[should_panic(expected = "there is a functional `uy_A` already")]
fn two_functionals_cannot_have_one_name() {
    let case = CaseBuilder::load("csm1").unwrap().set("mesh.refine", 0).build().unwrap();
    Simulation::new(case, 1).unwrap().record("uy_A", "m", |_| 0.0);
}

#[test]
fn stress_and_tangent_of_an_own_material_are_differences() {
    for b in [0.0, 2.0] {
        let [stress, tangent] = own_material::deviations(Tissue { mu: MU, lambda: LAMBDA, b });
        assert!(stress < 1e-8 && tangent < 1e-8, "b = {b}: {stress:.1e}, {tangent:.1e}");
    }
}

#[test]
#[ignore = "long"]
fn a_built_in_law_written_again_gives_the_same_solution() {
    let neo = own_material::tip(None, 0).unwrap();
    near(own_material::tip(Some(Tissue { mu: MU, lambda: LAMBDA, b: 0.0 }), 0).unwrap(), neo, 1e-10);
    let stiffer = own_material::tip(Some(Tissue { mu: MU, lambda: LAMBDA, b: 20.0 }), 0).unwrap();
    assert!(stiffer < 0.999 * neo, "{stiffer} and {neo}");
}

/// With a fluid, in time, and whichever way the Jacobian is computed.
#[test]
fn an_own_law_is_differentiated_in_every_way() {
    let last = |own: bool, settings: &[(&str, &str)]| {
        let mut case = CaseBuilder::load("fsi3").unwrap().set("mesh.refine", 0).set("time.step", 0.02);
        for (key, value) in settings {
            case = case.set(key, *value);
        }
        case = case.set("newton.tolerance", 1e-12).set("time.start", 1.0).set("solid.law", "neo-hookean");
        if own {
            case = case.material(Tissue { mu: 2e6, lambda: 8e6, b: 0.0 });
        }
        let mut simulation = Simulation::new(case.build().unwrap(), 2).unwrap();
        (0..3).map(|_| simulation.step().unwrap()).last().unwrap()
    };
    let expected = last(false, &[]);
    for settings in [
        &[][..],
        &[("newton.jacobian", "analytic")],
        &[("newton.jacobian", "finite-difference")],
        &[("newton.linearization", "newton")],
    ] {
        let row = last(true, settings);
        for (name, value) in expected.names().iter().zip(&expected.values) {
            assert!(
                (row[name.as_str()] / value - 1.0).abs() < 1e-8,
                "{settings:?} {name}: {row:?}, {expected:?}"
            );
        }
    }
}

#[test]
fn laws_that_cannot_be_computed_with_are_refused() {
    struct Stressed;
    impl StoredEnergy for Stressed {
        fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
            at.I1_minus_3() * 0.5 + at.J_minus_1() * at.J_minus_1()
        }
    }
    let refused = |case: CaseBuilder| case.build().unwrap_err().to_string();
    let csm1 = || CaseBuilder::load("csm1").unwrap();
    let stressed = refused(csm1().material(Stressed));
    assert!(stressed.contains("solid.law") && stressed.contains("a stress of 1 Pa at rest"), "{stressed}");
    let unstable = refused(csm1().material(Tissue { mu: -1.0, lambda: 1.0, b: 0.0 }));
    assert!(unstable.contains("solid.law") && unstable.contains("mu = -1 Pa"), "{unstable}");
    let without =
        refused(CaseBuilder::load("cfd1").unwrap().material(Tissue { mu: 1.0, lambda: 1.0, b: 0.0 }));
    assert!(without.contains("solid.density"), "{without}");
}

#[test]
fn an_own_mesh_is_that_of_a_box() {
    let own = own_mesh::solve(own_mesh::case().mesh(own_mesh::channel(4).unwrap()), 0).unwrap();
    assert!(own["bend"] > 1e-4 && own["drag"] > 0.1, "{own:?}");
    // The box has other names of sides, and the foot of the flap is a part of its bottom.
    let mut of_box = own_mesh::case();
    for name in ["inflow", "outflow", "walls", "foot"] {
        of_box = of_box.remove(&format!("boundary.{name}"));
    }
    let of_box = of_box
        .set("mesh.generator", "box")
        .set("mesh.lower", [0.0, 0.0])
        .set("mesh.upper", [3.0, 1.0])
        .set("mesh.cells", [12, 4])
        .set("mesh.region.solid", "min(min(x - 1, 1.25 - x), 0.5 - y)")
        .set("boundary.left.condition", "velocity")
        .set("boundary.left.velocity", ["4*y*(1 - y)", "0"])
        .set("boundary.right.condition", "do-nothing")
        .set("boundary.top.condition", "no-slip")
        .set("boundary.bottom.condition", "no-slip");
    let of_box = own_mesh::solve(of_box, 0).unwrap();
    near(own["bend"], of_box["bend"], 1e-6);
    near(own["drag"], of_box["drag"], 1e-6);
}

#[test]
fn triangles_are_refined_and_faults_of_an_own_mesh_are_told() {
    let mesh = |last: [f64; 2]| {
        let nodes = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], last];
        // The first cell runs clockwise.
        Mesh::from_cells(
            nodes,
            &[[0, 2, 1], [0, 2, 3]],
            |_| "solid",
            |x| if x[1] == 0.0 { "foot" } else { "sides" },
        )
    };
    let case = |mesh: Mesh<2>| {
        let case = CaseBuilder::new("block").mesh(mesh).set("mesh.refine", 2).set("solid.density", 1.0);
        let case =
            case.set("solid.young", 1.0).set("solid.poisson", 0.3).set("solid.body-force", [0.0, -0.01]);
        case.set("boundary.foot.condition", "clamped").set("boundary.sides.condition", "traction-free")
    };
    let mut simulation = Simulation::new(case(mesh([0.0, 1.0]).unwrap()).build().unwrap(), 1).unwrap();
    simulation.step().unwrap();
    let fields = simulation.fields();
    assert_eq!(fields.coordinates().len(), 9 * 9); // 32 triangles of degree 2
    assert!(fields.at([0.5, 1.0]).unwrap().displacement[1] < -1e-3);

    let error: Error = mesh([0.9, 0.1]).unwrap_err().into();
    assert!(
        matches!(error, Error::Mesh(_)) && error.to_string().contains("cells 0 and 1 overlap"),
        "{error}"
    );
    let twice =
        case(mesh([0.0, 1.0]).unwrap()).set("mesh.generator", "rotor").build().unwrap_err().to_string();
    assert!(twice.contains("mesh.generator") && twice.contains("the program gives the mesh"), "{twice}");
    let written = case(mesh([0.0, 1.0]).unwrap()).build().unwrap().to_toml();
    let read = undula::Case::from_toml(&written, "own.toml", &[]).unwrap_err().to_string();
    assert!(read.contains("mesh.generator = \"own\""), "{read}");
}

#[test]
fn a_sweep_is_in_the_order_of_its_list() {
    let tips = sweep::tips(&[1e6, 0.5e6, 2e6], 0).unwrap();
    near(tips[1], 66.1e-3, 0.02);
    assert!(tips[1] > 1.5 * tips[0] && tips[0] > 1.5 * tips[2], "{tips:?}");
}

#[test]
fn examples_are_short_and_on_the_landing_page() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let landing = fs::read_to_string(root.join("src/lib.rs")).unwrap();
    let manifest = fs::read_to_string(root.join("Cargo.toml")).unwrap();
    for entry in fs::read_dir(root.join("examples")).unwrap() {
        let path = entry.unwrap().path();
        let (name, text) = (path.file_stem().unwrap().to_str().unwrap(), fs::read_to_string(&path).unwrap());
        assert!(text.lines().count() < 80, "{name} has {} lines", text.lines().count());
        assert!(landing.contains(&format!("examples/{name}.rs")), "src/lib.rs does not name {name}");
        assert!(manifest.contains(&format!("name = \"{name}\"")), "Cargo.toml does not name {name}");
        let own = include_str!("examples.rs");
        assert!(own.contains(&format!("mod {name};")), "no test runs {name}");
    }
}

/// All names of the front; a program that uses them compiles.
#[test]
fn the_front_has_its_names() {
    #[allow(unused_imports)]
    use undula::{
        Case, CaseBuilder, Deformation, Error, Fields, Located, Material, Mesh, MeshError, OwnFunction,
        PointFields, Row, Scalar, Setting, Simulation, StoredEnergy, Tensor,
    };
    // A simulation can be moved to a thread, an error out of it.
    fn can_be_sent<T: Send>() {}
    can_be_sent::<Simulation>();
    can_be_sent::<CaseBuilder>();
    can_be_sent::<Error>();
}
