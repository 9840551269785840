//! What a Runge-Kutta method keeps of its stages, and what it makes of them: old states and guesses of the next.

use super::tableau::MOST;
use crate::space::State;

/// Degree of the polynomial in time that the derivatives of a stage are expected to follow.
const DEGREE: usize = 2;

/// What is known of the derivative at the beginning of the next step.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Known {
    /// Nothing: there was no step.
    Nothing,
    /// It is the one that the last step began with: that step was taken back, or has failed.
    First,
    /// It is that of the last stage.
    Last,
}

/// Stages of one step.
#[derive(Default)]
pub(super) struct Samples {
    /// Times \[s\]; the first is the beginning of the step.
    pub(super) times: Vec<f64>,
    /// Derivatives of v, u and s, with the pressures of the stages.
    pub(super) rates: Vec<State>,
}

/// What a Runge-Kutta method keeps from step to step.
pub(super) struct Stages {
    pub(super) now: Samples,
    /// Those of the step before.
    past: Samples,
    pub(super) known: Known,
    /// Where the iteration of a stage begins.
    pub(super) guess: State,
}

impl Samples {
    fn new(like: &State) -> Samples {
        Samples { times: vec![], rates: vec![like.clone(); MOST] }
    }

    /// Those that a checkpoint keeps: all but the first, which is the last of the step before.
    fn kept(&self) -> Vec<(f64, State)> {
        self.times.iter().copied().zip(self.rates.iter().cloned()).skip(1).collect()
    }

    fn last(&self) -> &State {
        &self.rates[self.times.len() - 1]
    }
}

impl Stages {
    pub(super) fn new(like: &State) -> Stages {
        let (now, past, guess) = (Samples::new(like), Samples::new(like), like.clone());
        Stages { now, past, known: Known::Nothing, guess }
    }

    /// What a checkpoint keeps: the stages of the last step that counts.
    pub(super) fn save(&self) -> Vec<(f64, State)> {
        match self.known {
            Known::Nothing => vec![],
            Known::First => self.past.kept(),
            Known::Last => self.now.kept(),
        }
    }

    /// Those that a checkpoint has kept; `like` has their sizes.
    pub(super) fn restore(kept: Vec<(f64, State)>, like: &State) -> Option<Stages> {
        let (last, _) = kept.last()?;
        let mut stages = Stages::new(like);
        stages.now.times.push(*last);
        for (i, (time, rate)) in kept.into_iter().enumerate().take(MOST - 1) {
            stages.now.times.push(time);
            stages.now.rates[i + 1] = rate;
        }
        stages.known = Known::Last;
        Some(stages)
    }

    /// The last step is taken back.
    pub(super) fn go_back(&mut self) {
        let began = !self.past.times.is_empty();
        self.known = if began { Known::First } else { Known::Nothing };
    }

    /// Begin a step at `time` \[s\].
    pub(super) fn begin(&mut self, time: f64) {
        if self.known == Known::Last {
            std::mem::swap(&mut self.now, &mut self.past);
            self.now.rates[0].copy_from(self.past.last());
            self.known = Known::First;
        }
        self.now.times.clear();
        self.now.times.push(time);
    }

    /// `out` = w⁻ + k Σ aᵢⱼ ẇⱼ.
    pub(super) fn combine(&self, row: &[f64], k: f64, old: &State, out: &mut State) {
        out.copy_from(old);
        for (a, rate) in row.iter().zip(&self.now.rates).filter(|(a, _)| **a != 0.0) {
            for (out, rate) in [(&mut out.v, &rate.v), (&mut out.u, &rate.u), (&mut out.s, &rate.s)] {
                out.iter_mut().zip(rate).for_each(|(out, rate)| *out += k * a * rate);
            }
        }
    }

    /// Sets the guess for the stage at the time `t` \[s\] with γ k = `step` and h = `base`; false if nothing is known.
    pub(super) fn predict(&mut self, t: f64, step: f64, base: &State) -> bool {
        let Stages { now, past, known, guess } = self;
        let started = *known == Known::First && !past.times.is_empty();
        let before = past.times.iter().zip(&past.rates).skip(1).filter(|_| started);
        // The first of a step is the last of the one before, which the derivative at the start alone is not.
        let has_first = *known == Known::First && !started;
        let present = now.times.iter().zip(&now.rates).skip(usize::from(!has_first));
        let (mut times, mut rates, mut n) = ([0.0; 2 * MOST], [base; 2 * MOST], 0);
        for (time, rate) in before.chain(present) {
            (times[n], rates[n]) = (*time, rate);
            n += 1;
        }
        if n == 0 {
            return false;
        }
        let weights = fit(&times[..n], t, DEGREE.min(n - 1));
        guess.copy_from(base);
        guess.p.fill(0.0);
        for (weight, rate) in weights.iter().zip(&rates[..n]) {
            let parts = [
                (&mut guess.v, &rate.v, step),
                (&mut guess.u, &rate.u, step),
                (&mut guess.s, &rate.s, step),
                (&mut guess.p, &rate.p, 1.0),
            ];
            for (out, rate, factor) in parts {
                out.iter_mut().zip(rate).for_each(|(out, rate)| *out += factor * weight * rate);
            }
        }
        true
    }

    /// Keep the solution `new` of the stage at `t` \[s\].
    pub(super) fn keep(&mut self, t: f64, per_step: f64, new: &State, base: &State) {
        differentiate(&mut self.now.rates[self.now.times.len()], per_step, new, base);
        self.now.times.push(t);
    }
}

/// `rate` = `per_step` (`new` − `base`), with the pressure of `new`.
pub(super) fn differentiate(rate: &mut State, per_step: f64, new: &State, base: &State) {
    let parts =
        [(&mut rate.v, &new.v, &base.v), (&mut rate.u, &new.u, &base.u), (&mut rate.s, &new.s, &base.s)];
    for (rate, new, base) in parts {
        rate.iter_mut().zip(new).zip(base).for_each(|((rate, new), base)| *rate = per_step * (new - base));
    }
    rate.p.copy_from_slice(&new.p);
}

/// Weights of values at `times` in the value at `t` of the polynomial that fits them best.
fn fit(times: &[f64], t: f64, degree: usize) -> [f64; 2 * MOST] {
    let n = times.len();
    let (first, last) = times.iter().fold((t, t), |(a, b), &x| (a.min(x), b.max(x)));
    let scaled = |x: f64| if last > first { (x - first) / (last - first) } else { 0.0 };
    let mut weights = [0.0; 2 * MOST];
    // Polynomials orthonormal over the times, with their values at t behind.
    let mut basis = [[0.0; 2 * MOST + 1]; DEGREE + 1];
    for m in 0..=degree.min(DEGREE) {
        let (before, rest) = basis.split_at_mut(m);
        let next = &mut rest[0];
        for (i, x) in times.iter().chain(&[t]).enumerate() {
            next[i] = scaled(*x).powi(m as i32);
        }
        // Twice is enough.
        for _ in 0..2 {
            for one in before.iter() {
                let along: f64 = (0..n).map(|i| one[i] * next[i]).sum();
                (0..=n).for_each(|i| next[i] -= along * one[i]);
            }
        }
        let size = next[..n].iter().map(|x| x * x).sum::<f64>().sqrt();
        if size < 1e-9 {
            break;
        }
        next.iter_mut().for_each(|x| *x /= size);
        (0..n).for_each(|i| weights[i] += next[i] * next[n]);
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_reproduce_polynomials() {
        let times = [0.0, 0.3, 0.55, 0.6, 1.0, 1.45];
        for degree in 0..=DEGREE {
            let weights = fit(&times, 1.7, degree);
            for power in 0..=degree as i32 {
                let found: f64 = times.iter().zip(weights).map(|(t, w)| w * t.powi(power)).sum();
                assert!((found - 1.7f64.powi(power)).abs() < 1e-12, "{degree} {power}: {found}");
            }
        }
    }

    /// As at a restart, where a stage may have the time of another one.
    #[test]
    fn equal_times_are_no_fault() {
        let weights = fit(&[1.0, 1.0, 1.0], 1.0, 2);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14 && weights.iter().all(|w| w.is_finite()));
    }
}
