//! Statistics, comparisons, and what `check` tells.

use super::{close, place, undula};
use serde_json::Value;
use std::fs;

/// A ramp and a zigzag: nothing of them is periodic, neither in the summary nor in the picture.
#[test]
fn a_ramp_and_a_zigzag_have_no_period_in_any_output() {
    let place = place("ramp", &["newcomer/flap.toml", "newcomer/flap_tri2.msh"]);
    undula(&place, "run flap.toml --threads 1 -o out --quiet", &["space.velocity=P2"]).expect(0, &[]);
    let summary = place.json("out/summary.json");
    for name in ["ux_tip", "fx"] {
        let found = &summary["functionals"][name];
        assert!(found["last"].is_f64());
        assert!(["mean", "amplitude", "frequency"].iter().all(|key| found[key].is_null()), "{found}");
    }
    undula(&place, "plot out", &[]).expect(0, &["history.svg"]);
    let picture = place.read("out/plots/history.svg");
    assert!(picture.contains("ux_tip") && !picture.contains("Hz") && !picture.contains('±'), "{picture}");
    let said = undula(&place, "compare out out", &[]).expect(0, &["value", "max"]);
    assert!(!said.out.contains("frequency") && !said.out.contains("amplitude"), "{}", said.out);
}

/// A body that swings: one frequency in summary, comparison and picture; none where it comes to rest.
#[test]
fn a_period_is_the_same_in_all_outputs() {
    let place = place("swing", &[]);
    let common = ["mesh.refine=0", "time.step=0.02", "time.end=4", "output.leading=none"];
    undula(&place, "run csm3 --threads 1 -o swing --quiet", &common).expect(0, &[]);
    let uy = &place.json("swing/summary.json")["functionals"]["uy_A"];
    let [amplitude, frequency] = ["amplitude", "frequency"].map(|key| uy[key].as_f64().unwrap());
    undula(&place, "plot swing", &[]).expect(0, &[]);
    let told = format!("± {:.2} mm, {frequency:.4} Hz", 1e3 * amplitude);
    assert!(place.read("swing/plots/history.svg").contains(&told), "{told}");
    let damped = [&common[..], &["time.scheme=backward-euler", "time.shift=none"]].concat();
    undula(&place, "run csm3 --threads 1 -o damped --quiet", &damped).expect(0, &[]);
    let uy = &place.json("damped/summary.json")["functionals"]["uy_A"];
    assert!(uy["amplitude"].is_null() && uy["frequency"].is_null(), "{uy}");
    let said = undula(&place, "compare swing damped", &[]).expect(0, &["swing", "damped", "value"]);
    assert!(!said.out.contains("frequency"), "{}", said.out);
    assert!(!said.out.contains("csm3  csm3"), "{}", said.out);
}

/// What one run did later does not count.
#[test]
fn two_runs_are_named_and_compared_over_their_common_time() {
    let place = place("common", &[]);
    let common = ["mesh.refine=0", "newton.tolerance=1e-11"];
    let short = [&common[..], &["time.step=0.02", "time.end=0.4"]].concat();
    let long = [&common[..], &["time.step=0.01", "time.end=0.6"]].concat();
    fs::create_dir(place.file("runs")).unwrap();
    undula(&place, "run csm3 --threads 1 -o runs/short --quiet", &short).expect(0, &[]);
    undula(&place, "run csm3 --threads 1 -o runs/long --quiet", &long).expect(0, &[]);
    let said = undula(&place, "compare runs/short runs/long", &[])
        .expect(0, &["From 0.02 s to 0.4 s, which both runs have", "runs/short", "runs/long"]);
    let history = undula::output::History::read(place.file("runs/long/history.csv")).unwrap();
    let at = history.column("time").unwrap().iter().position(|t| (t - 0.4).abs() < 1e-9).unwrap();
    let value = history.column("uy_A").unwrap()[at];
    let row = said.out.lines().find(|line| line.starts_with("uy_A") && line.contains("value")).unwrap();
    let told: f64 = row.split_whitespace().nth(4).unwrap().parse().unwrap();
    close(told, value, 1e-5);
}

#[test]
fn published_values_stand_beside_the_problem_they_are_of() {
    let place = place("published", &[]);
    let coarse = ["mesh.refine=0"];
    undula(&place, "run cfd1 --threads 1 -o same", &coarse).expect(0, &["published", "featflow"]);
    undula(&place, "compare same", &[]).expect(0, &["published", "deviation"]);
    // Another fluid: no number beside it, but the key.
    let other = [coarse[0], "fluid.density=900"];
    let told = ["its problem is not `cfd1`", "fluid.density = 900.0 instead of 1000.0"];
    let said = undula(&place, "run cfd1 --threads 1 -o other", &other).expect(0, &told);
    assert!(!said.out.contains("published"), "{}", said.out);
    undula(&place, "compare other", &[]).expect(2, &told);
    // A case of one's own may have any name.
    let text = place.read("same/case.toml");
    assert!(text.contains("reference = \"cfd1\""), "{text}");
    place.write("cfd1.toml", &text.replace("reference = \"cfd1\"", ""));
    let said = undula(&place, "run cfd1.toml --threads 1 -o own", &[]).expect(0, &[]);
    assert!(!said.out.contains("published"), "{}", said.out);
    undula(&place, "compare own", &[]).expect(2, &["names no published results", "reference ="]);
    // `new` writes the reference; an unknown one is refused.
    undula(&place, "new cfd1 mine.toml", &[]).expect(0, &[]);
    assert!(place.read("mine.toml").contains("reference = \"cfd1\""));
    undula(&place, "check mine.toml", &["reference=cdf1"])
        .expect(2, &["no published results; did you mean `cfd1`"]);
    let resolved = undula(&place, "check mine.toml --toml", &[]).expect(0, &["reference = \"cfd1\""]);
    place.write("resolved.toml", &resolved.out);
    assert_eq!(undula(&place, "check resolved.toml --toml", &[]).out, resolved.out);
}

/// What flows in flows out; where nothing flows there is nothing to tell.
#[test]
fn the_flow_through_the_boundaries_balances() {
    let place = place("balance", &[]);
    let balance = |directory: &str| place.json(&format!("{directory}/summary.json"));
    undula(&place, "run cfd1 --threads 1 -o flow --quiet", &["mesh.refine=0"]).expect(0, &[]);
    let flow = balance("flow");
    assert!(flow["mass_balance"].as_f64().unwrap() < 1e-8 && flow["swept_volume"].is_null(), "{flow}");
    let still = ["mesh.refine=0", "time.step=0.02", "time.end=0.1"];
    undula(&place, "run csm3 --threads 1 -o still --quiet", &still).expect(0, &[]);
    assert_eq!(
        (&balance("still")["mass_balance"], &balance("still")["swept_volume"]),
        (&Value::Null, &Value::Null)
    );
    // A beam that falls: of second order in the step.
    let sizes = ["0.01", "0.005"].map(|step| {
        let step = format!("time.step={step}");
        let sets = [step.as_str(), "mesh.refine=0", "time.end=0.1", "solid.body-force=[0,-20]"];
        undula(&place, "run fsi3 --threads 1 -o beam --quiet --force", &sets).expect(0, &[]);
        let found = balance("beam");
        assert!(found["mass_balance"].as_f64().unwrap() < 1e-6, "{found}");
        found["swept_volume"].as_f64().unwrap()
    });
    assert!(sizes[0] < 1e-2 && sizes[0] / sizes[1] > 3.0, "{sizes:?}");
}

/// Equations that are not solved.
#[test]
fn a_flow_that_does_not_balance_is_told() {
    let place = place("unbalanced", &[]);
    let sets = [
        "mesh.refine=0",
        "time.step=0.01",
        "time.end=0.05",
        "solid.body-force=[0,-20]",
        "newton.tolerance=0.5",
    ];
    undula(&place, "run fsi3 --threads 1 -o out", &sets).expect(0, &["warning: the flow", "mass_balance"]);
    assert!(place.json("out/summary.json")["mass_balance"].as_f64().unwrap() > 1e-6);
}

/// The largest of all steps is that of a run which was not stopped.
#[test]
fn a_resumed_run_has_the_same_balance() {
    let place = place("balance-resumed", &[]);
    let sets = ["mesh.refine=0", "time.step=0.01", "solid.body-force=[0,-20]", "newton.tolerance=1e-4"];
    let until = |end: &'static str| [&sets[..], &[end]].concat();
    undula(&place, "run fsi3 --threads 1 -o straight --quiet", &until("time.end=0.08")).expect(0, &[]);
    undula(&place, "run fsi3 --threads 1 -o parts --quiet", &until("time.end=0.05")).expect(0, &[]);
    undula(&place, "run fsi3 --threads 1 -o parts --quiet --resume", &until("time.end=0.08")).expect(0, &[]);
    let [straight, parts] = ["straight", "parts"].map(|run| place.json(&format!("{run}/summary.json")));
    for key in ["mass_balance", "swept_volume"] {
        assert!(straight[key].as_f64().unwrap() > 0.0, "{straight}");
        close(parts[key].as_f64().unwrap(), straight[key].as_f64().unwrap(), 1e-3);
    }
}
