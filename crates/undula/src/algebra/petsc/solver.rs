//! PETSc as a linear solver: scaling of fields, and a residual of our own after every solve.

use super::access::{Access, Engine, engine};
use super::error::{Missing, Trouble};
use super::fields;
use super::prepared::Prepared;
use super::system::Outcome;
use crate::algebra::{
    Cost, Csr, FactorReport, LinearSolver, Pattern, Sizes, SolveReport, SolverError, Unknown,
};
use crate::parallel::Halo;
use std::sync::Arc;

/// Backward error at which refinement of a direct solver stops.
const TARGET: f64 = 1e-12;

/// Backward error of a solve that counts as one of a direct solver.
const BACKWARD: f64 = 1e-9;

/// Solver of PETSc, made from a string of options.
///
/// The system is scaled by fields: with the typical size s of the unknowns of a field, and the geometric mean of
/// Σ |a_ij| s_j over the rows of a field, which divides them. Within a field nothing changes, so that symmetric blocks and
/// their near null spaces stay what they are. After a solve the residual is computed from our own matrix: the solve
/// counts if
/// ```text
///     ‖b − A x‖₂ ≤ 10 rtol ‖b‖₂   or   ‖b − A x‖∞ ≤ 1e-9 (‖A‖∞ ‖x‖∞ + ‖b‖∞)
/// ```
/// in scaled variables, the second alone where PETSc does not iterate (`-ksp_type preonly`). Then there are steps of
/// refinement, too.
#[derive(Debug)]
pub struct PetscSolver {
    options: String,
    refinement: usize,
    pattern: Option<Arc<Pattern>>,
    unknowns: Vec<Unknown>,
    sizes: Sizes,
    /// Where processes share the unknowns.
    halo: Option<Arc<Halo>>,
    prepared: Option<Prepared>,
    factored: bool,
    /// Scaled right-hand side, and what is added to the solution.
    work: [Vec<f64>; 2],
    residual: Vec<f64>,
}

/// What all calls need: the engine, with no other thread in it.
fn access() -> Result<Access, SolverError> {
    engine().and_then(Engine::access).map_err(|missing: Missing| SolverError::Engine(missing.to_string()))
}

fn said(trouble: Trouble) -> SolverError {
    SolverError::Engine(trouble.to_string())
}

impl PetscSolver {
    /// A solver by `options`, with at most so many steps of `refinement` if it is direct; it knows no matrix yet.
    pub fn new(options: &str, refinement: usize) -> PetscSolver {
        PetscSolver {
            options: options.into(),
            refinement,
            pattern: None,
            unknowns: vec![],
            sizes: Sizes::default(),
            halo: None,
            prepared: None,
            factored: false,
            work: [vec![], vec![]],
            residual: vec![],
        }
    }

    /// Solves, refines and judges.
    fn solve_and_judge(&mut self, a: &Csr, b: &[f64], x: &mut [f64]) -> Result<SolveReport, SolverError> {
        let PetscSolver { prepared: Some(prepared), unknowns, work: [right, step], residual, .. } = self
        else {
            return Err(SolverError::NotFactored);
        };
        let (scales, counted) = (&prepared.scales, &prepared.counted);
        let wrong = counted.rows().find(|&row| !b[row].is_finite());
        if counted.any(wrong.is_some()) {
            let row = wrong.unwrap_or(0);
            return Err(SolverError::RightHandSide { row, unknown: unknowns[row] });
        }
        let [norm_b, length_b] = scales.norms_of_rows(b, unknowns, counted);
        x.fill(0.0);
        let mut report = SolveReport { refinements: 0, backward_error: 0.0 };
        if norm_b == 0.0 {
            return Ok(report);
        }
        scales.scale_rows(b, unknowns, right);
        report.backward_error = f64::INFINITY;
        loop {
            let outcome = prepared.system.solve(&access()?, right, step).map_err(said)?;
            scales.add_columns(step, unknowns, x);
            a.residual(b, x, residual);
            let [norm_r, length_r] = scales.norms_of_rows(residual, unknowns, counted);
            let norm_x = scales.norm_of_columns(x, unknowns, counted);
            let (before, reduction) = (report.backward_error, length_r / length_b);
            report.backward_error = norm_r / (scales.norm * norm_x + norm_b);
            let solved = outcome.reason > 0 && reduction.is_finite();
            let improves = report.backward_error > TARGET && report.backward_error < 0.5 * before;
            if !solved || !prepared.is_direct || !improves || report.refinements == self.refinement {
                let close = report.backward_error <= BACKWARD || reduction <= prepared.allowed();
                let complaint = || SolverError::Engine(complaint(prepared, &outcome, reduction));
                return if solved && close { Ok(report) } else { Err(complaint()) };
            }
            report.refinements += 1;
            scales.scale_rows(residual, unknowns, right);
        }
    }

    fn check_pattern(&self, a: &Csr) -> Result<(), SolverError> {
        match &self.pattern {
            Some(p) if Arc::ptr_eq(p, &a.pattern) || **p == *a.pattern => Ok(()),
            _ => Err(SolverError::NotAnalysed),
        }
    }

    /// Gives everything in PETSc back.
    fn close(&mut self) {
        self.factored = false;
        if let Some(prepared) = self.prepared.take()
            && let Ok(access) = access()
        {
            prepared.system.destroy(&access);
        }
    }
}

impl Drop for PetscSolver {
    fn drop(&mut self) {
        self.close();
    }
}

/// What is wrong with a solve that left the residual at `reduction` times the right-hand side.
fn complaint(prepared: &Prepared, outcome: &Outcome, reduction: f64) -> String {
    let Outcome { reason, iterations, failure } = outcome;
    let found =
        format!("the residual is {reduction:.1e} of the right-hand side after {iterations} iterations");
    if *reason <= 0 {
        let why = fields::failure(*failure).map_or(String::new(), |why| format!(": {why}"));
        return format!("PETSc did not solve the system ({}{why}); {found}", fields::reason(*reason));
    }
    if prepared.is_direct {
        return format!(
            "PETSc calls the system solved, but {found}: the factors are not those of the matrix, or \
             `-ksp_type preonly` stands beside a preconditioner that takes an iteration, such as `-ksp_type fgmres`"
        );
    }
    format!(
        "PETSc calls the system solved, but {found}, asked for {:.1e}: it has measured another residual; \
         `-ksp_pc_side right` and `-ksp_type fgmres` take that of the system",
        prepared.tolerance
    )
}

impl LinearSolver for PetscSolver {
    fn name(&self) -> &'static str {
        "petsc"
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError> {
        let (expected, found) = (pattern.n, unknowns.len());
        if expected != found {
            return Err(SolverError::Size { what: "unknowns", expected, found });
        }
        self.close();
        let prepared = Prepared::new(&access()?, &self.options, pattern, unknowns, self.halo.clone());
        let prepared = prepared.map_err(said)?;
        (self.prepared, self.pattern) = (Some(prepared), Some(Arc::clone(pattern)));
        self.unknowns = unknowns.to_vec();
        self.work = [vec![0.0; pattern.n], vec![0.0; pattern.n]];
        self.residual = vec![0.0; pattern.n];
        Ok(())
    }

    fn factor(&mut self, a: &Csr) -> Result<FactorReport, SolverError> {
        self.check_pattern(a)?;
        self.factored = false;
        let prepared = self.prepared.as_mut().ok_or(SolverError::NotAnalysed)?;
        prepared.scale(a, &self.unknowns, self.sizes)?;
        if let Some(why) = prepared.set(&access()?, a, &self.unknowns).map_err(said)? {
            return Err(SolverError::Engine(format!("PETSc made no preconditioner of the matrix: {why}")));
        }
        self.factored = true;
        Ok(FactorReport { cost: Cost::default(), probe_error: f64::NAN, condition: None })
    }

    fn solve(&mut self, a: &Csr, b: &[f64], x: &mut [f64]) -> Result<SolveReport, SolverError> {
        self.check_pattern(a)?;
        if !self.factored {
            return Err(SolverError::NotFactored);
        }
        for (what, found) in [("right-hand side", b.len()), ("solution", x.len())] {
            if found != a.pattern.n {
                return Err(SolverError::Size { what, expected: a.pattern.n, found });
            }
        }
        self.solve_and_judge(a, b, x)
    }

    fn apply(&mut self, b: &[f64], x: &mut [f64]) {
        let PetscSolver { prepared: Some(prepared), unknowns, work: [right, step], factored: true, .. } =
            self
        else {
            return x.fill(f64::NAN);
        };
        prepared.scales.scale_rows(b, unknowns, right);
        let solved = access().and_then(|access| prepared.system.solve(&access, right, step).map_err(said));
        x.fill(if solved.is_ok() { 0.0 } else { f64::NAN });
        prepared.scales.add_columns(step, unknowns, x);
    }

    fn correct(&mut self, a: &Csr, b: &[f64], x: &mut [f64]) -> Result<usize, SolverError> {
        Ok(1 + self.solve(a, b, x)?.refinements)
    }

    fn largest_factor(&self) -> usize {
        let is_direct = self.prepared.as_ref().is_some_and(|prepared| prepared.is_direct);
        if is_direct { self.unknowns.len() } else { 0 }
    }

    fn share(&mut self, halo: Arc<Halo>) {
        self.halo = Some(halo);
    }

    fn set_sizes(&mut self, sizes: Sizes) {
        self.sizes = sizes;
    }
}
