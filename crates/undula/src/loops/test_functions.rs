//! BᵀDB: from the tangent at the points of a cell to blocks of its matrix.

use super::tensor::TensorBasis;
use super::tensor::matrices::BlockTask;
use super::width::Width;
use crate::math::{Lanes, Scalar};
use crate::physics::Couplings;
use crate::physics::form::Block;

/// Which equation a row belongs to.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Test {
    /// Momentum, component i.
    Phi(usize),
    /// Extension or velocity-deformation relation, component i.
    Psi(usize),
    /// Divergence.
    Xi,
}

/// Which unknown a column belongs to.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Trial {
    /// Velocity, component j.
    V(usize),
    /// Deformation, component j.
    U(usize),
    /// Pressure.
    P,
}

/// A block of the element matrix: one component of a test function against one of a trial function.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Row.
    pub test: Test,
    /// Column.
    pub trial: Trial,
    /// Values, gradients or both.
    pub block: Block,
}

/// All pieces that are not zero, in the order of assembly.
pub fn pieces(c: &Couplings, dim: usize, deforms: bool) -> Vec<Piece> {
    let mut list = vec![];
    let mut add = |test, trial, block| {
        if block != Block::Zero {
            list.push(Piece { test, trial, block });
        }
    };
    for i in 0..dim {
        for j in 0..dim {
            // Mass blocks act component by component.
            let of = |b: Block| if b == Block::Mass && i != j { Block::Zero } else { b };
            add(Test::Phi(i), Trial::V(j), of(c.phi_v));
            if deforms {
                add(Test::Phi(i), Trial::U(j), of(c.phi_u));
                add(Test::Psi(i), Trial::V(j), of(c.psi_v));
                add(Test::Psi(i), Trial::U(j), of(c.psi_u));
            }
        }
        add(Test::Phi(i), Trial::P, c.pressure);
        add(Test::Xi, Trial::V(i), c.xi_v);
        if deforms {
            add(Test::Xi, Trial::U(i), c.pressure);
        }
    }
    if c.xi_p {
        add(Test::Xi, Trial::P, Block::Mass);
    }
    list
}

impl Test {
    /// 0 for φ, 1 for ψ, 2 for ξ; and the component.
    #[inline(always)]
    pub fn split(self) -> (usize, usize) {
        match self {
            Test::Phi(i) => (0, i),
            Test::Psi(i) => (1, i),
            Test::Xi => (2, 0),
        }
    }

    /// Number of the value component among those of `Tested`.
    fn component(self, dim: usize) -> usize {
        match self {
            Test::Phi(i) => i,
            Test::Psi(i) => dim + dim * dim + i,
            Test::Xi => 2 * (dim + dim * dim),
        }
    }
}

impl Trial {
    /// 0 for v, 1 for u, 2 for p; and the component.
    #[inline(always)]
    pub fn split(self) -> (usize, usize) {
        match self {
            Trial::V(j) => (0, j),
            Trial::U(j) => (1, j),
            Trial::P => (2, 0),
        }
    }

    /// Number of the value component among those of `Fields`.
    fn component(self, dim: usize) -> usize {
        match self {
            Trial::V(j) => j,
            Trial::U(j) => dim + dim * dim + j,
            Trial::P => 2 * (dim + dim * dim),
        }
    }
}

/// Number of the α-th of (value, ∂_1, …, ∂_D) of the component that starts at `value`.
#[inline(always)]
fn nth<const D: usize>(value: usize, alpha: usize) -> usize {
    // Values of a vector field come first, then its gradient row by row.
    let offset = D + D * D;
    let (first, i) = (value / offset * offset, value % offset);
    if alpha == 0 { value } else { first + D + i * D + alpha - 1 }
}

/// The tangent at the points of a cell, and the bases.
pub struct Tangents<'a, const D: usize, const L: usize> {
    /// `[point][column][row]`, columns in the order of `Fields`, rows in that of `Tested`.
    pub tangent: &'a [Lanes<L>],
    /// `[point][basis][1 + D]`.
    pub basis: &'a [f64],
    /// `[point][basis]` of the pressure.
    pub pressure: &'a [Lanes<L>],
    /// Basis functions of v and u.
    pub n_basis: usize,
    /// Basis functions of p.
    pub n_pressure: usize,
    /// Points.
    pub n_points: usize,
    /// The basis of v and u as products, where that is faster.
    pub tensor: Option<&'a TensorBasis>,
    /// The element matrix itself, `[column][row]` in the order v, u, p, where it came from differences of residuals.
    pub nodal: Option<&'a [Lanes<L>]>,
}

impl<const D: usize, const L: usize> Tangents<'_, D, L>
where
    Lanes<L>: Width,
{
    const COMPONENTS: usize = 2 * (D + D * D) + 1;

    /// The element matrix of `piece`, `[row basis][column basis]`, into `out`; `work` is that of the tensor basis.
    #[inline(always)]
    pub fn contract(&self, piece: &Piece, out: &mut [Lanes<L>], work: &mut [Lanes<L>]) {
        if let Some(matrix) = self.nodal {
            return self.copy(matrix, piece, out);
        }
        out.fill(Lanes::zero());
        match (piece.test, piece.trial) {
            (Test::Xi, Trial::P) => self.pressures(piece, out),
            (Test::Xi, _) => self.divergence(piece, out),
            (_, Trial::P) => self.pressure(piece, out),
            _ if let Some(basis) = self.tensor => self.factorized(basis, piece, out, work),
            _ => match piece.block {
                Block::Mass => self.vector::<0, 1>(piece, out),
                Block::Stiffness => self.vector::<1, 0>(piece, out),
                _ => self.vector::<0, 0>(piece, out),
            },
        }
    }

    /// The block of a whole element matrix.
    #[inline(always)]
    fn copy(&self, matrix: &[Lanes<L>], piece: &Piece, out: &mut [Lanes<L>]) {
        let (n, m) = (self.n_basis, self.n_pressure);
        let size = 2 * n * D + m;
        let (rows, i) = match piece.test {
            Test::Phi(i) => (n, i),
            Test::Psi(i) => (n, n * D + i),
            Test::Xi => (m, 2 * n * D),
        };
        let (columns, j) = match piece.trial {
            Trial::V(j) => (n, j),
            Trial::U(j) => (n, n * D + j),
            Trial::P => (m, 2 * n * D),
        };
        let (per_row, per_column) =
            (if piece.test == Test::Xi { 1 } else { D }, if piece.trial == Trial::P { 1 } else { D });
        for a in 0..rows {
            for b in 0..columns {
                out[a * columns + b] = matrix[(j + b * per_column) * size + i + a * per_row];
            }
        }
    }

    /// Entries of the tangent at point `q` for one pair of components: `[α][β]`.
    #[inline(always)]
    fn entry(&self, q: usize, row: usize, column: usize) -> Lanes<L> {
        self.tangent[(q * Self::COMPONENTS + column) * Self::COMPONENTS + row]
    }

    /// v or u against φ or ψ. `FIRST`: 1 leaves values out; `VALUE`: 1 leaves gradients out.
    #[inline(always)]
    fn vector<const FIRST: usize, const VALUE: usize>(&self, piece: &Piece, out: &mut [Lanes<L>]) {
        let (row, column) = (piece.test.component(D), piece.trial.component(D));
        let last = if VALUE == 1 { 1 } else { 1 + D };
        let n = self.n_basis;
        for q in 0..self.n_points {
            let basis = &self.basis[q * n * (1 + D)..(q + 1) * n * (1 + D)];
            let mut d = [[Lanes::zero(); 4]; 4];
            for alpha in FIRST..last {
                for beta in FIRST..last {
                    d[alpha][beta] = self.entry(q, nth::<D>(row, alpha), nth::<D>(column, beta));
                }
            }
            for (a, out) in basis.chunks_exact(1 + D).zip(out.chunks_exact_mut(n)) {
                let mut t = [Lanes::zero(); 4];
                for beta in FIRST..last {
                    for alpha in FIRST..last {
                        t[beta].add_product(a[alpha], d[alpha][beta]);
                    }
                }
                for (b, out) in basis.chunks_exact(1 + D).zip(out) {
                    for beta in FIRST..last {
                        out.add_product(b[beta], t[beta]);
                    }
                }
            }
        }
    }

    /// The same by sums over one coordinate after the other.
    #[inline(always)]
    fn factorized(&self, basis: &TensorBasis, piece: &Piece, out: &mut [Lanes<L>], work: &mut [Lanes<L>]) {
        let (row, column) = (piece.test.component(D), piece.trial.component(D));
        let mut entries = [[0; 4]; 4];
        for alpha in 0..1 + D {
            for beta in 0..1 + D {
                entries[alpha][beta] = nth::<D>(column, beta) * Self::COMPONENTS + nth::<D>(row, alpha);
            }
        }
        let (step, block) = (Self::COMPONENTS * Self::COMPONENTS, piece.block);
        let tangent = self.tangent;
        Lanes::<L>::dispatch(BlockTask::<D, L> { basis, tangent, entries, step, block, out, work });
    }

    /// p against φ: gradients of φ, and values where the block has them.
    #[inline(always)]
    fn pressure(&self, piece: &Piece, out: &mut [Lanes<L>]) {
        let (row, column) = (piece.test.component(D), piece.trial.component(D));
        let (n, m) = (self.n_basis, self.n_pressure);
        let values = piece.block == Block::Full;
        for q in 0..self.n_points {
            let basis = &self.basis[q * n * (1 + D)..(q + 1) * n * (1 + D)];
            let pressure = &self.pressure[q * m..(q + 1) * m];
            for (a, out) in basis.chunks_exact(1 + D).zip(out.chunks_exact_mut(m)) {
                let mut t = Lanes::zero();
                for d in 0..D {
                    t.add_product(a[1 + d], self.entry(q, nth::<D>(row, 1 + d), column));
                }
                if values {
                    t.add_product(a[0], self.entry(q, row, column));
                }
                for (p, out) in pressure.iter().zip(out) {
                    out.add_product_lanes(*p, t);
                }
            }
        }
    }

    /// p against ξ: values only.
    #[inline(always)]
    fn pressures(&self, piece: &Piece, out: &mut [Lanes<L>]) {
        let (row, column) = (piece.test.component(D), piece.trial.component(D));
        let m = self.n_pressure;
        for q in 0..self.n_points {
            let pressure = &self.pressure[q * m..(q + 1) * m];
            let value = self.entry(q, row, column);
            for (test, out) in pressure.iter().zip(out.chunks_exact_mut(m)) {
                let weighted = *test * value;
                for (trial, out) in pressure.iter().zip(out) {
                    out.add_product_lanes(*trial, weighted);
                }
            }
        }
    }

    /// v or u against ξ: gradients, and values where the block has them.
    #[inline(always)]
    fn divergence(&self, piece: &Piece, out: &mut [Lanes<L>]) {
        let (row, column) = (piece.test.component(D), piece.trial.component(D));
        let (n, m) = (self.n_basis, self.n_pressure);
        let values = piece.block == Block::Full;
        for q in 0..self.n_points {
            let basis = &self.basis[q * n * (1 + D)..(q + 1) * n * (1 + D)];
            let pressure = &self.pressure[q * m..(q + 1) * m];
            for (j, b) in basis.chunks_exact(1 + D).enumerate() {
                let mut t = Lanes::zero();
                for d in 0..D {
                    t.add_product(b[1 + d], self.entry(q, row, nth::<D>(column, 1 + d)));
                }
                if values {
                    t.add_product(b[0], self.entry(q, row, column));
                }
                for (i, p) in pressure.iter().enumerate() {
                    out[i * n + j].add_product_lanes(*p, t);
                }
            }
        }
    }
}
