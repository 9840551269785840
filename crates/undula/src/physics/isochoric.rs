//! The neo-Hookean law with change of shape and change of volume apart.

use super::kinematics::volume_change;
use super::law::{Law, in_space, write};
use crate::math::{Dual, Scalar, Tensor};

/// W = ½ μ (J^(−2/3) I₁ − 3) + ¼ κ (J² − 1 − 2 ln J), compressible.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct IsochoricNeoHookean {
    /// Shear modulus \[Pa\].
    pub mu: f64,
    /// Bulk modulus \[Pa\].
    pub bulk: f64,
}

impl IsochoricNeoHookean {
    /// P = μ J^(−2/3) (F − ⅓ I₁ F⁻ᵀ) + ½ κ (J² − 1) F⁻ᵀ at ∇u.
    fn piola(&self, grad_u: &Tensor<Dual<f64>, 3>) -> Tensor<Dual<f64>, 3> {
        let F = Tensor::identity() + *grad_u;
        let (J, change) = (F.det(), volume_change(grad_u, grad_u));
        let (shape, first) = ((J.ln() * (-2.0 / 3.0)).exp() * self.mu, F.ddot(F));
        let volume = change * (change + Dual::constant(2.0)) * (0.5 * self.bulk);
        F * shape + F.cofactor() * ((volume - shape * first * (1.0 / 3.0)) / J)
    }

    /// W at ∇u.
    fn energy(&self, grad_u: &Tensor<f64, 3>) -> f64 {
        let E = 0.5 * (*grad_u + grad_u.t() + grad_u.t() * *grad_u);
        let (change, first) = (volume_change(grad_u, grad_u), 2.0 * E.trace());
        let ln_J = change.ln_1p();
        let scale = (-2.0 / 3.0 * ln_J).exp_m1();
        let shape = first * (1.0 + scale) + 3.0 * scale;
        0.5 * self.mu * shape + 0.25 * self.bulk * (change * change + 2.0 * (change - ln_J))
    }
}

impl Law for IsochoricNeoHookean {
    fn energy_at(&self, _: &[f64], grad_u: &[[f64; 2]]) -> [f64; 2] {
        let at = in_space(grad_u);
        let P = self.piola(&at).map(|x| x.re);
        [self.energy(&at.map(|x| x.re)), P.ddot(at.map(|x| x.eps))]
    }

    fn stress_at(&self, _: &[f64], grad_u: &[[f64; 2]], stress: &mut [[f64; 2]]) {
        write(&self.piola(&in_space(grad_u)), stress);
    }
}
