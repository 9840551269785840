//! What the machine can do: bandwidths and dense products.

use super::median;
use faer::linalg::matmul::matmul;
use faer::traits::ComplexField;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// Measurements of each rate.
const PASSES: usize = 11;

/// Entries of each of the three arrays of the triad, 64 MiB.
const TRIAD: usize = 8 << 20;

/// Entries that are read, 256 MiB.
const READ: usize = 32 << 20;

/// Rows and columns of the factors of a product.
const PRODUCT: usize = 768;

/// A rate by number of threads.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
pub struct Rates {
    /// One thread.
    pub one_thread: f64,
    /// All that the simulation has.
    pub all_threads: f64,
}

/// Rates of the machine; medians.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// a = b + s c on arrays of 64 MiB, 24 bytes per entry \[B/s\].
    pub triad: Rates,
    /// Sum of 256 MiB \[B/s\].
    pub read: Rates,
    /// Product of 768 × 768 matrices in double precision on one thread \[flop/s\].
    pub product_double: f64,
    /// The same in single precision.
    pub product_single: f64,
}

impl Machine {
    /// Measure, within a pool of `threads` threads.
    pub(super) fn measure(threads: usize) -> Machine {
        Machine {
            triad: triad(threads),
            read: read(threads),
            product_double: product::<f64>(),
            product_single: product::<f32>(),
        }
    }
}

/// `amount` over the median time of `work`; the first time does not count.
fn rate(amount: usize, mut work: impl FnMut()) -> f64 {
    let mut seconds = vec![];
    for _ in 0..=PASSES {
        let begun = Instant::now();
        work();
        seconds.push(begun.elapsed().as_secs_f64());
    }
    amount as f64 / median(&seconds[1..])
}

fn triad(threads: usize) -> Rates {
    // Zeros would share one page.
    let (mut a, b, c) = (vec![1.0; TRIAD], vec![2.0; TRIAD], vec![3.0; TRIAD]);
    let mut on = |threads: usize| {
        let size = TRIAD.div_ceil(threads);
        rate(24 * TRIAD, || {
            let s = black_box(0.5);
            let parts = a.par_chunks_mut(size).zip(b.par_chunks(size)).zip(c.par_chunks(size));
            parts.for_each(|((a, b), c)| {
                for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                    *a = b + s * c;
                }
            });
            black_box(&a);
        })
    };
    Rates { one_thread: on(1), all_threads: on(threads) }
}

fn read(threads: usize) -> Rates {
    let a = vec![1.0; READ];
    let on = |threads: usize| {
        let parts = a.par_chunks(READ.div_ceil(threads));
        rate(8 * READ, || {
            black_box(parts.clone().map(sum).sum::<f64>());
        })
    };
    Rates { one_thread: on(1), all_threads: on(threads) }
}

/// A sum in many parts, so that no addition waits for another.
fn sum(a: &[f64]) -> f64 {
    let mut parts = [0.0; 8];
    for chunk in a.as_chunks::<8>().0 {
        for (part, x) in parts.iter_mut().zip(chunk) {
            *part += x;
        }
    }
    parts.iter().sum()
}

fn product<T: ComplexField + From<f32>>() -> f64 {
    let matrix = |phase: f32| {
        Mat::<T>::from_fn(PRODUCT, PRODUCT, |i, j| T::from((i as f32 + 3.0 * j as f32 + phase).sin()))
    };
    let (a, b) = (matrix(0.0), matrix(1.0));
    let mut c = Mat::<T>::zeros(PRODUCT, PRODUCT);
    rate(2 * PRODUCT.pow(3), || {
        matmul(c.as_mut(), Accum::Replace, a.as_ref(), b.as_ref(), T::from(1.0), Par::Seq);
        black_box(&c);
    })
}
