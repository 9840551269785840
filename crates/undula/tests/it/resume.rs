//! A run that was stopped and goes on repeats the bits of one that was not, with every scheme in time.

use crate::common::{SCHEMES, builtin};
use std::fs;
use std::path::{Path, PathBuf};
use undula::output::{Checkpoint, Status};
use undula::run::{Flow, Observer, RunOptions, restore_latest, run};
use undula::simulation::{Memory, Row, Simulation};

/// Stops after some step.
struct StopAfter(u64);

impl Observer for StopAfter {
    fn after_step(&mut self, _: &Simulation, row: &Row) -> Flow {
        if row.step == self.0 { Flow::Stop } else { Flow::Continue }
    }
}

/// Few cells, a beam that moves.
const SMALL: [&str; 4] = ["mesh.refine=0", "time.step=0.01", "time.end=0.12", "solid.body-force=[0,-2]"];

fn compute(directory: &Path, sets: &[&str], resume: bool, stop: u64) -> Status {
    let case = builtin("fsi3", &[&SMALL[..], sets].concat());
    let options = RunOptions { directory: directory.into(), threads: 1, force: true, resume, commit: None };
    run(case, &options, &mut StopAfter(stop)).unwrap().status
}

fn place_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("resume-{name}"))
}

fn place(name: &str) -> PathBuf {
    let path = place_of(name);
    let _ = fs::remove_dir_all(&path);
    path
}

/// History and last state of a run without stop, and of runs stopped after the steps `stops`.
fn check(name: &str, sets: &[&str], stops: &[u64]) -> String {
    let whole = place(&format!("{name}-whole"));
    assert_eq!(compute(&whole, sets, false, 0), Status::Completed);
    let result = |directory: &Path| {
        let history = fs::read_to_string(directory.join("history.csv")).unwrap();
        let latest = Checkpoint::load_latest(directory.join("checkpoints")).unwrap().unwrap();
        (history, latest.checkpoint.arrays)
    };
    let expected = result(&whole);
    for &stop in stops {
        let parts = place(&format!("{name}-parts"));
        assert_eq!(compute(&parts, sets, false, stop), Status::Interrupted);
        assert_eq!(compute(&parts, sets, true, 0), Status::Completed);
        let found = result(&parts);
        assert_eq!(found.0, expected.0, "{name}, stopped after step {stop}");
        assert!(found.1 == expected.1, "{name}, stopped after step {stop}: the last states differ");
    }
    expected.0
}

/// Counts the rows in memory.
struct Most(usize);

impl Observer for Most {
    fn after_step(&mut self, simulation: &Simulation, _: &Row) -> Flow {
        self.0 = self.0.max(simulation.history.len());
        Flow::Continue
    }
}

#[test]
fn a_run_keeps_few_rows_and_its_summary_knows_all_of_them() {
    let case = || builtin("csm3", &["mesh.refine=0", "time.step=0.02", "time.end=7"]);
    let mut memory = Simulation::new(case(), 1).unwrap();
    while !memory.finished() {
        memory.step().unwrap();
    }
    assert_eq!(memory.history.len(), 350);
    let directory = place("rows");
    let options =
        RunOptions { directory: directory.clone(), threads: 1, force: true, resume: false, commit: None };
    let mut most = Most(0);
    let summary = run(case(), &options, &mut most).unwrap();
    assert!(most.0 <= 256, "{} rows in memory", most.0);
    assert_eq!(summary.functionals, memory.statistics());
    assert!(summary.functionals["uy_A"].frequency.is_some(), "one that needs more than the last rows");
    let later = builtin("csm3", &["mesh.refine=0", "time.step=0.02", "time.end=7.1"]);
    let summary = run(later, &RunOptions { resume: true, ..options }, &mut most).unwrap();
    for _ in 0..5 {
        memory.case.time.as_mut().unwrap().end = 7.1;
        memory.step().unwrap();
    }
    assert_eq!(summary.functionals, memory.statistics());
}

#[test]
#[ignore = "long"]
fn every_scheme_resumes_with_the_same_bits() {
    for scheme in SCHEMES.iter().filter(|scheme| !scheme.ends_with("rannacher")) {
        check(scheme.rsplit('=').next().unwrap(), &[scheme], &[1, 7]);
    }
    check("midpoint", &["time.domain-motion=midpoint"], &[7]);
    check("newton", &["time.scheme=bdf2", "newton.linearization=newton"], &[2]);
}

/// Factors that are older than the step, of the condensed matrix and of the whole one, and of another part of a step.
#[test]
fn gmres_resumes_with_the_same_bits() {
    for (name, set) in [
        ("gmres-condensed", "newton.linearization=condensed"),
        ("gmres-newton", "newton.linearization=newton"),
        ("gmres-parts", "time.scheme=fractional-step-theta"),
    ] {
        check(name, &[set, "linear.krylov=gmres", "time.step=0.005", "time.end=0.04"], &[5]);
    }
}

/// Stops after some step, and remembers what there is to remember then.
struct Witness(u64, Option<Memory>);

impl Observer for Witness {
    fn after_step(&mut self, simulation: &Simulation, row: &Row) -> Flow {
        if row.step == self.0 {
            self.1 = Some(simulation.save());
            return Flow::Stop;
        }
        Flow::Continue
    }
}

/// What a run remembers after the step `stop`, which a checkpoint must give back to a new simulation.
fn remembered(name: &str, sets: &[&str], stop: u64) -> Memory {
    let (directory, case) = (place(name), || builtin("fsi3", &[&SMALL[..], sets].concat()));
    let options = RunOptions { directory, threads: 1, force: true, resume: false, commit: None };
    let mut witness = Witness(stop, None);
    run(case(), &options, &mut witness).unwrap();
    let expected = witness.1.unwrap();
    let mut simulation = Simulation::new(case(), 1).unwrap();
    restore_latest(&mut simulation, &options.directory).unwrap();
    let found = simulation.save();
    assert!(found.stepper.point == expected.stepper.point, "{name}: another Jacobian");
    let scalars = |m: &Memory| (m.steps, m.stepper.clock, m.stepper.newton, m.stepper.detour, m.balance);
    assert_eq!(scalars(&found), scalars(&expected), "{name}");
    assert!(found == expected, "{name}: other solutions, or another past");
    expected
}

/// Every piece of memory is there in one of the runs.
#[test]
fn a_checkpoint_forgets_nothing() {
    let kept = remembered("memory-kept", &["time.step=0.005"], 9);
    let point = kept.stepper.point.unwrap();
    assert!(point.age.solves > 0 && point.age.iterations > 0 && point.age.last > 0, "{:?}", point.age);
    assert!(kept.stepper.newton.worsening > 1.0, "{:?}", kept.stepper.newton);
    assert!(kept.steps == 9 && kept.stepper.new != kept.stepper.old && kept.balance.is_some());
    let seconds = kept.stepper.newton.seconds;
    assert!([seconds.assembly, seconds.factorization, seconds.solve].iter().all(|&s| s > 0.0), "{seconds:?}");
    let counters = kept.stepper.newton.counters;
    assert!(counters.factorizations > 0 && counters.linear_iterations > 0, "{counters:?}");

    let damped = ["time.scheme=rannacher", "time.rannacher-interval=0.05"];
    let damping = remembered("memory-damping", &damped, 6).stepper.clock.damping;
    assert!(damping.interval > 0 && damping.left > 0, "{damping:?}");

    let strict = ["newton.rate-max=0", "newton.max-steps=2"];
    let detour = remembered("memory-detour", &strict, 3).stepper.detour;
    assert!(detour > 0, "no detour");

    let steered =
        ["time.step=0.004", "time.adaptive.tolerance=1e-3", "time.adaptive.min-step=0.001", "time.end=0.1"];
    let adaptive = remembered("memory-adaptive", &steered, 14).adaptive.unwrap();
    assert!(adaptive.past.len() == 3 && adaptive.rejected > 0, "{} rejected", adaptive.rejected);
}

/// Before, within and after the damping steps.
#[test]
fn rannacher_resumes_within_its_damping_steps() {
    check("rannacher", &["time.scheme=rannacher", "time.rannacher-interval=0.05"], &[1, 5, 6, 7]);
}

/// With its past, wherever it stands; fields and steps land on their times.
#[test]
#[ignore = "long"]
fn step_size_control_resumes_with_the_same_bits() {
    for scheme in ["shifted-crank-nicolson", "bdf2", "fractional-step-theta", "esdirk3", "esdirk4"] {
        let scheme = format!("time.scheme={scheme}");
        let sets = [
            &scheme,
            "time.step=0.004",
            "time.adaptive.tolerance=1e-3",
            "time.adaptive.min-step=0.001",
            "time.end=0.1",
            "output.fields-interval=0.025",
            "output.fields-every=0",
            "solid.body-force=[0,0]",
        ];
        let history = check(&format!("adaptive-{}", &scheme[12..]), &sets, &[1, 3, 7]);
        let times: Vec<f64> =
            history.lines().skip(1).map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
        for output in [0.025, 0.05, 0.075, 0.1] {
            assert!(times.contains(&output), "{scheme}: {output} in {times:?}");
        }
        let directory =
            Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("resume-adaptive-{}-whole", &scheme[12..]));
        // The start, and four times.
        assert_eq!(fs::read_dir(directory.join("fields")).unwrap().count(), 5);
        let summary = fs::read_to_string(directory.join("summary.json")).unwrap();
        assert!(summary.contains("\"rejected_steps\""), "{summary}");
    }
}

/// Means over a window go on with the same bits, and so do field files at given times.
#[test]
fn means_over_a_window_resume_with_the_same_bits() {
    let sets = ["output.window=[0.02,0.05]", "output.fields-times=[0.014,0.037]", "time.end=0.06"];
    let adaptive = ["time.adaptive.tolerance=1e-3", "time.adaptive.min-step=0.005"];
    for (name, more) in [("window", &[][..]), ("window-adaptive", &adaptive)] {
        check(name, &[&sets, more].concat(), &[1, 4]);
        let read = |part: &str, file: &str| {
            let path =
                Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("resume-{name}-{part}")).join(file);
            fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        };
        for file in ["mean.vtu", "fields.pvd"] {
            assert!(read("whole", file) == read("parts", file), "{name}: {file}");
        }
    }
}

/// Checkpoints have the shape without stress, a run from another one takes it over, and neither mixes with runs without.
#[test]
fn a_prestress_resumes_with_the_same_bits() {
    let more = ["solid.prestress=true"];
    check("prestress", &more, &[2]);
    let kept = remembered("memory-prestress", &more, 3);
    let largest = kept.unloading.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    assert!(largest > 1e-3, "{largest}");
    let from = format!("initial.from={}", place_of("memory-prestress").display());
    let next = |more: &[&str]| Simulation::new(builtin("fsi3", &[&SMALL[..], &[&from], more].concat()), 1);
    assert_eq!(next(&more).unwrap().save().unloading, kept.unloading);
    let message = |more: &[&str]| next(more).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(
        message(&[]).contains("the run has a prestress: expected solid.prestress = true"),
        "{}",
        message(&[])
    );
    let finer = message(&["solid.prestress=true", "mesh.refine=1"]);
    assert!(finer.contains("on the same mesh"), "{finer}");
}
