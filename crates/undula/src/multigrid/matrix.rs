//! Sparse matrices in 32 bits: those of the levels.

use crate::algebra::{Csr, Pattern};
use rayon::prelude::*;
use std::sync::Arc;

/// Rows per task.
const ROWS_PER_TASK: usize = 1024;

/// A matrix in 32 bits.
#[derive(Clone, Debug)]
pub struct Single {
    pattern: Arc<Pattern>,
    values: Vec<f32>,
}

impl Single {
    /// Zeros.
    pub fn zeros(pattern: &Arc<Pattern>) -> Single {
        Single { pattern: Arc::clone(pattern), values: vec![0.0; pattern.nnz()] }
    }

    /// Bytes of its entries and their columns.
    pub fn bytes(&self) -> usize {
        8 * self.values.len()
    }

    /// Take the entries of `a`.
    pub fn take(&mut self, a: &Csr) {
        self.values
            .par_iter_mut()
            .with_min_len(1 << 16)
            .zip(&a.values)
            .for_each(|(to, from)| *to = *from as f32);
    }

    /// Row `row` of b − A x.
    #[inline]
    pub fn residual_of(&self, row: usize, b: &[f32], x: &[f32]) -> f32 {
        let entries = self.pattern.row(row);
        b[row] - product(&self.pattern.col[entries.clone()], &self.values[entries], x)
    }

    /// `r ← b − A x`.
    pub fn residual(&self, b: &[f32], x: &[f32], r: &mut [f32]) {
        let rows = r.par_iter_mut().with_min_len(ROWS_PER_TASK).enumerate();
        rows.for_each(|(row, r)| *r = self.residual_of(row, b, x));
    }
}

/// The product of a row with `x`, summed in eight parts.
#[inline]
fn product(columns: &[u32], values: &[f32], x: &[f32]) -> f32 {
    let mut parts = [0.0_f32; 8];
    let (heads, tails) = (columns.chunks_exact(8), values.chunks_exact(8));
    let rest = heads.remainder().iter().zip(tails.remainder());
    let rest: f32 = rest.map(|(&column, value)| value * x[column as usize]).sum();
    for (columns, values) in heads.zip(tails) {
        for i in 0..8 {
            parts[i] += values[i] * x[columns[i] as usize];
        }
    }
    parts.iter().sum::<f32>() + rest
}
