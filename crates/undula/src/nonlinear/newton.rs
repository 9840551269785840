//! Newton's method with a kept Jacobian and line search.

use super::secants::Secants;
use super::system::{NonlinearSystem, Seconds};
use crate::algebra::SolverError;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How far a full step with a new Jacobian may raise the residual above its start value.
///
/// The residual of a stiff solid grows with the square of the update before it converges with the
/// square: insisting on descent at once cost 1.9 times as many Jacobians in fsi3 on the coarsest mesh.
pub const GROWTH: f64 = 10.0;

/// A residual below this part of the reference that a new exact Jacobian cannot halve any more is rounding:
/// there Newton's method would converge with the square. Stresses of a stiff solid cancel to their last
/// digits, so that the wanted reduction may lie below it.
const ROUNDING: f64 = 1e-5;

/// The same for a Jacobian that leaves something out: slow convergence is no sign of rounding there, only a
/// residual is that stays what it is.
const STAGNATION: f64 = 1e-9;

/// A residual of some times the rounding that is expected, which a new Jacobian cannot halve, is rounding.
const EXPECTED: f64 = 100.0;

/// Rate at which a new Jacobian of the condensed system converges in developed motion.
const FRESH_RATE: f64 = 0.03;

/// γ_nt of matrices that need no new factors, where none is given.
const MATRIX_RATE: f64 = 0.5;

/// When to stop and when to renew the Jacobian.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Settings {
    /// Reduction of the scaled residual relative to the reference.
    pub tolerance: f64,
    /// Scaled residual below which a step is solved whatever the reference. `None`: that of
    /// [rounding](NonlinearSystem::rounding).
    pub floor: Option<f64>,
    /// γ_nt: the Jacobian is kept while ‖r_n‖/‖r_{n−1}‖ ≤ γ_nt, (5.20). 0 is the exact method. `None`: it is
    /// kept as long as that costs less than a new one.
    pub rate_max: Option<f64>,
    /// Pairs of differences that improve the corrections of a kept Jacobian; 0: none.
    pub secants: usize,
    /// Iterations at most.
    pub max_steps: usize,
    /// Halvings of an update at most.
    pub line_search: usize,
}

/// Work done so far.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Newton iterations.
    pub newton_steps: usize,
    /// Jacobians assembled.
    pub jacobians: usize,
    /// Factorisations.
    pub factorizations: usize,
    /// Iterations of the linear solver: residuals to which factors were applied.
    pub linear_iterations: usize,
}

/// How a solve went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewtonReport {
    /// Iterations.
    pub steps: usize,
    /// Jacobians assembled in them.
    pub jacobians: usize,
    /// Iterations of the linear solver.
    pub linear_iterations: usize,
    /// Scaled residual at the start and after each iteration.
    pub norms: Vec<f64>,
}

/// Why a solve failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NewtonError {
    /// The iteration no longer reduces the residual, or not within the iterations allowed.
    #[error("the nonlinear iteration does not converge")]
    Stalled {
        /// Scaled residual after each iteration.
        norms: Vec<f64>,
    },
    /// The iteration is linear, and too slow to end within the iterations allowed.
    #[error("the nonlinear iteration converges too slowly: by the factor {rate:.3} per iteration")]
    Slow {
        /// Scaled residual after each iteration.
        norms: Vec<f64>,
        /// Mean factor of the last iterations.
        rate: f64,
        /// Iterations that would be left at this rate, infinite from 1 on.
        left: f64,
        /// Iterations allowed.
        allowed: usize,
    },
    /// The start value, or every shortened update, is not admissible.
    #[error("the iterate is not admissible (the domain map folds or a value is not finite)")]
    Inadmissible,
    /// The user stops it.
    #[error("stopped")]
    Stopped,
    /// The linear system could not be solved.
    #[error(transparent)]
    Linear(#[from] SolverError),
}

/// Whether a new Jacobian that reduced a residual by `rate` from the part `size` of the reference met rounding.
fn is_rounding(rate: f64, size: f64, exact: bool) -> bool {
    if exact { rate > 0.5 && size < ROUNDING } else { rate > 0.9 && size < STAGNATION }
}

impl NewtonError {
    /// Scaled residuals at the start and after each iteration, as far as there are any.
    pub fn norms(&self) -> &[f64] {
        match self {
            NewtonError::Stalled { norms } | NewtonError::Slow { norms, .. } => norms,
            NewtonError::Inadmissible | NewtonError::Stopped | NewtonError::Linear(_) => &[],
        }
    }
}

/// Iterations over which the rate of a linear iteration is estimated. Before twice as many it is not judged.
const WINDOW: usize = 10;
/// From here on, and before with this margin, an iteration that will not end within those allowed is given up.
const JUDGED: usize = 6 * WINDOW;
const MARGIN: f64 = 1.5;

/// Why an iteration with the residuals `norms` is given up before the `allowed` iterations: extrapolated at the better
/// of its last two mean rates it would need more to reach `target`.
fn too_slow(norms: &[f64], target: f64, allowed: usize) -> Option<NewtonError> {
    let done = norms.len() - 1;
    if done < 2 * WINDOW {
        return None;
    }
    let mean = |end: usize| (norms[end] / norms[end - WINDOW]).powf(1.0 / WINDOW as f64);
    let rate = mean(done).min(mean(done - WINDOW));
    let left = if rate < 1.0 { (target / norms[done]).ln() / rate.ln() } else { f64::INFINITY };
    let margin = if done < JUDGED { MARGIN } else { 1.0 };
    (left > margin * (allowed - done) as f64).then(|| NewtonError::Slow {
        norms: norms.to_vec(),
        rate,
        left: left.ceil(),
        allowed,
    })
}

/// Newton's method; keeps the factorised Jacobian from one solve to the next.
pub struct Newton {
    /// When to stop and when to renew the Jacobian.
    pub settings: Settings,
    /// Work done since the beginning.
    pub counters: Counters,
    /// Seconds since the beginning.
    pub seconds: Seconds,
    residual: Vec<f64>,
    delta: Vec<f64>,
    /// The factorisation exists and its last rate was good enough.
    keep: bool,
    secants: Secants,
    age: Age,
    /// Mean rate of the iterations after the first, with the Jacobian of an earlier step, over the rate of the first,
    /// as last seen; in single precision, for checkpoints.
    pub worsening: f32,
    /// Set from outside to end a solve before its next iteration.
    pub stop: Option<Arc<AtomicBool>>,
    /// Give an iteration up that is known to converge linearly, and too slowly.
    pub gives_up: bool,
}

/// How far a solve has come.
struct Progress {
    /// No γ_nt is given.
    economic: bool,
    /// Factors may be older than the matrix.
    iterative: bool,
    /// The Jacobian at the start is to be replaced.
    due: bool,
    /// The matrix at hand is good enough.
    usable: bool,
    /// It was made at the iterate,
    matrix: bool,
    /// and the factors with it.
    factors: bool,
    /// Iterations of the linear solver up to the last factorisation.
    spent: usize,
}

/// How a kept Jacobian has done since it was made.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Age {
    /// Solves with it.
    pub solves: u32,
    /// Iterations in them: of the linear solver where the factors may be older than the Jacobian, else of Newton's
    /// method.
    pub iterations: u32,
    /// Iterations in the last one.
    pub last: u32,
}

impl Age {
    /// Whether the last solve has cost more than the mean one, renewal included: then replacing pays.
    fn is_due(&self, price: f64) -> bool {
        self.solves > 0 && f64::from(self.last) * f64::from(self.solves) > price + f64::from(self.iterations)
    }
}

impl Newton {
    /// For systems of `n` unknowns; the norm of corrections sees the first `measured` of them.
    pub fn new(settings: Settings, n: usize, measured: usize) -> Newton {
        Newton {
            settings,
            counters: Counters::default(),
            seconds: Seconds::default(),
            residual: vec![0.0; n],
            delta: vec![0.0; n],
            keep: false,
            secants: Secants::new(settings.secants, measured),
            age: Age::default(),
            worsening: 1.0,
            stop: None,
            gives_up: false,
        }
    }

    /// Forget the kept Jacobian, as after a change of the step size.
    pub fn forget(&mut self) {
        self.keep = false;
    }

    /// Whether the next solve starts with the Jacobian at hand.
    pub fn keeps(&self) -> bool {
        self.keep
    }

    /// Say of the Jacobian at hand whether it is kept.
    pub(crate) fn set_kept(&mut self, keep: bool) {
        self.keep = keep;
    }

    /// How the kept Jacobian has done.
    pub fn age(&self) -> Age {
        self.age
    }

    /// Factorise a Jacobian kept by an earlier run, at the iterate of `system`; not counted as work.
    ///
    /// # Errors
    /// If the factorisation fails.
    pub fn recall(&mut self, system: &mut impl NonlinearSystem, age: Age) -> Result<(), NewtonError> {
        system.renew(&mut Seconds::default())?;
        (self.keep, self.age) = (true, age);
        Ok(())
    }

    /// The residual that was evaluated last.
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }

    /// Scaled residual of `system` at its iterate.
    pub fn norm(&mut self, system: &mut impl NonlinearSystem) -> Option<f64> {
        let start = Instant::now();
        let norm = system.residual(&mut self.residual);
        self.seconds.assembly += start.elapsed().as_secs_f64();
        norm
    }

    /// Iterate until the scaled residual is `tolerance` times `reference`, or below the floor; `norm` is that
    /// at the start, the last evaluated.
    ///
    /// # Errors
    /// [`NewtonError`]; the iterate of `system` is then somewhere on the way.
    pub fn solve(
        &mut self,
        system: &mut impl NonlinearSystem,
        mut norm: f64,
        reference: f64,
    ) -> Result<NewtonReport, NewtonError> {
        let noise = system.rounding();
        let target = (self.settings.tolerance * reference).max(self.settings.floor.unwrap_or(noise));
        let mut report = NewtonReport { norms: vec![norm], ..NewtonReport::default() };
        self.secants.clear();
        let mut state = self.begin(system);
        while norm > target {
            if self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                return Err(NewtonError::Stopped);
            }
            if report.steps == self.settings.max_steps {
                return Err(NewtonError::Stalled { norms: report.norms });
            }
            let allowed = self.settings.max_steps;
            if let Some(slow) = self.gives_up.then(|| too_slow(&report.norms, target, allowed)).flatten() {
                return Err(slow);
            }
            self.prepare(system, &mut state, &mut report)?;
            if let Err(error) = self.correct(system, &mut report) {
                if state.factors {
                    return Err(error.into());
                }
                self.keep = false;
                continue;
            }
            report.steps += 1;
            self.counters.newton_steps += 1;
            let fresh = state.matrix;
            let limit = if fresh || report.norms.len() == 1 { GROWTH * report.norms[0] } else { norm };
            match self.advance(system, limit, fresh) {
                Some(next) => {
                    let rate = next / norm;
                    let size = norm / reference;
                    let rounding = state.factors
                        && rate > 0.5
                        && (is_rounding(rate, size, system.is_exact())
                            || norm < EXPECTED * noise
                            || system.is_negligible(&self.delta));
                    let good = self.is_good(system.price(), &report, &state, rate, (target / next).ln());
                    *if state.iterative { &mut state.usable } else { &mut self.keep } = good;
                    norm = next;
                    report.norms.push(norm);
                    (state.matrix, state.factors) = (false, false);
                    if rounding {
                        break;
                    }
                }
                // An old Jacobian is to blame first.
                None if !state.factors => {
                    *if fresh || !state.iterative { &mut self.keep } else { &mut state.usable } = false;
                    norm = self.norm(system).ok_or(NewtonError::Inadmissible)?;
                }
                None => return Err(NewtonError::Stalled { norms: report.norms }),
            }
        }
        if state.economic || state.iterative {
            let work = if state.iterative { report.linear_iterations } else { report.steps } as u32;
            self.age.solves += 1;
            self.age.last = work;
            self.age.iterations += work;
        }
        Ok(report)
    }

    /// What there is at the start of a solve.
    fn begin(&mut self, system: &mut impl NonlinearSystem) -> Progress {
        let (economic, iterative) = (self.settings.rate_max.is_none(), system.is_iterative());
        let due = (economic || iterative) && self.keep && self.age.is_due(system.price());
        if iterative && due {
            self.keep = false;
        }
        Progress {
            economic,
            iterative,
            due: due && !iterative,
            // A matrix is of its step alone, factors may live longer.
            usable: !iterative,
            matrix: false,
            factors: false,
            spent: 0,
        }
    }

    /// Make what the next correction needs: factors that are not kept, the matrix where it is not good enough.
    fn prepare(
        &mut self,
        system: &mut impl NonlinearSystem,
        state: &mut Progress,
        report: &mut NewtonReport,
    ) -> Result<(), NewtonError> {
        let spent = report.linear_iterations - state.spent;
        if self.keep && state.usable {
            return Ok(());
        }
        if self.keep && spent as f64 <= system.price() {
            self.counters.jacobians += 1;
            self.secants.clear();
            system.refresh(&mut self.seconds)?;
        } else {
            self.renew(system)?;
            state.spent = report.linear_iterations;
            state.factors = true;
        }
        report.jacobians += 1;
        (state.matrix, state.usable) = (true, true);
        Ok(())
    }

    fn correct(
        &mut self,
        system: &mut impl NonlinearSystem,
        report: &mut NewtonReport,
    ) -> Result<(), SolverError> {
        let start = Instant::now();
        let solved = system.correct(&self.residual, &mut self.delta);
        let iterations = match solved {
            Ok(iterations) => {
                self.secants.improve(&mut self.delta);
                iterations
            }
            Err(SolverError::NotConverged { iterations, .. }) => iterations,
            Err(_) => 0,
        };
        report.linear_iterations += iterations;
        self.counters.linear_iterations += iterations;
        self.seconds.solve += start.elapsed().as_secs_f64();
        solved.map(|_| ())
    }

    /// Whether the Jacobian is kept after an iteration of this rate, the residual being exp(−`left`) times the wanted.
    fn is_good(&mut self, price: f64, report: &NewtonReport, state: &Progress, rate: f64, left: f64) -> bool {
        let expected = self.expected(report, rate);
        let iterative = state.iterative.then_some(MATRIX_RATE);
        match self.settings.rate_max.or(iterative) {
            Some(rate_max) => rate <= rate_max,
            // Iterations to go at this rate, against a new Jacobian and those it needs.
            None => {
                let renewed = price + left / FRESH_RATE.ln();
                !(state.due && report.norms.len() == 1) && expected < 1.0 && left / expected.ln() < renewed
            }
        }
    }

    /// The rate of iterations to come, after one of `rate`. The first one with the Jacobian of an earlier step
    /// does better than those that follow: by how much in the mean, the last steps tell.
    fn expected(&mut self, report: &NewtonReport, rate: f64) -> f64 {
        if report.jacobians > 0 {
            return rate;
        }
        if let [start, first, ..] = report.norms[..] {
            let last = rate * report.norms[report.norms.len() - 1];
            let mean = (last / first).powf(1.0 / (report.norms.len() - 1) as f64);
            self.worsening = ((mean * start / first) as f32).max(1.0);
            return rate;
        }
        rate * f64::from(self.worsening)
    }

    fn renew(&mut self, system: &mut impl NonlinearSystem) -> Result<(), NewtonError> {
        self.counters.jacobians += 1;
        self.counters.factorizations += 1;
        self.secants.clear();
        self.age = Age::default();
        self.keep = true;
        Ok(system.renew(&mut self.seconds)?)
    }

    /// Subtract the update, halved until the iterate is admissible and its residual below `limit`;
    /// `None`: it never is, iterate restored.
    ///
    /// An old Jacobian gets one try: shortening its steps is dearer than a new one.
    fn advance(&mut self, system: &mut impl NonlinearSystem, limit: f64, fresh: bool) -> Option<f64> {
        let tries = if fresh { self.settings.line_search } else { 0 };
        let mut omega = 1.0;
        system.update(-omega, &self.delta);
        for attempt in 0..=tries {
            let next = self.norm(system);
            if let Some(next) = next.filter(|&next| next < limit) {
                return Some(next);
            }
            if attempt < tries {
                system.update(0.5 * omega, &self.delta);
                omega *= 0.5;
            }
        }
        system.update(omega, &self.delta);
        None
    }
}
