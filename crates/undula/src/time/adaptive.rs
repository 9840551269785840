//! The length of steps from an estimate of their local error.
//!
//! The estimate compares a step with the polynomial through its end and the three solutions before: the
//! leading term of the local error of every scheme is a multiple of a divided difference of these, which costs
//! no further solve (Milne's device; Gresho, Lee and Sani 1980 for Navier-Stokes equations). A Runge-Kutta method is
//! compared with its embedded one, which costs none either.

use super::memory::Clock;
use super::report::{StepFailure, StepReport};
use super::schedule::{STRETCH, decimal};
use super::stepper::Stepper;
use crate::parallel::Reduce;
use crate::space::State;

/// Bounds of step-size control.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AdaptiveSettings {
    /// Largest local error of a step: of v relative to the largest v so far, and of u relative to the largest u.
    pub tolerance: f64,
    /// Steps of this length are taken whatever their error \[s\].
    pub min_step: f64,
    /// Longest step \[s\].
    pub max_step: f64,
    /// Part of the step that would meet the tolerance exactly.
    pub safety: f64,
}

/// Largest ratio of a step to the one before, and smallest to one that was rejected.
const GROWTH: f64 = 2.0;
const SHRINK: f64 = 0.2;

/// A step that could grow by less than this stays as it is: a new length costs a new Jacobian.
const WORTHWHILE: f64 = 1.25;

/// What control remembers, all that a checkpoint needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// Length of the next step \[s\].
    pub next: f64,
    /// Largest components of v \[m/s\] and u \[m\] so far.
    pub scales: [f64; 2],
    /// Steps that were rejected.
    pub rejected: u64,
    /// The last solutions, latest first: time \[s\], v and u.
    pub past: Vec<(f64, [Vec<f64>; 2])>,
}

/// Step-size control.
pub struct Adaptive {
    /// Bounds.
    pub settings: AdaptiveSettings,
    /// What it remembers.
    pub memory: Memory,
    new: State,
    old: State,
}

impl Adaptive {
    /// With a first step of length `first` \[s\].
    pub fn new(settings: AdaptiveSettings, first: f64) -> Adaptive {
        let memory = Memory { next: first, ..Memory::default() };
        Adaptive { settings, memory, new: State::default(), old: State::default() }
    }

    /// A step whose error is within the tolerance, at most to `target` \[s\], which it hits exactly.
    ///
    /// # Errors
    /// [`StepFailure`] if a step has no solution even in parts; everything is then as before it.
    pub fn step<const D: usize>(
        &mut self,
        stepper: &mut Stepper<D>,
        target: f64,
    ) -> Result<StepReport, StepFailure> {
        if self.memory.past.is_empty() {
            self.remember(stepper);
        }
        let (next, rejected) = (self.memory.next, self.memory.rejected);
        let result = self.steps(stepper, target);
        if result.is_err() {
            (self.memory.next, self.memory.rejected) = (next, rejected);
        }
        result
    }

    /// Whether the target, `rest` \[s\] from now, determines the length of the next step.
    pub fn feels(&self, rest: f64) -> bool {
        self.length(rest) != self.length(f64::INFINITY)
    }

    /// Steps until one is accepted.
    fn steps<const D: usize>(
        &mut self,
        stepper: &mut Stepper<D>,
        target: f64,
    ) -> Result<StepReport, StepFailure> {
        let mut spent = StepReport::none();
        loop {
            let rest = target - stepper.time;
            let k = self.length(rest);
            let before = self.save(stepper);
            let end = if k == rest { target } else { decimal(stepper.time, k) };
            let of_last = stepper.step_to(k, end)?;
            let (parts, min_j) = (of_last.parts, of_last.min_j);
            spent.add(of_last);
            let report = StepReport { parts, min_j, ..spent };
            let factor = if stepper.was_damped() { None } else { self.factor(stepper, k) };
            let rejected = factor.is_some_and(|factor| factor < self.settings.safety);
            // The smallest step is not rejected, also where it is a little longer to end at the target.
            if !rejected || k <= (1.0 + STRETCH) * self.settings.min_step {
                self.accept(k, factor.unwrap_or(1.0));
                self.remember(stepper);
                return Ok(report);
            }
            self.memory.rejected += 1;
            self.memory.next = (k * factor.unwrap_or(1.0).max(SHRINK)).max(self.settings.min_step);
            stepper.go_back(before, &self.new, &self.old);
            spent = report;
        }
    }

    /// The next step, `rest` \[s\] before a time that is to be hit: without a small one at the end.
    fn length(&self, rest: f64) -> f64 {
        let k = self.memory.next.clamp(self.settings.min_step, self.settings.max_step);
        if rest <= (1.0 + STRETCH) * k {
            rest
        } else if rest < 2.0 * k {
            0.5 * rest
        } else {
            k
        }
    }

    /// The length of the step after one of length `k` that could have been `factor` times as long.
    fn accept(&mut self, k: f64, factor: f64) {
        let next = &mut self.memory.next;
        if k < 0.999 * *next {
            // Shortened to hit a time: that says nothing against longer ones.
            *next = next.min((k * factor).max(self.settings.min_step));
        } else if !(1.0..WORTHWHILE).contains(&factor) {
            *next = (k * factor.min(GROWTH)).clamp(self.settings.min_step, self.settings.max_step);
        }
    }

    /// By how much a step of length `k` that was just done could be longer; `None` without an estimate.
    fn factor<const D: usize>(&self, stepper: &Stepper<D>, k: f64) -> Option<f64> {
        let scheme = stepper.settings.scheme;
        let (worst, order) = match scheme.tableau() {
            Some(_) => (self.embedded(stepper, k)?, scheme.order()),
            None => (self.milne(stepper, k)?, scheme.order() + 1),
        };
        if worst == 0.0 {
            return Some(GROWTH);
        }
        let ratio = self.settings.tolerance / worst;
        Some(self.settings.safety * ratio.powf(1.0 / f64::from(order)))
    }

    /// The relative error of the embedded method, of the order of the scheme; `None` in the first step.
    fn embedded<const D: usize>(&self, stepper: &Stepper<D>, k: f64) -> Option<f64> {
        let errors = stepper.embedded_error(k)?.into_iter().zip(self.memory.scales);
        let mut worst = 0.0f64;
        for ((error, scale), new) in errors.zip([&stepper.new.v, &stepper.new.u]) {
            let scale = new.iter().fold(scale, |scale, x| scale.max(x.abs()));
            let scale = stepper.assembler.space.over_all(Reduce::Max, scale);
            if error > f64::MIN_POSITIVE {
                worst = worst.max(error / scale);
            }
        }
        Some(worst)
    }

    /// The relative error by a divided difference, of the order after that of the scheme; `None` without enough past.
    fn milne<const D: usize>(&self, stepper: &Stepper<D>, k: f64) -> Option<f64> {
        let [(t1, first), (t2, second), (t3, third)] = &self.memory.past[..] else { return None };
        let c = stepper.settings.scheme.local_error(k, [stepper.time, *t1, *t2, *t3]);
        let mut worst = 0.0f64;
        for (field, new) in [&stepper.new.v, &stepper.new.u].into_iter().enumerate() {
            let (mut error, mut scale) = (0.0f64, self.memory.scales[field]);
            let past = first[field].iter().zip(&second[field]).zip(&third[field]);
            for (new, ((a, b), c3)) in new.iter().zip(past) {
                error = error.max((c[0] * new + c[1] * a + c[2] * b + c[3] * c3).abs());
                scale = scale.max(new.abs());
            }
            let mut both = [error, scale];
            stepper.assembler.space.reduce(Reduce::Max, &mut both);
            let [error, scale] = both;
            if error > f64::MIN_POSITIVE {
                worst = worst.max(error / scale);
            }
        }
        Some(worst)
    }

    fn remember<const D: usize>(&mut self, stepper: &Stepper<D>) {
        let Memory { past, scales, .. } = &mut self.memory;
        let mut fields =
            if past.len() == 3 { past.pop().map(|(_, f)| f).unwrap_or_default() } else { Default::default() };
        for ((field, new), scale) in fields.iter_mut().zip([&stepper.new.v, &stepper.new.u]).zip(scales) {
            field.clone_from(new);
            let largest = field.iter().fold(*scale, |scale, x| scale.max(x.abs()));
            *scale = stepper.assembler.space.over_all(Reduce::Max, largest);
        }
        past.insert(0, (stepper.time, fields));
    }

    fn save<const D: usize>(&mut self, stepper: &Stepper<D>) -> Clock {
        for (kept, state) in [(&mut self.new, &stepper.new), (&mut self.old, &stepper.old)] {
            if kept.v.is_empty() {
                *kept = state.clone();
            } else {
                kept.copy_from(state);
            }
        }
        stepper.clock()
    }
}
