//! Incompressible Navier-Stokes equations in ALE coordinates, and the extension of the deformation.

use super::form::Block;
use super::kinematics::cofactor;
use super::{
    CarreauYasuda, Couplings, Dots, Extension, Fields, Inertia, Kinematics, Place, Tested, WeakForm,
};
use crate::math::{Scalar, Tensor};

/// Momentum (5.15), divergence (5.16) and extension (5.18) in the fluid region.
#[derive(Copy, Clone, Debug)]
pub struct Fluid {
    /// Density ρ_f \[kg/m³\].
    pub rho: f64,
    /// Kinematic viscosity ν_f \[m²/s\]; that at rest if it depends on the rate of shear.
    pub nu: f64,
    /// How it depends on the rate of shear; `None`: it is constant.
    pub thinning: Option<CarreauYasuda>,
    /// How the deformation is extended.
    pub extension: Extension,
}

impl Fluid {
    /// Viscous stress μ (∇v + ∇vᵀ) \[Pa\] of the current gradient ∇v, with the viscosity μ at that of `lag`.
    #[inline(always)]
    pub fn friction<T: Scalar, const D: usize>(
        &self,
        grad_v: Tensor<T, D>,
        lag: Tensor<T, D>,
    ) -> Tensor<T, D> {
        let sigma = self.rho * self.nu * (grad_v + grad_v.t());
        match self.thinning {
            None => sigma,
            Some(law) => sigma * law.factor(&(lag + lag.t())),
        }
    }

    /// Derivative of the viscous stress in the direction `change` of the current gradient ∇v, whose own part is
    /// `newtonian` = ρ ν (`change` + `change`ᵀ), by hand.
    #[inline(always)]
    pub fn friction_derivative<T: Scalar, const D: usize>(
        &self,
        grad_v: &Tensor<T, D>,
        newtonian: Tensor<T, D>,
    ) -> Tensor<T, D> {
        let Some(law) = self.thinning else { return newtonian };
        let twice = *grad_v + grad_v.t();
        let change = 1.0 / (self.rho * self.nu) * newtonian;
        newtonian * law.factor(&twice) + self.rho * self.nu * (twice * law.derivative(&twice, &change))
    }
}

impl<const D: usize> WeakForm<D> for Fluid {
    fn couplings(&self) -> Couplings {
        Couplings {
            phi_v: Block::Full,
            phi_u: Block::Full,
            pressure: Block::Stiffness,
            xi_v: Block::Stiffness,
            xi_p: false,
            psi_v: Block::Zero,
            psi_u: Block::Stiffness,
        }
    }

    /// ρ J and ρ G, G = J ∇v F⁻¹ = ∇v (cof F)ᵀ.
    #[inline(always)]
    fn inertia<T: Scalar>(&self, at: &Fields<T, D>, lag: &Fields<T, D>) -> Inertia<T, D> {
        let F = Tensor::identity() + lag.grad_u;
        Inertia { mass: F.det() * self.rho, motion: self.rho * (at.grad_v * F.cofactor().t()) }
    }

    /// (ρ J (∂_t v − ∇v F⁻¹ ∂_t u), φ).
    #[inline(always)]
    fn rate<T: Scalar>(&self, dots: &Dots<T, D>, inertia: &Inertia<T, D>, r: &mut Tested<T, D>) {
        r.phi += dots.v * inertia.mass - inertia.motion * dots.domain;
    }

    /// (ρ J (∇v F⁻¹ v − f), φ) + (J σ F⁻ᵀ, ∇φ) with σ = ρ ν (∇v F⁻¹ + F⁻ᵀ ∇vᵀ);
    /// a fixed-point iteration keeps ν.
    #[inline(always)]
    fn transport<T: Scalar>(
        &self,
        place: &Place<T::Value, D>,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        weight: f64,
        r: &mut Tested<T, D>,
    ) {
        let rho = self.rho;
        let Kinematics { F_inv, J, .. } = Kinematics::of(&lag.grad_u);
        let grad_v = at.grad_v * F_inv;
        let sigma = self.friction(grad_v, lag.grad_v * F_inv);
        let f = place.force_at(&lag.u);
        r.phi += weight * rho * (grad_v * lag.v - f) * J;
        r.grad_phi += weight * (sigma * F_inv.t()) * J;
    }

    /// −(p J F⁻ᵀ, ∇φ).
    #[inline(always)]
    fn pressure<T: Scalar>(&self, p: T, cofactor: &Tensor<T, D>, r: &mut Tested<T, D>) {
        r.grad_phi -= *cofactor * p;
    }

    /// The stiffness of the extension may depend on where the step begins.
    #[inline(always)]
    fn place<S: Scalar<Value = S>>(&self, place: &Place<S, D>, old: &Fields<S, D>) -> Place<S, D> {
        Place { stiffness: self.extension.stiffness(place.stiffness, &old.grad_u), ..*place }
    }

    /// (J F⁻¹ : ∇vᵀ, ξ) and the extension (σ_e(u), ∇ψ).
    #[inline(always)]
    fn constraint<T: Scalar>(
        &self,
        place: &Place<T::Value, D>,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        r: &mut Tested<T, D>,
    ) {
        r.xi += cofactor(&lag.grad_u).ddot(at.grad_v);
        r.grad_psi += self.extension.stress(&at.grad_u, T::lift(place.stiffness));
    }
}
