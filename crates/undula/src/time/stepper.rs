//! One step: boundary data, start value, Newton, and smaller steps where it fails.

use super::linear::{Linear, Linearization};
use super::parts::Parts;
use super::scheme::{Damping, DomainMotion, Formula, Past, Scheme, multistep};
use super::system::{BlockNorms, Scales, StepSystem};
use crate::assembly::{Assembler, End, StepView, Worst};
use crate::nonlinear::newton::{Age, GROWTH};
use crate::nonlinear::{Newton, NewtonError, NewtonReport};
use crate::physics::StepRule;
use crate::space::{Region, State};
use crate::tangent::Tangent;
use std::time::Instant;

/// Body force per mass as a function of position and time \[m/s²\].
pub type Force<const D: usize> = Box<dyn Fn(&[f64; D], f64) -> [f64; D] + Send + Sync>;

/// A right-hand side `[v, u, p]` added to the residual: called with (t⁻, t, θ).
pub type Source = Box<dyn FnMut(f64, f64, f64, &mut [f64]) + Send>;

/// What a stepper needs besides assembly and Newton.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StepperSettings {
    /// Time scheme.
    pub scheme: Scheme,
    /// Where the factors of ∂_t are taken.
    pub domain_motion: DomainMotion,
    /// How derivatives are computed.
    pub tangent: Tangent,
    /// Start from the linear extrapolation of the last two solutions, Remark 5.1.
    pub extrapolate: bool,
    /// How often a failed step is halved.
    pub max_halvings: u32,
    /// Units of the residuals.
    pub scales: Scales,
}

impl StepperSettings {
    /// The rule of the scheme that has this 1/k and θ.
    pub fn rule_of(&self, per_k: f64, theta: f64) -> StepRule {
        let rule = StepRule { per_k, theta, ..self.scheme.rule(1.0) };
        self.domain_motion.apply(rule)
    }
}

/// Solutions at most until the parameters of a stationary stabilisation have settled, and the relative change of
/// v at which they have.
const SETTLING: usize = 20;
const SETTLED: f64 = 1e-7;

/// How a step went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Newton iterations, over all parts of a divided step.
    pub newton_steps: usize,
    /// Jacobians assembled.
    pub jacobians: usize,
    /// Into how many parts the step was divided.
    pub parts: usize,
    /// Scaled norms of the equations at the end \[m/s\].
    pub norms: BlockNorms,
    /// Smallest J at quadrature points and nodes.
    pub min_j: f64,
}

/// A step that could not be done even when halved.
#[derive(Clone, Debug, thiserror::Error)]
#[error("no solution for the step to t = {time:.6} s (k = {step:.3e} s): {reason}")]
pub struct StepFailure {
    /// Time that was tried \[s\].
    pub time: f64,
    /// Step that was tried last \[s\].
    pub step: f64,
    /// Why.
    pub reason: NewtonError,
    /// Where J was smallest in the last residual.
    pub worst: Worst,
}

/// The solution at one time and what is needed to carry it on.
pub struct Stepper<const D: usize> {
    /// Assembly.
    pub assembler: Assembler<D>,
    /// Nonlinear solver.
    pub newton: Newton,
    /// Matrices and their factors.
    pub linear: Linear,
    /// Settings.
    pub settings: StepperSettings,
    /// Time of `new` \[s\].
    pub time: f64,
    /// The last solution.
    pub new: State,
    /// The solution before.
    pub old: State,
    /// The solution before that, for extrapolation and BDF2.
    older: State,
    /// What BDF2 takes the difference from.
    base: State,
    /// Length of the last step, or of its last part \[s\]; 0 where there was none.
    last_step: f64,
    /// What the last step, or its last part, was made of.
    last: Formula,
    /// First time \[s\].
    start: f64,
    pub(super) damping: Damping,
    /// The parts of the last step of fractional-step θ.
    pub(super) parts: Option<Parts>,
    explicit: Vec<f64>,
    /// What the criterion of the last stationary solution referred to.
    reference: f64,
    /// Where the kept Jacobian was taken.
    point: Option<JacobianPoint>,
    force: [Option<Force<D>>; 2],
    /// Manufactured right-hand side.
    pub source: Option<Source>,
}

/// How the iteration of a step begins.
struct Start<'a> {
    /// The old solution.
    old: &'a State,
    /// The solution before the old one and the ratio of the steps, to extrapolate.
    older: Option<(&'a State, f64)>,
    /// Residual at the old solution.
    reference: f64,
}

impl Start<'_> {
    /// The extrapolated solution, or the old one where that is no good, with the boundary data.
    /// Returns the residual there; `None` if not even the old solution is admissible.
    fn set<const D: usize>(&self, newton: &mut Newton, system: &mut StepSystem<'_, D>) -> Option<f64> {
        if let Some((older, ratio)) = self.older {
            system.new.extrapolate(older, self.old, ratio);
            self.complete(system, false);
            let norm = newton.norm(system).filter(|&norm| norm <= GROWTH * self.reference);
            if norm.is_some() {
                return norm;
            }
        }
        system.new.copy_from(self.old);
        self.complete(system, true);
        newton.norm(system)
    }

    fn complete<const D: usize>(&self, system: &mut StepSystem<'_, D>, follow: bool) {
        let assembler = &mut *system.assembler;
        assembler.constraints.apply(&assembler.space, system.time, &mut system.new.v, &mut system.new.u);
        system.linear.start(assembler, system.rule, system.new, system.old, follow);
    }
}

/// Where a Jacobian was taken: with it a resumed run repeats the same bits.
#[derive(Clone, Debug, PartialEq)]
pub struct JacobianPoint {
    /// Weights of the scheme.
    pub rule: StepRule,
    /// Time of the body force \[s\].
    pub time: f64,
    /// The iterate.
    pub new: State,
    /// What the difference is taken from.
    pub old: State,
    /// How it has done so far.
    pub age: Age,
}

/// Where a run stands in time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Clock {
    /// Time \[s\].
    pub time: f64,
    /// Length of the last step, or of its last part \[s\].
    pub last_step: f64,
    /// Where Rannacher's scheme stands.
    pub damping: Damping,
}

impl<const D: usize> Stepper<D> {
    /// Start from `initial` at `time`; forces of (fluid, solid).
    pub fn new(
        assembler: Assembler<D>,
        newton: Newton,
        linear: Linear,
        settings: StepperSettings,
        time: f64,
        initial: State,
        force: [Option<Force<D>>; 2],
    ) -> Stepper<D> {
        let n = assembler.space.n_unknowns();
        let mut stepper = Stepper {
            assembler,
            newton,
            linear,
            settings,
            time,
            new: initial.clone(),
            old: initial.clone(),
            older: initial.clone(),
            base: if settings.scheme == Scheme::Bdf2 { initial } else { State::default() },
            last_step: 0.0,
            last: Formula { rule: StepRule::STATIONARY, ratio: None },
            start: time,
            damping: Damping::default(),
            parts: None,
            reference: 0.0,
            point: None,
            explicit: vec![0.0; n],
            force,
            source: None,
        };
        stepper.set_forces(End::New, time);
        stepper.set_forces(End::Old, time);
        stepper
    }

    pub(super) fn set_forces(&mut self, end: End, t: f64) {
        for (force, region) in self.force.iter().zip([Region::Fluid, Region::Solid]) {
            if let Some(force) = force {
                self.assembler.set_force(region, end, Some(&|x| force(x, t)));
            }
        }
    }

    /// Carry the solution on by `k` \[s\], in smaller parts if need be.
    ///
    /// # Errors
    /// [`StepFailure`]; everything is then as before the step, whatever its parts had reached.
    pub fn step(&mut self, k: f64) -> Result<StepReport, StepFailure> {
        self.damping = self.settings.scheme.damping(self.damping, self.time - self.start);
        let result = self.step_or_halves(k);
        if result.is_ok() {
            self.damping.left = self.damping.left.saturating_sub(1);
        }
        result
    }

    fn step_or_halves(&mut self, k: f64) -> Result<StepReport, StepFailure> {
        let failure = match self.whole(k) {
            Ok(report) => return Ok(report),
            Err(failure) => failure,
        };
        if self.settings.max_halvings == 0 {
            return Err(failure);
        }
        let (clock, states) = (self.clock(), (self.new.clone(), self.old.clone()));
        let result = self.halves(k, self.settings.max_halvings);
        if result.is_err() {
            self.set_clock(clock);
            (self.new, self.old) = states;
        }
        result
    }

    /// One step of the scheme without division; on failure everything is as before.
    fn whole(&mut self, k: f64) -> Result<StepReport, StepFailure> {
        match self.settings.scheme {
            Scheme::FractionalStepTheta => self.fractional_step(k),
            _ => self.attempt(k, 0),
        }
    }

    fn divided(&mut self, k: f64, halvings: u32) -> Result<StepReport, StepFailure> {
        match self.whole(k) {
            Ok(report) => Ok(report),
            Err(failure) if halvings == 0 => Err(failure),
            Err(_) => self.halves(k, halvings),
        }
    }

    fn halves(&mut self, k: f64, halvings: u32) -> Result<StepReport, StepFailure> {
        self.newton.forget();
        let first = self.divided(0.5 * k, halvings - 1)?;
        let second = self.divided(0.5 * k, halvings - 1)?;
        self.newton.forget();
        Ok(StepReport {
            newton_steps: first.newton_steps + second.newton_steps,
            jacobians: first.jacobians + second.jacobians,
            parts: first.parts + second.parts,
            norms: second.norms,
            min_j: first.min_j.min(second.min_j),
        })
    }

    /// The formula of part `part` of a step, of length `k` \[s\].
    fn formula(&self, k: f64, part: usize) -> Formula {
        let ratio = if self.last_step > 0.0 { k / self.last_step } else { 0.0 };
        let past = Past { ratio, damped: self.damping.left > 0, part };
        let Formula { rule, ratio } = self.settings.scheme.formula(k, &past);
        Formula { rule: self.settings.domain_motion.apply(rule), ratio }
    }

    /// A step of one part, or part `part` of one; on failure everything is as before.
    pub(super) fn attempt(&mut self, k: f64, part: usize) -> Result<StepReport, StepFailure> {
        let formula = self.formula(k, part);
        let (t_old, t) = (self.time, self.time + k);
        std::mem::swap(&mut self.older, &mut self.old);
        std::mem::swap(&mut self.old, &mut self.new);
        // Now `old` is the last solution and `older` the one before.
        let solved = self.solve_step(&formula, t_old, t);
        match solved {
            Ok((report, norms, min_j)) => {
                self.time = decimal(t);
                (self.last_step, self.last) = (k, formula);
                let (newton_steps, jacobians) = (report.steps, report.jacobians);
                Ok(StepReport { newton_steps, jacobians, parts: 1, norms, min_j })
            }
            Err(reason) => {
                let worst = self.assembler.worst();
                std::mem::swap(&mut self.old, &mut self.new);
                std::mem::swap(&mut self.older, &mut self.old);
                // `new` and `old` are as before; only the spare third state was written.
                self.newton.forget();
                Err(StepFailure { time: t, step: k, reason, worst })
            }
        }
    }

    fn solve_step(
        &mut self,
        formula: &Formula,
        t_old: f64,
        t: f64,
    ) -> Result<(NewtonReport, BlockNorms, f64), NewtonError> {
        let start = Instant::now();
        let rule = formula.rule;
        // cG(1) integrates over the step: its body force is that of the middle.
        let t_force = if rule.quadrature.is_empty() { t } else { 0.5 * (t_old + t) };
        self.set_forces(End::Old, t_old);
        self.set_forces(End::New, t_force);
        let view = StepView { rule, new: &self.old, old: &self.old };
        self.assembler.explicit(&view, &mut self.explicit);
        if let Some(source) = &mut self.source {
            source(t_old, t, rule.theta, &mut self.explicit);
        }
        self.new.copy_from(&self.old);
        self.apply_boundary(t, 1.0);
        self.newton.seconds.assembly += start.elapsed().as_secs_f64();
        if let Some(ratio) = formula.ratio {
            multistep(&mut self.base, &self.older, &self.old, ratio);
        }
        let k = t - t_old;
        let ratio = if self.last_step > 0.0 { k / self.last_step } else { 0.0 };
        let extrapolate = self.settings.extrapolate && ratio > 0.0;
        let mut system = StepSystem {
            assembler: &mut self.assembler,
            linear: &mut self.linear,
            rule,
            new: &mut self.new,
            old: if formula.ratio.is_some() { &self.base } else { &self.old },
            explicit: &self.explicit,
            scales: self.settings.scales,
            tangent: self.settings.tangent,
            time: t,
            force_time: t_force,
            point: &mut self.point,
            min_j: 1.0,
            norms: BlockNorms::default(),
        };
        // The criterion refers to the old solution with the new boundary data, whatever the start value.
        let reference = self.newton.norm(&mut system).ok_or(NewtonError::Inadmissible)?;
        let start = Start { old: &self.old, older: extrapolate.then_some((&self.older, ratio)), reference };
        let norm = start.set(&mut self.newton, &mut system).ok_or(NewtonError::Inadmissible)?;
        let mut solved = self.newton.solve(&mut system, norm, reference);
        if solved.is_err() && system.linear.fall_back() {
            self.newton.forget();
            let norm = start.set(&mut self.newton, &mut system).ok_or(NewtonError::Inadmissible)?;
            solved = self.newton.solve(&mut system, norm, reference);
        }
        let report = solved?;
        let min_j = system.assembler.nodal_min_j(system.new);
        if min_j <= 0.0 {
            return Err(NewtonError::Inadmissible);
        }
        if let Some(point) = &mut system.point {
            point.age = self.newton.age();
        }
        if system.linear.count_step() {
            self.newton.forget();
        }
        Ok((report, system.norms, min_j))
    }

    fn apply_boundary(&mut self, t: f64, factor: f64) {
        let State { v, u, .. } = &mut self.new;
        self.assembler.constraints.load = factor;
        self.assembler.constraints.apply(&self.assembler.space, t, v, u);
    }

    /// The stationary solution at the present time, with the load raised in parts if need be.
    ///
    /// # Errors
    /// [`StepFailure`] if even small increments of the load have no solution.
    pub fn stationary(&mut self) -> Result<StepReport, StepFailure> {
        let (mut load, mut increment) = (0.0f64, 1.0f64);
        let mut total = StepReport::default();
        let mut last_load = 0.0f64;
        while load < 1.0 {
            let next = (load + increment).min(1.0);
            match self.stationary_at(next, load, last_load, 0.0) {
                Ok(report) => {
                    total.newton_steps += report.newton_steps;
                    total.jacobians += report.jacobians;
                    total.parts += 1;
                    (total.norms, total.min_j) = (report.norms, report.min_j);
                    (last_load, load) = (load, next);
                    increment *= 2.0;
                }
                Err(failure) if increment < 1e-3 => return Err(failure),
                Err(_) => increment = 0.5 * increment.min(1.0 - load),
            }
        }
        self.settle(&mut total)?;
        Ok(total)
    }

    /// Parameters of the stabilisation come from the state before: repeat until they are those of the solution.
    fn settle(&mut self, total: &mut StepReport) -> Result<(), StepFailure> {
        let reference = self.reference;
        for _ in 0..if self.assembler.is_stabilized() { SETTLING } else { 0 } {
            let before = self.new.v.clone();
            let report = self.stationary_at(1.0, 0.0, 0.0, reference)?;
            total.newton_steps += report.newton_steps;
            total.jacobians += report.jacobians;
            (total.norms, total.min_j) = (report.norms, report.min_j);
            let size = |sum: f64, x: f64| sum.max(x.abs());
            let change = before.iter().zip(&self.new.v).map(|(a, b)| a - b).fold(0.0, size);
            if report.newton_steps == 0 || change <= SETTLED * self.new.v.iter().copied().fold(0.0, size) {
                break;
            }
        }
        Ok(())
    }

    /// The criterion refers to the residual at the start, or to `least` if that is larger.
    fn stationary_at(
        &mut self,
        load: f64,
        before: f64,
        earlier: f64,
        least: f64,
    ) -> Result<StepReport, StepFailure> {
        let t = self.time;
        for (force, region) in self.force.iter().zip([Region::Fluid, Region::Solid]) {
            if let Some(force) = force {
                self.assembler.set_force(region, End::New, Some(&|x| force(x, t).map(|f| f * load)));
            }
        }
        self.explicit.fill(0.0);
        if let Some(source) = &mut self.source {
            source(t, t, 1.0, &mut self.explicit);
        }
        let (before_state, earlier_state) = (self.new.clone(), self.old.clone());
        if before > 0.0 {
            let ratio =
                if before > earlier && earlier > 0.0 { (load - before) / (before - earlier) } else { 0.0 };
            self.new.extrapolate(&earlier_state, &before_state, ratio);
        }
        self.apply_boundary(t, load);
        self.newton.forget();
        let active = self.linear.active;
        if self.assembler.space.deforms {
            self.linear.active = Linearization::Newton;
        }
        let mut system = StepSystem {
            assembler: &mut self.assembler,
            linear: &mut self.linear,
            rule: StepRule::STATIONARY,
            new: &mut self.new,
            old: &before_state,
            explicit: &self.explicit,
            scales: self.settings.scales,
            tangent: self.settings.tangent,
            time: t,
            force_time: t,
            point: &mut self.point,
            min_j: 1.0,
            norms: BlockNorms::default(),
        };
        let solved = match self.newton.norm(&mut system) {
            Some(norm) => {
                self.reference = norm.max(least);
                self.newton.solve(&mut system, norm, self.reference)
            }
            None => Err(NewtonError::Inadmissible),
        };
        let (norms, min_j) = (system.norms, system.assembler.nodal_min_j(system.new));
        let solved = solved.and_then(|r| if min_j > 0.0 { Ok(r) } else { Err(NewtonError::Inadmissible) });
        self.linear.active = active;
        match solved {
            Ok(report) => {
                self.old = before_state;
                let (newton_steps, jacobians) = (report.steps, report.jacobians);
                Ok(StepReport { newton_steps, jacobians, parts: 1, norms, min_j })
            }
            Err(reason) => {
                let worst = self.assembler.worst();
                self.new = before_state;
                Err(StepFailure { time: t, step: 0.0, reason, worst })
            }
        }
    }

    /// The last step, or its last part: its rule, the solutions that it relates, and the assembly to evaluate
    /// it with.
    pub fn last_step(&mut self) -> (StepRule, &State, &State, &mut Assembler<D>) {
        let old = if self.last.ratio.is_some() { &self.base } else { &self.old };
        (self.last.rule, &self.new, old, &mut self.assembler)
    }

    /// Time to which pressure and forces of the last step belong: t⁻ + θ k, for fractional-step θ the middle.
    pub fn force_time(&self) -> f64 {
        match &self.parts {
            Some(parts) => self.time - 0.5 * parts.length,
            None => self.time - self.last_step + self.last.rule.theta * self.last_step,
        }
    }

    /// The clock, for a checkpoint.
    pub fn clock(&self) -> Clock {
        Clock { time: self.time, last_step: self.last_step, damping: self.damping }
    }

    /// Whether the last step was one of the damping steps of Rannacher's scheme.
    pub(super) fn was_damped(&self) -> bool {
        matches!(self.settings.scheme, Scheme::Rannacher { .. }) && self.last.rule.theta == 1.0
    }

    /// Take the last step back.
    pub(super) fn go_back(&mut self, clock: Clock, new: &State, old: &State) {
        self.set_clock(clock);
        self.new.copy_from(new);
        self.old.copy_from(old);
    }

    pub(super) fn set_clock(&mut self, clock: Clock) {
        Clock { time: self.time, last_step: self.last_step, damping: self.damping } = clock;
    }

    /// Where the Jacobian that the next step will start with was taken; `None`: it will make a new one.
    pub fn jacobian_point(&self) -> Option<&JacobianPoint> {
        self.point.as_ref().filter(|_| self.newton.keeps())
    }

    /// Go on from a checkpoint: the last two solutions, the clock and the kept Jacobian.
    ///
    /// # Errors
    /// If the kept Jacobian cannot be factorised again.
    pub fn restore(
        &mut self,
        clock: Clock,
        new: State,
        old: State,
        point: Option<JacobianPoint>,
    ) -> Result<(), NewtonError> {
        self.set_clock(clock);
        (self.new, self.old, self.parts) = (new, old, None);
        self.newton.forget();
        if let Some(point) = point {
            self.set_forces(End::New, point.time);
            let mut new = point.new.clone();
            let mut system = StepSystem {
                assembler: &mut self.assembler,
                linear: &mut self.linear,
                rule: point.rule,
                new: &mut new,
                old: &point.old,
                explicit: &self.explicit,
                scales: self.settings.scales,
                tangent: self.settings.tangent,
                time: point.time,
                force_time: point.time,
                point: &mut self.point,
                min_j: 1.0,
                norms: BlockNorms::default(),
            };
            self.newton.recall(&mut system, point.age)?;
        }
        self.set_forces(End::New, clock.time);
        self.set_forces(End::Old, clock.time);
        Ok(())
    }
}

/// `t` as a decimal number: 0.3, not 0.30000000000000004.
pub(super) fn decimal(t: f64) -> f64 {
    (t * 1e12).round() / 1e12
}
