//! A step of a Runge-Kutta method: some steps of backward Euler from other old states, all with one matrix.
//!
//! The unknowns of a stage are its solution w; its derivative ẇ = (w − h)/(γ k) is kept at the nodes. So the changing
//! mass ρ J of the momentum is taken at the stage, and the velocity of the domain is ∂_t u of the stage, as v = ∂_t u
//! of the solid.

use super::report::{StepFailure, StepReport, keep};
use super::scheme::{Formula, Origin};
use super::stages::{Known, Stages, differentiate};
use super::stepper::Stepper;
use super::tableau::{START, Tableau};
use crate::algebra;
use crate::nonlinear::NewtonError;
use crate::parallel::Reduce;
use crate::physics::StepRule;
use crate::space::State;

/// Part of the first step over which differences are taken for the derivative at the start: its error is the square.
const SHORT: f64 = 1e-4;

/// Ratio of the differences over 2 h and over h below which data jump: it is ½ then.
const JUMP: f64 = 0.75;

impl<const D: usize> Stepper<D> {
    /// A step of length `k` to the time `end` \[s\]; on failure everything is as before.
    pub(super) fn runge_kutta(
        &mut self,
        method: &'static Tableau,
        k: f64,
        end: f64,
    ) -> Result<StepReport, StepFailure> {
        let mut stages = self.stages.take().unwrap_or_else(|| Stages::new(&self.new));
        stages.begin(self.time);
        std::mem::swap(&mut self.older, &mut self.old);
        std::mem::swap(&mut self.old, &mut self.new);
        let mut total = StepReport::none();
        let begun =
            if stages.known == Known::Nothing { self.start_rate(&mut stages, k, &mut total) } else { Ok(()) };
        let method = if stages.known == Known::First { method } else { &START };
        let result = begun.and_then(|()| self.all_stages(method, &mut stages, (k, end), total));
        match &result {
            Ok(_) => {
                stages.known = Known::Last;
                (self.time, self.last_step) = (end, k);
            }
            Err(failure) => {
                std::mem::swap(&mut self.old, &mut self.new);
                std::mem::swap(&mut self.older, &mut self.old);
                self.newton.forget();
                keep(&mut self.attempts, failure.attempt(1.0));
            }
        }
        self.stages = Some(stages);
        result
    }

    /// The derivative at the start, by short steps of backward Euler over h and 2h, 2 d(h) − d(2h); it stays unknown where
    /// data jump, so that the differences do not converge.
    fn start_rate(&mut self, stages: &mut Stages, k: f64, total: &mut StepReport) -> Result<(), StepFailure> {
        let (start, tolerance) = (self.time, self.newton.settings.tolerance);
        let mut sizes = [0.0; 2];
        for (i, part) in [2.0 * SHORT, SHORT].into_iter().enumerate() {
            let (step, t) = (part * k, start + part * k);
            let rule = self.settings.domain_motion.apply(StepRule::theta(step, 1.0));
            let formula = Formula { rule, origin: Origin::Old };
            self.newton.forget();
            // The criterion refers to velocities, of which these are small parts.
            self.newton.settings.tolerance = SHORT * tolerance;
            let solved = self.solve_step(&formula, step, (start, t), None);
            self.newton.settings.tolerance = tolerance;
            self.newton.forget();
            match solved {
                Ok((report, norms, min_j)) => total.add(StepReport::new(report, norms, min_j)),
                Err(ended) if ended.reason == NewtonError::Stopped => {
                    return Err(StepFailure::new(t, step, None, ended));
                }
                Err(_) => return Ok(()),
            }
            let rate = if i == 0 { &mut stages.guess } else { &mut stages.now.rates[0] };
            differentiate(rate, rule.per_k, &self.new, &self.old);
            sizes[i] = self.assembler.space.over_all(Reduce::Max, algebra::norm_inf(&rate.v));
        }
        if sizes[0] >= JUMP * sizes[1] {
            let (State { v, u, p, s }, over) = (&mut stages.now.rates[0], &stages.guess);
            for (rate, over) in [(v, &over.v), (u, &over.u), (p, &over.p), (s, &over.s)] {
                rate.iter_mut().zip(over).for_each(|(rate, over)| *rate += *rate - over);
            }
            stages.known = Known::First;
        }
        Ok(())
    }

    fn all_stages(
        &mut self,
        method: &Tableau,
        stages: &mut Stages,
        (k, end): (f64, f64),
        mut total: StepReport,
    ) -> Result<StepReport, StepFailure> {
        let (start, step) = (self.time, method.gamma * k);
        let rule = self.settings.domain_motion.apply(StepRule::theta(step, 1.0));
        let formula = Formula { rule, origin: Origin::Stages };
        let n = method.c.len();
        for i in 1..n {
            let t = if i + 1 == n { end } else { start + method.c[i] * k };
            stages.combine(method.a[i], k, &self.old, &mut self.base);
            let guessed = self.settings.extrapolate && stages.predict(t, step, &self.base);
            let guess = guessed.then_some(&stages.guess);
            let (report, norms, min_j) = self
                .solve_step(&formula, k, (start, t), guess)
                .map_err(|ended| StepFailure::new(t, k, None, ended))?;
            self.assembler.level(&mut self.new.p);
            stages.keep(t, rule.per_k, &self.new, &self.base);
            total.add(StepReport::new(report, norms, min_j));
        }
        self.last = formula;
        total.parts = 1;
        Ok(total)
    }

    /// The local error of the embedded method in the last step: its largest components in v \[m/s\] and u \[m\];
    /// `None` without such a method.
    pub(super) fn embedded_error(&self, k: f64) -> Option<[f64; 2]> {
        let (stages, method) = (self.stages.as_ref()?, self.settings.scheme.tableau()?);
        if stages.known != Known::Last || stages.now.times.len() != method.error.len() {
            return None;
        }
        let rates = &stages.now.rates;
        let largest = |of: fn(&State) -> &Vec<f64>| {
            (0..of(&self.new).len()).fold(0.0f64, |worst, n| {
                let sum: f64 = method.error.iter().zip(rates).map(|(e, rate)| e * of(rate)[n]).sum();
                worst.max((k * sum).abs())
            })
        };
        let mut errors = [largest(|state| &state.v), largest(|state| &state.u)];
        self.assembler.space.reduce(Reduce::Max, &mut errors);
        Some(errors)
    }
}
