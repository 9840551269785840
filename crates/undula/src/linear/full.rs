//! Corrections by the whole Jacobian, or what the chosen linearisation leaves of it.

use super::correction::{At, Correction};
use super::factors::{Factored, scale_pressure, scale_rows};
use super::krylov::KrylovSettings;
use super::price::Work;
use crate::algebra::{LinearSolver, SolverError};
use crate::physics::StepRule;
use crate::space::FsiSpace;
use crate::system::{Assembler, StepView};

/// The matrix of [v, u, p].
pub(super) struct Full {
    factored: Factored,
    /// A right-hand side that had to be scaled.
    work: Vec<f64>,
}

impl Full {
    pub(super) fn new<const D: usize>(
        assembler: &mut Assembler<D>,
        solver: Box<dyn LinearSolver>,
        krylov: Option<KrylovSettings>,
    ) -> Result<Full, SolverError> {
        let pattern = assembler.try_pattern()?;
        let factored = Factored::new(&pattern, &assembler.unknowns(), solver, krylov)?;
        Ok(Full { factored, work: vec![] })
    }

    /// By GMRES, with factors of an older matrix.
    fn iterate<const D: usize>(
        &mut self,
        assembler: &Assembler<D>,
        rule: &StepRule,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        let ratio = self.factored.ratio(rule).unwrap_or(1.0);
        let before = |r: &mut [f64]| {
            if ratio != 1.0 {
                scale_rows(assembler, 1.0 / ratio, r);
            }
        };
        let after = |z: &mut [f64]| scale_pressure(assembler, ratio, z);
        self.factored.iterate((before, after), r, delta)
    }
}

impl<const D: usize> Correction<D> for Full {
    fn factored(&mut self) -> &mut Factored {
        &mut self.factored
    }

    fn assemble(&mut self, At { assembler, view, linearization, tangent }: &mut At<'_, D>) {
        assembler.matrix(view, *linearization, *tangent, &mut self.factored.matrix);
    }

    fn precondition(&mut self, space: &FsiSpace<D>, per_k: f64) {
        self.factored.precondition(|scales, weights| scales.weights(space, per_k, weights));
    }

    fn correct(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        _settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        if self.factored.are_old() {
            return self.iterate(assembler, &view.rule, r, delta);
        }
        let Some(ratio) = self.factored.ratio(&view.rule) else { return self.factored.solve(r, delta) };
        self.work.clear();
        self.work.extend_from_slice(r);
        scale_rows(assembler, 1.0 / ratio, &mut self.work);
        let applied = self.factored.solve(&self.work, delta)?;
        scale_pressure(assembler, ratio, delta);
        Ok(applied)
    }

    fn work(&self) -> Work {
        self.factored.work(self.factored.matrix.pattern.n, None)
    }
}
