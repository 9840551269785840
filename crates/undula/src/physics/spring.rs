//! An elastic and viscous bed on a boundary of the solid.

use super::{FacetForm, Fields};
use crate::math::{Scalar, Vector};

/// ⟨k u + c v, φ⟩ on the reference boundary, or its normal part ⟨n·(k u + c v) n, φ⟩: springs and dashpots per area.
#[derive(Copy, Clone, Debug)]
pub struct Spring {
    /// k \[Pa/m\].
    pub stiffness: f64,
    /// c \[Pa s/m\].
    pub damping: f64,
    /// Whether only the normal part acts.
    pub normal: bool,
}

impl<const D: usize> FacetForm<D> for Spring {
    #[inline(always)]
    fn traction<T: Scalar>(
        &self,
        at: &Fields<T, D>,
        _: &Fields<T, D>,
        normal: &Vector<T::Value, D>,
        weight: f64,
    ) -> Vector<T, D> {
        let force = self.stiffness * at.u + self.damping * at.v;
        let n = normal.map(T::lift);
        weight * if self.normal { n * n.dot(force) } else { force }
    }
}
