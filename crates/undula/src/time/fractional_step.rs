//! A step of fractional-step θ: three θ-steps that count as one.
//!
//! Each part has a pressure of its own, and is of first order by itself. Their mean, weighted by length, is
//! of second order at the middle of the step; so are the means of forces.

use super::kept::Parts;
use super::report::{StepFailure, StepReport};
use super::scheme::FRACTIONAL;
use super::stepper::Stepper;
use crate::space::State;
use crate::system::{Assembler, End, StepView};

impl<const D: usize> Stepper<D> {
    /// A step of three parts to the time `end` \[s\]; on failure everything is as before.
    pub(super) fn fractional_step(&mut self, k: f64, end: f64) -> Result<StepReport, StepFailure> {
        let clock = self.clock();
        let mut parts = self.parts.take().unwrap_or_else(|| Parts::new(&self.new));
        parts.states[0].copy_from(&self.new);
        parts.old.copy_from(&self.old);
        (parts.length, parts.times[0]) = (k, self.time);
        let mut total = StepReport::none();
        for (i, part) in FRACTIONAL.iter().enumerate() {
            let t = if i == 2 { end } else { self.time + part.length * k };
            match self.attempt(part.length * k, t, i) {
                Ok(report) => total.add(report),
                Err(failure) => {
                    self.set_clock(clock);
                    self.new.copy_from(&parts.states[0]);
                    self.old.copy_from(&parts.old);
                    return Err(failure);
                }
            }
            parts.states[i + 1].copy_from(&self.new);
            (parts.rules[i], parts.times[i + 1]) = (self.last_step().0, self.time);
        }
        let mean = |of: &dyn Fn(&State) -> f64| {
            (0..3).map(|i| FRACTIONAL[i].length * of(&parts.states[i + 1])).sum()
        };
        let State { p, s, .. } = &mut self.new;
        p.iter_mut().enumerate().for_each(|(n, p)| *p = mean(&|state| state.p[n]));
        let algebraic = self.assembler.algebraic_scalars();
        for (n, s) in s.iter_mut().enumerate().filter(|(n, _)| algebraic[*n]) {
            *s = mean(&|state| state.s[n]);
        }
        self.parts = Some(parts);
        total.parts = 1;
        Ok(total)
    }

    /// How many parts the last step had that forces are the mean of: 3 for fractional-step θ, else 1.
    pub fn n_parts(&self) -> usize {
        if self.parts.is_some() { FRACTIONAL.len() } else { 1 }
    }

    /// Part `i` of the last step, its weight in the means, and the assembly to evaluate it with.
    pub fn part(&mut self, i: usize) -> (f64, StepView<'_>, &mut Assembler<D>) {
        let Some(parts) = self.parts.take() else {
            let (rule, new, old, assembler) = self.last_step();
            return (1.0, StepView { rule, new, old }, assembler);
        };
        self.set_forces(End::Old, parts.times[i], 1.0);
        self.set_forces(End::New, parts.times[i + 1], 1.0);
        let Parts { rules, states, .. } = self.parts.insert(parts);
        let view = StepView { rule: rules[i], new: &states[i + 1], old: &states[i] };
        (FRACTIONAL[i].length, view, &mut self.assembler)
    }
}
