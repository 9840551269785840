//! What the stabilisation does with one batch of patches.
#![allow(non_snake_case)]

use super::{Coupling, Stabilizer};
use crate::loops::evaluate::{gather, gather_scalar, scatter};
use crate::loops::scatter::Shared;
use crate::loops::slots::Slots;
use crate::loops::test_functions::{Test, Trial};
use crate::loops::width::Task;
use crate::math::{Dual, Lanes, Scalar, Tensor, Vector};
use crate::operators::StepView;
use crate::physics::stabilization::{FineFields, FineTested};

/// Work space of one thread.
pub(super) struct Scratch<const D: usize, const L: usize> {
    pub(super) v: [Vec<Vector<Lanes<L>, D>>; 2],
    pub(super) u: [Vec<Vector<Lanes<L>, D>>; 2],
    pub(super) p: Vec<Lanes<L>>,
    pub(super) phi: Vec<Vector<Lanes<L>, D>>,
    pub(super) xi: Vec<Lanes<L>>,
    /// `[column][momentum rows, divergence rows]`.
    pub(super) matrix: Vec<Lanes<L>>,
    /// Rows of the iterate itself, for differences.
    pub(super) base: Vec<Lanes<L>>,
    /// Coefficients of a direction: v, u and p.
    pub(super) direction: ([Vec<Vector<Lanes<L>, D>>; 2], Vec<Lanes<L>>),
}

impl<const D: usize, const L: usize> Scratch<D, L> {
    /// For `n` nodes and `m` pressures.
    pub(super) fn new(n: usize, m: usize, columns: usize) -> Self {
        let vectors = || vec![Vector::zero(); n];
        Scratch {
            v: [vectors(), vectors()],
            u: [vectors(), vectors()],
            p: vec![Lanes::zero(); m],
            phi: vectors(),
            xi: vec![Lanes::zero(); m],
            matrix: vec![Lanes::zero(); columns * (n * D + m)],
            base: vec![Lanes::zero(); n * D + m],
            direction: ([vectors(), vectors()], vec![Lanes::zero(); m]),
        }
    }
}

impl<const D: usize, const L: usize> Stabilizer<D, L> {
    /// Gather both ends of the step.
    #[inline(always)]
    pub(super) fn load(&self, step: &StepView<'_>, batch: usize, s: &mut Scratch<D, L>) {
        let (n, m) = (self.tables.velocity.n, self.tables.pressure.n);
        let nodes = &self.tables.velocity.dofs[batch * n..(batch + 1) * n];
        for (end, state) in [step.new, step.old].into_iter().enumerate() {
            gather(nodes, &state.v, &mut s.v[end]);
            if self.deforms {
                gather(nodes, &state.u, &mut s.u[end]);
            }
        }
        gather_scalar(&self.tables.pressure.dofs[batch * m..(batch + 1) * m], &step.new.p, &mut s.p);
    }

    /// The fields of one end (0 new, 1 old) at point `q` of a batch; the pressure of the step at either.
    #[inline(always)]
    pub(super) fn fields(
        &self,
        batch: usize,
        q: usize,
        end: usize,
        s: &Scratch<D, L>,
    ) -> FineFields<Lanes<L>, D> {
        self.fields_of((&s.v[end], &s.u[end], &s.p), batch, q)
    }

    /// The fields with coefficients of v, u and p.
    #[inline(always)]
    pub(super) fn fields_of(
        &self,
        (v, u, p): (&[Vector<Lanes<L>, D>], &[Vector<Lanes<L>, D>], &[Lanes<L>]),
        batch: usize,
        q: usize,
    ) -> FineFields<Lanes<L>, D> {
        let (t, mut f) = (&self.tables, FineFields::zero());
        let (index, velocity, pressure) = (batch * t.points() + q, &t.velocity, &t.pressure);
        for a in 0..velocity.n {
            self.add(Trial::V(0), &mut f, q, index, a, &v[a]);
            if self.deforms {
                self.add(Trial::U(0), &mut f, q, index, a, &u[a]);
            }
        }
        for a in 0..pressure.n {
            f.grad_p += pressure.at(&pressure.grad, index)[a] * p[a];
            if !pressure.fine.is_empty() {
                f.fine_p += pressure.at(&pressure.fine, index)[a] * p[a];
            }
        }
        f
    }

    /// c φ_a to v or u with their derivatives.
    #[inline(always)]
    fn add(
        &self,
        trial: Trial,
        f: &mut FineFields<Lanes<L>, D>,
        q: usize,
        index: usize,
        a: usize,
        c: &Vector<Lanes<L>, D>,
    ) {
        let basis = &self.tables.velocity;
        let phi = basis.at(&basis.value, q)[a];
        let (value, grad, hessians) = match trial {
            Trial::U(_) => (&mut f.at.u, &mut f.at.grad_u, &mut f.hess_u),
            _ => (&mut f.at.v, &mut f.at.grad_v, &mut f.hess_v),
        };
        for i in 0..D {
            value.0[i].add_product(phi, c.0[i]);
        }
        add_gradient(grad, &basis.at(&basis.grad, index)[a], c);
        if !basis.hess.is_empty() {
            let hess = basis.at(&basis.hess, index)[a];
            for i in 0..D {
                hessians[i] += hess * c.0[i];
            }
        }
        if !basis.fine.is_empty() && matches!(trial, Trial::V(_)) {
            add_gradient(&mut f.fine_v, &basis.at(&basis.fine, index)[a], c);
        }
    }
}

#[inline(always)]
fn add_gradient<const D: usize, const L: usize>(
    grad: &mut Tensor<Lanes<L>, D>,
    slope: &Vector<Lanes<L>, D>,
    c: &Vector<Lanes<L>, D>,
) {
    for i in 0..D {
        for d in 0..D {
            grad.0[i][d].add_product_lanes(slope.0[d], c.0[i]);
        }
    }
}

pub(super) struct ResidualTask<'a, const D: usize, const L: usize> {
    pub(super) of: &'a Stabilizer<D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Stabilizer<D, L> {
    /// The terms of a batch for all its test functions, from the unknowns that are loaded.
    #[inline(always)]
    pub(super) fn rows(&self, step: &StepView<'_>, batch: usize, s: &mut Scratch<D, L>) {
        let t = &self.tables;
        s.phi.fill(Vector::zero());
        s.xi.fill(Lanes::zero());
        for child in 0..t.n_children {
            let cell = self.parameters(step, batch, child, s);
            for q in child * t.n_points..(child + 1) * t.n_points {
                let index = batch * t.points() + q;
                let (new, old) = (self.fields(batch, q, 0, s), self.fields(batch, q, 1, s));
                let with = self.at_point(step, index, &cell, &old);
                let r = self.how.terms(&self.fluid, &step.rule, &with, &new, &old);
                let (phi, xi) = (r.phi * t.weight[index], r.xi * t.weight[index]);
                for (r, slope) in s.phi.iter_mut().zip(t.velocity.tested(index)) {
                    *r += phi * *slope;
                }
                for (r, slope) in s.xi.iter_mut().zip(t.pressure.tested(index)) {
                    *r += xi.dot(*slope);
                }
            }
        }
    }
}

impl<const D: usize, const L: usize> Task for ResidualTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let (of, batch, s) = (self.of, self.batch, self.scratch);
        let t = &of.tables;
        of.load(self.step, batch, s);
        of.rows(self.step, batch, s);
        let (n, m, active) = (t.velocity.n, t.pressure.n, t.active[batch]);
        scatter(&of.write_phi[batch * n..(batch + 1) * n], &s.phi, active, self.out);
        for (rows, xi) in of.write_xi[batch * m..(batch + 1) * m].iter().zip(&s.xi) {
            for l in 0..active {
                self.out.add(rows[l], xi.0[l]);
            }
        }
    }
}

pub(super) struct MatrixTask<'a, const D: usize, const L: usize> {
    pub(super) of: &'a Stabilizer<D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) couplings: &'a [Coupling],
    pub(super) slots: &'a Slots<D, L>,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Task for MatrixTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let (of, batch, s) = (self.of, self.batch, self.scratch);
        let t = &of.tables;
        let (n, m) = (t.velocity.n, t.pressure.n);
        let rows = n * D + m;
        of.load(self.step, batch, s);
        let mut matrix = std::mem::take(&mut s.matrix);
        matrix.fill(Lanes::zero());
        for child in 0..t.n_children {
            let cell = of.parameters(self.step, batch, child, s);
            for q in child * t.n_points..(child + 1) * t.n_points {
                let index = batch * t.points() + q;
                let (new, old) = (of.fields(batch, q, 0, s), of.fields(batch, q, 1, s));
                let with = of.at_point(self.step, index, &cell, &old);
                let mut columns = matrix.chunks_exact_mut(rows);
                for coupling in self.couplings {
                    let components = if coupling.trial == Trial::P { 1 } else { D };
                    for b in 0..if coupling.trial == Trial::P { m } else { n } {
                        for j in 0..components {
                            let Some(column) = columns.next() else { return };
                            let direction = of.direction(coupling.trial, q, index, b, j);
                            let seeded = new.zip(&direction, |re, eps| Dual { re, eps });
                            let r = of.how.terms(&of.fluid, &self.step.rule, &with, &seeded, &old);
                            of.contract(coupling, index, &r, column);
                        }
                    }
                }
            }
        }
        of.scatter(self.couplings, &matrix, (self.slots, batch), self.out);
        s.matrix = matrix;
    }
}

impl<const D: usize, const L: usize> Stabilizer<D, L> {
    /// The direction in which component `j` of basis function `b` of a field moves.
    #[inline(always)]
    fn direction(&self, trial: Trial, q: usize, index: usize, b: usize, j: usize) -> FineFields<Lanes<L>, D> {
        let (mut f, mut unit) = (FineFields::zero(), Vector::zero());
        let pressure = &self.tables.pressure;
        unit.0[j] = Lanes::constant(1.0);
        match trial {
            Trial::V(_) | Trial::U(_) => self.add(trial, &mut f, q, index, b, &unit),
            Trial::P => {
                f.grad_p = pressure.at(&pressure.grad, index)[b];
                if !pressure.fine.is_empty() {
                    f.fine_p = pressure.at(&pressure.fine, index)[b];
                }
            }
        }
        f
    }

    /// Test the derivatives in `r` with all functions.
    #[inline(always)]
    fn contract(
        &self,
        coupling: &Coupling,
        index: usize,
        r: &FineTested<Dual<Lanes<L>>, D>,
        column: &mut [Lanes<L>],
    ) {
        let t = &self.tables;
        let (momentum, divergence) = column.split_at_mut(t.velocity.n * D);
        if coupling.phi {
            let phi = r.phi.map(|x| x.eps) * t.weight[index];
            for (out, slope) in momentum.chunks_exact_mut(D).zip(t.velocity.tested(index)) {
                for i in 0..D {
                    for d in 0..D {
                        out[i].add_product_lanes(phi.0[i][d], slope.0[d]);
                    }
                }
            }
        }
        if coupling.xi {
            let xi = r.xi.map(|x| x.eps) * t.weight[index];
            for (out, slope) in divergence.iter_mut().zip(t.pressure.tested(index)) {
                for d in 0..D {
                    out.add_product_lanes(xi.0[d], slope.0[d]);
                }
            }
        }
    }

    /// Add the element matrices `[column][row]`.
    #[inline(always)]
    pub(super) fn scatter(
        &self,
        couplings: &[Coupling],
        matrix: &[Lanes<L>],
        (slots, batch): (&Slots<D, L>, usize),
        out: &Shared<'_>,
    ) {
        let (n, m) = (self.tables.velocity.n, self.tables.pressure.n);
        let (rows, mut first) = (n * D + m, 0);
        for &Coupling { trial, phi, xi } in couplings {
            let (columns, components) = if trial == Trial::P { (m, 1) } else { (n, D) };
            let at = |b: usize, j: usize, row: usize| &matrix[(first + b * components + j) * rows + row];
            let tests = [(phi, Test::Phi(0), n, D, 0), (xi, Test::Xi, m, 1, n * D)];
            for (_, test, functions, parts, start) in tests.into_iter().filter(|(holds, ..)| *holds) {
                let places = slots.of(test, trial, batch);
                for (a, b) in (0..functions).flat_map(|a| (0..columns).map(move |b| (a, b))) {
                    for (i, j) in (0..parts).flat_map(|i| (0..components).map(move |j| (i, j))) {
                        places.add(out, (a, b), (i, j), at(b, j, start + a * parts + i));
                    }
                }
            }
            first += columns * components;
        }
    }
}
