//! Schemes as tables.

use super::tableau::{ESDIRK3, ESDIRK4, Tableau};
use crate::choice::{Choice, choice};
use crate::physics::StepRule;
use crate::physics::rule::{GALERKIN, MIDPOINT};
use crate::space::State;

/// How steps are weighed, section 5.1.2.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Scheme {
    /// θ = 1.
    BackwardEuler,
    /// θ = ½.
    CrankNicolson,
    /// Implicit weight θ, from ½ to 1.
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
    /// Runge-Kutta method of four implicit stages: [`ESDIRK3`].
    Esdirk3,
    /// Runge-Kutta method of five implicit stages: [`ESDIRK4`].
    Esdirk4,
}

/// Their names in a case; `None`: a stationary solution is sought.
pub static SCHEMES: [Choice<Option<Scheme>>; 11] = [
    choice("backward-euler", Some(Scheme::BackwardEuler), "first order, damps all frequencies"),
    choice(
        "theta",
        Some(Scheme::Theta { theta: 1.0 }),
        "weight `theta` of the new time; second order for 0.5 only",
    ),
    choice("crank-nicolson", Some(Scheme::CrankNicolson), "second order, no damping"),
    choice(
        "shifted-crank-nicolson",
        Some(Scheme::ShiftedCrankNicolson { shift: 0.0 }),
        "second order, θ = ½ + shift · step: damping that vanishes with the step",
    ),
    choice(
        "rannacher",
        Some(Scheme::Rannacher { steps: 2, interval: 1.0 }),
        "second order, Crank-Nicolson with steps of backward Euler now and then",
    ),
    choice(
        "fractional-step-theta",
        Some(Scheme::FractionalStepTheta),
        "second order, three θ-steps in one, strongly A-stable",
    ),
    choice(
        "cg1",
        Some(Scheme::Galerkin),
        "second order, Galerkin method with linear trial functions; conserves energy",
    ),
    choice(
        "bdf2",
        Some(Scheme::Bdf2),
        "second order, backward differentiation over two steps; strong damping",
    ),
    choice(
        "esdirk3",
        Some(Scheme::Esdirk3),
        "third order, Runge-Kutta method of four implicit stages; strong damping of what the step does not resolve",
    ),
    choice(
        "esdirk4",
        Some(Scheme::Esdirk4),
        "fourth order, Runge-Kutta method of five implicit stages; strong damping of what the step does not resolve",
    ),
    choice("stationary", None, "no steps in time: a stationary solution"),
];

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

/// Their names in a case.
pub static DOMAIN_MOTIONS: [Choice<DomainMotion>; 3] = [
    choice("secant", DomainMotion::Secant, "(1 − θ) G(U⁻) + θ G(U)"),
    choice("midpoint", DomainMotion::Midpoint, "G((1 − θ) U⁻ + θ U)"),
    choice("galerkin", DomainMotion::Galerkin, "one third of `secant` and two thirds of `midpoint`"),
];

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
    /// What the differences are taken from.
    pub origin: Origin,
}

/// What the differences of a step are taken from.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Origin {
    /// The old solution.
    Old,
    /// BDF2: [`multistep`], with the ratio ω of this step to the one before.
    Multistep(f64),
    /// The old solution and stages before, of a [`Tableau`].
    Stages,
}

impl Scheme {
    /// The name in a case.
    pub fn name(self) -> &'static str {
        let same = |row: &&Choice<Option<Scheme>>| {
            row.value.is_some_and(|other| std::mem::discriminant(&other) == std::mem::discriminant(&self))
        };
        SCHEMES.iter().find(same).map_or("", |row| row.name)
    }

    /// Whether a step takes the forces of its beginning, too.
    pub fn takes_old_forces(self) -> bool {
        let implicit = matches!(self, Scheme::BackwardEuler | Scheme::Bdf2 | Scheme::Galerkin);
        !implicit && self.tableau().is_none()
    }

    /// Whether the scheme says itself where the factors of ∂_t are taken, see [`DomainMotion`].
    pub fn has_own_domain_motion(self) -> bool {
        matches!(self, Scheme::Galerkin | Scheme::Bdf2) || self.tableau().is_some()
    }

    /// The Runge-Kutta method, if it is one.
    pub fn tableau(self) -> Option<&'static Tableau> {
        match self {
            Scheme::Esdirk3 => Some(&ESDIRK3),
            Scheme::Esdirk4 => Some(&ESDIRK4),
            _ => None,
        }
    }

    /// The formula of a step, or a part of one, of length `k` \[s\].
    pub fn formula(&self, k: f64, past: &Past) -> Formula {
        let theta = match *self {
            Scheme::BackwardEuler => 1.0,
            Scheme::CrankNicolson => 0.5,
            Scheme::Theta { theta } => theta,
            Scheme::ShiftedCrankNicolson { shift } => (0.5 + shift * k).min(1.0),
            Scheme::Rannacher { .. } if past.damped => 1.0,
            Scheme::Rannacher { .. } => 0.5,
            Scheme::FractionalStepTheta => FRACTIONAL[past.part].theta,
            Scheme::Galerkin => return Formula { rule: StepRule::galerkin(k), origin: Origin::Old },
            Scheme::Bdf2 if past.ratio > 0.0 && past.ratio <= MAX_RATIO => {
                let w = past.ratio;
                let rule = StepRule::theta(k * (1.0 + w) / (1.0 + 2.0 * w), 1.0);
                return Formula { rule, origin: Origin::Multistep(w) };
            }
            Scheme::Bdf2 => 0.5,
            Scheme::Esdirk3 | Scheme::Esdirk4 => 1.0,
        };
        Formula { rule: StepRule::theta(k, theta), origin: Origin::Old }
    }

    /// The rule of most steps of length `k` \[s\]; for fractional-step θ that of the first part, for a Runge-Kutta method
    /// that of a stage.
    pub fn rule(&self, k: f64) -> StepRule {
        let k = if *self == Scheme::FractionalStepTheta { GAMMA * k } else { k };
        let k = self.tableau().map_or(k, |method| method.gamma * k);
        self.formula(k, &Past { ratio: 1.0, damped: false, part: 0 }).rule
    }

    /// Order of v and u.
    pub fn order(&self) -> u32 {
        match *self {
            Scheme::BackwardEuler => 1,
            Scheme::Theta { theta } if theta != 0.5 => 1,
            Scheme::Esdirk3 => 3,
            Scheme::Esdirk4 => 4,
            _ => 2,
        }
    }

    /// Coefficients of the solutions at the times t, t⁻, t⁼, t≡ in the local error of a step of length k from t⁻ to t.
    ///
    /// With second and third divided differences d₂, d₃ and k⁻ = t⁻ − t⁼, a θ-step has
    /// k² (½ − θ) y″ + k³ (⅙ − θ/2) y‴ with y″ = 2 d₂ + 2 (k⁻ − k) d₃ at t⁻ and y‴ = 6 d₃; cG(1) that of θ = ½;
    /// fractional-step θ −k³ y‴ Σ l³ (θ³ + (1 − θ)³)/3; BDF2 k² (k + k⁻) (1 + ω)/(1 + 2ω) d₃. Runge-Kutta methods have
    /// an embedded one: 0.
    pub fn local_error(&self, k: f64, t: [f64; 4]) -> [f64; 4] {
        let before = t[1] - t[2];
        let of_theta = |theta: f64| {
            let second = k * k * (1.0 - 2.0 * theta);
            (second, second * (before - k) + k.powi(3) * (1.0 - 3.0 * theta))
        };
        let (second, third) = match *self {
            Scheme::Galerkin | Scheme::Rannacher { .. } => of_theta(0.5),
            Scheme::BackwardEuler
            | Scheme::CrankNicolson
            | Scheme::Theta { .. }
            | Scheme::ShiftedCrankNicolson { .. } => of_theta(self.rule(k).theta),
            Scheme::FractionalStepTheta => {
                let part = |l: f64, theta: f64| l.powi(3) * (theta.powi(3) + (1.0 - theta).powi(3)) / 3.0;
                (0.0, -6.0 * k.powi(3) * FRACTIONAL.iter().map(|p| part(p.length, p.theta)).sum::<f64>())
            }
            Scheme::Bdf2 => {
                let w = k / before;
                (0.0, k * k * (k + before) * (1.0 + w) / (1.0 + 2.0 * w))
            }
            Scheme::Esdirk3 | Scheme::Esdirk4 => (0.0, 0.0),
        };
        // A divided difference is Σ yᵢ / Π (tᵢ − tⱼ).
        let divided = |n: usize, i: usize| {
            let others = (0..n).filter(|&j| j != i);
            if i < n { others.map(|j| t[i] - t[j]).product::<f64>().recip() } else { 0.0 }
        };
        std::array::from_fn(|i| second * divided(3, i) + third * divided(4, i))
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
            assert_eq!((formula.origin, formula.rule.theta), (Origin::Multistep(w), 1.0));
            for (n, slope) in [0.0, 1.0, 2.0 * t].into_iter().enumerate() {
                assert!((formula.rule.per_k * (at(t).v[n] - base.v[n]) - slope).abs() < 1e-13);
            }
        }
        let jump = Scheme::Bdf2.formula(0.1, &Past { ratio: 2.5, damped: false, part: 0 });
        assert_eq!((jump.origin, jump.rule.theta), (Origin::Old, 0.5));
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

    /// Exact for y = t³, whose local errors are known.
    #[test]
    fn estimates_are_leading_errors() {
        let (k, t) = (0.1, [1.0, 0.9, 0.75, 0.7]);
        let of = |scheme: Scheme| {
            let c = scheme.local_error(k, t);
            (0..4).map(|i| c[i] * t[i].powi(3)).sum::<f64>()
        };
        // One step of y' = f(t) = 3 t² from the exact value.
        let theta = |theta: f64| {
            t[0].powi(3) - t[1].powi(3) - k * 3.0 * (theta * t[0].powi(2) + (1.0 - theta) * t[1].powi(2))
        };
        for weight in [0.5, 0.6, 1.0] {
            let found = of(Scheme::Theta { theta: weight });
            assert!((found - theta(weight)).abs() < 1e-13, "{weight}: {found} {}", theta(weight));
        }
        assert!((of(Scheme::Galerkin) + k.powi(3) / 2.0).abs() < 1e-13);
        let w: f64 = k / 0.15;
        let base = ((1.0 + w).powi(2) * t[1].powi(3) - w * w * t[2].powi(3)) / (1.0 + 2.0 * w);
        let bdf2 = t[0].powi(3) - base - k * (1.0 + w) / (1.0 + 2.0 * w) * 3.0 * t[0].powi(2);
        assert!((of(Scheme::Bdf2).abs() - bdf2.abs()).abs() < 1e-13, "{} {bdf2}", of(Scheme::Bdf2));
        let fractional = of(Scheme::FractionalStepTheta) / of(Scheme::CrankNicolson);
        assert!((fractional - 0.132_035).abs() < 1e-5, "{fractional}");
    }
}
