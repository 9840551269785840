//! The product of the derivative of the stabilisation with a vector, without a matrix.

use super::Stabilizer;
use super::tasks::Scratch;
use crate::loops::evaluate::{gather, gather_scalar, scatter};
use crate::loops::scatter::Shared;
use crate::loops::width::Task;
use crate::math::{Dual, Lanes, Scalar, Vector};
use crate::operators::StepView;

/// One pass with dual numbers in the direction `x`; without `with_u` u does not move.
pub(super) struct ApplyTask<'a, const D: usize, const L: usize> {
    pub(super) of: &'a Stabilizer<D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) with_u: bool,
    pub(super) x: &'a [f64],
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Task for ApplyTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let (of, batch, step, s) = (self.of, self.batch, self.step, self.scratch);
        let t = &of.tables;
        let (n, m, active) = (t.velocity.n, t.pressure.n, t.active[batch]);
        let (nodes, pressures) =
            (&t.velocity.dofs[batch * n..(batch + 1) * n], &t.pressure.dofs[batch * m..(batch + 1) * m]);
        of.load(step, batch, s);
        gather(nodes, self.x, &mut s.direction.0[0]);
        if self.with_u {
            gather(nodes, &self.x[of.n_v as usize..], &mut s.direction.0[1]);
        } else {
            s.direction.0[1].fill(Vector::zero());
        }
        gather_scalar(pressures, &self.x[of.first_pressure as usize..], &mut s.direction.1);
        s.phi.fill(Vector::zero());
        s.xi.fill(Lanes::zero());
        for child in 0..t.n_children {
            let cell = of.parameters(step, batch, child, s);
            for q in child * t.n_points..(child + 1) * t.n_points {
                let index = batch * t.points() + q;
                let (new, old) = (of.fields(batch, q, 0, s), of.fields(batch, q, 1, s));
                let with = of.at_point(step, index, &cell, &old);
                let ([v, u], p) = &s.direction;
                let direction = of.fields_of((v, u, p), batch, q);
                let seeded = new.zip(&direction, |re, eps| Dual { re, eps });
                let r = of.how.terms(&of.fluid, &step.rule, &with, &seeded, &old);
                let (phi, xi) =
                    (r.phi.map(|x| x.eps) * t.weight[index], r.xi.map(|x| x.eps) * t.weight[index]);
                for (r, slope) in s.phi.iter_mut().zip(t.velocity.tested(index)) {
                    *r += phi * *slope;
                }
                for (r, slope) in s.xi.iter_mut().zip(t.pressure.tested(index)) {
                    *r += xi.dot(*slope);
                }
            }
        }
        scatter(&of.write_phi[batch * n..(batch + 1) * n], &s.phi, active, self.out);
        for (rows, xi) in of.write_xi[batch * m..(batch + 1) * m].iter().zip(&s.xi) {
            for l in 0..active {
                self.out.add(rows[l], xi.0[l]);
            }
        }
    }
}
