//! A run that goes on from its newest checkpoint.

use super::checkpoint::{Found, Metadata, Unfit, newest, restore};
use super::files::Run;
use super::identity::changes;
use super::rows::{ITERATIONS, columns, read_row};
use super::together::{compare_states, settle_with};
use super::{Observer, RunOptions};
use crate::case::{Case, Initial};
use crate::error::Error;
use crate::output::{Collection, HistoryWriter, RunDirectory};
use crate::parallel::{Crew, Team};
use crate::results::computed::case_of;
use crate::simulation::{SetUp, Simulation};
use crate::system::Dim;
use std::path::Path;
use std::sync::Arc;

/// What a run goes on from.
struct Past {
    directory: RunDirectory,
    /// Whether its history has a column of linear iterations.
    with_iterations: bool,
    columns: Vec<String>,
    found: Found,
    /// Why it is not the newest checkpoint.
    notes: Vec<String>,
}

/// The run in directory `path`, with the checkpoint that `simulation` can go on from.
fn past_of<const D: usize>(simulation: &Simulation<D>, path: &Path) -> Result<Past, Error> {
    let extended = ends_later(path, &simulation.case);
    let directory = RunDirectory::open_for_resume(path, extended).map_err(Error::Directory)?;
    // The solver may have been changed, the columns stay.
    let with_iterations = HistoryWriter::has_column(directory.history(), ITERATIONS);
    let columns = columns(simulation, with_iterations);
    let (found, notes) = newest(&directory, "start again with --force", |metadata| {
        fits(&simulation.case, metadata)?;
        HistoryWriter::can_resume(directory.history(), &columns, metadata.step, metadata.row.as_deref())
            .map_err(|e| Unfit::Unsound(e.to_string()))?;
        is_on_the_way(&simulation.case, metadata)
    })?;
    Ok(Past { directory, with_iterations, columns, found, notes })
}

impl<const D: usize> Run<D> {
    /// The run in directory `path`, whose simulation is set up anew. The others of the `team` restore their simulations
    /// at the same time: the kept Jacobian is factorised by all.
    pub fn resume(
        mut simulation: Simulation<D>,
        path: &Path,
        observer: &mut dyn Observer<D>,
        team: &mut Team,
    ) -> Result<Run<D>, Error> {
        let past = settle_with(team, past_of(&simulation, path))?;
        team.told(past.found.metadata.step as f64).map_err(Error::Processes)?;
        let restored = restore(&mut simulation, &past.found.checkpoint, &past.found.metadata);
        settle_with(team, restored)?;
        compare_states(team, &simulation)?;
        settle_with(team, Run::reopen(simulation, past, observer))
    }

    /// The files of the run, for the steps after the checkpoint.
    fn reopen(
        simulation: Simulation<D>,
        past: Past,
        observer: &mut dyn Observer<D>,
    ) -> Result<Run<D>, Error> {
        let Past { directory, with_iterations, columns, found, notes } = past;
        let (Found { checkpoint, metadata }, mut simulation) = (found, simulation);
        let row = metadata.row.as_deref();
        let (history, before) = HistoryWriter::resume(directory.history(), &columns, metadata.step, row)?;
        let names: Arc<[String]> = simulation.names().into();
        // For an observer; most of them go after the next step.
        simulation.history = before.rows.iter().map(|row| read_row(row, &names)).collect();
        let collection = Collection::resume(directory.collection(), metadata.clock[0])?;
        notes.iter().for_each(|note| observer.note(note));
        let mut run = Run::new(simulation, directory, history, collection);
        run.with_iterations = with_iterations;
        if let Some(window) = &mut run.window {
            window.restore(&checkpoint);
        }
        run.wall_before = metadata.wall_seconds;
        run.output_seconds = metadata.seconds[3];
        (run.last_checkpoint, run.last_is_cut) = (Some(metadata.step), metadata.cut.is_some());
        run.cut = metadata.cut.filter(|end| run.simulation.case.time.as_ref().is_some_and(|t| t.end == *end));
        if !run.are_fields_due() {
            // Written because the run ended here, which it does no longer.
            let step = metadata.step;
            run.collection.remove(&run.directory.field_name(step))?;
            run.collection.remove(&RunDirectory::shared_field_name(step))?;
        }
        run.write_case()?;
        run.directory.write_breakdown(None)?;
        Ok(run)
    }
}

/// The simulation of a run that is resumed. Its state comes from its own checkpoints, and its start, if another run
/// gave it, from its own case.
pub(super) fn again<const D: usize>(
    mut case: Case,
    options: &RunOptions,
    crew: Option<&Crew>,
) -> Result<Simulation<D>, Error>
where
    Dim<D>: SetUp<D>,
{
    let given = case.record.places.contains_key("time.start");
    if let (Some(Initial::From(_)), false, Some(time)) = (&case.initial, given, &mut case.time)
        && let Some(former) = case_of(&options.directory).and_then(|former| former.time)
    {
        time.start = former.start;
    }
    Dim::<D>::at_rest_by(case, options.threads, crew)
}

/// Whether `case` ends later than that of the run in `path`.
fn ends_later(path: &Path, case: &Case) -> bool {
    match (case_of(path).and_then(|former| former.time), &case.time) {
        (Some(former), Some(time)) => time.end > former.end,
        _ => false,
    }
}

/// Whether `case` can go on from a checkpoint.
fn fits(case: &Case, metadata: &Metadata) -> Result<(), Unfit> {
    let changes = changes(&metadata.case, metadata.mesh.as_deref(), case);
    if !changes.is_empty() {
        let message = format!(
            "the case has changed in more than its end, output and solvers: {}; start again with --force, or in \
             another directory",
            changes.join("; ")
        );
        return Err(Unfit::Refused(Error::Resume(message)));
    }
    let now = metadata.clock[0];
    match &case.time {
        Some(time) if time.end < now - 1e-9 * now.abs() => {
            let end = time.end;
            let message = format!("time.end = {end} s lies before it: the run has come to {now} s already");
            Err(Unfit::Refused(Error::Resume(message)))
        }
        _ => Ok(()),
    }
}

/// Whether a run of `case` passes where a checkpoint was taken.
fn is_on_the_way(case: &Case, metadata: &Metadata) -> Result<(), Unfit> {
    match (metadata.cut, &case.time) {
        (Some(end), Some(time)) if time.end != end => Err(Unfit::SecondChoice(format!(
            "the last step was shortened to land on t = {end} s; a run that goes on from there does not have the \
             bits of one to {} s from the start",
            time.end
        ))),
        _ => Ok(()),
    }
}
