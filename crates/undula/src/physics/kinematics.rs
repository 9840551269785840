//! Deformation gradient and what follows from it.

use crate::math::{Scalar, Tensor};

/// `F = I + ∇u`, `J = det F`, `F⁻¹` at a point.
#[derive(Copy, Clone, Debug)]
pub struct Kinematics<T, const D: usize> {
    /// Deformation gradient.
    pub F: Tensor<T, D>,
    /// Its inverse.
    pub F_inv: Tensor<T, D>,
    /// Its determinant.
    pub J: T,
}

impl<T: Scalar, const D: usize> Kinematics<T, D> {
    /// From ∇u. Their derivatives are Lemma 5.4.
    #[inline(always)]
    pub fn of(grad_u: &Tensor<T, D>) -> Self {
        let F = Tensor::identity() + *grad_u;
        let J = F.det();
        Kinematics { F, F_inv: F.cofactor().t() * (T::one() / J), J }
    }
}

/// `J F⁻ᵀ = cof F`: carries areas and, times the pressure, forces.
#[inline(always)]
pub fn cofactor<T: Scalar, const D: usize>(grad_u: &Tensor<T, D>) -> Tensor<T, D> {
    (Tensor::identity() + *grad_u).cofactor()
}

/// J − 1 at ∇u, in a form linear in ∇u with the rest kept in `lag`, and without cancellation at small ∇u:
/// S : ∇u with S = ∫₀¹ cof(I + τ ∇u_lag) dτ, for `D` = 1, 2, 3.
#[inline(always)]
pub fn volume_change<T: Scalar, const D: usize>(grad_u: &Tensor<T, D>, lag: &Tensor<T, D>) -> T {
    let mut S = Tensor::identity() + 0.5 * (Tensor::identity() * lag.trace() - lag.t());
    if D == 3 {
        S += 1.0 / 3.0 * lag.cofactor();
    }
    S.ddot(*grad_u)
}
