//! Fields at the points of a batch and testing there: by whole tables or, in [`crate::loops::tensor`], by sums over one
//! coordinate after the other.

use super::kernel::{Kernel, Scratch};
use crate::loops::evaluate::{
    AtPoint, gather, gather_scalar, interpolate, interpolate_scalar, pull_back, scatter, test,
};
use crate::loops::scatter::Shared;
use crate::loops::tensor::TensorScratch;
use crate::loops::tensor::vectors::{InterpolateTask, TestTask};
use crate::loops::width::Width;
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::operators::{End, StepView};
use crate::physics::{Fabric, Fields, Place, Tested};
use crate::tangent::StepForm;

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    pub(super) fn basis(&self, q: usize) -> &[f64] {
        let n = self.batches.n_basis * (1 + D);
        &self.batches.basis[q * n..(q + 1) * n]
    }

    #[inline(always)]
    pub(super) fn place(&self, end: End, point: usize) -> Place<Lanes<L>, D> {
        let (force, force_slope) = self.body_force.at(end, point);
        let fabric = self.fabric.get(point).copied().unwrap_or_else(Fabric::plain);
        let mut per_radius = Lanes::zero();
        if F::HAS_AXIS {
            // Number by number: not all callers are compiled for vectors.
            let radius = &self.batches.positions[point].0[0];
            for l in 0..L {
                per_radius.0[l] = 1.0 / radius.0[l];
            }
        }
        let stiffness = self.batches.points[point].stiffness;
        Place { force, force_slope, stiffness, fabric, per_radius }
    }

    /// Gather both ends of the step; with `new`, its fields are about to be read, else those of the old time alone.
    #[inline(always)]
    pub(super) fn load(&self, step: &StepView<'_>, batch: usize, s: &mut Scratch<D, L>, new: bool) {
        let (n, m) = (self.batches.n_basis, self.batches.n_pressure);
        let nodes = &self.batches.nodes[batch * n..(batch + 1) * n];
        gather(nodes, &step.new.v, &mut s.v);
        gather(nodes, &step.old.v, &mut s.v_old);
        if self.deforms {
            gather(nodes, &step.new.u, &mut s.u);
            gather(nodes, &step.old.u, &mut s.u_old);
        }
        if m > 0 {
            gather_scalar(&self.batches.pressure[batch * m..(batch + 1) * m], &step.new.p, &mut s.p);
        }
        for (n, c) in [&s.v, &s.u, &s.v_old, &s.u_old].into_iter().enumerate() {
            if new || n >= 2 {
                self.spread(n, c, &mut s.tensor);
            }
        }
    }

    /// The field `n` of a batch with the coefficients `c` at all points, where that is done by sums over one coordinate
    /// after the other. Even numbers are velocities.
    #[inline(always)]
    pub(super) fn spread(&self, n: usize, c: &[Vector<Lanes<L>, D>], t: &mut TensorScratch<D, L>) {
        if let Some(basis) = self.batches.tensor.as_ref().filter(|_| self.deforms || n.is_multiple_of(2)) {
            let (at, work) = (&mut t.at[n][..], &mut t.vectors[..]);
            Lanes::<L>::dispatch(InterpolateTask { line: &basis.line, c, at, work });
        }
    }

    /// The field `n` at point `q`, by [`Kernel::spread`] or from its coefficients `c`.
    #[inline(always)]
    pub(super) fn spread_at(
        &self,
        n: usize,
        (q, inverse): (usize, &Tensor<Lanes<L>, D>),
        c: &[Vector<Lanes<L>, D>],
        t: &TensorScratch<D, L>,
    ) -> (Vector<Lanes<L>, D>, Tensor<Lanes<L>, D>) {
        match self.batches.tensor {
            Some(_) => t.at[n][q].mapped(inverse),
            None => interpolate(self.basis(q), c, inverse),
        }
    }

    /// Fields of the new and the old time at point `q` of batch `batch`.
    #[inline(always)]
    pub(super) fn fields(
        &self,
        batch: usize,
        q: usize,
        s: &Scratch<D, L>,
    ) -> (Fields<Lanes<L>, D>, Fields<Lanes<L>, D>) {
        let index = batch * self.batches.n_points + q;
        let inverse = &self.batches.points[index].inverse;
        let zero = (Vector::zero(), Tensor::zero());
        let ((v, grad_v), (u, grad_u), (v_old, grad_v_old), (u_old, grad_u_old));
        if self.batches.tensor.is_some() {
            let at = &s.tensor.at;
            (v, grad_v) = at[0][q].mapped(inverse);
            (u, grad_u) = if self.deforms { at[1][q].mapped(inverse) } else { zero };
            (v_old, grad_v_old) = at[2][q].mapped(inverse);
            (u_old, grad_u_old) = if self.deforms { at[3][q].mapped(inverse) } else { zero };
        } else {
            let basis = self.basis(q);
            (v, grad_v) = interpolate(basis, &s.v, inverse);
            (v_old, grad_v_old) = interpolate(basis, &s.v_old, inverse);
            (u, grad_u) = if self.deforms { interpolate(basis, &s.u, inverse) } else { zero };
            (u_old, grad_u_old) = if self.deforms { interpolate(basis, &s.u_old, inverse) } else { zero };
        }
        let m = self.batches.n_pressure;
        let p = interpolate_scalar(&self.batches.pressure_basis[index * m..(index + 1) * m], &s.p);
        let new = Fields { v, grad_v, u, grad_u, p };
        (new, Fields { v: v_old, grad_v: grad_v_old, u: u_old, grad_u: grad_u_old, p: Lanes::zero() })
    }

    /// Begin the element vectors of a batch.
    #[inline(always)]
    pub(super) fn begin_tests(&self, s: &mut Scratch<D, L>) {
        s.phi.fill(Vector::zero());
        s.psi.fill(Vector::zero());
        s.xi.fill(Lanes::zero());
    }

    /// Test at point `q` of a batch with what stands before the test functions there.
    #[inline(always)]
    pub(super) fn test(&self, batch: usize, q: usize, r: &Tested<Lanes<L>, D>, s: &mut Scratch<D, L>) {
        let (index, m) = (batch * self.batches.n_points + q, self.batches.n_pressure);
        let r = pull_back(r, &self.batches.points[index]);
        let basis = &self.batches.pressure_basis[index * m..(index + 1) * m];
        for (xi, basis) in s.xi.iter_mut().zip(basis) {
            xi.add_product_lanes(*basis, r.xi);
        }
        if self.batches.tensor.is_some() {
            s.tensor.at[0][q] = AtPoint { value: r.phi, grad: r.grad_phi };
            if self.deforms {
                s.tensor.at[1][q] = AtPoint { value: r.psi, grad: r.grad_psi };
            }
        } else {
            test(self.basis(q), &r.phi, &r.grad_phi, &mut s.phi);
            if self.deforms {
                test(self.basis(q), &r.psi, &r.grad_psi, &mut s.psi);
            }
        }
    }

    /// Add the element vectors to the global one after [`Kernel::test`] at all points, those of ψ if asked to.
    #[inline(always)]
    pub(super) fn finish_tests(&self, batch: usize, with_psi: bool, s: &mut Scratch<D, L>, out: &Shared<'_>) {
        if let Some(basis) = &self.batches.tensor {
            let t = &mut s.tensor;
            for (n, r) in [&mut s.phi, &mut s.psi].into_iter().enumerate() {
                if n == 0 || self.deforms {
                    let (at, work) = (&t.at[n][..], &mut t.vectors[..]);
                    Lanes::<L>::dispatch(TestTask { line: &basis.line, at, r, work });
                }
            }
        }
        let (n, m) = (self.batches.n_basis, self.batches.n_pressure);
        let active = self.batches.active[batch];
        scatter(&self.write_phi[batch * n..(batch + 1) * n], &s.phi, active, out);
        if with_psi {
            scatter(&self.write_psi[batch * n..(batch + 1) * n], &s.psi, active, out);
        }
        for (rows, xi) in self.write_xi[batch * m..(batch + 1) * m].iter().zip(&s.xi) {
            for l in 0..active {
                out.add(rows[l], xi.0[l]);
            }
        }
    }
}
