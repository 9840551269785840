//! `undula bench`: what a step costs, and its parts.

use crate::args::{BREAKDOWN, BenchArgs, bad_input, print, say, say_notes, threads};
use crate::{check, run};
use anyhow::Context;
use std::process::ExitCode;
use undula::bench::{Options, Report, measure, write_matrices};
use undula::case::Case;
use undula::error::Error;
use undula::output::write_atomic;
use undula::simulation::SetUp;
use undula::system::Dim;

/// Measures, and writes the report.
pub fn run(args: &BenchArgs) -> anyhow::Result<ExitCode> {
    if let Some(output) = args.output.as_ref().filter(|output| output.is_dir()) {
        return bad_input(format_args!("-o {}: this is a directory; a file is needed", output.display()));
    }
    let case = match check::load_from(args.from.as_deref(), &args.case, &args.set)? {
        Ok(case) => case,
        Err(code) => return Ok(code),
    };
    let report = match case.mesh.dimension {
        3 => report::<3>(args, case),
        _ => report::<2>(args, case),
    };
    match report {
        Ok(report) => write(args, &report),
        Err(Error::Breakdown(failure)) => {
            say(format_args!("breakdown: {failure}"));
            Ok(ExitCode::from(BREAKDOWN))
        }
        Err(error) => run::failed(error),
    }
}

fn report<const D: usize>(args: &BenchArgs, case: Case) -> Result<Report, Error>
where
    Dim<D>: SetUp<D>,
{
    let options = Options {
        steps: usize::from(args.steps),
        repeat: usize::from(args.repeat),
        kernels: !args.no_kernels,
    };
    // The state is that of the run in `from`.
    let mut simulation = match args.from {
        Some(_) => Dim::<D>::at_rest(case, threads(args.threads))?,
        None => Dim::<D>::set_up(case, threads(args.threads))?,
    };
    if let Some(from) = &args.from {
        say_notes(&undula::run::restore_latest(&mut simulation, from)?);
    }
    if let Some(directory) = &args.matrices {
        write_matrices(&mut simulation, directory)?;
    }
    measure(&mut simulation, &options)
}

fn write(args: &BenchArgs, report: &Report) -> anyhow::Result<ExitCode> {
    if !args.quiet {
        say(report.to_string().trim_end());
    }
    let text = serde_json::to_string_pretty(report)? + "\n";
    match &args.output {
        None => print(&text),
        Some(path) => {
            write_atomic(path, |file| std::io::Write::write_all(file, text.as_bytes()))
                .context("the report could not be written")?;
            Ok(ExitCode::SUCCESS)
        }
    }
}
