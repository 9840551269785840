//! A run as Python steps through it.

use crate::actor::{Actor, Ask, Tell};
use crate::functions::Raised;
use crate::view::{Point, Start, View};
use crate::{convert, errors};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use undula::output::{Status, Summary};
use undula::simulation::Row;

/// How often a computation looks whether the user wants to interrupt it.
const PATIENCE: Duration = Duration::from_millis(100);

/// Step, time, force_time, functionals, min_J, newton_steps, jacobians.
type Numbers = (u64, f64, f64, Vec<f64>, f64, usize, usize);

/// A run between two steps.
#[pyclass(module = "undula._undula")]
pub struct Run {
    /// In a mutex because it is asked from one thread at a time; nobody waits for it.
    actor: Mutex<Actor>,
    start: Start,
    summary: Option<Summary>,
    ended: bool,
    raised: Raised,
    in_memory: bool,
}

impl Run {
    /// The run of `actor` as soon as it is set up.
    pub fn ready(py: Python<'_>, actor: Actor, raised: Raised, in_memory: bool) -> PyResult<Run> {
        let nothing = Start {
            names: vec![],
            units: vec![],
            cells: 0,
            unknowns: 0,
            threads: 0,
            rows: vec![],
            notes: vec![],
        };
        let actor = Mutex::new(actor);
        let mut run = Run { actor, start: nothing, summary: None, ended: false, raised, in_memory };
        match run.wait(py)? {
            Tell::Ready(start) => run.start = *start,
            Tell::Failed(error) => return Err(run.failed(py, &error)),
            // Nothing was asked for.
            Tell::Row(_) | Tell::End(_) => return Err(lost()),
        }
        Ok(run)
    }

    fn actor(&mut self) -> &mut Actor {
        self.actor.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn ask(&mut self, ask: Ask) -> PyResult<()> {
        let sent = self.actor().asks.as_ref().is_some_and(|asks| asks.send(ask).is_ok());
        if sent { Ok(()) } else { Err(PyRuntimeError::new_err("the run has ended")) }
    }

    /// The answer of the thread, with the interpreter free; Ctrl-C ends the step that is computed.
    fn wait(&mut self, py: Python<'_>) -> PyResult<Tell> {
        let mut interrupt = None;
        let told = loop {
            let Actor { tells, stop, .. } = self.actor();
            let got = py.detach(move || tells.recv_timeout(PATIENCE));
            match got {
                Ok(tell) => break tell,
                Err(RecvTimeoutError::Disconnected) => return Err(interrupt.unwrap_or_else(lost)),
                Err(RecvTimeoutError::Timeout) if interrupt.is_none() => {
                    if let Err(signal) = py.check_signals() {
                        stop.store(true, Ordering::Relaxed);
                        interrupt = Some(signal);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        };
        let Some(interrupt) = interrupt else { return Ok(told) };
        self.actor().stop.store(false, Ordering::Relaxed);
        match told {
            // In memory the state is that before the step, and the run can go on.
            Tell::Failed(_) if self.in_memory => {}
            Tell::End(summary) => self.end(*summary),
            Tell::Row(_) | Tell::Ready(_) | Tell::Failed(_) => self.ended = true,
        }
        Err(interrupt)
    }

    fn end(&mut self, summary: Summary) {
        self.summary = Some(summary);
        self.ended = true;
    }

    fn failed(&mut self, py: Python<'_>, error: &undula::Error) -> PyErr {
        self.ended = true;
        self.raised().unwrap_or_else(|| errors::of(py, error))
    }

    /// What a function of the case has raised.
    fn raised(&self) -> Option<PyErr> {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// What `look` finds at the simulation; `None` if it has gone.
    fn look<R: Send + 'static>(
        &mut self,
        py: Python<'_>,
        look: impl FnOnce(&dyn View) -> R + Send + 'static,
    ) -> PyResult<Option<R>> {
        let (found, finds) = channel();
        let ask = Ask::Look(Box::new(move |view| drop(found.send(look(view)))));
        if self.ask(ask).is_err() {
            return Ok(None);
        }
        Ok(py.detach(move || finds.recv()).ok())
    }
}

fn lost() -> PyErr {
    PyRuntimeError::new_err("the thread of the run has ended; its message is on standard error")
}

fn numbers(row: &Row) -> Numbers {
    (row.step, row.time, row.force_time, row.values.clone(), row.min_j, row.newton_steps, row.jacobians)
}

#[pymethods]
impl Run {
    /// Names of the functionals.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.start.names.clone()
    }

    /// SI units of the functionals.
    #[getter]
    fn units(&self) -> Vec<String> {
        self.start.units.clone()
    }

    /// Numbers of cells, unknowns and threads.
    #[getter]
    fn sizes(&self) -> (usize, usize, usize) {
        (self.start.cells, self.start.unknowns, self.start.threads)
    }

    /// What should be known, though nothing is wrong.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.start.notes.clone()
    }

    /// Rows that the run has which goes on.
    #[getter]
    fn rows(&self) -> Vec<Numbers> {
        self.start.rows.iter().map(numbers).collect()
    }

    /// Whether there are no more steps.
    #[getter]
    fn ended(&self) -> bool {
        self.ended
    }

    /// The next step; `None` if there is none.
    fn step(&mut self, py: Python<'_>) -> PyResult<Option<Numbers>> {
        if self.ended {
            return Ok(None);
        }
        self.ask(Ask::Step)?;
        match self.wait(py)? {
            Tell::Row(row) => Ok(Some(numbers(&row))),
            Tell::End(summary) => {
                let broken = summary.breakdown.clone();
                self.end(*summary);
                match (self.raised(), broken) {
                    (Some(raised), _) => Err(raised),
                    (None, None) => Ok(None),
                    (None, Some(broken)) => {
                        let mut text = broken.reason;
                        if !broken.remedy.is_empty() {
                            text = format!("{text}\n{}", broken.remedy);
                        }
                        Err(errors::Breakdown::new_err(text))
                    }
                }
            }
            Tell::Failed(error) => Err(self.failed(py, &error)),
            Tell::Ready(_) => Err(lost()),
        }
    }

    /// Ends the run; one with files writes its checkpoint and its summary.
    fn stop(&mut self, py: Python<'_>) -> PyResult<()> {
        if self.in_memory && self.summary.is_none() {
            let found = self.look(py, |view| View::summary(view, Status::Interrupted, None, f64::NAN))?;
            self.summary = found;
        }
        let actor = self.actor();
        let last = py.detach(|| {
            actor.join();
            actor.tells.try_iter().last()
        });
        match last {
            Some(Tell::End(summary)) => self.end(*summary),
            Some(Tell::Failed(error)) if !self.ended => return Err(self.failed(py, &error)),
            _ => self.ended = true,
        }
        Ok(())
    }

    /// The present fields as a dictionary of arrays; `None` if the simulation has gone.
    fn fields<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        match self.look(py, |view| (view.snapshot(), view.time()))? {
            Some((snapshot, time)) => convert::fields(py, snapshot, time).map(Some),
            None => Ok(None),
        }
    }

    /// The present solution at a position on the reference domain; `None` if the simulation has gone.
    fn at<'py>(&mut self, py: Python<'py>, x: Vec<f64>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(found) = self.look(py, move |view| view.at(&x))? else { return Ok(None) };
        let Point { is_solid, velocity, velocity_gradient, displacement, displacement_gradient, pressure } =
            found.map_err(errors::InputError::new_err)?;
        let all = PyDict::new(py);
        all.set_item("is_solid", is_solid)?;
        all.set_item("velocity", velocity)?;
        all.set_item("velocity_gradient", velocity_gradient)?;
        all.set_item("displacement", displacement)?;
        all.set_item("displacement_gradient", displacement_gradient)?;
        all.set_item("pressure", pressure)?;
        Ok(Some(all))
    }

    /// What `summary.json` says, as JSON; that of now while the run goes on.
    fn summary(&mut self, py: Python<'_>) -> PyResult<Option<String>> {
        if self.summary.is_none() {
            let now = self.look(py, |view| View::summary(view, Status::Running, None, f64::NAN))?;
            return now.map(|summary| json(&summary)).transpose();
        }
        self.summary.as_ref().map(json).transpose()
    }

    /// A picture of the present fields as PNG; `None` where there is no such field.
    fn picture(&mut self, py: Python<'_>, field: String, title: String) -> PyResult<Option<Vec<u8>>> {
        let Some(snapshot) = self.look(py, |view| view.snapshot())? else { return Ok(None) };
        let drawn = py.detach(|| undula_cli::picture(snapshot, &field, &title));
        drawn.map_err(|error| errors::other(&error))
    }
}

fn json(summary: &Summary) -> PyResult<String> {
    serde_json::to_string(summary).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

impl Drop for Run {
    /// The thread may need the interpreter for functions of the case, so that it is free meanwhile.
    fn drop(&mut self) {
        let actor = self.actor.get_mut().unwrap_or_else(PoisonError::into_inner);
        Python::attach(|py| py.detach(|| actor.join()));
    }
}
