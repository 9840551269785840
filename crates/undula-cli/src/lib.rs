//! The `undula` command as a library, for what else offers it: the program, and the Python module.
// A pipe whose reader has gone makes these panic; `args` has what to use.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod bench;
mod cases;
mod check;
mod compare;
mod digits;
mod engines;
mod events;
mod explain;
mod inf_sup;
mod jacobian;
mod keys;
mod launch;
mod live;
mod modes;
mod new;
mod page;
mod plot;
mod progress;
mod report;
mod run;
mod schema;
mod shell;
mod study;

pub use args::with_causes;
use args::{Cli, Command};
use clap::Parser;
pub use engines::name_libraries;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use undula::case::Case;
use undula::output::FieldSnapshot;

/// The program with the command line `args`, the first of which is its name; returns its exit code. Mistakes in the
/// command line itself, `--help` and `--version` end the process.
pub fn command(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let command = Cli::parse_from(args).command;
    if !matches!(command, Command::Run(_))
        && let Some(code) = launch::refuse()
    {
        return code;
    }
    engines::name_libraries();
    let result = match command {
        Command::Run(args) => run::run(&args),
        Command::Check(args) if args.jacobian => jacobian::run(&args),
        Command::Check(args) if args.inf_sup => inf_sup::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Modes(args) => modes::run(&args),
        Command::Cases => cases::run(),
        Command::Engines => engines::run(),
        Command::Keys(args) => keys::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::New(args) => new::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Study(args) => study::run(&args),
        Command::Reproduce(args) => study::reproduce(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::manual(&args),
    };
    result.unwrap_or_else(|error| {
        args::say(format_args!("error: {}", args::with_causes(&error)));
        ExitCode::FAILURE
    })
}

/// What `undula check` says of a case.
///
/// # Errors
/// An [`undula::Error`] if the case does not fit its mesh.
pub fn summary(case: Case) -> anyhow::Result<String> {
    let (case, overview) = check::measured(case)?;
    Ok(check::summary(&case, Some(&overview))?)
}

/// What `undula keys PATTERN` prints; all keys if the pattern is empty.
pub fn keys(pattern: &str) -> String {
    keys::aligned(&undula::case::keys::search(pattern))
}

/// Writes the page of the run in `directory` into `to`, by default its `report.html`, and returns its path.
///
/// # Errors
/// If a file of the run cannot be read, or the page cannot be written.
pub fn report(directory: &Path, to: Option<&Path>) -> anyhow::Result<PathBuf> {
    report::write(directory, to, &[])
}

/// Draws the pictures of the run in `directory` into `to`, by default its `plots`, and returns their paths.
///
/// # Errors
/// If a file of the run cannot be read, or a picture cannot be written.
pub fn plot(directory: &Path, to: Option<&Path>) -> anyhow::Result<Vec<PathBuf>> {
    plot::plot_directory(directory, to)
}

/// A picture of the fields as PNG, in space of a cut across the shortest side; `None` where there is no such `field`.
///
/// # Errors
/// If it cannot be drawn.
pub fn picture(fields: FieldSnapshot, field: &str, title: &str) -> anyhow::Result<Option<Vec<u8>>> {
    plot::picture_of(fields, field, title)?.map(|image| image.png()).transpose()
}
