//! Sparse matrices of the levels.

use super::number::Number;
use crate::algebra::{Csr, Pattern, Value};
use rayon::prelude::*;
use std::sync::Arc;

/// Products that are summed side by side.
const WIDTH: usize = 16;

/// A matrix, its own or one that it shares. Rows of a node have the same columns, which are read once for them.
#[derive(Clone, Debug)]
pub struct Matrix<T>(Option<Arc<Csr<T>>>);

impl<T: Number> Matrix<T> {
    /// None yet.
    pub const fn none() -> Matrix<T> {
        Matrix(None)
    }

    /// Bytes of its entries and of the columns that are read, if it is one of `pattern`.
    pub fn bytes(pattern: &Pattern) -> usize {
        size_of::<T>() * pattern.nnz() + 4 * pattern.nnz() / 3
    }

    /// Take the entries of `a`.
    pub fn take<S: Value>(&mut self, a: &Csr<S>) {
        let own = self.0.get_or_insert_with(|| Arc::new(Csr::blank(&a.pattern)));
        let values = &mut Arc::make_mut(own).values;
        let entries = values.par_iter_mut().with_min_len(1 << 16).zip(&a.values);
        entries.for_each(|(to, from)| *to = T::of(from.double()));
    }

    /// Share `a`, or let go of what was shared.
    pub fn hold(&mut self, a: Option<Arc<Csr<T>>>) {
        self.0 = a;
    }

    /// The rows `list` of b − A x, into `r`; to be called where vectors are in use.
    #[inline(always)]
    pub fn residual_of(&self, list: &[u32], b: &[T], x: &[T], r: &mut [T]) {
        let Some(a) = &self.0 else { return };
        let mut at = 0;
        while at < list.len() {
            let row = list[at] as usize;
            let rows = row..a.pattern.end_of_alike(row);
            let there = list[at..].iter().zip(rows).take_while(|(listed, row)| **listed as usize == *row);
            let len = there.count();
            residual(a, row..row + len, b, x, &mut r[at..at + len]);
            at += len;
        }
    }
}

/// Rows of b − A x that have the same columns.
#[inline(always)]
fn residual<T: Number>(a: &Csr<T>, rows: std::ops::Range<usize>, b: &[T], x: &[T], r: &mut [T]) {
    let at = a.pattern.row(rows.start);
    let (columns, b) = (a.pattern.columns(rows.start), &b[rows.clone()]);
    let values = &a.values[at.start..at.start + rows.len() * at.len()];
    match rows.len() {
        3 => subtract(b, product::<T, 3>(columns, values, x), r),
        2 => subtract(b, product::<T, 2>(columns, values, x), r),
        _ => subtract(b, product::<T, 1>(columns, values, x), r),
    }
}

/// `r ← b − y`.
#[inline(always)]
fn subtract<T: Number, const K: usize>(b: &[T], y: [T; K], r: &mut [T]) {
    for i in 0..K {
        r[i] = b[i] - y[i];
    }
}

/// The products of rows of the same columns with `x`.
#[inline(always)]
fn product<T: Number, const K: usize>(columns: &[u32], values: &[T], x: &[T]) -> [T; K] {
    let rows: [&[T]; K] = std::array::from_fn(|i| &values[i * columns.len()..(i + 1) * columns.len()]);
    let mut parts = [[T::default(); WIDTH]; K];
    let whole = columns.len() / WIDTH * WIDTH;
    for at in (0..whole).step_by(WIDTH) {
        let here = &columns[at..at + WIDTH];
        let x: [T; WIDTH] = std::array::from_fn(|l| x[here[l] as usize]);
        for i in 0..K {
            let row = &rows[i][at..at + WIDTH];
            for l in 0..WIDTH {
                parts[i][l] += row[l] * x[l];
            }
        }
    }
    let mut sums = parts.map(|parts| parts.iter().copied().sum::<T>());
    for at in whole..columns.len() {
        let x = x[columns[at] as usize];
        for i in 0..K {
            sums[i] += rows[i][at] * x;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Groups of one, two and three rows, and more than three of the same columns.
    #[test]
    fn the_residual_is_that_of_the_matrix() {
        let n = 90_u32;
        let same = |row: u32| match row % 9 {
            0..3 => 0,
            3..5 => 3,
            5 => 5,
            _ => 6,
        };
        let columns = |row: u32| {
            let of = row / 9 * 9 + same(row);
            (0..n).filter(move |column| (column * 7 + of).is_multiple_of(2 + same(row))).chain([of])
        };
        let rows: Vec<Vec<u32>> = (0..n).map(|row| columns(row).collect()).collect();
        let pattern = Arc::new(Pattern::from_rows(&rows));
        let mut a = Csr::zeros(&pattern);
        a.values.iter_mut().enumerate().for_each(|(at, value)| *value = (at as f64).sin());
        let mut single = Matrix::<f32>::none();
        single.take(&a);
        let x: Vec<f64> = (0..n).map(|i| f64::from(i).cos()).collect();
        let b: Vec<f64> = (0..n).map(|i| (0.1 * f64::from(i)).exp().recip()).collect();
        let mut exact = vec![0.0; n as usize];
        a.residual(&b, &x, &mut exact);
        let short = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<f32>>();
        let all: Vec<u32> = (0..n).collect();
        let mut r = vec![0.0; n as usize];
        single.residual_of(&all, &short(&b), &short(&x), &mut r);
        let close = |r: f32, exact: f64| assert!((f64::from(r) - exact).abs() < 1e-5, "{r} {exact}");
        r.iter().zip(&exact).for_each(|(r, exact)| close(*r, *exact));
        // A list of rows: a whole group, a part of one, rows that turn back.
        let list = [9, 10, 11, 1, 2, 4, 3, 5, 6, 7, 8, 12, 13];
        let mut r = vec![0.0; list.len()];
        single.residual_of(&list, &short(&b), &short(&x), &mut r);
        r.iter().zip(list).for_each(|(r, row)| close(*r, exact[row as usize]));
    }
}
