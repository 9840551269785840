//! Square sparse matrices by rows.

use super::value::Value;
use rayon::prelude::*;
use std::sync::Arc;

/// Rows per task of [`Csr::mul`].
const ROWS_PER_TASK: usize = 2048;

/// Where a square matrix may be non-zero: compressed rows with sorted columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// Number of rows and of columns.
    pub n: usize,
    /// Row `i` has the entries `row_ptr[i]..row_ptr[i + 1]`; `n + 1` numbers.
    pub row_ptr: Vec<usize>,
    /// Where the columns of each row begin in `col`.
    first: Vec<usize>,
    /// Columns, increasing within each row; rows of a node, which have the same, share them.
    col: Vec<u32>,
    /// For each row how many have its columns from it on, one behind the other: those of a node do.
    alike: Vec<u8>,
}

/// Rows of the same columns that are taken together at most.
const ALIKE: usize = 3;

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
        let mut pattern = Pattern::empty(n);
        let mut sorted = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            sorted.clear();
            sorted.extend_from_slice(row.as_ref());
            sorted.sort_unstable();
            sorted.dedup();
            if let Some(&last) = sorted.last() {
                assert!((last as usize) < n, "row {i} has column {last}, but there are {n} rows");
            }
            pattern.push(&sorted);
        }
        pattern.finish()
    }

    /// Rows with their columns, increasing within each row, at `row_ptr[i]..row_ptr[i + 1]` of `col`.
    ///
    /// # Panics
    /// If `row_ptr` does not end with the number of columns.
    pub fn new(row_ptr: &[usize], col: &[u32]) -> Self {
        assert_eq!(row_ptr.last(), Some(&col.len()), "rows do not fit their columns");
        let mut pattern = Pattern::empty(row_ptr.len() - 1);
        row_ptr.windows(2).for_each(|at| pattern.push(&col[at[0]..at[1]]));
        pattern.finish()
    }

    /// Without rows, of which `n` will come.
    fn empty(n: usize) -> Self {
        let mut row_ptr = Vec::with_capacity(n + 1);
        row_ptr.push(0);
        Self { n: 0, row_ptr, first: Vec::with_capacity(n), col: vec![], alike: Vec::with_capacity(n) }
    }

    /// The next row.
    fn push(&mut self, columns: &[u32]) {
        let row = self.n;
        // Until all rows are there, for each row how many of the same columns are in front of it.
        let before = row.checked_sub(1).map_or(0, |last| usize::from(self.alike[last]) + 1);
        if row > 0 && before < ALIKE && self.columns(row - 1) == columns {
            self.first.push(self.first[row - 1]);
            self.alike.push(before as u8);
        } else {
            self.first.push(self.col.len());
            self.alike.push(0);
            self.col.extend_from_slice(columns);
        }
        self.row_ptr.push(self.row_ptr[row] + columns.len());
        self.n += 1;
    }

    fn finish(mut self) -> Self {
        self.col.shrink_to_fit();
        let mut behind = 0;
        for alike in self.alike.iter_mut().rev() {
            behind += 1;
            let before = std::mem::replace(alike, behind);
            if before == 0 {
                behind = 0;
            }
        }
        self
    }

    /// The columns of a row, increasing.
    #[inline(always)]
    pub fn columns(&self, row: usize) -> &[u32] {
        let first = self.first[row];
        &self.col[first..first + self.row(row).len()]
    }

    /// The column of an entry of a row.
    #[inline(always)]
    pub fn column(&self, row: usize, entry: usize) -> u32 {
        self.col[self.first[row] + entry - self.row_ptr[row]]
    }

    /// The columns of all entries, row after row.
    pub fn all_columns(&self) -> impl Iterator<Item = u32> {
        (0..self.n).flat_map(|row| self.columns(row).iter().copied())
    }

    /// Where rows from `row` on that have its columns end, three of them at most.
    #[inline(always)]
    pub(crate) fn end_of_alike(&self, row: usize) -> usize {
        row + usize::from(self.alike[row])
    }

    /// Number of stored entries.
    pub fn nnz(&self) -> usize {
        self.row_ptr[self.n]
    }

    /// Position of entry (`row`, `col`) in [`Csr::values`]; `None` where nothing is stored.
    ///
    /// # Panics
    /// If `row` is not a row.
    pub fn find(&self, row: usize, col: usize) -> Option<usize> {
        let col = u32::try_from(col).ok()?;
        self.columns(row).binary_search(&col).ok().map(|k| self.row_ptr[row] + k)
    }

    /// Positions of the entries of a row in [`Csr::values`].
    pub fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.row_ptr[row]..self.row_ptr[row + 1]
    }
}

/// Square sparse matrix by rows; the pattern is shared, the values are its own, in double precision or in single. Products
/// are summed in double precision.
#[derive(Debug, Clone)]
pub struct Csr<T = f64> {
    /// Where the values are.
    pub pattern: Arc<Pattern>,
    /// One value per entry of the pattern.
    pub values: Vec<T>,
}

impl<T: Value> Csr<T> {
    /// The matrix with zeros on the pattern, of any precision.
    pub fn blank(pattern: &Arc<Pattern>) -> Self {
        Self { pattern: Arc::clone(pattern), values: vec![T::default(); pattern.nnz()] }
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

    fn for_rows(&self, x: &[f64], y: &mut [f64], put: impl Fn(&mut f64, f64) + Sync) {
        let n = self.pattern.n;
        assert_eq!((x.len(), y.len()), (n, n), "vectors do not fit the matrix");
        y.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, y)| {
            let first = task * ROWS_PER_TASK;
            let mut row = 0;
            while row < y.len() {
                let end = y.len().min(self.pattern.end_of_alike(first + row) - first);
                let mut put =
                    |sums: &[f64]| y[row..end].iter_mut().zip(sums).for_each(|(y, sum)| put(y, *sum));
                match end - row {
                    3 => put(&self.sums::<3>(first + row, x)),
                    2 => put(&self.sums::<2>(first + row, x)),
                    _ => put(&self.sums::<1>(first + row, x)),
                }
                row = end;
            }
        });
    }

    /// The products with `x` of the rows from `row` on, which have the same columns.
    fn sums<const K: usize>(&self, row: usize, x: &[f64]) -> [f64; K] {
        let at = self.pattern.row(row);
        let (columns, len) = (self.pattern.columns(row), at.len());
        let rows: [&[T]; K] = std::array::from_fn(|i| &self.values[at.start + i * len..][..len]);
        let mut sums = [0.0; K];
        for (entry, &column) in columns.iter().enumerate() {
            let x = x[column as usize];
            for i in 0..K {
                sums[i] += rows[i][entry].double() * x;
            }
        }
        sums
    }
}

impl Csr {
    /// The matrix with zeros on the pattern.
    pub fn zeros(pattern: &Arc<Pattern>) -> Self {
        Self::blank(pattern)
    }

    /// The same matrix in single precision.
    pub fn single(&self) -> Csr<f32> {
        let values = self.values.par_iter().map(|value| *value as f32).collect();
        Csr { pattern: Arc::clone(&self.pattern), values }
    }

    /// Product `y = A x` and the largest sum `scale[i] Σ |A[i, j] x[j]|` of its absolute terms.
    ///
    /// # Panics
    /// If `x`, `y` or `scale` has not `n` entries.
    pub fn mul_with_norm(&self, scale: &[f64], x: &[f64], y: &mut [f64]) -> f64 {
        let n = self.pattern.n;
        assert_eq!((x.len(), y.len(), scale.len()), (n, n, n), "vectors do not fit the matrix");
        let rows = y.par_chunks_mut(ROWS_PER_TASK).zip(scale.par_chunks(ROWS_PER_TASK)).enumerate();
        let of_task = |(task, (y, scale)): (usize, (&mut [f64], &[f64]))| {
            let mut max = 0.0_f64;
            for ((y, scale), row) in y.iter_mut().zip(scale).zip(task * ROWS_PER_TASK..) {
                let (mut sum, mut size) = (0.0, 0.0);
                for (&j, v) in self.pattern.columns(row).iter().zip(&self.values[self.pattern.row(row)]) {
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
        let Pattern { n, row_ptr, .. } = &*self.pattern;
        let diagonal: Option<Vec<usize>> = (0..*n).map(|i| self.pattern.find(i, i)).collect();
        let Some(diagonal) = diagonal else { return false };
        let size: Vec<f64> = diagonal.iter().map(|&at| self.values[at].abs().sqrt()).collect();
        // Rows come in their order: the next entry right of the diagonal of row j belongs to the next row with a
        // column j.
        let mut next: Vec<usize> = diagonal.iter().map(|at| at + 1).collect();
        for i in 0..*n {
            for at in row_ptr[i]..diagonal[i] {
                let j = self.pattern.column(i, at) as usize;
                let mirror = next[j];
                next[j] += 1;
                let there = mirror < row_ptr[j + 1] && self.pattern.column(j, mirror) as usize == i;
                let is_alike =
                    there && (self.values[at] - self.values[mirror]).abs() <= tolerance * size[i] * size[j];
                if !is_alike {
                    return false;
                }
            }
        }
        (0..*n).all(|j| next[j] == row_ptr[j + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pattern_sorts_and_finds() {
        let p = Pattern::from_rows(&[vec![2, 0, 2], vec![1], vec![]]);
        assert_eq!(p, Pattern::new(&[0, 2, 3, 3], &[0, 2, 1]));
        assert_eq!((p.n, &p.row_ptr[..], &p.col[..]), (3, &[0, 2, 3, 3][..], &[0, 2, 1][..]));
        assert_eq!((p.columns(0), p.columns(2), p.column(1, 2)), (&[0, 2][..], &[][..], 1));
        assert_eq!(p.all_columns().collect::<Vec<u32>>(), [0, 2, 1]);
        assert_eq!((p.nnz(), p.find(0, 2), p.find(0, 1), p.find(2, 2)), (3, Some(1), None, None));
    }

    /// As many as have the same columns, three at most; their products are those of the rows alone.
    #[test]
    fn rows_of_the_same_columns_are_taken_together() {
        let of = |row: u32| if row < 5 { vec![0, 2, 7] } else { vec![row, 1] };
        let rows: Vec<Vec<u32>> = (0..8).map(of).collect();
        let p = Arc::new(Pattern::from_rows(&rows));
        let ends: Vec<usize> = (0..8).map(|row| p.end_of_alike(row)).collect();
        assert_eq!(ends, [3, 3, 3, 5, 5, 6, 7, 8]);
        let values: Vec<f64> = (0..p.nnz()).map(|at| (at as f64).sin()).collect();
        let (a, x) = (Csr { pattern: p, values }, [1.0, -0.3, 0.7, 2.0, 0.1, -4.0, 3.0, 0.2]);
        let mut y = [0.0; 8];
        a.mul(&x, &mut y);
        for (row, y) in y.iter().enumerate() {
            let terms = a.pattern.row(row).map(|at| a.values[at] * x[a.pattern.column(row, at) as usize]);
            assert_eq!(*y, terms.sum::<f64>());
        }
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
