//! Published results: every built-in case has them, and they are set beside computed ones.

use undula::problem::builtin::builtin_cases;
use undula::problem::case::Case;
use undula::problem::compare::{compare, difference};
use undula::problem::reference::{References, Run};

#[test]
fn every_builtin_case_has_published_results() {
    for shipped in builtin_cases() {
        let references =
            References::from_toml(shipped.reference).unwrap_or_else(|e| panic!("{}: {e}", shipped.name));
        let case = Case::builtin(shipped.name, &[]).unwrap();
        assert_eq!(references.case, shipped.name);
        assert_eq!(References::builtin(shipped.name).as_ref(), Some(&references));
        for (name, published) in &references.results {
            assert!(case.functional.iter().any(|(n, _)| n == name), "{}: {name}", shipped.name);
            for entry in published {
                let numbers = entry.numbers.named();
                assert!(
                    numbers.iter().any(|(_, x)| x.is_some()),
                    "{}: {name}: {}",
                    shipped.name,
                    entry.source
                );
                assert!(!entry.source.is_empty());
                // A stationary case has one value, a periodic one has none.
                let periodic = case.time.is_some() && !["dfg-2d3", "rotor"].contains(&shipped.name);
                assert_eq!(entry.numbers.value.is_some(), !periodic && entry.numbers.max.is_none());
            }
        }
        assert!(references.results.len() >= if shipped.name == "rotor" { 1 } else { 2 });
    }
    let fsi3 = References::builtin("fsi3").unwrap();
    let drag = &fsi3.results["drag"][0];
    assert_eq!((drag.numbers.mean, drag.numbers.amplitude), (Some(460.5), Some(27.74)));
    assert_eq!(drag.uncertainty.amplitude, Some(0.05));
}

#[test]
fn mistakes_in_reference_files_are_refused() {
    for text in [
        "case = \"a\"\n[reference.drag]\nvalue = 1\n",
        "case = \"a\"\n[reference.drag]\nvalue = 1\nsource = \"b\"\nmeen = 1\n",
        "case = \"a\"\n[reference.drag]\nvalue = \"1\"\nsource = \"b\"\n",
        "[reference]\n",
    ] {
        assert!(References::from_toml(text).is_err(), "{text}");
    }
}

const SUMMARY: &str = r#"{"status": "completed", "case": "fsi3", "version": "1", "functionals": {
    "drag": {"last": 470.0, "mean": 458.197, "amplitude": 27.74, "frequency": 10.9, "unit": "N/m"},
    "lift": {"last": 70.0, "mean": 18.0, "amplitude": 150.0, "frequency": null, "unit": "N/m"},
    "energy": {"last": 1.5, "mean": null, "amplitude": null, "frequency": null, "unit": "J/m"}}}"#;

#[test]
fn a_run_is_set_beside_the_published_results() {
    let run = Run::from_json(SUMMARY).unwrap();
    let mut references = References::builtin("fsi3").unwrap();
    for published in references.results.values_mut() {
        published.truncate(2);
    }
    references.results.remove("ux_A");
    let comparison = compare(&run, &references);
    let first = &comparison.rows[0];
    assert!((first.deviation.unwrap() + 0.005_001).abs() < 1e-6);
    assert!(first.primary && first.uncertainty == Some(0.01));
    // The mean of the lift is small beside its amplitude.
    let lift = comparison.rows.iter().find(|r| r.functional == "lift" && r.quantity == "mean").unwrap();
    assert!((lift.deviation.unwrap() - 15.5 / 153.91).abs() < 1e-12);
    let expected = "\
fsi3: completed

functional             unit  computed  published  deviation  uncertainty  source
drag        mean       N/m    458.197      460.5   -0.500 %          1 %  featflow 4+0, dt = 2.5e-4
                                           459.1   -0.197 %               featflow 3+0, dt = 2.5e-4
            amplitude  N/m    27.7400      27.74   +0.000 %          5 %  featflow 4+0, dt = 2.5e-4
                                            26.5   +4.679 %               featflow 3+0, dt = 2.5e-4
            frequency  Hz     10.9000      10.93   -0.274 %          1 %  featflow 4+0, dt = 2.5e-4
lift        mean       N/m    18.0000        2.5  +10.071 %               featflow 4+0, dt = 2.5e-4
                                            2.36  +10.433 %               featflow 3+0, dt = 2.5e-4
            amplitude  N/m    150.000     153.91   -2.540 %          4 %  featflow 4+0, dt = 2.5e-4
                                          149.91   +0.060 %               featflow 3+0, dt = 2.5e-4
            frequency  Hz           -       5.46          -          1 %  featflow 4+0, dt = 2.5e-4
uy_A        mean       m            -    0.00147          -               featflow 4+0, dt = 2.5e-4
                                         0.00143          -               featflow 3+0, dt = 2.5e-4
            amplitude  m            -    0.03499          -          2 %  featflow 4+0, dt = 2.5e-4
                                         0.03443          -               featflow 3+0, dt = 2.5e-4
            frequency  Hz           -       5.46          -          1 %  featflow 4+0, dt = 2.5e-4
                                            5.46          -               featflow 3+0, dt = 2.5e-4

Deviations of a mean are relative to the amplitude where that is larger.

Without published values: energy
";
    assert_eq!(comparison.to_string(), expected, "\n{comparison}");
}

#[test]
fn extrema_come_from_the_history() {
    let mut run = Run::from_json(
        r#"{"case": "dfg-2d3", "status": "completed", "functionals": {"c_D": {"last": 0.1, "unit": ""}}}"#,
    )
    .unwrap();
    run.add_history("step,time,c_D,other\n1,0.1,2.0,5\n2,0.2,2.95,x\n3,0.3,-0.5,\n");
    let numbers = run.functionals["c_D"].numbers;
    assert_eq!((numbers.min, numbers.max), (Some(-0.5), Some(2.95)));
    let comparison = compare(&run, &References::builtin("dfg-2d3").unwrap());
    assert!(comparison.rows[0].deviation.unwrap().abs() < 1e-3);
    assert!(comparison.rows[0].source.contains("at t = 3.93625 s"));
}

#[test]
fn two_runs_are_set_beside_each_other() {
    let first = Run::from_json(SUMMARY).unwrap();
    let mut second = first.clone();
    second.functionals.remove("energy");
    if let Some(drag) = second.functionals.get_mut("drag") {
        drag.numbers.amplitude = Some(27.7677);
    }
    let expected = "\
functional             unit     fsi3     fsi3  deviation
drag        value      N/m   470.000  470.000   +0.000 %
            mean       N/m   458.197  458.197   +0.000 %
            amplitude  N/m   27.7400  27.7677   +0.100 %
            frequency  Hz    10.9000  10.9000   +0.000 %
lift        value      N/m   70.0000  70.0000   +0.000 %
            mean       N/m   18.0000  18.0000   +0.000 %
            amplitude  N/m   150.000  150.000   +0.000 %

Only in one of them: energy
";
    let told = difference(&first, &second).to_string();
    assert_eq!(told, expected, "\n{told}");
}
