//! The shell around every direct solver: scaling, probing, refining.

use super::vector::pseudo_random_sign;
use super::{
    Cost, Csr, FactorReport, LinearSolver, Pattern, Scaling, Sizes, SolveReport, SolverError, Unknown, dot,
    norm_inf,
};
use std::sync::Arc;

/// Beyond this the matrix counts as singular.
const MAX_CONDITION: f64 = 1e14;

/// Refinement of an inaccurate probe, at least, before the factors are given up.
const PROBE_REFINEMENT: usize = 5;

/// What a [`Direct`] solver is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Steps of iterative refinement at most.
    pub refinement: usize,
    /// Backward error at which refinement stops.
    pub target: f64,
    /// Backward error above which a solve counts as failed.
    pub allowed: f64,
    /// Whether factors are judged before they are used. If not, only what cannot be factored is an
    /// error: entries that are not finite, pivots that are zero.
    pub probe: bool,
}

impl Options {
    /// For factors in single precision, which need more refinement for the same accuracy.
    pub fn single() -> Self {
        Self { refinement: 30, ..Self::default() }
    }

    /// For [`LinearSolver::apply`] alone.
    pub fn unprobed() -> Self {
        Self { probe: false, ..Self::default() }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self { refinement: 3, target: 1e-12, allowed: 1e-9, probe: true }
    }
}

/// A sparse factorisation as the shell sees it.
pub trait Backend: Send + std::fmt::Debug {
    /// Name as written in case files.
    fn name(&self) -> &'static str;

    /// Prepares for matrices of this pattern; `unknowns` has one entry per row.
    ///
    /// # Errors
    /// If memory is short.
    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError>;

    /// Factors `R A C`.
    ///
    /// # Errors
    /// A pivot that is exactly zero, or no memory. Near singularity is the shell's business.
    fn factor(&mut self, a: &Csr, scaling: &Scaling) -> Result<Cost, Failure>;

    /// Overwrites `y` by `(R A C)⁻¹ y`.
    fn solve(&mut self, y: &mut [f64]);

    /// What a factorisation will cost; `None` where that is not known.
    fn predicted(&self) -> Option<Cost> {
        None
    }

    /// Forget what only factorisations need.
    fn settle(&mut self) {}

    /// Whether matrices are taken to be symmetric positive definite: then both sides are scaled alike.
    fn is_definite(&self) -> bool {
        false
    }

    /// Relative error of one rounding in the factors.
    fn roundoff(&self) -> f64 {
        0.5 * f64::EPSILON
    }
}

/// Why a [`Backend`] did not factor.
#[derive(Debug, Clone, PartialEq)]
pub enum Failure {
    /// No pivot for the unknown of this number.
    ZeroPivot(usize),
    /// A pivot that is not positive, for the unknown of this number, where all should be.
    NotDefinite(usize),
    /// Memory is short, or an index does not fit.
    Memory(String),
}

/// Direct solver around a [`Backend`].
///
/// Both sides are scaled. Every factorisation is probed: a known pseudo-random vector
/// x* is multiplied by the matrix and solved for again; what is not recovered is a singular matrix
/// (then the error lies in its null space, and solving for the error shows how nearly singular) or a
/// wrong factorisation (then refinement does not converge). Both are reported as errors.
#[derive(Debug)]
pub struct Direct<B> {
    backend: B,
    options: Options,
    pattern: Option<Arc<Pattern>>,
    unknowns: Vec<Unknown>,
    scaling: Scaling,
    /// Whether there are factors.
    factored: bool,
    /// ‖R A C‖∞ of the matrix last factored, once it is known.
    norm: Option<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    known: Vec<f64>,
}

impl<B: Backend> Direct<B> {
    /// Wraps a backend.
    pub fn new(backend: B, options: Options) -> Self {
        Self {
            backend,
            options,
            pattern: None,
            unknowns: Vec::new(),
            scaling: Scaling::default(),
            factored: false,
            norm: None,
            residual: Vec::new(),
            step: Vec::new(),
            known: Vec::new(),
        }
    }

    fn check_pattern(&self, a: &Csr) -> Result<(), SolverError> {
        check_size("values of the matrix", a.pattern.nnz(), a.values.len())?;
        match &self.pattern {
            Some(p) if Arc::ptr_eq(p, &a.pattern) || **p == *a.pattern => Ok(()),
            _ => Err(SolverError::NotAnalysed),
        }
    }

    /// x ← C (R A C)⁻¹ R b, through `step`.
    fn substitute(&mut self, b: &[f64], x: &mut [f64]) {
        for ((s, b), r) in self.step.iter_mut().zip(b).zip(&self.scaling.row) {
            *s = b * r;
        }
        self.backend.solve(&mut self.step);
        for ((x, s), c) in x.iter_mut().zip(&self.step).zip(&self.scaling.col) {
            *x = s * c;
        }
    }

    /// Solves with at most `refinement` steps, keeping the best iterate; the report is not judged.
    fn refine(&mut self, a: &Csr, norm: f64, b: &[f64], x: &mut [f64], options: Options) -> SolveReport {
        let norm_b = scaled_norm(b, &self.scaling.row, |b, r| b * r);
        self.substitute(b, x);
        let mut report = SolveReport { refinements: 0, backward_error: f64::INFINITY };
        loop {
            let mut residual = std::mem::take(&mut self.residual);
            a.residual(b, x, &mut residual);
            let norm_r = scaled_norm(&residual, &self.scaling.row, |r, s| r * s);
            let norm_x = scaled_norm(x, &self.scaling.col, |x, c| x / c);
            let error = if norm_r == 0.0 { 0.0 } else { norm_r / (norm * norm_x + norm_b) };
            let before = report.backward_error;
            if error < before {
                report.backward_error = error;
            } else if report.refinements > 0 {
                // The last step made it worse: take it back.
                for ((x, s), c) in x.iter_mut().zip(&self.step).zip(&self.scaling.col) {
                    *x -= s * c;
                }
                report.refinements -= 1;
            }
            let done = !(error > options.target && error < 0.5 * before);
            if done || report.refinements == options.refinement {
                self.residual = residual;
                return report;
            }
            for ((s, b), r) in self.step.iter_mut().zip(&residual).zip(&self.scaling.row) {
                *s = b * r;
            }
            self.backend.solve(&mut self.step);
            for ((x, s), c) in x.iter_mut().zip(&self.step).zip(&self.scaling.col) {
                *x += s * c;
            }
            report.refinements += 1;
            self.residual = residual;
        }
    }

    /// `residual` ← A x* for x* = ±1 in scaled variables, so that the terms of A C x* add up to the norm
    /// of the row; returns ‖R A C‖∞.
    fn known_image(&mut self, a: &Csr) -> f64 {
        for (i, (x, c)) in self.known.iter_mut().zip(&self.scaling.col).enumerate() {
            *x = pseudo_random_sign(i) * c;
        }
        a.mul_with_norm(&self.scaling.row, &self.known, &mut self.residual)
    }

    /// Solves for a known solution and judges what comes back; also returns ‖R A C‖∞.
    fn probe(&mut self, a: &Csr, cost: Cost) -> Result<(FactorReport, f64), SolverError> {
        let norm = self.known_image(a);
        for ((s, b), r) in self.step.iter_mut().zip(&self.residual).zip(&self.scaling.row) {
            *s = b * r;
        }
        self.backend.solve(&mut self.step);
        let probe_error = self.error_of_known();
        if !probe_error.is_finite() {
            return Err(self.singular(f64::INFINITY));
        }
        let mut report = FactorReport { cost, probe_error, condition: None };
        // Half of the digits are lost.
        if probe_error > self.backend.roundoff().sqrt() {
            let condition = self.condition(norm);
            if condition.is_nan() || condition > MAX_CONDITION {
                return Err(self.singular(condition));
            }
            report.condition = Some(condition);
            self.check_refinement(a, norm)?;
        }
        Ok((report, norm))
    }

    /// ‖x − x*‖∞ for `step` = x in scaled variables, which becomes the difference.
    fn error_of_known(&mut self) -> f64 {
        for (i, s) in self.step.iter_mut().enumerate() {
            *s -= pseudo_random_sign(i);
        }
        norm_inf(&self.step)
    }

    /// One step of inverse iteration from the error of the probe in `step`: ‖A‖ ‖A⁻¹ e‖ / ‖e‖.
    fn condition(&mut self, norm: f64) -> f64 {
        let before = dot(&self.step, &self.step).sqrt();
        for s in &mut self.step {
            *s /= before;
        }
        self.backend.solve(&mut self.step);
        norm * dot(&self.step, &self.step).sqrt()
    }

    /// The unknown where `step`, then close to the null vector, is largest.
    fn singular(&self, condition: f64) -> SolverError {
        let size = |s: &f64| if s.is_finite() { s.abs() } else { f64::INFINITY };
        let (mut index, mut max) = (0, -1.0);
        for (i, s) in self.step.iter().enumerate() {
            if size(s) > max {
                (index, max) = (i, size(s));
            }
        }
        SolverError::Singular { condition, index, unknown: self.unknowns[index] }
    }

    /// Whether refinement recovers from factors that did badly in the probe: the residual must vanish,
    /// and the error with it as far as a regular matrix lets it.
    fn check_refinement(&mut self, a: &Csr, norm: f64) -> Result<(), SolverError> {
        let b = std::mem::take(&mut self.residual);
        let mut x = std::mem::take(&mut self.known);
        self.residual = vec![0.0; b.len()];
        let refinement = if self.backend.roundoff() > f64::EPSILON {
            self.options.refinement.max(PROBE_REFINEMENT)
        } else {
            PROBE_REFINEMENT
        };
        let report = self.refine(a, norm, &b, &mut x, Options { refinement, target: 0.0, ..self.options });
        for ((s, x), c) in self.step.iter_mut().zip(&x).zip(&self.scaling.col) {
            *s = x / c;
        }
        self.known = x;
        let condition = self.error_of_known() / report.backward_error.max(f64::EPSILON);
        if condition > MAX_CONDITION {
            return Err(self.singular(condition));
        }
        self.judge(report).map(|_| ())
    }

    fn judge(&self, report: SolveReport) -> Result<SolveReport, SolverError> {
        let SolveReport { refinements, backward_error } = report;
        let allowed = self.options.allowed;
        if backward_error <= allowed {
            Ok(report)
        } else {
            Err(SolverError::Inaccurate { backward_error, refinements, allowed })
        }
    }
}

impl<B: Backend> LinearSolver for Direct<B> {
    fn name(&self) -> &'static str {
        self.backend.name()
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError> {
        check_size("unknowns", pattern.n, unknowns.len())?;
        (self.factored, self.norm, self.pattern) = (false, None, None);
        self.backend.analyse(pattern, unknowns)?;
        self.unknowns = unknowns.to_vec();
        for work in [&mut self.residual, &mut self.step, &mut self.known] {
            *work = vec![0.0; pattern.n];
        }
        self.pattern = Some(Arc::clone(pattern));
        Ok(())
    }

    fn largest_factor(&self) -> usize {
        self.unknowns.len()
    }

    fn settle(&mut self) {
        // Matrices of another pattern are refused.
        self.pattern = self.pattern.as_ref().map(|_| Arc::new(Pattern::from_rows::<[u32; 0]>(&[])));
        self.backend.settle();
    }

    fn factor(&mut self, a: &Csr) -> Result<FactorReport, SolverError> {
        self.check_pattern(a)?;
        (self.factored, self.norm) = (false, None);
        if self.backend.is_definite() {
            self.scaling.update_definite(a, &self.unknowns)?;
        } else {
            self.scaling.update(a, &self.unknowns)?;
        }
        let cost = self.backend.factor(a, &self.scaling).map_err(|failure| match failure {
            Failure::Memory(what) => SolverError::Memory(what),
            Failure::NotDefinite(index) => SolverError::NotDefinite { index, unknown: self.unknowns[index] },
            Failure::ZeroPivot(index) => {
                SolverError::Singular { condition: f64::INFINITY, index, unknown: self.unknowns[index] }
            }
        })?;
        let report = if self.options.probe {
            let (report, norm) = self.probe(a, cost)?;
            self.norm = Some(norm);
            report
        } else {
            FactorReport { cost, probe_error: f64::NAN, condition: None }
        };
        self.factored = true;
        Ok(report)
    }

    fn solve(&mut self, a: &Csr, b: &[f64], x: &mut [f64]) -> Result<SolveReport, SolverError> {
        self.check_pattern(a)?;
        if !self.factored {
            return Err(SolverError::NotFactored);
        }
        check_size("right-hand side", a.pattern.n, b.len())?;
        check_size("solution", a.pattern.n, x.len())?;
        if let Some(row) = b.iter().position(|v| !v.is_finite()) {
            return Err(SolverError::RightHandSide { row, unknown: self.unknowns[row] });
        }
        let norm = self.norm.unwrap_or_else(|| self.known_image(a));
        self.norm = Some(norm);
        let report = self.refine(a, norm, b, x, self.options);
        self.judge(report)
    }

    fn apply(&mut self, b: &[f64], x: &mut [f64]) {
        if self.factored { self.substitute(b, x) } else { x.fill(f64::NAN) }
    }

    fn predicted(&self) -> Option<Cost> {
        self.pattern.as_ref().and_then(|_| self.backend.predicted())
    }

    fn set_sizes(&mut self, sizes: Sizes) {
        self.scaling.sizes = sizes;
    }
}

fn check_size(what: &'static str, expected: usize, found: usize) -> Result<(), SolverError> {
    if expected == found { Ok(()) } else { Err(SolverError::Size { what, expected, found }) }
}

/// max |f(x_i, s_i)|, NaN where one is not finite.
fn scaled_norm(x: &[f64], scale: &[f64], f: impl Fn(f64, f64) -> f64) -> f64 {
    let (mut max, mut poison) = (0.0_f64, 0.0);
    for (x, s) in x.iter().zip(scale) {
        let v = f(*x, *s);
        max = max.max(v.abs());
        poison += 0.0 * v;
    }
    max + poison
}
