//! The largest eigenvalues of S B, self-adjoint in the inner product of B, with their vectors.

use crate::algebra::dot;
use faer::{Mat, Side};

/// Vectors per block: eigenvalues of a multiplicity up to this are found as often as they are there.
const BLOCK: usize = 3;
/// Relative change of the eigenvalues at which the iteration ends, met in [`CALM`] blocks in a row.
const CHANGE: f64 = 1e-12;
/// See [`CHANGE`].
const CALM: usize = 2;
/// Of a vector less than this is left by the others: it is one of them.
const SPENT: f64 = 1e-10;

/// Orthonormal vectors, and their products with B.
#[derive(Default)]
struct Basis {
    vectors: Vec<Vec<f64>>,
    weighted: Vec<Vec<f64>>,
}

impl Basis {
    /// Appends what `x` has beside the vectors that are there.
    fn append(&mut self, mut x: Vec<f64>, mass: &mut impl FnMut(&[f64], &mut [f64])) {
        let mut taken = 0.0;
        // Twice is enough to be orthogonal to rounding.
        for _ in 0..2 {
            for (q, weighted) in self.vectors.iter().zip(&self.weighted) {
                let part = dot(&x, weighted);
                taken += part * part;
                x.iter_mut().zip(q).for_each(|(x, q)| *x -= part * q);
            }
        }
        let mut weighted = vec![0.0; x.len()];
        mass(&x, &mut weighted);
        let left = dot(&x, &weighted).max(0.0);
        if left == 0.0 || left < SPENT * SPENT * (taken + left) {
            return;
        }
        let scale = 1.0 / left.sqrt();
        x.iter_mut().chain(&mut weighted).for_each(|x| *x *= scale);
        self.vectors.push(x);
        self.weighted.push(weighted);
    }

    fn combined(&self, factors: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut x = vec![0.0; self.vectors.first().map_or(0, Vec::len)];
        for (q, factor) in self.vectors.iter().zip(factors) {
            x.iter_mut().zip(q).for_each(|(x, q)| *x += factor * q);
        }
        x
    }
}

/// The `count` largest eigenvalues of S B on vectors of `n` entries with their vectors x, xᵀ B x = 1, in descending
/// order; as many as there are above 0, or that are found.
///
/// `solve(b, x)` sets x = S b, `mass(x, y)` sets y = B x; S is symmetric and not negative, B positive on the image of
/// S. Lanczos' method by blocks with complete reorthogonalisation (B. N. Parlett, *The Symmetric Eigenvalue Problem*,
/// SIAM 1998, chapter 13).
pub(super) fn largest(
    n: usize,
    count: usize,
    mut solve: impl FnMut(&[f64], &mut [f64]),
    mut mass: impl FnMut(&[f64], &mut [f64]),
) -> Vec<(f64, Vec<f64>)> {
    let mut seed = 0x9E37_79B9_7F4A_7C15u64;
    let mut basis = Basis::default();
    // Images, so that they are in the image of S.
    let mut image = |b: &[f64]| {
        let mut x = vec![0.0; n];
        solve(b, &mut x);
        x
    };
    let mut block: Vec<Vec<f64>> = (0..BLOCK).map(|_| image(&random(n, &mut seed))).collect();
    let (mut rows, mut before, mut calm): (Vec<Vec<f64>>, Vec<f64>, usize) = (vec![], vec![], 0);
    let limit = n.min(10 * count + 300);
    let mut found = (vec![], Mat::zeros(0, 0));
    while rows.len() < limit && calm < CALM {
        block.drain(..).for_each(|x| basis.append(x, &mut mass));
        if basis.vectors.len() == rows.len() {
            break;
        }
        for j in rows.len()..basis.vectors.len() {
            let x = image(&basis.weighted[j]);
            rows.push(basis.weighted[..=j].iter().map(|weighted| dot(&x, weighted)).collect());
            block.push(x);
        }
        found = ritz(&rows, count);
        let moved = |(a, b): (&f64, &f64)| (a - b).abs() > CHANGE * a.abs();
        let still = before.len() == count && !found.0.iter().zip(&before).any(moved);
        calm = if still { calm + 1 } else { 0 };
        before.clone_from(&found.0);
    }
    let (values, vectors) = found;
    let last = vectors.ncols();
    let pair = |(n, value): (usize, f64)| {
        (value, basis.combined((0..vectors.nrows()).map(|row| vectors[(row, last - 1 - n)])))
    };
    values.into_iter().enumerate().filter(|(_, value)| *value > 0.0).map(pair).collect()
}

/// The `count` largest eigenvalues, descending, and all vectors, ascending, of a symmetric matrix given by its lower
/// rows.
fn ritz(rows: &[Vec<f64>], count: usize) -> (Vec<f64>, Mat<f64>) {
    let n = rows.len();
    let matrix = Mat::from_fn(n, n, |i, j| if j <= i { rows[i][j] } else { rows[j][i] });
    let Ok(eigen) = matrix.self_adjoint_eigen(Side::Lower) else {
        return (vec![], Mat::zeros(0, 0));
    };
    let values = eigen.S().column_vector();
    let largest = (0..n).rev().take(count).map(|i| values[i]).collect();
    (largest, eigen.U().to_owned())
}

/// Numbers without a pattern (xorshift).
fn random(n: usize, seed: &mut u64) -> Vec<f64> {
    let next = |_| {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    (0..n).map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiple_eigenvalues_are_found_as_often_as_they_are_there() {
        // 1/K is 60, 60, 58, 57, … on a diagonal, B is a weight.
        let n = 60;
        let value = |i: usize| if i == n - 2 { n as f64 } else { 1.0 + i as f64 };
        let weight = |i: usize| 1.0 + (i % 7) as f64;
        let solve = |b: &[f64], x: &mut [f64]| (0..n).for_each(|i| x[i] = value(i) / weight(i) * b[i]);
        let mass = |x: &[f64], y: &mut [f64]| (0..n).for_each(|i| y[i] = weight(i) * x[i]);
        let found = largest(n, 4, solve, mass);
        for ((value, vector), expected) in found.iter().zip([60.0, 60.0, 58.0, 57.0]) {
            assert!((value - expected).abs() < 1e-9, "{value} {expected}");
            let size: f64 = vector.iter().enumerate().map(|(i, x)| weight(i) * x * x).sum();
            assert!((size - 1.0).abs() < 1e-12);
        }
        assert_eq!(found.len(), 4);
    }

    #[test]
    fn there_are_no_more_modes_than_unknowns() {
        let found = largest(2, 5, |b, x| x.copy_from_slice(b), |x, y| y.copy_from_slice(x));
        assert_eq!(found.len(), 2);
    }
}
