//! Published results: every built-in case has them, and they are set beside computed ones.

use undula::case::Case;
use undula::case::builtin::builtin_cases;
use undula::output::{FunctionalSummary, History, Status, Summary};
use undula::results::compare::{compare, difference};
use undula::results::computed::Results;
use undula::results::reference::{Beside, References};

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
                let periodic =
                    case.time.is_some() && !["dfg-2d3", "rotor", "flap", "tube-2d"].contains(&shipped.name);
                let extreme = entry.numbers.max.is_some() || entry.numbers.min.is_some();
                assert_eq!(entry.numbers.value.is_some(), !periodic && !extreme);
            }
        }
        assert!(
            references.results.len()
                >= if [
                    "rotor", "flap", "cavity", "tube-2d", "cylinder", "pump", "valve", "cook", "tube", "land"
                ]
                .contains(&shipped.name)
                {
                    1
                } else {
                    2
                }
        );
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

/// A run of fsi3 without a history, so that the numbers are those of the summary.
fn summarized() -> Results {
    let one = |last, [mean, amplitude, frequency]: [Option<f64>; 3], unit: &str| FunctionalSummary {
        last,
        mean,
        amplitude,
        frequency,
        unit: unit.into(),
    };
    let functionals = [
        ("drag", one(470.0, [Some(458.197), Some(27.74), Some(10.9)], "N/m")),
        ("lift", one(70.0, [Some(18.0), Some(150.0), None], "N/m")),
        ("energy", one(1.5, [None; 3], "J/m")),
    ];
    let functionals = functionals.into_iter().map(|(name, f)| (name.to_string(), f)).collect();
    let summary =
        Summary { status: Status::Completed, case: "fsi3".into(), functionals, ..Summary::default() };
    Results { name: "out/fsi3".into(), summary, ..Results::default() }
}

/// A run with the functional `name` at `times`.
fn computed(directory: &str, name: &str, times: &[f64], value: impl Fn(f64) -> f64) -> Results {
    let functionals = [(name.to_string(), FunctionalSummary::default())].into();
    let columns = ["step", "time", name].map(String::from).to_vec();
    let rows = times.iter().zip(1..).map(|(&t, n)| vec![f64::from(n), t, value(t)]).collect();
    let history = History { columns, rows };
    Results {
        name: directory.into(),
        summary: Summary { functionals, ..Summary::default() },
        history,
        case: None,
    }
}

#[test]
fn a_run_is_set_beside_the_published_results() {
    let run = summarized();
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
    let run = computed("out", "c_D", &[0.1, 0.2, 0.3], |t| if t == 0.2 { 2.95 } else { 2.0 - 10.0 * t });
    let numbers = run.computed()["c_D"].numbers;
    assert_eq!((numbers.min, numbers.max), (Some(-1.0), Some(2.95)));
    let comparison = compare(&run, &References::builtin("dfg-2d3").unwrap());
    assert!(comparison.rows[0].deviation.unwrap().abs() < 1e-3);
    assert!(comparison.rows[0].source.contains("at t = 3.93625 s"));
}

#[test]
fn two_runs_are_set_beside_each_other() {
    let first = summarized();
    let mut second = Results { name: "out/fine".into(), ..first.clone() };
    second.summary.functionals.remove("energy");
    if let Some(drag) = second.summary.functionals.get_mut("drag") {
        drag.amplitude = Some(27.7677);
    }
    let expected = "\
functional             unit  out/fsi3  out/fine  deviation
drag        value      N/m    470.000   470.000   +0.000 %
            mean       N/m    458.197   458.197   +0.000 %
            amplitude  N/m    27.7400   27.7677   +0.100 %
            frequency  Hz     10.9000   10.9000   +0.000 %
lift        value      N/m    70.0000   70.0000   +0.000 %
            mean       N/m    18.0000   18.0000   +0.000 %
            amplitude  N/m    150.000   150.000   +0.000 %

Only in one of them: energy
";
    let told = difference(&first, &second).unwrap().to_string();
    assert_eq!(told, expected, "\n{told}");
}

/// One ends earlier and takes longer steps; what the other does later is another motion.
#[test]
fn runs_are_compared_over_the_time_that_both_have() {
    let motion = |t: f64| {
        let turns = std::f64::consts::TAU * t;
        if t < 4.02 { 3.0 + turns.sin() } else { 9.0 + 5.0 * (0.3 * turns).sin() }
    };
    let times = |k: f64, n: i32| -> Vec<f64> { (1..=n).map(|i| k * f64::from(i)).collect() };
    let short = computed("out/short", "uy", &times(0.03, 133), motion);
    let long = computed("out/long", "uy", &times(0.01, 1000), motion);
    let found = difference(&short, &long).unwrap();
    assert_eq!(found.names, ["out/short", "out/long"]);
    let (start, end) = found.common.unwrap();
    assert!((start - 0.03).abs() < 1e-12 && (end - 3.99).abs() < 1e-12, "{start} {end}");
    for (quantity, right, within) in [
        ("value", motion(3.99), 1e-9),
        ("mean", 3.0, 1e-3),
        ("amplitude", 1.0, 1e-3),
        ("frequency", 1.0, 1e-3),
    ] {
        let row = found.rows.iter().find(|row| row.quantity == quantity).unwrap();
        assert!(row.values.iter().all(|x| (x - right).abs() < within), "{row:?}");
    }
    let told = found.to_string();
    assert!(told.starts_with("From 0.03 s to 3.99 s, which both runs have:"), "{told}");
    let later: Vec<f64> = times(0.01, 10).iter().map(|t| t + 20.0).collect();
    assert_eq!(difference(&short, &computed("out/late", "uy", &later, motion)), None);
}

/// Published values are those of one problem.
#[test]
fn published_values_stand_beside_the_same_problem_only() {
    let beside = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
        Beside::of(&Case::builtin("fsi3", &overrides).unwrap())
    };
    let same = [
        &[][..],
        &[
            "mesh.refine=2",
            "mesh.grading=1",
            "time.step=0.01",
            "motion.model=biharmonic",
            "space.velocity=Q3",
        ],
        &["functional.drag.method=surface-integral", "functional.own.kind=rotation"],
        &[
            "boundary.inflow.velocity=[\"1.5*2.0*y * (0.41-y)/(0.41/2)^2*ramp(t,2)\", 0.0]",
            "fluid.density=1e3",
        ],
    ];
    for overrides in same {
        let Beside::Results(references, left_out) = beside(overrides) else { panic!("{overrides:?}") };
        assert_eq!((references.results.len(), left_out.len()), (4, 0), "{overrides:?}");
    }
    let others = [
        ("fluid.density=900", "fluid.density = 900.0 instead of 1000.0"),
        ("solid=none", "[solid] is missing"),
        ("solid.mu=1e6", "solid.mu = 1000000.0 instead of 2000000.0"),
        ("solid.body-force=[0,-2]", "solid.body-force = [0.0,-2.0] instead of [0.0,0.0]"),
        ("boundary.outflow.condition=traction-free", "boundary.outflow.condition"),
        ("mesh.generator=schaefer-turek", "mesh.generator = \"schaefer-turek\" instead of \"turek-hron\""),
    ];
    for (overrides, told) in others {
        let Beside::Departs("fsi3", keys) = beside(&[overrides]) else { panic!("{overrides}") };
        assert!(keys.iter().any(|key| key.to_string().starts_with(told)), "{overrides}: {keys:?}");
    }
    // The force on another boundary is not the published one.
    let Beside::Results(references, left_out) = beside(&["functional.drag.on=[\"cylinder\"]"]) else {
        panic!()
    };
    assert!(!references.results.contains_key("drag") && references.results.contains_key("lift"));
    assert_eq!(left_out[0].key, "functional.drag.on");
    assert_eq!(beside(&["reference=none"]), Beside::Nothing);
    let wrong = Case::builtin("fsi3", &["reference=fsi4".into()]).unwrap_err().to_string();
    assert!(wrong.contains("no published results; did you mean `fsi"), "{wrong}");
}
