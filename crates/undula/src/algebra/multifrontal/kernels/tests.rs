use super::*;
use crate::algebra::vector::pseudo_random_sign;
use crate::algebra::vectors::dispatch;
use pulp::{Arch, Scalar};

/// All kernels against plain loops, for sizes around the lengths of vectors.
struct Check;

impl WithSimd for Check {
    type Output = ();

    fn with_simd<S: Simd>(self, simd: S) {
        check::<f64, S>(simd, 1e-12);
        check::<f32, S>(simd, 1e-4);
    }
}

fn check<T: Real, S: Simd>(simd: S, allowed: f64) {
    let value = |i: usize| T::of(pseudo_random_sign(i) * (1.0 + i as f64 / 4000.0));
    let x: Vec<T> = (0..4000).map(value).collect();
    for rows in (0..34).chain([48, 57, 64, 67, 96]) {
        check_vectors(simd, &x, rows, allowed);
        for (columns, depth) in [(0, 3), (1, 1), (3, 7), (4, 16), (7, 0), (13, 5), (19, 20)] {
            check_product::<T, S, false>(simd, &x, [rows, columns, depth], allowed);
            check_product::<T, S, true>(simd, &x, [rows, columns, depth], allowed);
        }
    }
}

fn check_product<T: Real, S: Simd, const REPLACE: bool>(
    simd: S,
    x: &[T],
    [rows, columns, depth]: [usize; 3],
    allowed: f64,
) {
    let (lda, ldb, ldc) = (rows + 2, columns + 1, rows + 3);
    let mut c = x[..ldc * (columns + 1)].to_vec();
    let b = &x[500..];
    gemm_sub::<T, S, REPLACE>(simd, [rows, columns, depth], (x, lda), (b, ldb), (&mut c, ldc));
    for (at, (c, before)) in c.iter().zip(x).enumerate() {
        let (i, j) = (at % ldc, at / ldc);
        let term = |p: usize| x[p * lda + i].double() * b[p * ldb + j.min(columns)].double();
        let product: f64 = (0..depth).map(term).sum();
        let inside = i < rows && j < columns;
        let expected = match (inside, REPLACE) {
            (false, _) => before.double(),
            (true, true) => -product,
            (true, false) => before.double() - product,
        };
        assert!((c.double() - expected).abs() < allowed, "{rows} {columns} {depth}: {c:?} {expected}");
    }
}

fn check_vectors<T: Real, S: Simd>(simd: S, x: &[T], rows: usize, allowed: f64) {
    let max = x[..rows].iter().fold(0.0, |m: f64, v| m.max(v.double().abs()));
    assert_eq!(max_abs(simd, &x[..rows]).double(), max);
    for columns in [0, 1, 4, 7] {
        let a = |i: usize, p: usize| x[p * (rows + 1) + i].double();
        let (v, start) = (&x[700..], &x[900..]);
        let mut y = start[..rows].to_vec();
        gemv_sub(simd, (x, rows + 1), &v[..columns], &mut y);
        for i in 0..rows {
            let product: f64 = (0..columns).map(|p| a(i, p) * v[p].double()).sum();
            assert!((y[i].double() - (start[i].double() - product)).abs() < allowed);
        }
        let mut y = start[..columns].to_vec();
        gemv_transposed_sub(simd, (x, rows + 1), &v[..rows], &mut y);
        for p in 0..columns {
            let product: f64 = (0..rows).map(|i| a(i, p) * v[i].double()).sum();
            assert!((y[p].double() - (start[p].double() - product)).abs() < allowed);
        }
    }
}

#[test]
fn kernels_are_plain_loops_on_this_machine() {
    dispatch(Arch::new(), Check);
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
