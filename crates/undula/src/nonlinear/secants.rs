//! Corrections improved by what earlier ones have shown.
//!
//! With a Jacobian that is old or incomplete, z(x) = P r(x) is not the Newton correction. Differences
//! Δx of iterates and Δz of their corrections tell, for a few directions, what it should have been: the
//! combination z + Σ β_j Δz_j of least norm is what is left, and its Δx_j are known. This is the multi-secant
//! (Anderson, interface quasi-Newton) update. Pairs are forgotten with the step: kept longer they saved no iteration
//! of fsi3 (Degroote, Bathe and Vierendeels, Comput. Struct. 87, 2009; Walker and Ni, SIAM J. Numer. Anal. 49, 2011).
//!
//! Off by default. Measured on 2026-11-29: 100 steps of fsi3 with 0, 2, 4 and 8 pairs, `undula run fsi3 --set
//! newton.secants=N --set time.end=0.5` and more settings, Newton iterations with the number of Jacobians.
//! Strong motion: `mesh.refine=0`, `solid.body-force=[0,-8]`, inflow times `ramp(t, 0.2)` instead of `ramp(t, 2)`.
//!
//! | | 0 | 2 | 4 | 8 |
//! | --- | --- | --- | --- | --- |
//! | from rest, default | 223 (9) | 223 (9) | 223 (9) | 223 (9) |
//! | `newton.linearization=newton` | 306 (1) | 306 (1) | 306 (1) | 306 (1) |
//! | `newton.rate-max=0.5` | 307 (1) | 307 (1) | 307 (1) | 307 (1) |
//! | both | 306 (1) | 306 (1) | 306 (1) | 306 (1) |
//! | strong motion, default | 595 (19) | 544 (13) | 541 (13) | 541 (13) |
//! | `newton.linearization=newton` | 532 (13) | 530 (14) | 527 (14) | 527 (14) |
//! | `newton.rate-max=0.5` | 928 (5) | 805 (5) | 786 (5) | 733 (5) |
//! | both | 802 (5) | 621 (9) | 859 (5) | 654 (7) |
//!
//! From rest they change nothing. In strong motion they save a tenth of the iterations with the rule of prices, and up
//! to a fifth with a given rate. The least user times of five runs in strong motion (one thread, busy machine) are
//! 0.48, 0.40, 0.46 and 0.42 s by default, 0.46, 0.46, 0.47 and 0.45 s with `newton.rate-max=0.5`, and 1.14, 0.96,
//! 1.27 and 0.97 s with both. In developed motion they save no time: `validation/performance.md`.

use crate::algebra::dot;
use rayon::prelude::*;

/// Share of a Δz that must be new against the others for it to be used.
const INDEPENDENT: f64 = 1e-4;

/// Entries that are in the cache while all pairs are added to them.
const CHUNK: usize = 1024;

/// Chunks that are worth a thread's while.
const MANY: usize = 32;

/// Pairs of differences under one P. Their memory is taken once.
#[derive(Clone, Debug, Default)]
pub struct Secants {
    depth: usize,
    /// Entries of a vector that the norm sees: its first ones.
    measured: usize,
    /// Pairs in use, newest last.
    pairs: Vec<Pair>,
    /// Memory of others.
    spare: Vec<Pair>,
    /// Products of the Δz.
    gram: Vec<Vec<f64>>,
    /// Correction and update of the last iterate.
    last: Pair,
    /// Whether the next correction completes a pair with them.
    complete: bool,
}

/// First the correction and update of an iterate, then Δz and Δz − Δx.
#[derive(Clone, Debug, Default)]
struct Pair {
    z: Vec<f64>,
    update: Vec<f64>,
}

impl Secants {
    /// Keep `depth` pairs; the norm sees the first `measured` entries.
    pub fn new(depth: usize, measured: usize) -> Secants {
        Secants { depth, measured, ..Secants::default() }
    }

    /// Forget all pairs, as for a new P or another problem.
    pub fn clear(&mut self) {
        self.spare.append(&mut self.pairs);
        self.gram.clear();
        self.complete = false;
    }

    /// Improve the correction `z` in place: the iterate will be x − z.
    pub fn improve(&mut self, z: &mut [f64]) {
        if self.depth == 0 {
            return;
        }
        if self.complete {
            self.add(z);
        }
        let of = |pair: &Pair| -dot(&pair.z[..self.measured], &z[..self.measured]);
        let right: Vec<f64> = self.pairs.iter().map(of).collect();
        let beta = least_squares(&self.gram, &right);
        let used = || self.pairs.iter().zip(&beta).filter(|(_, beta)| **beta != 0.0);
        let Pair { z: before, update } = &mut self.last;
        before.resize(z.len(), 0.0);
        update.resize(z.len(), 0.0);
        let chunks =
            z.par_chunks_mut(CHUNK).zip(before.par_chunks_mut(CHUNK)).zip(update.par_chunks_mut(CHUNK));
        chunks.with_min_len(MANY).enumerate().for_each(|(c, ((z, before), update))| {
            before.copy_from_slice(z);
            for (pair, beta) in used() {
                for (z, update) in z.iter_mut().zip(&pair.update[c * CHUNK..]) {
                    *z += beta * update;
                }
            }
            update.copy_from_slice(z);
        });
        self.complete = true;
    }

    /// The pair of the last update: Δx = −update, Δz = z − before.
    fn add(&mut self, z: &[f64]) {
        if self.pairs.len() == self.depth {
            self.spare.push(self.pairs.remove(0));
            self.gram.remove(0);
            for row in &mut self.gram {
                row.remove(0);
            }
        }
        let mut pair = std::mem::replace(&mut self.last, self.spare.pop().unwrap_or_default());
        let chunks =
            pair.z.par_chunks_mut(CHUNK).zip(pair.update.par_chunks_mut(CHUNK)).zip(z.par_chunks(CHUNK));
        chunks.with_min_len(MANY).for_each(|((before, update), z)| {
            for ((before, update), z) in before.iter_mut().zip(update).zip(z) {
                *before = z - *before;
                *update += *before;
            }
        });
        let product = |other: &Pair| dot(&other.z[..self.measured], &pair.z[..self.measured]);
        let mut row: Vec<f64> = self.pairs.iter().map(product).collect();
        row.push(product(&pair));
        for (other, product) in self.gram.iter_mut().zip(&row) {
            other.push(*product);
        }
        self.gram.push(row);
        self.pairs.push(pair);
    }
}

/// Coefficients of the least-squares problem with Gram matrix `gram`; the newest columns are taken first,
/// and those that depend on them get 0.
fn least_squares(gram: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let n = gram.len();
    let order: Vec<usize> = (0..n).rev().collect();
    // Cholesky, leaving out columns with nothing of their own.
    let mut used: Vec<usize> = vec![];
    let mut factor: Vec<Vec<f64>> = vec![];
    for &j in &order {
        let mut row = vec![];
        for (a, &i) in used.iter().enumerate() {
            let known: f64 = row.iter().zip(&factor[a]).map(|(x, y): (&f64, &f64)| x * y).sum();
            row.push((gram[j][i] - known) / factor[a][a]);
        }
        let rest = gram[j][j] - row.iter().map(|x| x * x).sum::<f64>();
        if rest > INDEPENDENT * INDEPENDENT * gram[j][j] && rest > 0.0 {
            row.push(rest.sqrt());
            used.push(j);
            factor.push(row);
        }
    }
    let m = used.len();
    let mut y = vec![0.0; m];
    for a in 0..m {
        let known: f64 = (0..a).map(|b| factor[a][b] * y[b]).sum();
        y[a] = (right[used[a]] - known) / factor[a][a];
    }
    for a in (0..m).rev() {
        let known: f64 = (a + 1..m).map(|b| factor[b][a] * y[b]).sum();
        y[a] = (y[a] - known) / factor[a][a];
    }
    let mut beta = vec![0.0; n];
    used.iter().zip(y).for_each(|(&j, y)| beta[j] = y);
    beta
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P J = I + a matrix of rank two: three corrections, and the fourth is exact.
    #[test]
    fn directions_once_seen_are_solved_for() {
        let n = 20;
        let (a, b): (Vec<f64>, Vec<f64>) = (0..n).map(|i| ((i as f64).sin(), (1.7 * i as f64).cos())).unzip();
        let solution: Vec<f64> = (0..n).map(|i| 1.0 / (1.0 + i as f64)).collect();
        let mut x = vec![0.0; n];
        let mut secants = Secants::new(4, n);
        let mut errors = vec![];
        for _ in 0..5 {
            let e: Vec<f64> = x.iter().zip(&solution).map(|(x, s)| x - s).collect();
            errors.push(dot(&e, &e).sqrt());
            let (along_a, along_b) = (0.3 * dot(&a, &e), 0.2 * dot(&b, &e));
            let mut z: Vec<f64> = (0..n).map(|i| e[i] + along_a * b[i] + along_b * a[i]).collect();
            secants.improve(&mut z);
            x.iter_mut().zip(&z).for_each(|(x, z)| *x -= z);
        }
        assert!(errors[4] < 1e-12 * errors[0], "{errors:?}");
        assert!(errors[3] > 1e-6 * errors[0], "too easy: {errors:?}");
    }
}
