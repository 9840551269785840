//! The nonlinear system of one step.

use super::kept::JacobianPoint;
use crate::algebra::{self, SolverError};
use crate::linear::{BlockNorms, Linear, Scales};
use crate::nonlinear::{Age, NonlinearSystem, Seconds};
use crate::parallel::Reduce;
use crate::physics::StepRule;
use crate::space::State;
use crate::system::{Assembler, StepView};
use crate::tangent::{Linearization, Tangent};

/// Share of the largest residual below which that of the extension is left for a later iteration. It is linear
/// and solved to the last digits of the factors every time; without it substitution begins at the interface,
/// and passes over all fronts that are not behind it.
const SETTLED: f64 = 1e-5;

/// Part of v and u below which an update that does not reduce the residual is rounding.
const NEGLIGIBLE: f64 = 1e-12;

/// One step between two states.
pub struct StepSystem<'a, const D: usize> {
    /// Assembly.
    pub assembler: &'a mut Assembler<D>,
    /// Matrices and their factors.
    pub linear: &'a mut Linear<D>,
    /// Weights of the scheme.
    pub rule: StepRule,
    /// The iterate.
    pub new: &'a mut State,
    /// What the difference is taken from: the solution at the old time, or that of a multistep formula.
    pub old: &'a State,
    /// Explicit part and sources, `[v, u, p]`.
    pub explicit: &'a [f64],
    /// Units.
    pub scales: Scales,
    /// How derivatives are computed.
    pub tangent: Tangent,
    /// New time of the step \[s\].
    pub time: f64,
    /// Time of the body force \[s\].
    pub force_time: f64,
    /// Where the last Jacobian was taken.
    pub point: &'a mut Option<JacobianPoint>,
    /// Smallest J of the last residual.
    pub min_j: f64,
    /// Norms of the last residual.
    pub norms: BlockNorms,
}

impl<const D: usize> NonlinearSystem for StepSystem<'_, D> {
    fn residual(&mut self, r: &mut [f64]) -> Option<f64> {
        r.copy_from_slice(self.explicit);
        let view = StepView { rule: self.rule, new: self.new, old: self.old };
        let min_j = self.assembler.residual(&view, r);
        self.min_j = self.assembler.space.over_all(Reduce::Min, min_j);
        self.norms = self.scales.norms(&self.assembler.space, self.rule.per_k, r)?;
        (self.min_j > 0.0).then_some(self.norms.max())
    }

    fn renew(&mut self, seconds: &mut Seconds) -> Result<usize, SolverError> {
        let view = StepView { rule: self.rule, new: self.new, old: self.old };
        match self.point {
            Some(point) => {
                (point.rule, point.time) = (self.rule, self.force_time);
                point.new.copy_from(self.new);
                point.old.copy_from(self.old);
            }
            None => {
                let (new, old) = (self.new.clone(), self.old.clone());
                let (rule, time) = (self.rule, self.force_time);
                *self.point = Some(JacobianPoint { rule, time, new, old, age: Age::default() });
            }
        }
        self.linear.sizes = self.scales.sizes::<D>(self.rule.per_k);
        self.linear.renew(self.assembler, &view, self.tangent, seconds)
    }

    fn is_iterative(&self) -> bool {
        self.linear.is_iterative()
    }

    fn refresh(&mut self, seconds: &mut Seconds) -> Result<usize, SolverError> {
        let view = StepView { rule: self.rule, new: self.new, old: self.old };
        self.linear.refresh(self.assembler, &view, self.tangent, seconds)
    }

    fn correct(&mut self, r: &[f64], delta: &mut [f64]) -> Result<usize, SolverError> {
        let view = StepView { rule: self.rule, new: self.new, old: self.old };
        let settled = self.norms.extension < SETTLED * self.norms.max();
        self.linear.correct(self.assembler, &view, settled, r, delta)
    }

    fn is_exact(&self) -> bool {
        self.linear.active == Linearization::Newton && !self.linear.is_iterative()
    }

    /// Near a state of rest the reference goes to 0, and with it the residual that is asked for: what remains is the
    /// rounding of stresses, which moves v and u by that of u.
    fn is_negligible(&self, delta: &[f64]) -> bool {
        let (n_v, n_u) = (self.new.v.len(), self.new.u.len());
        let space = &self.assembler.space;
        let fields =
            [&self.new.v, &self.new.u, &space.fabrics.unloading, &delta[..n_v], &delta[n_v..n_v + n_u]];
        let mut sizes = fields.map(algebra::norm_inf);
        space.reduce(Reduce::Max, &mut sizes);
        let [v, u, unloading, delta_v, delta_u] = sizes;
        let u = u.max(unloading);
        delta_v <= NEGLIGIBLE * v.max(u * self.rule.per_k) && delta_u <= NEGLIGIBLE * u
    }

    fn rounding(&self) -> f64 {
        self.scales.rounding(&self.assembler.space, self.new, self.rule.per_k)
    }

    fn price(&self) -> f64 {
        self.linear.price()
    }

    fn update(&mut self, omega: f64, delta: &[f64]) {
        self.new.add_scaled(omega, delta);
        let constraints = &self.assembler.constraints;
        if constraints.follows {
            constraints.apply_data(&self.assembler.space, self.time, &mut self.new.v, &self.new.u);
        }
    }
}
