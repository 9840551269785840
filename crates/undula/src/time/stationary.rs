//! Stationary solutions, with the load raised in parts if need be.

use super::report::{StepFailure, StepReport};
use super::stepper::Stepper;
use super::system::{BlockNorms, StepSystem};
use crate::assembly::End;
use crate::nonlinear::NewtonError;
use crate::physics::StepRule;
use crate::tangent::Linearization;

/// Solutions at most until the parameters of a stationary stabilisation have settled, and the relative change of
/// v at which they have.
const SETTLING: usize = 20;
const SETTLED: f64 = 1e-7;

impl<const D: usize> Stepper<D> {
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
                    total.residuals.extend(report.residuals);
                    (total.norms, total.min_j) = (report.norms, report.min_j);
                    (last_load, load) = (load, next);
                    increment *= 2.0;
                }
                Err(failure) if failure.is_stop() || increment < 1e-3 => return Err(failure),
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

    /// Body forces, sources and boundary data of `t` \[s\], forces and boundary data times `load`.
    fn set_load(&mut self, t: f64, load: f64) {
        self.set_forces(End::New, t, load);
        self.explicit.fill(0.0);
        if let Some(source) = &mut self.source {
            source(t, t, 1.0, &mut self.explicit);
        }
        self.apply_boundary(t, load);
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
        self.set_load(t, load);
        self.newton.forget();
        let active = self.linear.active;
        // At rest u does not follow from v.
        if self.assembler.space.deforms && active == Linearization::Condensed {
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
                self.assembler.level(&mut self.new.p);
                Ok(StepReport::new(report, norms, min_j))
            }
            Err(reason) => {
                let worst = self.assembler.worst();
                self.new = before_state;
                Err(StepFailure { time: t, step: 0.0, reason, worst })
            }
        }
    }
}
