//! What a step costs.

use super::{Place, SMALL};
use serde_json::Value;

const COARSE: [&str; 1] = ["mesh.refine=0"];

#[test]
#[ignore = "long"]
fn the_report_keeps_its_contract() {
    let here = Place::new("bench");
    let said = here.run("bench fsi3 --steps 2 --repeat 1 --threads 1", &COARSE);
    let said = said.expect(0, &["iterations", "factor_single", "Gflop/s"]);
    let report: Value = serde_json::from_str(&said.out).unwrap();
    for key in "version processor threads lanes case cells unknowns scheme step linearization solver precision newton \
                steps kernels machine peak_memory_bytes"
        .split_whitespace()
    {
        assert!(report.get(key).is_some(), "{key}");
    }
    assert_eq!((&report["case"], &report["threads"]), (&"fsi3".into(), &1.into()));
    assert_eq!((&report["linearization"], &report["precision"]), (&"condensed".into(), &"single".into()));
    let steps = &report["steps"];
    assert_eq!((&steps["steps"], &steps["from"], &steps["to"]), (&2.into(), &0.0.into(), &0.01.into()));
    let part = |name: &str| steps["phases"][name].as_f64().unwrap_or_else(|| panic!("{name}"));
    let sum: f64 = ["assembly", "factorization", "solve", "functionals"].map(part).iter().sum();
    assert!((sum / part("wall") - 1.0).abs() < 1e-9, "{steps}");
    assert!(steps["newton_steps"].as_f64() > Some(0.0) && steps["jacobians"].as_f64() > Some(0.0));
    let kernels = "residual explicit condensed_dual condensed_by_hand eliminate_inner recover_inner jacobian_dual \
                   jacobian_by_hand jacobian_differences analyse factor_single factor_double apply_single apply_double \
 factor_extension apply_extension";
    for name in kernels.split_whitespace() {
        assert!(report["kernels"][name]["seconds"].as_f64() > Some(0.0), "{name}");
    }
    for name in ["triad", "read"] {
        assert!(report["machine"][name]["one_thread"].as_f64() > Some(0.0), "{name}");
    }
}

#[test]
#[ignore = "long"]
fn a_run_is_where_the_steps_start() {
    let here = Place::new("bench-from");
    here.run("run fsi3 -o results --quiet", &SMALL).expect(0, &[]);
    let history = here.read("results/history.csv");
    let line = "bench --from results --steps 2 --repeat 2 --no-kernels --quiet -o report.json";
    let said = here.run(line, &["linear.precision=double"]).expect(0, &[]);
    assert!(said.out.is_empty() && said.err.is_empty(), "{said:?}");
    let report = here.json("report.json");
    let steps = &report["steps"];
    // Beyond the end of the run.
    assert_eq!((&steps["after"], &steps["from"], &steps["to"]), (&5.into(), &0.05.into(), &0.07.into()));
    assert_eq!((&report["precision"], &report["kernels"]), (&"double".into(), &Value::Null));
    assert_eq!(here.read("results/history.csv"), history);
    let said = here.run("bench --from results --steps 0 --quiet", &[]).expect(0, &[]);
    let report: Value = serde_json::from_str(&said.out).unwrap();
    assert!(report["steps"].is_null() && report["kernels"]["residual"]["calls"].as_u64() >= Some(11));
    here.run("bench --from results --steps 1", &["mesh.refine=1"]).expect(2, &["new_v should have"]);
}

#[test]
fn wrong_directories_and_cases_are_refused() {
    let here = Place::new("bench-wrong");
    here.run("bench --from nowhere", &[])
        .expect(2, &["nowhere", "case.toml is missing", "the output directory of `undula run`"]);
    here.run("bench --from nowhere fsi3", &[]).expect(2, &["cannot be used with"]);
    here.run("bench --repeat 0", &[]).expect(2, &["--repeat"]);
    here.run("bench fsi33", &[]).expect(2, &["did you mean `fsi3`?"]);
    here.run("bench fsi1 --steps 1", &COARSE).expect(2, &["`fsi1` is stationary", "with time steps"]);
    here.run("bench -o .", &COARSE).expect(2, &["-o .: this is a directory"]);
    // A run that has not come to its first checkpoint.
    std::fs::create_dir(here.file("early")).unwrap();
    here.run("new fsi3 early/case.toml", &[]).expect(0, &[]);
    here.run("bench --from early", &COARSE).expect(2, &["early holds none", "a run that has written one"]);
}
