//! What solids have at their points from the start.

use super::{FsiSpace, Region};
use crate::math::{Tensor, Vector};
use std::fmt;
use std::sync::Arc;

/// A direction at a position \[m\], a unit vector.
pub type FibreField<const D: usize> = Arc<dyn Fn(&[f64; D]) -> [f64; D] + Send + Sync>;

/// Directions of fibres, and the displacement that takes stress away.
#[derive(Clone, Default)]
pub struct Fabrics<const D: usize> {
    /// Direction of the fibres of each material of the solids; `None`, or no entry: that of its law.
    pub fibres: Vec<Option<FibreField<D>>>,
    /// U at the nodes \[m\], `[node][component]`: x + U(x) is the position without stress; empty: the reference domain is
    /// free of stress.
    pub unloading: Vec<f64>,
}

impl<const D: usize> fmt::Debug for Fabrics<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fibres = self.fibres.iter().map(Option::is_some).collect::<Vec<_>>();
        f.debug_struct("Fabrics").field("fibres", &fibres).field("unloading", &self.unloading.len()).finish()
    }
}

impl<const D: usize> FsiSpace<D> {
    /// Whether the solid `material` has something at its points.
    pub fn has_fabric(&self, material: u16) -> bool {
        let field = self.fabrics.fibres.get(usize::from(material));
        field.is_some_and(Option::is_some) || !self.fabrics.unloading.is_empty()
    }

    /// Direction of the fibres of the solid `material` at `x` \[m\]; 0: that of its law.
    pub fn fibre_at(&self, material: u16, x: &[f64; D]) -> [f64; D] {
        let field = self.fabrics.fibres.get(usize::from(material));
        field.and_then(Option::as_ref).map_or([0.0; D], |field| field(x))
    }

    /// The direction of the fibres, ∇U and U_r/r around an axis at the place `x` \[m\] of a cell, where the basis has the
    /// values `value` and the gradients `grad`; 0 in the fluid.
    pub fn fabric_at(
        &self,
        cell: usize,
        x: &[f64; D],
        (value, grad): (&[f64], &[[f64; D]]),
    ) -> (Vector<f64, D>, Tensor<f64, D>, f64) {
        let (mut unloading, mut outward) = (Tensor::zero(), 0.0);
        if self.regions[cell] == Region::Fluid || !self.has_fabric(self.material[cell]) {
            return (Vector::zero(), unloading, 0.0);
        }
        if !self.fabrics.unloading.is_empty() {
            for ((&node, value), grad) in self.nodes.cell(cell).iter().zip(value).zip(grad) {
                let u = &self.fabrics.unloading[node as usize * D..][..D];
                outward += value * u[0];
                for i in 0..D {
                    (0..D).for_each(|d| unloading.0[i][d] += grad[d] * u[i]);
                }
            }
        }
        let hoop = match self.coordinates.radius(x) {
            None => 0.0,
            Some(r) if r > 0.0 => outward / r,
            Some(_) => unloading.0[0][0],
        };
        (Vector(self.fibre_at(self.material[cell], x)), unloading, hoop)
    }
}
