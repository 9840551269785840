//! Prolongation of corrections from a coarser level, restriction of residuals to it, and the coarser matrix P ᵀ A P.

use super::lists::Lists;
use super::number::Number;
use crate::algebra::{Csr, Pattern, Value};
use rayon::prelude::*;
use std::sync::Arc;

/// Rows per task.
const ROWS_PER_TASK: usize = 512;

/// The prolongation P from a coarser level.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Entries of each row of P: coarser unknown, weight.
    rows: Lists<(u32, f32)>,
    /// Entries of each column of P: finer unknown, weight.
    columns: Lists<(u32, f32)>,
}

/// A sparse vector that is summed up: dense, with a list of the places that are not zero.
struct Sum {
    values: Vec<f64>,
    is_set: Vec<bool>,
    set: Vec<u32>,
}

impl Sum {
    fn new(n: usize) -> Sum {
        Sum { values: vec![0.0; n], is_set: vec![false; n], set: vec![] }
    }

    fn add(&mut self, at: u32, value: f64) {
        let place = at as usize;
        if !self.is_set[place] {
            (self.is_set[place], self.values[place]) = (true, 0.0);
            self.set.push(at);
        }
        self.values[place] += value;
    }

    fn clear(&mut self) {
        self.set.drain(..).for_each(|at| self.is_set[at as usize] = false);
    }
}

impl Transfer {
    /// From the rows of P, with `n` columns.
    pub fn new(rows: Lists<(u32, f32)>, n: usize) -> Transfer {
        Transfer::of_own(rows, n, |_| true)
    }

    /// The same where Pᵀ has only the columns of finer unknowns that are `own` ones.
    pub fn of_own(rows: Lists<(u32, f32)>, n: usize, own: impl Fn(usize) -> bool) -> Transfer {
        let mut lists: Vec<Vec<(u32, f32)>> = vec![vec![]; n];
        for (fine, row) in rows.iter().enumerate().filter(|(fine, _)| own(*fine)) {
            row.iter().for_each(|&(coarse, weight)| lists[coarse as usize].push((fine as u32, weight)));
        }
        let mut columns = Lists::default();
        lists.into_iter().for_each(|list| columns.push(list));
        Transfer { rows, columns }
    }

    /// Bytes of P.
    pub fn bytes(&self) -> usize {
        size_of_val(self.rows.items())
    }

    /// Number of unknowns of the finer level, and of the coarser one.
    pub fn sizes(&self) -> [usize; 2] {
        [self.rows.len(), self.columns.len()]
    }

    /// `x ← x + P c`.
    pub fn prolong<T: Number>(&self, c: &[T], x: &mut [T]) {
        x.par_iter_mut().with_min_len(ROWS_PER_TASK).enumerate().for_each(|(fine, x)| {
            let weighted = |&(coarse, w): &(u32, f32)| T::of(f64::from(w)) * c[coarse as usize];
            *x += self.rows.get(fine).iter().map(weighted).sum::<T>();
        });
    }

    /// `b ← Pᵀ r`.
    pub fn restrict<T: Number>(&self, r: &[T], b: &mut [T]) {
        b.par_iter_mut().with_min_len(ROWS_PER_TASK).enumerate().for_each(|(coarse, b)| {
            let weighted = |&(fine, w): &(u32, f32)| T::of(f64::from(w)) * r[fine as usize];
            *b = self.columns.get(coarse).iter().map(weighted).sum::<T>();
        });
    }

    /// The pattern of Pᵀ A P for matrices A of `pattern`.
    pub fn pattern(&self, pattern: &Pattern) -> Pattern {
        let [_, n] = self.sizes();
        let sums = || (Sum::new(pattern.n), Sum::new(n));
        let rows: Vec<Vec<u32>> = (0..n)
            .into_par_iter()
            .with_min_len(ROWS_PER_TASK)
            .map_init(sums, |(fine, coarse), row| {
                for &(at, _) in self.columns.get(row) {
                    pattern.columns(at as usize).iter().for_each(|&column| fine.add(column, 0.0));
                }
                for &column in &fine.set {
                    self.rows.get(column as usize).iter().for_each(|&(at, _)| coarse.add(at, 0.0));
                }
                fine.clear();
                let columns = coarse.set.clone();
                coarse.clear();
                columns
            })
            .collect();
        Pattern::from_rows(&rows)
    }

    /// Pᵀ A P on its `pattern`.
    pub fn galerkin<S: Value>(&self, a: &Csr<S>, pattern: &Arc<Pattern>) -> Csr {
        let mut product = Csr::zeros(pattern);
        let [n, m] = self.sizes();
        let mut parts = vec![];
        let mut rest = &mut product.values[..];
        for start in (0..m).step_by(ROWS_PER_TASK) {
            let rows = start..(start + ROWS_PER_TASK).min(m);
            let (part, behind) = rest.split_at_mut(pattern.row_ptr[rows.end] - pattern.row_ptr[rows.start]);
            parts.push((rows, part));
            rest = behind;
        }
        parts.into_par_iter().for_each_init(
            || (Sum::new(n), vec![0.0; m]),
            |(fine, coarse), (rows, part)| {
                let first = pattern.row_ptr[rows.start];
                for row in rows {
                    self.row_of_product(a, row, (fine, coarse));
                    for at in pattern.row(row) {
                        part[at - first] = std::mem::take(&mut coarse[pattern.column(row, at) as usize]);
                    }
                }
            },
        );
        product
    }

    fn row_of_product<S: Value>(&self, a: &Csr<S>, row: usize, (fine, coarse): (&mut Sum, &mut [f64])) {
        for &(at, weight) in self.columns.get(row) {
            let entries = a.pattern.row(at as usize);
            for (&column, value) in a.pattern.columns(at as usize).iter().zip(&a.values[entries]) {
                fine.add(column, f64::from(weight) * value.double());
            }
        }
        for &column in &fine.set {
            let value = fine.values[column as usize];
            for &(at, weight) in self.rows.get(column as usize) {
                coarse[at as usize] += f64::from(weight) * value;
            }
        }
        fine.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coarser_matrix_is_a_triple_product() {
        let (n, m) = (40, 13);
        let rows: Vec<Vec<u32>> =
            (0..n as u32).map(|i| vec![i, (7 * i + 3) % n as u32, (i + 1) % n as u32]).collect();
        let mut a = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
        a.values.iter_mut().enumerate().for_each(|(at, value)| *value = (at as f64).sin());
        let mut lists = Lists::default();
        let weight =
            |i: usize, j: usize| if (i + 2 * j).is_multiple_of(5) { 0.5 + (i % 3) as f32 } else { 0.0 };
        for i in 0..n {
            lists.push((0..m).map(|j| (j as u32, weight(i, j))).filter(|(_, w)| *w != 0.0));
        }
        let transfer = Transfer::new(lists, m);
        let pattern = Arc::new(transfer.pattern(&a.pattern));
        let product = transfer.galerkin(&a, &pattern);
        for column in 0..m {
            let unit: Vec<f64> = (0..m).map(|j| f64::from(u8::from(j == column))).collect();
            let fine: Vec<f64> = (0..n).map(|i| f64::from(weight(i, column))).collect();
            let (mut image, mut found) = (vec![0.0; n], vec![0.0; m]);
            a.mul(&fine, &mut image);
            product.mul(&unit, &mut found);
            for (j, found) in found.iter().enumerate() {
                let exact: f64 = (0..n).map(|i| f64::from(weight(i, j)) * image[i]).sum();
                assert!((found - exact).abs() < 1e-12, "{j} {column}");
            }
        }
    }
}
