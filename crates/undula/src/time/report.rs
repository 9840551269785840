//! How a step went.

use super::system::BlockNorms;
use crate::assembly::Worst;
use crate::nonlinear::{NewtonError, NewtonReport};

/// How a step went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Newton iterations, over all parts of a divided step.
    pub newton_steps: usize,
    /// Jacobians assembled.
    pub jacobians: usize,
    /// Into how many parts the step was divided.
    pub parts: usize,
    /// Scaled norms of the equations at the end \[m/s\].
    pub norms: BlockNorms,
    /// Smallest J at quadrature points and nodes.
    pub min_j: f64,
    /// Scaled residual at the start and after each Newton iteration, over all parts \[m/s\].
    pub residuals: Vec<f64>,
}

/// A step that could not be done even when halved.
#[derive(Clone, Debug, thiserror::Error)]
#[error("no solution for the step to t = {time:.6} s (k = {step:.3e} s): {reason}")]
pub struct StepFailure {
    /// Time that was tried \[s\].
    pub time: f64,
    /// Step that was tried last \[s\].
    pub step: f64,
    /// Why.
    pub reason: NewtonError,
    /// Where J was smallest in the last residual.
    pub worst: Worst,
}

impl StepFailure {
    /// Whether the user stopped it: then it is no failure.
    pub fn is_stop(&self) -> bool {
        self.reason == NewtonError::Stopped
    }
}

impl StepReport {
    /// Of one step without division.
    pub(super) fn new(newton: NewtonReport, norms: BlockNorms, min_j: f64) -> StepReport {
        let NewtonReport { steps, jacobians, norms: residuals, .. } = newton;
        StepReport { newton_steps: steps, jacobians, parts: 1, norms, min_j, residuals }
    }

    /// Add that of the next part of a step.
    pub(super) fn add(&mut self, next: StepReport) {
        self.newton_steps += next.newton_steps;
        self.jacobians += next.jacobians;
        self.norms = next.norms;
        self.min_j = self.min_j.min(next.min_j);
    }
}
