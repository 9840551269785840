//! What the pivots of a front do to the columns behind them, to U and to the contribution to the parent.

use super::{Front, PANEL};
use crate::algebra::multifrontal::kernels::{flush, gemm_sub, gemv_sub};
use crate::algebra::multifrontal::large;
use crate::algebra::multifrontal::real::Real;
use crate::algebra::multifrontal::sizes::padded;
use faer::{MatMut, MatRef};
use pulp::{Simd, WithSimd};

impl<T: Real> Front<T> {
    /// Applies the pivots from `start` on to the columns from the next one to `stop`.
    #[inline(always)]
    pub(super) fn update<S: Simd>(&mut self, simd: S, start: usize, stop: usize, block: &mut Vec<T>) {
        let (ld, e, q) = (self.ld(), self.e, self.e - start);
        if q == 0 || e >= stop {
            return;
        }
        let n = stop - e;
        let (done, left) = self.panel.split_at_mut(e * ld);
        let left = &mut left[..n * ld];
        solve_lower(simd, (&done[start * ld + start..], ld), q, (&mut left[start..], ld), n, block);
        gemm_sub::<T, S, false>(
            simd,
            [ld - e, n, q],
            (&done[start * ld + e..], ld),
            (block, n),
            (&mut left[e..], ld),
        );
    }

    /// Applies the pivots from `start` on to the columns from `stop` on.
    #[inline(always)]
    pub(super) fn update_behind<S: Simd>(&mut self, simd: S, start: usize, stop: usize, block: &mut Vec<T>) {
        let (ld, e, q) = (self.ld(), self.e, self.e - start);
        if q <= PANEL {
            let n = self.k - stop;
            let (done, left) = self.panel.split_at_mut(stop * ld);
            solve_lower(simd, (&done[start * ld + start..], ld), q, (&mut left[start..], ld), n, block);
            gemm_sub::<T, S, false>(
                simd,
                [ld - e, n, q],
                (&done[start * ld + e..], ld),
                (block, n),
                (&mut left[e..], ld),
            );
            return;
        }
        let mut p = start;
        while p < e {
            let width = (e - p).min(PANEL);
            let n = self.k - stop;
            let (done, left) = self.panel.split_at_mut(stop * ld);
            solve_lower(simd, (&done[p * ld + p..], ld), width, (&mut left[p..], ld), n, block);
            let rows = e - p - width;
            gemm_sub::<T, S, false>(
                simd,
                [rows, n, width],
                (&done[p * ld + p + width..], ld),
                (block, n),
                (&mut left[p + width..], ld),
            );
            p += width;
        }
        let panel = MatMut::from_column_major_slice_with_stride_mut(&mut self.panel, ld, self.k, ld);
        let (done, left) = panel.split_at_col_mut(stop);
        let (upper, left) = left.split_at_row_mut(e);
        let lower = done.as_ref().submatrix(e, start, ld - e, q);
        large::subtract(left, lower, upper.as_ref().subrows(start, q));
    }

    /// U right of the pivots, from the assembled rows.
    #[inline(always)]
    pub(super) fn solve_upper<S: Simd>(&mut self, simd: S) {
        let (ld, ldu, e) = (self.ld(), padded(self.r), self.e);
        if self.r == 0 {
            return;
        }
        if e >= large::SOLVE.0 && self.r >= large::SOLVE.1 {
            let panel = MatRef::from_column_major_slice_with_stride(&self.panel, ld, self.k, ld);
            let upper = MatMut::from_column_major_slice_with_stride_mut(&mut self.upper, self.r, self.k, ldu);
            large::solve_upper(panel.subcols(0, e), upper.transpose_mut());
            flush(&mut self.upper[..e * ldu]);
            return;
        }
        let mut j = 0;
        while j < e {
            let width = (e - j).min(8);
            let (done, left) = self.upper.split_at_mut(j * ldu);
            gemm_sub::<T, S, false>(simd, [ldu, width, j], (done, ldu), (&self.panel[j..], ld), (left, ldu));
            for p in 1..width {
                let (before, now) = left.split_at_mut(p * ldu);
                let mut row = [T::ZERO; 8];
                for q in 0..p {
                    row[q] = self.panel[(j + q) * ld + j + p];
                }
                gemv_sub(simd, (before, ldu), &row[..p], &mut now[..ldu]);
                flush(&mut now[..ldu]);
            }
            j += width;
        }
        let (done, delayed) = self.upper.split_at_mut(e * ldu);
        gemm_sub::<T, S, false>(
            simd,
            [ldu, self.k - e, e],
            (done, ldu),
            (&self.panel[e..], ld),
            (delayed, ldu),
        );
    }

    /// `rest ← −L21 U12`.
    #[inline(always)]
    pub(super) fn multiply_rest<S: Simd>(&mut self, simd: S) {
        let (ld, ldu, r, k, e) = (self.ld(), padded(self.r), self.r, self.k, self.e);
        if r > 0 && e >= large::PRODUCT.0 && r >= large::PRODUCT.1 {
            let below =
                MatRef::from_column_major_slice_with_stride(&self.panel, ld, k, ld).submatrix(k, 0, r, e);
            let upper = MatRef::from_column_major_slice_with_stride(&self.upper, r, e, ldu);
            let rest = MatMut::from_column_major_slice_with_stride_mut(&mut self.rest, r, r, ldu);
            large::product(rest, below, upper.transpose());
        } else if r > 0 {
            let below = &self.panel[k.min(self.panel.len())..];
            gemm_sub::<T, S, true>(simd, [ldu, r, e], (below, ld), (&self.upper, ldu), (&mut self.rest, ldu));
        }
    }
}

/// `X ← L⁻¹ X` with `L` unit lower triangular of `q ≤ PANEL` and `X` of `q × n`; also leaves X by rows in
/// `block`. Compiled once, not wherever it is called.
#[inline(always)]
fn solve_lower<T: Real, S: Simd>(
    simd: S,
    lower: (&[T], usize),
    q: usize,
    x: (&mut [T], usize),
    n: usize,
    block: &mut Vec<T>,
) {
    simd.vectorize(SolveLower { lower, q, x, n, block });
}

/// What [`solve_lower`] does.
struct SolveLower<'a, T> {
    lower: (&'a [T], usize),
    q: usize,
    x: (&'a mut [T], usize),
    n: usize,
    block: &'a mut Vec<T>,
}

impl<T: Real> WithSimd for SolveLower<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lower: (lower, ldl), q, x: (x, ldx), n, block } = self;
        block.clear();
        block.resize(q * n, T::ZERO);
        for c in 0..n {
            for (p, v) in x[c * ldx..][..q].iter().enumerate() {
                block[p * n + c] = *v;
            }
        }
        for p in 1..q {
            let (before, now) = block.split_at_mut(p * n);
            let mut row = [T::ZERO; PANEL];
            for s in 0..p {
                row[s] = lower[s * ldl + p];
            }
            gemv_sub(simd, (before, n), &row[..p], &mut now[..n]);
            flush(&mut now[..n]);
        }
        for c in 0..n {
            for (p, v) in x[c * ldx..][..q].iter_mut().enumerate() {
                *v = block[p * n + c];
            }
        }
    }
}
