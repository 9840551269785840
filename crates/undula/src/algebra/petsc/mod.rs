//! PETSc, loaded at run time: a linear solver by a string of options.
//!
//! The program is linked to neither PETSc nor MPI, and starts without them. [`engine`] looks for them once and examines
//! what it finds before anything is called; [`PetscSolver`] hands a matrix over and solves with it;
//! [`mistake_in_options`] tries options on a small system. One thread at a time is in PETSc. [`finish`] ends it, before
//! the process ends.

mod access;
mod calls;
mod counted;
mod error;
mod fields;
mod prepared;
mod solver;
mod system;
mod trial;

pub use access::{
    Engine, MpiKind, Names, engine, finish, have_parted, mpi_alone, name_libraries, part, processes,
    processes_at_work,
};
pub use error::{INSTALL, Missing, PACKAGES};
pub use solver::PetscSolver;
pub use trial::mistake_in_options;

/// Options of an iteration for the extension, whose matrix is symmetric and positive definite.
pub const EXTENSION_OPTIONS: &str = "-ksp_type cg -ksp_rtol 1e-10 -pc_type gamg";

/// Options of a direct solver: LU of MUMPS, with room for delayed pivots.
pub const USUAL_OPTIONS: &str =
    "-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps -mat_mumps_icntl_14 60";
