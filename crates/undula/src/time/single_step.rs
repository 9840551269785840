//! One step without division: boundary data, start value, Newton.

use super::cause::{self, Cause, Ended};
use super::report::{StepFailure, StepReport, keep};
use super::scheme::{Formula, Origin, Past, multistep};
use super::solver::{Moment, States};
use super::stepper::Stepper;
use super::system::StepSystem;
use crate::linear::BlockNorms;
use crate::nonlinear::{GROWTH, Newton, NewtonError, NewtonReport};
use crate::space::State;
use crate::system::{End, StepView};
use std::time::Instant;

/// How the iteration of a step begins.
struct Start<'a> {
    /// The old solution.
    old: &'a State,
    /// Where it begins if that is any good.
    guess: Guess<'a>,
    /// Residual at the old solution.
    reference: f64,
}

/// Where an iteration begins if that is any good.
#[derive(Copy, Clone)]
enum Guess<'a> {
    /// The old solution.
    Old,
    /// Its extrapolation with the solution before, by a ratio of the steps.
    Line(&'a State, f64),
    /// This state.
    Found(&'a State),
}

impl Start<'_> {
    /// The extrapolated solution, or the old one where that is no good, with the boundary data.
    /// Returns the residual there; `None` if not even the old solution is admissible.
    fn set<const D: usize>(&self, newton: &mut Newton, system: &mut StepSystem<'_, D>) -> Option<f64> {
        match self.guess {
            Guess::Old => {}
            Guess::Line(older, ratio) => system.new.extrapolate(older, self.old, ratio),
            Guess::Found(state) => system.new.copy_from(state),
        }
        if !matches!(self.guess, Guess::Old) {
            let follow = system.assembler.extension_is_constant();
            complete(system, follow);
            let norm = newton.norm(system).filter(|&norm| norm <= GROWTH * self.reference);
            if norm.is_some() {
                return norm;
            }
        }
        system.new.copy_from(self.old);
        complete(system, true);
        newton.norm(system)
    }
}

/// Set the boundary data, and take along what follows from them; the extension if asked to.
fn complete<const D: usize>(system: &mut StepSystem<'_, D>, follow: bool) {
    let assembler = &mut *system.assembler;
    let mut moved = assembler.constraints.displacements(&system.new.u);
    assembler.constraints.apply(&assembler.space, system.time, &mut system.new.v, &mut system.new.u);
    moved.iter_mut().for_each(|(at, before)| *before -= system.new.u[*at]);
    system.linear.start(assembler, system.rule, system.new, system.old, (&moved, follow));
}

impl<const D: usize> Stepper<D> {
    /// The formula of part `part` of a step, of length `k` \[s\].
    fn formula(&self, k: f64, part: usize) -> Formula {
        let ratio = if self.last_step > 0.0 { k / self.last_step } else { 0.0 };
        let past = Past { ratio, damped: self.damping.left > 0, part };
        let Formula { rule, origin } = self.settings.scheme.formula(k, &past);
        Formula { rule: self.settings.domain_motion.apply(rule), origin }
    }

    /// A step of one part, or part `part` of one, of length `k` to the time `t`; on failure everything is as before.
    pub(super) fn attempt(&mut self, k: f64, t: f64, part: usize) -> Result<StepReport, StepFailure> {
        let formula = self.formula(k, part);
        let t_old = self.time;
        std::mem::swap(&mut self.older, &mut self.old);
        std::mem::swap(&mut self.old, &mut self.new);
        // Now `old` is the last solution and `older` the one before.
        let solved = self.solve_step(&formula, k, (t_old, t), None);
        match solved {
            Ok((report, norms, min_j)) => {
                self.time = t;
                (self.last_step, self.last) = (k, formula);
                self.assembler.level(&mut self.new.p);
                Ok(StepReport::new(report, norms, min_j))
            }
            Err(ended) => {
                std::mem::swap(&mut self.old, &mut self.new);
                std::mem::swap(&mut self.older, &mut self.old);
                // `new` and `old` are as before; only the spare third state was written.
                self.newton.forget();
                let failure = StepFailure::new(t, k, None, ended);
                keep(&mut self.attempts, failure.attempt(1.0));
                Err(failure)
            }
        }
    }

    /// Set forces, explicit part, boundary data and the base of the difference of the step from `t_old` to `t`;
    /// returns the time of the body force.
    fn prepare(&mut self, formula: &Formula, t_old: f64, t: f64) -> f64 {
        let (start, rule) = (Instant::now(), formula.rule);
        self.fault = None;
        // cG(1) integrates over the step: its body force is that of the middle.
        let t_force = if rule.quadrature.is_empty() { t } else { 0.5 * (t_old + t) };
        self.set_forces(End::Old, t_old, 1.0);
        if !rule.has_explicit() {
            // It has no part in the step.
            self.fault = None;
        }
        self.set_forces(End::New, t_force, 1.0);
        let view = StepView { rule, new: &self.old, old: &self.old };
        self.assembler.explicit(&view, &mut self.explicit);
        if let Some(source) = &mut self.source {
            source(t_old, t, rule.theta, &mut self.explicit);
        }
        self.new.copy_from(&self.old);
        self.apply_boundary(t, 1.0);
        self.newton.seconds.assembly += start.elapsed().as_secs_f64();
        if let Origin::Multistep(ratio) = formula.origin {
            multistep(&mut self.base, &self.older, &self.old, ratio);
        }
        t_force
    }

    /// Solve the system of a step of length `k` from `t_old` to `t` \[s\], from `guess` or else from an extrapolation.
    pub(super) fn solve_step(
        &mut self,
        formula: &Formula,
        k: f64,
        (t_old, t): (f64, f64),
        guess: Option<&State>,
    ) -> Result<(NewtonReport, BlockNorms, f64), Ended> {
        let t_force = self.prepare(formula, t_old, t);
        if let Some(fault) = self.fault_of_all() {
            let (worst, cause) = (self.assembler.worst(), Box::new(Cause::Data(fault)));
            return Err(Ended { reason: NewtonError::Inadmissible, worst, cause });
        }
        let ratio = if self.last_step > 0.0 { k / self.last_step } else { 0.0 };
        let is_stage = formula.origin == Origin::Stages;
        let extrapolate = self.settings.extrapolate && ratio > 0.0 && !is_stage;
        let (solver, States { new, old, older, base }) = self.split();
        let moment = Moment { rule: formula.rule, time: t, force_time: t_force };
        let origin = if formula.origin == Origin::Old { old } else { base };
        let (mut system, newton) = solver.system(moment, new, origin);
        let guess = match guess {
            Some(state) => Guess::Found(state),
            None if extrapolate => Guess::Line(older, ratio),
            None => Guess::Old,
        };
        let solved = iterate(newton, &mut system, old, guess);
        let (report, min_j) = match solved {
            Ok(solved) => solved,
            Err(reason) => return Err(cause::find(&mut system, newton, reason)),
        };
        if let Some(point) = &mut system.point {
            point.age = newton.age();
        }
        if system.linear.count_step() {
            newton.forget();
        }
        Ok((report, system.norms, min_j))
    }
}

/// Solve `system` from `old`, or from `guess`; the smallest J of the solution.
fn iterate<const D: usize>(
    newton: &mut Newton,
    system: &mut StepSystem<'_, D>,
    old: &State,
    guess: Guess<'_>,
) -> Result<(NewtonReport, f64), NewtonError> {
    // The criterion refers to the old solution with the new boundary data, whatever the start value.
    if system.assembler.constraints.moves {
        // A boundary that moves further than a cell takes the domain along, which would fold else.
        system.new.copy_from(old);
        complete(system, true);
    }
    let reference = newton.norm(system).ok_or(NewtonError::Inadmissible)?;
    let start = Start { old, guess, reference };
    let norm = start.set(newton, system).ok_or(NewtonError::Inadmissible)?;
    let mut solved = newton.solve(system, norm, reference);
    while let Err(error) = &solved {
        // First the factors in place of multigrid, then the whole Jacobian.
        let leaves = error.is_of_linear_iteration() && system.linear.leave_multigrid();
        if *error == NewtonError::Stopped || !(leaves || system.linear.fall_back()) {
            break;
        }
        newton.forget();
        newton.counters.fallbacks += 1;
        let norm = start.set(newton, system).ok_or(NewtonError::Inadmissible)?;
        solved = newton.solve(system, norm, reference);
    }
    let report = solved?;
    let min_j = system.assembler.nodal_min_j(system.new);
    if min_j > 0.0 { Ok((report, min_j)) } else { Err(NewtonError::Inadmissible) }
}
