//! Where a run stands: what a checkpoint keeps, and what a rejected step goes back to.

use super::scheme::Damping;
use super::stepper::Stepper;
use super::system::{BlockNorms, StepSystem};
use crate::assembly::End;
use crate::nonlinear::NewtonError;
use crate::nonlinear::newton::Age;
use crate::physics::StepRule;
use crate::space::State;

/// Where a Jacobian was taken: with it a resumed run repeats the same bits.
#[derive(Clone, Debug, PartialEq)]
pub struct JacobianPoint {
    /// Weights of the scheme.
    pub rule: StepRule,
    /// Time of the body force \[s\].
    pub time: f64,
    /// The iterate.
    pub new: State,
    /// What the difference is taken from.
    pub old: State,
    /// How it has done so far.
    pub age: Age,
}

/// Where a run stands in time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Clock {
    /// Time \[s\].
    pub time: f64,
    /// Length of the last step, or of its last part \[s\].
    pub last_step: f64,
    /// Where Rannacher's scheme stands.
    pub damping: Damping,
}

impl<const D: usize> Stepper<D> {
    /// The clock, for a checkpoint.
    pub fn clock(&self) -> Clock {
        Clock { time: self.time, last_step: self.last_step, damping: self.damping }
    }

    /// Take the last step back.
    pub(super) fn go_back(&mut self, clock: Clock, new: &State, old: &State) {
        self.set_clock(clock);
        self.new.copy_from(new);
        self.old.copy_from(old);
    }

    pub(super) fn set_clock(&mut self, clock: Clock) {
        Clock { time: self.time, last_step: self.last_step, damping: self.damping } = clock;
    }

    /// Where the Jacobian that the next step will start with was taken; `None`: it will make a new one.
    pub fn jacobian_point(&self) -> Option<&JacobianPoint> {
        self.point.as_ref().filter(|_| self.newton.keeps())
    }

    /// Go on from a checkpoint: the last two solutions, the clock and the kept Jacobian.
    ///
    /// # Errors
    /// If the kept Jacobian cannot be factorised again.
    pub fn restore(
        &mut self,
        clock: Clock,
        new: State,
        old: State,
        point: Option<JacobianPoint>,
    ) -> Result<(), NewtonError> {
        self.set_clock(clock);
        (self.new, self.old, self.parts) = (new, old, None);
        self.newton.forget();
        if let Some(point) = point {
            self.set_forces(End::New, point.time, 1.0);
            let mut new = point.new.clone();
            let mut system = StepSystem {
                assembler: &mut self.assembler,
                linear: &mut self.linear,
                rule: point.rule,
                new: &mut new,
                old: &point.old,
                explicit: &self.explicit,
                scales: self.settings.scales,
                tangent: self.settings.tangent,
                time: point.time,
                force_time: point.time,
                point: &mut self.point,
                min_j: 1.0,
                norms: BlockNorms::default(),
            };
            self.newton.recall(&mut system, point.age)?;
        }
        self.set_forces(End::New, clock.time, 1.0);
        self.set_forces(End::Old, clock.time, 1.0);
        Ok(())
    }
}

/// `t` as a decimal number: 0.3, not 0.30000000000000004.
pub(super) fn decimal(t: f64) -> f64 {
    (t * 1e12).round() / 1e12
}
