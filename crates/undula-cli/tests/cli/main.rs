//! The program as a user meets it: the real binary, in directories of its own.

mod animate;
mod bench;
mod commands;
mod endings;
mod engines;
mod faults;
mod in_space;
mod in_space_fields;
mod in_space_input;
mod in_space_turned;
mod initial;
mod input;
mod jacobian;
mod keys;
mod launch;
mod live;
mod log;
mod manual;
mod modes;
mod multigrid;
mod outputs;
mod pictures;
mod pictures_space;
mod python;
mod report;
mod several;
mod space_cases;
mod starters;
mod stored;
mod study;
mod tables;

// Sources of the program, of which some tests call functions.
#[path = "../../src/args.rs"]
#[allow(dead_code, unused_imports)]
mod args;
#[path = "../../src/cases.rs"]
mod cases;
#[path = "../../src/check.rs"]
mod check;
#[path = "../../src/compare.rs"]
#[allow(dead_code)]
mod compare;
#[path = "../../src/digits.rs"]
#[allow(dead_code)]
mod digits;
#[path = "../../src/new.rs"]
mod new;
#[path = "../../src"]
#[allow(dead_code)]
mod sources {
    pub mod plot;
}

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Few cells, few steps, a beam that moves; some milliseconds each.
const SMALL: [&str; 4] = ["mesh.refine=0", "time.step=0.01", "time.end=0.05", "solid.body-force=[0,-2]"];

/// A directory of one test.
struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Place {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-{name}"));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Place(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::create_dir_all(self.file(name).parent().unwrap()).unwrap();
        fs::write(self.file(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.file(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// The program, about to run here with `arguments` and `sets`.
    fn command(&self, arguments: &str, sets: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_undula"));
        command.current_dir(&self.0).args(arguments.split_whitespace()).stdin(Stdio::null());
        sets.iter().for_each(|set| {
            command.args(["--set", set]);
        });
        command
    }

    fn run(&self, arguments: &str, sets: &[&str]) -> Said {
        Said::of(self.command(arguments, sets).output().unwrap())
    }
}

/// How the program ended and what it said.
#[derive(Debug)]
struct Said {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Said {
    fn of(output: Output) -> Said {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        let said = Said { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) };
        assert!(!said.err.contains("panicked"), "{said:?}");
        said
    }

    /// Asserts the exit code, and that all of `words` were said.
    #[track_caller]
    fn expect(self, code: i32, words: &[&str]) -> Said {
        let all = format!("{}{}", self.out, self.err);
        assert_eq!(self.code, Some(code), "{all}");
        for word in words {
            assert!(all.contains(word), "`{word}` was not said:\n{all}");
        }
        self
    }
}

/// Waits until `done` gives something.
fn wait<T>(what: &str, mut done: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(value) = done() {
            return value;
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "waited too long for {what}");
        std::thread::sleep(Duration::from_millis(3));
    }
}
