//! What a linear solver is, what it may know, and how it fails.

use super::{Csr, Pattern};
use crate::parallel::Halo;
use std::{fmt, sync::Arc};

/// Field that an unknown belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A component of v.
    Velocity,
    /// A component of u.
    Deformation,
    /// p, or one of its moments in a cell.
    Pressure,
}

/// What a solver may know of an unknown, and of the row with the same number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknown {
    /// Mesh node that the unknown sits on; unknowns of one node are eliminated together. Pressures
    /// that belong to a cell and to no node have a number of their own for each cell; the first of them is
    /// constant there.
    pub node: u32,
    /// Field.
    pub kind: Kind,
    /// Position in the reference domain, m; the third coordinate is 0 in two dimensions.
    pub at: [f64; 3],
}

/// Typical sizes of unknowns, in one system of units: what is as large as what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Of a velocity \[m/s\].
    pub velocity: f64,
    /// Of a deformation \[m\].
    pub deformation: f64,
    /// Of a pressure \[Pa\].
    pub pressure: f64,
}

impl Default for Sizes {
    /// All numbers alike, whatever their units.
    fn default() -> Self {
        Self { velocity: 1.0, deformation: 1.0, pressure: 1.0 }
    }
}

impl Sizes {
    pub(super) fn of(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Velocity => self.velocity,
            Kind::Deformation => self.deformation,
            Kind::Pressure => self.pressure,
        }
    }
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { node, kind, at: [x, y, z] } = self;
        let kind = match kind {
            Kind::Velocity => "velocity",
            Kind::Deformation => "deformation",
            Kind::Pressure => "pressure",
        };
        // Six digits of the largest coordinate, six decimals at least.
        let size = x.abs().max(y.abs()).max(z.abs());
        let decimals = if size.is_normal() { 5.0 - size.log10().floor() } else { 0.0 };
        let n = decimals.max(6.0) as usize;
        write!(f, "{kind} of node {node} at ({x:.n$}, {y:.n$}, {z:.n$})")
    }
}

/// Direct or iterative solver of `A x = b` for many matrices of one pattern.
pub trait LinearSolver: Send {
    /// Name as written in case files.
    fn name(&self) -> &'static str;

    /// Tells, before the analysis, that processes share the unknowns: rows of copies are not complete, and solutions have
    /// the copies, too. For solvers that can: those of PETSc, and multigrid.
    fn share(&mut self, _halo: Arc<Halo>) {}

    /// Prepares for matrices of this pattern, once per run. `unknowns` has one entry per row.
    ///
    /// # Errors
    /// If the description does not fit the pattern, or memory is short.
    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError>;

    /// Factors `a`, once per kept Jacobian, and probes the factors with a known solution if asked to.
    ///
    /// # Errors
    /// If `a` is singular, nearly so, or the factors turn out to be inaccurate.
    fn factor(&mut self, a: &Csr) -> Result<FactorReport, SolverError>;

    /// Whether [`LinearSolver::factor_single`] is what it needs, a matrix in single precision.
    fn takes_single(&self) -> bool {
        false
    }

    /// Factors `a`, and keeps it for the products of its iterations.
    ///
    /// # Errors
    /// As [`LinearSolver::factor`]; [`SolverError::NotFactored`] where it does not take such a matrix.
    fn factor_single(&mut self, _a: &Arc<Csr<f32>>) -> Result<FactorReport, SolverError> {
        Err(SolverError::NotFactored)
    }

    /// The matrix of products from now on, with the factors of an older one; `None`: it is about to be filled anew.
    fn hold(&mut self, _a: Option<&Arc<Csr<f32>>>) {}

    /// Solves `a x = b`; `a` is the matrix last factored, `x` is only written.
    ///
    /// # Errors
    /// If the residual stays too large, or something is not finite.
    fn solve(&mut self, a: &Csr, b: &[f64], x: &mut [f64]) -> Result<SolveReport, SolverError>;

    /// The factors applied once, `x ← A⁻¹ b` as well as they are: no refinement and no judgement, for
    /// iterations that see their own residual. Without factors `x` becomes NaN.
    fn apply(&mut self, b: &[f64], x: &mut [f64]);

    /// A correction for an iteration that sees its own residual, with `a` the matrix last factored: as
    /// [`LinearSolver::apply`], but judged where that can go wrong. Returns how many times the factors were applied.
    ///
    /// # Errors
    /// If the solver says that it has a solution, and has not.
    fn correct(&mut self, _a: &Csr, b: &[f64], x: &mut [f64]) -> Result<usize, SolverError> {
        self.apply(b, x);
        Ok(1)
    }

    /// Whether [`LinearSolver::apply`] gives the solution but for rounding. Others precondition an iteration.
    fn is_exact(&self) -> bool {
        true
    }

    /// What a factorisation will cost, as far as the pattern tells: without delayed pivots. `None` before
    /// the analysis and where the backend does not know.
    fn predicted(&self) -> Option<Cost> {
        None
    }

    /// Unknowns of the largest system that is factorised as a whole; 0 before the analysis.
    fn largest_factor(&self) -> usize {
        0
    }

    /// What the parts of its iterations have cost; empty where it has none.
    fn spent(&self) -> Vec<Spent> {
        vec![]
    }

    /// Tells typical sizes of the unknowns for the factorisations to come: with them the pivots do not depend on the
    /// units in which the matrix is given.
    fn set_sizes(&mut self, _sizes: Sizes) {}

    /// No other matrix will come: forget what only factorisations need.
    fn settle(&mut self) {}
}

/// What a part of iterations has cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spent {
    /// What it does.
    pub part: &'static str,
    /// Elapsed time \[s\].
    pub seconds: f64,
    /// Bytes that had to be read, about.
    pub bytes: f64,
}

/// What a factorisation has cost; `None` where the backend does not tell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Stored entries of L and U.
    pub fill: Option<usize>,
    /// Floating point operations, a multiplication and an addition being two.
    pub flops: Option<f64>,
    /// Pivots that were refused in their own front and eliminated further up.
    pub delayed: usize,
    /// Memory held by the factors; in a prediction, by their entries alone.
    pub bytes: Option<usize>,
    /// Memory that a substitution reads, as far as it is entries of the factors.
    pub read: Option<usize>,
}

/// Outcome of [`LinearSolver::factor`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FactorReport {
    /// Size of the factors and work done.
    pub cost: Cost,
    /// Relative error of the probe, ‖x − x*‖∞ / ‖x*‖∞ in scaled variables, without refinement; NaN
    /// without a probe.
    pub probe_error: f64,
    /// Lower estimate of the condition number in scaled variables; only looked at where the probe
    /// lost half of the digits.
    pub condition: Option<f64>,
}

/// Outcome of [`LinearSolver::solve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveReport {
    /// Steps of iterative refinement taken.
    pub refinements: usize,
    /// ‖b − A x‖ / (‖A‖ ‖x‖ + ‖b‖) in the maximum norm and scaled variables.
    pub backward_error: f64,
}

/// Why a system was not solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolverError {
    /// The arrays given do not belong together.
    #[error("{what}: expected {expected} entries, got {found}")]
    Size {
        /// Which array.
        what: &'static str,
        /// Entries it should have.
        expected: usize,
        /// Entries it has.
        found: usize,
    },
    /// The matrix has another pattern than the one analysed, or there was none.
    #[error("the matrix has another pattern than the one analysed")]
    NotAnalysed,
    /// Solve without a (successful) factorisation.
    #[error("solve called without a factorisation")]
    NotFactored,
    /// Equations of scalar unknowns, or far couplings, that determine nothing.
    #[error("the equations of the scalar unknowns depend on each other")]
    DependentBorders,
    /// An entry of the matrix is infinite or not a number.
    #[error("entry ({row}, {col}) of the matrix is not finite: row of the {unknown}")]
    NotFinite {
        /// Row of the first such entry.
        row: usize,
        /// Its column.
        col: usize,
        /// Unknown of the row.
        unknown: Unknown,
    },
    /// An entry of the right-hand side is infinite or not a number.
    #[error("entry {row} of the right-hand side is not finite: row of the {unknown}")]
    RightHandSide {
        /// First such row.
        row: usize,
        /// Unknown of the row.
        unknown: Unknown,
    },
    /// A row of the matrix vanishes.
    #[error("row {row} of the matrix is zero: no equation for the {unknown}")]
    ZeroRow {
        /// The row.
        row: usize,
        /// Unknown of the row.
        unknown: Unknown,
    },
    /// A column of the matrix vanishes.
    #[error("column {col} of the matrix is zero: no equation contains the {unknown}")]
    ZeroColumn {
        /// The column.
        col: usize,
        /// Unknown of the column.
        unknown: Unknown,
    },
    /// The matrix is singular to working precision.
    #[error(
        "the matrix is singular (condition number about {condition:.1e}); \
         it does not determine the {unknown}"
    )]
    Singular {
        /// Estimate in scaled variables; infinite for a zero pivot.
        condition: f64,
        /// Number of the unknown where the null vector is largest.
        index: usize,
        /// What it is.
        unknown: Unknown,
    },
    /// A matrix that should be symmetric positive definite is not.
    #[error("the matrix is not positive definite: pivot of the {unknown}")]
    NotDefinite {
        /// Number of the unknown whose diagonal entry is not positive, or the first of those that were eliminated
        /// together with a pivot that is not.
        index: usize,
        /// What it is.
        unknown: Unknown,
    },
    /// Refinement does not bring the residual down: the factors are not those of the matrix.
    #[error(
        "the linear system was solved inaccurately: backward error {backward_error:.1e} \
         after {refinements} refinements, allowed {allowed:.1e}"
    )]
    Inaccurate {
        /// Backward error reached.
        backward_error: f64,
        /// Refinement steps taken.
        refinements: usize,
        /// Largest backward error accepted.
        allowed: f64,
    },
    /// An iteration with the factors of another matrix does not reduce the residual enough.
    #[error(
        "the linear system was not solved: residual reduced by {reduction:.1e} in {iterations} iterations, allowed {allowed:.1e}"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Residual reached, relative to the right-hand side.
        reduction: f64,
        /// The largest accepted.
        allowed: f64,
    },
    /// A solver that is no part of the program.
    #[error("{0}")]
    Engine(String),
    /// Memory is short.
    #[error("no memory for the factors: {0}")]
    Memory(String),
    /// The program was built for processors with other instructions.
    #[error(
        "this build computes in three dimensions on processors with {0} alone: build it on this machine, or with the \
         feature `undula/narrow`, one cell at a time"
    )]
    Processor(&'static str),
    /// A number of rows or entries does not fit.
    #[error("the problem is too large: {0}; fewer cells are needed, or cells of a lower degree")]
    TooLarge(String),
}
