//! Everything that can go wrong, gathered.

use crate::algebra::SolverError;
use crate::case::error::{CaseErrors, LoadError};
use crate::mesh::MeshError;
use crate::nonlinear::NewtonError;
use crate::output::OutputError;
use crate::time::StepFailure;

/// Why a computation could not be set up or went wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The case is wrong, or does not fit its mesh.
    #[error(transparent)]
    Case(#[from] CaseErrors),
    /// The case could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The mesh is wrong.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A file could not be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The output directory cannot be used as asked.
    #[error(transparent)]
    Directory(OutputError),
    /// The linear solver could not be prepared.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// A checkpoint could not be continued.
    #[error("cannot go on from the checkpoint: {0}")]
    Resume(String),
    /// The kept Jacobian of a checkpoint could not be factorised.
    #[error(transparent)]
    Newton(#[from] NewtonError),
    /// A step has no solution: the run breaks down.
    #[error(transparent)]
    Breakdown(#[from] StepFailure),
    /// Time steps are to be measured, and there are none.
    #[error("the case `{0}` is stationary; expected one with time steps, such as `fsi3`")]
    Stationary(String),
    /// The thread pool could not be made.
    #[error("cannot start {0} threads")]
    Threads(usize),
}

impl Error {
    /// Whether the input is to blame, and not the computation or the system.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Error::Directory(error) => !error.is_no_room(),
            Error::Load(error) => error.is_bad_input(),
            Error::Case(_) | Error::Mesh(_) | Error::Resume(_) | Error::Stationary(_) => true,
            _ => self.is_too_large(),
        }
    }

    /// Whether the problem does not fit the program, whatever the memory.
    pub fn is_too_large(&self) -> bool {
        matches!(self, Error::Solver(SolverError::TooLarge(_)))
    }
}
