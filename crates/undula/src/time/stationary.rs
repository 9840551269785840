//! Stationary solutions, with the load raised in parts if need be.

use super::cause::{self, Cause, Ended};
use super::report::{StepFailure, StepReport, keep};
use super::solver::Moment;
use super::stepper::Stepper;
use crate::linear::BlockNorms;
use crate::nonlinear::{NewtonError, NewtonReport};
use crate::parallel::Reduce;
use crate::physics::StepRule;
use crate::space::State;
use crate::system::{End, StepView};
use crate::tangent::Linearization;

/// Solutions at most until the parameters of a stationary stabilisation have settled, and the relative change of
/// v at which they have.
const SETTLING: usize = 20;
const SETTLED: f64 = 1e-7;

/// Iterations, all in all, of a linear iteration whose load must be raised in parts: a smaller part of the load
/// changes nothing of its rate at the end.
const PATIENCE: usize = 100;

impl<const D: usize> Stepper<D> {
    /// The stationary solution at the present time, with the load raised in parts if need be.
    ///
    /// # Errors
    /// [`StepFailure`] if even small increments of the load have no solution.
    pub fn stationary(&mut self) -> Result<StepReport, StepFailure> {
        // Of a solid alone the reduced Jacobian is the whole one.
        self.newton.gives_up = match self.linear.active {
            Linearization::FixedPoint => true,
            Linearization::Reduced => self.assembler.physics.fluid.is_some(),
            Linearization::Condensed | Linearization::Newton => false,
        };
        self.whole_at_rest = self.assembler.space.deforms;
        self.attempts.clear();
        let allowed = self.newton.settings.max_steps;
        let mut result = self.raise_load();
        self.newton.settings.max_steps = allowed;
        if let Err(failure) = &mut result {
            failure.details.attempts = std::mem::take(&mut self.attempts);
        }
        self.newton.gives_up = false;
        result
    }

    fn raise_load(&mut self) -> Result<StepReport, StepFailure> {
        let (mut load, mut increment) = (0.0f64, 1.0f64);
        let mut total = StepReport::none();
        let (mut last_load, mut spent) = (0.0f64, 0);
        let allowed = self.newton.settings.max_steps;
        let mut last_failure = None;
        while load < 1.0 {
            let next = (load + increment).min(1.0);
            match self.stationary_at(next, load, last_load, 0.0) {
                Ok(report) => {
                    let min_j = report.min_j;
                    spent += report.newton_steps;
                    total.add(report);
                    total.min_j = min_j;
                    (last_load, load) = (load, next);
                    increment *= 2.0;
                }
                Err(mut failure) => {
                    spent += failure.reason.norms().len().saturating_sub(1);
                    failure.details.load = Some(load);
                    if failure.is_stop() || failure.is_final() {
                        return Err(failure);
                    }
                    let condensed = self.linear.active == Linearization::Condensed;
                    if condensed && !self.whole_at_rest && !self.linear.is_multigrid() {
                        self.whole_at_rest = true;
                        continue;
                    }
                    let slow = matches!(failure.reason, NewtonError::Slow { .. }) || spent >= PATIENCE;
                    if increment < 1e-3 || self.newton.gives_up && slow {
                        self.blame_rate(&mut failure, spent, allowed);
                        return Err(failure);
                    }
                    increment = 0.5 * increment.min(1.0 - load);
                    last_failure = Some(failure);
                }
            }
            // After the first failure the parts share the iterations that are left.
            if let (true, Some(mut failure)) = (self.newton.gives_up && load < 1.0, last_failure.take()) {
                if spent >= PATIENCE {
                    self.blame_rate(&mut failure, spent, allowed);
                    return Err(failure);
                }
                self.newton.settings.max_steps = allowed.min(PATIENCE - spent);
                last_failure = Some(failure);
            }
        }
        self.settle(&mut total)?;
        Ok(total)
    }

    /// A linear iteration that failed after `spent` of the `allowed` iterations, all in all: its rate is the cause.
    fn blame_rate(&self, failure: &mut StepFailure, spent: usize, allowed: usize) {
        if let Cause::Slow { done, allowed: told, .. } = &mut failure.details.cause {
            *done = spent;
            *told = if self.newton.settings.max_steps < allowed { PATIENCE } else { allowed };
        } else if let (true, [first, .., last]) = (self.newton.gives_up, failure.reason.norms()) {
            let rate = (last / first).powf(1.0 / (failure.reason.norms().len() - 1) as f64);
            failure.details.cause = Cause::Slow { rate, done: spent, left: f64::INFINITY, allowed };
        }
    }

    /// Parameters of the stabilisation come from the state before: repeat until they are those of the solution.
    fn settle(&mut self, total: &mut StepReport) -> Result<(), StepFailure> {
        let reference = self.reference;
        for _ in 0..if self.assembler.is_stabilized() { SETTLING } else { 0 } {
            let before = self.new.v.clone();
            let report = self.stationary_at(1.0, 0.0, 0.0, reference)?;
            let (newton_steps, min_j) = (report.newton_steps, report.min_j);
            let parts = total.parts;
            total.add(report);
            (total.parts, total.min_j) = (parts, min_j);
            let size = |sum: f64, x: f64| sum.max(x.abs());
            let change = before.iter().zip(&self.new.v).map(|(a, b)| a - b).fold(0.0, size);
            let mut both = [change, self.new.v.iter().copied().fold(0.0, size)];
            self.assembler.space.reduce(Reduce::Max, &mut both);
            if newton_steps == 0 || both[0] <= SETTLED * both[1] {
                break;
            }
        }
        Ok(())
    }

    /// Body forces, sources and boundary data of `t` \[s\], forces and boundary data times `load`.
    fn set_load(&mut self, t: f64, load: f64) {
        self.set_forces(End::New, t, load);
        self.explicit.fill(0.0);
        if let Some(source) = &mut self.source {
            source(t, t, 1.0, &mut self.explicit);
        }
        self.assembler.constraints.still = true;
        self.apply_boundary(t, load);
        self.assembler.constraints.still = false;
    }

    /// The residual of the stationary equations at `state` with the whole load of the present time, `[v, u, p, s]`.
    pub fn load_of(&mut self, state: &State) -> Vec<f64> {
        self.set_load(self.time, 1.0);
        let mut residual = self.explicit.clone();
        let step = StepView { rule: StepRule::STATIONARY, new: state, old: state };
        self.assembler.residual(&step, &mut residual);
        residual
    }

    /// Take the domain along with boundaries whose displacement the load has changed, `given` before.
    fn follow_boundary(&mut self, given: Vec<(usize, f64)>, before: &State) {
        let moved: Vec<_> = given.into_iter().map(|(at, u)| (at, u - self.new.u[at])).collect();
        let Stepper { linear, assembler, new, .. } = self;
        linear.start(assembler, StepRule::STATIONARY, new, before, (&moved, true));
    }

    /// The solution with the part `load` of the load, from those with `before` and `earlier`.
    ///
    /// The criterion refers to the residual at the start, or to `least` if that is larger.
    fn stationary_at(
        &mut self,
        load: f64,
        before: f64,
        earlier: f64,
        least: f64,
    ) -> Result<StepReport, StepFailure> {
        let t = self.time;
        let (before_state, earlier_state) = (self.new.clone(), self.old.clone());
        if before > 0.0 {
            let ratio =
                if before > earlier && earlier > 0.0 { (load - before) / (before - earlier) } else { 0.0 };
            self.new.extrapolate(&earlier_state, &before_state, ratio);
        }
        self.fault = None;
        let given = self.assembler.constraints.displacements(&self.new.u);
        self.set_load(t, load);
        self.newton.forget();
        let active = self.linear.active;
        if self.whole_at_rest && active == Linearization::Condensed {
            self.linear.active = Linearization::Newton;
        }
        let moves = self.assembler.is_moved();
        if moves && !self.assembler.space.any(self.fault.is_some()) {
            self.follow_boundary(given, &before_state);
        }
        let solved = self.solve_load(least, &before_state);
        let of_linear = solved.as_ref().is_err_and(|ended| ended.reason.is_of_linear_iteration());
        let leaves = of_linear && self.linear.leave_multigrid();
        self.linear.active = active;
        if leaves {
            self.newton.counters.fallbacks += 1;
            self.new = before_state;
            return self.stationary_at(load, before, earlier, least);
        }
        match solved {
            Ok((report, norms, min_j)) => {
                self.old = before_state;
                self.assembler.level(&mut self.new.p);
                Ok(StepReport::new(report, norms, min_j))
            }
            Err(ended) => {
                self.new = before_state;
                let failure = StepFailure::new(t, 0.0, Some(0.0), ended);
                keep(&mut self.attempts, failure.attempt(load));
                Err(failure)
            }
        }
    }

    /// The solution with the load that is set, its norms and its smallest J; `before` is the solution before.
    fn solve_load(&mut self, least: f64, before: &State) -> Result<(NewtonReport, BlockNorms, f64), Ended> {
        let (t, fault) = (self.time, self.fault_of_all());
        let (solver, states) = self.split();
        let moment = Moment { rule: StepRule::STATIONARY, time: t, force_time: t };
        let (mut system, newton) = solver.system(moment, states.new, before);
        let norm = newton.norm(&mut system).filter(|_| fault.is_none());
        let reference = norm.map(|norm| norm.max(least));
        let solved = match norm.zip(reference) {
            Some((norm, reference)) => newton.solve(&mut system, norm, reference),
            None => Err(NewtonError::Inadmissible),
        };
        let (norms, min_j) = (system.norms, system.assembler.nodal_min_j(system.new));
        let solved = solved.and_then(|r| if min_j > 0.0 { Ok(r) } else { Err(NewtonError::Inadmissible) });
        let solved = solved.map_err(|reason| match fault {
            Some(fault) => {
                let (worst, cause) = (system.assembler.worst(), Box::new(Cause::Data(fault)));
                Ended { reason, worst, cause }
            }
            None => cause::find(&mut system, newton, reason),
        });
        self.reference = reference.unwrap_or(self.reference);
        Ok((solved?, norms, min_j))
    }
}
