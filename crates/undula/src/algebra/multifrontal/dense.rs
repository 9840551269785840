//! Forward and backward substitution with the factors of one front.
//!
//! Columns are taken in blocks, rows of large fronts in chunks that run in parallel. Every number is
//! computed by the same operations in the same order, however it is cut.

use super::front::{Front, padded};
use super::kernels::{flush, gemv_sub, gemv_transposed_sub, substitute_lower, substitute_upper};
use super::real::Real;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::ops::Range;

/// Pivots applied at a time: as many columns of the factors are read side by side.
const BLOCK: usize = 8;

/// Pivots of large fronts between updates of all other rows, a multiple of [`BLOCK`].
const WIDE: usize = 256;

/// Rows of large fronts that one thread updates.
const ROWS: usize = 512;

/// Entries from which on a front is large.
const LARGE: usize = 1 << 18;

/// `work` ← L⁻¹ `work`, the rows behind the pivots updated.
#[inline(always)]
pub(super) fn forward<T: Real, S: Simd>(simd: S, front: &mut Front<T>) {
    let (e, ld) = (front.e, front.ld());
    lower(simd, &front.panel, ld, 0..e, ld, &mut front.work);
}

/// The same, in parallel if the front is large.
pub(super) fn forward_large<T: Real>(arch: Arch, front: &mut Front<T>) {
    let (e, ld) = (front.e, front.ld());
    let Front { panel, work, .. } = front;
    if e <= WIDE || e * ld < LARGE {
        return arch.dispatch(Step::Lower { panel, ld, pivots: 0..e, end: ld, x: work });
    }
    for start in (0..e).step_by(WIDE) {
        let stop = (start + WIDE).min(e);
        arch.dispatch(Step::Lower { panel, ld, pivots: start..stop, end: stop, x: work });
        let (done, later) = work[..ld].split_at_mut(stop);
        let chunks = later.par_chunks_mut(ROWS).enumerate();
        chunks.for_each(|(c, y)| {
            let a = &panel[start * ld + stop + c * ROWS..];
            arch.dispatch(Step::Update { a, ld, x: &done[start..], y, backward: false });
        });
    }
}

/// `work` ← U⁻¹ `work` for the pivots, where the rest is known.
#[inline(always)]
pub(super) fn backward<T: Real, S: Simd>(simd: S, front: &mut Front<T>) {
    let (k, r, e, ld) = (front.k, front.r, front.e, front.ld());
    let (pivots, known) = front.work.split_at_mut(e);
    let whole = r.next_multiple_of(T::lanes::<S>());
    gemv_transposed_sub(simd, (&front.upper, padded(r)), &known[k - e..][..whole], pivots);
    gemv_sub(simd, (&front.panel[e * ld..], ld), &known[..k - e], pivots);
    upper(simd, &front.panel, ld, 0..e, pivots);
}

/// The same, in parallel if the front is large.
pub(super) fn backward_large<T: Real>(arch: Arch, front: &mut Front<T>) {
    let (k, r, e, ld) = (front.k, front.r, front.e, front.ld());
    if e <= WIDE || e * ld < LARGE {
        return arch.dispatch(Step::Backward { front });
    }
    let Front { panel, upper, work, .. } = front;
    let ldu = padded(r);
    let (pivots, known) = work.split_at_mut(e);
    let (delayed, rows) = known.split_at(k - e);
    pivots.par_chunks_mut(WIDE).enumerate().for_each(|(c, y)| {
        arch.dispatch(Step::Dots { a: &upper[c * WIDE * ldu..], ld: ldu, r, x: rows, y });
    });
    arch.dispatch(Step::Update { a: &panel[e * ld..], ld, x: delayed, y: pivots, backward: false });
    for start in (0..e).step_by(WIDE).rev() {
        let stop = (start + WIDE).min(e);
        arch.dispatch(Step::Upper { panel, ld, pivots: start..stop, x: pivots });
        let (before, done) = pivots[..stop].split_at_mut(start);
        before.par_chunks_mut(ROWS).enumerate().for_each(|(c, y)| {
            let a = &panel[start * ld + c * ROWS..];
            arch.dispatch(Step::Update { a, ld, x: done, y, backward: true });
        });
    }
}

/// Work on vectors of the machine.
enum Step<'a, T> {
    /// [`lower`].
    Lower { panel: &'a [T], ld: usize, pivots: Range<usize>, end: usize, x: &'a mut [T] },
    /// [`upper`].
    Upper { panel: &'a [T], ld: usize, pivots: Range<usize>, x: &'a mut [T] },
    /// y ← y − A x, block by block of columns, from the last one if `backward`.
    Update { a: &'a [T], ld: usize, x: &'a [T], y: &'a mut [T], backward: bool },
    /// y ← y − Aᵀ x with `r` rows, zeros in `x` behind.
    Dots { a: &'a [T], ld: usize, r: usize, x: &'a [T], y: &'a mut [T] },
    /// [`backward`].
    Backward { front: &'a mut Front<T> },
}

impl<T: Real> WithSimd for Step<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self {
            Self::Lower { panel, ld, pivots, end, x } => lower(simd, panel, ld, pivots, end, x),
            Self::Upper { panel, ld, pivots, x } => upper(simd, panel, ld, pivots, x),
            Self::Update { a, ld, x, y, backward } => {
                for block in 0..x.len().div_ceil(BLOCK) {
                    let block = if backward { x.len().div_ceil(BLOCK) - 1 - block } else { block };
                    let columns = block * BLOCK..x.len().min((block + 1) * BLOCK);
                    gemv_sub(simd, (&a[columns.start * ld..], ld), &x[columns], y);
                }
            }
            Self::Dots { a, ld, r, x, y } => {
                let whole = r.next_multiple_of(T::lanes::<S>());
                gemv_transposed_sub(simd, (a, ld), &x[..whole], y);
            }
            Self::Backward { front } => backward(simd, front),
        }
    }
}

/// Forward substitution with some pivots, and the update of the rows behind them up to `end`.
#[inline(always)]
fn lower<T: Real, S: Simd>(simd: S, panel: &[T], ld: usize, pivots: Range<usize>, end: usize, x: &mut [T]) {
    let mut j = pivots.start;
    while j < pivots.end {
        let width = (pivots.end - j).min(BLOCK);
        let (now, later) = x[j..].split_at_mut(width);
        let triangle = (&panel[j * ld + j..], ld);
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
        let rows = end - j - width;
        let rows = if end == ld { rows.next_multiple_of(T::lanes::<S>()) } else { rows };
        gemv_sub(simd, (&panel[j * ld + j + width..], ld), now, &mut later[..rows]);
        j += width;
    }
}

/// Backward substitution with some pivots, and the update of those before them from the first of
/// `pivots` on.
#[inline(always)]
fn upper<T: Real, S: Simd>(simd: S, panel: &[T], ld: usize, pivots: Range<usize>, x: &mut [T]) {
    let (start, mut end) = (pivots.start, pivots.end);
    while end > start {
        let j = (end - 1) / BLOCK * BLOCK;
        let (before, now) = x[start..end].split_at_mut(j - start);
        let triangle = (&panel[j * ld + j..], ld);
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
        gemv_sub(simd, (&panel[j * ld + start..], ld), now, before);
        end = j;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::multifrontal::buffer::Buffer;
    use crate::algebra::vector::pseudo_random_sign;

    fn check<T: Real>() {
        let (k, r, e) = (600, 405, 587);
        let mut front = Front::<T>::default();
        front.reset(k, r, Buffer::default());
        front.e = e;
        let ld = front.ld();
        for (i, v) in front.panel.iter_mut().enumerate() {
            let diagonal = i % ld == i / ld;
            *v = T::of(pseudo_random_sign(i) * if diagonal { 0.5 } else { 1e-2 });
        }
        front.upper.iter_mut().enumerate().for_each(|(i, v)| *v = T::of(1e-2 * pseudo_random_sign(i)));
        let start: Vec<T> = (0..ld + 16).map(|i| T::of((i as f64).sin())).collect();
        let solve = |large: bool, front: &mut Front<T>| {
            front.work = start.clone();
            let arch = Arch::new();
            if large {
                forward_large(arch, front)
            } else {
                arch.dispatch(Plain(front, true))
            }
            front.work[k + r..].fill(T::ZERO);
            let up = front.work.clone();
            if large {
                backward_large(arch, front)
            } else {
                arch.dispatch(Plain(front, false))
            }
            (up, front.work.clone())
        };
        assert!(solve(true, &mut front) == solve(false, &mut front));
    }

    struct Plain<'a, T>(&'a mut Front<T>, bool);

    impl<T: Real> WithSimd for Plain<'_, T> {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            if self.1 { forward(simd, self.0) } else { backward(simd, self.0) }
        }
    }

    #[test]
    fn large_fronts_are_substituted_like_small_ones() {
        check::<f64>();
        check::<f32>();
    }
}
