//! Systems on their way to PETSc: entries on every diagonal, scales of fields; and words for its numbers.

use crate::algebra::{Csr, Kind, Pattern, Sizes, SolverError, Unknown};
use std::ops::Range;

/// Where the rows of a matrix begin if each has an entry on its diagonal, which factors without fill ask for. Of several
/// processes each has some of the rows.
#[derive(Debug, Default)]
pub(super) struct Layout {
    rows: Range<usize>,
    starts: Vec<usize>,
    /// Rows whose diagonal is none of ours.
    added: Vec<usize>,
}

impl Layout {
    /// Of these `rows`.
    pub(super) fn new(pattern: &Pattern, rows: Range<usize>) -> Layout {
        let added: Vec<usize> = rows.clone().filter(|&i| pattern.find(i, i).is_none()).collect();
        let before = |row: usize| added.partition_point(|&other| other < row);
        let first = pattern.row_ptr[rows.start];
        let starts = (rows.start..=rows.end).map(|row| pattern.row_ptr[row] - first + before(row)).collect();
        Layout { rows, starts, added }
    }

    pub(super) fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    pub(super) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Columns of all entries, row by row.
    pub(super) fn columns<'a>(&'a self, pattern: &'a Pattern) -> impl Iterator<Item = usize> + 'a {
        self.rows().flat_map(move |row| {
            let own = pattern.row(row).map(|at| pattern.col[at] as usize);
            let mut columns: Vec<usize> = own.collect();
            if self.is_added(row) {
                columns.insert(columns.partition_point(|&column| column < row), row);
            }
            columns
        })
    }

    fn is_added(&self, row: usize) -> bool {
        self.added.binary_search(&row).is_ok()
    }

    /// `values` ← entries of `a`, times `factor(row, column)`.
    pub(super) fn write(&self, a: &Csr, factor: impl Fn(usize, usize) -> f64, values: &mut [f64]) {
        for row in self.rows() {
            let (mut to, added) = (self.starts[row - self.rows.start], self.is_added(row));
            let mut is_due = added;
            for at in a.pattern.row(row) {
                let column = a.pattern.col[at] as usize;
                if is_due && column > row {
                    values[to] = 0.0;
                    (to, is_due) = (to + 1, false);
                }
                values[to] = a.values[at] * factor(row, column);
                to += 1;
            }
            if is_due {
                values[to] = 0.0;
            }
        }
    }
}

/// Factors of the rows and of the columns of each field.
#[derive(Debug, Default)]
pub(super) struct FieldScales {
    row: [f64; 3],
    column: [f64; 3],
    /// ‖R A C‖∞ of the matrix R and C are of.
    pub(super) norm: f64,
}

fn field(kind: Kind) -> usize {
    match kind {
        Kind::Velocity => 0,
        Kind::Deformation => 1,
        Kind::Pressure => 2,
    }
}

impl FieldScales {
    /// Those of `a`, with typical `sizes` of its unknowns.
    ///
    /// # Errors
    /// An entry that is not finite, or a row of zeros.
    pub(super) fn update(&mut self, a: &Csr, unknowns: &[Unknown], sizes: Sizes) -> Result<(), SolverError> {
        self.column = [sizes.velocity, sizes.deformation, sizes.pressure];
        let (mut logarithms, mut counts, mut largest) = ([0.0; 3], [0.0; 3], [0.0f64; 3]);
        for row in 0..a.pattern.n {
            let mut sum = 0.0;
            for at in a.pattern.row(row) {
                let (value, col) = (a.values[at], a.pattern.col[at] as usize);
                if !value.is_finite() {
                    return Err(SolverError::NotFinite { row, col, unknown: unknowns[row] });
                }
                sum += value.abs() * self.column[field(unknowns[col].kind)];
            }
            if sum == 0.0 {
                return Err(SolverError::ZeroRow { row, unknown: unknowns[row] });
            }
            let of = field(unknowns[row].kind);
            logarithms[of] += sum.ln();
            counts[of] += 1.0;
            largest[of] = largest[of].max(sum);
        }
        for of in 0..3 {
            self.row[of] = if counts[of] > 0.0 { (-logarithms[of] / counts[of]).exp() } else { 1.0 };
        }
        self.norm = (0..3).map(|of| self.row[of] * largest[of]).fold(0.0, f64::max);
        Ok(())
    }

    /// Factor of an entry.
    pub(super) fn of(&self, unknowns: &[Unknown], row: usize, column: usize) -> f64 {
        self.row[field(unknowns[row].kind)] * self.column[field(unknowns[column].kind)]
    }

    /// `scaled` ← R b.
    pub(super) fn scale_rows(&self, b: &[f64], unknowns: &[Unknown], scaled: &mut [f64]) {
        for ((scaled, b), unknown) in scaled.iter_mut().zip(b).zip(unknowns) {
            *scaled = b * self.row[field(unknown.kind)];
        }
    }

    /// x ← x + C y.
    pub(super) fn add_columns(&self, y: &[f64], unknowns: &[Unknown], x: &mut [f64]) {
        for ((x, y), unknown) in x.iter_mut().zip(y).zip(unknowns) {
            *x += y * self.column[field(unknown.kind)];
        }
    }

    /// ‖R b‖∞ and ‖R b‖₂; NaN where an entry is not finite.
    pub(super) fn norms_of_rows(&self, b: &[f64], unknowns: &[Unknown]) -> [f64; 2] {
        let scaled = b.iter().zip(unknowns).map(|(b, unknown)| b * self.row[field(unknown.kind)]);
        let (mut most, mut sum) = (0.0f64, 0.0);
        for value in scaled {
            most = most.max(value.abs());
            sum += value * value;
        }
        [most + 0.0 * sum, sum.sqrt()]
    }

    /// ‖C⁻¹ x‖∞.
    pub(super) fn norm_of_columns(&self, x: &[f64], unknowns: &[Unknown]) -> f64 {
        let scaled = x.iter().zip(unknowns).map(|(x, unknown)| x / self.column[field(unknown.kind)]);
        scaled.fold(0.0, |most, value| most.max(value.abs()))
    }
}

/// The name of a reason for which PETSc ends an iteration.
pub(super) fn reason(code: i32) -> String {
    let name = match code {
        0 => "no iteration was done",
        -3 => "DIVERGED_ITS, too many iterations",
        -4 => "DIVERGED_DTOL, the residual grows",
        -5 | -6 => "DIVERGED_BREAKDOWN",
        -7 => "DIVERGED_NONSYMMETRIC, the iteration is for symmetric matrices",
        -8 => "DIVERGED_INDEFINITE_PC",
        -9 => "DIVERGED_NANORINF, a number is not finite",
        -10 => "DIVERGED_INDEFINITE_MAT",
        -11 => "DIVERGED_PC_FAILED",
        _ => return format!("reason {code}"),
    };
    name.into()
}

/// Why a preconditioner failed; `None`: it did not.
pub(super) fn failure(code: i32) -> Option<&'static str> {
    match code {
        0 => None,
        1 => Some("a pivot is missing (FACTOR_STRUCT_ZEROPIVOT)"),
        2 => Some("a pivot is zero (FACTOR_NUMERIC_ZEROPIVOT)"),
        3 => Some(
            "no room for the factors (FACTOR_OUTMEMORY); MUMPS takes -mat_mumps_icntl_14 200 for 200 % more of it",
        ),
        _ => Some("it could not be set up (FACTOR_OTHER)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Rows 0 and 2 have no diagonal.
    fn matrix() -> Csr {
        let pattern = Arc::new(Pattern::from_rows(&[vec![1, 2], vec![0, 1], vec![0, 1]]));
        Csr { pattern, values: vec![1.0, -2.0, 3.0, 4.0, 5.0, -6.0] }
    }

    #[test]
    fn every_diagonal_has_an_entry() {
        let (a, mut values) = (matrix(), [f64::NAN; 8]);
        let layout = Layout::new(&a.pattern, 0..3);
        assert_eq!(layout.starts(), [0, 3, 5, 8]);
        let columns: Vec<usize> = layout.columns(&a.pattern).collect();
        assert_eq!(columns, [0, 1, 2, 0, 1, 0, 1, 2]);
        layout.write(&a, |row, column| if (row, column) == (1, 0) { 10.0 } else { 1.0 }, &mut values);
        assert_eq!(values, [0.0, 1.0, -2.0, 30.0, 4.0, 5.0, -6.0, 0.0]);
        // The last two rows, as of one of two processes.
        let (last, mut values) = (Layout::new(&a.pattern, 1..3), [f64::NAN; 5]);
        assert_eq!(last.starts(), [0, 2, 5]);
        assert_eq!(last.columns(&a.pattern).collect::<Vec<_>>(), [0, 1, 0, 1, 2]);
        last.write(&a, |_, _| 1.0, &mut values);
        assert_eq!(values, [3.0, 4.0, 5.0, -6.0, 0.0]);
    }

    #[test]
    fn scales_do_not_depend_on_units_and_are_one_in_a_field() {
        let kinds = [Kind::Velocity, Kind::Velocity, Kind::Pressure];
        let unknown = |i: usize| Unknown { node: i as u32, kind: kinds[i], at: [0.0; 3] };
        let unknowns: Vec<Unknown> = (0..3).map(unknown).collect();
        let scaled = |velocity: f64, pressure: f64, momentum: f64| {
            let mut a = matrix();
            for row in 0..3 {
                for at in a.pattern.row(row) {
                    let column = a.pattern.col[at] as usize;
                    a.values[at] *= if column < 2 { velocity } else { pressure };
                    a.values[at] *= if row < 2 { momentum } else { 1.0 };
                }
            }
            let sizes = Sizes { velocity: 1.0 / velocity, deformation: 1.0, pressure: 1.0 / pressure };
            let mut scales = FieldScales::default();
            scales.update(&a, &unknowns, sizes).unwrap();
            let of =
                |row: usize, at: usize| a.values[at] * scales.of(&unknowns, row, a.pattern.col[at] as usize);
            let pattern = &a.pattern;
            let all = (0..3).flat_map(|row| pattern.row(row).map(move |at| (row, at)));
            all.map(|(row, at)| of(row, at)).collect::<Vec<f64>>()
        };
        let (one, other) = (scaled(1.0, 1.0, 1.0), scaled(1e3, 1e-5, 1e7));
        assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-12), "{one:?} {other:?}");
        // Ratios within the block of velocities are those of the matrix.
        assert!((one[2] / one[3] - 0.75).abs() < 1e-14, "{one:?}");
    }
}
