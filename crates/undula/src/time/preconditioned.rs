//! Corrections by GMRES: the newest matrix, preconditioned by the factors of an older one.

use super::condensed::Condensed;
use super::factors::{ratio, scale_pressure, scale_rows};
use super::linear::{Full, Linear};
use crate::algebra::SolverError;
use crate::nonlinear::Seconds;
use crate::physics::StepRule;
use crate::system::{Assembler, StepView};
use crate::tangent::{Linearization, Tangent};
use std::time::Instant;

impl Linear {
    /// Whether factors may be older than the matrix.
    pub fn is_iterative(&self) -> bool {
        self.krylov.is_some()
    }

    /// Assemble at the iterate of `view`, and keep the factors.
    ///
    /// # Errors
    /// If there are none.
    pub fn refresh<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        tangent: Tangent,
        seconds: &mut Seconds,
    ) -> Result<(), SolverError> {
        let start = Instant::now();
        match (self.active, &mut self.full, &mut self.condensed) {
            (Linearization::Condensed, _, Some(condensed)) => condensed.refresh(assembler, view, tangent),
            (Linearization::Condensed, ..) | (_, None, _) => return Err(SolverError::NotFactored),
            (linearization, Some(full), _) => full.refresh(assembler, view, linearization, tangent),
        }
        seconds.assembly += start.elapsed().as_secs_f64();
        Ok(())
    }
}

impl Full {
    fn refresh<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        linearization: Linearization,
        tangent: Tangent,
    ) {
        assembler.matrix(view, linearization, tangent, &mut self.matrix);
        if let Some(krylov) = &mut self.krylov {
            krylov.scales.weights(&assembler.space, view.rule.per_k, &mut krylov.weights);
            krylov.begin();
        }
    }

    /// δ for `r` with the matrix at hand and older factors.
    pub(super) fn iterate<const D: usize>(
        &mut self,
        assembler: &Assembler<D>,
        rule: &StepRule,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        let Some(krylov) = &mut self.krylov else { return Err(SolverError::NotFactored) };
        let ratio = ratio(&self.rule, rule).unwrap_or(1.0);
        let before = |r: &mut [f64]| {
            if ratio != 1.0 {
                scale_rows(assembler, 1.0 / ratio, r);
            }
        };
        let after = |z: &mut [f64]| scale_pressure(assembler, ratio, z);
        krylov.solve(&mut *self.solver, &self.matrix, (before, after), r, delta)
    }
}

impl Condensed {
    fn refresh<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        tangent: Tangent,
    ) {
        assembler.condensed_matrix(view, tangent, &mut self.matrix);
        if let Some(krylov) = &mut self.krylov {
            krylov.scales.weights(&assembler.space, view.rule.per_k, &mut self.work);
            for (weight, &place) in krylov.weights.iter_mut().zip(&self.system.places) {
                *weight = self.work[place as usize];
            }
            krylov.begin();
        }
    }

    /// `x` for `b` with the matrix at hand and older factors.
    pub(super) fn iterate<const D: usize>(
        &mut self,
        assembler: &Assembler<D>,
        rule: &StepRule,
    ) -> Result<usize, SolverError> {
        let Some(krylov) = &mut self.krylov else { return Err(SolverError::NotFactored) };
        let n_v = assembler.space.n_v();
        let (places, ratio) = (&self.system.places, ratio(&self.rule, rule).unwrap_or(1.0));
        let scale = |list: &mut [f64], velocity: bool, factor: f64| {
            if factor != 1.0 {
                let of_field = |place: u32| ((place as usize) < n_v) == velocity;
                let entries = list.iter_mut().zip(places).filter(|(_, place)| of_field(**place));
                entries.for_each(|(value, _)| *value *= factor);
            }
        };
        let (before, after) =
            (|r: &mut [f64]| scale(r, true, 1.0 / ratio), |z: &mut [f64]| scale(z, false, ratio));
        krylov.solve(&mut *self.solver, &self.matrix, (before, after), &self.b, &mut self.x)
    }
}
