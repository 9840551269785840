//! The (v, p) system of condensed Newton on one region.
//!
//! In the solid the velocity-deformation relation gives δu = kθ δv, so that a velocity direction moves u
//! along. In the fluid the derivatives with respect to u are left out. Without deformation nothing is
//! left out: the matrix is then the Jacobian.

use super::interior::{BackwardTask, CondenseTask, ForwardTask, Interior, Layout, Sweep};
use super::kernel::Kernel;
use super::tangents::{Directions, TangentTasks};
use crate::algebra::Sink;
use crate::loops::scatter::Shared;
use crate::loops::slots::{Numbering, Pair, scalars, vectors};
use crate::loops::test_functions::{Piece, Test, Trial};
use crate::loops::width::Width;
use crate::math::Lanes;
use crate::operators::{Blocks, StepView};
use crate::physics::form::Block;
use crate::physics::{Couplings, StepRule};
use crate::space::FsiSpace;
use crate::tangent::{Linearization, StepForm, Tangent};

/// All outer unknowns of a cell are coupled by the elimination of the inner ones.
pub(super) const CONDENSED: [Pair; 4] = [
    Pair::full(Test::Phi(0), Trial::V(0)),
    Pair::full(Test::Phi(0), Trial::P),
    Pair::full(Test::Xi, Trial::V(0)),
    Pair::full(Test::Xi, Trial::P),
];

/// Pieces of the (v, p) matrix; with `relation`, u moves with v.
pub fn condensed_pieces(c: &Couplings, dim: usize, relation: bool) -> Vec<Piece> {
    let block = if relation { Block::Full } else { c.phi_v };
    let mut list = vec![];
    for i in 0..dim {
        for j in 0..dim {
            if block != Block::Zero && !(block == Block::Mass && i != j) {
                list.push(Piece { test: Test::Phi(i), trial: Trial::V(j), block });
            }
        }
        if c.pressure != Block::Zero {
            list.push(Piece { test: Test::Phi(i), trial: Trial::P, block: c.pressure });
        }
        let divergence = if relation && c.xi_v == Block::Zero { c.pressure } else { c.xi_v };
        if divergence != Block::Zero {
            list.push(Piece { test: Test::Xi, trial: Trial::V(i), block: divergence });
        }
    }
    if c.xi_p {
        list.push(Piece { test: Test::Xi, trial: Trial::P, block: Block::Mass });
    }
    list
}

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Whether u follows v by the velocity-deformation relation.
    pub(super) fn relation(&self) -> bool {
        self.form.blocks().psi_v != Block::Zero
    }

    /// kθ where u moves with v, else 0 \[s\].
    pub(super) fn coupling(&self, rule: &StepRule) -> f64 {
        if self.relation() { rule.theta / rule.per_k } else { 0.0 }
    }

    /// Make room for the condensed system; `blocks` are the cells to which blocks are added. Unknowns inside of cells
    /// are eliminated if asked to.
    pub(super) fn prepare_interior(&mut self, space: &FsiSpace<D>, blocks: &[u32], eliminate: bool) {
        let b = &self.batches;
        let (shape, degree) = (space.mesh.shape, space.nodes.degree);
        let mut layout = Layout::new(shape, degree, b.n_basis, b.n_pressure, space.pressure.kind);
        if !eliminate {
            layout.set_outer(layout.all);
        }
        let mut interior = Interior::new(layout, b.len());
        for (batch, cells) in b.cells.iter().enumerate() {
            for (lane, cell) in cells[..b.active[batch]].iter().enumerate() {
                let with = blocks.iter().enumerate().filter(|(_, c)| *c == cell);
                interior.blocks.extend(with.map(|(n, _)| (batch as u32, lane as u32, n as u32)));
            }
        }
        self.condensed = condensed_pieces(&self.form.blocks(), D, self.relation());
        self.interior = Some(interior);
    }

    /// Places in `[v, u, p]` of the inner unknowns of all cells.
    pub(super) fn visit_inner(&self, visit: &mut dyn FnMut(u32)) {
        let Some(interior) = &self.interior else { return };
        for batch in 0..self.batches.len() {
            self.sweep(interior, batch).visit(|place, dofs| {
                if place >= interior.layout.outer {
                    dofs[..self.batches.active[batch]].iter().for_each(|&dof| visit(dof));
                }
            });
        }
    }

    /// Outer rows and columns of a batch in the numbers that `number` gives to places in `[v, u, p]`.
    pub(super) fn outer_numbering(&self, batch: usize, number: &[u32]) -> Numbering<D, L> {
        let Some(Interior { layout, .. }) = &self.interior else { return Numbering::default() };
        let (n, m, active) = (self.batches.n_basis, self.batches.n_pressure, self.batches.active[batch]);
        let outer = |places: &[usize], rows: &[[u32; L]]| -> Vec<[u32; L]> {
            rows.iter().zip(places).filter(|(_, place)| **place < layout.outer).map(|(row, _)| *row).collect()
        };
        let nodes = outer(&layout.node, &self.rows_phi[batch * n..(batch + 1) * n]);
        let pressures = outer(&layout.pressure, &self.rows_xi[batch * m..(batch + 1) * m]);
        let phi = || vectors(nodes.iter().copied(), active, number);
        let xi = || scalars(pressures.iter().copied(), active, number);
        Numbering { rows: [phi(), vec![], xi()], columns: [phi(), vec![], xi()] }
    }

    fn sweep<'a>(&'a self, interior: &'a Interior<D, L>, batch: usize) -> Sweep<'a, D, L> {
        let (kept, _) = interior.sizes();
        Sweep {
            layout: &interior.layout,
            batches: &self.batches,
            batch,
            factors: &interior.factors[batch * kept..(batch + 1) * kept],
            first_pressure: self.first_pressure,
        }
    }

    /// Where a batch adds to momentum and divergence rows.
    fn writes(&self, batch: usize) -> (&[[u32; L]], &[[u32; L]]) {
        let (n, m) = (self.batches.n_basis, self.batches.n_pressure);
        (&self.write_phi[batch * n..(batch + 1) * n], &self.write_xi[batch * m..(batch + 1) * m])
    }

    /// Add the outer matrix to the entries `out` and keep the factors of the inner blocks.
    pub(super) fn add_condensed(
        &mut self,
        step: &StepView<'_>,
        tangent: Tangent,
        blocks: &Blocks,
        out: Sink<'_>,
    ) {
        let Some(mut interior) = self.interior.take() else { return };
        let (kept, _) = interior.sizes();
        let mut factors = std::mem::take(&mut interior.factors);
        let mut slots = std::mem::take(&mut interior.slots);
        let coupling = self.coupling(&step.rule);
        slots.fill(out, |slots, out| {
            self.for_each_batch_of(&mut factors, kept, |batch, factors| {
                self.scratch.with(|s| {
                    let directions = Directions::Condensed { coupling };
                    let linearization = Linearization::Condensed;
                    TangentTasks {
                        kernel: self,
                        step,
                        linearization,
                        tangent,
                        directions,
                        batch,
                        scratch: s,
                    }
                    .run();
                    let tangents = self.tangents(batch, &s.tangent, s.nodal.asked(tangent));
                    let of_batch = |x: u32| interior.blocks.partition_point(|f| f.0 < x);
                    Lanes::<L>::dispatch(CondenseTask {
                        tangents,
                        pieces: &self.condensed,
                        layout: &interior.layout,
                        added: &interior.blocks[of_batch(batch as u32)..of_batch(batch as u32 + 1)],
                        blocks,
                        places: CONDENSED.map(|pair| slots.of(pair.test, pair.trial, batch)),
                        piece: &mut s.piece,
                        work: &mut s.tensor.matrices,
                        matrix: &mut s.matrix,
                        factors,
                        out,
                    });
                });
            });
        });
        (interior.factors, interior.slots) = (factors, slots);
        self.interior = Some(interior);
    }

    /// `b_o ← b_o − A_oi A_ii⁻¹ b_i` in `[v, u, p]`; the inner ones are kept for [`Kernel::backward`].
    pub(super) fn forward(&mut self, b: &mut [f64]) {
        let Some(mut interior) = self.interior.take() else { return };
        let mut inner = std::mem::take(&mut interior.inner);
        let (_, size) = interior.sizes();
        let mut copies = std::mem::take(&mut self.row_copies);
        let shared = copies.share(b);
        self.for_each_batch_of(&mut inner, size, |batch, inner| {
            self.scratch.with(|s| {
                let sweep = self.sweep(&interior, batch);
                Lanes::<L>::dispatch(ForwardTask {
                    sweep,
                    inner,
                    write: self.writes(batch),
                    work: &mut s.outer,
                    out: &shared,
                });
            });
        });
        copies.gather(b);
        self.row_copies = copies;
        interior.inner = inner;
        self.interior = Some(interior);
    }

    /// `x_i = A_ii⁻¹ (b_i − A_io x_o)` in `[v, u, p]`, b being that of the last [`Kernel::forward`].
    pub(super) fn backward(&self, x: &mut [f64]) {
        let Some(interior) = &self.interior else { return };
        let shared = Shared::new(x);
        let (_, size) = interior.sizes();
        self.for_each_batch(|batch| {
            self.scratch.with(|s| {
                Lanes::<L>::dispatch(BackwardTask {
                    sweep: self.sweep(interior, batch),
                    inner: &interior.inner[batch * size..(batch + 1) * size],
                    work: &mut s.outer,
                    out: &shared,
                });
            });
        });
    }
}
