//! `undula study` and `undula reproduce`.

use super::*;

/// Two stiffnesses of the beam of csm1.
const STUDY: &str = r#"
name = "stiff"
title = "A stiffer beam & a softer one"
case = "csm1"
functionals = ["uy_A"]
[set]
"mesh.refine" = 0
[[run]]
name = "mu"
over = [{ key = "solid.mu", values = [0.5e6, 1e6] }]
[[run]]
name = "fine"
set = { "mesh.refine" = 1 }
full-only = true
[[table]]
title = "Sinking"
head = ["mu", "published [mm]", "computed [mm]"]
rows = [[0.5, -66.1, "=1e3*mu_0.uy_A"], ["a, b", "", "=1e3*mu_1.uy_A"]]
[[figure]]
title = "Sinking over stiffness"
x = "mu [MPa]"
y = "uy_A [mm]"
curves = [{ name = "computed", points = [[0.5, "=1e3*mu_0.uy_A"], [1, "=1e3*mu_1.uy_A"]] }]
[[statement]]
text = "A stiffer beam sinks less."
number = "mu_1.uy_A/mu_0.uy_A"
holds = "it < 0.75 and mu_0.uy_A < 0"
[[statement]]
text = "A finer mesh sinks by 66.1 mm."
number = "1e3*fine.uy_A"
published = -66.1
unit = "mm"
holds = "abs(it/-66.1 - 1) < 0.01"
"#;

fn verdicts(place: &Place, directory: &str) -> Vec<String> {
    let results = place.json(&format!("{directory}/results.json"));
    let statements = results[0]["statements"].as_array().unwrap();
    statements.iter().map(|s| s["verdict"].as_str().unwrap().to_string()).collect()
}

#[test]
fn a_study_has_a_page_tables_and_verdicts() {
    let place = Place::new("study");
    place.write("stiff.toml", STUDY);
    let said =
        place.run("study stiff.toml", &[]).expect(0, &["2 statements: 2 reproduced", "out/stiff/index.html"]);
    assert!(said.err.contains("mu_1"), "{}", said.err);
    assert_eq!(verdicts(&place, "out/stiff"), ["reproduced", "reproduced"]);
    let page = place.read("out/stiff/index.html");
    for part in
        ["A stiffer beam &amp; a softer one", "<svg", "stiff/table-1.csv", "solid.mu = 500000", "-66."]
    {
        assert!(page.contains(part), "no {part} in the page");
    }
    // Nothing is fetched from elsewhere.
    assert!(!page.contains("src=\"http") && !page.contains("<script") && !page.contains("<link"));
    let table = place.read("out/stiff/stiff/table-1.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "mu,published [mm],computed [mm]");
    assert!(lines[1].starts_with("0.5,-66.1,-6") && lines[2].starts_with("\"a, b\",,-"), "{table}");
    assert!(place.read("out/stiff/stiff/runs.csv").lines().count() == 4);

    // The same command keeps what is there; a result that changes turns the verdict round.
    place.run("study stiff.toml", &[]).expect(0, &["mu_0 is there already", "2 reproduced"]);
    let history = place.read("out/stiff/stiff/runs/mu_1/history.csv");
    let (head, row) = history.trim_end().split_once('\n').unwrap();
    let at = head.split(',').position(|name| name == "uy_A").unwrap();
    let cells: Vec<&str> =
        row.split(',').enumerate().map(|(n, cell)| if n == at { "-0.1" } else { cell }).collect();
    place.write("out/stiff/stiff/runs/mu_1/history.csv", &format!("{head}\n{}\n", cells.join(",")));
    place
        .run("study stiff.toml", &[])
        .expect(0, &["1 reproduced, 1 not", "not reproduced: A stiffer beam sinks less."]);
    assert_eq!(verdicts(&place, "out/stiff"), ["not reproduced", "reproduced"]);
}

#[test]
fn a_quick_study_leaves_runs_out_and_says_so() {
    let place = Place::new("study-quick");
    place.write("stiff.toml", STUDY);
    place
        .run("study stiff.toml --quick -o q", &[])
        .expect(0, &["1 reproduced, 0 not reproduced, 1 undecided"]);
    assert_eq!(verdicts(&place, "q"), ["reproduced", "undecided"]);
    assert!(place.read("q/index.html").contains("missing: fine.uy_A"));
}

#[test]
fn mistakes_in_a_study_are_found_before_anything_is_computed() {
    let place = Place::new("study-mistakes");
    let wrong = |from: &str, to: &str, words: &[&str]| {
        assert!(STUDY.contains(from));
        place.write("wrong.toml", &STUDY.replace(from, to));
        place.run("study wrong.toml -o w", &[]).expect(2, words);
        assert!(!place.file("w").exists());
    };
    wrong("functionals =", "functional =", &["wrong.toml", "unknown field `functional`", "line 5"]);
    wrong("\"solid.mu\"", "\"solid.nu\"", &["run mu_0", "solid.nu"]);
    wrong(
        "mu_1.uy_A/mu_0.uy_A",
        "mu_2.uy_A/mu_0.uy_A",
        &["A stiffer beam sinks less", "unknown run `mu_2`", "mu_1"],
    );
    wrong("mu_1.uy_A/mu_0.uy_A", "mu_1.uy_B", &["unknown result `uy_B`", "did you mean `uy_A`"]);
    wrong("it < 0.75 and", "it < 0.75 und", &["expected an operator"]);
    wrong("name = \"fine\"", "name = \"mu\"", &["two runs have the name \"mu\""]);
    wrong("name = \"fine\"", "name = \"a-b\"", &["run.name = \"a-b\""]);
    wrong(
        "=1e3*mu_1.uy_A\"]]\n[[figure]]",
        "=highest(mu_1.uy_A)\"]]\n[[figure]]",
        &["`highest` takes a signal"],
    );
    wrong("name = \"fine\"", "name = \"mu_1\"", &["run mu_1", "another run has this name"]);
    wrong("full-only = true", "from = \"mu\"", &["run fine: from = \"mu\"", "without `over`"]);
    wrong(
        "\"mesh.refine\" = 0",
        "\"mesh.refine\" = 0\n\"functional.seconds\" = { kind = \"displacement\", point = [0.6, 0.2], component = \"x\" }",
        &["functional.seconds", "every run has a result of this name"],
    );
    place.run("study fsi3", &[]).expect(2, &["built-in case", "--converge"]);
    place.run("reproduce nonsense", &[]).expect(2, &["nonsense", "mesh-motion"]);
}

#[test]
fn runs_are_replaced_with_force_only() {
    let place = Place::new("study-force");
    place.write("stiff.toml", STUDY);
    place.run("study stiff.toml --quick -o s", &[]).expect(0, &[]);
    place.write("stiff.toml", &STUDY.replace("[0.5e6, 1e6]", "[0.5e6, 2e6]"));
    place.run("study stiff.toml --quick -o s", &[]).expect(2, &["mu_1", "--force"]);
    place.run("study stiff.toml --quick -o s --force", &[]).expect(0, &["mu_0 is there already"]);
    // Nothing is computed: the run that a quick study leaves out is missing in the full one.
    let said = place.run("study stiff.toml -o s --collect", &[]).expect(0, &["1 undecided"]);
    assert!(!said.err.contains("completed") && !place.file("s/stiff/runs/fine").exists(), "{}", said.err);
    // A directory of something else is left alone.
    place.write("other/file", "mine");
    place
        .run("study stiff.toml --quick -o other --force", &[])
        .expect(2, &["other", "no directory of a study"]);
}

#[test]
#[ignore = "long"]
fn refinement_gives_orders_and_extrapolated_values() {
    let place = Place::new("study-converge");
    let said = place.run("study csm1 --converge -q", &["mesh.refine=0"]).expect(0, &[]);
    assert!(said.out.is_empty() && said.err.is_empty(), "{said:?}");
    let said = place
        .run("study csm1 --converge", &["mesh.refine=0"])
        .expect(0, &["order 2.", "mesh_2 is there already"]);
    // Hron and Turek 2006: u_y = −66.10 mm; converged −66.103 mm.
    let line = said.out.lines().find(|line| line.starts_with("uy_A value")).unwrap();
    let value: f64 = line.split(": ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let uncertainty: f64 = line.split("± ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((value + 66.103e-3).abs() < uncertainty && uncertainty < 1e-4, "{line}");
}

/// A mesh whose run breaks down has no value, so that there is no order.
#[test]
fn refinement_takes_no_values_of_breakdowns() {
    let place = Place::new("study-converge-breakdown");
    let said = place
        .run("study csm1 --converge", &["mesh.refine=0", "newton.max-steps=1"])
        .expect(0, &["mesh_2 breakdown", "index.html"]);
    assert!(!said.out.contains("order"), "{}", said.out);
}

#[test]
fn the_studies_of_the_book_are_sound() {
    let place = Place::new("study-book");
    let said = place.run("reproduce --list", &[]).expect(0, &["5.3.5", "5.1.1"]);
    assert!(said.out.lines().count() >= 4, "{}", said.out);
    assert!(!place.file("out").exists());
}

#[test]
fn nothing_goes_on_from_a_run_that_broke_down() {
    let place = Place::new("study-from");
    let study = |end: &str| {
        format!(
            r#"
name = "on"
case = "csm3"
[set]
"mesh.refine" = 0
"time.step" = 0.01
[[run]]
name = "base"
set = {{ "time.end" = 0.03, "newton.max-steps" = {end}, "time.max-halvings" = 0 }}
[[run]]
name = "on"
from = "base"
set = {{ "time.end" = 0.05 }}
[[run]]
name = "further"
from = "on"
set = {{ "time.end" = 0.06 }}
[[statement]]
text = "It goes on."
number = "on.end_time"
holds = "it > 0.0499 and on.steps > 1.5 and on.steps < 2.5"
[[statement]]
text = "And on."
number = "further.end_time"
holds = "it > 0.0599 and further.steps > 0.5 and further.steps < 1.5 and further.uy_A < on.uy_A"
"#
        )
    };
    place.write("on.toml", &study("30"));
    place.run("study on.toml -o good", &[]).expect(0, &["2 reproduced"]);
    let circle = study("30").replace("name = \"base\"", "name = \"base\"\nfrom = \"further\"");
    place.write("circle.toml", &circle);
    place.run("study circle.toml -o circle", &[]).expect(2, &["from = \"further\" leads back to it"]);
    place.write("on.toml", &study("1"));
    place.run("study on.toml -o bad", &[]).expect(0, &["base breakdown", "2 undecided"]);
}

/// One after the other in one process.
#[test]
fn the_processor_time_of_a_run_is_its_own() {
    let place = Place::new("study-processor");
    let text = "name = \"three\"\ncase = \"csm3\"\n[set]\n\"mesh.refine\" = 2\n\"time.step\" = 0.01\n[[run]]\nname = \"run\"\n\
                over = [{ key = \"time.end\", values = [0.2, 0.21, 0.22] }]\n";
    place.write("three.toml", text);
    place.run("study three.toml -o three --threads 1", &[]).expect(0, &[]);
    let [processor, clock] = ["cpu_seconds", "wall_seconds"].map(|key| {
        let of = |run: usize| place.json(&format!("three/three/runs/run_{run}/summary.json"))[key].as_f64();
        (0..3).filter_map(of).sum::<f64>()
    });
    // With the time of the runs before it would be twice as much.
    assert!(processor <= 1.5 * clock + 0.03, "{processor} s of {clock} s");
}

/// A known solution on the unit square, a run whose last state is measured, and what stands for several of a kind.
#[test]
#[ignore = "long"]
fn a_study_computes_errors_modes_and_matrices() {
    let study = r#"
name = "more"
case = "square"
[cases]
square = """
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 1]
cells = [4, 4]
region.solid = "0.5-y"
[fluid]
density = 1.3
kinematic-viscosity = 0.4
[solid]
density = 2.1
law = "st-venant-kirchhoff"
mu = 3.0
lambda = 4.0
[boundary]
left.condition = "no-slip"
right.condition = "no-slip"
bottom.condition = "clamped"
top.condition = "do-nothing"
"""
[[run]]
name = "known"
compute = "errors"
over = [{ key = "mesh.refine", values = [0, 1, 2] }]
[[run]]
name = "beam"
case = "csm3"
compute = "newmark"
set = { "mesh.refine" = 0, "time.end" = 0.05, "newton.tolerance" = 1e-10 }
[[run]]
name = "modes"
case = "fsi3"
compute = "modes"
set = { "mesh.refine" = 0 }
[[run]]
name = "dry"
case = "csm3"
compute = "modes"
set = { "mesh.refine" = 0 }
[[run]]
name = "turn"
case = "rotor"
set = { "mesh.refine" = 0, "time.end" = 0.2, "output.fields-every" = 2 }
also = ["inf-sup", "matrix"]
[[picture]]
title = "The bar"
run = "turn"
time = 0.1
field = "pressure"
[[table]]
title = "Errors"
head = ["refined", "v"]
each = [[0], [1], [2]]
row = ["{1}", "=known_{1}.error_v"]
[[statement]]
text = "{1} has order {2}."
each = [["v", 3], ["u", 3], ["p", 2]]
number = "order(known_1.error_{1}, known_2.error_{1})"
published = "{2}"
holds = "it > {2} - 0.1"
[[statement]]
text = "Newmark's method is the Crank-Nicolson scheme."
number = "beam.difference"
holds = "it < 1e-9 and beam.count > 9.5"
[[statement]]
text = "Water slows the beam down."
number = "modes.fluid_1/modes.vacuum_1"
holds = "it > 0.2 and it < 0.3"
[[statement]]
text = "Without water there is nothing to compare."
number = "dry.fluid_1"
holds = "it > 0"
[[statement]]
text = "Blocks off the tree of couplings are zero, the diagonal of the divergence is, too."
number = "turn.entries_xi_q + turn.entries_psi_f_z_f + turn.entries_phi_s_q"
holds = "it < 0.5 and turn.zero_diagonal > turn.unknowns_q - 0.5 and turn.entries_phi_i_w_s > 0.5"
[[statement]]
text = "The bar has hardly turned."
number = "turn.inf_sup_moved/turn.inf_sup"
holds = "abs(it - 1) < 1e-3 and turn.present_J > 0.9"
"#;
    let place = Place::new("study-more");
    place.write("more.toml", study);
    place
        .run("study more.toml", &[])
        .expect(0, &["8 statements: 7 reproduced, 0 not reproduced, 1 undecided"]);
    let page = place.read("out/more/index.html");
    assert!(page.contains("p has order 2.") && page.contains("<img src=\"data:image/png;base64,"));
    assert!(place.file("out/more/more/picture-1.png").is_file());
    assert_eq!(place.read("out/more/more/table-1.csv").lines().count(), 4);
    // All is kept, the numbers included; numbers of other quantities make another run.
    let said = place.run("study more.toml", &[]).expect(0, &["7 reproduced", "modes is there already"]);
    assert!(!said.err.contains("completed"), "{}", said.err);
    place.write("more.toml", &study.replace("also = [\"inf-sup\", \"matrix\"]", "also = [\"matrix\"]"));
    place.run("study more.toml", &[]).expect(2, &["unknown result `inf_sup_moved`"]);

    let wrong = |from: &str, to: &str, words: &[&str]| {
        assert!(study.contains(from));
        place.write("wrong.toml", &study.replace(from, to));
        place.run("study wrong.toml -o w", &[]).expect(2, words);
        assert!(!place.file("w").exists());
    };
    wrong("compute = \"modes\"", "compute = \"modals\"", &["unknown variant `modals`", "`newmark`"]);
    wrong("modes.fluid_1/", "modes.end_time/", &["unknown result `end_time`"]);
    wrong("each = [[\"v\", 3]", "each = [[\"v\"]", &["expected a value for {2}"]);
    wrong("row = [\"{1}\", ", "rows = [] #", &["table \"Errors\"", "both `each` and `row`"]);
    wrong(
        "compute = \"modes\"",
        "compute = \"modes\"\nalso = [\"matrix\"]",
        &["run modes", "nor with `also`"],
    );
    let refused = |from: &str, to: &str, words: &[&str]| {
        place.write("refused.toml", &study.replace(from, to));
        place.run("study refused.toml -o r --force", &[]).expect(2, words);
    };
    let short = "\"time.end\" = 0.05, ";
    refused(short, "\"time.end\" = 0.05, \"time.step\" = \"0.005+t\", ", &["time.step", "equal steps"]);
    refused(
        short,
        "\"time.end\" = 0.05, \"solid.body-force\" = [0, \"-2*t\"], ",
        &["solid.body-force", "depend on t"],
    );
    wrong("run = \"turn\"", "run = \"turned\"", &["picture \"The bar\"", "no run is called \"turned\""]);
    wrong("field = \"pressure\"", "field = \"stress\"", &["`velocity`, `pressure`, `deformation`"]);
    wrong("cells = [4, 4]", "cells = [4, 4, 4]", &["cases.square", "cells"]);
}
