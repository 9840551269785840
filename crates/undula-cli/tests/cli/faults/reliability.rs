//! Files, signals, checkpoints.

use super::{input, place, undula};
use crate::{Place, SMALL, Said, wait};
use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use undula::output::Checkpoint;

/// `SMALL` without its end.
const MOVING: [&str; 3] = ["mesh.refine=0", "time.step=0.01", "solid.body-force=[0,-2]"];

fn with<'a>(sets: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [sets, more].concat()
}

/// The last state of a run.
fn state(here: &Place, run: &str) -> undula::output::Latest {
    Checkpoint::load_latest(here.file(run).join("checkpoints")).unwrap().unwrap()
}

/// Asserts that two runs have the same rows, fields and last state.
#[track_caller]
fn assert_same(here: &Place, one: &str, two: &str) {
    for file in ["history.csv", "fields.pvd"] {
        assert_eq!(here.read(&format!("{one}/{file}")), here.read(&format!("{two}/{file}")));
    }
    let (one, two) = (state(here, one), state(here, two));
    assert_eq!(one.step, two.step);
    assert!(one.checkpoint.arrays == two.checkpoint.arrays, "the last states differ");
}

/// Starts a run and waits until `file` of it is there and has `lines`.
fn start(here: &Place, arguments: &str, sets: &[&str], file: &str, lines: usize) -> Child {
    let mut command = here.command(arguments, sets);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    wait("the first steps", || {
        assert!(child.try_wait().unwrap().is_none(), "ended too early");
        let text = fs::read_to_string(here.file(file)).unwrap_or_default();
        (text.lines().count() > lines).then_some(())
    });
    child
}

fn end(child: Child) -> Said {
    Said::of(child.wait_with_output().unwrap())
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn a_completed_run_is_replaced_only_with_force() {
    let here = place("replace", &[]);
    let sets = with(&MOVING, &["time.end=0.02"]);
    undula(&here, "run fsi3 -o results --quiet", &sets).expect(0, &[]);
    let rows = here.read("results/history.csv");
    undula(&here, "run fsi3 -o results", &with(&MOVING, &["time.end=0.01"]))
        .expect(2, &["results: holds a completed run", "--force", "--resume"]);
    assert_eq!(here.read("results/history.csv"), rows);
    undula(&here, "run fsi3 -o results --quiet --force", &with(&MOVING, &["time.end=0.01"])).expect(0, &[]);
    assert_eq!(here.read("results/history.csv").lines().count(), 2);
}

#[test]
fn a_new_case_bears_the_name_of_its_file() {
    let here = place("new", &[]);
    undula(&here, "new fsi3 own.toml", &[]).expect(0, &[]);
    assert!(here.read("own.toml").contains("\nname = \"own\"\n"));
    undula(&here, "run own.toml --quiet", &with(&MOVING, &["time.end=0.01"])).expect(0, &[]);
    assert_eq!(here.json("out/own/summary.json")["case"], "own");
    let odd = here.command("new fsi3", &[]).arg("my own case.toml").output().unwrap();
    Said::of(odd).expect(0, &[]);
    assert!(here.read("my own case.toml").contains("\nname = \"my_own_case\"\n"));
}

/// What `| head -1` does: it reads a line, or none, and is gone.
#[test]
#[ignore = "long"]
fn nobody_needs_to_listen() {
    let here = place("pipes", &[]);
    let sets = with(&SMALL, &["output.fields-every=2"]);
    let mut command = here.command("run fsi3 -o results --verbose", &sets);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop((child.stdout.take(), child.stderr.take()));
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(here.json("results/summary.json")["status"], "completed");
    assert_eq!(here.read("results/history.csv").lines().count(), 6);
    assert!(here.file("results/plots/speed.png").exists());
    for (arguments, code) in [
        ("check fsi3", 0),
        ("check fsi3 --toml", 0),
        ("cases", 0),
        ("compare results", 2),
        ("plot results", 0),
        ("check fsi4", 2),
        ("run fsi3 -o results", 2),
        ("bench fsi3 --set mesh.refine=0 --steps 1 --repeat 1 --no-kernels --threads 1", 0),
    ] {
        let mut command = here.command(arguments, &[]);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop((child.stdout.take(), child.stderr.take()));
        assert_eq!(child.wait().unwrap().code(), Some(code), "{arguments}");
    }
}

#[test]
fn checkpoints_come_by_the_clock_on_the_wall() {
    let here = place("minutes", &[]);
    let refused = undula(&here, "check fsi3", &["output.checkpoint-minutes=-1"]);
    refused.expect(2, &["output.checkpoint-minutes", "0 or above"]);
    undula(&here, "check fsi3 --toml", &[]).expect(0, &["checkpoint-minutes = 10.0"]);
    let sets = with(&MOVING, &["time.end=0.3", "output.checkpoint-every=0"]);
    let often = with(&sets, &["output.checkpoint-minutes=1e-5"]);
    undula(&here, "run fsi3 -o whole --quiet --threads 1", &with(&sets, &["output.checkpoint-minutes=0"]))
        .expect(0, &[]);
    let mut child = start(&here, "run fsi3 -o killed --threads 1", &often, "killed/history.csv", 10);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(state(&here, "killed").step >= 8);
    undula(&here, "run fsi3 -o killed --resume --quiet", &often).expect(0, &[]);
    assert_same(&here, "whole", "killed");
    // An end is an end, the first step included.
    let late = with(&MOVING, &["time.step=1e-3", "time.end=9", "output.checkpoint-minutes=0"]);
    let child = start(&here, "run fsi3 -o early --threads 1", &late, "early/history.csv", 0);
    interrupt(&child);
    end(child).expect(130, &["--resume"]);
    let child = start(&here, "run fsi3 -o early --resume --threads 1", &late, "early/history.csv", 2);
    interrupt(&child);
    end(child).expect(130, &["--resume"]);
}

#[test]
fn a_refused_resume_names_the_keys_that_differ() {
    let here = place("keys", &[]);
    undula(&here, "run fsi3 -o results --quiet", &SMALL).expect(0, &[]);
    let more = ["time.end=0.1", "fluid.density=999", "solid.law=linear"];
    undula(&here, "run fsi3 -o results --resume", &with(&SMALL, &more)).expect(
        2,
        &["the case has changed", "fluid.density was 1000.0, now 999.0", "solid.law was", "\"linear\""],
    );
    undula(&here, "run fsi3 -o results --resume --quiet", &with(&SMALL, &["time.end=0.06", "name=other"]))
        .expect(0, &[]);
}

#[test]
fn case_mesh_and_results_move_together() {
    let here = place("move", &[]);
    fs::create_dir_all(here.file("old/meshes")).unwrap();
    fs::copy(input("interface-name/tube.msh"), here.file("old/meshes/tube.msh")).unwrap();
    let text = fs::read_to_string(input("interface-name/ok.toml")).unwrap();
    here.write("old/tube.toml", &text.replace("\"tube.msh\"", "\"meshes/tube.msh\""));
    let run = |directory: &str, arguments: &str, sets: &[&str]| {
        let mut command = here.command(arguments, sets);
        Said::of(command.current_dir(here.file(directory)).output().unwrap())
    };
    run("old", "run tube.toml --quiet", &["time.end=0.03"]).expect(0, &[]);
    run("old", "run tube.toml --quiet -o whole", &["time.end=0.06"]).expect(0, &[]);
    assert!(here.read("old/out/tube/case.toml").contains("file = \"../../meshes/tube.msh\""));
    fs::rename(here.file("old"), here.file("new")).unwrap();
    run("new", "check out/tube/case.toml", &[]).expect(0, &[" cells, "]);
    run("", "check new/out/tube/case.toml", &[]).expect(0, &[" cells, "]);
    let from = "bench --from out/tube --steps 1 --repeat 1 --no-kernels -o b.json";
    run("new", from, &[]).expect(0, &[]);
    // From the case in the directory of the run, and from its own place.
    run("new", "run out/tube/case.toml -o out/tube --resume --quiet", &["time.end=0.04"]).expect(0, &[]);
    run("", "run new/tube.toml -o new/out/tube --resume --quiet", &["time.end=0.06"]).expect(0, &[]);
    assert_same(&here, "new/whole", "new/out/tube");
    // Another file of that name is another mesh.
    let mesh = here.read("new/meshes/tube.msh");
    here.write("new/meshes/tube.msh", &format!("{mesh}\n$Comments\nmoved\n$EndComments\n"));
    run("new", "run tube.toml --resume", &["time.end=0.07"]).expect(2, &["mesh.file", "content"]);
}

#[test]
fn a_damaged_checkpoint_is_skipped_with_a_word() {
    let here = place("damaged", &[]);
    let sets = with(&MOVING, &["time.end=0.1", "output.checkpoint-every=4"]);
    undula(&here, "run fsi3 -o results --quiet", &sets).expect(0, &[]);
    undula(&here, "run fsi3 -o whole --quiet", &with(&sets, &["time.end=0.2"])).expect(0, &[]);
    let newest = here.file("results/checkpoints/checkpoint_00000010.npz");
    let bytes = fs::read(&newest).unwrap();
    fs::write(&newest, &bytes[..bytes.len() / 3]).unwrap();
    undula(&here, "check --jacobian --from results", &[])
        .expect(0, &["note: ", "checkpoint_00000010.npz", "older checkpoint"]);
    undula(&here, "run fsi3 -o results --resume", &with(&sets, &["time.end=0.2"]))
        .expect(0, &["note: ", "checkpoint_00000010.npz", "older checkpoint is taken", "completed"]);
    assert_same(&here, "whole", "results");
    for n in ["16", "20"] {
        fs::write(here.file(&format!("results/checkpoints/checkpoint_000000{n}.npz")), "none").unwrap();
    }
    undula(&here, "run fsi3 -o results --resume", &with(&sets, &["time.end=0.3"]))
        .expect(2, &["no sound one", "checkpoint_00000020.npz", "--force"]);
}

/// A case with many functionals, whose rows are long.
fn with_long_rows(here: &Place) {
    undula(here, "new fsi3 long.toml", &[]).expect(0, &[]);
    let mut text = here.read("long.toml");
    for n in 0..120 {
        let component = if n % 2 == 0 { "x" } else { "y" };
        text += &format!(
            "[functional.u{n}]\nkind = \"displacement\"\npoint = [0.6, 0.2]\ncomponent = \"{component}\"\n"
        );
    }
    here.write("long.toml", &text);
}

/// What a quota does: a file cannot grow any more, and that is a row of the history.
#[cfg(unix)]
#[test]
#[ignore = "long"]
fn a_run_whose_row_could_not_be_written_goes_on_with_the_same_bits() {
    let here = place("row", &[]);
    with_long_rows(&here);
    let sets = with(&MOVING, &["time.end=1.5", "output.checkpoint-every=20", "output.fields-every=0"]);
    let program = here.command("run long.toml -q -o cut --threads 1", &sets);
    let words: Vec<_> = program.get_args().map(|a| format!("'{}'", a.to_str().unwrap())).collect();
    let name = program.get_program().to_str().unwrap();
    // 500 blocks of 512 bytes: a checkpoint fits, all rows do not.
    let script = format!("trap '' XFSZ; ulimit -f 500; exec {name} {}", words.join(" "));
    let output = Command::new("sh").args(["-c", &script]).current_dir(&here.0).output().unwrap();
    Said::of(output).expect(1, &["history.csv", "cannot write"]);
    assert_eq!(here.json("cut/summary.json")["status"], "failed");
    let rows = here.read("cut/history.csv").lines().count();
    assert!(rows > 60 && rows < 150, "{rows}");
    assert_eq!(state(&here, "cut").step, rows as u64, "nothing is lost: the checkpoint has the row");
    undula(&here, "run long.toml -q -o cut --resume", &sets).expect(0, &[]);
    undula(&here, "run long.toml -q -o whole", &sets).expect(0, &[]);
    assert_same(&here, "whole", "cut");
    // A history that has lost rows that were there: the older checkpoint fits.
    let kept: String = here.read("cut/history.csv").split_inclusive('\n').take(142).collect();
    here.write("cut/history.csv", &kept);
    let later = with(&sets, &["time.end=1.55"]);
    undula(&here, "run long.toml -o cut --resume", &later)
        .expect(0, &["ends at step 141, before step 150", "older checkpoint"]);
    undula(&here, "run long.toml -q -o later", &later).expect(0, &[]);
    assert_same(&here, "later", "cut");
}

#[test]
fn what_follows_the_last_row_needed_is_cut_off() {
    let here = place("garbage", &[]);
    undula(&here, "run fsi3 -o results --quiet", &SMALL).expect(0, &[]);
    let history = here.file("results/history.csv");
    let rows = fs::read(&history).unwrap();
    fs::write(&history, [&rows[..], b"\xff\xfe\x00\x80\n\xc3"].concat()).unwrap();
    let sets = with(&SMALL, &["time.end=0.08"]);
    undula(&here, "run fsi3 -o results --resume --quiet", &sets).expect(0, &[]);
    undula(&here, "run fsi3 -o whole --quiet", &sets).expect(0, &[]);
    assert_same(&here, "whole", "results");
}

#[cfg(unix)]
#[test]
fn files_that_are_removed_are_missed() {
    let here = place("removed", &[]);
    let sets = with(&MOVING, &["time.end=60"]);
    let begin = |name: &str| {
        let history = format!("{name}/history.csv");
        start(&here, &format!("run fsi3 -o {name} --threads 1"), &sets, &history, 3)
    };
    let child = begin("all");
    fs::remove_dir_all(here.file("all")).unwrap();
    end(child).expect(1, &["error: all: was removed"]);
    assert!(!here.file("all").exists());

    let child = begin("moved");
    fs::rename(here.file("moved"), here.file("elsewhere")).unwrap();
    end(child).expect(1, &["error: moved: was removed, moved"]);
    assert!(!here.file("moved").exists() && here.file("elsewhere/history.csv").exists());

    // The rows are still known: the run can go on.
    let child = begin("rows");
    fs::remove_file(here.file("rows/history.csv")).unwrap();
    end(child).expect(1, &["error: rows/history.csv: was removed"]);
    assert_eq!(here.json("rows/summary.json")["status"], "failed");
    let rows = here.read("rows/history.csv").lines().count();
    let child = start(&here, "run fsi3 -o rows --resume --threads 1", &sets, "rows/history.csv", rows + 2);
    interrupt(&child);
    end(child).expect(130, &[]);

    // In the last moment, and fields of earlier times.
    let every = with(&sets, &["time.end=0.3", "output.fields-every=1"]);
    let child = start(&here, "run fsi3 -o fields --threads 1", &every, "fields/history.csv", 3);
    fs::remove_file(here.file("fields/fields/fields_000001.vtu")).unwrap();
    end(child).expect(1, &["fields_000001.vtu: was removed"]);
    // Nobody can bring it back: the run ends without it.
    undula(&here, "run fsi3 -o fields --resume --quiet", &every).expect(0, &[]);
}

/// Ends at times that are multiples of the step, or not, and that steps have to land on.
#[test]
#[ignore = "long"]
fn an_extended_run_has_the_bits_of_a_straight_one() {
    let here = place("extended", &[]);
    let check = |name: &str, sets: &[&str], ends: [&str; 2]| {
        let [first, last] = ends.map(|end| format!("time.end={end}"));
        let (parts, whole) = (format!("{name}-parts"), format!("{name}-whole"));
        let run = |directory: &str, more: &str, end: &str| {
            let arguments = format!("run fsi3 -o {directory} --quiet --threads 1 {more}");
            undula(&here, &arguments, &with(&with(&MOVING, sets), &[end])).expect(0, &[]).err
        };
        run(&parts, "", &first);
        assert_eq!(run(&parts, "--resume", &last), "", "{name}");
        run(&whole, "", &last);
        assert_same(&here, &whole, &parts);
    };
    check("steps", &["time.step=0.005"], ["0.035", "0.1"]);
    check("third", &["time.step=1/150"], ["0.06666666666666667", "0.1"]);
    check("cut", &["time.step=0.005", "output.checkpoint-every=3"], ["0.0421", "0.1"]);
    check("first", &[], ["0.0021", "0.03"]);
    check("longer", &[], ["0.040005", "0.1"]);
    check("late", &["time.start=-0.3"], ["-0.2", "-0.1"]);
    check("interval", &["output.fields-interval=0.025"], ["0.06", "0.1"]);
    check("expression", &["time.step=0.004+0.02*t"], ["0.05", "0.1"]);
    check("fields", &["output.fields-every=4"], ["0.05", "0.1"]);
    check("bdf2", &["time.scheme=bdf2", "output.checkpoint-every=1"], ["0.045", "0.1"]);
    check("rannacher", &["time.scheme=rannacher", "time.rannacher-interval=0.05"], ["0.06", "0.12"]);
    check("fractional", &["time.scheme=fractional-step-theta"], ["0.043", "0.08"]);
    let adaptive = [
        "time.step=0.004",
        "time.adaptive.tolerance=1e-3",
        "time.adaptive.min-step=0.001",
        "solid.body-force=[0,0]",
        "output.checkpoint-every=1",
    ];
    check("adaptive", &adaptive, ["0.05", "0.1"]);
}

#[test]
fn an_end_that_cannot_be_taken_back_is_told() {
    let here = place("landed", &[]);
    let sets = with(&MOVING, &["time.end=0.042"]);
    undula(&here, "run fsi3 -o results --quiet", &sets).expect(0, &[]);
    undula(&here, "run fsi3 -o results --resume", &with(&sets, &["time.end=0.02"]))
        .expect(2, &["already completed"]);
    fs::remove_file(here.file("results/checkpoints/checkpoint_00000004.npz")).unwrap();
    undula(&here, "run fsi3 -o results --resume", &with(&sets, &["time.end=0.08"]))
        .expect(0, &["shortened to land on t = 0.042 s", "completed"]);
    assert!(here.read("results/history.csv").lines().last().unwrap().starts_with("9,0.08,"));
}

#[test]
fn nested_conditions_are_read_at_once() {
    let here = place("nested", &["reliability/hang-if-const.toml"]);
    let begun = Instant::now();
    undula(&here, "check hang-if-const.toml --toml", &[]).expect(0, &[]);
    assert!(begun.elapsed() < Duration::from_secs(5));
}

#[test]
fn steps_below_rounding_are_refused() {
    let here = place("tiny", &["reliability/tiny-step.toml"]);
    for command in ["check", "run"] {
        undula(&here, &format!("{command} tiny-step.toml"), &[])
            .expect(2, &["tiny-step.toml:20:8: time.step = 1e-20", "below the rounding"]);
    }
    assert!(!here.file("out").exists());
    for sets in [
        &["time.step=1e-15*t"][..],
        &["time.start=0", "time.step=1e-20"],
        &["time.start=-1e9", "time.end=-1", "time.step=1e-6"],
        &["time.step=0.1", "time.adaptive.min-step=1e-18"],
        &["time.step=0.1", "output.fields-interval=1e-300"],
    ] {
        undula(&here, "check tiny-step.toml", sets).expect(2, &["below the rounding"]);
    }
    // Small, and seen well enough: the times are small, too.
    let small = ["mesh.refine=0", "time.start=0", "time.step=1e-13", "time.end=4e-13"];
    undula(&here, "run tiny-step.toml -o small --quiet", &small).expect(0, &[]);
    let history = here.read("small/history.csv");
    let times: Vec<&str> = history.lines().skip(1).map(|row| row.split(',').nth(1).unwrap()).collect();
    assert_eq!(times, ["1e-13", "2e-13", "3e-13", "4e-13"]);
    // Known only when it is met.
    let late = ["mesh.refine=0", "time.step=if(abs(t-1.0321)<0.001, 1e-17, 0.0107)"];
    undula(&here, "run tiny-step.toml -o late --quiet", &late)
        .expect(2, &["time.step", "below the rounding of t"]);
    assert_eq!(here.json("late/summary.json")["status"], "failed");
}

/// 0.3 − 0.29 is more than 0.01 by rounding: the last step is the smallest one nevertheless.
#[test]
fn a_tolerance_that_no_step_meets_ends() {
    let here = place("unreachable", &[]);
    let sets = [
        "mesh.refine=0",
        "time.step=0.01",
        "time.end=0.3",
        "time.adaptive.tolerance=1e-300",
        "time.adaptive.min-step=0.01",
    ];
    undula(&here, "run fsi3 -o results --quiet --threads 1", &sets).expect(0, &[]);
    assert_eq!(here.json("results/summary.json")["steps"], 30);
}

#[test]
fn meshes_that_do_not_fit_into_memory_are_refused_at_once() {
    let here = place("memory", &[]);
    let begun = Instant::now();
    for command in ["check", "run"] {
        undula(&here, &format!("{command} fsi3"), &["mesh.refine=10"])
            .expect(2, &["--set mesh.refine=10", "255852544 cells", "GB of memory", "GB are at hand"]);
    }
    let cells = ["mesh.generator=box", "mesh.lower=[0,0]", "mesh.upper=[1,1]", "mesh.cells=[90000,90000]"];
    undula(&here, "check fsi3", &with(&cells, &["mesh.refine=0"]))
        .expect(2, &["mesh.cells", "GB are at hand"]);
    undula(&here, "check fsi3", &["space.velocity=P2", "mesh.refine=10"]).expect(2, &["511705088 cells"]);
    fs::copy(input("interface-name/tube.msh"), here.file("tube.msh")).unwrap();
    fs::copy(input("interface-name/ok.toml"), here.file("tube.toml")).unwrap();
    undula(&here, "check tube.toml", &["mesh.refine=10"]).expect(2, &["mesh.refine", "GB are at hand"]);
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
    undula(&here, "check fsi3", &["mesh.refine=2"]).expect(0, &[]);
}

#[cfg(unix)]
#[test]
fn one_signal_ends_a_stationary_run() {
    let here = place("stationary", &[]);
    for (name, signal) in [("int", "-INT"), ("term", "-TERM")] {
        let summary = format!("{name}/summary.json");
        let child = start(&here, &format!("run fsi1 -o {name} --threads 1"), &["mesh.refine=2"], &summary, 3);
        wait("the computation", || here.read(&summary).contains("\"cells\": 4928").then_some(()));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        end(child).expect(130, &["interrupted", "--force"]);
        assert_eq!(here.json(&summary)["status"], "interrupted");
    }
}

/// Signals at any time, in the middle of steps too.
#[cfg(unix)]
#[test]
#[ignore = "long"]
fn a_step_that_was_stopped_leaves_no_trace() {
    let here = place("stopped", &[]);
    let sets = ["mesh.refine=1", "time.step=0.02", "time.end=0.2", "solid.body-force=[0,-2]"];
    undula(&here, "run fsi3 -o whole --quiet --threads 1", &sets).expect(0, &[]);
    let history: PathBuf = here.file("parts/history.csv");
    for n in 0..40 {
        let flag = if n == 0 { "" } else { "--resume" };
        let mut command = here.command(&format!("run fsi3 -o parts --quiet --threads 1 {flag}"), &sets);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        if n == 0 {
            wait("the file", || history.exists().then_some(()));
        }
        std::thread::sleep(Duration::from_millis(80 + 7 * n));
        if child.try_wait().unwrap().is_none() {
            interrupt(&child);
        }
        let said = end(child);
        match said.code {
            Some(130) => {}
            Some(0) => return assert_same(&here, "whole", "parts"),
            _ => panic!("{said:?}"),
        }
    }
    undula(&here, "run fsi3 -o parts --quiet --threads 1 --resume", &sets).expect(0, &[]);
    assert_same(&here, "whole", "parts");
}
