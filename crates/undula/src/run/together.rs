//! A run of several processes: the first one writes, the others follow it, and all agree before every step.

use super::identity::{mesh_hash, table_hashes};
use super::watch::Watch;
use super::{Flow, RunOptions};
use crate::case::Case;
use crate::error::Error;
use crate::loops::width::best_lanes;
use crate::output::hash;
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
    let watch = outcome.as_ref().err().and_then(|error| Watch::of(team, error));
    let agreed = team.agree(wish);
    drop(watch);
    match agreed.map_err(Error::Processes)? {
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
    let fields = match simulation.crew() {
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
