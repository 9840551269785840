//! A case that was checked.

use crate::actor::{Actor, Place};
use crate::functions::{Raised, own};
use crate::run::Run;
use crate::{convert, errors};
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::PoisonError;
use undula::CaseBuilder;
use undula::run::RunOptions;

/// A function of Python: its name in expressions, its value, its derivative if it has one of its own.
type Function = (String, Py<PyAny>, Option<Py<PyAny>>);

/// A case without mistakes, of a built-in case or a file, or of a text, with settings.
#[pyclass(frozen, module = "undula._undula")]
pub struct Case {
    case: undula::Case,
    raised: Raised,
}

#[pymethods]
impl Case {
    /// The built-in case or file `source`, or the TOML `text` that messages call `source`.
    #[new]
    #[pyo3(signature = (source, text, settings, functions))]
    fn new(
        py: Python<'_>,
        source: &str,
        text: Option<&str>,
        settings: Vec<String>,
        functions: Vec<Function>,
    ) -> PyResult<Case> {
        let raised = Raised::default();
        let builder = match text {
            Some(text) => CaseBuilder::from_toml(text, source),
            None => CaseBuilder::load(source).map_err(|error| errors::of(py, &error))?,
        };
        let mut builder = builder.with(settings);
        for (name, f, slope) in functions {
            builder = builder.function(&name, own(f, slope, &raised));
        }
        let built = builder.build();
        if let Some(raised) = raised.lock().unwrap_or_else(PoisonError::into_inner).take() {
            return Err(raised);
        }
        let case = built.map_err(|error| errors::of(py, &error))?;
        Ok(Case { case, raised })
    }

    /// Short name.
    #[getter]
    fn name(&self) -> &str {
        &self.case.name
    }

    /// What it is, in a line.
    #[getter]
    fn title(&self) -> &str {
        &self.case.title
    }

    /// 2 or 3.
    #[getter]
    fn dimension(&self) -> usize {
        self.case.mesh.dimension
    }

    /// The end \[s\]; `None` if stationary.
    #[getter]
    fn end(&self) -> Option<f64> {
        self.case.time.as_ref().map(|time| time.end)
    }

    /// Settings without effect and the like.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.case.notes().to_vec()
    }

    /// The case as TOML with all defaults.
    fn toml(&self) -> String {
        self.case.resolved().to_toml()
    }

    /// The same as a dictionary.
    fn data<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let table = self.toml().parse::<toml::Table>().map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        convert::toml(py, &toml::Value::Table(table))
    }

    /// What `undula check` says; the mesh is made for it.
    fn summary(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| undula_cli::summary(self.case.clone())).map_err(|error| match error.downcast_ref() {
            Some(error) => errors::of(py, error),
            None => errors::other(&error),
        })
    }

    /// Starts the case: without files, or with those of `undula run` in `directory`.
    fn start(
        &self,
        py: Python<'_>,
        directory: Option<PathBuf>,
        threads: usize,
        force: bool,
        resume: bool,
    ) -> PyResult<Run> {
        let place = match directory {
            None => Place::Memory,
            Some(directory) => {
                let commit = option_env!("UNDULA_COMMIT").map(String::from);
                Place::Files(RunOptions { directory, threads, force, resume, commit })
            }
        };
        let in_memory = matches!(place, Place::Memory);
        self.started(py, threads, place, in_memory)
    }

    /// The case at rest, to be looked at.
    fn preview(&self, py: Python<'_>) -> PyResult<Run> {
        self.started(py, 1, Place::Rest, true)
    }

    /// The state of the newest checkpoint of the run in `directory`, to be looked at.
    fn restore(&self, py: Python<'_>, directory: PathBuf, threads: usize) -> PyResult<Run> {
        self.started(py, threads, Place::Checkpoint(directory), true)
    }
}

impl Case {
    fn started(&self, py: Python<'_>, threads: usize, place: Place, in_memory: bool) -> PyResult<Run> {
        let actor = Actor::start(self.case.clone(), threads, place);
        let actor = actor.map_err(|error| PyOSError::new_err(error.to_string()))?;
        Run::ready(py, actor, self.raised.clone(), in_memory)
    }
}
