//! What a stepper remembers: for a checkpoint, for a step that is stopped, and for one that is rejected.

use super::kept::{Before, JacobianPoint};
use super::scheme::Damping;
use super::solver::Moment;
use super::stages::Stages;
use super::stepper::Stepper;
use crate::nonlinear::{self, NewtonError};
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

/// All that a stepper needs to go on with the same bits: what a checkpoint keeps of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// Where it stands in time.
    pub clock: Clock,
    /// The last solution.
    pub new: State,
    /// The solution before.
    pub old: State,
    /// Where the Jacobian was taken that the next step will start with; `None`: it will make a new one.
    pub point: Option<JacobianPoint>,
    /// Of Newton's method.
    pub newton: nonlinear::Memory,
    /// Steps to go with the whole Jacobian after that has failed.
    pub detour: u32,
    /// Stages of the last step of a Runge-Kutta method, the last one last: times \[s\], derivatives of v, u and s, and
    /// pressures.
    pub stages: Vec<(f64, State)>,
}

impl Memory {
    /// That of a run which begins with the solutions `new` and, before it, `old`.
    pub fn of(clock: Clock, new: State, old: State) -> Memory {
        let newton = nonlinear::Memory::default();
        Memory { clock, new, old, point: None, newton, detour: 0, stages: vec![] }
    }
}

impl<const D: usize> Stepper<D> {
    /// What a checkpoint keeps.
    pub fn save(&self) -> Memory {
        let Stepper {
            // From the case.
            assembler: _,
            settings: _,
            start: _,
            forces: _,
            source: _,
            // In the clock.
            time: _,
            last_step: _,
            damping: _,
            // With their own memory.
            newton,
            linear,
            new,
            old,
            stages,
            point: _,
            // Written by a step before it reads them, or of the last step alone.
            older: _,
            base: _,
            last: _,
            parts: _,
            explicit: _,
            reference: _,
            whole_at_rest: _,
            before: _,
            fault: _,
            attempts: _,
        } = self;
        let (new, old, point) = (new.clone(), old.clone(), self.jacobian_point().cloned());
        let (newton, detour) = (newton.save(), linear.save());
        let stages = stages.as_ref().map_or(vec![], Stages::save);
        Memory { clock: self.clock(), new, old, point, newton, detour, stages }
    }

    /// Go on from a checkpoint: the last two solutions, the clock and the kept Jacobian.
    ///
    /// # Errors
    /// If the kept Jacobian cannot be factorised again.
    pub fn restore(&mut self, memory: Memory) -> Result<(), NewtonError> {
        let Memory { clock, new, old, point, newton, detour, stages } = memory;
        self.linear.restore(detour);
        self.newton.restore(newton);
        self.set_clock(clock);
        self.stages = Stages::restore(stages, &new);
        (self.new, self.old, self.parts) = (new, old, None);
        self.before = Before::default();
        if let Some(JacobianPoint { rule, time, mut new, old, age }) = point {
            self.set_forces(End::New, time, 1.0);
            let moment = Moment { rule, time, force_time: time };
            let (mut system, newton) = self.split().0.system(moment, &mut new, &old);
            newton.recall(&mut system, age)?;
            if let Some(point) = &mut self.point {
                point.age = age;
            }
        }
        self.set_forces(End::New, clock.time, 1.0);
        self.set_forces(End::Old, clock.time, 1.0);
        Ok(())
    }

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
        (before.keeps, before.newton, before.detour) = (newton.keeps(), newton.save(), self.linear.save());
    }

    /// After a step that was stopped: what a checkpoint keeps is that of before the step. The factors at hand belong
    /// to the step, so another one would not have the bits of a run that goes on from the checkpoint.
    pub(crate) fn undo(&mut self) {
        let Stepper { before, newton, point, .. } = self;
        if before.keeps {
            std::mem::swap(point, &mut before.point);
        }
        before.factorization = None;
        newton.undo(before.keeps, before.newton);
        self.linear.detour = before.detour;
    }

    /// The clock.
    pub(super) fn clock(&self) -> Clock {
        Clock { time: self.time, last_step: self.last_step, damping: self.damping }
    }

    pub(super) fn set_clock(&mut self, clock: Clock) {
        Clock { time: self.time, last_step: self.last_step, damping: self.damping } = clock;
    }

    /// Take the last step back.
    pub(super) fn go_back(&mut self, clock: Clock, new: &State, old: &State) {
        self.set_clock(clock);
        self.new.copy_from(new);
        self.old.copy_from(old);
        if let Some(stages) = &mut self.stages {
            stages.go_back();
        }
    }

    /// Where the Jacobian that the next step will start with was taken; `None`: it will make a new one.
    fn jacobian_point(&self) -> Option<&JacobianPoint> {
        self.point.as_ref().filter(|_| self.newton.keeps())
    }
}
