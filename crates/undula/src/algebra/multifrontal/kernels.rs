//! Small dense kernels, vectorised for the machine at run time. Matrices are stored by columns.
//!
//! Everything is generic over the instruction set and inlined into one entry per front, but for what an entry of its own
//! does; the order of additions depends on sizes only.

use super::real::Real;
use pulp::{Simd, WithSimd};

/// `C ← C − A B`, or `C ← −A B` where `REPLACE`, with `A` of `rows × depth` and `C` of `rows × columns`; entry (p, j) of `B` is at
/// `b[p * ldb + j]`, so that `B` is stored by rows. Compiled once, not wherever it is called.
#[inline(always)]
pub(super) fn gemm_sub<T: Real, S: Simd, const REPLACE: bool>(
    simd: S,
    sizes: [usize; 3],
    a: (&[T], usize),
    b: (&[T], usize),
    c: (&mut [T], usize),
) {
    let [_, columns, depth] = sizes;
    if columns > 0 && (depth > 0 || REPLACE) {
        simd.vectorize(Product::<T, REPLACE> { sizes, a, b, c });
    }
}

/// What [`gemm_sub`] does.
struct Product<'a, T, const REPLACE: bool> {
    sizes: [usize; 3],
    a: (&'a [T], usize),
    b: (&'a [T], usize),
    c: (&'a mut [T], usize),
}

impl<T: Real, const REPLACE: bool> WithSimd for Product<'_, T, REPLACE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { sizes: [rows, columns, depth], a: (a, lda), b, c: (c, ldc) } = self;
        let mut i = 0;
        while i < rows {
            let size = (rows - i).min(if const { one::<T, S>() } { 1 } else { 3 * T::lanes::<S>() });
            let strip = Strip { simd, size, depth, a: (&a[i..], lda), b };
            strip.multiply::<REPLACE>(columns, &mut c[i..], ldc);
            i += size;
        }
    }
}

/// Up to three vectors of rows of `A`.
#[derive(Clone, Copy)]
struct Strip<'a, T, S> {
    simd: S,
    size: usize,
    depth: usize,
    a: (&'a [T], usize),
    b: (&'a [T], usize),
}

impl<T: Real, S: Simd> Strip<'_, T, S> {
    #[inline(always)]
    fn multiply<const R: bool>(self, columns: usize, c: &mut [T], ldc: usize) {
        if const { one::<T, S>() } {
            return self.columns::<1, true, R>(columns, c, ldc);
        }
        let vectors = self.size.div_ceil(T::lanes::<S>());
        match (vectors, self.size == vectors * T::lanes::<S>()) {
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
        c: &mut [T],
        ldc: usize,
    ) {
        let mut j = 0;
        if const { size_of::<T::Vector<S>>() >= 8 * size_of::<T>() } {
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
        c: &mut [T],
        ldc: usize,
    ) {
        let Self { simd, size, depth, a: (a, lda), b: (b, ldb) } = self;
        let mut sum = [[T::splat(simd, T::ZERO); V]; N];
        for p in 0..depth {
            let column = load::<T, S, V, WHOLE>(simd, &a[p * lda..][..size]);
            let row = &b[p * ldb + j..][..N];
            for n in 0..N {
                let factor = T::splat(simd, row[n]);
                for v in 0..V {
                    sum[n][v] = T::mul_add(simd, factor, column[v], sum[n][v]);
                }
            }
        }
        for n in 0..N {
            let column = &mut c[n * ldc..][..size];
            let mut value =
                if R { [T::splat(simd, T::ZERO); V] } else { load::<T, S, V, WHOLE>(simd, column) };
            for v in 0..V {
                value[v] = T::subtract(simd, value[v], sum[n][v]);
            }
            store::<T, S, V, WHOLE>(simd, column, value);
        }
    }
}

/// Whether vectors are single numbers. Then sums are taken row by row, to the same result: nothing longer is compiled.
const fn one<T: Real, S: Simd>() -> bool {
    size_of::<T::Vector<S>>() == size_of::<T>()
}

/// V vectors from a slice; of the last, only what is there unless WHOLE.
#[inline(always)]
fn load<T: Real, S: Simd, const V: usize, const WHOLE: bool>(simd: S, x: &[T]) -> [T::Vector<S>; V] {
    let (whole, rest) = T::vectors::<S>(x);
    let mut out = [T::splat(simd, T::ZERO); V];
    if WHOLE {
        out.copy_from_slice(&whole[..V]);
    } else {
        out[..V - 1].copy_from_slice(&whole[..V - 1]);
        out[V - 1] = T::load(simd, rest);
    }
    out
}

#[inline(always)]
fn store<T: Real, S: Simd, const V: usize, const WHOLE: bool>(
    simd: S,
    x: &mut [T],
    value: [T::Vector<S>; V],
) {
    let (whole, rest) = T::vectors_mut::<S>(x);
    if WHOLE {
        whole[..V].copy_from_slice(&value);
    } else {
        whole[..V - 1].copy_from_slice(&value[..V - 1]);
        T::store(simd, rest, value[V - 1]);
    }
}

/// `y ← y − A x` with `A` of `y.len() × x.len()`.
#[inline(always)]
pub(super) fn gemv_sub<T: Real, S: Simd>(simd: S, (a, lda): (&[T], usize), x: &[T], y: &mut [T]) {
    if x.is_empty() {
        return;
    }
    let rows = y.len();
    let strip = 4 * T::lanes::<S>();
    let mut i = 0;
    while i + strip <= rows {
        gemv_strip::<T, S, 4, true>(simd, (&a[i..], lda), x, &mut y[i..i + strip]);
        i += strip;
    }
    if const { one::<T, S>() } {
        for i in i..rows {
            gemv_strip::<T, S, 1, true>(simd, (&a[i..], lda), x, &mut y[i..=i]);
        }
        return;
    }
    let left = rows - i;
    let (a, y) = (&a[i..], &mut y[i..]);
    match (left.div_ceil(T::lanes::<S>()), left.is_multiple_of(T::lanes::<S>())) {
        (0, _) => {}
        (1, true) => gemv_strip::<T, S, 1, true>(simd, (a, lda), x, y),
        (1, false) => gemv_strip::<T, S, 1, false>(simd, (a, lda), x, y),
        (2, true) => gemv_strip::<T, S, 2, true>(simd, (a, lda), x, y),
        (2, false) => gemv_strip::<T, S, 2, false>(simd, (a, lda), x, y),
        (3, true) => gemv_strip::<T, S, 3, true>(simd, (a, lda), x, y),
        (3, false) => gemv_strip::<T, S, 3, false>(simd, (a, lda), x, y),
        _ => gemv_strip::<T, S, 4, false>(simd, (a, lda), x, y),
    }
}

/// `x ← L⁻¹ x` for the unit lower triangle of the first W rows and columns.
#[inline(always)]
pub(super) fn substitute_lower<T: Real, const W: usize>((a, lda): (&[T], usize), x: &mut [T]) {
    let mut v = [T::ZERO; W];
    v.copy_from_slice(x);
    for p in 0..W {
        let column = &a[p * lda..][..W];
        for i in p + 1..W {
            v[i] -= column[i] * v[p];
        }
    }
    x.copy_from_slice(&v);
}

/// `x ← U⁻¹ x` for the upper triangle of the first W rows and columns, its diagonal inverted.
#[inline(always)]
pub(super) fn substitute_upper<T: Real, const W: usize>((a, lda): (&[T], usize), x: &mut [T]) {
    let mut v = [T::ZERO; W];
    v.copy_from_slice(x);
    for p in (0..W).rev() {
        let column = &a[p * lda..][..W];
        v[p] *= column[p];
        for i in 0..p {
            v[i] -= column[i] * v[p];
        }
    }
    x.copy_from_slice(&v);
}

#[inline(always)]
fn gemv_strip<T: Real, S: Simd, const V: usize, const WHOLE: bool>(
    simd: S,
    (a, lda): (&[T], usize),
    x: &[T],
    y: &mut [T],
) {
    let mut value = load::<T, S, V, WHOLE>(simd, y);
    for (p, x) in x.iter().enumerate() {
        let column = load::<T, S, V, WHOLE>(simd, &a[p * lda..][..y.len()]);
        let factor = T::splat(simd, -*x);
        for v in 0..V {
            value[v] = T::mul_add(simd, factor, column[v], value[v]);
        }
    }
    store::<T, S, V, WHOLE>(simd, y, value);
}

/// `y[p] ← y[p] − Σ_i A[i, p] x[i]`, that is `y ← y − Aᵀ x` with `A` of `x.len() × y.len()`.
#[inline(always)]
pub(super) fn gemv_transposed_sub<T: Real, S: Simd>(simd: S, (a, lda): (&[T], usize), x: &[T], y: &mut [T]) {
    let n = y.len();
    let mut p = 0;
    while p + 4 <= n {
        let dots = dots::<T, S, 4>(simd, &a[p * lda..], lda, x);
        for q in 0..4 {
            y[p + q] -= dots[q];
        }
        p += 4;
    }
    while p < n {
        y[p] -= dots::<T, S, 1>(simd, &a[p * lda..], lda, x)[0];
        p += 1;
    }
}

/// Products of N neighbouring columns with a vector.
#[inline(always)]
pub(super) fn dots<T: Real, S: Simd, const N: usize>(simd: S, a: &[T], lda: usize, x: &[T]) -> [T; N] {
    let (x, rest) = T::vectors::<S>(x);
    let size = x.len() * T::lanes::<S>();
    let mut sum = [T::splat(simd, T::ZERO); N];
    let mut columns = [x; N];
    for n in 0..N {
        columns[n] = T::vectors::<S>(&a[n * lda..][..size]).0;
    }
    for (i, x) in x.iter().enumerate() {
        for n in 0..N {
            sum[n] = T::mul_add(simd, columns[n][i], *x, sum[n]);
        }
    }
    if !rest.is_empty() {
        let x = T::load(simd, rest);
        for n in 0..N {
            let a = T::load(simd, &a[n * lda + size..][..rest.len()]);
            sum[n] = T::mul_add(simd, a, x, sum[n]);
        }
    }
    // Array::map is not inlined here.
    let mut out = [T::ZERO; N];
    for n in 0..N {
        out[n] = T::sum(simd, sum[n]);
    }
    out
}

/// max |x[i]|; entries that are not numbers do not count.
#[inline(always)]
pub(super) fn max_abs<T: Real, S: Simd>(simd: S, x: &[T]) -> T {
    let (whole, rest) = T::vectors::<S>(x);
    let mut max = T::splat(simd, T::ZERO);
    for &v in whole {
        max = T::larger(simd, v, max);
    }
    let max = T::larger(simd, T::load(simd, rest), max);
    T::max(simd, max)
}

/// Replaces what is too small to be multiplied safely by zero.
#[inline(always)]
pub(super) fn flush<T: Real>(x: &mut [T]) {
    if T::TINY > 0.0 {
        for x in x {
            *x = flushed(*x);
        }
    }
}

/// `x`, or zero if it is too small to be multiplied safely.
#[inline(always)]
pub(super) fn flushed<T: Real>(x: T) -> T {
    if T::TINY > 0.0 && x.size() < T::of(T::TINY) { T::ZERO } else { x }
}

#[cfg(test)]
mod tests;
