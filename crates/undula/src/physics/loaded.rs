//! Stress, volume and energy of a solid whose reference domain is loaded, see [`Reference`].

use super::kinematics::{Kinematics, cofactor, volume_change};
use super::{Fabric, Fields, Reference, Solid};
use crate::math::{Scalar, Tensor};

impl Solid {
    /// ∇U and ∇u, where `grad_u` is the gradient of the unknown.
    #[inline(always)]
    fn gradients<T: Scalar, const D: usize>(
        &self,
        fabric: &Fabric<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> [Tensor<T, D>; 2] {
        match self.reference {
            Reference::Free => [Tensor::zero(), *grad_u],
            Reference::Loaded => [fabric.unloading.map(T::lift), *grad_u],
            Reference::Sought => [*grad_u, Tensor::zero()],
        }
    }

    /// F g⁻¹ − I, from the domain without stress.
    #[inline(always)]
    pub(super) fn total<T: Scalar, const D: usize>(
        &self,
        fabric: &Fabric<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        if self.reference == Reference::Free {
            return *grad_u;
        }
        let [unloading, grad_u] = self.gradients(fabric, grad_u);
        let strain = grad_u - unloading;
        if self.is_linear() { strain } else { strain * Kinematics::of(&unloading).F_inv }
    }

    /// The same in the direction `grad_w` of u.
    #[inline(always)]
    pub(super) fn total_along<T: Scalar, const D: usize>(
        &self,
        fabric: &Fabric<T::Value, D>,
        grad_w: Tensor<T, D>,
    ) -> Tensor<T, D> {
        if self.reference == Reference::Free || self.is_linear() {
            return grad_w;
        }
        grad_w * Kinematics::of(&fabric.unloading.map(T::lift)).F_inv
    }

    /// `P` cof g: a stress per area without stress as one per area of the reference domain.
    #[inline(always)]
    pub(super) fn carried<T: Scalar, const D: usize>(
        &self,
        fabric: &Fabric<T::Value, D>,
        grad_u: &Tensor<T, D>,
        P: Tensor<T, D>,
    ) -> Tensor<T, D> {
        if self.reference == Reference::Free || self.is_linear() {
            return P;
        }
        P * cofactor(&self.gradients(fabric, grad_u)[0])
    }

    /// 1 − det g without cancellation: what the reference domain has gained in volume, and det g.
    #[inline(always)]
    pub(super) fn gain<T: Scalar, const D: usize>(
        &self,
        fabric: &Fabric<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> [T; 2] {
        if self.reference == Reference::Free {
            return [T::zero(), T::one()];
        }
        let [unloading, _] = self.gradients(fabric, grad_u);
        let change = volume_change(&unloading, &unloading);
        [-change, change + T::one()]
    }

    /// Stored energy per volume of the reference domain \[J/m³\]; of a law with J = 1 that of the deformation alone.
    pub fn energy<T: Scalar, const D: usize>(
        &self,
        fabric: &Fabric<T::Value, D>,
        grad_u: &Tensor<T, D>,
    ) -> T {
        let W = self.material.energy_at(&fabric.fibre, &self.total(fabric, grad_u));
        if self.reference == Reference::Free || self.is_linear() {
            return W;
        }
        W * self.gain(fabric, grad_u)[1]
    }

    /// The same of `fields`; where the law has a pressure with a bulk modulus, the energy of the volume is that of its
    /// pressure, p²/(2κ'): J itself is off by what the pressure cannot resolve.
    pub fn stored<const D: usize>(&self, fabric: &Fabric<f64, D>, fields: &Fields<f64, D>) -> f64 {
        let W = self.energy(fabric, &fields.grad_u);
        let Some(compliance) = self.material.compliance().filter(|c| *c > 0.0) else { return W };
        let total = self.total(fabric, &fields.grad_u);
        let change = volume_change(&total, &total);
        let excess = 0.5 * (compliance * fields.p * fields.p - change * change / compliance);
        W + excess * self.gain(fabric, &fields.grad_u)[1]
    }
}
