//! Stress, volume and energy of a solid whose reference domain is loaded, see [`Reference`].

use super::kinematics::{Kinematics, cofactor, volume_change};
use super::{Fabric, Reference, Solid};
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
}
