//! `undula compare`: results beside published ones, or beside those of another run.

use crate::args::{CompareArgs, bad_input, print};
use anyhow::Context;
use std::path::Path;
use std::process::ExitCode;
use undula::problem::compare::{compare, difference};
use undula::problem::reference::{References, Run};

/// Prints the table.
pub fn run(args: &CompareArgs) -> anyhow::Result<ExitCode> {
    let run = match read(&args.dir)? {
        Ok(run) => run,
        Err(message) => return bad_input(message),
    };
    if let Some(other) = &args.other {
        return match read(other)? {
            Ok(second) => print(&difference(&run, &second).to_string()),
            Err(message) => bad_input(message),
        };
    }
    let references = match &args.reference {
        None => References::builtin(&run.case),
        Some(path) => {
            let text =
                std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
            match References::from_toml(&text) {
                Ok(references) => Some(references),
                Err(e) => return bad_input(format_args!("{}: {e}", path.display())),
            }
        }
    };
    match references {
        Some(references) => print(&compare(&run, &references).to_string()),
        None => bad_input(format_args!(
            "there are no published results for the case `{}`; give some with --reference FILE, \
             or a second run to compare with",
            run.case
        )),
    }
}

/// Prints the run in `dir` beside the published results of its case, if there are any.
///
/// # Errors
/// If the summary cannot be read.
pub fn show(dir: &Path) -> anyhow::Result<()> {
    let run = read(dir)?.map_err(anyhow::Error::msg)?;
    if let Some(references) = References::builtin(&run.case) {
        print(&compare(&run, &references).to_string())?;
    }
    Ok(())
}

/// The run in `dir`, or what is wrong with it.
fn read(dir: &Path) -> anyhow::Result<Result<Run, String>> {
    let path = dir.join("summary.json");
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            let shown = dir.display();
            return Ok(Err(format!("{shown} is not the output of a finished run: it has no summary.json")));
        }
        Err(e) => return Err(e).with_context(|| format!("cannot read {}", path.display())),
    };
    let mut run = match Run::from_json(&text) {
        Ok(run) => run,
        Err(e) => return Ok(Err(format!("{}: {e}", path.display()))),
    };
    // Extrema over all times are in the history only.
    if let Ok(history) = std::fs::read_to_string(dir.join("history.csv")) {
        run.add_history(&history);
    }
    Ok(Ok(run))
}
