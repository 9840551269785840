//! The command line: its arguments, and the functions for output that all subcommands share.

// For tests, too, which have this file elsewhere.
#[path = "args/log.rs"]
mod log;
#[path = "args/plot.rs"]
mod plot;

use clap::{Args, Parser, Subcommand};
pub use log::{Log, event, log_as, say, say_notes, silence, speak_as, tell};
pub use plot::{AnimatedField, Plane, PlotArgs, SurfaceField};
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Finite element solver for fluid-structure interaction in ALE coordinates.
#[derive(Debug, Parser)]
#[command(name = "undula", version, about, after_help = EXIT_CODES)]
pub struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 completed, 1 failed, 2 bad input, 3 breakdown of the computation, \
                          130 interrupted.";

/// One arm per subcommand.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a case
    Run(RunArgs),
    /// Validate a case and print a summary, without running it
    Check(CheckArgs),
    /// Compute eigenfrequencies of the solid, in vacuum and with the added mass of the fluid
    Modes(ModesArgs),
    /// List the built-in cases
    Cases,
    /// List what can solve linear systems here beside the program itself (PETSc and its MPI), and what is missing
    Engines,
    /// List the keys of a case with units, default values and meanings
    Keys(KeysArgs),
    /// Say what a word of the output or of a case means
    Explain(ExplainArgs),
    /// Copy a built-in case to a file, or write one for a mesh, as a starting point
    New(NewArgs),
    /// Compare results with published values or with another run
    Compare(CompareArgs),
    /// Plot histories and fields of a run
    Plot(PlotArgs),
    /// Write a page about a run: results, histories, a player of the fields, the case; it needs no network
    Report(ReportArgs),
    /// Compute a study: many runs, and a page with their tables, figures and statements
    Study(StudyArgs),
    /// Recompute the numerical studies of chapter 5 of the book, published numbers beside computed ones
    Reproduce(ReproduceArgs),
    /// Measure the time of a step, of its phases and of its kernels
    Bench(BenchArgs),
    /// Print completions for a shell
    Completions(CompletionsArgs),
    /// Write manual pages, undula.1 and one for each subcommand
    Man(ManArgs),
}

/// Which case, and what to change in it.
#[derive(Debug, Args)]
pub struct CaseArgs {
    /// Built-in case or TOML file
    pub case: String,
    /// Set a value of the case, such as time.step=0.01 (`none` removes the key or table); may be repeated
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
    /// Number of threads [default: all cores]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Continue from the last checkpoint in the output directory
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Overwrite the run in the output directory, completed or not
    #[arg(long)]
    pub force: bool,
    /// Serve the page of the run on this machine while it goes on, at http://127.0.0.1:PORT/ [default: a free port]
    #[arg(long, value_name = "PORT", require_equals = true, num_args = 0..=1, default_missing_value = "0")]
    pub live: Option<u16>,
    /// Print errors only; draw no pictures and write no report.html
    #[arg(short, long)]
    pub quiet: bool,
    /// Print the scaled residual after every Newton iteration
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// What standard error has: text for people, or one JSON object a line for programs (with --quiet, too)
    #[arg(long, value_enum, value_name = "FORM", default_value_t = Log::Text)]
    pub log: Log,
}

/// `undula check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Built-in case or TOML file
    #[arg(required_unless_present = "from")]
    pub case: Option<String>,
    /// Set a value of the case, such as time.step=0.01 (`none` removes the key or table); may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Compare every Jacobian with finite differences at one state; exit code 1 if they do not agree
    #[arg(long, conflicts_with = "toml", group = "at_state")]
    pub jacobian: bool,
    /// Seed of the random state at which the Jacobians are compared
    #[arg(long, value_name = "N", default_value_t = 1, requires = "jacobian")]
    pub seed: u32,
    /// Print the case as TOML with all defaults, instead of the summary
    #[arg(long)]
    pub toml: bool,
    /// Compute inf-sup constants and condition numbers (book, section 5.3)
    #[arg(long, conflicts_with = "toml", group = "at_state")]
    pub inf_sup: bool,
    /// Use the state of the last checkpoint of this run (and its case, unless CASE is given)
    #[arg(long, value_name = "RUN_DIR", requires = "at_state")]
    pub from: Option<PathBuf>,
}

/// `undula modes`.
#[derive(Debug, Args)]
pub struct ModesArgs {
    /// The case
    #[command(flatten)]
    pub case: CaseArgs,
    /// Number of modes, from the lowest frequency on
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub count: u16,
    /// Directory for modes.csv and the shapes modes.vtu, new or empty [default: no files]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Number of threads [default: all cores]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

/// `undula keys`.
#[derive(Debug, Args)]
#[command(
    after_help = "Numbers may have a unit, as in \"120 mmHg\"; expressions may take values from a file, as in \
                        table(\"inflow.csv\", t)."
)]
pub struct KeysArgs {
    /// A key, a table, a part of a key or of a value; `*` and `?` stand for any characters [default: all keys]
    pub pattern: Option<String>,
    /// Print Markdown, as in docs/keys.md
    #[arg(long)]
    pub markdown: bool,
    /// Print the JSON Schema of case files, for editors
    #[arg(long, conflicts_with_all = ["pattern", "markdown"])]
    pub schema: bool,
}

/// `undula explain`.
#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// A word of a message, a column of history.csv, a name of summary.json, a key or a value
    pub word: String,
}

/// `undula completions`.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// `undula man`.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Directory of the pages
    pub dir: PathBuf,
}

/// `undula new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// Built-in case to start from; with --mesh the file to write [default: that of the mesh, ending with .toml]
    #[arg(required_unless_present = "mesh")]
    pub name: Option<String>,
    /// File to write, `-` for standard output [default: NAME.toml]
    #[arg(conflicts_with = "mesh")]
    pub file: Option<PathBuf>,
    /// Start from this Gmsh file instead: a case with all of its regions and boundaries
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Overwrite the file if it exists
    #[arg(long)]
    pub force: bool,
}

/// `undula compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Output directory of a run
    pub dir: PathBuf,
    /// Output directory of a second run to compare with
    pub other: Option<PathBuf>,
    /// Reference file to compare with [default: that of the built-in case named by `reference` in the case]
    #[arg(long, value_name = "FILE", conflicts_with = "other")]
    pub reference: Option<PathBuf>,
}

/// `undula report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Output directory of a run
    pub dir: PathBuf,
    /// File of the page [default: DIR/report.html]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Cut a run in three dimensions by this plane, such as x=0.2 [m]; z alone is the middle of the domain; may be
    /// repeated [default: across the shortest side of the domain, in its middle]
    #[arg(long, value_name = "PLANE", value_parser = plot::plane)]
    pub cut: Vec<Plane>,
}

/// How the runs of a study are computed.
#[derive(Clone, Debug, Args)]
pub struct Common {
    /// Directory of the page and of the runs [default: out/NAME of the study, of the book out/chapter-5]; what an
    /// earlier call left there goes on
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Coarser or shorter runs: take the settings of `[quick]`, and leave out runs that are `full-only`
    #[arg(long)]
    pub quick: bool,
    /// Replace runs that were computed with other settings
    #[arg(long)]
    pub force: bool,
    /// Compute nothing: write the page from the runs that are there
    #[arg(long, conflicts_with = "force")]
    pub collect: bool,
    /// Number of threads [default: all cores]; runs are computed side by side
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// `undula study`.
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// The study, a TOML file; with --converge a built-in case or a case file
    pub file: String,
    /// Refine mesh and step of a case; show orders and extrapolated values of its functionals, with uncertainties
    #[arg(long, conflicts_with = "quick")]
    pub converge: bool,
    /// Number of meshes, and of steps; three at least
    #[arg(long, value_name = "N", default_value_t = 3, requires = "converge",
        value_parser = clap::value_parser!(u8).range(3..=6))]
    pub levels: u8,
    /// Set a value of the case, such as time.step=0.01; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "converge")]
    pub set: Vec<String>,
    /// How runs are computed
    #[command(flatten)]
    pub common: Common,
}

/// `undula reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArgs {
    /// Studies [default: all]
    pub studies: Vec<String>,
    /// List the studies
    #[arg(long)]
    pub list: bool,
    /// How runs are computed
    #[command(flatten)]
    pub common: Common,
}

/// `undula bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Built-in case or TOML file
    #[arg(default_value = "fsi3")]
    pub case: String,
    /// Start from the last checkpoint of this run, and use its case
    #[arg(long, value_name = "RUN_DIR", conflicts_with = "case")]
    pub from: Option<PathBuf>,
    /// Set a value of the case, such as time.step=0.01 (`none` removes the key or table); may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Number of time steps per repetition; 0 skips the steps
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub steps: u16,
    /// Number of repetitions, all from the same state
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    pub repeat: u16,
    /// Do not measure the kernels
    #[arg(long)]
    pub no_kernels: bool,
    /// Write the matrices of a step to this directory, for `cargo bench --bench factor -- FILE`
    #[arg(long, value_name = "DIR")]
    pub matrices: Option<PathBuf>,
    /// File for the JSON report [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Do not print the table on standard error
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

/// Prints a mistake in the input and returns exit code 2, as for mistakes on the command line.
pub fn bad_input(message: impl Display) -> anyhow::Result<ExitCode> {
    tell("error", message);
    Ok(ExitCode::from(2))
}

/// Prints text for people on standard output and ignores errors, as [`say`] does.
pub fn show(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// An error and its causes in one line. A cause whose text is already part of the line is not repeated.
pub fn with_causes(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |text, cause| match text.contains(&cause) {
        true => text,
        false if text.is_empty() => cause,
        false => format!("{text}: {cause}"),
    })
}

/// Writes to standard output. A pipe that the reader has closed (such as `head`) is not a failure.
pub fn print(text: &str) -> anyhow::Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(e.into()),
        _ => Ok(ExitCode::SUCCESS),
    }
}
