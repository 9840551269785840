//! Backward substitution with L of a symmetric factorisation: `x ← L⁻ᵀ D⁻¹ x` for the pivots of a front.
//!
//! Blocks are those of forward substitution, from the last to the first. Every number is computed by the same
//! operations in the same order, whatever the number of threads.

use super::factors::Lower;
use super::kernels::{dots, flush};
use super::real::Real;
use super::sizes::{BLOCK, Sizes};
use crate::algebra::vectors::dispatch;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::ops::Range;

/// Pivots of large fronts that wait for all rows behind them at once, a multiple of [`BLOCK`].
const WIDE: usize = 256;

/// Pivots of large fronts for one thread, a multiple of [`BLOCK`].
const COLUMNS: usize = 64;

/// Numbers of L from which on a front is large.
const LARGE: usize = 1 << 18;

/// x ← L⁻ᵀ D⁻¹ x for the pivots; the rest of x is known, and zero behind to the end of the last vector.
#[inline(always)]
pub(super) fn backward<T: Real, S: Simd>(simd: S, factor: Lower<T>, x: &mut [T]) {
    let Sizes { k, e, r } = factor.sizes;
    for j in (0..e).step_by(BLOCK).rev() {
        let width = (e - j).min(BLOCK);
        let (now, known) = x[j..].split_at_mut(width);
        let known = &known[..(k + r - j - width).next_multiple_of(T::lanes::<S>())];
        block::<T, S, true, true>(simd, factor, j, 0, known, now);
    }
}

/// The same, in parallel if the front is large.
pub(super) fn backward_large<T: Real>(arch: Arch, factor: Lower<T>, x: &mut [T]) {
    let Sizes { k, e, r } = factor.sizes;
    if e <= WIDE || e * (k + r) < LARGE {
        return dispatch(arch, Step::Whole { factor, x });
    }
    for start in (0..e).step_by(WIDE).rev() {
        let stop = (start + WIDE).min(e);
        let (now, known) = x.split_at_mut(stop);
        now[start..].par_chunks_mut(COLUMNS).enumerate().for_each(|(c, y)| {
            dispatch(arch, Step::Behind { factor, first: start + c * COLUMNS, stop, known, y });
        });
        dispatch(arch, Step::Among { factor, pivots: start..stop, x: now });
    }
}

/// Work on vectors of the machine.
enum Step<'a, T> {
    /// [`backward`].
    Whole { factor: Lower<'a, T>, x: &'a mut [T] },
    /// Divide the pivots `y`, which begin with `first`, and subtract what the rows from `stop` on contribute.
    Behind { factor: Lower<'a, T>, first: usize, stop: usize, known: &'a [T], y: &'a mut [T] },
    /// Solve for `pivots`, the last of `x`, where the rows behind have been subtracted.
    Among { factor: Lower<'a, T>, pivots: Range<usize>, x: &'a mut [T] },
}

impl<T: Real> WithSimd for Step<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self {
            Self::Whole { factor, x } => backward(simd, factor, x),
            Self::Behind { factor, first, stop, known, y } => {
                let Sizes { k, r, .. } = factor.sizes;
                let known = &known[..(k + r - stop).next_multiple_of(T::lanes::<S>())];
                for (b, y) in y.chunks_mut(BLOCK).enumerate() {
                    let j = first + b * BLOCK;
                    let skip = stop - j - y.len();
                    block::<T, S, true, false>(simd, factor, j, skip, known, y);
                }
            }
            Self::Among { factor, pivots, x } => {
                for j in pivots.clone().step_by(BLOCK).rev() {
                    let width = (pivots.end - j).min(BLOCK);
                    let (now, known) = x[j..].split_at_mut(width);
                    block::<T, S, false, true>(simd, factor, j, 0, known, now);
                }
            }
        }
    }
}

/// `y ← L⁻ᵀ (D⁻¹ y − Lᵀ known)` for the block that starts with pivot `j`; `known` begins `skip` rows behind it. Without
/// DIVIDE y is D⁻¹ y already, without SOLVE the triangle of the block waits.
#[inline(always)]
fn block<T: Real, S: Simd, const DIVIDE: bool, const SOLVE: bool>(
    simd: S,
    factor: Lower<T>,
    j: usize,
    skip: usize,
    known: &[T],
    y: &mut [T],
) {
    let (triangle, rows, ld) = factor.block(j, y.len());
    let rows = (&rows[skip..], ld);
    match y.len() {
        1 => columns::<T, S, 1, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
        2 => columns::<T, S, 2, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
        3 => columns::<T, S, 3, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
        4 => columns::<T, S, 4, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
        5 => columns::<T, S, 5, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
        6 => columns::<T, S, 6, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
        7 => columns::<T, S, 7, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
        _ => columns::<T, S, BLOCK, DIVIDE, SOLVE>(simd, triangle, rows, known, y),
    }
}

/// [`block`] of W columns.
#[inline(always)]
fn columns<T: Real, S: Simd, const W: usize, const DIVIDE: bool, const SOLVE: bool>(
    simd: S,
    triangle: &[T],
    (rows, ld): (&[T], usize),
    known: &[T],
    y: &mut [T],
) {
    let mut v = [T::ZERO; W];
    v.copy_from_slice(y);
    let sums = if known.is_empty() { [T::ZERO; W] } else { dots::<T, S, W>(simd, rows, ld, known) };
    for p in 0..W {
        if DIVIDE {
            v[p] *= triangle[p * BLOCK + p];
        }
        v[p] -= sums[p];
    }
    if SOLVE {
        for q in (1..W).rev() {
            for p in 0..q {
                v[p] -= triangle[p * BLOCK + q] * v[q];
            }
        }
    }
    flush(&mut v);
    y.copy_from_slice(&v);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::multifrontal::buffer::Buffer;
    use crate::algebra::multifrontal::factors::{Factors, pack_lower};
    use crate::algebra::multifrontal::front::Front;
    use crate::algebra::multifrontal::symbolic::Shape;
    use crate::algebra::vector::pseudo_random_sign;

    /// A front with random L and D, against plain loops; whole and cut.
    fn check<T: Real>(k: usize, r: usize, allowed: f64) {
        let mut front = Front::<T>::default();
        front.reset(k, r, Buffer::default(), Buffer::default(), Buffer::default());
        front.e = k;
        let ld = front.ld();
        for (i, v) in front.panel.iter_mut().enumerate() {
            let (row, column) = (i % ld, i / ld);
            let size = if row == column { 0.5 } else { 1.0 / (k + r) as f64 };
            *v = if row < k + r { T::of(pseudo_random_sign(i) * size) } else { T::ZERO };
        }
        let mut factors = Factors::new(0, front.sizes().lower(), true);
        pack_lower(&front, true, &mut factors.upper);
        let (shape, arch) = (Shape::default(), Arch::new());
        let mut start: Vec<T> = (0..k + r + 32).map(|i| T::of((i as f64).sin())).collect();
        start[k + r..].fill(T::ZERO);
        let mut expected: Vec<f64> = start.iter().map(|x| x.double()).collect();
        for p in (0..k).rev() {
            let entry = |i: usize| front.panel[p * ld + i].double();
            let sum: f64 = (p + 1..k + r).map(|i| entry(i) * expected[i]).sum();
            expected[p] = expected[p] * entry(p) - sum;
        }
        let (mut whole, mut cut) = (start.clone(), start);
        dispatch(arch, Step::Whole { factor: factors.lower(&shape, &front), x: &mut whole });
        backward_large(arch, factors.lower(&shape, &front), &mut cut);
        for (i, expected) in expected.iter().enumerate() {
            let found = [whole[i].double(), cut[i].double()];
            assert!(
                found.iter().all(|x| (x - expected).abs() < allowed),
                "{k} {r}: {i} {found:?} {expected}"
            );
        }
    }

    #[test]
    fn substitution_is_a_plain_loop() {
        for (k, r) in [(1, 0), (3, 5), (8, 0), (13, 40), (40, 23), (257, 11), (600, 405)] {
            check::<f64>(k, r, 1e-12);
            check::<f32>(k, r, 1e-4);
        }
    }
}
