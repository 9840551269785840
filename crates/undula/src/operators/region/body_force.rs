//! The body force at the points of a region: given there, or taken at the current position x + u, so that it moves with
//! the iterate. The forms multiply it with the density: −(ρ J f, φ) in the fluid, −(ρ f, φ) in the solid.

use super::current_force::CurrentForce;
use crate::math::{Lanes, Tensor, Vector};
use crate::operators::{DataTime, End, ForceAt};
use std::array::from_fn;

/// Body force per mass at the quadrature points of a region.
pub(super) struct BodyForce<const D: usize, const L: usize> {
    /// The force, where it is taken at the current position.
    pub(super) current: Option<CurrentForce<D>>,
    /// f at the old and at the new time \[m/s²\]; empty: none.
    pub(super) values: [Vec<Vector<Lanes<L>, D>>; 2],
    /// ∇f where it is taken at the current position \[1/s²\]; else empty.
    pub(super) slopes: Vec<Tensor<Lanes<L>, D>>,
}

impl<const D: usize, const L: usize> BodyForce<D, L> {
    /// No force.
    pub(super) fn none() -> Self {
        BodyForce { current: None, values: [vec![], vec![]], slopes: vec![] }
    }

    /// f and ∇f at a point.
    #[inline(always)]
    pub(super) fn at(&self, end: End, point: usize) -> (Vector<Lanes<L>, D>, Tensor<Lanes<L>, D>) {
        let values = &self.values[end as usize];
        let value = if values.is_empty() { Vector::zero() } else { values[point] };
        (value, if self.slopes.is_empty() { Tensor::zero() } else { self.slopes[point] })
    }

    /// Take f(x + u, t) from now on.
    pub(super) fn follow(&mut self, force: CurrentForce<D>) {
        self.current = Some(force);
    }

    /// The time of one end for a force at the current position.
    pub(super) fn set(&mut self, at: &DataTime) {
        if let Some(force) = &mut self.current {
            force.set(at);
        }
    }

    /// Take the force of one end at the `positions` of the points; `None`: no force.
    pub(super) fn fill(
        &mut self,
        end: End,
        force: Option<ForceAt<'_, D>>,
        positions: &[Vector<Lanes<L>, D>],
    ) {
        let values = &mut self.values[end as usize];
        values.clear();
        let Some(force) = force else { return };
        for position in positions {
            let mut value = Vector::<Lanes<L>, D>::zero();
            for l in 0..L {
                let f = force(&from_fn(|d| position.0[d].0[l]));
                for d in 0..D {
                    value.0[d].0[l] = f[d];
                }
            }
            values.push(value);
        }
    }
}
