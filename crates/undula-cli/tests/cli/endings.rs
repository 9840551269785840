//! Runs that end before their time: interrupted, killed, broken down, or without room on the disk.

use super::{Place, SMALL, Said, wait};
use std::fs;
use std::process::{Child, Command, Stdio};
use undula::output::Checkpoint;

/// Long enough to be stopped on the way.
const LONG: [&str; 6] = [
    "mesh.refine=0",
    "time.step=0.01",
    "time.end=1.5",
    "solid.body-force=[0,-2]",
    "output.checkpoint-every=7",
    "output.fields-every=20",
];

impl Place {
    /// Starts a run and waits until its history has `rows` rows.
    fn start(&self, arguments: &str, sets: &[&str], directory: &str, rows: usize) -> Child {
        let mut command = self.command(arguments, sets);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        wait("the first steps", || {
            assert!(child.try_wait().unwrap().is_none(), "ended too early");
            let history = fs::read_to_string(self.file(directory).join("history.csv")).unwrap_or_default();
            (history.lines().count() > rows).then_some(())
        });
        child
    }

    fn status(&self, directory: &str) -> String {
        self.json(&format!("{directory}/summary.json"))["status"].as_str().unwrap().to_string()
    }

    /// Asserts that two runs have the same history, byte by byte, and the same last state.
    fn assert_same(&self, one: &str, two: &str) {
        let history = |run: &str| self.read(&format!("{run}/history.csv"));
        assert_eq!(history(one), history(two));
        let last = |run: &str| {
            let found = Checkpoint::load_latest(self.file(run).join("checkpoints")).unwrap().unwrap();
            (found.step, found.checkpoint.arrays)
        };
        assert!(last(one) == last(two), "the last states differ");
        assert_eq!((self.status(one), self.status(two)), ("completed".into(), "completed".into()));
    }
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn stopped_runs_go_on_with_the_same_bits() {
    let here = Place::new("resume");
    here.run("run fsi3 -o whole --quiet --threads 1", &LONG).expect(0, &[]);

    // Ctrl-C.
    let child = here.start("run fsi3 -o stopped --threads 1", &LONG, "stopped", 10);
    signal(&child, "-INT");
    Said::of(child.wait_with_output().unwrap()).expect(130, &["interrupted", "--resume"]);
    assert_eq!(here.status("stopped"), "interrupted");
    let rows = here.read("stopped/history.csv");
    here.run("run fsi3 -o stopped", &LONG)
        .expect(2, &["unfinished run", "`interrupted`", "--resume", "--force"]);
    here.run("run fsi3 -o stopped --resume", &[&LONG[..], &["fluid.density=999"]].concat())
        .expect(2, &["the case has changed", "fluid.density was 1000.0, now 999.0"]);
    assert_eq!(here.read("stopped/history.csv"), rows);
    here.run("run fsi3 -o stopped --resume --threads 2", &LONG).expect(0, &["completed"]);
    here.assert_same("whole", "stopped");
    assert!(here.read("whole/history.csv").starts_with(&rows));

    // kill -9, once from the last checkpoint, once with that damaged, from the one before.
    for damaged in [false, true] {
        let _ = fs::remove_dir_all(here.file("killed"));
        let mut child = here.start("run fsi3 -o killed --threads 1", &LONG, "killed", 16);
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(here.status("killed"), "running");
        here.run("run fsi3 -o killed", &LONG).expect(2, &["unfinished run", "`running`"]);
        if damaged {
            let mut files: Vec<_> = fs::read_dir(here.file("killed/checkpoints"))
                .unwrap()
                .map(|entry| entry.unwrap().path())
                .filter(|path| path.extension().is_some_and(|e| e == "npz"))
                .collect();
            files.sort();
            let bytes = fs::read(&files[1]).unwrap();
            fs::write(&files[1], &bytes[..bytes.len() / 2]).unwrap();
        }
        here.run("run fsi3 -o killed --resume --quiet --threads 1", &LONG).expect(0, &[]);
        here.assert_same("whole", "killed");
    }

    // A completed run can be carried on to a later end only.
    here.run("run fsi3 -o whole --resume", &LONG).expect(2, &["already completed", "time.end"]);
    here.run("run fsi3 -o whole --resume --quiet", &[&LONG[..], &["time.end=1.52"]].concat()).expect(0, &[]);
    assert!(here.read("whole/history.csv").lines().last().unwrap().starts_with("152,1.52,"));
}

#[test]
fn only_one_program_writes_into_a_directory() {
    let here = Place::new("busy");
    let endless = [&LONG[..], &["time.end=60", "output.checkpoint-every=0"]].concat();
    let mut child = here.start("run fsi3 -o results --threads 1", &endless, "results", 1);
    for flag in ["--force", "--resume"] {
        here.run(&format!("run fsi3 -o results {flag}"), &LONG).expect(2, &["another run is writing"]);
    }
    child.kill().unwrap();
    child.wait().unwrap();
    here.run("run fsi3 -o results --resume", &endless).expect(2, &["--force"]);
    here.run("run fsi3 -o results --force --quiet", &SMALL).expect(0, &[]);
    assert_eq!(here.read("results/history.csv").lines().count(), 6);
}

#[test]
fn a_breakdown_is_a_result() {
    let here = Place::new("breakdown");
    // A hundredth of the stiffness, and a mesh that is moved carelessly.
    let soft =
        ["mesh.refine=0", "motion.model=harmonic", "solid.mu=1e3", "solid.lambda=4e3", "time.step=0.02"];
    let said = here.run("run fsi3 -o results --threads 2", &soft);
    said.expect(3, &["breakdown", "smallest J", "what was computed so far is in results", "results/plots"]);
    let summary = here.json("results/summary.json");
    assert_eq!(summary["status"], "breakdown");
    let breakdown = &summary["breakdown"];
    let rows = here.read("results/history.csv");
    let last = rows.lines().last().unwrap();
    let number = |n: usize| last.split(',').nth(n).unwrap().parse::<f64>().unwrap();
    assert!(rows.lines().count() > 5 && number(1) < breakdown["time"].as_f64().unwrap());
    assert!(breakdown["min_J"].as_f64().unwrap() < 0.5);
    assert!(breakdown["where"].as_str().unwrap().starts_with("cell "), "{breakdown}");
    assert!(breakdown["reason"].as_str().unwrap().contains("no solution for the step"), "{breakdown}");
    // The last fields and the last checkpoint are those of the last row.
    assert_eq!(summary["steps"].as_f64(), Some(number(0)));
    let found = Checkpoint::load_latest(here.file("results/checkpoints")).unwrap().unwrap();
    assert_eq!(found.step as f64, number(0));
    assert!(found.checkpoint.metadata.contains(&format!("\"clock\":[{},", number(1))));
    assert!(here.read("results/fields.pvd").contains(&format!("timestep=\"{}\"", number(1))));
    here.run("run fsi3 -o results", &soft).expect(2, &["unfinished run", "`breakdown`"]);
}

/// Files that the system does not let grow: what a full disk or a quota looks like.
#[cfg(unix)]
#[test]
fn a_full_disk_is_no_panic() {
    let here = Place::new("full");
    let sets = [&SMALL[..], &["output.fields-every=1"]].concat();
    let run = |arguments: &str, limit: u32| {
        let program = here.command(arguments, &sets);
        let words: Vec<_> = program.get_args().map(|a| format!("'{}'", a.to_str().unwrap())).collect();
        let script = format!(
            "trap '' XFSZ; ulimit -f {limit}; exec {} {}",
            program.get_program().to_str().unwrap(),
            words.join(" ")
        );
        Said::of(Command::new("sh").args(["-c", &script]).current_dir(&here.0).output().unwrap())
    };
    // Too small for a field file, and large enough for the text files.
    let said = run("run fsi3 -o results", 32)
        .expect(1, &["error: ", "fields_000000.vtu", "cannot write", "too large"]);
    assert_eq!(said.err.matches("File too large").count(), 1, "{}", said.err);
    assert!(!said.err.contains("ZipWriter"), "{}", said.err);
    assert_eq!(here.status("results"), "failed");
    assert_eq!(here.read("results/history.csv").lines().count(), 1);
    // Nothing is left half written.
    for folder in ["fields", "checkpoints"] {
        assert_eq!(fs::read_dir(here.file("results").join(folder)).unwrap().count(), 0, "{folder}");
    }
    run("run fsi3 -o nothing", 0).expect(1, &["error: ", "summary.json", "cannot write"]);
    // With room again, the run is made anew.
    here.run("run fsi3 -o results --resume", &sets).expect(2, &["--force"]);
    here.run("run fsi3 -o results --force --quiet", &sets).expect(0, &[]);
}

/// An address space that is too small, wherever it ends: refused before, or told in a sentence; never a signal.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "long"]
fn memory_that_ends_is_told() {
    let here = Place::new("memory");
    let run = |limit: u64| {
        let sets = ["mesh.refine=1", "time.end=0.01"];
        let program = here.command("run fsi3 -o results --force --quiet --threads 1", &sets);
        let words: Vec<_> = program.get_args().map(|a| format!("'{}'", a.to_str().unwrap())).collect();
        let script = format!(
            "ulimit -v {limit}; exec {} {}",
            program.get_program().to_str().unwrap(),
            words.join(" ")
        );
        Said::of(Command::new("sh").args(["-c", &script]).current_dir(&here.0).output().unwrap())
    };
    let (mut limit, mut told) = (40_000, 0);
    loop {
        let said = run(limit);
        match said.code {
            Some(0) => break,
            Some(2) => assert!(said.err.contains(" GB") || said.err.contains(" MB"), "{limit}: {}", said.err),
            Some(3) => {
                assert!(said.err.contains("out of memory"), "{limit}: {}", said.err);
                told += 1;
            }
            _ => panic!("{limit}: {:?}, {}", said.code, said.err),
        }
        limit += limit / 12;
        assert!(limit < 4_000_000);
    }
    assert!(told > 0);
}
