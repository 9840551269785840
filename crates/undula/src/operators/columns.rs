//! Derivatives of the traction of a term at a point of a facet.

use crate::math::Vector;
use crate::physics::Fields;
use crate::sampling::FacetPoint;

/// Derivatives of the traction in the directions of value and gradient of v and u: `[field][j]`,
/// `[field][j][d]`.
pub(super) struct Columns<const D: usize> {
    pub(super) value: [[Vector<f64, D>; D]; 2],
    pub(super) grad: [[[Vector<f64, D>; D]; D]; 2],
}

impl<const D: usize> Columns<D> {
    /// Add the derivative in every direction of `fields`; it is told whether the direction is that of the value of u.
    pub(super) fn add(
        &mut self,
        fields: &[usize],
        derivative: impl Fn(&Fields<f64, D>, bool) -> Vector<f64, D>,
    ) {
        let column = |n: usize, of_u: bool| {
            let mut w = Fields::zero();
            *w.component(n) = 1.0;
            derivative(&w, of_u)
        };
        for &field in fields {
            let first = field * (D + D * D);
            for j in 0..D {
                self.value[field][j] += column(first + j, field == 1);
                for d in 0..D {
                    self.grad[field][j][d] += column(first + D + j * D + d, false);
                }
            }
        }
    }

    /// d(traction) for basis function `b` in component `j` of field 0 (v) or 1 (u).
    pub(super) fn of(&self, p: &FacetPoint<D>, field: usize, b: usize, j: usize) -> Vector<f64, D> {
        let value = self.value[field][j] * p.value[b];
        (0..D).fold(value, |sum, d| sum + self.grad[field][j][d] * p.grad[b][d])
    }
}
