//! The largest eigenvalue of an operator that is self-adjoint and positive in some inner product.

/// Iterations at most.
const STEPS: usize = 300;
/// Relative change of the eigenvalue at which the iteration ends, met twice in a row.
const CHANGE: f64 = 1e-9;

/// The largest eigenvalue of `apply` on vectors of `n` entries, by Lanczos' method with complete
/// reorthogonalisation; an estimate from below.
///
/// `mass` is the matrix of the inner product, `project` takes a kernel off. Zero if nothing is left.
pub(super) fn largest(
    n: usize,
    mut apply: impl FnMut(&[f64], &mut [f64]),
    mass: impl Fn(&[f64], &mut [f64]),
    project: impl Fn(&mut [f64]),
) -> f64 {
    let (mut basis, mut weighted): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (vec![], vec![]);
    let (mut alpha, mut beta, mut value, mut calm) = (vec![], vec![], 0.0f64, 0);
    let mut next = start(n);
    project(&mut next);
    while basis.len() < STEPS.min(n) {
        let mut with_mass = vec![0.0; n];
        mass(&next, &mut with_mass);
        let size = dot(&next, &with_mass).max(0.0).sqrt();
        let scale = alpha.iter().fold(f64::MIN_POSITIVE, |m: f64, a: &f64| m.max(a.abs()));
        if size == 0.0 || (!basis.is_empty() && size < 1e-14 * scale) {
            break;
        }
        if !basis.is_empty() {
            beta.push(size);
        }
        next.iter_mut().chain(&mut with_mass).for_each(|x| *x /= size);
        let mut image = vec![0.0; n];
        apply(&next, &mut image);
        project(&mut image);
        alpha.push(dot(&image, &with_mass));
        basis.push(next);
        weighted.push(with_mass);
        // Twice is enough to be orthogonal to rounding.
        for _ in 0..2 {
            for (q, weighted) in basis.iter().zip(&weighted) {
                let part = dot(&image, weighted);
                image.iter_mut().zip(q).for_each(|(x, q)| *x -= part * q);
            }
        }
        next = image;
        let before = std::mem::replace(&mut value, top(&alpha, &beta));
        calm = if (value - before).abs() <= CHANGE * value.abs() { calm + 1 } else { 0 };
        if calm == 2 {
            break;
        }
    }
    value
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Numbers without a pattern, the same every time (xorshift).
fn start(n: usize) -> Vec<f64> {
    let mut seed = 0x9E37_79B9_7F4A_7C15u64;
    let next = |_| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    (0..n).map(next).collect()
}

/// The largest eigenvalue of a symmetric tridiagonal matrix by bisection with Sturm's sequence.
fn top(diagonal: &[f64], beside: &[f64]) -> f64 {
    let off = |i: usize| beside.get(i).copied().unwrap_or(0.0).abs();
    let radius = |i: usize| off(i) + if i > 0 { off(i - 1) } else { 0.0 };
    let bound = |sign: f64| (0..diagonal.len()).map(move |i| diagonal[i] + sign * radius(i));
    let (mut low, mut high) =
        (bound(-1.0).fold(f64::INFINITY, f64::min), bound(1.0).fold(f64::NEG_INFINITY, f64::max));
    // All eigenvalues are below x if all pivots of T − x are negative.
    let all_below = |x: f64| {
        let mut pivot = 1.0f64;
        (0..diagonal.len()).all(|i| {
            let coupling = if i > 0 { off(i - 1).powi(2) / pivot } else { 0.0 };
            pivot = diagonal[i] - x - coupling;
            pivot < 0.0
        })
    };
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if all_below(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_largest_of_known_eigenvalues() {
        // (i + 1)² on a diagonal, in the inner product of a weight; the last one is taken off.
        let n = 50;
        let apply = |x: &[f64], y: &mut [f64]| (0..n).for_each(|i| y[i] = ((i + 1) * (i + 1)) as f64 * x[i]);
        let mass = |x: &[f64], y: &mut [f64]| (0..n).for_each(|i| y[i] = (1.0 + i as f64) * x[i]);
        assert!((largest(n, apply, mass, |_| {}) - 2500.0).abs() < 1e-5);
        assert!((largest(n, apply, mass, |x| x[n - 1] = 0.0) - 2401.0).abs() < 1e-5);
        assert_eq!(largest(3, |_, _| {}, |x, y| y.copy_from_slice(x), |x| x.fill(0.0)), 0.0);
    }
}
