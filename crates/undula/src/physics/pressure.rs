//! A given pressure on a boundary.

use super::kinematics::cofactor;
use super::{FacetForm, Fields};
use crate::math::{Scalar, Vector};

/// ⟨p J F⁻ᵀ n, φ⟩ on the boundary in motion, so that J σ F⁻ᵀ n = −p J F⁻ᵀ n there; or ⟨p n, φ⟩, a dead load.
#[derive(Copy, Clone, Debug)]
pub struct Pressure {
    /// p \[Pa\].
    pub pressure: f64,
    /// Whether the load follows the boundary.
    pub follows: bool,
}

impl<const D: usize> FacetForm<D> for Pressure {
    #[inline(always)]
    fn traction<T: Scalar>(
        &self,
        _: &Fields<T, D>,
        lag: &Fields<T, D>,
        normal: &Vector<T::Value, D>,
        weight: f64,
    ) -> Vector<T, D> {
        let n = normal.map(T::lift);
        let n = if self.follows { cofactor(&lag.grad_u) * n } else { n };
        n * (T::one() * (self.pressure * weight))
    }
}
