//! Small dense kernels, vectorised for the machine at run time. Matrices are stored by columns.
//!
//! Everything is generic over the instruction set and inlined into one entry per front; the order of
//! additions depends on sizes only.

use pulp::Simd;

/// `C ← C − A B`, or `C ← −A B` where `REPLACE`, with `A` of `rows × depth` and `C` of `rows × columns`; entry (p, j) of `B` is at
/// `b[p * ldb + j]`, so that `B` is stored by rows.
#[inline(always)]
pub(super) fn gemm_sub<S: Simd, const REPLACE: bool>(
    simd: S,
    [rows, columns, depth]: [usize; 3],
    (a, lda): (&[f64], usize),
    b: (&[f64], usize),
    (c, ldc): (&mut [f64], usize),
) {
    if columns == 0 || depth == 0 && !REPLACE {
        return;
    }
    let mut i = 0;
    while i < rows {
        let size = (rows - i).min(3 * S::F64_LANES);
        let strip = Strip { simd, size, depth, a: (&a[i..], lda), b };
        strip.multiply::<REPLACE>(columns, &mut c[i..], ldc);
        i += size;
    }
}

/// Up to three vectors of rows of `A`.
#[derive(Clone, Copy)]
struct Strip<'a, S> {
    simd: S,
    size: usize,
    depth: usize,
    a: (&'a [f64], usize),
    b: (&'a [f64], usize),
}

impl<S: Simd> Strip<'_, S> {
    #[inline(always)]
    fn multiply<const R: bool>(self, columns: usize, c: &mut [f64], ldc: usize) {
        let vectors = self.size.div_ceil(S::F64_LANES);
        match (vectors, self.size == vectors * S::F64_LANES) {
            (3, true) => self.columns::<3, true, R>(columns, c, ldc),
            (3, false) => self.columns::<3, false, R>(columns, c, ldc),
            (2, true) => self.columns::<2, true, R>(columns, c, ldc),
            (2, false) => self.columns::<2, false, R>(columns, c, ldc),
            (_, true) => self.columns::<1, true, R>(columns, c, ldc),
            (_, false) => self.columns::<1, false, R>(columns, c, ldc),
        }
    }

    /// All columns of the strip, as many at a time as there are registers for.
    #[inline(always)]
    fn columns<const V: usize, const WHOLE: bool, const R: bool>(
        self,
        columns: usize,
        c: &mut [f64],
        ldc: usize,
    ) {
        let mut j = 0;
        if S::F64_LANES >= 8 {
            while j + 8 <= columns {
                self.block::<V, 8, WHOLE, R>(j, &mut c[j * ldc..], ldc);
                j += 8;
            }
        }
        while j + 4 <= columns {
            self.block::<V, 4, WHOLE, R>(j, &mut c[j * ldc..], ldc);
            j += 4;
        }
        while j < columns {
            self.block::<V, 1, WHOLE, R>(j, &mut c[j * ldc..], ldc);
            j += 1;
        }
    }

    #[inline(always)]
    fn block<const V: usize, const N: usize, const WHOLE: bool, const R: bool>(
        self,
        j: usize,
        c: &mut [f64],
        ldc: usize,
    ) {
        let Self { simd, size, depth, a: (a, lda), b: (b, ldb) } = self;
        let mut sum = [[simd.splat_f64s(0.0); V]; N];
        for p in 0..depth {
            let column = load::<S, V, WHOLE>(simd, &a[p * lda..][..size]);
            let row = &b[p * ldb + j..][..N];
            for n in 0..N {
                let factor = simd.splat_f64s(row[n]);
                for v in 0..V {
                    sum[n][v] = simd.mul_add_f64s(factor, column[v], sum[n][v]);
                }
            }
        }
        for n in 0..N {
            let column = &mut c[n * ldc..][..size];
            let mut value = if R { [simd.splat_f64s(0.0); V] } else { load::<S, V, WHOLE>(simd, column) };
            for v in 0..V {
                value[v] = simd.sub_f64s(value[v], sum[n][v]);
            }
            store::<S, V, WHOLE>(simd, column, value);
        }
    }
}

/// V vectors from a slice; of the last, only what is there unless WHOLE.
#[inline(always)]
fn load<S: Simd, const V: usize, const WHOLE: bool>(simd: S, x: &[f64]) -> [S::f64s; V] {
    let (whole, rest) = S::as_simd_f64s(x);
    let mut out = [simd.splat_f64s(0.0); V];
    if WHOLE {
        out.copy_from_slice(&whole[..V]);
    } else {
        out[..V - 1].copy_from_slice(&whole[..V - 1]);
        out[V - 1] = simd.partial_load_f64s(rest);
    }
    out
}

#[inline(always)]
fn store<S: Simd, const V: usize, const WHOLE: bool>(simd: S, x: &mut [f64], value: [S::f64s; V]) {
    let (whole, rest) = S::as_mut_simd_f64s(x);
    if WHOLE {
        whole[..V].copy_from_slice(&value);
    } else {
        whole[..V - 1].copy_from_slice(&value[..V - 1]);
        simd.partial_store_f64s(rest, value[V - 1]);
    }
}

/// `y ← y − A x` with `A` of `y.len() × x.len()`.
#[inline(always)]
pub(super) fn gemv_sub<S: Simd>(simd: S, (a, lda): (&[f64], usize), x: &[f64], y: &mut [f64]) {
    if x.is_empty() {
        return;
    }
    let rows = y.len();
    let strip = 4 * S::F64_LANES;
    let mut i = 0;
    while i + strip <= rows {
        gemv_strip::<S, 4, true>(simd, (&a[i..], lda), x, &mut y[i..i + strip]);
        i += strip;
    }
    while i + S::F64_LANES <= rows {
        gemv_strip::<S, 1, true>(simd, (&a[i..], lda), x, &mut y[i..i + S::F64_LANES]);
        i += S::F64_LANES;
    }
    if i < rows {
        gemv_strip::<S, 1, false>(simd, (&a[i..], lda), x, &mut y[i..]);
    }
}

#[inline(always)]
fn gemv_strip<S: Simd, const V: usize, const WHOLE: bool>(
    simd: S,
    (a, lda): (&[f64], usize),
    x: &[f64],
    y: &mut [f64],
) {
    let mut value = load::<S, V, WHOLE>(simd, y);
    for (p, x) in x.iter().enumerate() {
        let column = load::<S, V, WHOLE>(simd, &a[p * lda..][..y.len()]);
        let factor = simd.splat_f64s(-x);
        for v in 0..V {
            value[v] = simd.mul_add_f64s(factor, column[v], value[v]);
        }
    }
    store::<S, V, WHOLE>(simd, y, value);
}

/// `y[p] ← y[p] − Σ_i A[i, p] x[i]`, that is `y ← y − Aᵀ x` with `A` of `x.len() × y.len()`.
#[inline(always)]
pub(super) fn gemv_transposed_sub<S: Simd>(simd: S, (a, lda): (&[f64], usize), x: &[f64], y: &mut [f64]) {
    let n = y.len();
    let mut p = 0;
    while p + 4 <= n {
        let dots = dots::<S, 4>(simd, &a[p * lda..], lda, x);
        for q in 0..4 {
            y[p + q] -= dots[q];
        }
        p += 4;
    }
    while p < n {
        y[p] -= dots::<S, 1>(simd, &a[p * lda..], lda, x)[0];
        p += 1;
    }
}

/// Products of N neighbouring columns with a vector.
#[inline(always)]
fn dots<S: Simd, const N: usize>(simd: S, a: &[f64], lda: usize, x: &[f64]) -> [f64; N] {
    let (x, rest) = S::as_simd_f64s(x);
    let size = x.len() * S::F64_LANES;
    let mut sum = [simd.splat_f64s(0.0); N];
    let mut columns = [x; N];
    for n in 0..N {
        columns[n] = S::as_simd_f64s(&a[n * lda..][..size]).0;
    }
    for (i, x) in x.iter().enumerate() {
        for n in 0..N {
            sum[n] = simd.mul_add_f64s(columns[n][i], *x, sum[n]);
        }
    }
    if !rest.is_empty() {
        let x = simd.partial_load_f64s(rest);
        for n in 0..N {
            let a = simd.partial_load_f64s(&a[n * lda + size..][..rest.len()]);
            sum[n] = simd.mul_add_f64s(a, x, sum[n]);
        }
    }
    sum.map(|s| simd.reduce_sum_f64s(s))
}

/// max |x[i]|; entries that are not numbers do not count.
#[inline(always)]
pub(super) fn max_abs<S: Simd>(simd: S, x: &[f64]) -> f64 {
    let (whole, rest) = S::as_simd_f64s(x);
    let mut max = simd.splat_f64s(0.0);
    for &v in whole {
        max = simd.max_f64s(simd.abs_f64s(v), max);
    }
    let max = simd.max_f64s(simd.abs_f64s(simd.partial_load_f64s(rest)), max);
    simd.reduce_max_f64s(max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::vector::pseudo_random_sign;
    use pulp::{Arch, Scalar, WithSimd};

    /// All kernels against plain loops, for sizes around the lengths of vectors.
    struct Check;

    impl WithSimd for Check {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let x: Vec<f64> = (0..4000).map(|i| pseudo_random_sign(i) * (1.0 + i as f64 / 4000.0)).collect();
            for rows in (0..34).chain([48, 57]) {
                check_vectors(simd, &x, rows);
                for (columns, depth) in [(0, 3), (1, 1), (3, 7), (4, 16), (7, 0), (13, 5), (19, 20)] {
                    check_product::<S, false>(simd, &x, [rows, columns, depth]);
                    check_product::<S, true>(simd, &x, [rows, columns, depth]);
                }
            }
        }
    }

    fn check_product<S: Simd, const REPLACE: bool>(simd: S, x: &[f64], [rows, columns, depth]: [usize; 3]) {
        let (lda, ldb, ldc) = (rows + 2, columns + 1, rows + 3);
        let mut c = x[..ldc * (columns + 1)].to_vec();
        let b = &x[500..];
        gemm_sub::<S, REPLACE>(simd, [rows, columns, depth], (x, lda), (b, ldb), (&mut c, ldc));
        for (at, (c, before)) in c.iter().zip(x).enumerate() {
            let (i, j) = (at % ldc, at / ldc);
            let product: f64 = (0..depth).map(|p| x[p * lda + i] * b[p * ldb + j.min(columns)]).sum();
            let inside = i < rows && j < columns;
            let expected = match (inside, REPLACE) {
                (false, _) => *before,
                (true, true) => -product,
                (true, false) => before - product,
            };
            assert!((c - expected).abs() < 1e-12, "{rows} {columns} {depth}: {c} {expected}");
        }
    }

    fn check_vectors<S: Simd>(simd: S, x: &[f64], rows: usize) {
        assert_eq!(max_abs(simd, &x[..rows]), x[..rows].iter().fold(0.0, |m: f64, v| m.max(v.abs())));
        for columns in [0, 1, 4, 7] {
            let a = |i: usize, p: usize| x[p * (rows + 1) + i];
            let (v, start) = (&x[700..], &x[900..]);
            let mut y = start[..rows].to_vec();
            gemv_sub(simd, (x, rows + 1), &v[..columns], &mut y);
            for i in 0..rows {
                let product: f64 = (0..columns).map(|p| a(i, p) * v[p]).sum();
                assert!((y[i] - (start[i] - product)).abs() < 1e-12);
            }
            let mut y = start[..columns].to_vec();
            gemv_transposed_sub(simd, (x, rows + 1), &v[..rows], &mut y);
            for p in 0..columns {
                let product: f64 = (0..rows).map(|i| a(i, p) * v[i]).sum();
                assert!((y[p] - (start[p] - product)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn kernels_are_plain_loops_on_this_machine() {
        Arch::new().dispatch(Check);
    }

    #[test]
    fn kernels_are_plain_loops_without_vectors() {
        Scalar.vectorize(Check);
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn kernels_are_plain_loops_with_short_vectors() {
        if let Some(simd) = pulp::x86::V3::try_new() {
            Simd::vectorize(simd, Check);
        }
    }
}
