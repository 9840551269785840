//! Element matrices of (v, p), and elimination of the unknowns that belong to one cell alone.
//!
//! With the unknowns of a cell split into inner ones (velocities of nodes inside, pressures that are not
//! constant: nothing outside of the cell couples to them) and outer ones,
//! ```text
//!     [ A_oo A_oi ] [x_o]   [b_o]        (A_oo − A_oi A_ii⁻¹ A_io) x_o = b_o − A_oi A_ii⁻¹ b_i,
//!     [ A_io A_ii ] [x_i] = [b_i]                                 x_i = A_ii⁻¹ (b_i − A_io x_o),
//! ```
//! so that the global matrix has 7 instead of 11 unknowns per Q2–P1dc cell in two dimensions, and 11 instead of 24
//! per Q3–P2dc cell. A discontinuous pressure q that does no work on any velocity inside is constant: with the
//! bubble b of the cell and the velocity b∇q, (b∇q, ∇q) = 0. So A_ii is regular. Inner
//! velocities come first: without pivoting, A_ii is eliminated by the definite part of the momentum
//! equation and then by its definite Schur complement.

use crate::element::Shape;
use crate::loops::batch::Batches;
use crate::loops::scatter::Shared;
use crate::loops::slots::{Places, Slots};
use crate::loops::test_functions::{Piece, Tangents, Test, Trial};
use crate::loops::width::{Task, Width};
use crate::math::{Lanes, Scalar};
use crate::operators::Blocks;
use crate::space::PressureKind;

/// Where the (v, p) unknowns of a cell stand in its matrix: outer ones first.
#[derive(Clone, Debug)]
pub struct Layout {
    /// First of the D places of each node.
    pub node: Vec<usize>,
    /// Place of each pressure.
    pub pressure: Vec<usize>,
    /// Number of outer unknowns.
    pub outer: usize,
    /// Number of all.
    pub all: usize,
    /// Places of the outer nodes, and of the outer pressures.
    pub places: [Vec<usize>; 2],
}

impl Layout {
    /// For cells of `shape` with `n_basis` nodes, those of degree `degree` and perhaps bubbles, and `n_pressure`
    /// pressures of `kind`.
    pub fn new(shape: Shape, degree: usize, n_basis: usize, n_pressure: usize, kind: PressureKind) -> Layout {
        let dim = shape.dim();
        // Of bubbles the last one is that of the cell; those before are of its faces.
        let inside = |a: usize| {
            if a >= shape.n_nodes(degree) { a + 1 == n_basis } else { shape.is_inner(degree, a) }
        };
        // Pressures without velocities that feel them stay: their matrix is singular.
        let felt = n_pressure <= 1 + dim * (0..n_basis).filter(|&a| inside(a)).count();
        let own = |b: usize| matches!(kind, PressureKind::Pdc(_)) && felt && b > 0;
        let mut layout = Layout {
            node: vec![0; n_basis],
            pressure: vec![0; n_pressure],
            outer: 0,
            all: 0,
            places: [vec![], vec![]],
        };
        for inner in [false, true] {
            for (_, place) in layout.node.iter_mut().enumerate().filter(|(a, _)| inside(*a) == inner) {
                *place = layout.all;
                layout.all += dim;
            }
            for (_, place) in layout.pressure.iter_mut().enumerate().filter(|(b, _)| own(*b) == inner) {
                *place = layout.all;
                layout.all += 1;
            }
            if !inner {
                layout.outer = layout.all;
            }
        }
        layout.set_outer(layout.outer);
        layout
    }

    /// Eliminate the unknowns from place `outer` on.
    pub fn set_outer(&mut self, outer: usize) {
        self.outer = outer;
        let before = |places: &[usize]| places.iter().copied().filter(|&place| place < outer).collect();
        self.places = [before(&self.node), before(&self.pressure)];
    }

    /// Numbers kept per cell: for each inner unknown its row and column of the factors behind it.
    fn kept(&self) -> usize {
        (self.outer..self.all).map(|k| 1 + 2 * self.others(k)).sum()
    }

    /// Unknowns that the elimination of `k` changes: the outer ones and the inner ones behind.
    fn others(&self, k: usize) -> usize {
        self.outer + self.all - 1 - k
    }

    /// The place of the `n`-th of [`Layout::others`] of `k`.
    #[inline(always)]
    fn other(&self, k: usize, n: usize) -> usize {
        if n < self.outer { n } else { k + 1 + n - self.outer }
    }
}

/// The factors of all inner blocks of one region, and where the outer ones go.
pub struct Interior<const D: usize, const L: usize> {
    /// Places in the element matrix.
    pub layout: Layout,
    /// Where the outer entries go.
    pub slots: Slots<D, L>,
    /// Blocks to be added before the elimination: (batch, lane, block), by batch.
    pub blocks: Vec<(u32, u32, u32)>,
    /// `[batch][inner unknown]`: inverse pivot, then (row, column) entries of the others.
    pub factors: Vec<Lanes<L>>,
    /// Right-hand sides of inner unknowns after forward elimination, `[batch][inner unknown]`.
    pub inner: Vec<Lanes<L>>,
}

impl<const D: usize, const L: usize> Interior<D, L> {
    /// Room for `batches` batches.
    pub fn new(layout: Layout, batches: usize) -> Self {
        let (kept, inner) = (layout.kept(), layout.all - layout.outer);
        Interior {
            slots: Slots::default(),
            blocks: vec![],
            factors: vec![Lanes::zero(); batches * kept],
            inner: vec![Lanes::zero(); batches * inner],
            layout,
        }
    }

    /// Numbers of factors in a batch, and of inner unknowns.
    pub fn sizes(&self) -> (usize, usize) {
        (self.layout.kept(), self.layout.all - self.layout.outer)
    }
}

/// From tangents at the points to the outer matrix, for one batch.
pub(super) struct CondenseTask<'a, const D: usize, const L: usize> {
    pub(super) tangents: Tangents<'a, D, L>,
    pub(super) pieces: &'a [Piece],
    pub(super) layout: &'a Layout,
    /// (batch, lane, block) to be added.
    pub(super) added: &'a [(u32, u32, u32)],
    pub(super) blocks: &'a Blocks,
    /// Of the blocks of nodes and pressures with both: φ v, φ p, ξ v, ξ p.
    pub(super) places: [Places<'a, D, L>; 4],
    pub(super) piece: &'a mut [Lanes<L>],
    /// For sums over one coordinate after the other.
    pub(super) work: &'a mut [Lanes<L>],
    pub(super) matrix: &'a mut [Lanes<L>],
    pub(super) factors: &'a mut [Lanes<L>],
    pub(super) out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> CondenseTask<'_, D, L>
where
    Lanes<L>: Width,
{
    /// The matrix of the cells, and what is added to it.
    #[inline(always)]
    fn fill(&mut self) {
        let Layout { node, pressure, all, .. } = self.layout;
        let (n, m, all) = (self.tangents.n_basis, self.tangents.n_pressure, *all);
        let matrix = &mut self.matrix[..all * all];
        matrix.fill(Lanes::zero());
        for piece in self.pieces {
            let (rows, columns) =
                (if piece.test == Test::Xi { m } else { n }, if piece.trial == Trial::P { m } else { n });
            let block = &mut self.piece[..rows * columns];
            self.tangents.contract(piece, block, self.work);
            for (a, line) in block.chunks_exact(columns).enumerate() {
                let row = match piece.test {
                    Test::Phi(i) | Test::Psi(i) => node[a] + i,
                    Test::Xi => pressure[a],
                };
                for (b, value) in line.iter().enumerate() {
                    let column = match piece.trial {
                        Trial::V(j) | Trial::U(j) => node[b] + j,
                        Trial::P => pressure[b],
                    };
                    matrix[row * all + column] = *value;
                }
            }
        }
        for &(_, lane, block) in self.added {
            for (at, value) in self.blocks.entries(block as usize).iter().enumerate() {
                let (row, column) = (at / (n * D), at % (n * D));
                let (row, column) = (node[row / D] + row % D, node[column / D] + column % D);
                matrix[row * all + column].0[lane as usize] += value;
            }
        }
    }

    /// Eliminate the inner unknowns, and keep the factors.
    #[inline(always)]
    fn eliminate(&mut self) {
        let (outer, all) = (self.layout.outer, self.layout.all);
        let matrix = &mut self.matrix[..all * all];
        let mut kept = &mut *self.factors;
        for k in outer..all {
            let others = self.layout.others(k);
            let (now, rest) = kept.split_at_mut(1 + 2 * others);
            kept = rest;
            // Padded lanes are zero throughout, and stay so.
            let pivot = matrix[k * all + k];
            let mut inverse = Lanes::<L>::zero();
            for l in 0..L {
                inverse.0[l] = if pivot.0[l] == 0.0 { 0.0 } else { 1.0 / pivot.0[l] };
            }
            now[0] = inverse;
            let (upper, lower) = now[1..].split_at_mut(others);
            for n in 0..others {
                let at = self.layout.other(k, n);
                upper[n] = matrix[k * all + at];
                lower[n] = matrix[at * all + k] * inverse;
            }
            for (n, factor) in lower.iter().enumerate() {
                let row = &mut matrix[self.layout.other(k, n) * all..][..all];
                let factor = -*factor;
                for (value, u) in row[..outer].iter_mut().zip(&upper[..outer]) {
                    value.add_product_lanes(factor, *u);
                }
                for (value, u) in row[k + 1..].iter_mut().zip(&upper[outer..]) {
                    value.add_product_lanes(factor, *u);
                }
            }
        }
    }
}

impl<const D: usize, const L: usize> CondenseTask<'_, D, L> {
    /// Add the blocks of outer rows and columns with `R` and `C` components.
    #[inline(always)]
    fn scatter<const R: usize, const C: usize>(
        &self,
        places: Places<'_, D, L>,
        rows: &[usize],
        columns: &[usize],
    ) {
        let (all, matrix) = (self.layout.all, &*self.matrix);
        for (a, &row) in rows.iter().enumerate() {
            for (b, &column) in columns.iter().enumerate() {
                places.add_block::<R, C>(self.out, (a, b), |i, j| &matrix[(row + i) * all + column + j]);
            }
        }
    }
}

impl<const D: usize, const L: usize> Task for CondenseTask<'_, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(mut self) {
        self.fill();
        self.eliminate();
        let [nodes, pressures] = &self.layout.places;
        let [phi_v, phi_p, xi_v, xi_p] = self.places;
        self.scatter::<D, D>(phi_v, nodes, nodes);
        self.scatter::<D, 1>(phi_p, nodes, pressures);
        self.scatter::<1, D>(xi_v, pressures, nodes);
        self.scatter::<1, 1>(xi_p, pressures, pressures);
    }
}

/// What both sweeps over inner unknowns know of a batch.
pub(super) struct Sweep<'a, const D: usize, const L: usize> {
    pub(super) layout: &'a Layout,
    pub(super) batches: &'a Batches<D, L>,
    pub(super) batch: usize,
    pub(super) factors: &'a [Lanes<L>],
    /// Place of the first pressure in vectors `[v, u, p]`.
    pub(super) first_pressure: u32,
}

impl<const D: usize, const L: usize> Sweep<'_, D, L> {
    /// Places in `[v, u, p]` of the unknown at place `at` of the layout.
    #[inline(always)]
    pub(super) fn visit(&self, mut visit: impl FnMut(usize, [u32; L])) {
        let (n, m) = (self.batches.n_basis, self.batches.n_pressure);
        let nodes = &self.batches.nodes[self.batch * n..][..n];
        for (nodes, &place) in nodes.iter().zip(&self.layout.node) {
            for i in 0..D {
                visit(place + i, nodes.map(|node| node * D as u32 + i as u32));
            }
        }
        let pressures = &self.batches.pressure[self.batch * m..][..m];
        for (dofs, &place) in pressures.iter().zip(&self.layout.pressure) {
            visit(place, dofs.map(|dof| self.first_pressure + dof));
        }
    }
}

/// `b_o ← b_o − A_oi A_ii⁻¹ b_i` in a vector `[v, u, p]`.
pub(super) struct ForwardTask<'a, const D: usize, const L: usize> {
    pub(super) sweep: Sweep<'a, D, L>,
    pub(super) inner: &'a mut [Lanes<L>],
    /// Where it adds to momentum and divergence rows.
    pub(super) write: (&'a [[u32; L]], &'a [[u32; L]]),
    pub(super) work: &'a mut [Lanes<L>],
    pub(super) out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Task for ForwardTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let layout = self.sweep.layout;
        let (outer, all) = (layout.outer, layout.all);
        let x = &mut self.work[..all];
        x[..outer].fill(Lanes::zero());
        let active = self.sweep.batches.active[self.sweep.batch];
        self.sweep.visit(|place, dofs| {
            if place >= outer {
                for l in 0..L {
                    x[place].0[l] = self.out.get(dofs[l]);
                }
            }
        });
        let mut factors = self.sweep.factors;
        for k in outer..all {
            let others = layout.others(k);
            let (now, rest) = factors.split_at(1 + 2 * others);
            factors = rest;
            let value = -x[k];
            for (n, lower) in now[1 + others..].iter().enumerate() {
                x[layout.other(k, n)].add_product_lanes(*lower, value);
            }
        }
        self.inner.copy_from_slice(&x[outer..]);
        let (nodes, pressures) = self.write;
        for (rows, &place) in nodes.iter().zip(&layout.node).filter(|(_, place)| **place < outer) {
            for i in 0..D {
                for l in 0..active {
                    self.out.add(rows[l] + i as u32, x[place + i].0[l]);
                }
            }
        }
        for (rows, &place) in pressures.iter().zip(&layout.pressure).filter(|(_, place)| **place < outer) {
            for l in 0..active {
                self.out.add(rows[l], x[place].0[l]);
            }
        }
    }
}

/// `x_i = A_ii⁻¹ (b_i − A_io x_o)` in a vector `[v, u, p]`.
pub(super) struct BackwardTask<'a, const D: usize, const L: usize> {
    pub(super) sweep: Sweep<'a, D, L>,
    pub(super) inner: &'a [Lanes<L>],
    pub(super) work: &'a mut [Lanes<L>],
    pub(super) out: &'a Shared<'a>,
}

impl<const D: usize, const L: usize> Task for BackwardTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        let layout = self.sweep.layout;
        let (outer, all) = (layout.outer, layout.all);
        let x = &mut self.work[..all];
        self.sweep.visit(|place, dofs| {
            if place < outer {
                for l in 0..L {
                    x[place].0[l] = self.out.get(dofs[l]);
                }
            }
        });
        x[outer..].copy_from_slice(self.inner);
        let mut factors = self.sweep.factors;
        for k in (outer..all).rev() {
            let others = layout.others(k);
            let (rest, now) = factors.split_at(factors.len() - 1 - 2 * others);
            factors = rest;
            let mut value = x[k];
            for (n, upper) in now[1..1 + others].iter().enumerate() {
                value.add_product_lanes(*upper, -x[layout.other(k, n)]);
            }
            x[k] = value * now[0];
        }
        let active = self.sweep.batches.active[self.sweep.batch];
        self.sweep.visit(|place, dofs| {
            if place >= outer {
                for l in 0..active {
                    self.out.set(dofs[l] as usize, x[place].0[l]);
                }
            }
        });
    }
}
