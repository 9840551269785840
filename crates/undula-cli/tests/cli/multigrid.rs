//! `linear.solver = "multigrid"`: the same solution as by factors, in iterations that do not grow.

use super::Place;
use super::in_space::{FLAP, Row};

const MULTIGRID: &str = "linear.solver=multigrid";
const TIGHT: [&str; 2] = ["newton.tolerance=1e-10", "newton.floor=0"];
const INFLOW: &str = "boundary.left.velocity=[\"y*(0.4 - y)\", 0]";
const LAYER: &str = "mesh.extrude={ depth = 0.2, layers = 2 }";

/// A lid-driven cavity of equal cells.
const LID: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 1]
cells = [2, 2]
[fluid]
density = 1
kinematic-viscosity = 0.01
[boundary.top]
condition = "velocity"
velocity = ["16*(x*(1 - x))^2*ramp(t, 0.1)", 0]
[boundary.bottom]
condition = "no-slip"
[boundary.left]
condition = "no-slip"
[boundary.right]
condition = "do-nothing"
[time]
step = 0.05
end = 0.1
[functional.flux]
kind = "flux"
on = ["right"]
[functional.lid]
kind = "force"
on = ["top"]
component = "x"
"#;

/// Both solvers end at the same numbers. Returns iterations for each step of Newton's method.
#[track_caller]
fn agree(here: &Place, case: &str, sets: &[&str]) -> f64 {
    let with = |solver: &str| here.rows(case, &[&TIGHT, sets, &[solver]].concat());
    let by_factors = with("linear.solver=multifrontal");
    let rows = with(MULTIGRID);
    let summary = here.json("out/summary.json");
    assert_eq!(summary["direct_fallbacks"], 0, "{sets:?}");
    let sum: f64 = rows.iter().map(|row| row["linear_iterations"]).sum();
    assert_eq!(summary["linear_iterations"].as_f64(), Some(sum), "{sets:?}");
    is_near(&by_factors, &rows, sets);
    summary["linear_iterations"].as_f64().unwrap() / summary["newton_steps"].as_f64().unwrap()
}

#[track_caller]
fn is_near(one: &[Row], other: &[Row], sets: &[&str]) {
    assert_eq!(one.len(), other.len());
    let counts = ["step", "jacobians", "newton_steps"];
    for name in one[0].keys().filter(|name| !counts.contains(&name.as_str())) {
        let largest = one.iter().map(|row| row[name].abs()).fold(1e-4, f64::max);
        for (one, other) in one.iter().zip(other) {
            let gap = (one[name] - other[name]).abs();
            assert!(gap <= 1e-6 * largest, "{name}: {} and {}; {sets:?}", one[name], other[name]);
        }
    }
}

#[test]
fn moving_bodies_are_those_of_a_direct_solver() {
    let here = Place::new("multigrid-flap");
    here.write("flap.toml", FLAP);
    for (sets, most) in [
        (&["mesh.refine=1"][..], 6.0),
        (&["mesh.refine=2", "time.scheme=bdf2", "motion.model=harmonic"], 6.0),
        (&["mesh.refine=1", "motion.model=biharmonic"], 6.0),
        (&["mesh.refine=1", "solid.law=incompressible-neo-hookean", "solid.lambda=none"], 8.0),
        (&["mesh.refine=1", "motion.model=jacobian-stiffened", LAYER], 6.0),
        // Parts of a step that share factors.
        (&["mesh.refine=1", "time.scheme=fractional-step-theta"], 6.0),
        // As stiff as the matrix may be in single precision, and stiffer.
        (&["mesh.refine=1", "solid.mu=6e7", "solid.lambda=1.2e8"], 6.0),
        (&["mesh.refine=1", "solid.mu=2e9", "solid.lambda=4e9"], 6.0),
    ] {
        let iterations = agree(&here, "flap.toml", sets);
        assert!(iterations < most, "{iterations}: {sets:?}");
    }
}

/// Flow, solid and extension one behind the other; a thin body, whose bending needs double precision; an extension that
/// takes factors.
#[test]
#[ignore = "long"]
fn deformations_at_rest_are_those_of_a_direct_solver() {
    let here = Place::new("multigrid-at-rest");
    here.write("flap.toml", FLAP);
    for (case, sets, most) in [
        ("fsi1", &["mesh.refine=1"][..], 5.0),
        ("flap.toml", &["mesh.refine=1", "time=none", INFLOW], 5.0),
        ("csm2", &["mesh.refine=1"], 12.0),
        (
            "flap.toml",
            &["mesh.refine=1", "time=none", "boundary.left.velocity=[\"y*(0.4 - y)\", 0, 0]", LAYER],
            5.0,
        ),
        // Cycles for an extension of fourth order take 3.7 here, and fail on finer meshes.
        ("flap.toml", &["mesh.refine=3", "time=none", INFLOW, "motion.model=biharmonic"], 3.2),
    ] {
        let iterations = agree(&here, case, sets);
        assert!(iterations < most, "{iterations}: {case} {sets:?}");
    }
    let counts = [1, 2].map(|refine| agree(&here, "fsi1", &[&format!("mesh.refine={refine}")]));
    assert!(counts[1] < 1.2 * counts[0], "{counts:?}");
}

#[test]
fn flows_of_all_pairs_are_those_of_a_direct_solver() {
    let here = Place::new("multigrid-pairs");
    here.write("lid.toml", LID);
    for (sets, most) in [
        (&["mesh.refine=2"][..], 5.0),
        (&["mesh.refine=2", "space.velocity=Q3", "space.pressure=P2dc"], 6.0),
        (&["mesh.refine=2", "space.pressure=Q1"], 10.0),
        (&["mesh.refine=2", "space.velocity=P2", "space.pressure=P1"], 12.0),
        (&["mesh.refine=2", "space.velocity=Q1", "stabilization.pressure=lps"], 12.0),
        (&["mesh.refine=1", LAYER, "space.pressure=Q1"], 10.0),
    ] {
        let iterations = agree(&here, "lid.toml", sets);
        assert!(iterations < most, "{iterations}: {sets:?}");
    }
}

/// Layers that are thick, graded or of an odd number stay on coarser meshes.
#[test]
#[ignore = "long"]
fn long_cells_are_coarsened_across() {
    let here = Place::new("multigrid-long");
    here.write("lid.toml", LID);
    for (layers, most) in [
        ("mesh.extrude={ depth = 2, layers = 2 }", 7.0),
        ("mesh.extrude={ depth = 1, layers = 2, grading = 1 }", 7.0),
        ("mesh.extrude={ depth = 0.6, layers = 3 }", 7.0),
    ] {
        for no_slip in [false, true] {
            let condition = if no_slip { "no-slip" } else { "symmetry" };
            let sides = ["front", "back"].map(|side| format!("boundary.{side}.condition={condition}"));
            let sets = ["mesh.refine=2", layers, &sides[0], &sides[1]];
            let iterations = agree(&here, "lid.toml", &sets);
            assert!(iterations < most, "{iterations}: {sets:?}");
        }
    }
}

#[test]
fn iterations_do_not_grow_with_refinement() {
    let here = Place::new("multigrid-growth");
    here.write("lid.toml", LID);
    let count = |refine: usize, sets: &[&str]| {
        let refine = format!("mesh.refine={refine}");
        here.rows("lid.toml", &[&[MULTIGRID, "linear.krylov-tolerance=1e-6", &refine], sets].concat());
        let summary = here.json("out/summary.json");
        summary["linear_iterations"].as_f64().unwrap() / summary["newton_steps"].as_f64().unwrap()
    };
    let plane: Vec<f64> = [2, 3, 4].map(|refine| count(refine, &[])).to_vec();
    assert!(plane[2] < 1.2 * plane[0], "{plane:?}");
    let cube = [
        "mesh.lower=[0, 0, 0]",
        "mesh.upper=[1, 1, 1]",
        "mesh.cells=[2, 2, 2]",
        "boundary.top.velocity=[\"16*(x*(1 - x))^2*ramp(t, 0.1)\", 0, 0]",
        "boundary.front.condition=symmetry",
        "boundary.back.condition=symmetry",
    ];
    let space: Vec<f64> = [1, 2].map(|refine| count(refine, &cube)).to_vec();
    assert!(space[1] < 1.3 * space[0], "{space:?}");
}

#[test]
fn results_depend_on_neither_threads_nor_interruptions() {
    let here = Place::new("multigrid-bits");
    here.write("flap.toml", FLAP);
    let sets = [MULTIGRID, "mesh.refine=2", "time.end=0.04"];
    let history = |arguments: &str, sets: &[&str]| {
        here.run(&format!("run flap.toml --quiet {arguments}"), sets).expect(0, &[]);
        here.read("out/history.csv")
    };
    let one = history("--threads 1 --force -o out", &sets);
    assert_eq!(one, history("--threads 3 --force -o out", &sets));
    let half = [MULTIGRID, "mesh.refine=2", "time.end=0.02"];
    history("--threads 1 --force -o out", &half);
    assert_eq!(one, history("--threads 1 --resume -o out", &sets));
    // The solver may change, the columns do not.
    let half = [&half[1..], &["linear.solver=multifrontal"]].concat();
    let columns = |history: &str| history.lines().next().unwrap().to_string();
    let before = columns(&history("--threads 1 --force -o out", &half));
    assert!(columns(&one).ends_with(",linear_iterations") && !before.contains("linear_iterations"));
    assert_eq!(before, columns(&history("--threads 1 --resume -o out", &sets)));
}

#[test]
fn a_direct_solver_takes_over_where_multigrid_fails() {
    let here = Place::new("multigrid-fails");
    here.write("flap.toml", FLAP);
    here.write("lid.toml", LID);
    // One iteration is not enough.
    let weak = ["mesh.refine=1", "linear.krylov-size=1", "linear.krylov-tolerance=1e-9"];
    let still = ["time=none", "boundary.top.velocity=[\"16*(x*(1 - x))^2\", 0]"];
    for (case, more) in [("flap.toml", &[][..]), ("lid.toml", &still)] {
        let with = |solver: &str| here.rows(case, &[&TIGHT[..], &weak, &[solver], more].concat());
        let rows = with(MULTIGRID);
        assert_eq!(here.json("out/summary.json")["direct_fallbacks"], 1);
        is_near(&with("linear.solver=multifrontal"), &rows, more);
        let sets = [&[MULTIGRID], &weak[..], more].concat();
        here.run(&format!("run {case} --force"), &sets)
            .expect(0, &["did not converge, the direct solver takes over"]);
    }
}

/// Multigrid fails within Newton's method: the step is neither shortened nor given up, and the direct solver, which keeps
/// the slopes of p of long cells, needs no second attempt.
#[test]
fn a_direct_solver_takes_over_in_the_same_step() {
    let here = Place::new("multigrid-stalls");
    here.write("lid.toml", LID);
    let sets = [
        "mesh.refine=2",
        "mesh.cells=[6, 2]",
        "mesh.extrude={ depth = 200, layers = 1 }",
        "boundary.left.condition=velocity",
        "boundary.left.velocity=[\"5*y*(1 - y)\", 0]",
        "fluid.kinematic-viscosity=1e-4",
        "time.end=0.05",
        "time.max-halvings=0",
    ];
    let with = |solver: &str| here.rows("lid.toml", &[&TIGHT[..], &sets, &[solver]].concat());
    let rows = with(MULTIGRID);
    assert_eq!(here.json("out/summary.json")["direct_fallbacks"], 1);
    is_near(&with("linear.solver=multifrontal"), &rows, &sets);
}

#[test]
fn what_multigrid_cannot_do_is_said() {
    let here = Place::new("multigrid-input");
    here.write("flap.toml", FLAP);
    here.run("run flap.toml", &[MULTIGRID]).expect(2, &["linear.solver", "mesh.refine of at least 1"]);
    here.run("check flap.toml", &[MULTIGRID]).expect(2, &["linear.solver", "mesh.refine of at least 1"]);
    let whole = [MULTIGRID, "newton.linearization=newton"];
    here.run("check flap.toml", &whole).expect(0, &["linear.solver has no effect"]);
    let body = ["mesh.refine=1", "solid.law=incompressible-neo-hookean", "solid.lambda=none", MULTIGRID];
    here.run("check csm2", &body).expect(0, &["linear.solver has no effect", "incompressible"]);
    let bubbles = [MULTIGRID, "mesh.refine=1", "space.velocity=P2-bubble", "space.pressure=P1dc"];
    here.run("check flap.toml", &bubbles).expect(2, &["linear.solver", "bubbles"]);
    here.write("krylov.toml", &format!("{FLAP}[linear]\nsolver = \"multigrid\"\nkrylov = \"none\"\n"));
    here.run("check krylov.toml", &["mesh.refine=1"]).expect(0, &["linear.krylov has no effect"]);
}
