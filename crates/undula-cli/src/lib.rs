//! The `undula` command as a library, for what else offers it: the program, and the Python module.
// A pipe whose reader has gone makes these panic; `args` has what to use.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod bench;
mod cases;
mod check;
mod compare;
mod digits;
mod events;
mod explain;
mod inf_sup;
mod jacobian;
mod keys;
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

use args::{Cli, Command};
use clap::Parser;
use std::ffi::OsString;
use std::process::ExitCode;

/// The program with the command line `args`, the first of which is its name; returns its exit code. Mistakes in the
/// command line itself, `--help` and `--version` end the process.
pub fn command(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let result = match Cli::parse_from(args).command {
        Command::Run(args) => run::run(&args),
        Command::Check(args) if args.jacobian => jacobian::run(&args),
        Command::Check(args) if args.inf_sup => inf_sup::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Modes(args) => modes::run(&args),
        Command::Cases => cases::run(),
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
