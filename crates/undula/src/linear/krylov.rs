//! GMRES for one matrix, preconditioned by the factors of another.

use super::scales::Scales;
use crate::algebra::{Gmres, GmresSettings, LinearOperator, SolverError};
use crate::parallel::Halo;
use std::sync::Arc;

/// What GMRES is asked for.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct KrylovSettings {
    /// When it ends; beyond its iterations the factors are renewed.
    pub gmres: GmresSettings,
    /// Units of the residuals, those of Newton's criterion.
    pub scales: Scales,
}

/// GMRES for operators of one size.
pub(super) struct Krylov {
    gmres: Gmres,
    scales: Scales,
    /// Of the rows.
    weights: Vec<f64>,
    /// Whether the factors are of an older matrix than the one at hand.
    pub(super) active: bool,
}

impl Krylov {
    /// Of a system that processes share where there is a `halo`.
    pub(super) fn new(settings: KrylovSettings, rows: usize, halo: Option<Arc<Halo>>) -> Krylov {
        let KrylovSettings { gmres, scales } = settings;
        Krylov { gmres: Gmres::new(gmres).shared(halo), scales, weights: vec![1.0; rows], active: false }
    }

    /// The operator is new, the factors are not; `set` sets the weights of the rows.
    pub(super) fn begin(&mut self, set: impl FnOnce(&Scales, &mut [f64])) {
        set(&self.scales, &mut self.weights);
        self.gmres.clear();
        self.active = true;
    }

    /// x ← A⁻¹ b; `precondition(r, z)` sets z ← P r, and may spoil `r`. Returns the number of iterations.
    pub(super) fn solve(
        &mut self,
        a: &dyn LinearOperator,
        precondition: impl FnMut(&mut [f64], &mut [f64]),
        b: &[f64],
        x: &mut [f64],
    ) -> Result<usize, SolverError> {
        Ok(self.gmres.solve(a, &self.weights, precondition, b, x)?.iterations)
    }
}
