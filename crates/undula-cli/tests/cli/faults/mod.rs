//! Inputs that went wrong once, run through the program: each gives the right value or is refused with the reason.

mod bodies;
mod boundaries;
mod breakdowns;
mod forces;
mod formats;
mod reliability;
mod scales;
mod summary;

use super::{Place, Said};
use std::path::{Path, PathBuf};

/// A file of `inputs/`.
fn input(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/faults/inputs").join(name)
}

/// A directory of one test with copies of `files` of `inputs/`.
fn place(name: &str, files: &[&str]) -> Place {
    let place = Place::new(&format!("faults-{name}"));
    for file in files {
        let from = input(file);
        std::fs::copy(&from, place.file(from.file_name().and_then(|n| n.to_str()).unwrap())).unwrap();
    }
    place
}

/// The last value of functional `name` of the run in `directory`.
fn last(place: &Place, directory: &str, name: &str) -> f64 {
    let summary = place.json(&format!("{directory}/summary.json"));
    summary["functionals"][name]["last"].as_f64().unwrap_or_else(|| panic!("{name}: {summary}"))
}

/// Asserts that `value` is `right` to the relative accuracy `within`.
#[track_caller]
fn close(value: f64, right: f64, within: f64) {
    assert!((value - right).abs() <= within * right.abs(), "{value} is not {right} to {within:e}");
}

/// The program run in `place` with the words of `arguments` and `sets`.
fn undula(place: &Place, arguments: &str, sets: &[&str]) -> Said {
    place.run(arguments, sets)
}
