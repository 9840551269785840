//! Elimination inside one front.
//!
//! A front is a dense matrix of `k` pivots (its own and those delayed by its children) and `r` rows
//! behind them,
//! ```text
//!     [ F11 F12 ]      panel = [ F11 ]  m × k      upper = F12ᵀ  r × k      rest = F22  r × r
//!     [ F21 F22 ]              [ F21 ]
//! ```
//! all by columns. After elimination, `panel` holds L and the part of U that belongs to pivots, with
//! the diagonal inverted, `upper` the rest of U, `rest` the contribution to the parent. Pivots that are too small are left:
//! the last `k − e` columns of `panel` and `upper` then belong to the contribution too.
//!
//! Where the matrix is symmetric positive definite, every pivot is taken as it comes. U = D Lᵀ is computed all the same,
//! as it happens once per run, but not kept.

mod update;

use super::buffer::Buffer;
use super::kernels::{flushed, gemv_sub, max_abs};
use super::real::Real;
use super::sizes::{SLACK, Sizes, padded};
use pulp::Simd;

/// A pivot must be at least this share of the largest entry of its column.
const THRESHOLD: f64 = 0.01;

/// The diagonal is taken, and rows are not exchanged, if it is this share of the best pivot.
const KEEP_DIAGONAL: f64 = 0.1;

/// Columns factored one after the other before the columns behind are updated.
const PANEL: usize = 16;

/// Columns between updates of all columns behind, in fronts of more than twice as many.
const BLOCK: usize = 64;

/// Numbers of one front; the memory stays from factorisation to factorisation.
#[derive(Debug, Default)]
pub(super) struct Front<T> {
    /// Pivots to try: own and delayed by children.
    pub k: usize,
    /// Rows behind the pivots.
    pub r: usize,
    /// Pivots eliminated; the others are delayed.
    pub e: usize,
    /// Whether all pivots were positive where they had to be.
    pub is_definite: bool,
    /// F11 over F21, leading dimension [`Front::ld`]; lent until it has been packed, or the parent has taken
    /// delayed pivots out of it.
    pub panel: Buffer<T>,
    /// F12ᵀ, leading dimension `padded(r)`; lent like `panel`.
    pub upper: Buffer<T>,
    /// L and U of a front whose sizes are not those of the analysis, else empty.
    pub spill: Buffer<T>,
    /// F22, leading dimension `padded(r)`; lent from the pool until the parent has added it. Children
    /// are added last.
    pub rest: Buffer<T>,
    /// Which of the assembled rows (columns) is at each place among the pivots.
    pub row_from: Vec<u32>,
    /// The same for columns.
    pub col_from: Vec<u32>,
    /// Whether rows, and columns, have changed places.
    pub moved: (bool, bool),
    /// Place of the first delayed pivot among the pivots of the parent.
    pub delayed_to: usize,
    /// Vector of the triangular solves, one number per row.
    pub work: Vec<T>,
    /// Whether it is zero after forward substitution.
    pub is_zero: bool,
    /// Memory to permute it.
    pub spare: Vec<T>,
}

/// Memory shared by the fronts of one thread.
#[derive(Debug, Default)]
pub(super) struct Scratch<T> {
    /// Of a front, as long as it is eliminated.
    pub panel: Buffer<T>,
    /// The same.
    pub upper: Buffer<T>,
    pub column: Vec<T>,
    pub block: Vec<T>,
    pub row_scale: Vec<f64>,
    pub col_scale: Vec<f64>,
}

impl<T: Real> Front<T> {
    /// Leading dimension of `panel`.
    pub fn ld(&self) -> usize {
        self.k + padded(self.r)
    }

    /// Pivots handed to the parent.
    pub fn delayed(&self) -> usize {
        self.k - self.e
    }

    /// What determines where its factors are.
    #[inline(always)]
    pub fn sizes(&self) -> Sizes {
        Sizes { k: self.k, e: self.e, r: self.r }
    }

    /// Takes memory and sets all numbers to zero for `k` pivots and `r` rows, but not those of `rest`.
    pub fn reset(&mut self, k: usize, r: usize, panel: Buffer<T>, upper: Buffer<T>, rest: Buffer<T>) {
        (self.k, self.r, self.e) = (k, r, 0);
        self.moved = (false, false);
        (self.panel, self.upper, self.rest) = (panel, upper, rest);
        let zeros = |v: &mut Buffer<T>, n: usize| {
            v.resize(n);
            v.fill(T::ZERO);
        };
        let ld = self.ld();
        zeros(&mut self.panel, k * ld + SLACK);
        zeros(&mut self.upper, k * padded(r) + SLACK);
        self.rest.resize(r * padded(r));
        for from in [&mut self.row_from, &mut self.col_from] {
            from.clear();
            from.extend(0..k as u32);
        }
    }

    /// Eliminates what can be eliminated; with `definite`, everything.
    #[inline(always)]
    pub fn eliminate<S: Simd>(&mut self, simd: S, definite: bool, scratch: &mut Scratch<T>) {
        self.is_definite = true;
        // Columns from `end` on have been tried in vain, after `tried` pivots.
        let (mut end, mut tried) = (self.k, 0);
        let block = if self.k >= 2 * BLOCK { BLOCK } else { PANEL };
        loop {
            let start = self.e;
            let stop = (start + block).min(end);
            let mut limit = stop;
            while self.e < limit {
                let start = self.e;
                self.factor_panel(simd, definite, &mut limit, &mut scratch.column);
                self.update(simd, start, stop, &mut scratch.block);
            }
            if stop < self.k {
                self.update_behind(simd, start, stop, &mut scratch.block);
            }
            for failed in self.e..stop {
                end -= 1;
                if failed < end {
                    self.swap_columns(failed, end);
                }
            }
            if self.e == end {
                if end == self.k || tried == self.e {
                    break;
                }
                (end, tried) = (self.k, self.e);
            }
        }
        self.solve_upper(simd);
        self.multiply_rest(simd);
    }

    /// Factors the next columns. A column without an acceptable pivot changes places with the last one
    /// before `limit`.
    #[inline(always)]
    fn factor_panel<S: Simd>(&mut self, simd: S, definite: bool, limit: &mut usize, column: &mut Vec<T>) {
        let (ld, start) = (self.ld(), self.e);
        while self.e < (start + PANEL).min(*limit) {
            let (j, q) = (self.e, self.e - start);
            column.clear();
            column.extend_from_slice(&self.panel[j * ld + start..(j + 1) * ld]);
            self.apply_pivots(simd, start, q, column);
            let row = if definite {
                if !(column[q] > T::ZERO && column[q].finite()) {
                    (column[q], self.is_definite) = (T::ONE, false);
                }
                Some(0)
            } else {
                choose(simd, column[q..].split_at(self.k - j))
            };
            if let Some(row) = row {
                column.swap(q, q + row);
                let inverse = T::ONE / column[q];
                for v in &mut column[q + 1..] {
                    *v = flushed(*v * inverse);
                }
                column[q] = inverse;
                if row > 0 {
                    self.swap_rows(j, j + row);
                }
                self.panel[j * ld + start..(j + 1) * ld].copy_from_slice(column);
                self.e += 1;
            } else {
                *limit -= 1;
                self.swap_columns(j, *limit);
            }
        }
    }

    /// Applies the `q` pivots of a panel that starts at `start` to a column below `start`.
    #[inline(always)]
    fn apply_pivots<S: Simd>(&self, simd: S, start: usize, q: usize, column: &mut [T]) {
        let ld = self.ld();
        for p in 0..q {
            let lower = &self.panel[(start + p) * ld + start + p + 1..][..q - p - 1];
            let factor = flushed(column[p]);
            column[p] = factor;
            for (v, l) in column[p + 1..q].iter_mut().zip(lower) {
                *v -= *l * factor;
            }
        }
        let (done, below) = column.split_at_mut(q);
        if q > 0 {
            gemv_sub(simd, (&self.panel[start * ld + start + q..], ld), done, below);
        }
    }

    fn swap_rows(&mut self, a: usize, b: usize) {
        let (ld, ldu) = (self.ld(), padded(self.r));
        for column in self.panel[..self.k * ld].chunks_exact_mut(ld) {
            column.swap(a, b);
        }
        swap_chunks(&mut self.upper, ldu, a, b);
        self.row_from.swap(a, b);
        self.moved.0 = true;
    }

    fn swap_columns(&mut self, a: usize, b: usize) {
        let ld = self.ld();
        swap_chunks(&mut self.panel, ld, a, b);
        self.col_from.swap(a, b);
        self.moved.1 |= a != b;
    }
}

/// The row to exchange with the first for a pivot that is not small against its column; `None`: there is none.
#[inline(always)]
fn choose<T: Real, S: Simd>(simd: S, (pivots, below): (&[T], &[T])) -> Option<usize> {
    let best = max_abs(simd, pivots);
    if !(best > T::ZERO && best.finite() && best >= T::of(THRESHOLD) * max_abs(simd, below)) {
        return None;
    }
    if pivots[0].size() >= T::of(KEEP_DIAGONAL) * best {
        return Some(0);
    }
    pivots.iter().position(|v| v.size() == best).or(Some(0))
}

/// Exchanges two chunks of equal size.
fn swap_chunks<T>(v: &mut [T], size: usize, a: usize, b: usize) {
    if a != b {
        let (low, high) = v.split_at_mut(a.max(b) * size);
        low[a.min(b) * size..][..size].swap_with_slice(&mut high[..size]);
    }
}
