//! Everything that can go wrong, gathered.

use crate::algebra::SolverError;
use crate::case::error::{CaseErrors, LoadError};
use crate::mesh::MeshError;
use crate::nonlinear::NewtonError;
use crate::output::OutputError;
use crate::parallel::Fault;
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
    /// The processes of a run did not come together.
    #[error(transparent)]
    Processes(Fault),
    /// The processes of a run are not alike.
    #[error("process {rank} has {what} than process 0: all processes of a run need the same")]
    Differing {
        /// The first that differs.
        rank: usize,
        /// What it has.
        what: &'static str,
    },
    /// Another process of the run has ended, and says why.
    #[error("another process of the run has ended, with exit code {code}")]
    Elsewhere {
        /// Its exit code.
        code: u8,
    },
}

impl Error {
    /// Whether the input is to blame, and not the computation or the system.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Error::Directory(error) => !error.is_no_room(),
            Error::Load(error) => error.is_bad_input(),
            Error::Case(_)
            | Error::Mesh(_)
            | Error::Resume(_)
            | Error::Stationary(_)
            | Error::Differing { .. } => true,
            _ => self.is_too_large(),
        }
    }

    /// Exit code of a program that ends with this error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Elsewhere { code } => *code,
            Error::Breakdown(_) => 3,
            _ if self.is_bad_input() => 2,
            _ => 1,
        }
    }

    /// Whether the problem does not fit the program, whatever the memory.
    pub fn is_too_large(&self) -> bool {
        matches!(self, Error::Solver(SolverError::TooLarge(_)))
    }
}
