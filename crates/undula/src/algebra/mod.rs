//! Sparse matrices and linear solvers; nothing here knows finite elements.
//!
//! [`Csr`] is the matrix, [`LinearSolver`] what can be done with it: analyse its pattern once, factor it for every
//! kept Jacobian, solve with the factors. All solvers share the same outer shell ([`Direct`]): equilibration, a probe
//! of every factorisation with a known solution, iterative refinement with a residual check. [`MultifrontalLu`] is
//! the fast one, [`FaerLu`] the one to compare it with; `definite` ones are for symmetric positive definite matrices,
//! and store half. [`Gmres`] makes do with factors of an older matrix, and with any [`LinearOperator`] in place of
//! the matrix. [`petsc`] is a library that is loaded at run time. Every result is the same, bit for bit, for any
//! number of threads.

mod csr;
mod direct;
mod faer;
mod gmres;
mod multifrontal;
#[cfg(feature = "mumps")]
mod mumps;
mod operator;
pub mod petsc;
mod scaling;
mod solver;
mod value;
mod vector;
mod vectors;

use crate::choice::{Choice, choice};
pub use csr::{Csr, Pattern, add_column};
pub use direct::{Backend, Direct, Failure, Options};
pub use faer::{FaerBackend, FaerLu};
pub use gmres::{Gmres, GmresReport, GmresSettings};
pub use multifrontal::{MultifrontalBackend, MultifrontalLu};
#[cfg(feature = "mumps")]
pub use mumps::{MumpsBackend, MumpsLu, Ordering};
pub use operator::LinearOperator;
pub use scaling::Scaling;
pub use solver::{Cost, FactorReport, Kind, LinearSolver, Sizes, SolveReport, SolverError, Spent, Unknown};
pub use value::{Sink, Value};
pub use vector::{dot, norm_inf};
pub(crate) use vectors::Vectors;

/// Direct solvers.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum LinearSolverKind {
    /// Multifrontal LU of our own: nested dissection on mesh nodes, threshold pivoting, delayed pivots.
    Multifrontal,
    /// Sparse LU of the crate faer.
    Faer,
    /// GMRES with a cycle of geometric multigrid; multifrontal LU on its coarsest level, and where there is none.
    Multigrid,
    /// Multigrid for large problems of space, else multifrontal LU.
    Automatic,
}

/// Their names in a case, the usual one first.
pub static SOLVERS: [Choice<LinearSolverKind>; 4] = [
    choice("multifrontal", LinearSolverKind::Multifrontal, "multifrontal LU of Undula"),
    choice("faer", LinearSolverKind::Faer, "sparse LU of the crate faer, for comparison"),
    choice(
        "multigrid",
        LinearSolverKind::Multigrid,
        "GMRES with geometric multigrid on the meshes of mesh.refine",
    ),
    choice(
        "automatic",
        LinearSolverKind::Automatic,
        "multigrid in space from 12 000 cells on if the mesh is refined",
    ),
];

/// Who solves the systems of a step.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Solvers of our own: see [`LinearSolverKind`].
    Own,
    /// PETSc, loaded at run time.
    Petsc,
}

/// Their names in a case.
pub static ENGINES: [Choice<Engine>; 2] = [
    choice("own", Engine::Own, "the solvers of Undula, see linear.solver"),
    choice(
        "petsc",
        Engine::Petsc,
        "PETSc, loaded at run time, for the systems of Newton's method: see `undula engines`",
    ),
];

/// Precision of factors.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits: half the memory and half the time of a solve.
    Single,
    /// 64 bits.
    Double,
}

/// Their names in a case.
pub static PRECISIONS: [Choice<Precision>; 2] = [
    choice("single", Precision::Single, "32 bits: half the memory and half the time of a solve"),
    choice("double", Precision::Double, "64 bits"),
];

impl LinearSolverKind {
    /// A solver for any matrix, or for symmetric positive `definite` ones; solvers without a variant for `precision`
    /// or for definite matrices are the general one.
    pub fn make(self, precision: Precision, definite: bool, options: Options) -> Box<dyn LinearSolver> {
        match (self, precision, definite) {
            (LinearSolverKind::Faer, ..) => Box::new(FaerLu::faer(options)),
            (_, Precision::Single, false) => Box::new(MultifrontalLu::single(options)),
            (_, Precision::Single, true) => Box::new(MultifrontalLu::single_definite(options)),
            (_, Precision::Double, false) => Box::new(MultifrontalLu::multifrontal(options)),
            (_, Precision::Double, true) => Box::new(MultifrontalLu::definite(options)),
        }
    }
}
