//! `undula compare`: results beside published ones, or beside those of another run.

use crate::args::{CompareArgs, bad_input, print, say};
use anyhow::Context;
use std::path::Path;
use std::process::ExitCode;
use undula::output::directory::SUMMARY;
use undula::results::compare::{Comparison, compare, difference};
use undula::results::computed::Results;
use undula::results::reference::{Beside, Departure, References};

/// Prints the table.
pub fn run(args: &CompareArgs) -> anyhow::Result<ExitCode> {
    let run = match read(&args.dir)? {
        Ok(run) => run,
        Err(message) => return bad_input(message),
    };
    if let Some(other) = &args.other {
        let second = match read(other)? {
            Ok(second) => second,
            Err(message) => return bad_input(message),
        };
        return match difference(&run, &second) {
            Some(difference) => print(&difference.to_string()),
            None => bad_input(format_args!("{} and {} have no time in common", run.name, second.name)),
        };
    }
    if let Some(path) = &args.reference {
        let text =
            std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        return match References::from_toml(&text) {
            Ok(references) => print(&compare(&run, &references).to_string()),
            Err(e) => bad_input(format_args!("{}: {e}", path.display())),
        };
    }
    match published(&run) {
        Published::Table(comparison) => print(&comparison.to_string()),
        Published::Departs(why) => bad_input(format_args!(
            "{why}\ngive results with --reference FILE, or a second run to compare with"
        )),
        Published::None => bad_input(format_args!(
            "the case `{}` names no published results, as reference = \"fsi3\" at its top would; give some with \
             --reference FILE, or a second run to compare with",
            run.summary.case
        )),
    }
}

/// Prints the run in `dir` beside the published results of its case, if there are any, or why there are none.
///
/// # Errors
/// If the summary cannot be read.
pub fn show(dir: &Path) -> anyhow::Result<()> {
    match published(&read(dir)?.map_err(anyhow::Error::msg)?) {
        Published::Table(comparison) => {
            print(&comparison.to_string())?;
        }
        Published::Departs(why) => say(format_args!("note: {why}")),
        Published::None => {}
    }
    Ok(())
}

/// What stands beside a run.
pub enum Published {
    /// The case asks for nothing.
    None,
    /// The case is another problem than the one that it names; in words.
    Departs(String),
    /// Results.
    Table(Comparison),
}

/// The published results of the case of `run`.
pub fn published(run: &Results) -> Published {
    match run.case.as_ref().map_or(Beside::Nothing, Beside::of) {
        Beside::Nothing => Published::None,
        Beside::Departs(name, keys) => Published::Departs(in_words(name, &keys)),
        Beside::Results(references, left_out) => {
            Published::Table(Comparison { left_out, ..compare(run, &references) })
        }
    }
}

/// Why no published results of `name` stand beside a run.
fn in_words(name: &str, keys: &[Departure]) -> String {
    let keys: Vec<String> = keys.iter().map(|key| format!("\n  {key}")).collect();
    format!("no published values stand beside this run, for its problem is not `{name}`:{}", keys.concat())
}

/// The run in `dir`, or what is wrong with it.
fn read(dir: &Path) -> anyhow::Result<Result<Results, String>> {
    if !dir.join(SUMMARY).exists() {
        let shown = dir.display();
        return Ok(Err(format!("{shown} is not the output of a finished run: it has no {SUMMARY}")));
    }
    Ok(Results::read(dir).map_err(|e| e.to_string()))
}
