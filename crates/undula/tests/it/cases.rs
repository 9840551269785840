//! Every built-in case of the plane, shortened (those of space are run by `crates/undula-cli/tests/cli/space_cases.rs`): the functionals are those stored in `tests/cases.stored`.
//!
//! After a change that is meant to change numbers, `UNDULA_STORE=1 cargo test --test it cases` writes the
//! file anew; its difference belongs into the commit, and into the reasons given there.

use crate::common::builtin;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::Mutex;
use undula::case::builtin::builtin_cases;
use undula::results::reference::References;
use undula::simulation::Simulation;

/// Cases, what is changed in them, and how far their functionals may be from the published ones at this
/// resolution; `None` where the run is too short to have reached what is published.
const RUNS: [(&str, &[&str], Option<f64>); 19] = [
    ("cfd1", &["mesh.refine=1"], Some(0.01)),
    ("cfd2", &["mesh.refine=1"], Some(0.06)),
    ("cfd3", &["mesh.refine=0", "time.step=0.02", "time.end=0.2"], None),
    ("csm1", &["mesh.refine=1"], Some(0.01)),
    ("csm2", &["mesh.refine=1"], Some(0.01)),
    ("csm3", &["mesh.refine=0", "time.step=0.02", "time.end=0.4"], None),
    ("fsi1", &["mesh.refine=1"], Some(0.01)),
    ("fsi2", &["mesh.refine=0", "time.step=0.02", "time.end=0.2"], None),
    ("fsi3", &["mesh.refine=0", "time.step=0.02", "time.end=0.2"], None),
    ("dfg-2d1", &["mesh.refine=1"], Some(0.015)),
    ("dfg-2d2", &["mesh.refine=0", "time.step=0.02", "time.end=0.2"], None),
    ("dfg-2d3", &["mesh.refine=0", "time.step=0.04", "time.end=0.4"], None),
    ("rotor", &["mesh.refine=0", "time.step=0.1", "time.end=1"], None),
    ("flap", &["time.step=0.02"], Some(0.02)),
    ("cavity", &["mesh.refine=0", "time.step=0.1", "time.end=2"], None),
    ("tube-2d", &["mesh.refine=0", "time.step=2e-4", "time.end=2e-3"], None),
    ("cylinder", &["mesh.cells=[12,2]", "time.step=0.05", "time.end=0.5"], None),
    ("pump", &["mesh.cells=[20,1]", "time.step=1", "time.end=10"], None),
    ("valve", &["time.step=0.04", "time.end=0.4"], None),
];

/// The last values by functional, with their units.
type Values = BTreeMap<String, (f64, &'static str)>;

fn run(name: &str, overrides: &[&str]) -> Values {
    // Solved far below what is compared, whatever way Newton's method takes.
    let case = builtin(name, &[overrides, &["newton.tolerance=1e-11"]].concat());
    let mut simulation = Simulation::new(case, 1).unwrap_or_else(|e| panic!("{name}: {e}"));
    while !simulation.finished() {
        simulation.step().unwrap_or_else(|e| panic!("{name}: {e}"));
    }
    let values = &simulation.history.last().unwrap().values;
    let units = simulation.units();
    simulation.names().into_iter().zip(values.iter().copied().zip(units)).collect()
}

/// Two at a time.
fn run_all() -> BTreeMap<&'static str, Values> {
    let queue: Mutex<VecDeque<_>> = Mutex::new(RUNS.iter().collect());
    let done = Mutex::new(BTreeMap::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some((name, overrides, _)) = queue.lock().unwrap().pop_front() else { return };
                    let values = run(name, overrides);
                    done.lock().unwrap().insert(*name, values);
                }
            });
        }
    });
    done.into_inner().unwrap()
}

#[test]
fn shortened_cases_give_the_stored_numbers() {
    let mut plane: Vec<&str> = builtin_cases().iter().map(|c| c.name).collect();
    plane.retain(|name| builtin(name, &[]).mesh.dimension == 2);
    assert_eq!(RUNS.map(|run| run.0).to_vec(), plane);
    let found = run_all();
    let mut table =
        String::from("# case functional value unit; written by UNDULA_STORE=1 cargo test --test it cases\n");
    for (name, _, tolerance) in RUNS {
        for (functional, (value, unit)) in &found[name] {
            table += format!("{name} {functional} {value:e} {unit}").trim_end();
            table.push('\n');
            assert!(value.is_finite(), "{name} {functional}");
            let Some(tolerance) = tolerance else { continue };
            let references = References::builtin(name).unwrap();
            let published = references.results.get(functional).and_then(|list| list[0].numbers.value);
            let Some(published) = published else { continue };
            let deviation = (value / published - 1.0).abs();
            assert!(deviation < tolerance, "{name} {functional}: {value}, published {published}");
        }
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases.stored");
    if std::env::var_os("UNDULA_STORE").is_some() {
        std::fs::write(&file, table).unwrap();
        return;
    }
    let stored = std::fs::read_to_string(&file).unwrap();
    let mut wrong = vec![];
    let mut count = 0;
    for line in stored.lines().filter(|line| !line.starts_with('#')) {
        let words: Vec<&str> = line.split(' ').collect();
        let (values, stored) = (&found[words[0]], words[2].parse::<f64>().unwrap());
        let (value, unit) = values[words[1]];
        // Beside a drag, a lift that has hardly begun is rounding.
        let largest = values.values().filter(|(_, u)| *u == unit).fold(0.0, |m: f64, (x, _)| m.max(x.abs()));
        if (value - stored).abs() > 1e-6 * stored.abs() + 1e-9 * largest {
            wrong.push(format!("{line}: now {value:e}"));
        }
        count += 1;
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    assert_eq!(
        count,
        found.values().map(BTreeMap::len).sum::<usize>(),
        "run with UNDULA_STORE=1 for new ones"
    );
}
