//! The neo-Hookean law with change of shape and change of volume apart.

use super::stored_energy::{Deformation, StoredEnergy};
use crate::math::Scalar;

/// W = ½ μ (J^(−2/3) I₁ − 3) + ¼ κ (J² − 1 − 2 ln J), compressible.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct IsochoricNeoHookean {
    /// Shear modulus \[Pa\].
    pub mu: f64,
    /// Bulk modulus \[Pa\].
    pub bulk: f64,
}

impl StoredEnergy for IsochoricNeoHookean {
    fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
        let (ln_J, change) = (at.J().ln(), at.J_minus_1());
        let scale = (ln_J * (-2.0 / 3.0)).exp();
        let shape = at.I1_minus_3() * scale + (scale - T::one()) * 3.0;
        shape * (0.5 * self.mu) + (change * change + (change - ln_J) * 2.0) * (0.25 * self.bulk)
    }
}
