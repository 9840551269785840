//! A run with its open files: what is written, and when.

use super::checkpoint::{self, OfRun};
use super::identity::mesh_hash;
use super::rows::{columns, numbers};
use super::share::{self, Order};
use super::summary::{Spent, summary_of};
use super::together::{settle, settle_with};
use super::window::Window;
use super::{Flow, Observer, RunOptions, written_fields};
use crate::error::Error;
use crate::output::{
    Breakdown, Checkpoint, Collection, FunctionalSummary, HistoryWriter, OutputError, Precision, Provenance,
    RankSummary, RunDirectory, Status, Summary, hash, text_of, write_vtu,
};
use crate::parallel::{Crew, Team};
use crate::simulation::{Columns, Row, Simulation};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// How often a run looks whether its files are still there, besides when it writes one.
const LOOK: Duration = Duration::from_millis(500);

/// Rows that a run keeps in memory: those that say which output time is nearest.
const KEPT: usize = 2;

/// So many rows gather before the earlier ones go.
const GATHERED: usize = 256;

/// A simulation with its open files.
pub(super) struct Run<const D: usize> {
    pub simulation: Simulation<D>,
    pub directory: RunDirectory,
    history: HistoryWriter,
    /// Whether the history has a column of linear iterations.
    pub with_iterations: bool,
    pub collection: Collection,
    start: Instant,
    /// Seconds of the runs that this one continues.
    pub wall_before: f64,
    pub output_seconds: f64,
    last_fields: Option<u64>,
    pub last_checkpoint: Option<u64>,
    /// Whether it lies on the way to this end alone, as `cut` says.
    pub last_is_cut: bool,
    /// When the last checkpoint was written, or the run began.
    checkpoint_time: Instant,
    /// When the files were last looked for.
    looked: Instant,
    /// Hash of the mesh file.
    mesh: Option<String>,
    /// Commit of the source of the program.
    pub commit: Option<String>,
    /// The end \[s\] that the last steps were shortened for.
    pub cut: Option<f64>,
    /// Means over a window of time.
    pub window: Option<Window<D>>,
    /// The processes that share the mesh.
    crew: Option<Crew>,
    /// What they have had to do, at the end.
    ranks: Vec<RankSummary>,
}

impl<const D: usize> Run<D> {
    pub fn create(simulation: Simulation<D>, options: &RunOptions) -> Result<Run<D>, Error> {
        let directory = RunDirectory::create(&options.directory, options.force).map_err(Error::Directory)?;
        let with_iterations = simulation.stepper.linear.is_iterative();
        let columns = columns(&simulation, with_iterations);
        let history = HistoryWriter::create(directory.history(), &columns)?;
        let collection = Collection::create(directory.collection())?;
        let run = Run { with_iterations, ..Run::new(simulation, directory, history, collection) };
        run.write_case()?;
        run.directory.write_breakdown(None)?;
        Ok(run)
    }

    pub fn new(
        simulation: Simulation<D>,
        directory: RunDirectory,
        history: HistoryWriter,
        collection: Collection,
    ) -> Run<D> {
        let now = Instant::now();
        Run {
            mesh: mesh_hash(&simulation.case),
            commit: None,
            window: Window::new(&simulation),
            crew: simulation.crew(),
            ranks: vec![],
            simulation,
            directory,
            history,
            with_iterations: false,
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

    pub fn write_case(&self) -> Result<(), Error> {
        Ok(self.directory.write_case(&self.simulation.case.to_toml_in(self.directory.path()))?)
    }

    /// Step until the end, a stop, or an error.
    pub fn advance(&mut self, observer: &mut dyn Observer<D>, team: &mut Team) -> Result<Flow, Error> {
        let begun = self.begin();
        self.order(Order::Settle)?;
        settle_with(team, begun)?;
        while !self.simulation.finished() {
            let outcome = self.step(observer);
            self.order(Order::Settle)?;
            if settle(team, outcome)? == Flow::Stop && !self.simulation.finished() {
                return Ok(Flow::Stop);
            }
        }
        Ok(Flow::Continue)
    }

    /// What is written before the first step.
    fn begin(&mut self) -> Result<(), Error> {
        self.write_summary(Status::Running, None)?;
        if self.simulation.steps == 0 && self.simulation.writes_fields() {
            self.write_fields()?;
        }
        Ok(())
    }

    /// A step, and what is written after it.
    fn step(&mut self, observer: &mut dyn Observer<D>) -> Result<Flow, Error> {
        if self.simulation.next_is_cut() {
            // A run to a later end goes on from here.
            self.write_checkpoint()?;
            self.cut = self.simulation.case.time.as_ref().map(|time| time.end);
        }
        let before = self.fallbacks();
        self.order(Order::Step)?;
        let row = self.simulation.step()?;
        let now = self.fallbacks();
        if now.0 != before.0 {
            observer.note("linear.solver: multigrid did not converge, the direct solver takes over");
        } else if now.1 != before.1 && self.simulation.stepper.linear.is_multigrid() {
            observer.note(
                "newton.linearization: a step did not converge, the whole Jacobian takes over for some steps",
            );
        }
        if let Some(window) = &mut self.window {
            window.observe(&self.simulation);
        }
        self.record(&row)?;
        Ok(observer.after_step(&self.simulation, &row))
    }

    /// Whether the direct solver has taken over from multigrid, and how many steps were begun anew.
    const fn fallbacks(&self) -> (bool, usize) {
        let stepper = &self.simulation.stepper;
        (stepper.linear.has_left_multigrid(), stepper.newton.counters.fallbacks)
    }

    /// Write what is due after a step. The row comes first: a checkpoint without its row would lead nowhere.
    fn record(&mut self, row: &Row) -> Result<(), Error> {
        let start = Instant::now();
        self.history.append(&numbers(row, self.with_iterations))?;
        // They are in the file.
        let rows = &mut self.simulation.history;
        if rows.len() >= GATHERED {
            rows.drain(..rows.len() - KEPT);
        }
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

    pub fn are_fields_due(&self) -> bool {
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
        self.order(Order::Fields)?;
        let name = match self.crew {
            Some(_) => share::write_fields(&self.simulation, self.directory.path())?,
            None => self.write_vtu(step)?,
        };
        self.collection.add(self.simulation.time(), name)?;
        self.last_fields = Some(step);
        Ok(())
    }

    /// Writes the fields of a process that has all of them; the name of the file in the directory.
    fn write_vtu(&self, step: u64) -> Result<String, Error> {
        let name = self.directory.field_name(step);
        let snapshot = written_fields(&self.simulation);
        write_vtu(self.directory.path().join(&name), &snapshot, self.simulation.time(), Precision::Auto)?;
        Ok(name)
    }

    /// Tells the processes that share the mesh what all do next.
    fn order(&self, order: Order) -> Result<(), Error> {
        share::order(self.crew.as_ref(), order)
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
                .map(|row| text_of(&numbers(row, self.with_iterations))),
            cut: self.cut,
        };
        self.order(Order::Checkpoint)?;
        let memory = share::whole_memory(&self.simulation)?;
        let mut checkpoint = checkpoint::of(&self.simulation, memory, &of_run)?;
        if let Some(window) = &self.window {
            window.save(&mut checkpoint);
        }
        // Of two on the way to this end alone the later one is enough: the other leads to later ends, too.
        let former = self.last_checkpoint.filter(|_| self.cut.is_some() && self.last_is_cut);
        checkpoint.save_instead(self.directory.checkpoints(), step, former)?;
        (self.last_checkpoint, self.last_is_cut) = (Some(step), self.cut.is_some());
        self.checkpoint_time = Instant::now();
        Ok(())
    }

    fn summary(&self, status: Status, breakdown: Option<Breakdown>) -> Summary {
        let wall = self.wall_before + self.start.elapsed().as_secs_f64();
        let spent = Spent { wall, output: self.output_seconds };
        let summary = summary_of(&self.simulation, status, breakdown, spent);
        let all = self.ranks.iter().map(|rank| rank.cpu_seconds).sum::<f64>();
        Summary {
            cpu_seconds: summary.cpu_seconds.map(|own| if self.ranks.is_empty() { own } else { all }),
            ranks: self.ranks.clone(),
            functionals: self.statistics(),
            provenance: Provenance {
                case_hash: std::fs::read(self.directory.case()).ok().map(|case| hash(&case)),
                mesh_hash: self.mesh.clone(),
                commit: self.commit.clone(),
                ..summary.provenance
            },
            ..summary
        }
    }

    /// Statistics of all rows: those of the file, and those behind that could not be written.
    fn statistics(&self) -> BTreeMap<String, FunctionalSummary> {
        let (mut columns, mut last) = (Columns::default(), -1.0);
        let n = self.simulation.names().len();
        let read = self.history.for_each_row(|row| {
            columns.push(row[1], row[2], &row[3..3 + n]);
            last = row[0];
        });
        if read.is_err() {
            // The run ends with that error; what is left says something nevertheless.
            return self.simulation.statistics();
        }
        for row in self.simulation.history.iter().filter(|row| row.step as f64 > last) {
            columns.push(row.time, row.force_time, &row.values);
        }
        self.simulation.statistics_of(&columns)
    }

    fn write_summary(&self, status: Status, breakdown: Option<Breakdown>) -> Result<Summary, Error> {
        let summary = self.summary(status, breakdown);
        summary.write(self.directory.summary())?;
        Ok(summary)
    }

    /// Write what is left to write: last fields, a checkpoint if the run can go on, the summary.
    pub fn close(mut self, status: Status, breakdown: Option<Breakdown>) -> Result<Summary, Error> {
        let summary = self.write_rest(status, breakdown);
        // Before anything is given back, which all do together.
        self.order(Order::End).and(summary)
    }

    fn write_rest(&mut self, status: Status, breakdown: Option<Breakdown>) -> Result<Summary, Error> {
        let start = Instant::now();
        // Where there is another directory now, nothing of this run belongs into it.
        self.directory.verify()?;
        let lost = self.verify().err();
        if lost.is_some() && !self.directory.history().exists() {
            self.write_history()?;
        }
        let transient = self.simulation.case.time.is_some();
        let fields = if self.simulation.history.is_empty() { Ok(()) } else { self.write_fields() };
        let means = self.write_means();
        // A state whose row could not be written is kept nevertheless: the checkpoint has its row.
        let checkpoint = if transient { self.write_checkpoint() } else { Ok(()) };
        self.output_seconds += start.elapsed().as_secs_f64();
        let errors = [lost.map_or(Ok(()), Err), fields, means, checkpoint, self.check_files()];
        let failed = errors.iter().any(Result::is_err);
        self.order(Order::Account)?;
        self.ranks = share::account(&self.simulation)?;
        // The summary is written even where the disk refused the rest: it is small.
        let summary = self.write_summary(if failed { Status::Failed } else { status }, breakdown)?;
        errors.into_iter().collect::<Result<(), Error>>()?;
        Ok(summary)
    }

    /// Write the means over the window, if there are some.
    fn write_means(&self) -> Result<(), Error> {
        let Some(window) = &self.window else { return Ok(()) };
        let Some(means) = window.fields(&self.simulation) else { return Ok(()) };
        Ok(write_vtu(self.directory.means(), &means, window.time(), Precision::Auto)?)
    }

    /// Write the history anew, from the file that has lost its name.
    fn write_history(&mut self) -> Result<(), Error> {
        let columns = columns(&self.simulation, self.with_iterations);
        let mut anew = HistoryWriter::create(self.directory.history(), &columns)?;
        let mut written = Ok(());
        self.history.for_each_row(|row| {
            if written.is_ok() {
                written = anew.append(row);
            }
        })?;
        self.history = anew;
        Ok(written?)
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
