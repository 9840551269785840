//! What is done with one batch: residual, explicit part, contraction of its tangents ([`super::tangents`]). Each
//! is compiled for the vector width of its numbers, see [`crate::loops::width`].

use super::kernel::{Kernel, Scratch};
use super::tangents::{Directions, TangentTasks};
use crate::algebra::Sink;
use crate::loops::scatter::Shared;
use crate::loops::slots::Slots;
use crate::loops::test_functions::{Piece, Tangents, Test, Trial};
use crate::loops::width::{Task, Width};
use crate::math::Lanes;
use crate::operators::{End, StepView};
use crate::physics::Tested;
use crate::tangent::{Linearization, StepForm, Tangent};

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Add all terms of the step but the explicit part to `out`; returns the smallest J at the points.
    pub(super) fn add_residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        let mut copies = std::mem::take(&mut self.row_copies);
        let shared = copies.share(out);
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
        copies.gather(out);
        self.row_copies = copies;
        let smallest = min_j.iter().copied().fold(f64::INFINITY, f64::min);
        self.min_j = min_j;
        smallest
    }

    /// Add the explicit part to `out`.
    pub(super) fn add_explicit(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        let mut copies = std::mem::take(&mut self.row_copies);
        let shared = copies.share(out);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                Lanes::<L>::dispatch(ExplicitTask { kernel: self, step, batch, scratch, out: &shared });
            });
        });
        copies.gather(out);
        self.row_copies = copies;
    }

    /// Add the Jacobian to the entries `out` of the matrix.
    pub(super) fn add_jacobian(
        &mut self,
        step: &StepView<'_>,
        linearization: Linearization,
        tangent: Tangent,
        out: Sink<'_>,
    ) {
        let mut slots = std::mem::take(&mut self.slots);
        slots.fill(out, |slots, out| {
            self.for_each_batch(|batch| {
                self.scratch.with(|scratch| {
                    JacobianTask { kernel: self, step, linearization, tangent, batch, scratch, slots, out }
                        .run();
                });
            });
        });
        self.slots = slots;
    }
}

pub(super) struct ResidualTask<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) out: &'a Shared<'a>,
    pub(super) min_j: &'a Shared<'a>,
}

impl<F: StepForm<D>, const D: usize, const L: usize> Task for ResidualTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        let b = &k.batches;
        k.load(self.step, batch, s, true);
        let mut min_j = [f64::INFINITY; L];
        k.begin_tests(s);
        for q in 0..b.n_points {
            let (new, old) = k.fields(batch, q, s);
            let place = k.place(End::New, batch * b.n_points + q);
            let mut r = Tested::zero();
            k.form.residual(&self.step.rule, &place, &new, &new, &old, &mut r);
            let j = k.form.volume_ratio(&place, &new);
            for l in 0..L {
                min_j[l] = min_j[l].min(j.0[l]);
            }
            k.test(batch, q, &r, s);
        }
        k.finish_tests(batch, k.deforms, s, self.out);
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

impl<F: StepForm<D>, const D: usize, const L: usize> Task for ExplicitTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        let b = &k.batches;
        k.load(self.step, batch, s, false);
        k.begin_tests(s);
        for q in 0..b.n_points {
            let (_, old) = k.fields(batch, q, s);
            let place = k.place(End::Old, batch * b.n_points + q);
            let mut r = Tested::zero();
            k.form.explicit(&self.step.rule, &place, &old, &mut r);
            k.test(batch, q, &r, s);
        }
        k.finish_tests(batch, k.deforms, s, self.out);
    }
}

pub(super) struct JacobianTask<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) linearization: Linearization,
    pub(super) tangent: Tangent,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
    pub(super) slots: &'a Slots<D, L>,
    pub(super) out: &'a Shared<'a>,
}

impl<F: StepForm<D>, const D: usize, const L: usize> JacobianTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    /// Tangents at the points, then one block of the matrix after the other. Each is an entry of its own
    /// for the processor: one function of everything would take minutes to compile.
    pub(super) fn run(self) {
        let JacobianTask { kernel: k, step, linearization, tangent, batch, scratch: s, slots, out } = self;
        let reduced = linearization == Linearization::Reduced && !k.relation();
        let directions = if reduced && k.deforms { Directions::Flow } else { Directions::All };
        TangentTasks { kernel: k, step, linearization, tangent, directions, batch, scratch: s }.run();
        let tangents = k.tangents(batch, &s.tangent, s.nodal.asked(tangent));
        let (pieces, piece, work) = (&k.pieces, &mut s.piece, &mut s.tensor.matrices);
        Lanes::<L>::dispatch(ContractTask { tangents, pieces, reduced, batch, slots, piece, work, out });
    }
}

/// BᵀDB block by block, added to the matrix.
struct ContractTask<'a, const D: usize, const L: usize> {
    tangents: Tangents<'a, D, L>,
    pieces: &'a [Piece],
    /// Without derivatives of momentum and divergence with respect to u.
    reduced: bool,
    batch: usize,
    slots: &'a Slots<D, L>,
    piece: &'a mut [Lanes<L>],
    /// For sums over one coordinate after the other.
    work: &'a mut [Lanes<L>],
    out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Task for ContractTask<'_, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (n, m) = (self.tangents.n_basis, self.tangents.n_pressure);
        for piece in self.pieces {
            if self.reduced && matches!((piece.test, piece.trial), (Test::Phi(_) | Test::Xi, Trial::U(_))) {
                continue;
            }
            let (rows, columns) =
                (if piece.test == Test::Xi { m } else { n }, if piece.trial == Trial::P { m } else { n });
            let block = &mut self.piece[..rows * columns];
            self.tangents.contract(piece, block, self.work);
            let places = self.slots.of(piece.test, piece.trial, self.batch);
            let components = (piece.test.split().1, piece.trial.split().1);
            for (a, line) in block.chunks_exact(columns).enumerate() {
                for (b, value) in line.iter().enumerate() {
                    places.add(self.out, (a, b), components, value);
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
    pub(super) work: &'a mut [Lanes<L>],
}

impl<const D: usize, const L: usize> Task for PieceTask<'_, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        self.tangents.contract(self.piece, self.block, self.work);
    }
}
