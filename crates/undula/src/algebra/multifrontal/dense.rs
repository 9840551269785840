//! Forward and backward substitution with the factors of one front.
//!
//! Columns are taken in blocks, rows of large fronts in chunks that run in parallel. Every number is
//! computed by the same operations in the same order, however it is cut.

use super::factors::{Lower, Upper};
use super::kernels::{flush, gemv_sub, gemv_transposed_sub, substitute_lower, substitute_upper};
use super::prefetch::prefetch;
use super::real::Real;
use super::sizes::{BLOCK, Sizes};
use crate::algebra::vectors::dispatch;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::ops::Range;

/// Pivots of large fronts between updates of all other rows, a multiple of [`BLOCK`].
const WIDE: usize = 256;

/// Rows of large fronts that one thread updates.
const ROWS: usize = 512;

/// Numbers of L from which on a front is large.
const LARGE: usize = 1 << 18;

/// Whether its rows are worth the while of several threads.
fn is_large(sizes: Sizes) -> bool {
    sizes.e > WIDE && sizes.e * (sizes.k + sizes.r) >= LARGE
}

/// x ← L⁻¹ x, the rows behind the pivots updated.
#[inline(always)]
pub(super) fn forward<T: Real, S: Simd>(simd: S, factor: Lower<T>, x: &mut [T]) {
    lower(simd, factor, 0..factor.sizes.e, usize::MAX, x);
}

/// The same, in parallel if the front is large.
pub(super) fn forward_large<T: Real>(arch: Arch, factor: Lower<T>, x: &mut [T]) {
    let Sizes { k, e, r } = factor.sizes;
    if !is_large(factor.sizes) {
        return dispatch(arch, Step::Lower { factor, pivots: 0..e, end: usize::MAX, x });
    }
    for start in (0..e).step_by(WIDE) {
        let pivots = start..(start + WIDE).min(e);
        let stop = pivots.end;
        dispatch(arch, Step::Lower { factor, pivots: pivots.clone(), end: stop, x });
        let (done, later) = x[..k + r].split_at_mut(stop);
        let chunks = later.par_chunks_mut(ROWS).enumerate();
        chunks.for_each(|(c, y)| {
            let (x, row) = (&done[start..], stop + c * ROWS);
            dispatch(arch, Step::Below { factor, pivots: pivots.clone(), row, x, y });
        });
    }
}

/// x ← U⁻¹ x for the pivots, where the rest is known.
#[inline(always)]
pub(super) fn backward<T: Real, S: Simd>(simd: S, factor: Upper<T>, x: &mut [T]) {
    let Sizes { k, e, r } = factor.sizes;
    let (pivots, known) = x.split_at_mut(e);
    let whole = r.next_multiple_of(T::lanes::<S>());
    gemv_transposed_sub(simd, factor.right(), &known[k - e..][..whole], pivots);
    gemv_sub(simd, factor.delayed(), &known[..k - e], pivots);
    upper(simd, factor, 0..e, pivots);
}

/// The same, in parallel if the front is large.
pub(super) fn backward_large<T: Real>(arch: Arch, factor: Upper<T>, x: &mut [T]) {
    let Sizes { k, e, r } = factor.sizes;
    if !is_large(factor.sizes) {
        return dispatch(arch, Step::Backward { factor, x });
    }
    let (right, ld) = factor.right();
    let (pivots, known) = x.split_at_mut(e);
    let (delayed, rows) = known.split_at(k - e);
    pivots.par_chunks_mut(WIDE).enumerate().for_each(|(c, y)| {
        dispatch(arch, Step::Dots { a: &right[c * WIDE * ld..], ld, r, x: rows, y });
    });
    dispatch(arch, Step::Delayed { factor, x: delayed, y: pivots });
    for start in (0..e).step_by(WIDE).rev() {
        let block = start..(start + WIDE).min(e);
        dispatch(arch, Step::Upper { factor, pivots: block.clone(), x: pivots });
        let (before, done) = pivots[..block.end].split_at_mut(start);
        before.par_chunks_mut(ROWS).enumerate().for_each(|(c, y)| {
            dispatch(arch, Step::Above { factor, pivots: block.clone(), row: c * ROWS, x: done, y });
        });
    }
}

/// Work on vectors of the machine.
enum Step<'a, T> {
    /// [`lower`].
    Lower { factor: Lower<'a, T>, pivots: Range<usize>, end: usize, x: &'a mut [T] },
    /// The rows from `row` on ← them − L x with `x` at the pivots.
    Below { factor: Lower<'a, T>, pivots: Range<usize>, row: usize, x: &'a [T], y: &'a mut [T] },
    /// [`upper`].
    Upper { factor: Upper<'a, T>, pivots: Range<usize>, x: &'a mut [T] },
    /// The same for U, from the last block of columns on.
    Above { factor: Upper<'a, T>, pivots: Range<usize>, row: usize, x: &'a [T], y: &'a mut [T] },
    /// y ← y − Aᵀ x with `r` rows, zeros in `x` behind.
    Dots { a: &'a [T], ld: usize, r: usize, x: &'a [T], y: &'a mut [T] },
    /// y ← y − U x with the columns of delayed pivots.
    Delayed { factor: Upper<'a, T>, x: &'a [T], y: &'a mut [T] },
    /// [`backward`].
    Backward { factor: Upper<'a, T>, x: &'a mut [T] },
}

impl<T: Real> WithSimd for Step<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self {
            Self::Lower { factor, pivots, end, x } => lower(simd, factor, pivots, end, x),
            Self::Below { factor, pivots, row, x, y } => {
                for j in pivots.clone().step_by(BLOCK) {
                    let width = (pivots.end - j).min(BLOCK);
                    let (_, below, ld) = factor.block(j, width);
                    let x = &x[j - pivots.start..][..width];
                    gemv_sub(simd, (&below[row - j - width..], ld), x, y);
                }
            }
            Self::Upper { factor, pivots, x } => upper(simd, factor, pivots, x),
            Self::Above { factor, pivots, row, x, y } => {
                for j in pivots.clone().step_by(BLOCK).rev() {
                    let width = (pivots.end - j).min(BLOCK);
                    let (_, above) = factor.block(j, width);
                    gemv_sub(simd, (&above[row..], j), &x[j - pivots.start..][..width], y);
                }
            }
            Self::Dots { a, ld, r, x, y } => {
                let whole = r.next_multiple_of(T::lanes::<S>());
                gemv_transposed_sub(simd, (a, ld), &x[..whole], y);
            }
            Self::Delayed { factor, x, y } => gemv_sub(simd, factor.delayed(), x, y),
            Self::Backward { factor, x } => backward(simd, factor, x),
        }
    }
}

/// Forward substitution with some pivots, and the update of the rows behind them up to `end`.
#[inline(always)]
fn lower<T: Real, S: Simd>(simd: S, factor: Lower<T>, pivots: Range<usize>, end: usize, x: &mut [T]) {
    let ld = factor.sizes.k + factor.sizes.r;
    let mut j = pivots.start;
    while j < pivots.end {
        let width = (pivots.end - j).min(BLOCK);
        let (now, later) = x[j..].split_at_mut(width);
        let (triangle, below, ld_below) = factor.block(j, width);
        prefetch(factor.ahead(j + width));
        let triangle = (triangle, BLOCK);
        match width {
            1 => {}
            2 => substitute_lower::<T, 2>(triangle, now),
            3 => substitute_lower::<T, 3>(triangle, now),
            4 => substitute_lower::<T, 4>(triangle, now),
            5 => substitute_lower::<T, 5>(triangle, now),
            6 => substitute_lower::<T, 6>(triangle, now),
            7 => substitute_lower::<T, 7>(triangle, now),
            _ => substitute_lower::<T, BLOCK>(triangle, now),
        }
        flush(now);
        // Behind the last row nothing is read again: whole vectors do no harm.
        let rows = end.min(ld) - j - width;
        let rows = if end > ld { rows.next_multiple_of(T::lanes::<S>()) } else { rows };
        gemv_sub(simd, (below, ld_below), now, &mut later[..rows]);
        j += width;
    }
}

/// Backward substitution with some pivots, and the update of those before them from the first of
/// `pivots` on.
#[inline(always)]
fn upper<T: Real, S: Simd>(simd: S, factor: Upper<T>, pivots: Range<usize>, x: &mut [T]) {
    let (start, mut end) = (pivots.start, pivots.end);
    while end > start {
        let j = (end - 1) / BLOCK * BLOCK;
        let (before, now) = x[start..end].split_at_mut(j - start);
        let (triangle, above) = factor.block(j, end - j);
        let triangle = (triangle, BLOCK);
        match end - j {
            1 => substitute_upper::<T, 1>(triangle, now),
            2 => substitute_upper::<T, 2>(triangle, now),
            3 => substitute_upper::<T, 3>(triangle, now),
            4 => substitute_upper::<T, 4>(triangle, now),
            5 => substitute_upper::<T, 5>(triangle, now),
            6 => substitute_upper::<T, 6>(triangle, now),
            7 => substitute_upper::<T, 7>(triangle, now),
            _ => substitute_upper::<T, BLOCK>(triangle, now),
        }
        flush(now);
        gemv_sub(simd, (&above[start..], j), now, before);
        end = j;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::multifrontal::buffer::Buffer;
    use crate::algebra::multifrontal::factors::{Factors, pack_lower, pack_upper};
    use crate::algebra::multifrontal::front::Front;
    use crate::algebra::multifrontal::symbolic::Shape;
    use crate::algebra::vector::pseudo_random_sign;

    fn check<T: Real>() {
        let (k, r, e) = (600, 405, 587);
        let mut front = Front::<T>::default();
        front.reset(k, r, Buffer::default(), Buffer::default(), Buffer::default());
        front.e = e;
        let ld = front.ld();
        for (i, v) in front.panel.iter_mut().enumerate() {
            let diagonal = i % ld == i / ld;
            *v = T::of(pseudo_random_sign(i) * if diagonal { 0.5 } else { 1e-2 });
        }
        front.upper.iter_mut().enumerate().for_each(|(i, v)| *v = T::of(1e-2 * pseudo_random_sign(i)));
        let sizes = front.sizes();
        let mut factors = Factors::new(sizes.lower(), sizes.upper(), false);
        pack_lower(&front, false, &mut factors.lower);
        pack_upper(&front, &mut factors.upper);
        let shape = Shape::default();
        let start: Vec<T> = (0..ld + 16).map(|i| T::of((i as f64).sin())).collect();
        let solve = |large: bool| {
            let (lower, upper) = (factors.lower(&shape, &front), factors.upper(&shape, &front));
            let mut x = start.clone();
            let arch = Arch::new();
            if large {
                forward_large(arch, lower, &mut x);
            } else {
                let pivots = 0..e;
                dispatch(arch, Step::Lower { factor: lower, pivots, end: usize::MAX, x: &mut x });
            }
            x[k + r..].fill(T::ZERO);
            let up = x.clone();
            if large {
                backward_large(arch, upper, &mut x);
            } else {
                dispatch(arch, Step::Backward { factor: upper, x: &mut x });
            }
            (up, x)
        };
        assert!(solve(true) == solve(false));
    }

    #[test]
    fn large_fronts_are_substituted_like_small_ones() {
        check::<f64>();
        check::<f32>();
    }
}
