//! Errors of the library as exceptions, with the messages of the program.

use pyo3::create_exception;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use undula::Error;

create_exception!(
    undula,
    InputError,
    PyValueError,
    "A case, a mesh or a directory is wrong; nothing was computed."
);
create_exception!(
    undula,
    Breakdown,
    PyRuntimeError,
    "The computation broke down: a step or a stationary solution was not found."
);

/// The exception for `error`.
pub fn of(_py: Python<'_>, error: &Error) -> PyErr {
    match error {
        Error::Breakdown(_) => Breakdown::new_err(error.to_string()),
        _ if error.is_bad_input() => InputError::new_err(error.to_string()),
        Error::Output(_) | Error::Directory(_) => PyOSError::new_err(error.to_string()),
        _ => PyRuntimeError::new_err(error.to_string()),
    }
}

/// The exception for an error of the program.
pub fn other(error: &anyhow::Error) -> PyErr {
    PyRuntimeError::new_err(undula_cli::with_causes(error))
}
