//! A computation with its files: history, fields, checkpoints, summary.

mod breakdown;
mod checkpoint;
mod fields;
mod identity;
mod inflow;

pub use checkpoint::restore_latest;
pub use fields::snapshot;
pub use inflow::{Inflow, inflow};

use crate::case::Case;
use crate::error::Error;
use crate::functional::balance::Balance;
use crate::output::{
    Breakdown, Checkpoint, Collection, HistoryWriter, Phases, Precision, Provenance, RunDirectory, Status,
    Summary, hash, peak_memory, write_vtu,
};
use crate::output::{OutputError, text_of};
use crate::results::computed::case_of;
use crate::simulation::{Row, Simulation};
use checkpoint::{Found, Metadata, OfRun, Unfit, newest, restore};
use identity::changes;
pub(crate) use identity::mesh_hash;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// How often a run looks whether its files are still there, besides when it writes one.
const LOOK: Duration = Duration::from_millis(500);

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
pub trait Observer {
    /// Called once before the first step.
    fn start(&mut self, simulation: &Simulation) {
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
    fn after_step(&mut self, simulation: &Simulation, row: &Row) -> Flow;
}

/// Run `case` to its end and write everything into the directory; the summary says how it ended.
///
/// # Errors
/// Problems with the case, its mesh, or files. A breakdown is no error: the summary has that status.
pub fn run(case: Case, options: &RunOptions, observer: &mut dyn Observer) -> Result<Summary, Error> {
    // Everything that can be wrong with the input is found before a file is touched.
    let mut simulation = match options.resume {
        true => again(case, options)?,
        false => Simulation::new(case, options.threads)?,
    };
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

/// A simulation with its open files.
struct Run {
    simulation: Simulation,
    directory: RunDirectory,
    history: HistoryWriter,
    collection: Collection,
    start: Instant,
    /// Seconds of the runs that this one continues.
    wall_before: f64,
    output_seconds: f64,
    last_fields: Option<u64>,
    last_checkpoint: Option<u64>,
    /// Whether it lies on the way to this end alone, as `cut` says.
    last_is_cut: bool,
    /// When the last checkpoint was written, or the run began.
    checkpoint_time: Instant,
    /// When the files were last looked for.
    looked: Instant,
    /// The last step that has a row in the history.
    recorded: u64,
    /// Hash of the mesh file.
    mesh: Option<String>,
    /// Commit of the source of the program.
    commit: Option<String>,
    /// The end \[s\] that the last steps were shortened for.
    cut: Option<f64>,
}

impl Run {
    fn create(simulation: Simulation, options: &RunOptions) -> Result<Run, Error> {
        let directory = RunDirectory::create(&options.directory, options.force).map_err(Error::Directory)?;
        let history = HistoryWriter::create(directory.history(), &columns(&simulation))?;
        let collection = Collection::create(directory.collection())?;
        let run = Run::new(simulation, directory, history, collection);
        run.write_case()?;
        run.directory.write_breakdown(None)?;
        Ok(run)
    }

    fn new(
        simulation: Simulation,
        directory: RunDirectory,
        history: HistoryWriter,
        collection: Collection,
    ) -> Run {
        let now = Instant::now();
        Run {
            mesh: mesh_hash(&simulation.case),
            commit: None,
            recorded: simulation.steps,
            simulation,
            directory,
            history,
            collection,
            start: now,
            wall_before: 0.0,
            output_seconds: 0.0,
            last_fields: None,
            last_checkpoint: None,
            last_is_cut: false,
            checkpoint_time: now,
            looked: now,
            cut: None,
        }
    }

    fn write_case(&self) -> Result<(), Error> {
        Ok(self.directory.write_case(&self.simulation.case.to_toml_in(self.directory.path()))?)
    }

    fn resume(mut simulation: Simulation, path: &Path, observer: &mut dyn Observer) -> Result<Run, Error> {
        let extended = ends_later(path, &simulation.case);
        let directory = RunDirectory::open_for_resume(path, extended).map_err(Error::Directory)?;
        let columns = columns(&simulation);
        let (found, notes) = newest(&directory, "start again with --force", |metadata| {
            fits(&simulation.case, metadata)?;
            HistoryWriter::can_resume(directory.history(), &columns, metadata.step, metadata.row.as_deref())
                .map_err(|e| Unfit::Unsound(e.to_string()))?;
            is_on_the_way(&simulation.case, metadata)
        })?;
        let Found { checkpoint, metadata } = found;
        restore(&mut simulation, &checkpoint, &metadata)?;
        let row = metadata.row.as_deref();
        let (history, before) = HistoryWriter::resume(directory.history(), &columns, metadata.step, row)?;
        let names: Arc<[String]> = simulation.names().into();
        simulation.history = before.rows.iter().map(|row| read_row(row, &names)).collect();
        let collection = Collection::resume(directory.collection(), metadata.clock[0])?;
        notes.iter().for_each(|note| observer.note(note));
        let mut run = Run::new(simulation, directory, history, collection);
        run.wall_before = metadata.wall_seconds;
        run.output_seconds = metadata.seconds[3];
        (run.last_checkpoint, run.last_is_cut) = (Some(metadata.step), metadata.cut.is_some());
        run.cut = metadata.cut.filter(|end| run.simulation.case.time.as_ref().is_some_and(|t| t.end == *end));
        if !run.are_fields_due() {
            // Written because the run ended here, which it does no longer.
            let name = run.directory.field_name(metadata.step);
            run.collection.remove(&name)?;
        }
        run.write_case()?;
        run.directory.write_breakdown(None)?;
        Ok(run)
    }

    /// Step until the end, a stop, or an error.
    fn advance(&mut self, observer: &mut dyn Observer) -> Result<Flow, Error> {
        self.write_summary(Status::Running, None)?;
        while !self.simulation.finished() {
            if self.simulation.next_is_cut() {
                // A run to a later end goes on from here.
                self.write_checkpoint()?;
                self.cut = self.simulation.case.time.as_ref().map(|time| time.end);
            }
            let row = self.simulation.step()?;
            self.record(&row)?;
            if observer.after_step(&self.simulation, &row) == Flow::Stop && !self.simulation.finished() {
                return Ok(Flow::Stop);
            }
        }
        Ok(Flow::Continue)
    }

    /// Write what is due after a step. The row comes first: a checkpoint without its row would lead nowhere.
    fn record(&mut self, row: &Row) -> Result<(), Error> {
        let start = Instant::now();
        self.history.append(&numbers(row))?;
        self.recorded = row.step;
        if start - self.looked >= LOOK {
            self.verify()?;
        }
        if self.are_fields_due() {
            self.write_fields()?;
        }
        if self.is_checkpoint_due() {
            self.write_checkpoint()?;
            self.write_summary(Status::Running, None)?;
        }
        self.output_seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn is_due(&self, every: usize) -> bool {
        let step = self.simulation.steps;
        every > 0 && step > 0 && step.is_multiple_of(every as u64)
    }

    fn are_fields_due(&self) -> bool {
        self.is_due(self.simulation.case.output.fields_every) || self.simulation.is_output_time()
    }

    fn is_checkpoint_due(&self) -> bool {
        let output = &self.simulation.case.output;
        let passed = self.checkpoint_time.elapsed().as_secs_f64() / 60.0;
        let late = output.checkpoint_minutes > 0.0 && passed >= output.checkpoint_minutes;
        self.simulation.case.time.is_some() && (self.is_due(output.checkpoint_every) || late)
    }

    /// Checks that the directory and the history are still those that the run has opened.
    fn verify(&mut self) -> Result<(), Error> {
        self.looked = Instant::now();
        self.directory.verify()?;
        Ok(self.history.verify()?)
    }

    fn write_fields(&mut self) -> Result<(), Error> {
        let step = self.simulation.steps;
        if self.last_fields == Some(step) {
            return Ok(());
        }
        self.verify()?;
        let name = self.directory.field_name(step);
        let stepper = &self.simulation.stepper;
        let output = &self.simulation.case.output;
        let snapshot = snapshot(&stepper.assembler.space, &stepper.new, output.deformed);
        let snapshot = if output.curved { snapshot } else { snapshot.linear() };
        write_vtu(self.directory.path().join(&name), &snapshot, stepper.time, Precision::Auto)?;
        self.collection.add(stepper.time, name)?;
        self.last_fields = Some(step);
        Ok(())
    }

    fn write_checkpoint(&mut self) -> Result<(), Error> {
        let step = self.simulation.steps;
        if self.last_checkpoint == Some(step) && Checkpoint::path(self.directory.checkpoints(), step).exists()
        {
            return Ok(());
        }
        self.verify()?;
        self.history.sync()?;
        let of_run = OfRun {
            output_seconds: self.output_seconds,
            wall_seconds: self.wall_before + self.start.elapsed().as_secs_f64(),
            mesh: &self.mesh,
            row: self
                .simulation
                .history
                .last()
                .filter(|row| row.step == step)
                .map(|row| text_of(&numbers(row))),
            cut: self.cut,
        };
        let checkpoint = checkpoint::of(&self.simulation, &of_run)?;
        // Of two on the way to this end alone the later one is enough: the other leads to later ends, too.
        let former = self.last_checkpoint.filter(|_| self.cut.is_some() && self.last_is_cut);
        checkpoint.save_instead(self.directory.checkpoints(), step, former)?;
        (self.last_checkpoint, self.last_is_cut) = (Some(step), self.cut.is_some());
        self.checkpoint_time = Instant::now();
        Ok(())
    }

    fn summary(&self, status: Status, breakdown: Option<Breakdown>) -> Summary {
        let simulation = &self.simulation;
        let newton = &simulation.stepper.newton;
        Summary {
            status,
            case: simulation.case.name.clone(),
            cells: simulation.stepper.assembler.space.mesh.n_cells(),
            unknowns: simulation.unknowns(),
            steps: simulation.steps,
            newton_steps: newton.counters.newton_steps as u64,
            jacobians: newton.counters.jacobians as u64,
            rejected_steps: simulation.adaptive.as_ref().map(|a| a.memory.rejected),
            factorizations: newton.counters.factorizations as u64,
            threads: simulation.threads(),
            wall_seconds: self.wall_before + self.start.elapsed().as_secs_f64(),
            phases: Phases {
                assembly: newton.seconds.assembly,
                factorization: newton.seconds.factorization,
                solve: newton.seconds.solve,
                output: self.output_seconds,
            },
            peak_memory_bytes: peak_memory(),
            mass_balance: simulation.balance.as_ref().and_then(Balance::mass),
            swept_volume: simulation.balance.as_ref().and_then(Balance::swept),
            functionals: simulation.statistics(),
            breakdown,
            provenance: Provenance {
                case_hash: std::fs::read(self.directory.case()).ok().map(|case| hash(&case)),
                mesh_hash: self.mesh.clone(),
                ..Provenance::now(self.commit.clone())
            },
        }
    }

    fn write_summary(&self, status: Status, breakdown: Option<Breakdown>) -> Result<Summary, Error> {
        let summary = self.summary(status, breakdown);
        summary.write(self.directory.summary())?;
        Ok(summary)
    }

    /// Write what is left to write: last fields, a checkpoint if the run can go on, the summary.
    fn close(mut self, status: Status, breakdown: Option<Breakdown>) -> Result<Summary, Error> {
        let start = Instant::now();
        // Where there is another directory now, nothing of this run belongs into it.
        self.directory.verify()?;
        let lost = self.verify().err();
        if lost.is_some() && !self.directory.history().exists() {
            self.write_history()?;
        }
        let transient = self.simulation.case.time.is_some();
        let fields = if self.simulation.history.is_empty() { Ok(()) } else { self.write_fields() };
        // A state whose row could not be written is kept nevertheless: the checkpoint has its row.
        let checkpoint = if transient { self.write_checkpoint() } else { Ok(()) };
        self.output_seconds += start.elapsed().as_secs_f64();
        let errors = [lost.map_or(Ok(()), Err), fields, checkpoint, self.check_files()];
        let failed = errors.iter().any(Result::is_err);
        // The summary is written even where the disk refused the rest: it is small.
        let summary = self.write_summary(if failed { Status::Failed } else { status }, breakdown)?;
        errors.into_iter().collect::<Result<(), Error>>()?;
        Ok(summary)
    }

    /// Write the history anew from memory.
    fn write_history(&mut self) -> Result<(), Error> {
        self.history = HistoryWriter::create(self.directory.history(), &columns(&self.simulation))?;
        for row in self.simulation.history.iter().filter(|row| row.step <= self.recorded) {
            self.history.append(&numbers(row))?;
        }
        Ok(())
    }

    /// Checks that no file of the run was removed; the case and the list of fields are written again.
    fn check_files(&self) -> Result<(), Error> {
        if !self.directory.case().exists() {
            self.write_case()?;
        }
        self.collection.restore()?;
        match self.collection.missing() {
            Some(path) => Err(OutputError::Lost { path, content: "others beside it" }.into()),
            None => Ok(()),
        }
    }
}

/// All columns of `history.csv`.
fn columns(simulation: &Simulation) -> Vec<String> {
    let mut columns: Vec<String> = ["step", "time", "force_time"].map(String::from).to_vec();
    columns.extend(simulation.names());
    columns.extend(["min_J", "newton_steps", "jacobians"].map(String::from));
    columns
}

/// A row in the order of the columns.
fn numbers(row: &Row) -> Vec<f64> {
    let mut numbers = vec![row.step as f64, row.time, row.force_time];
    numbers.extend(&row.values);
    numbers.extend([row.min_j, row.newton_steps as f64, row.jacobians as f64]);
    numbers
}

fn read_row(row: &[f64], names: &Arc<[String]>) -> Row {
    let n = names.len();
    Row {
        step: row[0] as u64,
        time: row[1],
        force_time: row[2],
        values: row[3..3 + n].to_vec(),
        min_j: row[3 + n],
        newton_steps: row[4 + n] as usize,
        jacobians: row[5 + n] as usize,
        names: names.clone(),
    }
}

/// The simulation of a run that is resumed. Its state comes from its own checkpoints, and its start, if another run
/// gave it, from its own case.
fn again(mut case: Case, options: &RunOptions) -> Result<Simulation, Error> {
    let initial = case.initial.take();
    let given = case.record.places.contains_key("time.start");
    if let (Some(_), false, Some(time)) = (&initial, given, &mut case.time)
        && let Some(former) = case_of(&options.directory).and_then(|former| former.time)
    {
        time.start = former.start;
    }
    let mut simulation = Simulation::new(case, options.threads)?;
    simulation.case.initial = initial;
    Ok(simulation)
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
