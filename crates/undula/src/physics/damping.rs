//! Viscous damping of a solid: Kelvin-Voigt and Rayleigh.

use super::kinematics::Kinematics;
use crate::math::{Scalar, Tensor};

/// A force −α ρ v per volume and a viscous stress of the rate of strain, S_v = 2 η_s Ė + η_v tr(Ė) I with
/// Ė = ½ (∇vᵀF + Fᵀ∇v) and P_v = F S_v: no rigid motion has a stress. Of Hooke's law P_v = 2 η_s ε̇ + η_v tr(ε̇) I.
///
/// A Kelvin-Voigt solid of viscosity η has 2 η_s = η, so that S_v = η Ė is the derivative of the potential ½ η Ė : Ė.
/// Rayleigh damping β has η_s = β μ and η_v = β λ with the moduli at rest: the stress is β times the rate of that of the
/// law, exactly for St. Venant-Kirchhoff and Hooke, at small strains for the others.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Damping {
    /// α \[1/s\].
    pub mass: f64,
    /// 2 η_s \[Pa s\], the factor of Ė.
    pub shear: f64,
    /// η_v \[Pa s\], the factor of tr(Ė) I.
    pub volume: f64,
}

impl Damping {
    /// None.
    pub const NONE: Damping = Damping { mass: 0.0, shear: 0.0, volume: 0.0 };

    /// Whether there is a viscous stress.
    pub fn has_stress(&self) -> bool {
        self.shear != 0.0 || self.volume != 0.0
    }

    /// 2 η_s A + η_v tr(A) I.
    #[inline(always)]
    fn of_rate<T: Scalar, const D: usize>(&self, rate: Tensor<T, D>) -> Tensor<T, D> {
        self.shear * rate + Tensor::identity() * (rate.trace() * self.volume)
    }

    /// P_v \[Pa\] of ∇v on the deformation `grad_u`; `small`: of small strains, as Hooke's law.
    #[inline(always)]
    pub fn piola<T: Scalar, const D: usize>(
        &self,
        small: bool,
        grad_v: &Tensor<T, D>,
        grad_u: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        if small {
            return self.of_rate(0.5 * (*grad_v + grad_v.t()));
        }
        let Kinematics { F, .. } = Kinematics::of(grad_u);
        F * self.of_rate(0.5 * (grad_v.t() * F + F.t() * *grad_v))
    }

    /// Derivative of [`Damping::piola`] in the directions ∇z of v and ∇w of u, by hand.
    #[inline(always)]
    pub fn derivative<T: Scalar, const D: usize>(
        &self,
        small: bool,
        (grad_v, grad_u): (&Tensor<T, D>, &Tensor<T, D>),
        (grad_z, grad_w): (&Tensor<T, D>, &Tensor<T, D>),
    ) -> Tensor<T, D> {
        if small {
            return self.piola(small, grad_z, grad_u);
        }
        let Kinematics { F, .. } = Kinematics::of(grad_u);
        let rate = 0.5 * (grad_v.t() * F + F.t() * *grad_v);
        let half = F.t() * *grad_z + grad_w.t() * *grad_v;
        *grad_w * self.of_rate(rate) + F * self.of_rate(0.5 * (half + half.t()))
    }
}
