//! The body force at the current positions x + u of the points of a region.

use super::current_force::CurrentForce;
use super::kernel::{Kernel, Scratch};
use crate::loops::width::{Task, Width};
use crate::math::{Lanes, Tensor, Vector};
use crate::operators::{End, StepView};
use crate::tangent::{Difference, StepForm, Tangent};
use std::array::from_fn;

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Take the body force of one end at the positions of that end, where it is the current one.
    pub(super) fn move_force(&mut self, step: &StepView<'_>, end: End, tangent: Tangent) {
        let Some(force) = self.body_force.current.take() else { return };
        let by = match &tangent {
            Tangent::Difference(by) => Some(by),
            _ => None,
        };
        let n = self.batches.positions.len();
        let mut values = std::mem::take(&mut self.body_force.values[end as usize]);
        let mut slopes = std::mem::take(&mut self.body_force.slopes);
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
        self.body_force.values[end as usize] = values;
        self.body_force.slopes = slopes;
        self.body_force.current = Some(force);
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

impl<F: StepForm<D>, const D: usize, const L: usize> Task for ForceTask<'_, F, D, L>
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
