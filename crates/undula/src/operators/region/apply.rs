//! The product of the derivative with a vector, without a matrix: one pass with dual numbers at each point, lane by lane,
//! since nothing but tests asks for it yet.

use super::kernel::{Direction, Kernel, Scratch};
use super::tangents::{ByLane, Point};
use crate::loops::evaluate::{gather, gather_scalar, interpolate_scalar};
use crate::loops::scatter::Shared;
use crate::loops::width::{Task, Width};
use crate::math::{Lanes, Scalar, Vector};
use crate::operators::{End, Matrix, StepView};
use crate::physics::{Fields, Tested};
use crate::tangent::StepForm;

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Add the product with `x` to `y`, both `[v, u, p]`; in the condensed matrix u moves by kθ v in the solid, and does
    /// not move in the fluid.
    pub(super) fn add_product(&mut self, matrix: Matrix, step: &StepView<'_>, x: &[f64], y: &mut [f64]) {
        let mut copies = std::mem::take(&mut self.row_copies);
        let shared = copies.share(y);
        let coupling = match matrix {
            Matrix::Whole => None,
            Matrix::Condensed => Some(self.coupling(&step.rule)),
        };
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                let out = &shared;
                Lanes::<L>::dispatch(ApplyTask { kernel: self, step, coupling, x, batch, scratch, out });
            });
        });
        copies.gather(y);
        self.row_copies = copies;
    }
}

struct ApplyTask<'a, F, const D: usize, const L: usize> {
    kernel: &'a Kernel<F, D, L>,
    step: &'a StepView<'a>,
    /// What v is multiplied by to give u; `None`: u has a direction of its own.
    coupling: Option<f64>,
    x: &'a [f64],
    batch: usize,
    scratch: &'a mut Scratch<D, L>,
    out: &'a Shared<'a>,
}

impl<F: StepForm<D>, const D: usize, const L: usize> ApplyTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    /// Gather the direction.
    #[inline(always)]
    fn load(&self, w: &mut Direction<D, L>) {
        let (k, b) = (self.kernel, &self.kernel.batches);
        let (n, m) = (b.n_basis, b.n_pressure);
        w.v.resize(n, Vector::zero());
        w.u.resize(n, Vector::zero());
        w.p.resize(m, Lanes::zero());
        let nodes = &b.nodes[self.batch * n..(self.batch + 1) * n];
        gather(nodes, self.x, &mut w.v);
        match self.coupling {
            Some(coupling) => {
                for (u, v) in w.u.iter_mut().zip(&w.v) {
                    *u = *v * Lanes::constant(coupling);
                }
            }
            None if k.deforms => gather(nodes, &self.x[k.first_deformation as usize..], &mut w.u),
            None => {}
        }
        let pressures = &b.pressure[self.batch * m..(self.batch + 1) * m];
        gather_scalar(pressures, &self.x[k.first_pressure as usize..], &mut w.p);
    }
}

impl<F: StepForm<D>, const D: usize, const L: usize> Task for ApplyTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch) = (self.kernel, self.batch);
        let (b, mut w) = (&k.batches, std::mem::take(&mut self.scratch.direction));
        self.load(&mut w);
        let s = self.scratch;
        k.load(self.step, batch, s, true);
        k.spread(4, &w.v, &mut s.tensor);
        k.spread(5, &w.u, &mut s.tensor);
        k.begin_tests(s);
        for q in 0..b.n_points {
            let (index, m) = (batch * b.n_points + q, b.n_pressure);
            let (new, old) = k.fields(batch, q, s);
            let at = (q, &b.points[index].inverse);
            let mut direction = Fields::zero();
            (direction.v, direction.grad_v) = k.spread_at(4, at, &w.v, &s.tensor);
            if k.deforms {
                (direction.u, direction.grad_u) = k.spread_at(5, at, &w.u, &s.tensor);
            }
            direction.p = interpolate_scalar(&b.pressure_basis[index * m..(index + 1) * m], &w.p);
            let place = k.place(End::New, index);
            let at = Point { form: &k.form, rule: &self.step.rule, place: &place, new: &new, old: &old };
            let mut r = Tested::zero();
            ByLane::Duals { lagged: false }.put(&at, &direction, &mut r);
            k.test(batch, q, &r, s);
        }
        k.finish_tests(batch, k.deforms && self.coupling.is_none(), s, self.out);
        s.direction = w;
    }
}
