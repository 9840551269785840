//! Reductions whose result depends on the numbers only, not on threads or on the machine's lanes.

use rayon::prelude::*;

/// Partial sums of [`dot`]: entry `i` always goes to lane `i % LANES`.
const LANES: usize = 8;

/// Entries per partial sum of [`dot`]; a fixed number, so that the sum is always the same sum.
const CHUNK: usize = 4096;

/// From here on vectors are divided among the threads.
const LONG: usize = 8 * CHUNK;

/// Σ `x[i] y[i]`, summed in a fixed order.
///
/// # Panics
/// If the lengths differ.
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    assert_eq!(x.len(), y.len(), "dot of vectors of different length");
    if x.len() < LONG {
        return x.chunks(CHUNK).zip(y.chunks(CHUNK)).map(|(x, y)| dot_chunk(x, y)).sum();
    }
    let chunks = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK));
    let sums: Vec<f64> = chunks.with_min_len(4).map(|(x, y)| dot_chunk(x, y)).collect();
    sums.into_iter().sum()
}

/// y ← y + factor x.
pub fn add_scaled(factor: f64, x: &[f64], y: &mut [f64]) {
    let add = |(x, y): (&[f64], &mut [f64])| y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
    if y.len() < LONG {
        return add((x, y));
    }
    x.par_chunks(CHUNK).zip(y.par_chunks_mut(CHUNK)).with_min_len(4).for_each(add);
}

fn dot_chunk(x: &[f64], y: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (x, y) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let (x_rest, y_rest) = (x.remainder(), y.remainder());
    for (x, y) in x.zip(y) {
        for l in 0..LANES {
            lanes[l] += x[l] * y[l];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
    lanes.iter().sum::<f64>() + rest
}

/// max |`x[i]`|, or NaN where an entry is not finite; 0 for an empty vector.
pub fn norm_inf(x: &[f64]) -> f64 {
    let mut max = [0.0_f64; LANES];
    let mut poison = [0.0; LANES];
    let chunks = x.chunks_exact(LANES);
    for (l, v) in chunks.remainder().iter().enumerate() {
        max[l] = v.abs();
        poison[l] = 0.0 * v;
    }
    for chunk in chunks {
        for l in 0..LANES {
            let size = chunk[l].abs();
            max[l] = if size > max[l] { size } else { max[l] };
            poison[l] += 0.0 * chunk[l];
        }
    }
    // A maximum passes over NaN, a sum does not.
    max.iter().fold(0.0, |m: f64, v| m.max(*v)) + poison.iter().sum::<f64>()
}

/// The `i`-th of a fixed sequence of signs that looks random, as ±1.
pub(crate) fn pseudo_random_sign(i: usize) -> f64 {
    // splitmix64
    let mut z = (i as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (z ^ (z >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_tell_of_numbers_that_are_not_finite() {
        let x: Vec<f64> = (0..37).map(|i| 20.0 - f64::from(i)).collect();
        assert_eq!((norm_inf(&x), norm_inf(&x[..3]), norm_inf(&[])), (20.0, 20.0, 0.0));
        for at in 0..x.len() {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut y = x.clone();
                y[at] = bad;
                assert!(norm_inf(&y).is_nan(), "{bad} at {at}");
            }
        }
    }

    #[test]
    fn dot_of_known_vectors() {
        let x: Vec<f64> = (0..10_007).map(|i| i as f64).collect();
        let y = vec![2.0; x.len()];
        assert_eq!(dot(&x, &y), 10_007.0 * 10_006.0);
    }

    /// The threads change no bit.
    #[test]
    fn long_vectors_are_summed_in_the_order_of_short_ones() {
        let n = LONG + CHUNK + 3;
        let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut y: Vec<f64> = (0..n).map(|i| (3.0 * i as f64).cos()).collect();
        let sums = x.chunks(CHUNK).zip(y.chunks(CHUNK)).map(|(x, y)| dot(x, y));
        assert_eq!(dot(&x, &y), sums.sum::<f64>());
        let expected: Vec<f64> = x.iter().zip(&y).map(|(x, y)| y + 0.3 * x).collect();
        add_scaled(0.3, &x, &mut y);
        assert_eq!(y, expected);
    }

    #[test]
    fn norm_sees_what_is_not_finite() {
        assert_eq!(norm_inf(&[]), 0.0);
        assert_eq!(norm_inf(&[1.0, -3.0, 2.0]), 3.0);
        assert!(norm_inf(&[1.0, f64::NAN, 2.0]).is_nan());
        assert!(norm_inf(&[1.0, f64::NEG_INFINITY]).is_nan());
    }

    #[test]
    fn signs_have_no_pattern() {
        let x: Vec<f64> = (0..1000).map(pseudo_random_sign).collect();
        assert!(x.iter().sum::<f64>().abs() < 100.0);
        assert!(dot(&x[1..], &x[..999]).abs() < 100.0);
    }
}
