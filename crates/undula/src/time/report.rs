//! How a step went.

use super::cause::{Cause, Ended};
use crate::algebra::SolverError;
use crate::linear::BlockNorms;
use crate::math::{rounded, shortest};
use crate::nonlinear::{NewtonError, NewtonReport};
use crate::system::Worst;
use std::fmt;

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
    /// Ends of the parts in `residuals`: a part of a divided step, of fractional-step θ, of the load.
    pub ends: Vec<usize>,
}

/// An iteration that failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Time that was tried \[s\].
    pub time: f64,
    /// Length of the step \[s\]; 0 if stationary.
    pub step: f64,
    /// Part of the load; 1 in time.
    pub load: f64,
    /// Why, with its residuals.
    pub reason: NewtonError,
}

/// Attempts that are kept.
const ATTEMPTS: usize = 50;

/// A step that could not be done even when halved, or a stationary solution that was not found.
#[derive(Clone, Debug)]
pub struct StepFailure {
    /// Time that was tried \[s\].
    pub time: f64,
    /// Step that was tried last \[s\]; 0 if stationary.
    pub step: f64,
    /// How the last iteration ended.
    pub reason: NewtonError,
    /// Where J was smallest in the last residual.
    pub worst: Worst,
    /// Why it ended so, and what was tried.
    pub details: Box<Details>,
}

/// More of a failure.
#[derive(Clone, Debug)]
pub struct Details {
    /// Why, and where.
    pub cause: Cause,
    /// Part of the load for which there is a stationary solution; `None` in time.
    pub load: Option<f64>,
    /// The iterations that failed, the last one last.
    pub attempts: Vec<Attempt>,
}

impl std::error::Error for StepFailure {}

impl fmt::Display for StepFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.headline(), self.details.cause)
    }
}

impl StepFailure {
    /// Of a step of length `step` to `time` \[s\]; with `load` of a stationary solution.
    pub(super) fn new(time: f64, step: f64, load: Option<f64>, ended: Ended) -> StepFailure {
        let Ended { reason, worst, cause } = ended;
        let details = Box::new(Details { cause: *cause, load, attempts: vec![] });
        StepFailure { time, step, reason, worst, details }
    }

    /// What could not be done, without the cause.
    pub fn headline(&self) -> String {
        match self.details.load {
            Some(load) if load > 0.0 && load < 1.0 => {
                format!(
                    "no stationary solution with more than {} of the load",
                    shortest(rounded(load, load, 3))
                )
            }
            Some(_) => "no stationary solution".into(),
            None => {
                let time = shortest(rounded(self.time, self.step, 3));
                let step = shortest(rounded(self.step, self.step, 3));
                format!("no solution for the step to t = {time} s (k = {step} s)")
            }
        }
    }

    /// Whether smaller steps or loads cannot help.
    pub fn is_final(&self) -> bool {
        self.is_too_large() || matches!(self.details.cause, Cause::Data(_))
    }

    /// Whether the problem does not fit the program or the memory.
    pub fn is_too_large(&self) -> bool {
        matches!(&self.reason, NewtonError::Linear(SolverError::TooLarge(_) | SolverError::Memory(_)))
    }

    /// This failure as one of the attempts of the step.
    pub(super) fn attempt(&self, load: f64) -> Attempt {
        Attempt { time: self.time, step: self.step, load, reason: self.reason.clone() }
    }
}

/// Remember `attempt`; the first ones are forgotten where there are many.
pub(super) fn keep(attempts: &mut Vec<Attempt>, attempt: Attempt) {
    if attempts.len() == ATTEMPTS {
        attempts.remove(0);
    }
    attempts.push(attempt);
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
        let ends = vec![residuals.len()];
        StepReport { newton_steps: steps, jacobians, parts: 1, norms, min_j, residuals, ends }
    }

    /// Nothing yet, for [`StepReport::add`].
    pub(super) fn none() -> StepReport {
        StepReport { min_j: f64::INFINITY, ..StepReport::default() }
    }

    /// Add that of the next part of a step.
    pub(super) fn add(&mut self, next: StepReport) {
        let before = self.residuals.len();
        self.newton_steps += next.newton_steps;
        self.jacobians += next.jacobians;
        self.parts += next.parts;
        self.norms = next.norms;
        self.min_j = self.min_j.min(next.min_j);
        self.residuals.extend(next.residuals);
        self.ends.extend(next.ends.iter().map(|end| before + end));
    }

    /// The residuals of each part.
    pub fn residuals_of_parts(&self) -> impl Iterator<Item = &[f64]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(&start, &end)| &self.residuals[start..end])
    }
}
