//! One region of the mesh: its batches, its equations, and the loops over them.

use super::batch::Batches;
use super::contract::{Piece, Tangents, Test, Trial, pieces};
use super::evaluate::{gather, gather_scalar, interpolate, interpolate_scalar, pull_back, scatter, test};
use super::scatter::{DROP, PerThread, Shared};
use super::simd::{Task, Width};
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::physics::{Fields, Place, StepRule, Tested};
use crate::space::{Constraints, FsiSpace, PsiOwner, Region, State};
use crate::tangent::{ByHand, Tangent, automatic};
use rayon::prelude::*;
use std::marker::PhantomData;

/// One step as assembly sees it.
#[derive(Copy, Clone)]
pub struct StepView<'a> {
    /// Weights of the scheme.
    pub rule: StepRule,
    /// The iterate.
    pub new: &'a State,
    /// The solution at the old time.
    pub old: &'a State,
}

/// Body force per mass at the quadrature points of a region \[m/s²\]; empty: none.
pub type ForceField<const D: usize, const L: usize> = Vec<Vector<Lanes<L>, D>>;

/// Work space of one thread.
struct Scratch<const D: usize, const L: usize> {
    v: Vec<Vector<Lanes<L>, D>>,
    u: Vec<Vector<Lanes<L>, D>>,
    v_old: Vec<Vector<Lanes<L>, D>>,
    u_old: Vec<Vector<Lanes<L>, D>>,
    p: Vec<Lanes<L>>,
    phi: Vec<Vector<Lanes<L>, D>>,
    psi: Vec<Vector<Lanes<L>, D>>,
    xi: Vec<Lanes<L>>,
    tangent: Vec<Lanes<L>>,
    piece: Vec<Lanes<L>>,
}

/// A region with its equations `F`, `L` cells at a time.
pub struct Kernel<F, const D: usize, const L: usize> {
    form: F,
    /// Cells, geometry, colours.
    pub batches: Batches<D, L>,
    /// Body force at the new time.
    pub force: ForceField<D, L>,
    /// Body force at the old time.
    pub force_old: ForceField<D, L>,
    pieces: Vec<Piece>,
    /// Where the entries of each piece go, `[batch][piece][row basis][column basis]`.
    slots: Vec<[u32; L]>,
    slots_per_batch: usize,
    rows_phi: Vec<[u32; L]>,
    rows_psi: Vec<[u32; L]>,
    rows_xi: Vec<[u32; L]>,
    deforms: bool,
    scratch: PerThread<Scratch<D, L>>,
    /// Smallest J met by the last residual, per cell: `[batch][lane]`.
    min_j: Vec<f64>,
    threads: usize,
}

impl<F: ByHand<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Prepare the loops of `region` for `threads` threads.
    pub fn new(
        form: F,
        space: &FsiSpace<D>,
        region: Region,
        batches: Batches<D, L>,
        threads: usize,
    ) -> Kernel<F, D, L> {
        let (n, m, q) = (batches.n_basis, batches.n_pressure, batches.n_points);
        let components = Fields::<f64, D>::COMPONENTS;
        let vectors = || vec![Vector::zero(); n];
        let scalars = || vec![Lanes::zero(); m];
        let scratch = PerThread::new(threads, || Scratch {
            v: vectors(),
            u: vectors(),
            v_old: vectors(),
            u_old: vectors(),
            p: scalars(),
            phi: vectors(),
            psi: vectors(),
            xi: scalars(),
            tangent: vec![Lanes::zero(); q * components * components],
            piece: vec![Lanes::zero(); n * n.max(m)],
        });
        let (n_v, n_u) = (space.n_v() as u32, space.n_u() as u32);
        let owner = if region == Region::Solid { PsiOwner::Relation } else { PsiOwner::Extension };
        let psi_row = |node: u32| {
            if space.deforms && space.owner[node as usize] == owner { n_v + node * D as u32 } else { DROP }
        };
        let rows_phi = batches.nodes.iter().map(|l| l.map(|node| node * D as u32)).collect();
        let rows_psi = batches.nodes.iter().map(|l| l.map(psi_row)).collect();
        let rows_xi = batches.pressure.iter().map(|l| l.map(|p| n_v + n_u + p)).collect();
        let min_j = vec![f64::INFINITY; batches.len() * L];
        let pieces = pieces(&F::COUPLINGS, D, space.deforms);
        Kernel {
            form,
            batches,
            force: vec![],
            force_old: vec![],
            pieces,
            slots: vec![],
            slots_per_batch: 0,
            rows_phi,
            rows_psi,
            rows_xi,
            deforms: space.deforms,
            scratch,
            min_j,
            threads,
        }
    }

    /// Call `visit(row, column)` for every entry the element matrices write, [`DROP`]ped ones included.
    pub fn entries(&self, constraints: &Constraints<D>, mut visit: impl FnMut(usize, usize, u32, u32)) {
        let (n, m) = (self.batches.n_basis, self.batches.n_pressure);
        let column =
            |first: u32, i: usize, given: bool| if given || first == DROP { DROP } else { first + i as u32 };
        let n_v = constraints.v.len() * D;
        for batch in 0..self.batches.len() {
            for piece in &self.pieces {
                let rows = if piece.test == Test::Xi { m } else { n };
                let columns = if piece.trial == Trial::P { m } else { n };
                for a in 0..rows {
                    for b in 0..columns {
                        for l in 0..L {
                            let node = |x: usize| self.batches.nodes[batch * n + x][l] as usize;
                            let row = match piece.test {
                                Test::Phi(i) => {
                                    column(self.rows_phi[batch * n + a][l], i, constraints.v[node(a)])
                                }
                                Test::Psi(i) => {
                                    column(self.rows_psi[batch * n + a][l], i, constraints.u[node(a)])
                                }
                                Test::Xi => self.rows_xi[batch * m + a][l],
                            };
                            let col = match piece.trial {
                                Trial::V(j) => column((node(b) * D) as u32, j, constraints.v[node(b)]),
                                Trial::U(j) => column((n_v + node(b) * D) as u32, j, constraints.u[node(b)]),
                                Trial::P => self.rows_xi[batch * m + b][l],
                            };
                            let there = l < self.batches.active[batch] && row != DROP && col != DROP;
                            let (row, col) = if there { (row, col) } else { (DROP, DROP) };
                            visit(batch, l, row, col);
                        }
                    }
                }
            }
        }
    }

    /// Remember where every entry of the element matrices goes.
    pub fn set_slots(&mut self, constraints: &Constraints<D>, find: impl Fn(u32, u32) -> u32) {
        let mut slots: Vec<[u32; L]> = vec![];
        self.entries(constraints, |_, l, row, col| {
            if l == 0 {
                slots.push([DROP; L]);
            }
            if let (Some(last), true) = (slots.last_mut(), row != DROP) {
                last[l] = find(row, col);
            }
        });
        self.slots_per_batch = if self.batches.is_empty() { 0 } else { slots.len() / self.batches.len() };
        self.slots = slots;
    }

    /// Run `work` on every batch, colour by colour.
    fn for_each_batch(&self, work: impl Fn(usize) + Sync) {
        for colour in &self.batches.colours {
            if self.threads == 1 || colour.len() == 1 {
                colour.clone().for_each(&work);
            } else {
                colour.clone().into_par_iter().for_each(&work);
            }
        }
    }

    /// Add all terms of the step but the explicit part to `out`; returns the smallest J at the points.
    pub fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        let shared = Shared::new(out);
        let mut min_j = std::mem::take(&mut self.min_j);
        let slots = Shared::new(&mut min_j);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                Lanes::<L>::dispatch(ResidualTask {
                    kernel: self,
                    step,
                    batch,
                    scratch,
                    out: &shared,
                    min_j: &slots,
                });
            });
        });
        let smallest = min_j.iter().copied().fold(f64::INFINITY, f64::min);
        self.min_j = min_j;
        smallest
    }

    /// Add the explicit part to `out`.
    pub fn explicit(&self, step: &StepView<'_>, out: &mut [f64]) {
        let shared = Shared::new(out);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                Lanes::<L>::dispatch(ExplicitTask { kernel: self, step, batch, scratch, out: &shared });
            });
        });
    }

    /// Add the Jacobian to the entries `out` of the matrix.
    pub fn jacobian(&self, step: &StepView<'_>, tangent: Tangent, out: &mut [f64]) {
        let shared = Shared::new(out);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                JacobianTask { kernel: self, step, tangent, batch, scratch, out: &shared }.run();
            });
        });
    }

    /// Smallest J of the last residual with its cell, and all cells where J is not positive.
    pub fn worst(&self) -> Option<(f64, Vec<u32>)> {
        let cell = |i: usize| self.batches.cells[i / L][i % L];
        let (worst, j) = self.min_j.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let mut cells = vec![cell(worst)];
        let real = |i: &usize| i % L < self.batches.active[i / L];
        cells.extend(
            (0..self.min_j.len()).filter(real).filter(|&i| i != worst && self.min_j[i] <= 0.0).map(cell),
        );
        Some((*j, cells))
    }

    #[inline(always)]
    fn basis(&self, q: usize) -> &[f64] {
        let n = self.batches.n_basis * (1 + D);
        &self.batches.basis[q * n..(q + 1) * n]
    }

    #[inline(always)]
    fn place(&self, force: &ForceField<D, L>, point: usize) -> Place<Lanes<L>, D> {
        let force = if force.is_empty() { Vector::zero() } else { force[point] };
        Place { force, stiffness: self.batches.points[point].stiffness }
    }

    /// Gather both ends of the step.
    #[inline(always)]
    fn load(&self, step: &StepView<'_>, batch: usize, s: &mut Scratch<D, L>) {
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
    }

    /// Fields of the new and the old time at point `q` of batch `batch`.
    #[inline(always)]
    fn fields(
        &self,
        batch: usize,
        q: usize,
        s: &Scratch<D, L>,
    ) -> (Fields<Lanes<L>, D>, Fields<Lanes<L>, D>) {
        let index = batch * self.batches.n_points + q;
        let inverse = &self.batches.points[index].inverse;
        let basis = self.basis(q);
        let (v, grad_v) = interpolate(basis, &s.v, inverse);
        let (v_old, grad_v_old) = interpolate(basis, &s.v_old, inverse);
        let zero = (Vector::zero(), Tensor::zero());
        let (u, grad_u) = if self.deforms { interpolate(basis, &s.u, inverse) } else { zero };
        let (u_old, grad_u_old) = if self.deforms { interpolate(basis, &s.u_old, inverse) } else { zero };
        let m = self.batches.n_pressure;
        let p = interpolate_scalar(&self.batches.pressure_basis[index * m..(index + 1) * m], &s.p);
        let new = Fields { v, grad_v, u, grad_u, p };
        (new, Fields { v: v_old, grad_v: grad_v_old, u: u_old, grad_u: grad_u_old, p: Lanes::zero() })
    }
}

struct ResidualTask<'a, F, const D: usize, const L: usize> {
    kernel: &'a Kernel<F, D, L>,
    step: &'a StepView<'a>,
    batch: usize,
    scratch: &'a mut Scratch<D, L>,
    out: &'a Shared<'a>,
    min_j: &'a Shared<'a>,
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
        scatter(&k.rows_phi[batch * n..(batch + 1) * n], &s.phi, active, self.out);
        if k.deforms {
            scatter(&k.rows_psi[batch * n..(batch + 1) * n], &s.psi, active, self.out);
        }
        for (rows, xi) in k.rows_xi[batch * m..(batch + 1) * m].iter().zip(&s.xi) {
            for l in 0..active {
                self.out.add(rows[l], xi.0[l]);
            }
        }
        for (l, j) in min_j.into_iter().enumerate() {
            self.min_j.set(batch * L + l, j);
        }
    }
}

struct ExplicitTask<'a, F, const D: usize, const L: usize> {
    kernel: &'a Kernel<F, D, L>,
    step: &'a StepView<'a>,
    batch: usize,
    scratch: &'a mut Scratch<D, L>,
    out: &'a Shared<'a>,
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
        scatter(&k.rows_phi[batch * n..(batch + 1) * n], &s.phi, active, self.out);
        if k.deforms {
            scatter(&k.rows_psi[batch * n..(batch + 1) * n], &s.psi, active, self.out);
        }
    }
}

struct JacobianTask<'a, F, const D: usize, const L: usize> {
    kernel: &'a Kernel<F, D, L>,
    step: &'a StepView<'a>,
    tangent: Tangent,
    batch: usize,
    scratch: &'a mut Scratch<D, L>,
    out: &'a Shared<'a>,
}

impl<F: ByHand<D>, const D: usize, const L: usize> JacobianTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    /// Tangents at the points, then one block of the matrix after the other. Each is an entry of its own
    /// for the processor: one function of everything would take minutes to compile.
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        match self.tangent {
            Tangent::Automatic => {
                Lanes::<L>::dispatch(TangentTask::<F, Automatic, D, L> {
                    kernel: k,
                    step: self.step,
                    batch,
                    scratch: s,
                    how: PhantomData,
                });
            }
            Tangent::Analytic => {
                Lanes::<L>::dispatch(TangentTask::<F, Analytic, D, L> {
                    kernel: k,
                    step: self.step,
                    batch,
                    scratch: s,
                    how: PhantomData,
                });
            }
        }
        let b = &k.batches;
        let m = b.n_pressure;
        let from = batch * b.n_points * m;
        let tangents = Tangents::<D, L> {
            tangent: &s.tangent,
            basis: &b.basis,
            pressure: &b.pressure_basis[from..from + b.n_points * m],
            n_basis: b.n_basis,
            n_pressure: m,
            n_points: b.n_points,
        };
        let slots = &k.slots[batch * k.slots_per_batch..(batch + 1) * k.slots_per_batch];
        Lanes::<L>::dispatch(ContractTask {
            tangents,
            pieces: &k.pieces,
            slots,
            piece: &mut s.piece,
            out: self.out,
        });
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
        k.load(self.step, batch, s);
        for q in 0..b.n_points {
            let index = batch * b.n_points + q;
            let (new, old) = k.fields(batch, q, s);
            let (point, place) = (&b.points[index], k.place(&k.force, index));
            let columns = &mut s.tangent[q * components * components..(q + 1) * components * components];
            for (n, column) in columns.chunks_exact_mut(components).enumerate() {
                if !k.deforms && (D + D * D..2 * (D + D * D)).contains(&n) {
                    continue;
                }
                let direction = reference_direction::<D, L>(n, &point.inverse);
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
