//! What is done with one batch: residual, explicit part, tangents, contraction. Each is compiled for the
//! vector width of its numbers, see [`super::simd`].

use super::contract::{Piece, Tangents, Test, Trial};
use super::evaluate::{pull_back, scatter, test};
use super::kernel::{Kernel, Scratch, StepView};
use super::scatter::Shared;
use super::simd::{Task, Width};
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::physics::{Fields, Place, StepRule, Tested};
use crate::tangent::{ByHand, Tangent, automatic};
use std::marker::PhantomData;

pub(super) struct ResidualTask<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) out: &'a Shared<'a>,
    pub(super) min_j: &'a Shared<'a>,
}

impl<F: ByHand<D>, const D: usize, const L: usize> Task for ResidualTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        let b = &k.batches;
        k.load(self.step, batch, s);
        s.phi.fill(Vector::zero());
        s.psi.fill(Vector::zero());
        s.xi.fill(Lanes::zero());
        let mut min_j = [f64::INFINITY; L];
        for q in 0..b.n_points {
            let index = batch * b.n_points + q;
            let (new, old) = k.fields(batch, q, s);
            let mut r = Tested::zero();
            self.step.rule.residual(&k.form, &k.place(&k.force, index), &new, &new, &old, &mut r);
            let j = (Tensor::identity() + new.grad_u).det();
            for l in 0..L {
                min_j[l] = min_j[l].min(j.0[l]);
            }
            let r = pull_back(&r, &b.points[index]);
            test(k.basis(q), &r.phi, &r.grad_phi, &mut s.phi);
            if k.deforms {
                test(k.basis(q), &r.psi, &r.grad_psi, &mut s.psi);
            }
            let m = b.n_pressure;
            for (xi, basis) in s.xi.iter_mut().zip(&b.pressure_basis[index * m..(index + 1) * m]) {
                xi.add_product_lanes(*basis, r.xi);
            }
        }
        let (n, m, active) = (b.n_basis, b.n_pressure, b.active[batch]);
        scatter(&k.write_phi[batch * n..(batch + 1) * n], &s.phi, active, self.out);
        if k.deforms {
            scatter(&k.write_psi[batch * n..(batch + 1) * n], &s.psi, active, self.out);
        }
        for (rows, xi) in k.write_xi[batch * m..(batch + 1) * m].iter().zip(&s.xi) {
            for l in 0..active {
                self.out.add(rows[l], xi.0[l]);
            }
        }
        for (l, j) in min_j.into_iter().enumerate() {
            self.min_j.set(batch * L + l, j);
        }
    }
}

pub(super) struct ExplicitTask<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) out: &'a Shared<'a>,
}

impl<F: ByHand<D>, const D: usize, const L: usize> Task for ExplicitTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        let b = &k.batches;
        k.load(self.step, batch, s);
        s.phi.fill(Vector::zero());
        s.psi.fill(Vector::zero());
        for q in 0..b.n_points {
            let index = batch * b.n_points + q;
            let (_, old) = k.fields(batch, q, s);
            let mut r = Tested::zero();
            self.step.rule.explicit(&k.form, &k.place(&k.force_old, index), &old, &mut r);
            let r = pull_back(&r, &b.points[index]);
            test(k.basis(q), &r.phi, &r.grad_phi, &mut s.phi);
            if k.deforms {
                test(k.basis(q), &r.psi, &r.grad_psi, &mut s.psi);
            }
        }
        let (n, active) = (b.n_basis, b.active[batch]);
        scatter(&k.write_phi[batch * n..(batch + 1) * n], &s.phi, active, self.out);
        if k.deforms {
            scatter(&k.write_psi[batch * n..(batch + 1) * n], &s.psi, active, self.out);
        }
    }
}

/// In which directions tangents are computed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Directions {
    /// v, u and p.
    All,
    /// v and p; u moves by `coupling` times v.
    Condensed {
        /// kθ in the solid, else 0 \[s\].
        coupling: f64,
    },
}

/// The tangents at all points of a batch, each way of computing them compiled on its own.
pub(super) struct TangentTasks<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) tangent: Tangent,
    pub(super) directions: Directions,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
}

impl<F: ByHand<D>, const D: usize, const L: usize> TangentTasks<'_, F, D, L>
where
    Lanes<L>: Width,
{
    pub(super) fn run(self) {
        let TangentTasks { kernel, step, tangent, directions, batch, scratch } = self;
        match tangent {
            Tangent::Automatic => {
                let how = PhantomData::<Automatic>;
                Lanes::<L>::dispatch(TangentTask { kernel, step, directions, batch, scratch, how });
            }
            Tangent::Analytic => {
                let how = PhantomData::<Analytic>;
                Lanes::<L>::dispatch(TangentTask { kernel, step, directions, batch, scratch, how });
            }
        }
    }
}

pub(super) struct JacobianTask<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) tangent: Tangent,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) out: &'a Shared<'a>,
}

impl<F: ByHand<D>, const D: usize, const L: usize> JacobianTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    /// Tangents at the points, then one block of the matrix after the other. Each is an entry of its own
    /// for the processor: one function of everything would take minutes to compile.
    pub(super) fn run(self) {
        let JacobianTask { kernel: k, step, tangent, batch, scratch: s, out } = self;
        TangentTasks { kernel: k, step, tangent, directions: Directions::All, batch, scratch: s }.run();
        let slots = &k.slots[batch * k.slots_per_batch..(batch + 1) * k.slots_per_batch];
        let tangents = k.tangents(batch, &s.tangent);
        Lanes::<L>::dispatch(ContractTask { tangents, pieces: &k.pieces, slots, piece: &mut s.piece, out });
    }
}

/// How a tangent is computed, as a type: each way is compiled on its own.
trait How<F, const D: usize> {
    fn tangent<S: Scalar<Value = S>>(
        form: &F,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        direction: &Fields<S, D>,
    ) -> Tested<S, D>;
}

struct Automatic;
struct Analytic;

impl<F: ByHand<D>, const D: usize> How<F, D> for Automatic {
    #[inline(always)]
    fn tangent<S: Scalar<Value = S>>(
        form: &F,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        direction: &Fields<S, D>,
    ) -> Tested<S, D> {
        automatic(form, rule, place, new, old, direction)
    }
}

impl<F: ByHand<D>, const D: usize> How<F, D> for Analytic {
    #[inline(always)]
    fn tangent<S: Scalar<Value = S>>(
        form: &F,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        direction: &Fields<S, D>,
    ) -> Tested<S, D> {
        form.by_hand(rule, place, new, old, direction)
    }
}

/// The tangent at all points of a batch.
struct TangentTask<'a, F, H, const D: usize, const L: usize> {
    kernel: &'a Kernel<F, D, L>,
    step: &'a StepView<'a>,
    directions: Directions,
    batch: usize,
    scratch: &'a mut Scratch<D, L>,
    how: PhantomData<H>,
}

impl<F: ByHand<D>, H: How<F, D>, const D: usize, const L: usize> Task for TangentTask<'_, F, H, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        let b = &k.batches;
        let components = Fields::<f64, D>::COMPONENTS;
        let (with_u, coupling) = match self.directions {
            Directions::All => (k.deforms, 0.0),
            Directions::Condensed { coupling } => (false, coupling),
        };
        k.load(self.step, batch, s);
        for q in 0..b.n_points {
            let index = batch * b.n_points + q;
            let (new, old) = k.fields(batch, q, s);
            let (point, place) = (&b.points[index], k.place(&k.force, index));
            let columns = &mut s.tangent[q * components * components..(q + 1) * components * components];
            for (n, column) in columns.chunks_exact_mut(components).enumerate() {
                if !with_u && (D + D * D..2 * (D + D * D)).contains(&n) {
                    continue;
                }
                let mut direction = reference_direction::<D, L>(n, &point.inverse);
                if coupling != 0.0 {
                    direction.u = direction.v * Lanes::constant(coupling);
                    direction.grad_u = direction.grad_v * Lanes::constant(coupling);
                }
                let t = H::tangent(&k.form, &self.step.rule, &place, &new, &old, &direction);
                store(&pull_back(&t, point), column);
            }
        }
    }
}

/// BᵀDB block by block, added to the matrix.
struct ContractTask<'a, const D: usize, const L: usize> {
    tangents: Tangents<'a, D, L>,
    pieces: &'a [Piece],
    slots: &'a [[u32; L]],
    piece: &'a mut [Lanes<L>],
    out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Task for ContractTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let (n, m) = (self.tangents.n_basis, self.tangents.n_pressure);
        let mut slots = self.slots;
        for piece in self.pieces {
            let rows = if piece.test == Test::Xi { m } else { n };
            let size = rows * if piece.trial == Trial::P { m } else { n };
            let block = &mut self.piece[..size];
            self.tangents.contract(piece, block);
            let (here, rest) = slots.split_at(size);
            slots = rest;
            for (slot, value) in here.iter().zip(block.iter()) {
                for l in 0..L {
                    self.out.add(slot[l], value.0[l]);
                }
            }
        }
    }
}

/// One block of the element matrices.
pub(super) struct PieceTask<'a, const D: usize, const L: usize> {
    pub(super) tangents: Tangents<'a, D, L>,
    pub(super) piece: &'a Piece,
    pub(super) block: &'a mut [Lanes<L>],
}

impl<const D: usize, const L: usize> Task for PieceTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        self.tangents.contract(self.piece, self.block);
    }
}

/// The direction in which only component `n` of the fields moves, gradients taken with respect to ξ:
/// ∂v_i/∂x_j = (∂v_i/∂ξ_d) (∂ξ_d/∂x_j).
#[inline(always)]
fn reference_direction<const D: usize, const L: usize>(
    n: usize,
    inverse: &Tensor<Lanes<L>, D>,
) -> Fields<Lanes<L>, D> {
    let mut w = Fields::zero();
    let (d, half) = (D, D + D * D);
    if n == 2 * half {
        w.p = Lanes::constant(1.0);
    } else {
        let (field, m) = (n / half, n % half);
        let (value, grad) = if field == 0 { (&mut w.v, &mut w.grad_v) } else { (&mut w.u, &mut w.grad_u) };
        if m < d {
            value.0[m] = Lanes::constant(1.0);
        } else {
            grad.0[(m - d) / d] = inverse.0[(m - d) % d];
        }
    }
    w
}

/// Write the components of `t` in the order of `Tested`.
#[inline(always)]
fn store<const D: usize, const L: usize>(t: &Tested<Lanes<L>, D>, out: &mut [Lanes<L>]) {
    let half = D + D * D;
    for i in 0..D {
        out[i] = t.phi.0[i];
        out[half + i] = t.psi.0[i];
        for d in 0..D {
            out[D + i * D + d] = t.grad_phi.0[i][d];
            out[half + D + i * D + d] = t.grad_psi.0[i][d];
        }
    }
    out[2 * half] = t.xi;
}
