//! Constitutive laws of the solid.

use crate::math::{Scalar, Tensor};

/// Second Piola-Kirchhoff stress Σ as a function of the deformation.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Material {
    /// Σ = 2 μ E + λ tr(E) I, E = ½ (FᵀF − I), (5.6).
    StVenantKirchhoff {
        /// Shear modulus \[Pa\].
        mu: f64,
        /// First Lamé parameter \[Pa\].
        lambda: f64,
    },
}

impl Material {
    /// Σ at ∇u, with the factor that a fixed-point iteration keeps in `lag`:
    /// E = ½ (∇u + ∇uᵀ + ∇u_lagᵀ ∇u).
    ///
    /// Erratum: section 5.2.1 prints ½ ∇u^(l−1) ∇u^(l)ᵀ, whose limit is ½ (F Fᵀ − I), another equation.
    #[inline(always)]
    pub fn stress<T: Scalar, const D: usize>(
        &self,
        grad_u: &Tensor<T, D>,
        lag: &Tensor<T, D>,
    ) -> Tensor<T, D> {
        match *self {
            Material::StVenantKirchhoff { mu, lambda } => {
                let E = 0.5 * (*grad_u + grad_u.t() + lag.t() * *grad_u);
                2.0 * mu * E + Tensor::identity() * (E.trace() * lambda)
            }
        }
    }

    /// Stored energy per reference volume \[J/m³\]: μ E:E + ½ λ tr(E)².
    pub fn energy<const D: usize>(&self, grad_u: &Tensor<f64, D>) -> f64 {
        match *self {
            Material::StVenantKirchhoff { mu, lambda } => {
                let E = 0.5 * (*grad_u + grad_u.t() + grad_u.t() * *grad_u);
                mu * E.ddot(E) + 0.5 * lambda * E.trace() * E.trace()
            }
        }
    }
}
