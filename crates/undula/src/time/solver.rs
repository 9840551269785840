//! A stepper taken apart: the states of a step, and what makes and solves its system.

use super::kept::JacobianPoint;
use super::stepper::{Stepper, StepperSettings};
use super::system::StepSystem;
use crate::linear::{BlockNorms, Linear};
use crate::nonlinear::Newton;
use crate::physics::StepRule;
use crate::space::State;
use crate::system::Assembler;

/// Which step it is.
pub(super) struct Moment {
    /// Weights of the scheme.
    pub(super) rule: StepRule,
    /// New time \[s\].
    pub(super) time: f64,
    /// Time of the body force \[s\].
    pub(super) force_time: f64,
}

/// The solutions of a stepper: see its fields.
pub(super) struct States<'a> {
    pub(super) new: &'a mut State,
    pub(super) old: &'a State,
    pub(super) older: &'a State,
    pub(super) base: &'a State,
}

/// All else of a stepper that a solution takes.
pub(super) struct Solver<'a, const D: usize> {
    assembler: &'a mut Assembler<D>,
    linear: &'a mut Linear<D>,
    newton: &'a mut Newton,
    explicit: &'a [f64],
    settings: &'a StepperSettings,
    point: &'a mut Option<JacobianPoint>,
}

impl<const D: usize> Stepper<D> {
    /// Both at once, so that a system may be made of states of the stepper and of others.
    pub(super) fn split(&mut self) -> (Solver<'_, D>, States<'_>) {
        let Stepper { assembler, linear, newton, explicit, settings, point, new, old, older, base, .. } =
            self;
        (Solver { assembler, linear, newton, explicit, settings, point }, States { new, old, older, base })
    }
}

impl<'a, const D: usize> Solver<'a, D> {
    /// The system of a step from `old` to `new`, and Newton's method for it.
    pub(super) fn system(
        self,
        at: Moment,
        new: &'a mut State,
        old: &'a State,
    ) -> (StepSystem<'a, D>, &'a mut Newton) {
        let Solver { assembler, linear, newton, explicit, settings, point } = self;
        let Moment { rule, time, force_time } = at;
        let (scales, tangent, norms) = (settings.scales, settings.tangent, BlockNorms::default());
        let system = StepSystem {
            assembler,
            linear,
            rule,
            new,
            old,
            explicit,
            scales,
            tangent,
            time,
            force_time,
            point,
            min_j: 1.0,
            norms,
        };
        (system, newton)
    }
}
