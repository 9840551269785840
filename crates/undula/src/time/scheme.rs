//! Schemes as tables.

use crate::physics::StepRule;
use crate::physics::step::{GALERKIN, MIDPOINT};
use crate::space::State;

/// How steps are weighed, section 5.1.2.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Scheme {
    /// Implicit weight θ; 1 is backward Euler, ½ Crank-Nicolson.
    Theta {
        /// Weight of the new time.
        theta: f64,
    },
    /// θ = ½ + c k: second order, and damps what Crank-Nicolson keeps.
    ShiftedCrankNicolson {
        /// c \[1/s\].
        shift: f64,
    },
    /// Crank-Nicolson with some steps of backward Euler, of the same length, from t₀, t₀ + interval, … on.
    Rannacher {
        /// Steps of backward Euler.
        steps: u32,
        /// Interval \[s\].
        interval: f64,
    },
    /// Three θ-steps in one: strongly A-stable, second order.
    FractionalStepTheta,
    /// cG(1): linear trial functions, test functions constant in each step.
    Galerkin,
    /// Backward differentiation over two steps, of any lengths; Crank-Nicolson first.
    Bdf2,
}

/// Where in the step the factors of ∂_t in the fluid are taken, section 5.1.2.1.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum DomainMotion {
    /// At both ends.
    #[default]
    Secant,
    /// In the middle, at (1 − θ) U⁻ + θ U.
    Midpoint,
    /// A third of the first and two of the second.
    Galerkin,
}

/// A θ-step that is a part of a step of fractional-step θ.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Part {
    /// Its length as a part of k.
    pub length: f64,
    /// Its θ.
    pub theta: f64,
}

/// γ = 1 − √½, α = (1 − 2γ)/(1 − γ) = 2 − √2, β = 1 − α.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
const ALPHA: f64 = 2.0 - std::f64::consts::SQRT_2;

/// Lengths γ, 1 − 2γ, γ and implicit weights α, β, α. As α γ = β (1 − 2γ), all have the same matrix k⁻¹M + θA but
/// for a factor.
pub const FRACTIONAL: [Part; 3] = [
    Part { length: GAMMA, theta: ALPHA },
    Part { length: 1.0 - 2.0 * GAMMA, theta: 1.0 - ALPHA },
    Part { length: GAMMA, theta: ALPHA },
];

/// Ratio of one step to that before, above which BDF2 is unstable: it begins anew there.
const MAX_RATIO: f64 = 1.0 + std::f64::consts::SQRT_2;

/// What a rule depends on besides the length of the step.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Past {
    /// Length of the step by that of the one before; 0 where there is none.
    pub ratio: f64,
    /// Whether the step is one of the damping steps of Rannacher's scheme.
    pub damped: bool,
    /// Number of the part of the step.
    pub part: usize,
}

/// Where Rannacher's scheme stands.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Damping {
    /// Intervals begun.
    pub interval: u64,
    /// Damping steps still to come in this one.
    pub left: u32,
}

/// What a step is made of.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Formula {
    /// Its weights.
    pub rule: StepRule,
    /// BDF2: ratio ω of this step to the one before; the old state is then [`multistep`].
    pub ratio: Option<f64>,
}

impl Scheme {
    /// Backward Euler.
    pub const BACKWARD_EULER: Scheme = Scheme::Theta { theta: 1.0 };
    /// Crank-Nicolson.
    pub const CRANK_NICOLSON: Scheme = Scheme::Theta { theta: 0.5 };

    /// The formula of a step, or a part of one, of length `k` \[s\].
    pub fn formula(&self, k: f64, past: &Past) -> Formula {
        let theta = match *self {
            Scheme::Theta { theta } => theta,
            Scheme::ShiftedCrankNicolson { shift } => (0.5 + shift * k).min(1.0),
            Scheme::Rannacher { .. } if past.damped => 1.0,
            Scheme::Rannacher { .. } => 0.5,
            Scheme::FractionalStepTheta => FRACTIONAL[past.part].theta,
            Scheme::Galerkin => return Formula { rule: StepRule::galerkin(k), ratio: None },
            Scheme::Bdf2 if past.ratio > 0.0 && past.ratio <= MAX_RATIO => {
                let w = past.ratio;
                let rule = StepRule::theta(k * (1.0 + w) / (1.0 + 2.0 * w), 1.0);
                return Formula { rule, ratio: Some(w) };
            }
            Scheme::Bdf2 => 0.5,
        };
        Formula { rule: StepRule::theta(k, theta), ratio: None }
    }

    /// The rule of most steps of length `k` \[s\]; for fractional-step θ that of the first part.
    pub fn rule(&self, k: f64) -> StepRule {
        let k = if *self == Scheme::FractionalStepTheta { GAMMA * k } else { k };
        self.formula(k, &Past { ratio: 1.0, damped: false, part: 0 }).rule
    }

    /// Order of v and u: 1 or 2.
    pub fn order(&self) -> u32 {
        if matches!(*self, Scheme::Theta { theta } if theta != 0.5) { 1 } else { 2 }
    }

    /// As `damping` is for a step that begins `elapsed` \[s\] after the start.
    pub fn damping(&self, damping: Damping, elapsed: f64) -> Damping {
        let Scheme::Rannacher { steps, interval } = *self else { return damping };
        let begun = (elapsed / interval + 1e-9).floor() as u64 + 1;
        if begun == damping.interval { damping } else { Damping { interval: begun, left: steps } }
    }
}

impl DomainMotion {
    /// The rule with the factors of ∂_t taken there; cG(1) has its own.
    pub fn apply(self, rule: StepRule) -> StepRule {
        match self {
            _ if rule.inertia.is_empty() => rule,
            DomainMotion::Secant => rule,
            DomainMotion::Midpoint => StepRule { inertia: MIDPOINT, ..rule },
            DomainMotion::Galerkin => StepRule { inertia: GALERKIN, ..rule },
        }
    }
}

/// `out` = ((1 + ω)² U⁻ − ω² U⁼) / (1 + 2ω), such that BDF2 reads ∂_t U ≈ (1 + 2ω)/((1 + ω) k) (U − `out`).
pub fn multistep(out: &mut State, older: &State, old: &State, w: f64) {
    let s = w * w / (1.0 + 2.0 * w);
    out.extrapolate(older, old, s);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Second order, (α, γ) as in the book, one matrix, and damping by −β/α at infinity.
    #[test]
    fn fractional_steps_are_those_of_the_book() {
        let [a, b, c] = FRACTIONAL;
        assert_eq!(a, c);
        assert!((a.length + b.length + c.length - 1.0).abs() < 1e-15);
        assert!((a.theta - (1.0 - 2.0 * GAMMA) / (1.0 - GAMMA)).abs() < 1e-15);
        assert!((a.theta * a.length - b.theta * b.length).abs() < 1e-15, "one matrix");
        let second: f64 = FRACTIONAL.iter().map(|p| p.length * p.length * (0.5 - p.theta)).sum();
        assert!(second.abs() < 1e-15);
        let damping: f64 = FRACTIONAL.iter().map(|p| -(1.0 - p.theta) / p.theta).product();
        assert!((damping.abs() - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-15);
    }

    /// Exact derivatives of parabolas at the new time.
    #[test]
    fn bdf2_differentiates_parabolas() {
        for w in [0.3, 1.0, 2.4] {
            let (k, t) = (0.2, 1.7);
            let at = |t: f64| State { v: vec![1.0, t, t * t], ..State::default() };
            let mut base = at(0.0);
            multistep(&mut base, &at(t - k - k / w), &at(t - k), w);
            let formula = Scheme::Bdf2.formula(k, &Past { ratio: w, damped: false, part: 0 });
            assert_eq!((formula.ratio, formula.rule.theta), (Some(w), 1.0));
            for (n, slope) in [0.0, 1.0, 2.0 * t].into_iter().enumerate() {
                assert!((formula.rule.per_k * (at(t).v[n] - base.v[n]) - slope).abs() < 1e-13);
            }
        }
        let jump = Scheme::Bdf2.formula(0.1, &Past { ratio: 2.5, damped: false, part: 0 });
        assert_eq!((jump.ratio, jump.rule.theta), (None, 0.5));
    }

    #[test]
    fn damping_steps_begin_at_every_interval() {
        let scheme = Scheme::Rannacher { steps: 2, interval: 1.0 };
        let (mut damping, mut damped) = (Damping::default(), vec![]);
        for step in 0..25 {
            damping = scheme.damping(damping, 0.1 * f64::from(step));
            if damping.left > 0 {
                damped.push(step);
                damping.left -= 1;
            }
        }
        assert_eq!(damped, [0, 1, 10, 11, 20, 21]);
    }
}
