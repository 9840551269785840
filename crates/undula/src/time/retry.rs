//! A step, and smaller ones where it fails.

use super::report::{StepFailure, StepReport};
use super::schedule::decimal;
use super::scheme::Scheme;
use super::stepper::Stepper;

impl<const D: usize> Stepper<D> {
    /// Carry the solution on by `k` \[s\], in smaller parts if need be.
    ///
    /// # Errors
    /// [`StepFailure`]; everything is then as before the step, whatever its parts had reached.
    pub fn step(&mut self, k: f64) -> Result<StepReport, StepFailure> {
        self.step_to(k, decimal(self.time, k))
    }

    /// The same to the time `end` \[s\], which is the present one and `k` but for rounding.
    ///
    /// # Errors
    /// As [`Stepper::step`].
    pub fn step_to(&mut self, k: f64, end: f64) -> Result<StepReport, StepFailure> {
        let damping = self.damping;
        self.damping = self.settings.scheme.damping(damping, self.time - self.start);
        self.attempts.clear();
        let mut result = self.step_or_halves(k, end);
        match &mut result {
            Ok(_) => self.damping.left = self.damping.left.saturating_sub(1),
            Err(failure) => {
                self.damping = damping;
                failure.details.attempts = std::mem::take(&mut self.attempts);
            }
        }
        result
    }

    fn step_or_halves(&mut self, k: f64, end: f64) -> Result<StepReport, StepFailure> {
        let failure = match self.whole(k, end) {
            Ok(report) => return Ok(report),
            Err(failure) => failure,
        };
        if self.settings.max_halvings == 0 || !self.can_halve(&failure, end) {
            return Err(failure);
        }
        let (clock, states) = (self.clock(), (self.new.clone(), self.old.clone()));
        let result = self.halves(k, end, self.settings.max_halvings);
        if result.is_err() {
            self.set_clock(clock);
            (self.new, self.old) = states;
        }
        result
    }

    /// One step of the scheme without division; on failure everything is as before.
    fn whole(&mut self, k: f64, end: f64) -> Result<StepReport, StepFailure> {
        match self.settings.scheme {
            Scheme::FractionalStepTheta => self.fractional_step(k, end),
            scheme => match scheme.tableau() {
                Some(method) => self.runge_kutta(method, k, end),
                None => self.attempt(k, end, 0),
            },
        }
    }

    fn divided(&mut self, k: f64, end: f64, halvings: u32) -> Result<StepReport, StepFailure> {
        match self.whole(k, end) {
            Ok(report) => Ok(report),
            Err(failure) if halvings == 0 || !self.can_halve(&failure, end) => Err(failure),
            Err(_) => self.halves(k, end, halvings),
        }
    }

    /// Whether smaller parts of a step to `end` may help after `failure`: not where the user stops, where something else
    /// is to blame, nor where they have no length.
    fn can_halve(&self, failure: &StepFailure, end: f64) -> bool {
        let middle = self.middle(end);
        // What is to blame may be known to one of several processes alone.
        let is_final = self.assembler.space.any(failure.is_final());
        !failure.is_stop() && !is_final && self.time < middle && middle < end
    }

    fn middle(&self, end: f64) -> f64 {
        self.time + 0.5 * (end - self.time)
    }

    fn halves(&mut self, k: f64, end: f64, halvings: u32) -> Result<StepReport, StepFailure> {
        self.newton.forget();
        let mut total = self.divided(0.5 * k, self.middle(end), halvings - 1)?;
        total.add(self.divided(0.5 * k, end, halvings - 1)?);
        self.newton.forget();
        Ok(total)
    }
}
