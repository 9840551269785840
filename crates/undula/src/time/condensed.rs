//! Corrections from the condensed system: (v, p), then u in the solid, then the extension.

use super::extension::Extension;
use super::factors::{MakeSolver, Purpose, ratio, relation, scale_pressure, scale_rows};
use super::krylov::{Krylov, KrylovSettings};
use crate::algebra::{Csr, LinearSolver, SolverError};
use crate::physics::StepRule;
use crate::system::{Assembler, CondensedSystem, StepView};
use std::sync::Arc;

/// The matrix of (v, p), its factors, and what follows from (v, p).
pub(super) struct Condensed {
    pub(super) system: Arc<CondensedSystem>,
    pub(super) matrix: Csr,
    pub(super) solver: Box<dyn LinearSolver>,
    /// Rule of the step that the factors are of.
    pub(super) rule: StepRule,
    pub(super) krylov: Option<Krylov>,
    pub(super) extension: Option<Extension>,
    /// Nodes where δu = kθ δv.
    relation: Vec<u32>,
    pub(super) b: Vec<f64>,
    pub(super) x: Vec<f64>,
    pub(super) work: Vec<f64>,
}

impl Condensed {
    pub(super) fn new<const D: usize>(
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        make: &MakeSolver,
        krylov: Option<KrylovSettings>,
    ) -> Result<Condensed, SolverError> {
        let system = assembler.try_condensed()?;
        let mut solver = make(Purpose::Correction);
        solver.analyse(&system.pattern, &system.unknowns)?;
        let extension = Extension::new(assembler, view, make)?;
        let relation = relation(assembler).map(|node| node as u32).collect();
        let n = system.places.len();
        Ok(Condensed {
            matrix: Csr::zeros(&system.pattern),
            solver,
            rule: StepRule::STATIONARY,
            krylov: krylov.map(|settings| Krylov::new(settings, n)),
            extension,
            relation,
            b: vec![0.0; n],
            x: vec![0.0; n],
            work: vec![0.0; assembler.space.n_unknowns()],
            system,
        })
    }

    /// δ from the residual `r` \[v, u, p\]; with `settled` that of the extension is taken for zero. Returns how many times
    /// factors were applied.
    pub(super) fn correct<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        self.work.copy_from_slice(r);
        let stale = self.krylov.as_ref().is_some_and(|krylov| krylov.active);
        // The blocks of the cells are those of the matrix, not of the factors.
        let ratio = ratio(&self.rule, &view.rule).filter(|_| !stale);
        if let Some(ratio) = ratio {
            scale_rows(assembler, 1.0 / ratio, &mut self.work);
        }
        assembler.eliminate_inner(&mut self.work);
        for (b, &place) in self.b.iter_mut().zip(&self.system.places) {
            *b = self.work[place as usize];
        }
        let iterations = if stale {
            self.iterate(assembler, &view.rule)?
        } else {
            self.solver.apply(&self.b, &mut self.x);
            1
        };
        delta.fill(0.0);
        for (x, &place) in self.x.iter().zip(&self.system.places) {
            delta[place as usize] = *x;
        }
        assembler.recover_inner(delta);
        if let Some(ratio) = ratio {
            scale_pressure(assembler, ratio, delta);
        }
        let n_v = assembler.space.n_v();
        if !self.relation.is_empty() {
            let factor = view.rule.theta / view.rule.per_k;
            let (v, u) = delta.split_at_mut(n_v);
            for &node in &self.relation {
                for at in node as usize * D..(node as usize + 1) * D {
                    u[at] = factor * v[at];
                }
            }
        }
        if let Some(extension) = &mut self.extension {
            extension.solve((!settled).then_some(r), delta);
            for (place, x) in extension.values() {
                delta[place] = x;
            }
        }
        Ok(iterations)
    }

    /// Subtract from `u` the extension of the update of the solid in `work`, whose other entries are zero.
    pub(super) fn follow(&mut self, u: &mut [f64], n_v: usize) {
        let Some(extension) = &mut self.extension else { return };
        extension.solve(Some(&self.work), &self.work);
        for (place, x) in extension.values() {
            u[place - n_v] -= x;
        }
    }
}
