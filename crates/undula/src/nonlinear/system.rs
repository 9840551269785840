//! What Newton's method wants to know of a system.

use super::report::Seconds;
use crate::algebra::SolverError;

/// A system `r(x) = 0` that holds its own iterate.
pub trait NonlinearSystem {
    /// Residual at the iterate into `r`; returns its scaled norm, or `None` where the iterate is not
    /// admissible (the domain map has folded, or a number is not finite).
    fn residual(&mut self, r: &mut [f64]) -> Option<f64>;
    /// Jacobian, or what stands for it, at the iterate, ready for corrections; returns how many times its factors were
    /// applied already.
    ///
    /// # Errors
    /// If it is singular.
    fn renew(&mut self, seconds: &mut Seconds) -> Result<usize, SolverError>;
    /// Whether the factors can be those of an older Jacobian than the one that corrections come from.
    fn is_iterative(&self) -> bool {
        false
    }
    /// The Jacobian at the iterate, with the factors at hand as its preconditioner; called where it
    /// [is iterative](NonlinearSystem::is_iterative). Returns how many times they were applied already.
    ///
    /// # Errors
    /// If there are no factors.
    fn refresh(&mut self, _seconds: &mut Seconds) -> Result<usize, SolverError> {
        Err(SolverError::NotFactored)
    }
    /// δ ← J⁻¹ r with the Jacobian at hand; returns how many times its factors were applied to a residual.
    ///
    /// # Errors
    /// If they cannot be applied, or the tolerance of the linear system is not reached.
    fn correct(&mut self, r: &[f64], delta: &mut [f64]) -> Result<usize, SolverError>;
    /// Whether what [`NonlinearSystem::renew`] makes is the derivative, or leaves out a part of it or
    /// corrects by it no better than to a tolerance.
    fn is_exact(&self) -> bool;
    /// Whether an update is so small that it only moves the iterate within its rounding.
    fn is_negligible(&self, _delta: &[f64]) -> bool {
        false
    }
    /// Scaled residual that rounding leaves of a solution of the size of the iterate.
    fn rounding(&self) -> f64 {
        0.0
    }
    /// What a new Jacobian costs, in iterations; where it [is iterative](NonlinearSystem::is_iterative) what its factors
    /// alone cost, in iterations of the linear solver.
    fn price(&self) -> f64;
    /// `x ← x + ω δ`.
    fn update(&mut self, omega: f64, delta: &[f64]);
}
