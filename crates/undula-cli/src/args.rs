//! The command line: what can be said, and the ways to answer that all subcommands share.

use clap::{Args, Parser, Subcommand};
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Fluid-structure interaction on a fixed reference domain.
#[derive(Debug, Parser)]
#[command(name = "undula", version, about, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 completed, 1 failed, 2 bad input, 3 breakdown of the computation, \
                          130 interrupted.";

/// One arm per subcommand.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Compute a case
    Run(RunArgs),
    /// Check a case without computing it, and say what it is
    Check(CheckArgs),
    /// List the built-in cases
    Cases,
    /// Write a built-in case to a file, as a start for an own one
    New(NewArgs),
    /// Set results beside published ones, or beside those of another run
    Compare(CompareArgs),
    /// Draw the histories of a run
    Plot(PlotArgs),
    /// Measure what a step costs, and its parts
    Bench(BenchArgs),
}

/// Which case, and what to change in it.
#[derive(Debug, Args)]
pub struct CaseArgs {
    /// Built-in case or TOML file
    pub case: String,
    /// Replace a value of the case, such as time.step=0.01 (`none` removes a key or table); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// `undula run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// The case
    #[command(flatten)]
    pub case: CaseArgs,
    /// Output directory [default: out/NAME of the case]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Number of threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Go on from the last checkpoint in the output directory
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Replace the run in the output directory, completed or not
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Print the scaled residual after every Newton iteration
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
}

/// `undula check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Built-in case or TOML file
    #[arg(required_unless_present = "from")]
    pub case: Option<String>,
    /// Replace a value of the case, such as time.step=0.01 (`none` removes a key or table); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Compare all Jacobians at one state; exit code 1 if they do not agree
    #[arg(long, conflicts_with = "toml", group = "at_state")]
    pub jacobian: bool,
    /// Another random state
    #[arg(long, value_name = "N", default_value_t = 1, requires = "jacobian")]
    pub seed: u32,
    /// Print the case as TOML with all defaults instead of the summary
    #[arg(long)]
    pub toml: bool,
    /// Compute inf-sup constants and condition numbers, as section 5.3 of the book warns of them
    #[arg(long, conflicts_with = "toml", group = "at_state")]
    pub inf_sup: bool,
    /// Take the state of the last checkpoint of the run in this directory, and its case where none is named
    #[arg(long, value_name = "RUN_DIR", requires = "at_state")]
    pub from: Option<PathBuf>,
}

/// `undula new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// Built-in case to start from
    pub name: String,
    /// File to write [default: NAME.toml]
    pub file: Option<PathBuf>,
    /// Overwrite the file if it exists
    #[arg(long)]
    pub force: bool,
}

/// `undula compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Output directory of a run
    pub dir: PathBuf,
    /// Output directory of a second run, to be set beside the first
    pub other: Option<PathBuf>,
    /// Reference file to compare with [default: that of the built-in case named by `reference` in the case]
    #[arg(long, value_name = "FILE", conflicts_with = "other")]
    pub reference: Option<PathBuf>,
}

/// `undula plot`.
#[derive(Debug, Args)]
pub struct PlotArgs {
    /// Output directory of a run
    pub dir: PathBuf,
    /// Directory to write the pictures into [default: DIR/plots]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
}

/// `undula bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Built-in case or TOML file
    #[arg(default_value = "fsi3")]
    pub case: String,
    /// Start from the last checkpoint of the run in this directory, with its case
    #[arg(long, value_name = "RUN_DIR", conflicts_with = "case")]
    pub from: Option<PathBuf>,
    /// Replace a value of the case, such as time.step=0.01 (`none` removes a key or table); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Steps of a repetition; 0 leaves them out
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub steps: u16,
    /// Repetitions, all from the same state
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    pub repeat: u16,
    /// Do not measure kernels one by one
    #[arg(long)]
    pub no_kernels: bool,
    /// Write the matrices of a step here, for `cargo bench --bench factor -- FILE`
    #[arg(long, value_name = "DIR")]
    pub matrices: Option<PathBuf>,
    /// File for the report in JSON [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// No table on standard error
    #[arg(short, long)]
    pub quiet: bool,
}

/// The number of threads asked for, or all cores.
pub fn threads(asked: Option<u16>) -> usize {
    match asked {
        Some(n) => usize::from(n),
        None => std::thread::available_parallelism().map_or(1, usize::from),
    }
}

/// Exit code of a run that broke down.
pub const BREAKDOWN: u8 = 3;
/// Exit code of an interrupted run.
pub const INTERRUPTED: u8 = 130;

/// Tells what is wrong with the input; exit code 2, as for mistakes on the command line.
pub fn bad_input(message: impl Display) -> anyhow::Result<ExitCode> {
    say(message);
    Ok(ExitCode::from(2))
}

/// Prints a line on standard error. A reader that has gone, such as `head`, is no failure, nor is anything else there:
/// a computation does not depend on who listens.
pub fn say(line: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Prints notes on standard error.
pub fn say_notes(notes: &[String]) {
    notes.iter().for_each(|note| say(format_args!("note: {note}")));
}

/// Prints on standard output what is there for people only, as [`say`] does.
pub fn show(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// An error and its causes in one line; a cause that has been quoted by what it led to is not repeated.
pub fn with_causes(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |text, cause| match text.contains(&cause) {
        true => text,
        false if text.is_empty() => cause,
        false => format!("{text}: {cause}"),
    })
}

/// Writes to standard output. A reader that has seen enough, such as `head`, is no failure.
pub fn print(text: &str) -> anyhow::Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(e.into()),
        _ => Ok(ExitCode::SUCCESS),
    }
}
