//! Newton's method with a kept Jacobian and line search.

use super::secants::Secants;
use crate::algebra::SolverError;
use std::time::Instant;

/// A system `r(x) = 0` that holds its own iterate.
pub trait NonlinearSystem {
    /// Residual at the iterate into `r`; returns its scaled norm, or `None` where the iterate is not
    /// admissible (the domain map has folded, or a number is not finite).
    fn residual(&mut self, r: &mut [f64]) -> Option<f64>;
    /// Jacobian, or what stands for it, at the iterate, ready for corrections.
    ///
    /// # Errors
    /// If it is singular.
    fn renew(&mut self, seconds: &mut Seconds) -> Result<(), SolverError>;
    /// δ ← J⁻¹ r with the Jacobian at hand.
    ///
    /// # Errors
    /// If it cannot be applied.
    fn correct(&mut self, r: &[f64], delta: &mut [f64]) -> Result<(), SolverError>;
    /// Whether what [`NonlinearSystem::renew`] makes is the derivative, or leaves out a part of it.
    fn is_exact(&self) -> bool;
    /// Whether an update is so small that it only moves the iterate within its rounding.
    fn is_negligible(&self, _delta: &[f64]) -> bool {
        false
    }
    /// What a new Jacobian costs, in iterations.
    fn price(&self) -> f64;
    /// `x ← x + ω δ`.
    fn update(&mut self, omega: f64, delta: &[f64]);
}

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

/// Rate at which a new Jacobian of the condensed system converges in developed motion.
const FRESH_RATE: f64 = 0.03;

/// When to stop and when to renew the Jacobian.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Settings {
    /// Reduction of the scaled residual relative to the reference.
    pub tolerance: f64,
    /// Scaled residual below which a step is solved whatever the reference.
    pub floor: f64,
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

/// Seconds spent by phase.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Residuals and Jacobians.
    pub assembly: f64,
    /// Factorisations.
    pub factorization: f64,
    /// Triangular solves.
    pub solve: f64,
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
}

/// How a solve went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewtonReport {
    /// Iterations.
    pub steps: usize,
    /// Jacobians assembled in them.
    pub jacobians: usize,
    /// Scaled residual at the start and after each iteration.
    pub norms: Vec<f64>,
}

/// Why a solve failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NewtonError {
    /// The iteration no longer reduces the residual.
    #[error("Newton's method stalled: scaled residuals {}", list(.norms))]
    Stalled {
        /// Scaled residual after each iteration.
        norms: Vec<f64>,
    },
    /// The start value, or every shortened update, is not admissible.
    #[error("the iterate is not admissible (the domain map folds or a value is not finite)")]
    Inadmissible,
    /// The linear system could not be solved.
    #[error(transparent)]
    Linear(#[from] SolverError),
}

/// Whether a new Jacobian that reduced a residual by `rate` from the part `size` of the reference met rounding.
fn is_rounding(rate: f64, size: f64, exact: bool) -> bool {
    if exact { rate > 0.5 && size < ROUNDING } else { rate > 0.9 && size < STAGNATION }
}

fn list(norms: &[f64]) -> String {
    let shown: Vec<String> = norms.iter().map(|n| format!("{n:.2e}")).collect();
    shown.join(", ")
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
    /// Rate of the second iteration with the Jacobian of an earlier step over that of the first, as last seen; in
    /// single precision, for checkpoints.
    pub worsening: f32,
}

/// How a kept Jacobian has done since it was made.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Age {
    /// Solves with it.
    pub solves: u32,
    /// Iterations in them.
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
        let target = (self.settings.tolerance * reference).max(self.settings.floor);
        let mut report = NewtonReport { norms: vec![norm], ..NewtonReport::default() };
        let mut fresh = false;
        self.secants.clear();
        let economic = self.settings.rate_max.is_none();
        let due = economic && self.keep && self.age.is_due(system.price());
        while norm > target {
            if report.steps == self.settings.max_steps {
                return Err(NewtonError::Stalled { norms: report.norms });
            }
            if !self.keep {
                self.renew(system)?;
                report.jacobians += 1;
                fresh = true;
            }
            let start = Instant::now();
            let solved = system.correct(&self.residual, &mut self.delta);
            if solved.is_ok() {
                self.secants.improve(&mut self.delta);
            }
            self.seconds.solve += start.elapsed().as_secs_f64();
            if let Err(error) = solved {
                if fresh {
                    return Err(error.into());
                }
                self.keep = false;
                continue;
            }
            report.steps += 1;
            self.counters.newton_steps += 1;
            let limit = if fresh || report.norms.len() == 1 { GROWTH * report.norms[0] } else { norm };
            match self.advance(system, limit, fresh) {
                Some(next) => {
                    let rate = next / norm;
                    let size = norm / reference;
                    let rounding = fresh
                        && rate > 0.5
                        && (is_rounding(rate, size, system.is_exact()) || system.is_negligible(&self.delta));
                    let expected = self.expected(&report, rate);
                    self.keep = match self.settings.rate_max {
                        Some(rate_max) => rate <= rate_max,
                        // Iterations to go at this rate, against a new Jacobian and those it needs.
                        None => {
                            let left = (target / next).ln();
                            let renewed = system.price() + left / FRESH_RATE.ln();
                            !(due && report.norms.len() == 1)
                                && expected < 1.0
                                && left / expected.ln() < renewed
                        }
                    };
                    norm = next;
                    report.norms.push(norm);
                    fresh = false;
                    if rounding {
                        break;
                    }
                }
                // An old Jacobian is to blame first.
                None if !fresh => {
                    self.keep = false;
                    norm = self.norm(system).ok_or(NewtonError::Inadmissible)?;
                }
                None => return Err(NewtonError::Stalled { norms: report.norms }),
            }
        }
        if economic {
            self.age.solves += 1;
            self.age.last = report.steps as u32;
            self.age.iterations += report.steps as u32;
        }
        Ok(report)
    }

    /// The rate of iterations to come, after one of `rate`. The first one with the Jacobian of an earlier step
    /// does better than those that follow: by how much, the last steps tell.
    fn expected(&mut self, report: &NewtonReport, rate: f64) -> f64 {
        if report.jacobians > 0 {
            return rate;
        }
        match report.norms[..] {
            [_] => rate * f64::from(self.worsening),
            [start, first] => {
                self.worsening = ((rate * start / first) as f32).max(1.0);
                rate
            }
            _ => rate,
        }
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
