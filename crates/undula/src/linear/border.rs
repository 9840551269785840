//! Corrections of systems with borders, by those of the matrix alone.
//!
//! With Z = A⁻¹ a and the small matrix S = c − bᵀ Z,
//! ```text
//!     x = A⁻¹ r,   S λ = r_λ − bᵀ x,   δ = x − Z λ.
//! ```
//! A renewal costs one correction more for each border, and so does the first correction of a step with another rule. All
//! other corrections cost nothing more but products of vectors.

use super::correction::Correction;
use crate::algebra::SolverError;
use crate::physics::StepRule;
use crate::system::{Assembler, Borders, Matrix, StepView};

/// Part of a row of S that is rounding.
const DEPENDENT: f64 = 1e-13;

/// Borders at the Jacobian at hand.
#[derive(Default)]
pub(super) struct Bordered {
    borders: Borders,
    /// Z, one vector `[v, u, p]` for each border.
    solved: Vec<Vec<f64>>,
    /// S by rows, replaced by its factors.
    small: Vec<f64>,
    /// Row that was exchanged with each row of S.
    pivots: Vec<usize>,
    /// What they belong to, once they are solved.
    of: Option<(Matrix, StepRule)>,
    lambda: Vec<f64>,
}

impl Bordered {
    /// Take the borders at the iterate of `view`. Returns how many times factors were applied.
    ///
    /// # Errors
    /// If a correction fails, or if the borders are dependent.
    pub(super) fn renew<const D: usize>(
        &mut self,
        correction: &mut dyn Correction<D>,
        matrix: Matrix,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
    ) -> Result<usize, SolverError> {
        self.of = None;
        assembler.borders(matrix, view, &mut self.borders);
        let (n, fields) = (self.borders.len(), assembler.space.n_field_unknowns());
        self.solved.resize(n, vec![]);
        let mut column = vec![0.0; if n > 0 { fields } else { 0 }];
        let mut applied = 0;
        for (border, z) in self.borders.iter().zip(&mut self.solved) {
            column.fill(0.0);
            z.resize(fields, 0.0);
            border.add_column(1.0, &mut column);
            assembler.zero_given(&mut column);
            applied += correction.correct(assembler, view, true, &column, z)?;
        }
        self.small.clear();
        for (i, border) in self.borders.iter().enumerate() {
            for (j, z) in self.solved.iter().enumerate() {
                let product = assembler.space.sum(border.product(z));
                self.small.push(if i == j { border.corner } else { 0.0 } - product);
            }
        }
        self.factor()?;
        self.of = Some((matrix, view.rule));
        Ok(applied)
    }

    /// δ from the residual `r`, both `[v, u, p, s]`. Returns how many times factors were applied.
    pub(super) fn correct<const D: usize>(
        &mut self,
        correction: &mut dyn Correction<D>,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        let fields = assembler.space.n_field_unknowns();
        let (r, r_scalar) = r.split_at(fields);
        let (delta, scalars) = delta.split_at_mut(fields);
        let Some((matrix, rule)) = self.of else { return Err(SolverError::NotFactored) };
        let mut applied = 0;
        if !self.borders.is_empty() && rule != view.rule {
            // The factors serve another step of the same kθ.
            applied = self.renew(correction, matrix, assembler, view)?;
        }
        applied += correction.correct(assembler, view, settled, r, delta)?;
        scalars.fill(0.0);
        self.lambda.clear();
        for border in self.borders.iter() {
            let residual = border.scalar.map_or(0.0, |scalar| r_scalar[scalar]);
            self.lambda.push(residual - assembler.space.sum(border.product(delta)));
        }
        self.substitute();
        for ((border, z), lambda) in self.borders.iter().zip(&self.solved).zip(&self.lambda) {
            delta.iter_mut().zip(z).for_each(|(delta, z)| *delta -= lambda * z);
            if let Some(scalar) = border.scalar {
                scalars[scalar] = *lambda;
            }
        }
        Ok(applied)
    }

    /// Factors of the small matrix with partial pivoting.
    fn factor(&mut self) -> Result<(), SolverError> {
        let n = self.borders.len();
        let a = &mut self.small;
        let largest = |row: &[f64]| row.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
        let mut scales: Vec<f64> = a.chunks_exact(n.max(1)).map(largest).collect();
        self.pivots.clear();
        for k in 0..n {
            let pivot =
                (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).unwrap_or(k);
            self.pivots.push(pivot);
            (0..n).for_each(|j| a.swap(k * n + j, pivot * n + j));
            // Against the size of its row before the elimination.
            scales.swap(k, pivot);
            let size = a[k * n + k].abs();
            if !size.is_finite() || size <= DEPENDENT * scales[k] {
                return Err(SolverError::DependentBorders);
            }
            for i in k + 1..n {
                a[i * n + k] /= a[k * n + k];
                for j in k + 1..n {
                    a[i * n + j] -= a[i * n + k] * a[k * n + j];
                }
            }
        }
        Ok(())
    }

    /// λ ← S⁻¹ λ.
    fn substitute(&mut self) {
        let (n, a, x) = (self.borders.len(), &self.small, &mut self.lambda);
        for k in 0..n {
            x.swap(k, self.pivots[k]);
        }
        for i in 0..n {
            x[i] -= (0..i).map(|j| a[i * n + j] * x[j]).sum::<f64>();
        }
        for i in (0..n).rev() {
            x[i] = (x[i] - (i + 1..n).map(|j| a[i * n + j] * x[j]).sum::<f64>()) / a[i * n + i];
        }
    }
}
