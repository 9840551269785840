//! One run by several processes, started by `mpirun` where that is there and PETSc too: numbers, files, and what goes
//! wrong on some of them.

use super::engines::{LAYER, PETSC, TIGHT, is_near, is_there};
use super::in_space::FLAP;
use super::{Place, Said};
use std::fs;
use std::process::Command;

/// Whether the machine can; says so if not.
fn can() -> bool {
    let there = Command::new("mpirun").arg("--version").output().is_ok_and(|said| said.status.success());
    if !there {
        println!("skipped: there is no mpirun");
    }
    there && is_there()
}

/// `mpirun`, about to start programs here.
fn mpirun(here: &Place) -> Command {
    let mut command = Command::new("mpirun");
    command.arg("--oversubscribe").current_dir(here.file("."));
    // In containers of tests everybody is root.
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command
}

/// Several programs: of each the number of processes, the arguments, and the settings.
fn together(here: &Place, programs: &[(usize, &str, &[&str])]) -> Said {
    let mut command = mpirun(here);
    for (i, (n, arguments, sets)) in programs.iter().enumerate() {
        command.args((i > 0).then_some(":")).args(["-n", &n.to_string()]);
        command.arg(env!("CARGO_BIN_EXE_undula")).args(arguments.split_whitespace());
        command.args(sets.iter().flat_map(|set| ["--set", set]));
    }
    Said::of(command.output().unwrap())
}

/// A process in each of two directories, which do not see the same files.
fn apart(here: &Place, directories: [&str; 2], arguments: &str, sets: &[&str]) -> Said {
    let mut command = mpirun(here);
    for (i, directory) in directories.iter().enumerate() {
        command.args((i > 0).then_some(":")).args([
            "-n",
            "1",
            "-wdir",
            here.file(directory).to_str().unwrap(),
        ]);
        command.arg(env!("CARGO_BIN_EXE_undula")).args(arguments.split_whitespace());
        command.args(sets.iter().flat_map(|set| ["--set", set]));
    }
    Said::of(command.output().unwrap())
}

/// Lines of the program: `mpirun` adds some of its own where a process ends with an error.
fn own_lines(said: &Said, of: &str) -> usize {
    said.err.lines().filter(|line| line.contains(of)).count()
}

#[test]
fn several_processes_compute_what_one_computes() {
    if !can() {
        return;
    }
    let here = Place::new("several-same");
    here.write("flap.toml", FLAP);
    for space in [&[][..], &[LAYER]] {
        let sets = [&TIGHT[..], space].concat();
        let own = here.rows("flap.toml", &sets);
        for (n, more) in [
            (2, &[][..]),
            (3, &["newton.linearization=newton"]),
            (2, &["linear.petsc.options=-ksp_type fgmres -ksp_rtol 1e-8 -pc_type asm -sub_pc_type ilu"]),
        ] {
            // Blocks of the processes alone are too weak for the whole Jacobian in space.
            let sets = [&sets[..], &[PETSC], more].concat();
            let said = together(&here, &[(n, "run flap.toml --quiet --force -o several", &sets)]);
            said.expect(0, &[]);
            is_near(&own, &here.rows_of("several"), &sets);
        }
    }
    let summary = here.json("several/summary.json");
    assert_eq!((&summary["status"], &summary["processes"]), (&"completed".into(), &2.into()));
    assert!(summary["engine"].as_str().is_some_and(|engine| engine.starts_with("PETSc 3.")), "{summary}");
}

#[test]
fn one_process_writes_and_a_run_goes_on_with_others() {
    if !can() {
        return;
    }
    let here = Place::new("several-resume");
    here.write("flap.toml", FLAP);
    let run = |n: usize, arguments: &str, sets: &[&str]| together(&here, &[(n, arguments, sets)]);
    let [first, more] = ["time.end=0.02", "time.end=0.04"];
    let said = run(2, "run flap.toml -o out", &[first]).expect(0, &["linear.engine: PETSc"]);
    assert_eq!(own_lines(&said, "unknowns (velocity"), 1, "{}", said.err);
    run(2, "run flap.toml -o out", &[first]).expect(2, &["holds a completed run; use --force"]);
    run(2, "run flap.toml -o out --resume --quiet", &[more]).expect(0, &[]);
    run(3, "run flap.toml -o at-once --quiet", &[more]).expect(0, &[]);
    is_near(&here.rows_of("at-once"), &here.rows_of("out"), &[more]);
    // The last step was shortened: a longer run goes on from the one before.
    run(2, "run flap.toml -o cut --quiet", &["time.end=0.025"]).expect(0, &[]);
    run(2, "run flap.toml -o cut --resume --quiet", &[more]).expect(0, &[]);
    is_near(&here.rows_of("at-once"), &here.rows_of("cut"), &[more]);
    let said = run(2, "run flap.toml -o out --resume", &["time.end=0.06", "fluid.density=2"]);
    said.expect(2, &["the case has changed in more than its end"]);
    // Alone again, by our own solver.
    here.run("run flap.toml -o out --resume --quiet", &["time.end=0.05"]).expect(0, &[]);
    assert_eq!((here.rows_of("at-once").len(), here.rows_of("out").len()), (4, 5));
}

#[test]
fn what_goes_wrong_on_one_ends_all_and_is_said_once() {
    if !can() {
        return;
    }
    let here = Place::new("several-wrong");
    here.write("flap.toml", FLAP);
    let run = "run flap.toml -o out";
    for (n, sets, words) in [
        (2, &["time.stepp=1"][..], &["time.stepp=1: unknown key; did you mean `step`?"][..]),
        (3, &["linear.engine=own"], &["linear.engine=own: 3 processes are computed by PETSc"]),
        (2, &["linear.petsc.options=-ksp_tpye gmres"], &["nothing reads the option `-ksp_tpye`"]),
    ] {
        let said = together(&here, &[(n, run, sets)]).expect(2, words);
        assert_eq!(own_lines(&said, words[0]), 1, "{}", said.err);
    }
    let said = together(&here, &[(1, run, &[]), (1, run, &["time.stepp=1"])]);
    said.expect(2, &["process 1 of 2: --set time.stepp=1: unknown key; did you mean `step`?"]);
    let said = together(&here, &[(2, run, &[]), (1, run, &["fluid.density=999"])]);
    said.expect(2, &["process 2 has another case than process 0"]);
    let said = together(&here, &[(2, "check flap.toml", &[])]);
    said.expect(2, &["only `undula run` takes several processes"]);
    assert!(!here.file("out").exists());
    // A step without a solution is one for all, and what was computed is kept.
    let said = together(
        &here,
        &[(2, "run flap.toml -o broken", &["solid.mu=1", "time.max-halvings=0", "time.end=1"])],
    );
    said.expect(3, &["breakdown: ", "broken/breakdown.txt"]);
    assert!(fs::metadata(here.file("broken/breakdown.txt")).is_ok());
}

#[test]
fn processes_that_see_other_files_are_told() {
    // A path that is another one in each process.
    if !can() || !cfg!(target_os = "linux") {
        return;
    }
    let here = Place::new("several-apart");
    for (directory, density) in [("one", "1000"), ("two", "999"), ("none", "")] {
        fs::create_dir_all(here.file(directory)).unwrap();
        here.write(&format!("{directory}/flap.toml"), FLAP);
        if !density.is_empty() {
            let sets = ["time.end=0.01", &format!("fluid.density={density}")];
            here.run(&format!("run {directory}/flap.toml -o {directory}/start --quiet"), &sets)
                .expect(0, &[]);
        }
    }
    let (run, sets) = ("run flap.toml -o out", ["initial.from=/proc/self/cwd/start", "time.end=0.03"]);
    apart(&here, ["one", "two"], run, &sets).expect(2, &["process 1 has another state to begin with"]);
    let said = apart(&here, ["one", "none"], run, &sets);
    said.expect(2, &["process 1 of 2: --set initial.from=/proc/self/cwd/start: "]);
    assert!(!here.file("one/out").exists());
}
