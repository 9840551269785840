//! What a new Jacobian costs: estimated from numbers of unknowns, operations and bytes, so that it is the same on every
//! run.

use crate::algebra::Cost;
use crate::parallel::{Halo, Reduce};
use std::sync::Arc;

/// A new Jacobian in iterations where the solver does not tell what it does.
pub(super) const TYPICAL: f64 = 5.0;

/// Nanoseconds of one core of a typical machine: per unknown for a Jacobian and the overhead of its fronts, for that
/// alone, and for the residual and vectors of an iteration; operations and bytes of the factors per nanosecond.
const JACOBIAN: f64 = 300.0;
const FRONTS: f64 = 100.0;
const ITERATION: f64 = 25.0;
const OPERATIONS: f64 = 30.0;
const BYTES: f64 = 5.0;

/// Bytes of an entry of a matrix, and for a row those of the vectors of an iteration of GMRES.
const ENTRY: f64 = 12.0;
const ROW: f64 = 100.0;

/// What renewals and iterations do.
pub(super) struct Work {
    /// Unknowns of the full system.
    pub(super) unknowns: usize,
    /// Rows and entries of the matrix.
    pub(super) rows: usize,
    pub(super) entries: usize,
    /// Its factors; `None`: not known.
    pub(super) factors: Option<Cost>,
    /// Others that an iteration applies.
    pub(super) extension: Option<Cost>,
    /// Whether iterations are those of GMRES, and the factors alone are renewed.
    pub(super) iterative: bool,
    /// Where processes share the unknowns: all have to find the same.
    pub(super) halo: Option<Arc<Halo>>,
}

impl Work {
    /// A renewal in iterations.
    pub(super) fn price(&self) -> f64 {
        let price = self.here();
        match &self.halo {
            Some(halo) if self.factors.is_some() => halo.crew().one(Reduce::Max, price),
            _ => price,
        }
    }

    fn here(&self) -> f64 {
        let (Some(factors), unknowns) = (&self.factors, self.unknowns as f64) else { return TYPICAL };
        let bytes = |cost: &Cost| cost.read.unwrap_or(0) as f64;
        let numeric = factors.flops.unwrap_or(0.0) / OPERATIONS;
        if self.iterative {
            let (rows, entries) = (self.rows as f64, self.entries as f64);
            let iteration = (bytes(factors) + ENTRY * entries + ROW * rows) / BYTES;
            return (FRONTS * unknowns + numeric) / iteration;
        }
        let renewal = JACOBIAN * unknowns + numeric;
        let extension = self.extension.as_ref().map_or(0.0, bytes);
        let iteration = ITERATION * unknowns + (bytes(factors) + extension) / BYTES;
        renewal / iteration
    }
}
