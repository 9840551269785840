//! How an update follows from a residual: with the whole Jacobian, or condensed to (v, p) as in `condensed.rs`.

use super::condensed::Condensed;
use super::extension::Extension;
use super::factors::{MakeSolver, Purpose, ratio, relation, scale_pressure, scale_rows};
use super::krylov::{Krylov, KrylovSettings};
use crate::algebra::{Cost, Csr, LinearSolver, Sizes, SolverError};
use crate::nonlinear::Seconds;
use crate::physics::StepRule;
use crate::space::State;
use crate::system::{Assembler, StepView};
use crate::tangent::{Linearization, Tangent};
use std::time::Instant;

/// Steps with the whole Jacobian after one that another linearisation could not do.
const DETOUR: u32 = 10;

/// A new Jacobian in iterations where the solver does not tell what it does.
const TYPICAL_PRICE: f64 = 5.0;

/// Nanoseconds of one core of a typical machine: per unknown for a Jacobian and the overhead of its fronts, for that
/// alone, and for the residual and vectors of an iteration; operations and bytes of the factors per nanosecond.
const JACOBIAN: f64 = 300.0;
const FRONTS: f64 = 100.0;
const ITERATION: f64 = 25.0;
const OPERATIONS: f64 = 30.0;
const BYTES: f64 = 5.0;

/// Bytes of an entry of a matrix, and for a row those of the vectors of an iteration of GMRES.
const ENTRY: f64 = 12.0;
const ROW: f64 = 100.0;

/// The whole matrix and the condensed one, each made when first needed.
pub struct Linear {
    /// The one in use.
    pub active: Linearization,
    /// The one that was asked for.
    chosen: Linearization,
    /// Steps to go with the whole Jacobian after that has failed.
    pub detour: u32,
    make: MakeSolver,
    /// Typical sizes of the unknowns in a step, for the factorisations to come.
    pub sizes: Sizes,
    /// GMRES, if factors may be older than the matrix.
    pub(super) krylov: Option<KrylovSettings>,
    pub(super) full: Option<Full>,
    pub(super) condensed: Option<Condensed>,
}

pub(super) struct Full {
    pub(super) matrix: Csr,
    pub(super) solver: Box<dyn LinearSolver>,
    /// Rule of the step that the factors are of.
    pub(super) rule: StepRule,
    pub(super) krylov: Option<Krylov>,
    /// A right-hand side that had to be scaled.
    work: Vec<f64>,
}

impl Linear {
    /// Nothing is prepared yet.
    pub fn new(chosen: Linearization, make: MakeSolver) -> Linear {
        let sizes = Sizes::default();
        Linear { active: chosen, chosen, detour: 0, make, sizes, krylov: None, full: None, condensed: None }
    }

    /// With GMRES: factors are kept longer than matrices.
    #[must_use]
    pub fn with_krylov(mut self, settings: Option<KrylovSettings>) -> Linear {
        self.krylov = settings;
        self
    }

    /// Take the whole Jacobian for some steps; `false` if it is in use already.
    pub fn fall_back(&mut self) -> bool {
        if self.active == Linearization::Newton {
            return false;
        }
        (self.active, self.detour) = (Linearization::Newton, DETOUR);
        true
    }

    /// As it was when a run was left; nothing if that is to go on with the whole Jacobian anyway.
    pub fn set_detour(&mut self, steps: u32) {
        if steps > 0 && self.active != Linearization::Newton {
            (self.active, self.detour) = (Linearization::Newton, steps);
        }
    }

    /// A step is done; `true` if the linearisation that was asked for takes over again.
    pub fn count_step(&mut self) -> bool {
        if self.detour == 0 {
            return false;
        }
        self.detour -= 1;
        if self.detour == 0 {
            self.active = self.chosen;
        }
        self.detour == 0
    }

    /// Assemble and factorise at the iterate of `view`.
    ///
    /// # Errors
    /// If the matrix is singular, or memory is short.
    pub fn renew<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        tangent: Tangent,
        seconds: &mut Seconds,
    ) -> Result<(), SolverError> {
        let start = Instant::now();
        match self.active {
            Linearization::Newton | Linearization::Reduced | Linearization::FixedPoint => {
                let full = match &mut self.full {
                    Some(full) => full,
                    none => none.insert(Full::new(assembler, (self.make)(Purpose::Exact), self.krylov)?),
                };
                full.rule = view.rule;
                full.krylov.iter_mut().for_each(|krylov| krylov.active = false);
                assembler.matrix(view, self.active, tangent, &mut full.matrix);
                let assembled = Instant::now();
                seconds.assembly += (assembled - start).as_secs_f64();
                full.solver.set_sizes(self.sizes);
                let factored = full.solver.factor(&full.matrix);
                seconds.factorization += assembled.elapsed().as_secs_f64();
                factored?;
            }
            Linearization::Condensed => {
                let condensed = match &mut self.condensed {
                    Some(condensed) => {
                        if let Some(extension) = &mut condensed.extension {
                            extension.renew(assembler, view)?;
                        }
                        condensed
                    }
                    none => none.insert(Condensed::new(assembler, view, &self.make, self.krylov)?),
                };
                condensed.rule = view.rule;
                condensed.krylov.iter_mut().for_each(|krylov| krylov.active = false);
                assembler.condensed_matrix(view, tangent, &mut condensed.matrix);
                let assembled = Instant::now();
                seconds.assembly += (assembled - start).as_secs_f64();
                condensed.solver.set_sizes(self.sizes);
                let factored = condensed.solver.factor(&condensed.matrix);
                seconds.factorization += assembled.elapsed().as_secs_f64();
                factored?;
            }
        }
        Ok(())
    }

    /// δ from the residual `r` \[v, u, p\] by the factors at hand; with `settled` the condensed system takes the
    /// residual of the extension for zero, which is cheaper. Returns how many times factors were applied.
    ///
    /// # Errors
    /// If the solution is inaccurate or there are no factors.
    pub fn correct<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        match (self.active, &mut self.full, &mut self.condensed) {
            (Linearization::Condensed, _, Some(condensed)) => {
                condensed.correct(assembler, view, settled, r, delta)
            }
            (Linearization::Condensed, ..) | (_, None, _) => Err(SolverError::NotFactored),
            (_, Some(full), _) => full.correct(assembler, view, r, delta),
        }
    }

    /// What a new Jacobian costs, in iterations, or with GMRES its factors in those: estimated from numbers of
    /// unknowns, operations and bytes, so that it is the same on every run.
    pub fn price(&self) -> f64 {
        let (unknowns, matrix, solver, others) = match (self.active, &self.full, &self.condensed) {
            (Linearization::Condensed, _, Some(condensed)) => {
                let others = condensed.extension.as_ref().and_then(Extension::predicted);
                (condensed.work.len(), &condensed.matrix, &condensed.solver, others)
            }
            (Linearization::Condensed, ..) | (_, None, _) => return TYPICAL_PRICE,
            (_, Some(full), _) => (full.matrix.pattern.n, &full.matrix, &full.solver, None),
        };
        let (Some(factors), unknowns) = (solver.predicted(), unknowns as f64) else { return TYPICAL_PRICE };
        let bytes = |cost: &Cost| cost.read.unwrap_or(0) as f64;
        let numeric = factors.flops.unwrap_or(0.0) / OPERATIONS;
        if self.krylov.is_some() {
            let (rows, entries) = (matrix.pattern.n as f64, matrix.pattern.nnz() as f64);
            let iteration = (bytes(&factors) + ENTRY * entries + ROW * rows) / BYTES;
            return (FRONTS * unknowns + numeric) / iteration;
        }
        let renewal = JACOBIAN * unknowns + numeric;
        let iteration = ITERATION * unknowns + (bytes(&factors) + others.as_ref().map_or(0.0, bytes)) / BYTES;
        renewal / iteration
    }

    /// Make `new` satisfy the velocity-deformation relation at the nodes, where the condensed system takes
    /// it for granted; with `follow` the extension goes along: the fluid then sees at once what a step behind the
    /// solid would cost half an iteration later, and a solid that moves by more than the size of a cell
    /// does not fold its neighbours.
    pub fn start<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        rule: StepRule,
        new: &mut State,
        old: &State,
        follow: bool,
    ) {
        if self.active != Linearization::Condensed || relation(assembler).next().is_none() {
            return;
        }
        if follow && self.condensed.is_none() {
            // What goes wrong here goes wrong again, and is told, where the matrix is made.
            let view = StepView { rule, new, old };
            self.condensed = Condensed::new(assembler, &view, &self.make, self.krylov).ok();
        }
        let mut condensed = self.condensed.as_mut().filter(|_| follow);
        if let Some(condensed) = &mut condensed {
            condensed.work.fill(0.0);
        }
        let (n_v, k) = (assembler.space.n_v(), 1.0 / rule.per_k);
        for node in relation(assembler) {
            for at in node * D..(node + 1) * D {
                let u = old.u[at] + k * (rule.theta * new.v[at] + (1.0 - rule.theta) * old.v[at]);
                if let Some(condensed) = &mut condensed {
                    condensed.work[n_v + at] = new.u[at] - u;
                }
                new.u[at] = u;
            }
        }
        if let Some(condensed) = condensed {
            condensed.follow(&mut new.u, n_v);
        }
    }
}

impl Full {
    fn new<const D: usize>(
        assembler: &mut Assembler<D>,
        mut solver: Box<dyn LinearSolver>,
        krylov: Option<KrylovSettings>,
    ) -> Result<Full, SolverError> {
        let pattern = assembler.try_pattern()?;
        solver.analyse(&pattern, &assembler.unknowns())?;
        let krylov = krylov.map(|settings| Krylov::new(settings, pattern.n));
        let matrix = Csr::zeros(&pattern);
        Ok(Full { matrix, solver, rule: StepRule::STATIONARY, krylov, work: vec![] })
    }

    fn correct<const D: usize>(
        &mut self,
        assembler: &Assembler<D>,
        view: &StepView<'_>,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        if self.krylov.as_ref().is_some_and(|krylov| krylov.active) {
            return self.iterate(assembler, &view.rule, r, delta);
        }
        let Some(ratio) = ratio(&self.rule, &view.rule) else {
            return Ok(1 + self.solver.solve(&self.matrix, r, delta)?.refinements);
        };
        self.work.clear();
        self.work.extend_from_slice(r);
        scale_rows(assembler, 1.0 / ratio, &mut self.work);
        let report = self.solver.solve(&self.matrix, &self.work, delta)?;
        scale_pressure(assembler, ratio, delta);
        Ok(1 + report.refinements)
    }
}
