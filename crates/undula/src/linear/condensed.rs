//! Corrections from the condensed system: (v, p), then u in the solid, then the extension.

use super::correction::{At, Correction};
use super::extension::Extension;
use super::factors::{Factored, Fill, MakeSolver, Purpose, scale_pressure, scale_rows, share};
use super::krylov::KrylovSettings;
use super::price::Work;
use super::relation;
use crate::algebra::{LinearSolver, SolverError};
use crate::multigrid::{self, System, Tiers};
use crate::physics::StepRule;
use crate::space::{FsiSpace, State};
use crate::system::{Assembler, CondensedSystem, StepView};
use std::sync::Arc;

/// The matrix of (v, p), and what follows from (v, p).
pub(super) struct Condensed<const D: usize> {
    system: Arc<CondensedSystem>,
    factored: Factored,
    extension: Option<Extension<D>>,
    /// Places in u where δu = kθ δv.
    relation: Vec<u32>,
    b: Vec<f64>,
    x: Vec<f64>,
    /// A vector \[v, u, p\].
    work: Vec<f64>,
}

impl<const D: usize> Condensed<D> {
    /// With the extension at the iterate of `view`.
    pub(super) fn new(
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        make: &MakeSolver,
        (krylov, multigrid): (Option<KrylovSettings>, Option<multigrid::Settings>),
    ) -> Result<Condensed<D>, SolverError> {
        assembler.eliminate_in_long_cells(multigrid.is_some());
        let system = assembler.try_condensed()?;
        let mut solver: Box<dyn LinearSolver> = match multigrid {
            Some(settings) => {
                let places = System::Flow { given: &assembler.is_given(), places: &system.places };
                let tiers = Tiers::new(&assembler.space, places)?;
                multigrid::multigrid(settings, tiers, make(Purpose::Coarsest))
            }
            None => make(Purpose::Condensed),
        };
        let halo = share(&assembler.space, system.places.iter().copied(), &mut *solver)?;
        let factored = Factored::new(&system.pattern, &system.unknowns, solver, krylov, halo)?;
        let extension = Extension::new(assembler, view, make, multigrid)?;
        // Its coarser meshes were all that was still needed.
        assembler.space.part.iter().for_each(|part| part.forget());
        let relation = relation::places(assembler).map(|place| place as u32).collect();
        let n = system.places.len();
        Ok(Condensed {
            factored,
            extension,
            relation,
            b: vec![0.0; n],
            x: vec![0.0; n],
            work: vec![0.0; assembler.space.n_field_unknowns()],
            system,
        })
    }

    /// (v, p) of δ from the residual `r`. Returns how many times factors were applied.
    fn solve(
        &mut self,
        assembler: &mut Assembler<D>,
        rule: &StepRule,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        self.work.copy_from_slice(r);
        let are_old = self.factored.are_old();
        // The blocks of the cells are those of the matrix, not of the factors.
        let ratio = self.factored.ratio(rule).filter(|_| !are_old);
        if let Some(ratio) = ratio {
            scale_rows(assembler, 1.0 / ratio, &mut self.work);
        }
        assembler.eliminate_inner(&mut self.work);
        assembler.project(&mut self.work);
        for (b, &place) in self.b.iter_mut().zip(&self.system.places) {
            *b = self.work[place as usize];
        }
        let applied = if are_old {
            self.iterate(assembler.space.n_v(), rule)?
        } else {
            self.factored.correct(&self.b, &mut self.x)?
        };
        delta.fill(0.0);
        for (x, &place) in self.x.iter().zip(&self.system.places) {
            delta[place as usize] = *x;
        }
        assembler.recover_inner(delta);
        if let Some(ratio) = ratio {
            scale_pressure(assembler, ratio, delta);
        }
        Ok(applied)
    }

    /// `x` for `b` by GMRES, with factors of an older matrix; the first `n_v` unknowns are velocities.
    fn iterate(&mut self, n_v: usize, rule: &StepRule) -> Result<usize, SolverError> {
        let (places, ratio) = (&self.system.places, self.factored.ratio(rule).unwrap_or(1.0));
        let scale = |list: &mut [f64], velocity: bool, factor: f64| {
            if factor != 1.0 {
                let of_field = |place: u32| ((place as usize) < n_v) == velocity;
                let entries = list.iter_mut().zip(places).filter(|(_, place)| of_field(**place));
                entries.for_each(|(value, _)| *value *= factor);
            }
        };
        let (before, after) =
            (|r: &mut [f64]| scale(r, true, 1.0 / ratio), |z: &mut [f64]| scale(z, false, ratio));
        self.factored.iterate((before, after), &self.b, &mut self.x)
    }
}

impl<const D: usize> Correction<D> for Condensed<D> {
    fn factored(&mut self) -> &mut Factored {
        &mut self.factored
    }

    fn assemble(&mut self, At { assembler, view, tangent, .. }: &mut At<'_, D>) {
        self.factored.fill(|matrix| match matrix {
            Fill::Double(matrix) => assembler.condensed_matrix(view, *tangent, matrix),
            Fill::Single(matrix) => assembler.condensed_matrix(view, *tangent, matrix),
        });
    }

    fn precondition(&mut self, space: &FsiSpace<D>, per_k: f64) {
        let Condensed { factored, work, system, .. } = self;
        factored.precondition(|scales, weights| {
            scales.weights(space, per_k, work);
            for (weight, &place) in weights.iter_mut().zip(&system.places) {
                *weight = work[place as usize];
            }
        });
    }

    fn correct(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        let applied = self.solve(assembler, &view.rule, r, delta)?;
        if !self.relation.is_empty() {
            let factor = view.rule.theta / view.rule.per_k;
            let (v, u) = delta.split_at_mut(assembler.space.n_v());
            for at in self.relation.iter().map(|&at| at as usize) {
                u[at] = factor * v[at];
            }
        }
        if let Some(extension) = &mut self.extension {
            extension.solve((!settled).then_some(r), delta);
            for (place, x) in extension.values() {
                delta[place] = x;
            }
        }
        Ok(applied)
    }

    fn solvers(&self) -> Vec<&dyn LinearSolver> {
        let extension = self.extension.iter().map(Extension::solver);
        [self.factored.solver()].into_iter().chain(extension).collect()
    }

    fn work(&self) -> Work {
        self.factored.work(self.work.len(), self.extension.as_ref().and_then(Extension::predicted))
    }

    fn renew_extension(&mut self, assembler: &Assembler<D>, view: &StepView<'_>) -> Result<(), SolverError> {
        self.extension.as_mut().map_or(Ok(()), |extension| extension.renew(assembler, view))
    }

    /// The solid moves, and its extension with it.
    fn follow(
        &mut self,
        assembler: &Assembler<D>,
        rule: StepRule,
        new: &mut State,
        old: &State,
        moved: &[(usize, f64)],
    ) {
        let n_v = assembler.space.n_v();
        self.work.fill(0.0);
        moved.iter().for_each(|&(at, change)| self.work[n_v + at] = change);
        relation::impose(assembler, rule, new, old, |at, change| self.work[n_v + at] = change);
        let Some(extension) = &mut self.extension else { return };
        // A run that goes on from a checkpoint has no others.
        extension.forget();
        extension.solve(Some(&self.work), &self.work);
        extension.values().for_each(|(place, x)| self.work[place] = x);
        assembler.project(&mut self.work);
        extension.values().for_each(|(place, _)| new.u[place - n_v] -= self.work[place]);
    }
}
