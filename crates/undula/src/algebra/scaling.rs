//! Equilibration: rows in Pa, m/s and penalties brought to one size.

use super::{Csr, SolverError, Unknown};

/// Row and column scales `R` and `C`, powers of two, such that the largest entry of every row and
/// column of `R A C` is about one. `A x = b` is `(R A C) (C⁻¹ x) = R b`; scaling rounds nothing.
#[derive(Debug, Clone, Default)]
pub struct Scaling {
    /// Diagonal of `R`.
    pub row: Vec<f64>,
    /// Diagonal of `C`.
    pub col: Vec<f64>,
    row_max: Vec<f64>,
    col_max: Vec<f64>,
}

impl Scaling {
    /// Finds the scales of `a`: rows by their largest entry, then columns, then both by the root of what
    /// is left (Ruiz). Reuses its memory.
    ///
    /// # Errors
    /// An entry that is not finite, a row or a column of zeros, each with its unknown.
    pub fn update(&mut self, a: &Csr, unknowns: &[Unknown]) -> Result<(), SolverError> {
        let n = a.pattern.n;
        for scale in [&mut self.row, &mut self.col] {
            scale.clear();
            scale.resize(n, 1.0);
        }
        self.maxima(a);
        self.check(a, unknowns)?;
        rescale(&mut self.row, &self.row_max, inverse);
        self.maxima(a);
        rescale(&mut self.col, &self.col_max, inverse);
        self.maxima(a);
        rescale(&mut self.row, &self.row_max, inverse_root);
        rescale(&mut self.col, &self.col_max, inverse_root);
        Ok(())
    }

    /// ‖R A C‖∞, the largest row sum.
    pub fn norm_inf(&self, a: &Csr) -> f64 {
        let p = &a.pattern;
        let row_sum = |i: usize| -> f64 {
            let at = p.row(i);
            let terms = p.col[at.clone()].iter().zip(&a.values[at]);
            self.row[i] * terms.map(|(&j, v)| v.abs() * self.col[j as usize]).sum::<f64>()
        };
        (0..p.n).map(row_sum).fold(0.0, f64::max)
    }

    /// Largest scaled entry of each row and of each column.
    fn maxima(&mut self, a: &Csr) {
        let n = a.pattern.n;
        self.row_max.clear();
        self.col_max.clear();
        self.col_max.resize(n, 0.0);
        for i in 0..n {
            let at = a.pattern.row(i);
            let mut max = 0.0_f64;
            for (&j, v) in a.pattern.col[at.clone()].iter().zip(&a.values[at]) {
                let j = j as usize;
                let v = v.abs() * self.row[i];
                max = max.max(v * self.col[j]);
                self.col_max[j] = self.col_max[j].max(v * self.col[j]);
            }
            self.row_max.push(max);
        }
    }

    fn check(&self, a: &Csr, unknowns: &[Unknown]) -> Result<(), SolverError> {
        let p = &a.pattern;
        if let Some(k) = a.values.iter().position(|v| !v.is_finite()) {
            let row = p.row_ptr.partition_point(|&start| start <= k) - 1;
            return Err(SolverError::NotFinite { row, col: p.col[k] as usize, unknown: unknowns[row] });
        }
        if let Some(row) = self.row_max.iter().position(|&m| m == 0.0) {
            return Err(SolverError::ZeroRow { row, unknown: unknowns[row] });
        }
        if let Some(col) = self.col_max.iter().position(|&m| m == 0.0) {
            return Err(SolverError::ZeroColumn { col, unknown: unknowns[col] });
        }
        Ok(())
    }
}

fn rescale(scale: &mut [f64], max: &[f64], factor: impl Fn(f64) -> f64) {
    for (s, m) in scale.iter_mut().zip(max) {
        *s *= factor(*m);
    }
}

/// Exponent of the power of two below m; subnormal numbers count as the smallest normal one.
fn exponent(m: f64) -> i64 {
    ((m.to_bits() >> 52) & 0x7ff).max(1) as i64 - 1023
}

fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent.clamp(-1022, 1023)) as u64) << 52)
}

/// 1/m to a power of two.
fn inverse(m: f64) -> f64 {
    power_of_two(-exponent(m))
}

/// 1/√m to a power of two.
fn inverse_root(m: f64) -> f64 {
    power_of_two(-(exponent(m) + 1).div_euclid(2))
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
        s.maxima(&a);
        assert!(s.row_max.iter().chain(&s.col_max).all(|m| (0.25..=4.0).contains(m)), "{s:?}");
        assert!(s.row.iter().chain(&s.col).all(|v| v.to_bits() << 12 == 0), "not powers of two");
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
