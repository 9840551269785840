//! The body force at the points of a region: given there, or taken at the current position x + u, so that it moves with
//! the iterate.

use super::current_force::CurrentForce;
use super::kernel::{Kernel, Scratch};
use crate::loops::width::{Task, Width};
use crate::math::{Lanes, Tensor, Vector};
use crate::operators::{End, ForceAt, StepView};
use crate::tangent::{ByHand, Difference, Tangent};
use std::array::from_fn;

impl<F: ByHand<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Take the body force of one end at the points; `None`: no force.
    pub(super) fn fill_force(&mut self, end: End, force: Option<ForceAt<'_, D>>) {
        let field = match end {
            End::Old => &mut self.force_old,
            End::New => &mut self.force,
        };
        field.clear();
        let Some(force) = force else { return };
        for position in &self.batches.positions {
            let mut values = Vector::<Lanes<L>, D>::zero();
            for l in 0..L {
                let f = force(&from_fn(|d| position.0[d].0[l]));
                for d in 0..D {
                    values.0[d].0[l] = f[d];
                }
            }
            field.push(values);
        }
    }

    /// Take the body force of one end at the positions of that end, where it is the current one.
    pub(super) fn move_force(&mut self, step: &StepView<'_>, end: End, tangent: Tangent) {
        let Some(force) = self.current_force.take() else { return };
        let by = match &tangent {
            Tangent::Difference(by) => Some(by),
            _ => None,
        };
        let n = self.batches.positions.len();
        let mut values = std::mem::take(if end == End::Old { &mut self.force_old } else { &mut self.force });
        let mut slopes = std::mem::take(&mut self.force_slope);
        values.resize(n, Vector::zero());
        slopes.resize(n, Tensor::zero());
        let points = self.batches.n_points;
        let all = values.chunks_exact_mut(points).zip(slopes.chunks_exact_mut(points));
        for (batch, (values, slopes)) in all.enumerate() {
            self.scratch.with(|scratch| {
                let kernel = &*self;
                let force = &force;
                let task = ForceTask { kernel, step, batch, scratch, force, end, by, values, slopes };
                Lanes::<L>::dispatch(task);
            });
        }
        *(if end == End::Old { &mut self.force_old } else { &mut self.force }) = values;
        self.force_slope = slopes;
        self.current_force = Some(force);
    }
}

/// The force at the points of a batch.
struct ForceTask<'a, F, const D: usize, const L: usize> {
    kernel: &'a Kernel<F, D, L>,
    step: &'a StepView<'a>,
    batch: usize,
    scratch: &'a mut Scratch<D, L>,
    force: &'a CurrentForce<D>,
    end: End,
    by: Option<&'a Difference>,
    values: &'a mut [Vector<Lanes<L>, D>],
    slopes: &'a mut [Tensor<Lanes<L>, D>],
}

impl<F: ByHand<D>, const D: usize, const L: usize> Task for ForceTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let Self { kernel, step, batch, scratch, force, end, by, values, slopes } = self;
        kernel.load(step, batch, scratch, true);
        for (q, (value, all)) in values.iter_mut().zip(slopes).enumerate() {
            let (new, old) = kernel.fields(batch, q, scratch);
            let u = if end == End::Old { old.u } else { new.u };
            let x = kernel.batches.positions[batch * kernel.batches.n_points + q] + u;
            for l in 0..L {
                let (f, slope) = force.at(end, &from_fn(|d| x.0[d].0[l]), by);
                for i in 0..D {
                    value.0[i].0[l] = f[i];
                    for (to, from) in all.0[i].iter_mut().zip(slope[i]) {
                        to.0[l] = from;
                    }
                }
            }
        }
    }
}
