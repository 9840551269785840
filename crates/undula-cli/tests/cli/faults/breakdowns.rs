//! What a run that cannot go on says.

use super::super::SMALL;
use super::{place, undula};

/// A channel of few cells with an inflow, and what `sets` say, as `case.toml`.
const CHANNEL: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [2, 1]
cells = [4, 2]
[fluid]
density = 1
kinematic-viscosity = 0.1
[boundary.left]
condition = "velocity"
velocity = ["y*(1-y)", 0]
[boundary.right]
condition = "do-nothing"
[boundary.top]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
"#;

const IN_TIME: [&str; 2] = ["time.step=0.1", "time.end=1"];

/// The word for a cause and the place in `summary.json`.
fn cause(place: &super::Place, directory: &str) -> (String, String) {
    let summary = place.json(&format!("{directory}/summary.json"));
    let text =
        |key: &str| summary["breakdown"][key].as_str().unwrap_or_else(|| panic!("{summary}")).to_string();
    assert_eq!(summary["status"], "breakdown");
    (text("cause"), text("where"))
}

#[test]
fn a_velocity_that_is_not_finite_is_refused_with_its_place() {
    let here =
        place("nan", &["newcomer/nan_inflow.toml", "newcomer/g_ok.msh", "reliability/nan-velocity.toml"]);
    for command in ["check", "run -o out --threads 1"] {
        let said = undula(&here, &format!("{command} nan_inflow.toml"), &[]);
        said.expect(
            2,
            &["nan_inflow.toml:", "boundary.inflow.velocity", "sqrt(y-0.5)", "(NaN, 0)", "t = 0 s"],
        );
        let said = undula(&here, &format!("{command} nan-velocity.toml"), &[]);
        let said =
            said.expect(2, &["nan-velocity.toml:", "boundary.inflow.velocity", "(NaN, 0) at (0, ", ") m"]);
        assert!(!said.err.contains("t ="), "{said:?}");
    }
    assert!(!here.file("out").exists());
}

#[test]
fn expressions_that_fail_at_a_point_or_time_are_found_by_check() {
    let here = place("expressions", &[]);
    here.write("case.toml", CHANNEL);
    for (source, said) in [
        ("1/(y-0.5)", "(inf, 0) at (0, 0.5) m"),
        ("log10(y)", "(-inf, 0) at (0, 0) m"),
        ("exp(1e4*y)", "(inf, 0)"),
        ("max(sqrt(y-0.5), 0)", "(NaN, 0)"),
        ("if(sqrt(y-0.5) > 1, 1, 0)", "(NaN, 0)"),
        ("ramp(sqrt(0.5-t), 1)*y", "(NaN, 0) at"),
        ("y*(1-y)/(1-t)", "t = 1 s"),
    ] {
        let set = format!("boundary.left.velocity=[\"{source}\", 0]");
        undula(&here, "check case.toml", &[&IN_TIME[..], &[set.as_str()]].concat())
            .expect(2, &["boundary.left.velocity", source, "expected finite values", said]);
    }
    for (source, said) in [("[0, \"1/(x-1)\"]", "(0, inf)"), ("[\"sqrt(0.3-t)\", 0]", "(NaN, 0)")] {
        let set = format!("fluid.body-force={source}");
        undula(&here, "check case.toml", &[&IN_TIME[..], &[set.as_str()]].concat())
            .expect(2, &["fluid.body-force", "expected finite values", said]);
    }
    // A branch that is not taken may be what it likes.
    let set = "boundary.left.velocity=[\"if(y > 0.5, sqrt(y-0.5), 0)\", 0]";
    undula(&here, "check case.toml", &[set]).expect(0, &[]);
}

/// Between the times that `check` looks at: the run ends with the same sentence, and keeps what it has.
#[test]
fn data_that_fail_in_the_course_of_a_run_end_it_as_bad_input() {
    let here = place("later", &[]);
    here.write("case.toml", CHANNEL);
    let moment = "if(abs(t - 0.4) < 1e-6, 1/0, 1)";
    for (key, value) in [
        ("boundary.left.velocity", format!("[\"y*(1-y)*{moment}\", 0]")),
        ("fluid.body-force", format!("[0, \"{moment}\"]")),
    ] {
        let set = format!("{key}={value}");
        let sets = [&IN_TIME[..], &[set.as_str()]].concat();
        undula(&here, "check case.toml", &sets).expect(0, &[]);
        let said = undula(&here, "run case.toml -o out --threads 1 --force", &sets);
        said.expect(2, &[key, "expected finite values; it is (", "inf", "t = 0.4 s"]);
        assert_eq!(here.json("out/summary.json")["status"], "failed");
        assert_eq!(here.read("out/history.csv").lines().count(), 1 + 3);
    }
    let sets = ["time.step=if(abs(t - 0.3) < 1e-6, 0, 0.1)", "time.end=1"];
    let said = undula(&here, "run case.toml -o out --threads 1 --force", &sets);
    said.expect(2, &["time.step", "it is 0 at t = 0.3"]);
    assert_eq!(here.read("out/history.csv").lines().count(), 1 + 3);
}

#[test]
fn a_mesh_that_folds_is_named_with_its_place_and_the_ways_out() {
    let here = place("folds", &[]);
    let soft = ["mesh.refine=0", "motion.model=harmonic", "solid.body-force=[0,-20]", "time.step=0.02"];
    let said = undula(&here, "run fsi3 -o out --threads 1 --quiet", &soft).expect(
        3,
        &[
            "the mesh of the fluid folds, smallest J = ",
            " in cell ",
            "motion.model",
            "motion.offset",
            "time.step",
        ],
    );
    // One sentence and one of what to try; the residuals are in a file.
    assert_eq!(said.err.lines().count(), 3, "{}", said.err);
    let (cause, place) = cause(&here, "out");
    assert!(cause == "folding" && place.starts_with("cell "), "{cause} {place}");
    let table = here.read("out/breakdown.txt");
    assert!(table.contains("step to t = ") && table.lines().count() > 10, "{table}");
    // The file goes with the run.
    undula(&here, "run fsi3 -o out --threads 1 --quiet --force", &SMALL).expect(0, &[]);
    assert!(!here.file("out/breakdown.txt").exists());
}

#[test]
fn a_small_mesh_has_places_with_digits() {
    let here = place("small-folds", &[]);
    here.write("case.toml", &CHANNEL.replace("[2, 1]", "[2e-6, 1e-6]"));
    undula(&here, "check case.toml", &["boundary.left.velocity=[\"1/(y-0.5e-6)\", 0]"])
        .expect(2, &["(0, 5e-7) m"]);
}

#[test]
fn a_flow_that_does_not_converge_has_no_word_of_folding() {
    let here = place("diverges", &[]);
    here.write("case.toml", CHANNEL);
    let sets = ["mesh.cells=[8, 4]", "boundary.left.velocity=[\"1e7*y*(1-y)\", \"1e7*sin(9*y)\"]"];
    let said = undula(&here, "run case.toml -o out --threads 1 --quiet", &sets)
        .expect(3, &["no stationary solution", "does not converge", "momentum of the fluid", " at node "]);
    for word in ["fold", "J =", "t = ", "k = "] {
        assert!(!said.err.contains(word), "`{word}` was said: {}", said.err);
    }
    assert_eq!(cause(&here, "out").0, "divergence");
}

/// Cells 3000 times longer than wide: what single precision cannot condense is solved by the whole Jacobian. The drop of
/// the pressure is that of both with `linear.precision=double`.
#[test]
fn a_flow_at_rest_on_very_long_cells_takes_the_whole_jacobian() {
    let here = place("long-cells", &[]);
    here.write("case.toml", CHANNEL);
    let sets = [
        "mesh.upper=[300, 0.1]",
        "mesh.cells=[10, 10]",
        "space.velocity=Q3",
        "fluid.density=1",
        "fluid.kinematic-viscosity=1e-4",
        "boundary.left.velocity=[\"40*y*(0.1 - y)*(1 + 0.2*y)\", 0]",
        "functional.dp={ kind = \"pressure-difference\", a = [0, 0.05], b = [150, 0.05] }",
    ];
    let drop = |more: &[&str]| {
        undula(&here, "run case.toml -o out --threads 1 --quiet --force", &[&sets, more].concat())
            .expect(0, &[]);
        here.json("out/summary.json")["functionals"]["dp"]["last"].as_f64().unwrap()
    };
    let (single, double) = (drop(&[]), drop(&["linear.precision=double"]));
    assert!((single - double).abs() < 1e-6 * double.abs(), "{single}, {double}");
}

/// Loads at which the iteration converges are none of its business.
#[test]
fn a_linear_iteration_that_is_too_slow_says_so_early() {
    let here = place("slow", &[]);
    for linearization in ["fixed-point", "reduced"] {
        for load in [2, 8, 30, 1000] {
            let inflow = format!("boundary.inflow.velocity=[\"{load}*1.5*0.2*y*(0.41-y)/(0.41/2)^2\", 0]");
            let way = format!("newton.linearization={linearization}");
            let sets = ["mesh.refine=0", "mesh.grading=0", inflow.as_str(), way.as_str()];
            let said = undula(&here, "run fsi1 -o out --threads 1 --quiet --force", &sets);
            if said.code == Some(0) {
                continue;
            }
            let said = said.expect(
                3,
                &["no stationary solution", "by the factor ", "newton.linearization = \"newton\""],
            );
            assert_eq!(cause(&here, "out").0, "slow");
            let done = said.err.split("after ").nth(1).and_then(|rest| rest.split(' ').next());
            let done: usize = done.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{}", said.err));
            assert!(done <= 100, "{}", said.err);
            // One more line for the start of each attempt.
            let told = here.read("out/breakdown.txt").lines().filter(|l| l.starts_with("   ")).count();
            assert!(told <= 100 + 10, "{told} lines");
        }
    }
}

#[test]
#[ignore = "long"]
fn a_verbose_run_tells_the_residuals_of_all_parts() {
    let here = place("verbose", &[]);
    let verbose = |case: &str, sets: &[&str]| {
        let said = undula(&here, &format!("run {case} -o out --threads 1 --force --verbose"), sets);
        let said = said.expect(0, &["residuals "]);
        let lines: Vec<String> =
            said.err.lines().filter(|l| l.contains("residuals")).map(String::from).collect();
        assert!(
            lines.iter().all(|l| l.split("residuals ").nth(1).is_some_and(|r| r.contains("e"))),
            "{lines:?}"
        );
        lines
    };
    let parts = [&SMALL[..], &["time.scheme=fractional-step-theta"]].concat();
    for line in verbose("fsi3", &parts) {
        assert_eq!(line.matches('|').count(), 2, "{line}");
    }
    let adaptive = [&SMALL[..], &["time.adaptive.tolerance=1e-3"]].concat();
    assert!(verbose("fsi3", &adaptive)[0].starts_with("t = "));
    let lines = verbose("csm1", &["mesh.refine=0", "solid.body-force=[0,-60]"]);
    assert!(lines[0].starts_with("stationary: ") && lines.len() == 1, "{lines:?}");
}

/// The reduced Jacobian of a solid alone is the whole one: no linear iteration that could be too slow.
#[test]
fn a_solid_alone_is_reduced_to_nothing() {
    let here = place("solid-reduced", &[]);
    let last = |way: &str| {
        let sets = ["mesh.refine=0", way];
        undula(&here, "run csm1 -o out --threads 1 --quiet --force", &sets).expect(0, &[]);
        here.json("out/summary.json")["functionals"]["uy_A"]["last"].as_f64().unwrap()
    };
    assert_eq!(last("newton.linearization=reduced"), last("newton.linearization=newton"));
}

#[test]
fn stationary_breakdowns_do_not_speak_of_time() {
    let here = place("stationary", &[]);
    let sets = ["mesh.refine=0", "solid.body-force=[0,-20000]"];
    let said =
        undula(&here, "run csm1 -o out --threads 1 --quiet", &sets).expect(3, &["no stationary solution"]);
    for word in ["t = ", "k = ", "0.000e0"] {
        assert!(!said.err.contains(word), "`{word}` was said: {}", said.err);
    }
}
