//! Where a run stands: what a checkpoint keeps, and what a rejected step goes back to.

use super::kept::{Before, JacobianPoint};
use super::scales::BlockNorms;
use super::scheme::Damping;
use super::stepper::Stepper;
use super::system::StepSystem;
use crate::nonlinear::NewtonError;
use crate::space::State;
use crate::system::End;

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
    /// Remember what the step to come may change, so that [`Stepper::undo`] can take it back. Costs a copy of two
    /// states after each new Jacobian.
    pub(crate) fn remember(&mut self) {
        let Stepper { before, newton, point, .. } = self;
        if newton.keeps() {
            match (&mut before.point, point) {
                (Some(kept), Some(point)) if before.factorization == Some(newton.counters.factorizations) => {
                    kept.age = point.age;
                }
                (Some(kept), Some(point)) => {
                    (kept.rule, kept.time, kept.age) = (point.rule, point.time, point.age);
                    kept.new.copy_from(&point.new);
                    kept.old.copy_from(&point.old);
                }
                (kept, point) => kept.clone_from(point),
            }
            before.factorization = Some(newton.counters.factorizations);
        }
        (before.keeps, before.worsening) = (newton.keeps(), newton.worsening);
        (before.detour, before.counters) = (self.linear.detour, newton.counters);
    }

    /// After a step that was stopped: what a checkpoint keeps is that of before the step. The factors at hand belong
    /// to the step, so another one would not have the bits of a run that goes on from the checkpoint.
    pub(crate) fn undo(&mut self) {
        let Stepper { before, newton, point, .. } = self;
        if before.keeps {
            std::mem::swap(point, &mut before.point);
        }
        before.factorization = None;
        newton.set_kept(before.keeps);
        (newton.worsening, newton.counters) = (before.worsening, before.counters);
        self.linear.detour = before.detour;
    }

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
        self.before = Before::default();
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
