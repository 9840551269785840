//! Equilibration: rows in Pa, m/s and penalties brought to one size.

use super::{Csr, Kind, Sizes, SolverError, Unknown};
use rayon::prelude::*;
use std::ops::Range;

/// Pieces of the matrix whose largest entries are found at the same time.
const PIECES: usize = 8;

/// Consecutive unknowns of one kind at most, for sums over parts of rows; where there are more, entries are taken one
/// by one.
const FEW: usize = 4;

/// Row and column scales `R` and `C` such that the sum `Σ |R A| s` of every row, s the [sizes](Sizes) of the unknowns,
/// and the largest entry of every column of `R A C` are one. `A x = b` is `(R A C) (C⁻¹ x) = R b`.
///
/// With sizes in the units of the matrix, `R A C` is the same in every system of units, but for rounding, and with it
/// the choice of pivots. Powers of two, which would round nothing, would not do: which one is nearest depends on
/// the units.
#[derive(Debug, Clone, Default)]
pub struct Scaling {
    /// Diagonal of `R`.
    pub row: Vec<f64>,
    /// Diagonal of `C`.
    pub col: Vec<f64>,
    /// Typical sizes of the unknowns.
    pub sizes: Sizes,
    /// Largest entries of the columns in each piece.
    maxima: Vec<Vec<f64>>,
}

impl Scaling {
    /// Finds the scales of `a`; reuses its memory.
    ///
    /// # Errors
    /// An entry that is not finite, a row or a column of zeros, each with its unknown.
    pub fn update(&mut self, a: &Csr, unknowns: &[Unknown]) -> Result<(), SolverError> {
        let n = a.pattern.n;
        self.row.resize(n, 0.0);
        let (sizes, blocks) = (self.sizes, blocks(unknowns));
        let row_sums = self.row.par_iter_mut().enumerate().with_min_len(1024);
        row_sums.for_each(|(i, sum)| {
            let at = a.pattern.row(i);
            let (columns, values) = (a.pattern.columns(i), &a.values[at]);
            *sum = match blocks.len() {
                0..=FEW => sum_by_blocks(columns, values, &blocks, &sizes),
                _ => columns
                    .iter()
                    .zip(values)
                    .map(|(&j, v)| v.abs() * sizes.of(unknowns[j as usize].kind))
                    .sum(),
            };
        });
        if let Some(row) = self.row.iter().position(|sum| !sum.is_finite()) {
            let at = a.pattern.row(row);
            let k = a.values[at.clone()].iter().position(|v| !v.is_finite()).unwrap_or(0);
            let col = a.pattern.columns(row)[k] as usize;
            return Err(SolverError::NotFinite { row, col, unknown: unknowns[row] });
        }
        if let Some(row) = self.row.iter().position(|&sum| sum == 0.0) {
            return Err(SolverError::ZeroRow { row, unknown: unknowns[row] });
        }
        self.row.iter_mut().for_each(|sum| *sum = reciprocal(*sum));
        self.column_maxima(a);
        if let Some(col) = self.col.iter().position(|&m| m == 0.0) {
            return Err(SolverError::ZeroColumn { col, unknown: unknowns[col] });
        }
        self.col.iter_mut().for_each(|m| *m = reciprocal(*m));
        Ok(())
    }

    /// The same for a symmetric positive definite `a`, which `R A R` still is: its diagonal is about one.
    ///
    /// # Errors
    /// A diagonal entry that is not positive, with its unknown.
    pub fn update_definite(&mut self, a: &Csr, unknowns: &[Unknown]) -> Result<(), SolverError> {
        self.row.clear();
        for i in 0..a.pattern.n {
            let diagonal = a.pattern.find(i, i).map_or(0.0, |at| a.values[at]);
            if !(diagonal > 0.0 && diagonal.is_finite()) {
                return Err(SolverError::NotDefinite { index: i, unknown: unknowns[i] });
            }
            self.row.push(reciprocal(diagonal.sqrt()));
        }
        self.col.clone_from(&self.row);
        Ok(())
    }

    /// `col` ← largest entry of each column of `R A`.
    fn column_maxima(&mut self, a: &Csr) {
        let n = a.pattern.n;
        let Self { row, col, maxima, .. } = self;
        maxima.resize(PIECES, Vec::new());
        maxima.par_iter_mut().enumerate().for_each(|(piece, max)| {
            max.clear();
            max.resize(n, 0.0);
            for i in piece * n / PIECES..(piece + 1) * n / PIECES {
                let at = a.pattern.row(i);
                for (&j, v) in a.pattern.columns(i).iter().zip(&a.values[at]) {
                    let max = &mut max[j as usize];
                    *max = max.max(v.abs() * row[i]);
                }
            }
        });
        col.clear();
        col.resize(n, 0.0);
        for piece in maxima {
            col.iter_mut().zip(piece).for_each(|(max, m)| *max = max.max(*m));
        }
    }
}

/// Ranges of consecutive unknowns of one kind.
fn blocks(unknowns: &[Unknown]) -> Vec<(Range<u32>, Kind)> {
    let mut blocks: Vec<(Range<u32>, Kind)> = vec![];
    for (i, Unknown { kind, .. }) in unknowns.iter().enumerate() {
        match blocks.last_mut() {
            Some((range, last)) if last == kind => range.end += 1,
            _ => blocks.push((i as u32..i as u32 + 1, *kind)),
        }
    }
    blocks
}

/// Σ |v| s of a row with sorted `columns`.
fn sum_by_blocks(columns: &[u32], values: &[f64], blocks: &[(Range<u32>, Kind)], sizes: &Sizes) -> f64 {
    let (mut sum, mut from) = (0.0, 0);
    for (range, kind) in blocks {
        let to = match columns.last() {
            Some(&last) if last >= range.end => from + columns[from..].partition_point(|&j| j < range.end),
            _ => columns.len(),
        };
        sum += absolute_sum(&values[from..to]) * sizes.of(*kind);
        from = to;
    }
    sum
}

/// Σ |v|; not finite where an entry is not.
fn absolute_sum(values: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let chunks = values.chunks_exact(8);
    let rest: f64 = chunks.remainder().iter().map(|v| v.abs()).sum();
    for chunk in chunks {
        for l in 0..8 {
            lanes[l] += chunk[l].abs();
        }
    }
    rest + lanes.iter().sum::<f64>()
}

/// 1/m, finite.
fn reciprocal(m: f64) -> f64 {
    m.max(f64::MIN_POSITIVE).recip()
}

/// Exponent of the power of two below m; subnormal numbers count as the smallest normal one.
fn exponent(m: f64) -> i64 {
    ((m.to_bits() >> 52) & 0x7ff).max(1) as i64 - 1023
}

/// 1/m to a power of two.
pub(super) fn inverse(m: f64) -> f64 {
    f64::from_bits(((1023 - exponent(m)).clamp(1, 2046) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::{Kind, Pattern};
    use std::sync::Arc;

    fn unknowns(n: usize) -> Vec<Unknown> {
        (0..n).map(|i| Unknown { node: i as u32, kind: Kind::Velocity, at: [0.0; 3] }).collect()
    }

    #[test]
    fn scaled_maxima_are_about_one() {
        let pattern = Arc::new(Pattern::from_rows(&[[0, 1], [0, 1]]));
        let a = Csr { pattern, values: vec![1e-8, 2e3, 3e10, 4.0] };
        let mut s = Scaling::default();
        s.update(&a, &unknowns(2)).unwrap();
        let scaled = |i: usize, j: usize| a.values[2 * i + j].abs() * s.row[i] * s.col[j];
        let row_max = |i: usize| scaled(i, 0).max(scaled(i, 1));
        let col_max = |j: usize| scaled(0, j).max(scaled(1, j));
        for i in 0..2 {
            assert!((0.5..4.0).contains(&row_max(i)) && (col_max(i) - 1.0).abs() < 1e-15, "{s:?}");
        }
    }

    /// In whatever order the kinds come.
    #[test]
    fn scaled_matrix_is_the_same_in_all_units() {
        let pattern = Arc::new(Pattern::from_rows(&[[0, 1, 2, 3], [0, 1, 2, 3], [0, 1, 2, 3], [0, 1, 2, 3]]));
        let values =
            vec![3.0, -0.5, 2.0, 0.1, 1.0, 0.25, -0.5, 1e3, 7.0, 1e-3, 0.0, 5.0, 2.0, 0.5, -1.0, 0.3];
        let kinds = [Kind::Velocity, Kind::Velocity, Kind::Deformation, Kind::Pressure];
        let orders = [[0, 1, 2, 3], [0, 2, 1, 3], [3, 2, 0, 1]];
        let scaled = |order: [usize; 4], [v, u, p]: [f64; 3], rows: [f64; 4]| {
            let unit = |i: usize| [v, v, u, p][order[i]];
            let values: Vec<f64> = (0..16).map(|at| values[at] * unit(at % 4) * rows[at / 4]).collect();
            let a = Csr { pattern: Arc::clone(&pattern), values };
            let mut unknowns = unknowns(4);
            (0..4).for_each(|i| unknowns[i].kind = kinds[order[i]]);
            let sizes = Sizes { velocity: 1.0 / v, deformation: 0.01 / u, pressure: 10.0 / p };
            let mut s = Scaling { sizes, ..Scaling::default() };
            s.update(&a, &unknowns).unwrap();
            (0..16).map(|at| a.values[at] * s.row[at / 4] * s.col[at % 4]).collect::<Vec<f64>>()
        };
        for order in orders {
            let one = scaled(order, [1.0; 3], [1.0; 4]);
            let other = scaled(order, [1e3, 1e-7, 3e5], [1e-9, 1e4, 1.0, 7.0]);
            assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-14), "{one:?} {other:?}");
        }
    }

    #[test]
    fn names_rows_that_cannot_be_scaled() {
        let pattern = Arc::new(Pattern::from_rows(&[[0, 1], [0, 1]]));
        let of = |values: [f64; 4]| {
            let a = Csr { pattern: Arc::clone(&pattern), values: values.to_vec() };
            Scaling::default().update(&a, &unknowns(2))
        };
        assert!(matches!(of([1.0, 1.0, 0.0, 0.0]), Err(SolverError::ZeroRow { row: 1, .. })));
        assert!(matches!(of([0.0, 1.0, 0.0, 1.0]), Err(SolverError::ZeroColumn { col: 0, .. })));
        assert!(matches!(of([1.0, 1.0, f64::NAN, 1.0]), Err(SolverError::NotFinite { row: 1, col: 0, .. })));
    }
}
