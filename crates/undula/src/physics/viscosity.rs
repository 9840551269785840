//! Fluids whose viscosity depends on the rate of shear.

use crate::choice::{Choice, choice};
use crate::math::{Scalar, Tensor};

/// Viscosity law of the fluid.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum FluidLaw {
    /// μ is constant.
    Newtonian,
    /// μ = μ_∞ + (μ₀ − μ_∞)(1 + (λ γ̇)^a)^((n − 1)/a).
    CarreauYasuda,
}

/// Their names in a case.
pub static FLUID_LAWS: [Choice<FluidLaw>; 2] = [
    choice("newtonian", FluidLaw::Newtonian, "constant viscosity"),
    choice(
        "carreau-yasuda",
        FluidLaw::CarreauYasuda,
        "μ_∞ + (μ₀ − μ_∞)(1 + (λ γ̇)^a)^((n − 1)/a), shear-thinning",
    ),
];

/// The viscosity after Carreau and Yasuda (1979) as a part of that at rest, with the rate of shear γ̇ = √(2 D : D),
/// D = ½ (∇v + ∇vᵀ) in the current domain:
/// μ/μ₀ = r + (1 − r)(1 + (λ γ̇)^a)^((n − 1)/a).
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CarreauYasuda {
    /// r = μ_∞/μ₀, at most 1.
    pub ratio: f64,
    /// λ \[s\]; the viscosity changes at the rate 1/λ.
    pub time: f64,
    /// n, above 0: the stress grows with γ̇ⁿ where μ_∞ does not matter; below 1 the fluid is shear-thinning.
    pub index: f64,
    /// a, above 0: how sharp the transition is; 2 is the law of Carreau.
    pub transition: f64,
}

/// Added to (λ γ̇)², so that powers have a derivative at rest; far below the rounding of (λ γ̇)^a where that matters.
const AT_REST: f64 = 1e-40;

impl CarreauYasuda {
    /// (λ γ̇)² and (λ γ̇)^a at 2 D.
    #[inline(always)]
    fn powers<T: Scalar, const D: usize>(&self, twice: &Tensor<T, D>) -> (T, T) {
        let square = twice.ddot(*twice) * (0.5 * self.time * self.time) + T::constant(AT_REST);
        (square, square.powf(0.5 * self.transition))
    }

    /// μ/μ₀ at 2 D = ∇v + ∇vᵀ \[1/s\].
    #[inline(always)]
    pub fn factor<T: Scalar, const D: usize>(&self, twice: &Tensor<T, D>) -> T {
        let (_, power) = self.powers(twice);
        let decay = (T::one() + power).powf((self.index - 1.0) / self.transition);
        T::constant(self.ratio) + decay * (1.0 - self.ratio)
    }

    /// Derivative of [`CarreauYasuda::factor`] in the direction `change` of 2 D, by hand.
    #[inline(always)]
    pub fn derivative<T: Scalar, const D: usize>(&self, twice: &Tensor<T, D>, change: &Tensor<T, D>) -> T {
        let (square, power) = self.powers(twice);
        let decay = (T::one() + power).powf((self.index - 1.0) / self.transition - 1.0);
        let slope = decay * power / square * (0.5 * (1.0 - self.ratio) * (self.index - 1.0));
        slope * twice.ddot(*change) * (self.time * self.time)
    }
}
