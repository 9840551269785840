//! A matrix with its factors or those of an older one: how solvers are made, and how factors serve a step with another
//! k.

use super::krylov::{Krylov, KrylovSettings};
use super::price::Work;
use super::relation;
use super::scales::Scales;
use crate::algebra::{Cost, Csr, LinearOperator, LinearSolver, Pattern, Sizes, SolverError, Unknown};
use crate::parallel::Halo;
use crate::physics::StepRule;
use crate::space::FsiSpace;
use crate::system::Assembler;
use std::sync::Arc;

/// Makes linear solvers of the kind that the case asks for.
pub type MakeSolver = Box<dyn Fn(Purpose) -> Box<dyn LinearSolver> + Send>;

/// What a linear solver is for.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The whole Jacobian of a step.
    Whole,
    /// The condensed system of a step.
    Condensed,
    /// Other solutions, as exact as can be.
    Exact,
    /// Other corrections in an iteration that sees its own residual.
    Correction,
    /// The same where the matrix is symmetric and should be positive definite.
    Definite,
    /// The coarsest level of multigrid, of which every process has all.
    Coarsest,
}

/// A matrix in double precision, or in single where GMRES needs no more.
pub(super) enum Held {
    Double(Csr),
    /// Shared with the solver but while it is filled.
    Single(Arc<Csr<f32>>),
}

/// A matrix to be filled.
pub(super) enum Fill<'a> {
    Double(&'a mut Csr),
    Single(&'a mut Csr<f32>),
}

/// A matrix, and the factors of it or of an older one.
pub(super) struct Factored {
    matrix: Held,
    pattern: Arc<Pattern>,
    solver: Box<dyn LinearSolver>,
    /// Rule of the step that the factors are of.
    rule: StepRule,
    krylov: Option<Krylov>,
    /// Where processes share the unknowns.
    halo: Option<Arc<Halo>>,
}

impl Factored {
    /// For matrices of `pattern`, with GMRES if there are settings for it.
    pub(super) fn new(
        pattern: &Arc<Pattern>,
        unknowns: &[Unknown],
        mut solver: Box<dyn LinearSolver>,
        krylov: Option<KrylovSettings>,
        halo: Option<Arc<Halo>>,
    ) -> Result<Factored, SolverError> {
        let single = krylov.is_some() && solver.takes_single();
        solver.analyse(pattern, unknowns)?;
        let krylov = krylov.map(|settings| Krylov::new(settings, pattern.n, halo.clone()));
        let matrix = if single {
            Held::Single(Arc::new(Csr::blank(pattern)))
        } else {
            Held::Double(Csr::zeros(pattern))
        };
        let (pattern, rule) = (Arc::clone(pattern), StepRule::STATIONARY);
        Ok(Factored { matrix, pattern, solver, rule, krylov, halo })
    }

    /// Let `assemble` fill the matrix, whose factors stay.
    pub(super) fn fill(&mut self, assemble: impl FnOnce(Fill<'_>)) {
        match &mut self.matrix {
            Held::Double(matrix) => assemble(Fill::Double(matrix)),
            Held::Single(matrix) => {
                self.solver.hold(None);
                assemble(Fill::Single(Arc::make_mut(matrix)));
                self.solver.hold(Some(matrix));
            }
        }
    }

    /// Factorise the matrix, which is that of a step by `rule`.
    pub(super) fn factor(&mut self, rule: StepRule, sizes: Sizes) -> Result<(), SolverError> {
        self.rule = rule;
        let exact = self.solver.is_exact();
        self.krylov.iter_mut().for_each(|krylov| krylov.active = !exact);
        self.solver.set_sizes(sizes);
        match &self.matrix {
            Held::Double(matrix) => self.solver.factor(matrix).map(|_| ()),
            Held::Single(matrix) => self.solver.factor_single(matrix).map(|_| ()),
        }
    }

    /// Whether the factors solve the system of their matrix.
    pub(super) fn is_exact(&self) -> bool {
        self.solver.is_exact()
    }

    /// The matrix is newer than the factors; `set` sets the weights of its rows.
    pub(super) fn precondition(&mut self, set: impl FnOnce(&Scales, &mut [f64])) {
        if let Some(krylov) = &mut self.krylov {
            krylov.begin(set);
        }
    }

    /// Whether the factors are of an older matrix than the one at hand.
    pub(super) fn are_old(&self) -> bool {
        self.krylov.as_ref().is_some_and(|krylov| krylov.active)
    }

    /// How many times the matrix of a step by `rule` is that of the factors, where this is all that differs: in
    /// k⁻¹M + θA with equal kθ, as in the parts of fractional-step θ. `None`: once, or more differs.
    pub(super) fn ratio(&self, rule: &StepRule) -> Option<f64> {
        let coupling = |rule: &StepRule| rule.theta / rule.per_k;
        let equal = (coupling(&self.rule) - coupling(rule)).abs() <= 1e-9 * coupling(rule);
        (equal && self.rule.per_k != rule.per_k).then_some(rule.per_k / self.rule.per_k)
    }

    /// Whether the solver, which shares the matrix, cannot take that of a step by `rule` for the one of its factors: with
    /// another k sweeps would need five times as many iterations.
    pub(super) fn is_of_other_step(&self, rule: &StepRule) -> bool {
        let same = self.rule.per_k == rule.per_k && self.rule.theta == rule.theta;
        matches!(self.matrix, Held::Single(_)) && !same
    }

    /// x ← A⁻¹ b to the last digits, with iterative refinement; returns how many times the factors were applied.
    pub(super) fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<usize, SolverError> {
        let Held::Double(matrix) = &self.matrix else { return Err(SolverError::NotFactored) };
        Ok(1 + self.solver.solve(matrix, b, x)?.refinements)
    }

    /// x ← A⁻¹ b as far as an iteration needs it that sees its own residual; returns how many times the factors were
    /// applied.
    pub(super) fn correct(&mut self, b: &[f64], x: &mut [f64]) -> Result<usize, SolverError> {
        match &self.matrix {
            Held::Double(matrix) => self.solver.correct(matrix, b, x),
            Held::Single(_) => Err(SolverError::NotFactored),
        }
    }

    /// x ← A⁻¹ b by GMRES; `before` and `after` make the factors those of a step with another k.
    pub(super) fn iterate(
        &mut self,
        (before, after): (impl Fn(&mut [f64]), impl Fn(&mut [f64])),
        b: &[f64],
        x: &mut [f64],
    ) -> Result<usize, SolverError> {
        let Factored { matrix, solver, krylov: Some(krylov), .. } = self else {
            return Err(SolverError::NotFactored);
        };
        let precondition = |r: &mut [f64], z: &mut [f64]| {
            before(r);
            solver.apply(r, z);
            after(z);
        };
        let a: &dyn LinearOperator = match matrix {
            Held::Double(matrix) => matrix,
            Held::Single(matrix) => &**matrix,
        };
        krylov.solve(a, precondition, b, x)
    }

    /// What applies its factors.
    pub(super) fn solver(&self) -> &dyn LinearSolver {
        &*self.solver
    }

    /// Rows of the matrix.
    pub(super) fn rows(&self) -> usize {
        self.pattern.n
    }

    /// What it does in a system of `unknowns`, which has an `extension` apart or not.
    pub(super) fn work(&self, unknowns: usize, extension: Option<Cost>) -> Work {
        let (rows, entries) = (self.pattern.n, self.pattern.nnz());
        let (factors, iterative) = (self.solver.predicted(), self.krylov.is_some());
        Work { unknowns, rows, entries, factors, extension, iterative, halo: self.halo.clone() }
    }
}

/// Tells a solver of the unknowns at `places` in \[v, u, p\] that processes share them, if they do, and returns how.
///
/// # Errors
/// If MPI fails.
pub(super) fn share<const D: usize>(
    space: &FsiSpace<D>,
    places: impl Iterator<Item = u32>,
    solver: &mut dyn LinearSolver,
) -> Result<Option<Arc<Halo>>, SolverError> {
    let Some(halo) = space.halo(places) else { return Ok(None) };
    let halo = Arc::new(halo.map_err(|fault| SolverError::Engine(fault.to_string()))?);
    solver.share(Arc::clone(&halo));
    Ok(Some(halo))
}

/// Scale the rows that have k⁻¹M + θA: momentum and velocity-deformation relation.
pub(super) fn scale_rows<const D: usize>(assembler: &Assembler<D>, factor: f64, r: &mut [f64]) {
    let space = &assembler.space;
    let (v, rest) = r.split_at_mut(space.n_v());
    v.iter_mut().for_each(|r| *r *= factor);
    relation::places(assembler).for_each(|place| rest[place] *= factor);
}

/// The pressure is not multiplied by θ: its correction makes up for the scaled rows.
pub(super) fn scale_pressure<const D: usize>(assembler: &Assembler<D>, factor: f64, delta: &mut [f64]) {
    let space = &assembler.space;
    delta[space.n_v() + space.n_u()..].iter_mut().for_each(|p| *p *= factor);
}
