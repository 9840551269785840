//! `undula check --jacobian`: all Jacobians of a case beside each other.

use crate::args::{CheckArgs, print, say_notes};
use crate::{check, run};
use std::process::ExitCode;
use undula::case::Case;
use undula::error::Error;
use undula::run::restore_latest;
use undula::simulation::SetUp;
use undula::system::Dim;
use undula::verification::jacobians::{At, JacobianReport, compare};

/// Compares them at a random state, or at that of a run; exit code 1 if they do not agree.
pub fn run(args: &CheckArgs) -> anyhow::Result<ExitCode> {
    let case = match check::of(args)? {
        Ok(case) => case,
        Err(code) => return Ok(code),
    };
    let report = match case.mesh.dimension {
        3 => report::<3>(args, case),
        _ => report::<2>(args, case),
    };
    match report {
        Ok(report) => {
            let printed = print(&report.to_string())?;
            Ok(if report.agrees() { printed } else { ExitCode::FAILURE })
        }
        Err(error) => run::failed(error),
    }
}

fn report<const D: usize>(args: &CheckArgs, case: Case) -> Result<JacobianReport, Error>
where
    Dim<D>: SetUp<D>,
{
    // The state is that of the run in `from`.
    let mut simulation = match args.from {
        Some(_) => Dim::<D>::at_rest(case, 1)?,
        None => Dim::<D>::set_up(case, 1)?,
    };
    let at = match &args.from {
        Some(from) => {
            say_notes(&restore_latest(&mut simulation, from)?);
            At::Present
        }
        None => At::Random { seed: u64::from(args.seed) },
    };
    Ok(compare(&mut simulation, at)?)
}
