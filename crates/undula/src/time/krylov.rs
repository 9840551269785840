//! GMRES for one matrix, preconditioned by the factors of another.

use super::scales::Scales;
use crate::algebra::{Csr, Gmres, LinearSolver, SolverError};

/// What GMRES is asked for.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct KrylovSettings {
    /// Residual of the linear system relative to its right-hand side, in the units of Newton's criterion.
    pub tolerance: f64,
    /// Iterations at most; beyond them the factors are renewed.
    pub size: usize,
    /// Units of the residuals.
    pub scales: Scales,
}

/// GMRES for the matrices of one pattern.
pub(super) struct Krylov {
    gmres: Gmres,
    pub(super) scales: Scales,
    /// Of the rows.
    pub(super) weights: Vec<f64>,
    /// Whether the factors are of an older matrix than the one at hand.
    pub(super) active: bool,
}

impl Krylov {
    pub(super) fn new(settings: KrylovSettings, rows: usize) -> Krylov {
        let KrylovSettings { tolerance, size, scales } = settings;
        Krylov { gmres: Gmres::new(tolerance, size), scales, weights: vec![1.0; rows], active: false }
    }

    /// The matrix is new, the factors are not.
    pub(super) fn begin(&mut self) {
        self.gmres.clear();
        self.active = true;
    }

    /// x ← A⁻¹ b; `before` and `after` make the factors those of a step with another k.
    pub(super) fn solve(
        &mut self,
        solver: &mut dyn LinearSolver,
        a: &Csr,
        (before, after): (impl Fn(&mut [f64]), impl Fn(&mut [f64])),
        b: &[f64],
        x: &mut [f64],
    ) -> Result<usize, SolverError> {
        let precondition = |r: &mut [f64], z: &mut [f64]| {
            before(r);
            solver.apply(r, z);
            after(z);
        };
        Ok(self.gmres.solve(a, &self.weights, precondition, b, x)?.iterations)
    }
}
