//! The run of a process that has no files of its own.

use super::checkpoint::restore_step;
use super::share::serve;
use super::summary::{Spent, summary_of};
use super::together::{compare_states, settle, settle_with};
use super::{Flow, Observer, RunOptions};
use crate::error::Error;
use crate::output::{Status, Summary};
use crate::parallel::Team;
use crate::simulation::Simulation;

/// The run of a process that writes nothing, or the pieces of its own.
pub(super) fn follow<const D: usize>(
    mut simulation: Simulation<D>,
    options: &RunOptions,
    observer: &mut dyn Observer<D>,
    team: &mut Team,
) -> Result<Summary, Error> {
    if options.resume {
        // The first process has found the checkpoint.
        settle(team, Ok(Flow::Continue))?;
        let step = team.told(0.0).map_err(Error::Processes)? as u64;
        let restored = restore_step(&mut simulation, &options.directory, step);
        settle_with(team, restored)?;
        compare_states(team, &simulation)?;
    }
    // It has opened its files.
    settle(team, Ok(Flow::Continue))?;
    observer.start(&simulation);
    let spent = Spent { wall: 0.0, output: 0.0 };
    if simulation.crew().is_some() {
        let status = serve(&mut simulation, &options.directory, (observer, team))?;
        return Ok(summary_of(&simulation, status, None, spent));
    }
    settle(team, Ok(Flow::Continue))?;
    let mut status = Status::Completed;
    while !simulation.finished() {
        let outcome = simulation.step().map(|row| observer.after_step(&simulation, &row));
        // Nobody reads them here.
        let rows = simulation.history.len();
        simulation.history.drain(..rows.saturating_sub(2));
        let is_over = simulation.finished();
        if settle(team, outcome)? == Flow::Stop && !is_over {
            status = Status::Interrupted;
            break;
        }
    }
    Ok(summary_of(&simulation, status, None, spent))
}
