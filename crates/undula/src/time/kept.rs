//! What a stepper keeps of the steps before: where its Jacobian was taken, what a step is taken back to, and the parts
//! of the last one.

use crate::nonlinear::{self, Age};
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

/// What a step changes besides solution and clock, as it was before: a step that the user stops must leave no trace
/// in a checkpoint.
#[derive(Default)]
pub(super) struct Before {
    pub(super) point: Option<JacobianPoint>,
    /// The factorisation that `point` belongs to.
    pub(super) factorization: Option<usize>,
    pub(super) keeps: bool,
    pub(super) newton: nonlinear::Memory,
    pub(super) detour: u32,
}

/// The parts of a step of fractional-step θ.
pub struct Parts {
    /// Length of the step \[s\].
    pub length: f64,
    /// Ends of the parts \[s\], the beginning first.
    pub(super) times: [f64; 4],
    pub(super) rules: [StepRule; 3],
    /// The solutions then, with the pressures of the parts.
    pub(super) states: [State; 4],
    /// The solution before the step, for extrapolation.
    pub(super) old: State,
}

impl Parts {
    pub(super) fn new(like: &State) -> Parts {
        let states = [like.clone(), like.clone(), like.clone(), like.clone()];
        Parts { length: 0.0, times: [0.0; 4], rules: [StepRule::STATIONARY; 3], states, old: like.clone() }
    }
}
