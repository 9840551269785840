//! Square sparse matrices by rows.

use rayon::prelude::*;
use std::sync::Arc;

/// Rows per task of [`Csr::mul`].
const ROWS_PER_TASK: usize = 2048;

/// Where a square matrix may be non-zero: compressed rows with sorted columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// Number of rows and of columns.
    pub n: usize,
    /// Row `i` has its columns at `row_ptr[i]..row_ptr[i + 1]` of `col`; `n + 1` numbers.
    pub row_ptr: Vec<usize>,
    /// Columns, increasing within each row.
    pub col: Vec<u32>,
}

/// Adds a column to those of a row of [`Pattern::from_rows`]; repetitions are taken out before the list grows.
pub fn add_column(row: &mut Vec<u32>, column: u32) {
    if row.len() == row.capacity() && row.len() >= 32 {
        row.sort_unstable();
        row.dedup();
        if row.len() > row.capacity() / 4 * 3 {
            row.reserve(row.capacity());
        }
    }
    row.push(column);
}

impl Pattern {
    /// The pattern with the given columns in each row, in any order and with repetitions.
    ///
    /// # Panics
    /// If a column is not less than the number of rows, or this does not fit in 32 bits.
    pub fn from_rows<R: AsRef<[u32]>>(rows: &[R]) -> Self {
        let n = rows.len();
        assert!(u32::try_from(n).is_ok(), "too many rows: {n}");
        let mut row_ptr = Vec::with_capacity(n + 1);
        row_ptr.push(0);
        let mut col = Vec::with_capacity(rows.iter().map(|r| r.as_ref().len()).sum());
        let mut sorted = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            sorted.clear();
            sorted.extend_from_slice(row.as_ref());
            sorted.sort_unstable();
            sorted.dedup();
            if let Some(&last) = sorted.last() {
                assert!((last as usize) < n, "row {i} has column {last}, but there are {n} rows");
            }
            col.extend_from_slice(&sorted);
            row_ptr.push(col.len());
        }
        col.shrink_to_fit();
        Self { n, row_ptr, col }
    }

    /// Number of stored entries.
    pub fn nnz(&self) -> usize {
        self.col.len()
    }

    /// Position of entry (`row`, `col`) in `col` and in [`Csr::values`]; `None` where nothing is stored.
    ///
    /// # Panics
    /// If `row` is not a row.
    pub fn find(&self, row: usize, col: usize) -> Option<usize> {
        let start = self.row_ptr[row];
        let columns = &self.col[start..self.row_ptr[row + 1]];
        let col = u32::try_from(col).ok()?;
        columns.binary_search(&col).ok().map(|k| start + k)
    }

    /// Positions of the entries of a row in `col` and in [`Csr::values`].
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.row_ptr[row]..self.row_ptr[row + 1]
    }
}

/// Square sparse matrix by rows; the pattern is shared, the values are its own.
#[derive(Debug, Clone)]
pub struct Csr {
    /// Where the values are.
    pub pattern: Arc<Pattern>,
    /// One value per entry of the pattern.
    pub values: Vec<f64>,
}

impl Csr {
    /// The matrix with zeros on the pattern.
    pub fn zeros(pattern: &Arc<Pattern>) -> Self {
        Self { pattern: Arc::clone(pattern), values: vec![0.0; pattern.nnz()] }
    }

    /// Product `y = A x`, with each row summed from left to right.
    ///
    /// # Panics
    /// If `x` or `y` has not `n` entries.
    pub fn mul(&self, x: &[f64], y: &mut [f64]) {
        self.for_rows(x, y, |y, sum| *y = sum);
    }

    /// Residual `r = b − A x`, with each row of the product summed from left to right.
    ///
    /// # Panics
    /// If `b`, `x` or `r` has not `n` entries.
    pub fn residual(&self, b: &[f64], x: &[f64], r: &mut [f64]) {
        r.copy_from_slice(b);
        self.for_rows(x, r, |r, sum| *r -= sum);
    }

    /// Product `y = A x` and the largest sum `scale[i] Σ |A[i, j] x[j]|` of its absolute terms.
    ///
    /// # Panics
    /// If `x`, `y` or `scale` has not `n` entries.
    pub fn mul_with_norm(&self, scale: &[f64], x: &[f64], y: &mut [f64]) -> f64 {
        let Pattern { n, row_ptr, col } = &*self.pattern;
        assert_eq!((x.len(), y.len(), scale.len()), (*n, *n, *n), "vectors do not fit the matrix");
        let rows = y.par_chunks_mut(ROWS_PER_TASK).zip(scale.par_chunks(ROWS_PER_TASK)).enumerate();
        let of_task = |(task, (y, scale)): (usize, (&mut [f64], &[f64]))| {
            let mut max = 0.0_f64;
            for ((y, scale), at) in y.iter_mut().zip(scale).zip(row_ptr[task * ROWS_PER_TASK..].windows(2)) {
                let (mut sum, mut size) = (0.0, 0.0);
                for (&j, v) in col[at[0]..at[1]].iter().zip(&self.values[at[0]..at[1]]) {
                    let term = v * x[j as usize];
                    sum += term;
                    size += term.abs();
                }
                *y = sum;
                max = max.max(scale * size);
            }
            max
        };
        rows.map(of_task).reduce(|| 0.0, f64::max)
    }

    /// Whether the pattern is symmetric, and a_ij and a_ji differ by no more than `tolerance` times √|a_ii a_jj|.
    pub fn is_symmetric(&self, tolerance: f64) -> bool {
        let Pattern { n, row_ptr, col } = &*self.pattern;
        let diagonal: Option<Vec<usize>> = (0..*n).map(|i| self.pattern.find(i, i)).collect();
        let Some(diagonal) = diagonal else { return false };
        let size: Vec<f64> = diagonal.iter().map(|&at| self.values[at].abs().sqrt()).collect();
        // Rows come in their order: the next entry right of the diagonal of row j belongs to the next row with a
        // column j.
        let mut next: Vec<usize> = diagonal.iter().map(|at| at + 1).collect();
        for i in 0..*n {
            for at in row_ptr[i]..diagonal[i] {
                let j = col[at] as usize;
                let mirror = next[j];
                next[j] += 1;
                let there = mirror < row_ptr[j + 1] && col[mirror] as usize == i;
                let is_alike =
                    there && (self.values[at] - self.values[mirror]).abs() <= tolerance * size[i] * size[j];
                if !is_alike {
                    return false;
                }
            }
        }
        (0..*n).all(|j| next[j] == row_ptr[j + 1])
    }

    fn for_rows(&self, x: &[f64], y: &mut [f64], put: impl Fn(&mut f64, f64) + Sync) {
        let Pattern { n, row_ptr, col } = &*self.pattern;
        assert_eq!((x.len(), y.len()), (*n, *n), "vectors do not fit the matrix");
        y.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, y)| {
            let first = task * ROWS_PER_TASK;
            for (y, at) in y.iter_mut().zip(row_ptr[first..].windows(2)) {
                let (col, value) = (&col[at[0]..at[1]], &self.values[at[0]..at[1]]);
                put(y, col.iter().zip(value).map(|(&j, v)| v * x[j as usize]).sum());
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pattern_sorts_and_finds() {
        let p = Pattern::from_rows(&[vec![2, 0, 2], vec![1], vec![]]);
        assert_eq!(p, Pattern { n: 3, row_ptr: vec![0, 2, 3, 3], col: vec![0, 2, 1] });
        assert_eq!((p.nnz(), p.find(0, 2), p.find(0, 1), p.find(2, 2)), (3, Some(1), None, None));
    }

    #[test]
    fn product_and_residual() {
        let pattern = Arc::new(Pattern::from_rows(&[[0, 1], [0, 1]]));
        let a = Csr { pattern, values: vec![1.0, 2.0, 3.0, 4.0] };
        let (mut y, mut r) = ([0.0; 2], [0.0; 2]);
        a.mul(&[1.0, -1.0], &mut y);
        a.residual(&[1.0, 1.0], &[1.0, -1.0], &mut r);
        assert_eq!((y, r), ([-1.0, -1.0], [2.0, 2.0]));
        let norm = a.mul_with_norm(&[1.0, 0.5], &[1.0, -1.0], &mut y);
        assert_eq!((y, norm), ([-1.0, -1.0], 3.5));
    }
}
