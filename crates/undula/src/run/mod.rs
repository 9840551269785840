//! A computation with its files: history, fields, checkpoints, summary.

mod breakdown;
mod checkpoint;
mod fields;
mod files;
mod identity;
mod inflow;
mod resume;
mod rows;
mod summary;
mod window;

pub use breakdown::describe as breakdown_of;
pub use checkpoint::restore_latest;
pub use fields::{fields, snapshot, written_fields};
pub use inflow::{Inflow, inflow};
pub use summary::{Spent, summary_of};

use crate::case::Case;
use crate::error::Error;
use crate::output::{Status, Summary};
use crate::simulation::{Row, SetUp, Simulation};
use crate::system::Dim;
use files::Run;
pub(crate) use identity::mesh_hash;
use resume::again;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Where and how to run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Output directory.
    pub directory: PathBuf,
    /// Threads.
    pub threads: usize,
    /// Replace a run that is there.
    pub force: bool,
    /// Go on with an unfinished run, or with a completed one to a later end.
    pub resume: bool,
    /// Commit of the source of the program, which the summary names.
    pub commit: Option<String>,
}

/// Whether to go on.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Yes.
    Continue,
    /// Stop here, as if interrupted.
    Stop,
}

/// Watches a run.
pub trait Observer<const D: usize = 2> {
    /// Called once before the first step.
    fn start(&mut self, simulation: &Simulation<D>) {
        let _ = simulation;
    }
    /// Something that the user should know: the run goes on, but not as expected.
    fn note(&mut self, note: &str) {
        let _ = note;
    }
    /// Ends the run when it is set: after the step, or within it before the next iteration of Newton's method.
    fn stop(&self) -> Option<Arc<AtomicBool>> {
        None
    }
    /// Called after every step.
    fn after_step(&mut self, simulation: &Simulation<D>, row: &Row) -> Flow;
}

/// Run `case`, a case of the plane, to its end and write everything into the directory; the summary says how it ended.
///
/// # Errors
/// Problems with the case, its mesh, or files. A breakdown is no error: the summary has that status.
pub fn run(case: Case, options: &RunOptions, observer: &mut dyn Observer) -> Result<Summary, Error> {
    run_in(case, options, observer)
}

/// [`run`] of a case in space.
///
/// # Errors
/// As [`run`].
pub fn run_in_space(
    case: Case,
    options: &RunOptions,
    observer: &mut dyn Observer<3>,
) -> Result<Summary, Error> {
    run_in(case, options, observer)
}

fn run_in<const D: usize>(
    case: Case,
    options: &RunOptions,
    observer: &mut dyn Observer<D>,
) -> Result<Summary, Error>
where
    Dim<D>: SetUp<D>,
{
    // Everything that can be wrong with the input is found before a file is touched.
    let simulation = match options.resume {
        true => again(case, options)?,
        false => Dim::<D>::set_up(case, options.threads)?,
    };
    run_simulation(simulation, options, observer)
}

/// [`run`] of a simulation that may have terms and functionals of its own; one that resumes has those of the first run.
///
/// # Errors
/// As [`run`].
#[doc(hidden)]
pub fn run_simulation<const D: usize>(
    mut simulation: Simulation<D>,
    options: &RunOptions,
    observer: &mut dyn Observer<D>,
) -> Result<Summary, Error> {
    simulation.stepper.newton.stop = observer.stop();
    let mut run = if options.resume {
        Run::resume(simulation, &options.directory, observer)?
    } else {
        Run::create(simulation, options)?
    };
    run.commit = options.commit.clone();
    observer.start(&run.simulation);
    let result = run.advance(observer);
    let (status, breakdown, error) = match result {
        Ok(Flow::Continue) => (Status::Completed, None, None),
        Ok(Flow::Stop) => (Status::Interrupted, None, None),
        Err(Error::Breakdown(failure)) if failure.is_stop() => (Status::Interrupted, None, None),
        Err(Error::Breakdown(failure)) => {
            let breakdown = breakdown::describe(&run.simulation, &failure);
            let written = run.directory.write_breakdown(Some(&breakdown::table(&breakdown, &failure)));
            (Status::Breakdown, Some(breakdown), written.err().map(Error::Output))
        }
        Err(error) => (Status::Failed, None, Some(error)),
    };
    let closed = run.close(status, breakdown);
    match error {
        Some(error) => Err(error),
        None => closed,
    }
}
