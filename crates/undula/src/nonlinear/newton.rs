//! Newton's method with a kept Jacobian and line search.

use super::error::NewtonError;
use super::renewal::{self, Age, Iteration, Kept, Make, Renewal};
use super::report::{Counters, NewtonReport, Seconds};
use super::secants::Secants;
use super::system::NonlinearSystem;
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

/// When to stop and when to renew the Jacobian.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct NewtonSettings {
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

/// What is known when a solve begins.
struct Goal {
    /// The scaled residual that is wanted.
    target: f64,
    /// That of the old solution.
    reference: f64,
    /// That which rounding leaves.
    noise: f64,
}

/// What a checkpoint keeps of Newton's method, besides the Jacobian.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Memory {
    /// What kept Jacobians lose after the first iteration of a step: a factor of rates.
    pub worsening: f32,
    /// Work done since the beginning.
    pub counters: Counters,
    /// Seconds since the beginning.
    pub seconds: Seconds,
}

impl Default for Memory {
    /// That of a new run.
    fn default() -> Memory {
        let Kept { worsening, .. } = Kept::default();
        Memory { worsening, counters: Counters::default(), seconds: Seconds::default() }
    }
}

/// Newton's method; keeps the factorised Jacobian from one solve to the next.
pub struct Newton {
    /// When to stop and when to renew the Jacobian.
    pub settings: NewtonSettings,
    /// Work done since the beginning.
    pub counters: Counters,
    /// Seconds since the beginning.
    pub seconds: Seconds,
    residual: Vec<f64>,
    delta: Vec<f64>,
    kept: Kept,
    secants: Secants,
    /// Set from outside to end a solve before its next iteration.
    pub stop: Option<Arc<AtomicBool>>,
    /// Give an iteration up that is known to converge linearly, and too slowly.
    pub gives_up: bool,
}

impl Newton {
    /// For systems of `n` unknowns; the norm of corrections sees the first `measured` of them.
    pub fn new(settings: NewtonSettings, n: usize, measured: usize) -> Newton {
        Newton {
            settings,
            counters: Counters::default(),
            seconds: Seconds::default(),
            residual: vec![0.0; n],
            delta: vec![0.0; n],
            kept: Kept::default(),
            secants: Secants::new(settings.secants, measured),
            stop: None,
            gives_up: false,
        }
    }

    /// For a system of `n` unknowns from now on.
    pub(crate) fn resize(&mut self, n: usize) {
        self.residual.resize(n, 0.0);
        self.delta.resize(n, 0.0);
    }

    /// Forget the kept Jacobian, as after a change of the step size.
    pub fn forget(&mut self) {
        self.kept.usable = false;
    }

    /// Whether the next solve starts with the Jacobian at hand.
    pub fn keeps(&self) -> bool {
        self.kept.usable
    }

    /// As `before` a solve that was stopped, but for the seconds that it took; whether the Jacobian at hand is `kept`.
    pub(crate) fn undo(&mut self, kept: bool, before: Memory) {
        self.kept.usable = kept;
        (self.kept.worsening, self.counters) = (before.worsening, before.counters);
    }

    /// How the kept Jacobian has done.
    pub fn age(&self) -> Age {
        self.kept.age
    }

    /// What a checkpoint keeps. All else is asked for by the case, kept with the Jacobian, or made anew in a solve.
    pub fn save(&self) -> Memory {
        let Newton {
            settings: _,
            counters,
            seconds,
            residual: _,
            delta: _,
            kept: Kept { usable: _, age: _, worsening },
            secants: _,
            stop: _,
            gives_up: _,
        } = *self;
        Memory { worsening, counters, seconds }
    }

    /// Go on from a checkpoint, without a Jacobian.
    pub fn restore(&mut self, memory: Memory) {
        let Memory { worsening, counters, seconds } = memory;
        self.forget();
        self.kept.worsening = if worsening.is_finite() { worsening.max(1.0) } else { 1.0 };
        (self.counters, self.seconds) = (counters, seconds);
    }

    /// Factorise a Jacobian kept by an earlier run, at the iterate of `system`; not counted as work.
    ///
    /// # Errors
    /// If the factorisation fails.
    pub fn recall(&mut self, system: &mut impl NonlinearSystem, age: Age) -> Result<(), NewtonError> {
        system.renew(&mut Seconds::default())?;
        (self.kept.usable, self.kept.age) = (true, age);
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
        let goal = Goal::new(&self.settings, reference, system.rounding());
        let mut report = NewtonReport { norms: vec![norm], ..NewtonReport::default() };
        let (rate_max, iterative) = (self.settings.rate_max, system.is_iterative());
        let mut rule = renewal::rule(rate_max, iterative, &mut self.kept, system.price());
        self.secants.clear();
        while norm > goal.target {
            self.check(&report, goal.target)?;
            let made = self.prepare(system, &mut *rule, &mut report)?;
            let all_new = made == Make::Factors;
            match self.correct(system, &mut report) {
                Err(error) if all_new => return Err(error.into()),
                Err(_) => {
                    self.forget();
                    continue;
                }
                Ok(()) => {}
            }
            match self.advance(system, &report, norm, made != Make::Nothing) {
                Some(next) => {
                    let ends = all_new && self.is_rounding(system, &goal, norm, next);
                    self.judge(system, &mut *rule, &report, next / norm, goal.target / next);
                    report.norms.push(next);
                    norm = next;
                    if ends {
                        break;
                    }
                }
                None if all_new => return Err(NewtonError::Stalled { norms: report.norms }),
                // What is old is to blame first.
                None => {
                    rule.blame(&mut self.kept, made);
                    norm = self.norm(system).ok_or(NewtonError::Inadmissible)?;
                }
            }
        }
        rule.end(&mut self.kept, &report);
        Ok(report)
    }

    /// Whether there may be another iteration: the user, their number and, where asked for, their rate.
    fn check(&self, report: &NewtonReport, target: f64) -> Result<(), NewtonError> {
        let allowed = self.settings.max_steps;
        if self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(NewtonError::Stopped);
        }
        if report.steps == allowed {
            return Err(NewtonError::Stalled { norms: report.norms.clone() });
        }
        let slow = self.gives_up.then(|| NewtonError::too_slow(&report.norms, target, allowed));
        slow.flatten().map_or(Ok(()), Err)
    }

    /// Make what the next correction needs, by the `rule`.
    fn prepare(
        &mut self,
        system: &mut impl NonlinearSystem,
        rule: &mut dyn Renewal,
        report: &mut NewtonReport,
    ) -> Result<Make, NewtonError> {
        let made = rule.due(&self.kept, report.linear_iterations, system.price());
        if made == Make::Nothing {
            return Ok(made);
        }
        self.secants.clear();
        self.counters.jacobians += 1;
        if made == Make::Factors {
            self.counters.factorizations += 1;
            (self.kept.usable, self.kept.age) = (true, Age::default());
        }
        let applied = match made {
            Make::Factors => system.renew(&mut self.seconds)?,
            _ => system.refresh(&mut self.seconds)?,
        };
        self.count(report, applied);
        report.jacobians += 1;
        Ok(made)
    }

    /// δ for the residual, improved by secant pairs if there are any.
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
                (report.steps, self.counters.newton_steps) =
                    (report.steps + 1, self.counters.newton_steps + 1);
                iterations
            }
            Err(SolverError::NotConverged { iterations, .. }) => iterations,
            Err(_) => 0,
        };
        self.count(report, iterations);
        self.seconds.solve += start.elapsed().as_secs_f64();
        solved.map(|_| ())
    }

    /// Count iterations of the linear solver.
    fn count(&mut self, report: &mut NewtonReport, iterations: usize) {
        report.linear_iterations += iterations;
        self.counters.linear_iterations += iterations;
    }

    /// Let the `rule` judge the Jacobian by an iteration of this `rate`, `left` of whose residual is wanted.
    fn judge(
        &mut self,
        system: &impl NonlinearSystem,
        rule: &mut dyn Renewal,
        report: &NewtonReport,
        rate: f64,
        left: f64,
    ) {
        self.kept.learn(report, rate);
        let iteration = Iteration { report, rate, left: left.ln(), price: system.price() };
        rule.observe(&mut self.kept, &iteration);
    }

    /// Whether a new Jacobian that led from the residual `norm` to `next` has met rounding.
    fn is_rounding(&self, system: &impl NonlinearSystem, goal: &Goal, norm: f64, next: f64) -> bool {
        let (rate, size) = (next / norm, norm / goal.reference);
        let small = if system.is_exact() { size < ROUNDING } else { rate > 0.9 && size < STAGNATION };
        rate > 0.5 && (small || norm < EXPECTED * goal.noise || system.is_negligible(&self.delta))
    }

    /// Subtract the update, halved until the iterate is admissible and its residual small enough after that of `norm`;
    /// `None`: it never is, iterate restored.
    ///
    /// A Jacobian that is not `fresh` gets one try: shortening its steps is dearer than a new one.
    fn advance(
        &mut self,
        system: &mut impl NonlinearSystem,
        report: &NewtonReport,
        norm: f64,
        fresh: bool,
    ) -> Option<f64> {
        let may_grow = fresh || report.norms.len() == 1;
        let limit = if may_grow { GROWTH * report.norms[0] } else { norm };
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

impl Goal {
    fn new(settings: &NewtonSettings, reference: f64, noise: f64) -> Goal {
        let target = (settings.tolerance * reference).max(settings.floor.unwrap_or(noise));
        Goal { target, reference, noise }
    }
}
