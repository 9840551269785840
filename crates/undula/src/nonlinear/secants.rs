//! Corrections improved by what earlier ones have shown.
//!
//! With a Jacobian that is old or incomplete, z(x) = P r(x) is not the Newton correction. Differences
//! Δx of iterates and Δz of their corrections tell, for a few directions, what it should have been: the
//! combination z + Σ β_j Δz_j of least norm is what is left, and its Δx_j are known. This is the multi-secant
//! (Anderson, interface quasi-Newton) update; pairs stay over time steps as long as P does
//! (Degroote, Bathe and Vierendeels, Comput. Struct. 87, 2009; Walker and Ni, SIAM J. Numer. Anal. 49, 2011).

use crate::algebra::dot;

/// Share of a Δz that must be new against the others for it to be used.
const INDEPENDENT: f64 = 1e-4;

/// Pairs of differences under one P.
#[derive(Clone, Debug, Default)]
pub struct Secants {
    depth: usize,
    /// Entries of a vector that the norm sees: its first ones.
    measured: usize,
    /// Δz, measured part, newest last.
    dz: Vec<Vec<f64>>,
    /// Δz − Δx.
    both: Vec<Vec<f64>>,
    /// Products of the Δz.
    gram: Vec<Vec<f64>>,
    /// Correction and update of the last iterate, if the next one completes a pair.
    last: Option<(Vec<f64>, Vec<f64>)>,
}

impl Secants {
    /// Keep `depth` pairs; the norm sees the first `measured` entries.
    pub fn new(depth: usize, measured: usize) -> Secants {
        Secants { depth, measured, ..Secants::default() }
    }

    /// Forget all pairs, as for a new P.
    pub fn clear(&mut self) {
        self.dz.clear();
        self.both.clear();
        self.gram.clear();
        self.last = None;
    }

    /// The next correction belongs to another problem: no pair with the last one.
    pub fn cut(&mut self) {
        self.last = None;
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.dz.len()
    }

    /// Whether there is no pair.
    pub fn is_empty(&self) -> bool {
        self.dz.is_empty()
    }

    /// Improve the correction `z` in place: the iterate will be x − z.
    pub fn improve(&mut self, z: &mut [f64]) {
        if self.depth == 0 {
            return;
        }
        let raw = z.to_vec();
        if let Some((before, update)) = self.last.take() {
            self.add(&raw, before, update);
        }
        if !self.is_empty() {
            let right: Vec<f64> = self.dz.iter().map(|dz| -dot(dz, &z[..self.measured])).collect();
            let beta = least_squares(&self.gram, &right);
            for (both, beta) in self.both.iter().zip(beta).filter(|(_, beta)| *beta != 0.0) {
                for (z, both) in z.iter_mut().zip(both) {
                    *z += beta * both;
                }
            }
        }
        self.last = Some((raw, z.to_vec()));
    }

    /// The pair of the last update: Δx = −update, Δz = z − before.
    fn add(&mut self, z: &[f64], before: Vec<f64>, update: Vec<f64>) {
        if self.dz.len() == self.depth {
            self.dz.remove(0);
            self.both.remove(0);
            self.gram.remove(0);
            self.gram.iter_mut().for_each(|row| {
                row.remove(0);
            });
        }
        let dz: Vec<f64> = z.iter().zip(&before).map(|(z, b)| z - b).collect();
        let both = dz.iter().zip(&update).map(|(dz, u)| dz + u).collect();
        let dz = dz[..self.measured].to_vec();
        let mut row: Vec<f64> = self.dz.iter().map(|other| dot(other, &dz)).collect();
        row.push(dot(&dz, &dz));
        for (other, product) in self.gram.iter_mut().zip(&row) {
            other.push(*product);
        }
        self.gram.push(row);
        self.dz.push(dz);
        self.both.push(both);
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
