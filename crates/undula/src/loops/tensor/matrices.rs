//! BᵀDB with one coordinate after the other.
//!
//! With α, β ∈ {value, ∂_1, …, ∂_D} and D_αβ the tangent at the points, a block of the element matrix is
//! ```text
//!     A_ab = Σ_q Σ_αβ ∂^α φ_a(ξ_q) D_αβ(ξ_q) ∂^β φ_b(ξ_q).
//! ```
//! The sum over the points of coordinate d leaves pairs (a_d, b_d), and of α and β only the coordinates behind it.

use super::super::width::Task;
use super::TensorBasis;
use super::vectors::rows;
use crate::element::LineTable;
use crate::math::{Lanes, Scalar};
use crate::physics::form::Block;

/// Numbers of work space in `dim` dimensions: two halves.
pub fn work(line: &LineTable, dim: usize) -> usize {
    let (pairs, m) = (line.n_basis.pow(2), line.n_points);
    let stage = |d: usize| pairs.pow(d as u32) * (1 + dim - d).pow(2) * m.pow((dim - d) as u32);
    2 * (0..dim).map(stage).max().unwrap_or(0)
}

/// One block of the element matrix, `[row basis][column basis]`.
pub struct BlockTask<'a, const D: usize, const L: usize> {
    /// The basis of rows and columns.
    pub basis: &'a TensorBasis,
    /// The tangent at the points.
    pub tangent: &'a [Lanes<L>],
    /// Where D_αβ of the first point stands in it, `[α][β]`, only those of [`BlockTask::block`] being read.
    pub entries: [[usize; 4]; 4],
    /// From one point to the next.
    pub step: usize,
    /// Values, gradients or both.
    pub block: Block,
    /// What comes out.
    pub out: &'a mut [Lanes<L>],
    /// Work space of [`work`] numbers.
    pub work: &'a mut [Lanes<L>],
}

impl<const D: usize, const L: usize> Task for BlockTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        match self.basis.line.n_basis {
            3 if const { D == 3 } => contract::<3, D, L>(self),
            4 => contract::<4, D, L>(self),
            5 if const { D < 3 } => contract::<5, D, L>(self),
            n => unreachable!("{n} basis functions"),
        }
    }
}

/// `Σ_q Σ_st φ_a^(s) D_st φ_b^(t)` for all pairs (a, b) in one coordinate, s and t being value and derivative.
#[inline(always)]
fn pairs<const N: usize, const L: usize>(
    line: &LineTable,
    d: &[[Option<&[Lanes<L>]>; 2]; 2],
) -> [[Lanes<L>; N]; N] {
    let mut sums = [[Lanes::zero(); N]; N];
    let tables = rows::<N>(line);
    for q in 0..line.n_points {
        let basis = [&tables.0[q], &tables.1[q]];
        for s in 0..2 {
            let mut t = [Lanes::zero(); N];
            for (d, basis) in d[s].iter().zip(basis) {
                if let Some(d) = d {
                    for b in 0..N {
                        t[b].add_product(basis[b], d[q]);
                    }
                }
            }
            if d[s][0].is_some() || d[s][1].is_some() {
                for a in 0..N {
                    for b in 0..N {
                        sums[a][b].add_product(basis[s][a], t[b]);
                    }
                }
            }
        }
    }
    sums
}

/// The sum over one coordinate d: from `[a_1, b_1]…[a_{d-1}, b_{d-1}] [α][β] [q_D]…[q_d]` to the same for d + 1,
/// α and β being value, ∂_d, …, ∂_D.
struct Stage<'a> {
    basis: &'a TensorBasis,
    /// Number of pairs (a, b) of the coordinates before.
    done: usize,
    /// Number of points in this coordinate and those behind.
    points: usize,
    /// Number of kinds of α: value, and derivatives in this coordinate and behind.
    kinds: usize,
    /// Whether there are values; from the second coordinate on, they stand for derivatives in those before, too.
    values: bool,
    /// Whether there are derivatives.
    gradients: bool,
}

impl Stage<'_> {
    /// The α of value and derivative in this coordinate that go into kind `kind` of the next.
    #[inline(always)]
    fn parts(&self, kind: usize) -> [Option<usize>; 2] {
        match kind {
            0 => [self.values.then_some(0), self.gradients.then_some(1)],
            // A derivative behind this coordinate goes with the values in it.
            _ => [Some(kind + 1), None],
        }
    }

    /// The last one writes `to` in the order of the element matrix.
    #[inline(always)]
    fn sum<const N: usize, const L: usize>(&self, from: &[Lanes<L>], to: &mut [Lanes<L>]) {
        let (left, m) = (self.kinds - 1, self.basis.line.n_points);
        let (live, rest) = (if self.gradients { left } else { 1 }, self.points / m);
        for pair in 0..self.done {
            for kinds in 0..live * live {
                let (alpha, beta) = (kinds / live, kinds % live);
                let (rows, columns) = (self.parts(alpha), self.parts(beta));
                for r in 0..rest {
                    let mut d = [[None; 2]; 2];
                    for s in 0..2 {
                        for t in 0..2 {
                            if let (Some(row), Some(column)) = (rows[s], columns[t]) {
                                let kind = (pair * self.kinds + row) * self.kinds + column;
                                d[s][t] = Some(&from[kind * self.points + r * m..][..m]);
                            }
                        }
                    }
                    let sums = pairs::<N, L>(&self.basis.line, &d);
                    for a in 0..N {
                        for b in 0..N {
                            let next = (pair * N + a) * N + b;
                            let at = ((next * left + alpha) * left + beta) * rest + r;
                            to[if left == 1 { self.basis.places[at] as usize } else { at }] = sums[a][b];
                        }
                    }
                }
            }
        }
    }
}

/// Coordinate after coordinate.
#[inline(always)]
fn contract<const N: usize, const D: usize, const L: usize>(task: BlockTask<'_, D, L>) {
    let BlockTask { basis, tangent, entries, step, block, out, work } = task;
    let (values, gradients) = (block != Block::Stiffness, block != Block::Mass);
    let half = work.len() / 2;
    let (mut from, mut to) = work.split_at_mut(half);
    let mut points = basis.n_points(D);
    let kinds = usize::from(!values)..if gradients { 1 + D } else { 1 };
    for alpha in kinds.clone() {
        for beta in kinds.clone() {
            let first = (alpha * (1 + D) + beta) * points;
            for q in 0..points {
                from[first + q] = tangent[q * step + entries[alpha][beta]];
            }
        }
    }
    let mut done = 1;
    for d in 0..D {
        let values = values || d > 0;
        let stage = Stage { basis, done, points, kinds: 1 + D - d, values, gradients };
        stage.sum::<N, L>(from, if d + 1 == D { &mut *out } else { &mut *to });
        (from, to) = (to, from);
        (done, points) = (done * N * N, points / basis.line.n_points);
    }
}
