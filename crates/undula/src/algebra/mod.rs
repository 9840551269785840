//! Sparse matrices and linear solvers; nothing here knows finite elements.
//!
//! [`Csr`] is the matrix, [`LinearSolver`] what can be done with it: analyse its pattern once, factor
//! it for every kept Jacobian, solve with the factors. All solvers share the same outer shell
//! ([`Direct`]): equilibration, a probe of every factorisation with a known solution,
//! iterative refinement with a residual check. [`MultifrontalLu`] is the fast one, [`FaerLu`] the one to
//! compare it with; `definite` ones are for symmetric positive definite matrices, and store half. [`Gmres`] makes do
//! with factors of an older matrix. Every result is the same, bit for bit, for any number of threads.

mod csr;
mod direct;
mod faer;
mod gmres;
mod multifrontal;
#[cfg(feature = "mumps")]
mod mumps;
mod scaling;
mod solver;
mod vector;

pub use csr::{Csr, Pattern};
pub use direct::{Backend, Direct, Failure, Options};
pub use faer::{FaerBackend, FaerLu};
pub use gmres::{Gmres, GmresReport};
pub use multifrontal::{MultifrontalBackend, MultifrontalLu};
#[cfg(feature = "mumps")]
pub use mumps::{MumpsBackend, MumpsLu, Ordering};
pub use scaling::{Scaling, Sizes};
pub use solver::{Cost, FactorReport, Kind, LinearSolver, SolveReport, SolverError, Unknown};
pub use vector::{dot, norm_inf};

/// Names of the solvers in case files, the usual one first.
pub const SOLVERS: [&str; 2] = ["multifrontal", "faer"];

/// The solver of a name; `None` if it is not one of [`SOLVERS`].
pub fn solver(name: &str, options: Options) -> Option<Box<dyn LinearSolver>> {
    match name {
        "multifrontal" => Some(Box::new(MultifrontalLu::multifrontal(options))),
        "faer" => Some(Box::new(FaerLu::faer(options))),
        _ => None,
    }
}
