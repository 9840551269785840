//! A run of several processes: the first one writes, the others follow it, and all agree before every step.

use super::checkpoint::restore_step;
use super::identity::{mesh_hash, table_hashes};
use super::summary::{Spent, summary_of};
use super::{Flow, Observer, RunOptions, share};
use crate::case::Case;
use crate::error::Error;
use crate::loops::width::best_lanes;
use crate::output::{Status, Summary, hash};
use crate::parallel::{Agreed, Team, Wish};
use crate::simulation::Simulation;

/// What this process does next after `outcome`, which the others hear of. An error that another one has, too, is told by
/// the first of them.
pub(super) fn settle(team: &mut Team, outcome: Result<Flow, Error>) -> Result<Flow, Error> {
    let wish = match &outcome {
        Ok(Flow::Continue) => Wish::GoOn,
        Ok(Flow::Stop) => Wish::Stop,
        // The one that knows says what it is.
        Err(Error::Elsewhere { .. }) => Wish::GoOn,
        Err(error) => Wish::Fail(error.exit_code()),
    };
    match team.agree(wish).map_err(Error::Processes)? {
        Agreed::GoOn => outcome.map(|_| Flow::Continue),
        Agreed::Stop => Ok(Flow::Stop),
        Agreed::Fail { first, .. } if first == team.rank() => outcome,
        Agreed::Fail { code, .. } => Err(Error::Elsewhere { code }),
    }
}

/// [`settle`] of something that was made.
pub(super) fn settle_with<T>(team: &mut Team, made: Result<T, Error>) -> Result<T, Error> {
    match made {
        Ok(made) => settle(team, Ok(Flow::Continue)).map(|_| made),
        Err(error) => Err(settle(team, Err(error)).err().unwrap_or(Error::Elsewhere { code: 1 })),
    }
}

/// Whether all have the same case and the same program, and compute with vectors of one width: their numbers must not
/// differ in a bit, or their ways part.
///
/// # Errors
/// What is different, on all processes.
pub(super) fn compare(team: &mut Team, case: &Case, options: &RunOptions) -> Result<(), Error> {
    if team.size() == 1 {
        return Ok(());
    }
    let number = |text: &str| number_of(text.as_bytes());
    let program = format!("{} {}", env!("CARGO_PKG_VERSION"), options.commit.as_deref().unwrap_or_default());
    let compared = [
        (number(&program), "another version of the program"),
        (best_lanes() as f64, "a processor with vectors of another width"),
        (number(&case.to_toml()), "another case"),
        (number(&mesh_hash(case).unwrap_or_default()), "another mesh file"),
        (number(&format!("{:?}", table_hashes(case))), "another table of values"),
    ];
    for (own, what) in compared {
        if let Some(rank) = team.differing(&[own]).map_err(Error::Processes)? {
            return Err(Error::Differing { rank, what });
        }
    }
    Ok(())
}

/// A number of these bytes that others hardly have.
fn number_of(bytes: &[u8]) -> f64 {
    f64::from(u32::from_str_radix(&hash(bytes)[..8], 16).unwrap_or(0))
}

/// Whether all begin with the same state, at the same time: it may come from files.
///
/// # Errors
/// The first process that has another one, on all processes.
pub(super) fn compare_states<const D: usize>(
    team: &mut Team,
    simulation: &Simulation<D>,
) -> Result<(), Error> {
    if team.size() == 1 {
        return Ok(());
    }
    let state = &simulation.stepper.new;
    let fields = match share::crew_of(simulation) {
        None => vec![&state.v, &state.u, &state.p, &state.s],
        // Each has its own part of it.
        Some(_) => vec![],
    };
    let numbers = fields.into_iter().flatten();
    let bytes: Vec<u8> =
        numbers.chain([&simulation.time()]).flat_map(|number| number.to_le_bytes()).collect();
    match team.differing(&[number_of(&bytes)]).map_err(Error::Processes)? {
        Some(rank) => Err(Error::Differing { rank, what: "another state to begin with" }),
        None => Ok(()),
    }
}

/// The run of a process that writes nothing.
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
    if share::crew_of(&simulation).is_some() {
        let status = share::serve(&mut simulation, &options.directory, (observer, team))?;
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
