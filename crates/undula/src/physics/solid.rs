//! Elastodynamics in Lagrangian coordinates.

use super::form::Block;
use super::{Couplings, Dots, Fields, Inertia, Material, Place, Tested, WeakForm};
use crate::math::{Scalar, Tensor};

/// Momentum and velocity-deformation relation (5.17) in the solid region.
#[derive(Copy, Clone, Debug)]
pub struct Solid {
    /// Density ρ_s \[kg/m³\] of the reference configuration.
    pub rho: f64,
    /// Constitutive law.
    pub material: Material,
}

impl<const D: usize> WeakForm<D> for Solid {
    const COUPLINGS: Couplings = Couplings {
        phi_v: Block::Mass,
        phi_u: Block::Stiffness,
        pressure: false,
        psi_v: Block::Mass,
        psi_u: Block::Mass,
    };

    /// ρ_s; the reference configuration does not move.
    #[inline(always)]
    fn inertia<T: Scalar>(&self, _: &Fields<T, D>, _: &Fields<T, D>) -> Inertia<T, D> {
        Inertia { mass: T::constant(self.rho), motion: Tensor::zero() }
    }

    /// (ρ_s ∂_t v, φ) + (∂_t u, ψ).
    #[inline(always)]
    fn rate<T: Scalar>(&self, dots: &Dots<T, D>, _: &Inertia<T, D>, r: &mut Tested<T, D>) {
        r.phi += self.rho * dots.v;
        r.psi += dots.u;
    }

    /// (F Σ, ∇φ) − (ρ_s f, φ) − (v, ψ).
    #[inline(always)]
    fn transport<T: Scalar>(
        &self,
        place: &Place<T::Value, D>,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        weight: f64,
        r: &mut Tested<T, D>,
    ) {
        let F = Tensor::identity() + lag.grad_u;
        let Sigma = self.material.stress(&at.grad_u, &lag.grad_u);
        r.grad_phi += weight * (F * Sigma);
        r.phi -= weight * self.rho * place.force.map(T::lift);
        r.psi -= weight * at.v;
    }

    #[inline(always)]
    fn pressure<T: Scalar>(&self, _: T, _: &Tensor<T, D>, _: &mut Tested<T, D>) {}

    #[inline(always)]
    fn constraint<T: Scalar>(
        &self,
        _: &Place<T::Value, D>,
        _: &Fields<T, D>,
        _: &Fields<T, D>,
        _: &mut Tested<T, D>,
    ) {
    }
}
