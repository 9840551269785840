//! A computation with its files: history, fields, checkpoints, summary.

mod checkpoint;
mod fields;

pub use checkpoint::restore_latest;
pub use fields::snapshot;

use crate::error::Error;
use crate::functional::balance::Balance;
use crate::output::{
    Breakdown, Collection, HistoryWriter, Phases, Precision, RunDirectory, Status, Summary, peak_memory,
    write_vtu,
};
use crate::problem::case::Case;
use crate::simulation::{Row, Simulation};
use checkpoint::{identity, latest, restore};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where and how to run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Output directory.
    pub directory: PathBuf,
    /// Threads.
    pub threads: usize,
    /// Replace an unfinished run.
    pub force: bool,
    /// Go on with an unfinished run.
    pub resume: bool,
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
    /// Called after every step.
    fn after_step(&mut self, simulation: &Simulation, row: &Row) -> Flow;
}

/// Run `case` to its end and write everything into the directory; the summary says how it ended.
///
/// # Errors
/// Problems with the case, its mesh, or files. A breakdown is no error: the summary has that status.
pub fn run(case: Case, options: &RunOptions, observer: &mut dyn Observer) -> Result<Summary, Error> {
    // Everything that can be wrong with the input is found before a file is touched.
    let simulation = Simulation::new(case, options.threads)?;
    let mut run = if options.resume {
        Run::resume(simulation, &options.directory)?
    } else {
        Run::create(simulation, options)?
    };
    observer.start(&run.simulation);
    let result = run.advance(observer);
    let (status, breakdown, error) = match result {
        Ok(Flow::Continue) => (Status::Completed, None, None),
        Ok(Flow::Stop) => (Status::Interrupted, None, None),
        Err(Error::Breakdown(failure)) => {
            (Status::Breakdown, Some(describe(&run.simulation, &failure)), None)
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
}

impl Run {
    fn create(simulation: Simulation, options: &RunOptions) -> Result<Run, Error> {
        let directory = RunDirectory::create(&options.directory, options.force).map_err(Error::Directory)?;
        directory.write_case(&simulation.case.to_toml())?;
        let history = HistoryWriter::create(directory.history(), &columns(&simulation))?;
        let collection = Collection::create(directory.collection())?;
        Ok(Run {
            simulation,
            directory,
            history,
            collection,
            start: Instant::now(),
            wall_before: 0.0,
            output_seconds: 0.0,
            last_fields: None,
            last_checkpoint: None,
        })
    }

    fn resume(mut simulation: Simulation, path: &Path) -> Result<Run, Error> {
        let extended = ends_later(path, &simulation.case);
        let directory = RunDirectory::open_for_resume(path, extended).map_err(Error::Directory)?;
        let (checkpoint, metadata) = latest(&directory, "start again with --force")?;
        if metadata.case != identity(&simulation.case) {
            return Err(Error::Resume("the case has changed in more than its end time and output".into()));
        }
        restore(&mut simulation, &checkpoint, &metadata)?;
        let (history, before) =
            HistoryWriter::resume(directory.history(), &columns(&simulation), metadata.step)?;
        let n = simulation.names().len();
        simulation.history = before.rows.iter().map(|row| read_row(row, n)).collect();
        let collection = Collection::resume(directory.collection(), metadata.clock[0])?;
        directory.write_case(&simulation.case.to_toml())?;
        Ok(Run {
            simulation,
            directory,
            history,
            collection,
            start: Instant::now(),
            wall_before: metadata.wall_seconds,
            output_seconds: metadata.seconds[3],
            last_fields: None,
            last_checkpoint: Some(metadata.step),
        })
    }

    /// Step until the end, a stop, or an error.
    fn advance(&mut self, observer: &mut dyn Observer) -> Result<Flow, Error> {
        self.write_summary(Status::Running, None)?;
        while !self.simulation.finished() {
            let row = self.simulation.step()?;
            self.record(&row)?;
            if observer.after_step(&self.simulation, &row) == Flow::Stop && !self.simulation.finished() {
                return Ok(Flow::Stop);
            }
        }
        Ok(Flow::Continue)
    }

    /// Write what is due after a step.
    fn record(&mut self, row: &Row) -> Result<(), Error> {
        let start = Instant::now();
        let mut numbers = vec![row.step as f64, row.time, row.force_time];
        numbers.extend(&row.values);
        numbers.extend([row.min_j, row.newton_steps as f64, row.jacobians as f64]);
        self.history.append(&numbers)?;
        let due = |every: usize| every > 0 && row.step > 0 && row.step.is_multiple_of(every as u64);
        let output = &self.simulation.case.output;
        let (fields, checkpoint) = (due(output.fields_every), due(output.checkpoint_every));
        if fields || self.simulation.is_output_time() {
            self.write_fields()?;
        }
        if checkpoint {
            self.write_checkpoint()?;
            self.write_summary(Status::Running, None)?;
        }
        self.output_seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    fn write_fields(&mut self) -> Result<(), Error> {
        let step = self.simulation.steps;
        if self.last_fields == Some(step) {
            return Ok(());
        }
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
        if self.last_checkpoint == Some(step) {
            return Ok(());
        }
        self.history.sync()?;
        let wall_seconds = self.wall_before + self.start.elapsed().as_secs_f64();
        let checkpoint = checkpoint::of(&self.simulation, self.output_seconds, wall_seconds)?;
        checkpoint.save(self.directory.checkpoints(), step)?;
        self.last_checkpoint = Some(step);
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
        let transient = self.simulation.case.time.is_some();
        let fields = if self.simulation.history.is_empty() { Ok(()) } else { self.write_fields() };
        let checkpoint =
            if transient && self.simulation.steps > 0 { self.write_checkpoint() } else { Ok(()) };
        self.output_seconds += start.elapsed().as_secs_f64();
        // The summary is written even where the disk refused the rest: it is small.
        let summary =
            self.write_summary(if checkpoint.is_err() { Status::Failed } else { status }, breakdown)?;
        fields?;
        checkpoint?;
        Ok(summary)
    }
}

/// All columns of `history.csv`.
fn columns(simulation: &Simulation) -> Vec<String> {
    let mut columns: Vec<String> = ["step", "time", "force_time"].map(String::from).to_vec();
    columns.extend(simulation.names());
    columns.extend(["min_J", "newton_steps", "jacobians"].map(String::from));
    columns
}

fn read_row(row: &[f64], n: usize) -> Row {
    Row {
        step: row[0] as u64,
        time: row[1],
        force_time: row[2],
        values: row[3..3 + n].to_vec(),
        min_j: row[3 + n],
        newton_steps: row[4 + n] as usize,
        jacobians: row[5 + n] as usize,
    }
}

/// Whether `case` ends later than that of the run in `path`.
fn ends_later(path: &Path, case: &Case) -> bool {
    let former = RunDirectory::open(path).ok().and_then(|directory| {
        let text = std::fs::read_to_string(directory.case()).ok()?;
        Case::from_toml(&text, "case.toml", &[]).ok()
    });
    match (former.and_then(|former| former.time), &case.time) {
        (Some(former), Some(time)) => time.end > former.end,
        _ => false,
    }
}

/// A breakdown in words.
fn describe(simulation: &Simulation, failure: &crate::time::StepFailure) -> Breakdown {
    let mesh = &simulation.stepper.assembler.space.mesh;
    let centre = |&c: &u32| {
        let x = mesh.centre(c as usize);
        format!("cell {c} at ({:.4}, {:.4})", x[0], x[1])
    };
    let cells: Vec<String> = failure.worst.cells.iter().map(centre).collect();
    Breakdown {
        time: failure.time,
        min_j: failure.worst.min_j,
        r#where: cells.join(", "),
        reason: failure.to_string(),
    }
}
