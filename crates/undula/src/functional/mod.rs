//! Numbers of interest.

pub mod averages;
pub mod balance;
pub mod body_energy;
pub mod energy;
pub mod fields;
pub mod force;
pub mod moment;
pub mod nodal;
pub mod point;
pub mod power;
pub mod quantity;
pub mod sampled;
mod signal;
pub mod site;
pub mod spatial;
pub mod statistics;
pub mod transfer;

use crate::physics::StepRule;
use crate::space::{FsiSpace, State};
use crate::system::{Assembler, Physics, StepView};
use body_energy::{Body, BodyResidual};

/// What a functional may look at after a step.
pub struct Snapshot<'a, const D: usize> {
    /// Spaces.
    pub space: &'a FsiSpace<D>,
    /// Parameters.
    pub physics: &'a Physics,
    /// Weights of the last step.
    pub rule: StepRule,
    /// Solution at the new time.
    pub new: &'a State,
    /// Solution at the old time.
    pub old: &'a State,
    /// Residual of the fluid alone in the last step, `[v, u, p]` \[N/m\]: what the fluid exerts on each node that a
    /// functional has asked for.
    pub fluid_residual: &'a [f64],
    /// The operators, for what the conditions on the boundary add to the residual; `None`: nothing.
    pub system: Option<&'a Assembler<D>>,
    /// Residuals of the volume terms of the bodies that functionals have asked for.
    pub volume: &'a [BodyResidual],
}

impl<'a, const D: usize> Snapshot<'a, D> {
    /// The step that it is of.
    pub fn step(&self) -> StepView<'a> {
        StepView { rule: self.rule, new: self.new, old: self.old }
    }
}

/// A number computed from the solution after each step.
pub trait Functional<const D: usize>: Send {
    /// SI unit; empty for a pure number.
    fn unit(&self) -> &'static str;
    /// Whether it belongs to the time t⁻ + θ k of the pressure instead of the new time.
    fn at_force_time(&self) -> bool {
        false
    }
    /// Nodes whose velocity rows of [`Snapshot::fluid_residual`] it reads.
    fn residual_nodes(&self) -> &[u32] {
        &[]
    }
    /// The body of which it reads [`Snapshot::volume`].
    fn residual_body(&self) -> Option<Body> {
        None
    }
    /// The value.
    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64;
}
