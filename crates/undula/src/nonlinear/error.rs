//! How a solve fails.

use crate::algebra::SolverError;

/// Why a solve failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NewtonError {
    /// The iteration no longer reduces the residual, or not within the iterations allowed.
    #[error("the nonlinear iteration does not converge")]
    Stalled {
        /// Scaled residual after each iteration.
        norms: Vec<f64>,
    },
    /// The iteration is linear, and too slow to end within the iterations allowed.
    #[error("the nonlinear iteration converges too slowly: by the factor {rate:.3} per iteration")]
    Slow {
        /// Scaled residual after each iteration.
        norms: Vec<f64>,
        /// Mean factor of the last iterations.
        rate: f64,
        /// Iterations that would be left at this rate, infinite from 1 on.
        left: f64,
        /// Iterations allowed.
        allowed: usize,
    },
    /// The start value, or every shortened update, is not admissible.
    #[error("the iterate is not admissible (the domain map folds or a value is not finite)")]
    Inadmissible,
    /// The user stops it.
    #[error("stopped")]
    Stopped,
    /// The linear system could not be solved.
    #[error(transparent)]
    Linear(#[from] SolverError),
}

/// Iterations over which the rate of a linear iteration is estimated. Before twice as many it is not judged.
const WINDOW: usize = 10;
/// From here on, and before with this margin, an iteration that will not end within those allowed is given up.
const JUDGED: usize = 6 * WINDOW;
const MARGIN: f64 = 1.5;

impl NewtonError {
    /// Whether the iteration of a linear solver has not converged.
    pub fn is_of_linear_iteration(&self) -> bool {
        matches!(self, NewtonError::Linear(SolverError::NotConverged { .. }))
    }

    /// Scaled residuals at the start and after each iteration, as far as there are any.
    pub fn norms(&self) -> &[f64] {
        match self {
            NewtonError::Stalled { norms } | NewtonError::Slow { norms, .. } => norms,
            NewtonError::Inadmissible | NewtonError::Stopped | NewtonError::Linear(_) => &[],
        }
    }

    /// Why an iteration with the residuals `norms` is given up before the `allowed` iterations: extrapolated at the
    /// better of its last two mean rates it would need more to reach `target`.
    pub(super) fn too_slow(norms: &[f64], target: f64, allowed: usize) -> Option<NewtonError> {
        let done = norms.len() - 1;
        if done < 2 * WINDOW {
            return None;
        }
        let mean = |end: usize| (norms[end] / norms[end - WINDOW]).powf(1.0 / WINDOW as f64);
        let rate = mean(done).min(mean(done - WINDOW));
        let left = if rate < 1.0 { (target / norms[done]).ln() / rate.ln() } else { f64::INFINITY };
        let margin = if done < JUDGED { MARGIN } else { 1.0 };
        (left > margin * (allowed - done) as f64).then(|| NewtonError::Slow {
            norms: norms.to_vec(),
            rate,
            left: left.ceil(),
            allowed,
        })
    }
}
