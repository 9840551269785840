//! Elastodynamics in Lagrangian coordinates.

use super::form::Block;
use super::kinematics::{cofactor, volume_change};
use super::{
    Couplings, Damping, Dots, Fields, Inertia, Material, Place, Reference, StepRule, Tested, WeakForm,
};
use crate::math::{Scalar, Tensor};

/// Momentum and velocity-deformation relation (5.17) in the solid region, and J = 1 with a pressure of its own
/// if the law asks for it.
#[derive(Copy, Clone, Debug)]
pub struct Solid {
    /// Density ρ_s \[kg/m³\] of the reference configuration.
    pub rho: f64,
    /// Constitutive law.
    pub material: Material,
    /// Viscous damping.
    pub damping: Damping,
    /// What the reference domain is.
    pub reference: Reference,
}

impl Solid {
    /// The solid without damping.
    pub const fn elastic(rho: f64, material: Material) -> Solid {
        Solid { rho, material, damping: Damping::NONE, reference: Reference::Free }
    }

    /// Whether stresses are those of small strains.
    pub(super) fn is_linear(&self) -> bool {
        matches!(self.material, Material::Linear { .. })
    }
}

impl<const D: usize> WeakForm<D> for Solid {
    fn couplings(&self) -> Couplings {
        let gradients = |there| if there { Block::Stiffness } else { Block::Zero };
        Couplings {
            phi_v: if self.damping.has_stress() { Block::Full } else { Block::Mass },
            phi_u: Block::Stiffness,
            pressure: gradients(self.material.compliance().is_some()),
            xi_v: gradients(self.material.compliance() == Some(0.0)),
            xi_p: self.material.compliance().is_some_and(|c| c > 0.0),
            psi_v: Block::Mass,
            psi_u: Block::Mass,
        }
    }

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

    /// (P + P_v, ∇φ) + (ρ_s (α v − f), φ) − (v, ψ), P = F Σ, see [`Reference`]; P_v and α of the damping.
    #[inline(always)]
    fn transport<T: Scalar>(
        &self,
        place: &Place<T::Value, D>,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        weight: f64,
        r: &mut Tested<T, D>,
    ) {
        let fabric = &place.fabric;
        let (total, lagged) = (self.total(fabric, &at.grad_u), self.total(fabric, &lag.grad_u));
        let P = self.material.piola_at(&fabric.fibre, &total, &lagged);
        r.grad_phi += weight * self.carried(fabric, &at.grad_u, P);
        if self.damping.has_stress() {
            r.grad_phi += weight * self.damping.piola(self.is_linear(), &at.grad_v, &lag.grad_u);
        }
        if self.damping.mass != 0.0 {
            r.phi += weight * self.rho * self.damping.mass * at.v;
        }
        r.phi -= weight * self.rho * place.force.map(T::lift);
        r.psi -= weight * at.v;
    }

    /// −(p J F⁻ᵀ, ∇φ); where U is sought F is I.
    #[inline(always)]
    fn pressure<T: Scalar>(&self, p: T, cofactor: &Tensor<T, D>, r: &mut Tested<T, D>) {
        if self.material.compliance().is_some() {
            let sought = self.reference == Reference::Sought;
            r.grad_phi -= if sought { Tensor::identity() * p } else { *cofactor * p };
        }
    }

    #[inline(always)]
    fn constraint<T: Scalar>(
        &self,
        _: &Place<T::Value, D>,
        _: &Fields<T, D>,
        _: &Fields<T, D>,
        _: &mut Tested<T, D>,
    ) {
    }

    /// ((J − 1)/k + (1 − θ) J F⁻ᵀ : ∇v, ξ) at the new time, which has the unit of the divergence in the fluid;
    /// J − 1 alone if stationary. Both terms vanish.
    ///
    /// With J = 1 alone the velocity of the new time is bound only together with that of the old:
    /// J F⁻ᵀ : ∇v would take the factor −(1 − θ)/θ from step to step, and p be of first order with
    /// oscillations. The part of u that the next step takes from v is bound, too, so that the factor is 0; for the
    /// parts of fractional-step θ see [`StepRule::volume`].
    ///
    /// With a finite bulk modulus (J − 1 + p/κ', ξ)/(θ²k), J − 1 weighed by θ and 1 − θ because p belongs to
    /// t⁻ + θk; its derivative along v is J F⁻ᵀ : ∇v, too. Where the reference domain is loaded, p is that of the whole
    /// change of volume: J − det g + det g p/κ'.
    #[inline(always)]
    fn volume<T: Scalar>(
        &self,
        rule: &StepRule,
        place: &Place<T::Value, D>,
        new: &Fields<T, D>,
        lag: &Fields<T, D>,
        old: &Fields<T::Value, D>,
        r: &mut Tested<T, D>,
    ) {
        let Some(compliance) = self.material.compliance() else { return };
        let change = volume_change(&new.grad_u, &lag.grad_u);
        if compliance == 0.0 {
            let flux = cofactor(&lag.grad_u).ddot(new.grad_v);
            let (rate, share) = rule.volume();
            r.xi += change * rate + flux * share;
        } else {
            let before = T::lift(volume_change(&old.grad_u, &old.grad_u));
            let [gain, ratio] = self.gain(&place.fabric, &new.grad_u);
            let sought = self.reference == Reference::Sought;
            let mean = if sought { T::zero() } else { change * rule.theta + before * (1.0 - rule.theta) };
            r.xi += (mean + gain + new.p * compliance * ratio) * rule.compression();
        }
    }
}
