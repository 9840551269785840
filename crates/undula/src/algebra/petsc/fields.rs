//! Systems on their way to PETSc: entries on every diagonal, scales of fields; and words for its numbers.

use super::counted::Counted;
use crate::algebra::{Csr, Kind, Pattern, Sizes, SolverError, Unknown};
use crate::parallel::Reduce;

/// Rows of a matrix as PETSc has them: the columns of each sorted, and an entry on its diagonal, which factors without fill
/// ask for. Of several processes each has some of the rows.
#[derive(Debug, Default)]
pub(super) struct Layout {
    rows: Vec<u32>,
    starts: Vec<usize>,
    /// Entry of our matrix for each entry of PETSc; `u32::MAX`: a diagonal that is none of ours.
    from: Vec<u32>,
}

impl Layout {
    /// Of these `rows`, and the columns of all their entries, row by row; `number` is that of an unknown in PETSc.
    pub(super) fn new(
        pattern: &Pattern,
        rows: Vec<u32>,
        number: impl Fn(usize) -> usize,
    ) -> (Layout, Vec<usize>) {
        let (mut starts, mut from, mut columns) = (vec![0], vec![], vec![]);
        let mut entries: Vec<(usize, u32)> = vec![];
        for row in rows.iter().map(|&row| row as usize) {
            entries.clear();
            entries.extend(pattern.row(row).map(|at| (number(pattern.column(row, at) as usize), at as u32)));
            let own = number(row);
            if entries.iter().all(|(column, _)| *column != own) {
                entries.push((own, u32::MAX));
            }
            entries.sort_unstable();
            from.extend(entries.iter().map(|(_, at)| *at));
            columns.extend(entries.iter().map(|(column, _)| *column));
            starts.push(from.len());
        }
        (Layout { rows, starts, from }, columns)
    }

    pub(super) fn rows(&self) -> &[u32] {
        &self.rows
    }

    pub(super) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// `values` ← entries of `a`, times `factor(row, column)`.
    pub(super) fn write(&self, a: &Csr, factor: impl Fn(usize, usize) -> f64, values: &mut [f64]) {
        for (row, range) in self.rows.iter().zip(self.starts.windows(2)) {
            for to in range[0]..range[1] {
                values[to] = match self.from[to] {
                    u32::MAX => 0.0,
                    at => {
                        let at = at as usize;
                        a.values[at] * factor(*row as usize, a.pattern.column(*row as usize, at) as usize)
                    }
                };
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
    /// Those of `a`, with typical `sizes` of its unknowns, over the rows that are `counted`.
    ///
    /// # Errors
    /// An entry that is not finite, or a row of zeros, on all processes.
    pub(super) fn update(
        &mut self,
        a: &Csr,
        unknowns: &[Unknown],
        sizes: Sizes,
        counted: &Counted,
    ) -> Result<(), SolverError> {
        self.column = [sizes.velocity, sizes.deformation, sizes.pressure];
        let (mut means, mut largest, mut wrong) = ([0.0; 6], [0.0f64; 3], None);
        for row in counted.rows() {
            let of = field(unknowns[row].kind);
            match self.sum_of_row(a, unknowns, row) {
                Ok(sum) => {
                    means[of] += sum.ln();
                    means[3 + of] += 1.0;
                    largest[of] = largest[of].max(sum);
                }
                Err(error) => wrong = wrong.or(Some(error)),
            }
        }
        if counted.any(wrong.is_some()) {
            let elsewhere = || SolverError::Engine("a row of the matrix of another process is none".into());
            return Err(wrong.unwrap_or_else(elsewhere));
        }
        counted.reduce(Reduce::Sum, &mut means);
        counted.reduce(Reduce::Max, &mut largest);
        for of in 0..3 {
            let count = means[3 + of];
            self.row[of] = if count > 0.0 { (-means[of] / count).exp() } else { 1.0 };
        }
        self.norm = (0..3).map(|of| self.row[of] * largest[of]).fold(0.0, f64::max);
        Ok(())
    }

    /// Σ |a_ij| s_j of a row.
    fn sum_of_row(&self, a: &Csr, unknowns: &[Unknown], row: usize) -> Result<f64, SolverError> {
        let mut sum = 0.0;
        for at in a.pattern.row(row) {
            let (value, col) = (a.values[at], a.pattern.column(row, at) as usize);
            if !value.is_finite() {
                return Err(SolverError::NotFinite { row, col, unknown: unknowns[row] });
            }
            sum += value.abs() * self.column[field(unknowns[col].kind)];
        }
        if sum == 0.0 { Err(SolverError::ZeroRow { row, unknown: unknowns[row] }) } else { Ok(sum) }
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
    pub(super) fn norms_of_rows(&self, b: &[f64], unknowns: &[Unknown], counted: &Counted) -> [f64; 2] {
        let (mut most, mut sum) = ([0.0f64], [0.0]);
        for row in counted.rows() {
            let value = b[row] * self.row[field(unknowns[row].kind)];
            most[0] = most[0].max(value.abs());
            sum[0] += value * value;
        }
        counted.reduce(Reduce::Max, &mut most);
        counted.reduce(Reduce::Sum, &mut sum);
        [most[0] + 0.0 * sum[0], sum[0].sqrt()]
    }

    /// ‖C⁻¹ x‖∞.
    pub(super) fn norm_of_columns(&self, x: &[f64], unknowns: &[Unknown], counted: &Counted) -> f64 {
        let scaled = counted.rows().map(|row| x[row] / self.column[field(unknowns[row].kind)]);
        let mut most = [scaled.fold(0.0, |most: f64, value| most.max(value.abs()))];
        counted.reduce(Reduce::Max, &mut most);
        most[0]
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
        let (layout, columns) = Layout::new(&a.pattern, vec![0, 1, 2], |i| i);
        assert_eq!(layout.starts(), [0, 3, 5, 8]);
        assert_eq!(columns, [0, 1, 2, 0, 1, 0, 1, 2]);
        layout.write(&a, |row, column| if (row, column) == (1, 0) { 10.0 } else { 1.0 }, &mut values);
        assert_eq!(values, [0.0, 1.0, -2.0, 30.0, 4.0, 5.0, -6.0, 0.0]);
        // The last two rows, as of one of two processes.
        let ((last, columns), mut values) = (Layout::new(&a.pattern, vec![1, 2], |i| i), [f64::NAN; 5]);
        assert_eq!(last.starts(), [0, 2, 5]);
        assert_eq!(columns, [0, 1, 0, 1, 2]);
        last.write(&a, |_, _| 1.0, &mut values);
        assert_eq!(values, [3.0, 4.0, 5.0, -6.0, 0.0]);
        // The same rows where PETSc has the unknowns in another order.
        let (other, columns) = Layout::new(&a.pattern, vec![1, 2], |i| 2 - i);
        assert_eq!((other.starts(), columns), (&[0, 2, 5][..], vec![1, 2, 0, 1, 2]));
        other.write(&a, |_, _| 1.0, &mut values);
        assert_eq!(values, [4.0, 3.0, 0.0, -6.0, 5.0]);
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
                    let column = a.pattern.column(row, at) as usize;
                    a.values[at] *= if column < 2 { velocity } else { pressure };
                    a.values[at] *= if row < 2 { momentum } else { 1.0 };
                }
            }
            let sizes = Sizes { velocity: 1.0 / velocity, deformation: 1.0, pressure: 1.0 / pressure };
            let mut scales = FieldScales::default();
            scales.update(&a, &unknowns, sizes, &Counted::new(3, None)).unwrap();
            let of = |row: usize, at: usize| {
                a.values[at] * scales.of(&unknowns, row, a.pattern.column(row, at) as usize)
            };
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
