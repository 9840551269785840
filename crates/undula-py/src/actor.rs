//! The thread of a run: it computes a step when it is asked for one, and shows its simulation in between.

use crate::view::{Start, View};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Instant;
use undula::output::{Status, Summary};
use undula::run::{Flow, Observer, RunOptions, breakdown_of, restore_latest, run, run_in_space};
use undula::simulation::{Row, SetUp, Simulation};
use undula::system::Dim;
use undula::{Case, Error};

/// What is done with the simulation between two steps.
type Look = Box<dyn FnOnce(&dyn View) + Send>;

/// What a run is asked for.
pub enum Ask {
    /// The next step.
    Step,
    /// A look at the simulation.
    Look(Look),
}

/// What a run tells.
pub enum Tell {
    /// It is set up.
    Ready(Box<Start>),
    /// A step is done.
    Row(Box<Row>),
    /// There are no more steps.
    End(Box<Summary>),
    /// It has gone wrong; one in memory can be asked again if it was only stopped.
    Failed(Box<Error>),
}

/// Where a run gets its state and leaves its files.
pub enum Place {
    /// From its case; no files.
    Memory,
    /// As `undula run` does.
    Files(RunOptions),
    /// From the newest checkpoint of a run, to be looked at.
    Checkpoint(PathBuf),
    /// At rest, whatever the case begins with, to be looked at.
    Rest,
}

/// A run on a thread of its own. Dropping it stops the run, which writes what is left to write.
pub struct Actor {
    pub asks: Option<Sender<Ask>>,
    pub tells: Receiver<Tell>,
    /// Ends the step that is computed.
    pub stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Actor {
    /// Starts `case` on `threads` threads; the first that it tells is [`Tell::Ready`].
    ///
    /// # Errors
    /// If there are no more threads.
    pub fn start(case: Case, threads: usize, place: Place) -> std::io::Result<Actor> {
        let (asks, asked) = channel();
        let (told, tells) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let mut worker = Worker { asked, told, stop: stop.clone(), notes: vec![] };
        let body = move || match (place, case.mesh.dimension) {
            (Place::Files(options), 3) => {
                let result = run_in_space(case, &options, &mut worker);
                worker.end(result);
            }
            (Place::Files(options), _) => {
                let result = run(case, &options, &mut worker);
                worker.end(result);
            }
            (Place::Checkpoint(directory), 3) => worker.restored::<3>(case, threads, &directory),
            (Place::Checkpoint(directory), _) => worker.restored::<2>(case, threads, &directory),
            (Place::Rest, 3) => worker.in_memory(Dim::<3>::at_rest(case, threads)),
            (Place::Rest, _) => worker.in_memory(Dim::<2>::at_rest(case, threads)),
            (Place::Memory, 3) => worker.in_memory(Dim::<3>::set_up(case, threads)),
            (Place::Memory, _) => worker.in_memory(Dim::<2>::set_up(case, threads)),
        };
        let thread = std::thread::Builder::new().name("undula".into()).spawn(body)?;
        Ok(Actor { asks: Some(asks), tells, stop, thread: Some(thread) })
    }

    /// Waits for the thread, which has to know that nothing more is asked.
    pub fn join(&mut self) {
        self.asks = None;
        if let Some(thread) = self.thread.take() {
            // A panic was told by the channel that it has closed.
            drop(thread.join());
        }
    }
}

/// The side of the thread.
struct Worker {
    asked: Receiver<Ask>,
    told: Sender<Tell>,
    stop: Arc<AtomicBool>,
    notes: Vec<String>,
}

impl Worker {
    /// Nobody may listen any more.
    fn tell(&self, tell: Tell) {
        let _ = self.told.send(tell);
    }

    fn end(&self, result: Result<Summary, Error>) {
        match result {
            Ok(summary) => self.tell(Tell::End(Box::new(summary))),
            Err(error) => self.tell(Tell::Failed(Box::new(error))),
        }
    }

    /// Shows `view` until a step is asked for; `false` if none will be.
    fn serve(&self, view: &dyn View) -> bool {
        loop {
            match self.asked.recv() {
                Ok(Ask::Step) => return true,
                Ok(Ask::Look(look)) => look(view),
                Err(_) => return false,
            }
        }
    }

    /// Computes steps without files.
    fn in_memory<const D: usize>(&self, simulation: Result<Simulation<D>, Error>) {
        let mut simulation = match simulation {
            Ok(simulation) => simulation,
            Err(error) => return self.tell(Tell::Failed(Box::new(error))),
        };
        simulation.stepper.newton.stop = Some(self.stop.clone());
        self.tell(Tell::Ready(Box::new(simulation.start())));
        let begun = Instant::now();
        let seconds = || begun.elapsed().as_secs_f64();
        while self.serve(&simulation) {
            if simulation.finished() {
                self.tell(Tell::End(Box::new(View::summary(
                    &simulation,
                    Status::Completed,
                    None,
                    seconds(),
                ))));
                continue;
            }
            match simulation.step() {
                Ok(row) => self.tell(Tell::Row(Box::new(row))),
                Err(Error::Breakdown(failure)) if !failure.is_stop() => {
                    let breakdown = breakdown_of(&simulation, &failure);
                    let summary = View::summary(&simulation, Status::Breakdown, Some(breakdown), seconds());
                    self.tell(Tell::End(Box::new(summary)));
                }
                Err(error) => self.tell(Tell::Failed(Box::new(error))),
            }
        }
    }

    /// Shows the state of the newest checkpoint in `directory`.
    fn restored<const D: usize>(&self, case: Case, threads: usize, directory: &PathBuf)
    where
        Dim<D>: SetUp<D>,
    {
        let restored = Dim::<D>::at_rest(case, threads).and_then(|mut simulation| {
            restore_latest(&mut simulation, directory)?;
            Ok(simulation)
        });
        match restored {
            Err(error) => self.tell(Tell::Failed(Box::new(error))),
            Ok(simulation) => {
                self.tell(Tell::Ready(Box::new(simulation.start())));
                while self.serve(&simulation) {
                    let summary = View::summary(&simulation, Status::Interrupted, None, 0.0);
                    self.tell(Tell::End(Box::new(summary)));
                }
            }
        }
    }
}

impl<const D: usize> Observer<D> for Worker {
    fn start(&mut self, simulation: &Simulation<D>) {
        let mut start = View::start(simulation);
        start.notes.append(&mut self.notes);
        self.tell(Tell::Ready(Box::new(start)));
        if !self.serve(simulation) {
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn note(&mut self, note: &str) {
        self.notes.push(note.into());
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(self.stop.clone())
    }

    fn after_step(&mut self, simulation: &Simulation<D>, row: &Row) -> Flow {
        self.tell(Tell::Row(Box::new(row.clone())));
        let go_on = self.serve(simulation) && !self.stop.load(Ordering::Relaxed);
        if go_on { Flow::Continue } else { Flow::Stop }
    }
}
