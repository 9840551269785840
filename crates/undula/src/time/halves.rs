//! A step, and smaller ones where it fails.

use super::report::{StepFailure, StepReport};
use super::scheme::Scheme;
use super::stepper::Stepper;

impl<const D: usize> Stepper<D> {
    /// Carry the solution on by `k` \[s\], in smaller parts if need be.
    ///
    /// # Errors
    /// [`StepFailure`]; everything is then as before the step, whatever its parts had reached.
    pub fn step(&mut self, k: f64) -> Result<StepReport, StepFailure> {
        self.damping = self.settings.scheme.damping(self.damping, self.time - self.start);
        self.attempts.clear();
        let mut result = self.step_or_halves(k);
        match &mut result {
            Ok(_) => self.damping.left = self.damping.left.saturating_sub(1),
            Err(failure) => failure.details.attempts = std::mem::take(&mut self.attempts),
        }
        result
    }

    fn step_or_halves(&mut self, k: f64) -> Result<StepReport, StepFailure> {
        let failure = match self.whole(k) {
            Ok(report) => return Ok(report),
            Err(failure) => failure,
        };
        if self.settings.max_halvings == 0 || failure.is_final() {
            return Err(failure);
        }
        let (clock, states) = (self.clock(), (self.new.clone(), self.old.clone()));
        let result = self.halves(k, self.settings.max_halvings);
        if result.is_err() {
            self.set_clock(clock);
            (self.new, self.old) = states;
        }
        result
    }

    /// One step of the scheme without division; on failure everything is as before.
    fn whole(&mut self, k: f64) -> Result<StepReport, StepFailure> {
        match self.settings.scheme {
            Scheme::FractionalStepTheta => self.fractional_step(k),
            _ => self.attempt(k, 0),
        }
    }

    fn divided(&mut self, k: f64, halvings: u32) -> Result<StepReport, StepFailure> {
        match self.whole(k) {
            Ok(report) => Ok(report),
            Err(failure) if halvings == 0 || failure.is_final() => Err(failure),
            Err(_) => self.halves(k, halvings),
        }
    }

    fn halves(&mut self, k: f64, halvings: u32) -> Result<StepReport, StepFailure> {
        self.newton.forget();
        let mut total = self.divided(0.5 * k, halvings - 1)?;
        total.add(self.divided(0.5 * k, halvings - 1)?);
        self.newton.forget();
        Ok(total)
    }
}
