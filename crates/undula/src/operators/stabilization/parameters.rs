//! Parameters of the stabilisation, frozen at the old state.
#![allow(non_snake_case)]

use super::Stabilizer;
use super::tasks::Scratch;
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::operators::StepView;
use crate::physics::stabilization::{CellState, FineFields, Mapping, Parameters};

/// α and δ of a cell in each lane.
#[derive(Copy, Clone)]
pub(super) struct CellParameters<const L: usize> {
    pub(super) alpha: Lanes<L>,
    pub(super) delta: Lanes<L>,
    speed: Lanes<L>,
    /// h/ĥ = J^(1/D).
    stretch: Lanes<L>,
}

impl<const D: usize, const L: usize> Stabilizer<D, L> {
    /// Parameters of the cell `child` of a batch from the old state.
    #[inline(always)]
    pub(super) fn parameters(
        &self,
        step: &StepView<'_>,
        batch: usize,
        child: usize,
        s: &Scratch<D, L>,
    ) -> CellParameters<L> {
        let (t, mut speed) = (&self.tables, [0.0f64; L]);
        let (mut volume, mut moved) = (Lanes::<L>::zero(), Lanes::<L>::zero());
        for q in child * t.n_points..(child + 1) * t.n_points {
            let index = batch * t.points() + q;
            let (mut v, mut grad_u) = (Vector::<Lanes<L>, D>::zero(), Tensor::<Lanes<L>, D>::zero());
            let (values, grads) =
                (t.velocity.at(&t.velocity.value, q), t.velocity.at(&t.velocity.grad, index));
            for a in 0..t.velocity.n {
                for i in 0..D {
                    v.0[i].add_product(values[a], s.v[1][a].0[i]);
                    for d in (0..D).filter(|_| self.deforms) {
                        grad_u.0[i][d].add_product_lanes(grads[a].0[d], s.u[1][a].0[i]);
                    }
                }
            }
            let square = v.dot(v);
            for l in 0..L {
                speed[l] = speed[l].max(square.0[l]);
            }
            volume += t.weight[index];
            moved.add_product_lanes(t.weight[index], (Tensor::identity() + grad_u).det());
        }
        let size = t.size[batch * t.n_children + child];
        let zero = Lanes::zero();
        let mut r = CellParameters { alpha: zero, delta: zero, speed: zero, stretch: Lanes::splat(1.0) };
        for l in 0..L {
            // Padded lanes have no volume.
            let present = volume.0[l] > 0.0 && self.how.map != Mapping::None;
            let j = if present { moved.0[l] / volume.0[l] } else { 1.0 };
            let cell = CellState { size: size.0[l], j, speed: speed[l].sqrt() };
            r.alpha.0[l] = self.how.alpha::<D>(&self.fluid, &cell);
            r.delta.0[l] = self.how.delta::<D>(&self.fluid, step.rule.per_k, &cell);
            r.speed.0[l] = cell.speed;
            if self.how.map == Mapping::Size {
                r.stretch.0[l] = j.max(0.0).powf(1.0 / D as f64);
            }
        }
        r
    }

    /// Σ weight α_i ĥ_i ĥ_iᵀ at a point.
    #[inline(always)]
    fn axes(
        &self,
        jacobian: &Tensor<Lanes<L>, D>,
        F: &Tensor<Lanes<L>, D>,
        speed: Lanes<L>,
    ) -> Tensor<Lanes<L>, D> {
        let mut sum = Tensor::<Lanes<L>, D>::zero();
        for (axis, weight) in &self.axes {
            let h = *jacobian * Vector(std::array::from_fn(|d| Lanes::constant(axis[d])));
            let moved = *F * h;
            let square = moved.dot(moved);
            let mut alpha = Lanes::<L>::zero();
            for l in 0..L {
                alpha.0[l] = weight * self.how.axis_alpha(&self.fluid, speed.0[l], square.0[l].sqrt());
            }
            for i in 0..D {
                for j in 0..D {
                    sum.0[i][j] += h.0[i] * h.0[j] * alpha;
                }
            }
        }
        sum
    }

    /// Frozen parameters at a point.
    #[inline(always)]
    pub(super) fn at_point(
        &self,
        step: &StepView<'_>,
        index: usize,
        cell: &CellParameters<L>,
        old: &FineFields<Lanes<L>, D>,
    ) -> Parameters<Lanes<L>, D> {
        let mut force = Vector::zero();
        for (field, weight) in self.force.iter().zip([step.rule.theta, 1.0 - step.rule.theta]) {
            if let Some(f) = field.get(index) {
                force += weight * *f;
            }
        }
        let axes = match (self.tables.jacobian.get(index), self.how.map) {
            (Some(jacobian), Mapping::Full) => {
                self.axes(jacobian, &(Tensor::identity() + old.at.grad_u), cell.speed)
            }
            (Some(jacobian), _) => self.axes(&(*jacobian * cell.stretch), &Tensor::identity(), cell.speed),
            (None, _) => Tensor::zero(),
        };
        Parameters { alpha: cell.alpha, delta: cell.delta, axes, force }
    }
}
