//! Factors as substitution reads them: from the first number to the last, once up and once down the tree.
//!
//! Fronts are eliminated in memory that stays in the cache and packed afterwards, so that factors lie side
//! by side in the order of the fronts, U in the opposite one. With `P = padded(k + r)`, blocks of up to [`BLOCK`] pivots
//! ```text
//!     L: block by block   triangle, leading dimension BLOCK | rows below, P − (pivots up to here)
//!     U: U12ᵀ, e columns of padded(r) | pivots × delayed, padded(e) | from the last block: triangle | rows above
//! ```
//! A symmetric factorisation has L alone, with the inverse pivots on the diagonals of its triangles, and reads it twice. It
//! lies where U would, its blocks from the last to the first, as they are read on the way down: on the way up a
//! right-hand side is often zero in most of the tree.
//! A front with delayed pivots has other sizes than the analysis has foreseen, and memory of its own.

use super::buffer::Buffer;
use super::front::Front;
use super::real::Real;
use super::sizes::{BLOCK, SLACK, Sizes, padded};
use super::symbolic::Shape;

/// Numbers of a front from which on its blocks are asked for one by one.
const AHEAD: usize = 1 << 15;

/// The factors of all fronts.
#[derive(Debug, Default)]
pub(super) struct Factors<T> {
    pub lower: Buffer<T>,
    pub upper: Buffer<T>,
    /// Whether there is L alone, in the memory of U.
    pub definite: bool,
}

impl<T: Real> Factors<T> {
    /// Memory for `lower` and `upper` numbers.
    pub fn new(lower: usize, upper: usize, definite: bool) -> Self {
        let zeros = |n: usize| {
            let mut buffer = Buffer::with_capacity(n + SLACK);
            buffer.resize(n + SLACK);
            buffer
        };
        Self { lower: zeros(lower), upper: zeros(upper), definite }
    }

    /// L of a front.
    #[inline(always)]
    pub fn lower<'a>(&'a self, shape: &Shape, front: &'a Front<T>) -> Lower<'a, T> {
        let sizes = front.sizes();
        if self.definite {
            return Lower { data: &self.upper[shape.upper..], sizes, end: sizes.lower() };
        }
        let data = if front.spill.is_empty() { &self.lower[shape.lower..] } else { &front.spill };
        Lower { data, sizes, end: 0 }
    }

    /// U of a front.
    #[inline(always)]
    pub fn upper<'a>(&'a self, shape: &Shape, front: &'a Front<T>) -> Upper<'a, T> {
        let sizes = front.sizes();
        let spill = &front.spill[..];
        let data = if spill.is_empty() { &self.upper[shape.upper..] } else { &spill[sizes.lower()..] };
        Upper { data, sizes }
    }
}

/// L of one front.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lower<'a, T> {
    data: &'a [T],
    pub sizes: Sizes,
    /// Where the first block ends if the last one comes first, else 0.
    end: usize,
}

impl<'a, T: Real> Lower<'a, T> {
    /// The `width` pivots from `j` on: their triangle, the rows below, and the leading dimension of those.
    #[inline(always)]
    pub fn block(self, j: usize, width: usize) -> (&'a [T], &'a [T], usize) {
        let below = self.sizes.below(j + width);
        let at = self.sizes.lower_at(j);
        let start = if self.end > 0 { self.end - at - width * (BLOCK + below) } else { at };
        let (triangle, rows) = self.data[start..].split_at(width * BLOCK);
        (triangle, rows, below)
    }

    /// The block from pivot `j` on, to be asked for ahead where it does not follow in memory and the front is too
    /// large to have been asked for as a whole; else nothing.
    #[inline(always)]
    pub fn ahead(self, j: usize) -> &'a [T] {
        if self.end < AHEAD || j >= self.sizes.e {
            return &[];
        }
        let width = (self.sizes.e - j).min(BLOCK);
        let end = self.end - self.sizes.lower_at(j);
        &self.data[end - width * (BLOCK + self.sizes.below(j + width))..end]
    }

    /// All numbers, to be asked for ahead.
    pub fn all(self) -> &'a [T] {
        &self.data[..self.sizes.lower()]
    }
}

/// U of one front.
#[derive(Debug, Clone, Copy)]
pub(super) struct Upper<'a, T> {
    data: &'a [T],
    pub sizes: Sizes,
}

impl<'a, T: Real> Upper<'a, T> {
    /// U12ᵀ by columns, and their leading dimension.
    #[inline(always)]
    pub fn right(self) -> (&'a [T], usize) {
        (self.data, padded(self.sizes.r))
    }

    /// The columns of delayed pivots, and their leading dimension.
    #[inline(always)]
    pub fn delayed(self) -> (&'a [T], usize) {
        (&self.data[self.sizes.e * padded(self.sizes.r)..], padded(self.sizes.e))
    }

    /// The `width` pivots from `j` on: their triangle, and the rows above with leading dimension `j`.
    #[inline(always)]
    pub fn block(self, j: usize, width: usize) -> (&'a [T], &'a [T]) {
        let end = self.sizes.upper();
        self.data[end - self.sizes.above(j + width)..].split_at(width * BLOCK)
    }

    /// All numbers, to be asked for ahead.
    pub fn all(self) -> &'a [T] {
        &self.data[..self.sizes.upper()]
    }
}

impl<T: Real> Front<T> {
    /// Packs the factors, where sizes are those `foreseen` into `lower` and `upper`; with `definite` L alone, into
    /// `upper`.
    #[inline(always)]
    pub fn put_away(&mut self, foreseen: Sizes, definite: bool, lower: &mut [T], upper: &mut [T]) {
        let sizes = self.sizes();
        if sizes == foreseen {
            self.spill.resize(0);
            if definite {
                pack_lower(self, true, upper);
            } else {
                pack_lower(self, false, lower);
                pack_upper(self, upper);
            }
            return;
        }
        let mut spill = std::mem::take(&mut self.spill);
        spill.resize(sizes.lower() + sizes.upper() + SLACK);
        let (lower, upper) = spill.split_at_mut(sizes.lower());
        upper[sizes.upper()..].fill(T::ZERO);
        pack_lower(self, false, lower);
        pack_upper(self, upper);
        self.spill = spill;
    }
}

/// Packs L of a front that has been eliminated, its last block first if `definite`. What lies behind the last row of a
/// column is copied along: nothing reads it but whole vectors, whose last lanes are not used.
#[inline(always)]
pub(super) fn pack_lower<T: Real>(front: &Front<T>, definite: bool, lower: &mut [T]) {
    let sizes = front.sizes();
    let (panel, ld, e) = (&front.panel[..], front.ld(), sizes.e);
    let (mut to, total) = (0, sizes.lower());
    for j in (0..e).step_by(BLOCK) {
        let width = (e - j).min(BLOCK);
        let below = sizes.below(j + width);
        let start = if definite { total - to - width * (BLOCK + below) } else { to };
        let (triangle, rows) = lower[start..].split_at_mut(width * BLOCK);
        copy_triangle(&panel[j * ld + j..], ld, width, triangle);
        for (p, column) in rows.chunks_exact_mut(below.max(1)).take(width).enumerate() {
            copy_whole(&panel[(j + p) * ld + j + width..], column);
        }
        to += width * (BLOCK + below);
    }
}

/// Packs U, in the same way.
#[inline(always)]
pub(super) fn pack_upper<T: Real>(front: &Front<T>, upper: &mut [T]) {
    let Sizes { k, e, r } = front.sizes();
    let (panel, ld, ldu) = (&front.panel[..], front.ld(), padded(r));
    upper[..e * ldu].copy_from_slice(&front.upper[..e * ldu]);
    let mut to = e * ldu;
    for column in panel.chunks_exact(ld.max(1)).take(k).skip(e) {
        upper[to..][..e].copy_from_slice(&column[..e]);
        upper[to + e..to + padded(e)].fill(T::ZERO);
        to += padded(e);
    }
    for j in (0..e).step_by(BLOCK).rev() {
        let width = (e - j).min(BLOCK);
        let (triangle, rows) = upper[to..].split_at_mut(width * BLOCK);
        copy_triangle(&panel[j * ld + j..], ld, width, triangle);
        for (p, column) in rows.chunks_exact_mut(j.max(1)).take(width).enumerate() {
            copy_whole(&panel[(j + p) * ld..], column);
        }
        to += width * (BLOCK + j);
    }
}

/// `width` columns of [`BLOCK`] rows.
#[inline(always)]
fn copy_triangle<T: Copy>(panel: &[T], ld: usize, width: usize, to: &mut [T]) {
    for (p, column) in to.chunks_exact_mut(BLOCK).take(width).enumerate() {
        column.copy_from_slice(&panel[p * ld..][..BLOCK]);
    }
}

/// Whole blocks; calls would cost more than copying such short columns.
#[inline(always)]
fn copy_whole<T: Copy>(from: &[T], to: &mut [T]) {
    for (to, from) in to.chunks_exact_mut(BLOCK).zip(from.chunks_exact(BLOCK)) {
        to.copy_from_slice(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number is where the views say, and nothing else is.
    #[test]
    fn factors_are_found_where_they_were_packed() {
        for (k, e, r) in [(1, 1, 0), (7, 7, 3), (8, 8, 8), (16, 15, 21), (37, 30, 0), (40, 40, 13)] {
            let mut front = Front::<f64>::default();
            front.reset(k, r, Buffer::default(), Buffer::default(), Buffer::default());
            front.e = e;
            let (ld, ldu) = (front.ld(), padded(r));
            front.panel.iter_mut().enumerate().for_each(|(i, v)| *v = 1.0 + i as f64);
            front.upper.iter_mut().enumerate().for_each(|(i, v)| *v = -1.0 - i as f64);
            let sizes = front.sizes();
            front.spill.resize(sizes.lower() + sizes.upper());
            let (mut lower, mut upper) = (vec![0.0; sizes.lower()], vec![0.0; sizes.upper()]);
            pack_lower(&front, false, &mut lower);
            pack_upper(&front, &mut upper);
            let (lower, upper) = (Lower { data: &lower, sizes, end: 0 }, Upper { data: &upper, sizes });
            for p in 0..e {
                let j = p / BLOCK * BLOCK;
                let width = (e - j).min(BLOCK);
                let ((low, rows, below), (up, above)) = (lower.block(j, width), upper.block(j, width));
                for i in 0..k + r {
                    let wanted = front.panel[p * ld + i];
                    if i < j {
                        assert_eq!(above[(p - j) * j + i], wanted);
                    } else if i < j + width {
                        assert_eq!([low, up].map(|t| t[(p - j) * BLOCK + i - j]), [wanted; 2]);
                    } else {
                        assert_eq!(rows[(p - j) * below + i - j - width], wanted);
                    }
                }
                for i in 0..r {
                    assert_eq!(upper.right().0[p * ldu + i], front.upper[p * ldu + i]);
                }
                for d in e..k {
                    let (columns, ld_delayed) = upper.delayed();
                    assert_eq!(columns[(d - e) * ld_delayed + p], front.panel[d * ld + p]);
                }
            }
        }
    }
}
