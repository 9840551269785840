//! What every linearisation does: a matrix, its factors, and corrections by them.

use super::factors::Factored;
use super::price::Work;
use crate::algebra::{LinearSolver, SolverError};
use crate::physics::StepRule;
use crate::space::{FsiSpace, State};
use crate::system::{Assembler, StepView};
use crate::tangent::{Linearization, Tangent};

/// Where a matrix is taken, what it leaves out, and how derivatives are computed.
pub(super) struct At<'a, const D: usize> {
    pub(super) assembler: &'a mut Assembler<D>,
    pub(super) view: &'a StepView<'a>,
    pub(super) linearization: Linearization,
    pub(super) tangent: Tangent,
}

/// Corrections by one matrix.
pub(super) trait Correction<const D: usize>: Send {
    /// The matrix with the factors that are applied to its residuals.
    fn factored(&mut self) -> &mut Factored;

    /// Put the Jacobian at the iterate into the matrix.
    fn assemble(&mut self, at: &mut At<'_, D>);

    /// The factors are those of an older matrix from now on: GMRES with the weights of a step with 1/k = `per_k`.
    fn precondition(&mut self, space: &FsiSpace<D>, per_k: f64);

    /// δ from the residual `r` \[v, u, p\]; with `settled` that of the extension may be taken for zero. Returns how
    /// many times factors were applied.
    ///
    /// # Errors
    /// If the solution is inaccurate.
    fn correct(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError>;

    /// What applies factors, or cycles.
    fn solvers(&self) -> Vec<&dyn LinearSolver>;

    /// What renewals and iterations do, for their price.
    fn work(&self) -> Work;

    /// Factorise the extension at the iterate of `view`, where it is apart and not constant.
    ///
    /// # Errors
    /// If it is singular.
    fn renew_extension(&mut self, _: &Assembler<D>, _: &StepView<'_>) -> Result<(), SolverError> {
        Ok(())
    }

    /// Make `new` satisfy the velocity-deformation relation at the nodes and take the extension along, where
    /// corrections take the relation for granted; `moved` as in [`super::Linear::start`].
    fn follow(
        &mut self,
        _: &Assembler<D>,
        _: StepRule,
        _new: &mut State,
        _old: &State,
        _moved: &[(usize, f64)],
    ) {
    }
}
