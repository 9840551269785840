//! The ALE map: how the deformation of the solid is extended into the fluid, section 5.3.5.

use crate::math::{Scalar, Tensor};

/// Operator of the extension; stiffening E_e(x) is a number at the point.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Extension {
    /// (E_e ∇u, ∇ψ), (5.37); harmonic with E_e = 1.
    Harmonic,
    /// (μ_e (∇u + ∇uᵀ) + λ_e div u I, ∇ψ), μ_e = E_e / (2 (1 + ν_e)), λ_e = ν_e E_e / ((1 + ν_e)(1 − 2 ν_e)).
    PseudoElastic {
        /// Poisson ratio ν_e in (−1, ½); negative values are auxetic.
        poisson: f64,
    },
}

impl Extension {
    /// What stands before ∇ψ.
    #[inline(always)]
    pub fn stress<T: Scalar, const D: usize>(&self, grad_u: &Tensor<T, D>, stiffness: T) -> Tensor<T, D> {
        match *self {
            Extension::Harmonic => *grad_u * stiffness,
            Extension::PseudoElastic { poisson } => {
                let mu = 0.5 / (1.0 + poisson);
                let lambda = poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
                (mu * (*grad_u + grad_u.t()) + lambda * (Tensor::identity() * grad_u.trace())) * stiffness
            }
        }
    }
}
