//! The body force at the points of a region: given there, or taken at the current position x + u, so that it moves with
//! the iterate.

use super::kernel::{Kernel, Scratch};
use crate::loops::width::{Task, Width};
use crate::math::{Lanes, Tensor, Vector};
use crate::operators::{DataTime, End, ForceAt, StepView};
use crate::tangent::{ByHand, Difference, Tangent};
use std::array::from_fn;

/// Body force per mass \[m/s²\] and its gradient `[i][j]` = ∂f_i/∂x_j \[1/s²\] at a position \[m\] and a time
/// \[s\].
pub type ForceWithSlope<const D: usize> =
    Box<dyn Fn(&[f64; D], f64) -> ([f64; D], [[f64; D]; D]) + Send + Sync>;

/// f(x + u, t) of the fluid: the right-hand side is (ρ J f, φ), and (J ρ ∇f w, φ) belongs to its derivative.
pub struct CurrentForce<const D: usize> {
    field: ForceWithSlope<D>,
    /// Times of the old and the new end \[s\].
    times: [f64; 2],
    /// A part of the load.
    factor: f64,
}

impl<const D: usize> CurrentForce<D> {
    /// At time 0, in full.
    pub fn new(field: ForceWithSlope<D>) -> CurrentForce<D> {
        CurrentForce { field, times: [0.0; 2], factor: 1.0 }
    }

    /// The time of one end, and the part of the load that acts.
    pub(super) fn set(&mut self, at: &DataTime) {
        self.times[at.end as usize] = at.time;
        self.factor = at.load;
    }

    /// Value and gradient; the latter by differences where `by` says so.
    pub(super) fn at(&self, end: End, x: &[f64; D], by: Option<&Difference>) -> ([f64; D], [[f64; D]; D]) {
        let at = |x: &[f64; D]| (self.field)(x, self.times[end as usize]);
        let (value, mut slope) = at(x);
        if let Some(by) = by {
            slope = difference(|x| at(x).0, x, value, by);
        }
        (value.map(|f| self.factor * f), slope.map(|row| row.map(|f| self.factor * f)))
    }
}

/// ∇f by the differences that the rest of the Jacobian is made of.
fn difference<const D: usize>(
    f: impl Fn(&[f64; D]) -> [f64; D],
    x: &[f64; D],
    value: [f64; D],
    by: &Difference,
) -> [[f64; D]; D] {
    let h = by.epsilon * by.sizes.u;
    let columns: [[f64; D]; D] = from_fn(|j| {
        let moved = |h: f64| f(&from_fn(|d| if d == j { x[d] + h } else { x[d] }));
        let (from, to) = (if by.is_central() { moved(-h) } else { value }, moved(h));
        from_fn(|i| (to[i] - from[i]) / if by.is_central() { 2.0 * h } else { h })
    });
    from_fn(|i| from_fn(|j| columns[j][i]))
}

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
