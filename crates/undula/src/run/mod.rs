//! A computation with its files: history, fields, checkpoints, summary.

mod breakdown;
mod checkpoint;
mod fields;
mod files;
mod follow;
mod identity;
mod inflow;
mod resume;
mod rows;
mod share;
mod summary;
mod together;
mod watch;
mod window;

pub use breakdown::describe as breakdown_of;
pub use checkpoint::restore_latest;
pub use fields::{fields, snapshot, written_fields};
pub use inflow::{Inflow, inflow};
pub use summary::{Spent, summary_of};

use crate::algebra::petsc;
use crate::case::Case;
use crate::error::Error;
use crate::output::{Status, Summary};
use crate::parallel::Team;
use crate::simulation::{Row, SetUp, Simulation, with_start};
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
    run_together(case, options, observer, &mut Team::alone())
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
    run_together(case, options, observer, &mut Team::alone())
}

/// [`run`] by the processes of `team`. Each has the whole state and takes every step; the first one writes. Of the systems
/// each solves its share, where PETSc solves them.
///
/// # Errors
/// As [`run`]; [`Error::Elsewhere`] where another process says what went wrong.
pub fn run_together<const D: usize>(
    case: Case,
    options: &RunOptions,
    observer: &mut dyn Observer<D>,
    team: &mut Team,
) -> Result<Summary, Error>
where
    Dim<D>: SetUp<D>,
{
    together::compare(team, &case, options)?;
    if team.size() > 1 && !options.resume {
        // Where one finds no start, the others would wait for it in PETSc.
        together::settle_with(team, with_start(case.clone()))?;
    }
    // Everything that can be wrong with the input is found before a file is touched.
    let simulation = match options.resume {
        true => again(case, options, team.crew()),
        false => Dim::<D>::set_up_by(case, options.threads, team.crew()),
    };
    let simulation = together::settle_with(team, simulation)?;
    together::compare_states(team, &simulation)?;
    let result = match team.is_first() {
        true => lead(simulation, options, observer, team),
        false => follow::follow(simulation, options, observer, team),
    };
    // What follows, such as the page about the run, is done by one of them.
    petsc::part();
    result
}

/// [`run`] of a simulation that may have terms and functionals of its own; one that resumes has those of the first run.
///
/// # Errors
/// As [`run`].
#[doc(hidden)]
pub fn run_simulation<const D: usize>(
    simulation: Simulation<D>,
    options: &RunOptions,
    observer: &mut dyn Observer<D>,
) -> Result<Summary, Error> {
    lead(simulation, options, observer, &mut Team::alone())
}

/// The run of the process that writes.
fn lead<const D: usize>(
    mut simulation: Simulation<D>,
    options: &RunOptions,
    observer: &mut dyn Observer<D>,
    team: &mut Team,
) -> Result<Summary, Error> {
    // Several processes stop after a step, together: one that left the iteration would be missing in the next solve.
    simulation.stepper.newton.stop = observer.stop().filter(|_| team.size() == 1);
    let mut run = match options.resume {
        true => Run::resume(simulation, &options.directory, observer, team)?,
        false => together::settle_with(team, Run::create(simulation, options))?,
    };
    run.commit = options.commit.clone();
    observer.start(&run.simulation);
    let result = run.advance(observer, team);
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
