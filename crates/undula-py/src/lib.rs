//! The part of the Python module `undula` that is not Python: cases, runs step by step, files, pictures.
//!
//! What people call is in `python/undula`; it documents units and shapes. A run has a thread of its own (`actor`), so
//! that the interpreter is free while it computes and a run can be asked for its fields between two steps.

mod actor;
mod case;
mod convert;
mod errors;
mod functions;
mod run;
mod view;

use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

/// The module `undula._undula`.
#[pymodule]
mod _undula {
    #[pymodule_export]
    use super::case::Case;
    #[pymodule_export]
    use super::errors::{Breakdown, InputError};
    #[pymodule_export]
    use super::run::Run;
    #[pymodule_export]
    use super::{builtin, command, keys, page, picture, plots, read_fields, version};

    /// The variables of the environment that name libraries hold for Python, too.
    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        undula_cli::name_libraries();
        Ok(())
    }
}

/// The version of the program.
#[pyfunction]
fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Names and titles of the built-in cases.
#[pyfunction]
fn builtin() -> Vec<&'static str> {
    undula::case::builtin::builtin_cases().iter().map(|case| case.name).collect()
}

/// Keys of a case as `undula keys` prints them.
#[pyfunction]
fn keys(pattern: &str) -> String {
    undula_cli::keys(pattern)
}

/// The program `undula` with these arguments, the first of which is its name; returns its exit code.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    let code = py.detach(|| undula_cli::command(arguments));
    (0..=u8::MAX).find(|&n| ExitCode::from(n) == code).unwrap_or(1)
}

/// The fields of a VTU file that a run has written, as a dictionary of arrays.
#[pyfunction]
fn read_fields<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let read = py.detach(|| undula::output::read_snapshot(&path));
    let (mut snapshot, time) = read.map_err(|error| errors::of(py, &error.into()))?;
    if snapshot.kind.dim() == 2 {
        convert::in_plane(&mut snapshot);
    }
    convert::fields(py, snapshot, time)
}

/// Writes the page of the run in a directory and returns its path.
#[pyfunction]
fn page(py: Python<'_>, directory: PathBuf, to: Option<PathBuf>) -> PyResult<PathBuf> {
    py.detach(|| undula_cli::report(&directory, to.as_deref())).map_err(|error| errors::other(&error))
}

/// Draws the pictures of the run in a directory and returns their paths.
#[pyfunction]
fn plots(py: Python<'_>, directory: PathBuf, to: Option<PathBuf>) -> PyResult<Vec<PathBuf>> {
    py.detach(|| undula_cli::plot(&directory, to.as_deref())).map_err(|error| errors::other(&error))
}

/// A picture of a VTU file as PNG; `None` where it has no such field.
#[pyfunction]
fn picture(py: Python<'_>, path: PathBuf, field: &str, title: &str) -> PyResult<Option<Vec<u8>>> {
    let drawn = py.detach(|| {
        let (snapshot, _) = undula::output::read_snapshot(&path)?;
        undula_cli::picture(snapshot, field, title)
    });
    drawn.map_err(|error| errors::other(&error))
}
