//! A body force as a function of the current position x + u.

use crate::operators::{DataTime, End};
use crate::tangent::Difference;
use std::array::from_fn;

/// Body force per mass \[m/s²\] and its gradient `[i][j]` = ∂f_i/∂x_j \[1/s²\] at a position \[m\] and a time
/// \[s\].
pub type ForceWithSlope<const D: usize> =
    Box<dyn Fn(&[f64; D], f64) -> ([f64; D], [[f64; D]; D]) + Send + Sync>;

/// f(x + u, t) of the fluid: the right-hand side is (ρ J f, φ), and (J ρ ∇f w, φ) belongs to its derivative.
pub struct CurrentForce<const D: usize> {
    field: ForceWithSlope<D>,
    /// Times of the old and the new end \[s\].
    times: [f64; 2],
    /// A part of the load.
    factor: f64,
}

impl<const D: usize> CurrentForce<D> {
    /// At time 0, in full.
    pub fn new(field: ForceWithSlope<D>) -> CurrentForce<D> {
        CurrentForce { field, times: [0.0; 2], factor: 1.0 }
    }

    /// The time of one end, and the part of the load that acts.
    pub(super) fn set(&mut self, at: &DataTime) {
        self.times[at.end as usize] = at.time;
        self.factor = at.load;
    }

    /// Value and gradient; the latter by differences where `by` says so.
    pub(super) fn at(&self, end: End, x: &[f64; D], by: Option<&Difference>) -> ([f64; D], [[f64; D]; D]) {
        let at = |x: &[f64; D]| (self.field)(x, self.times[end as usize]);
        let (value, mut slope) = at(x);
        if let Some(by) = by {
            slope = difference(|x| at(x).0, x, value, by);
        }
        (value.map(|f| self.factor * f), slope.map(|row| row.map(|f| self.factor * f)))
    }
}

/// ∇f by the differences that the rest of the Jacobian is made of.
fn difference<const D: usize>(
    f: impl Fn(&[f64; D]) -> [f64; D],
    x: &[f64; D],
    value: [f64; D],
    by: &Difference,
) -> [[f64; D]; D] {
    let h = by.epsilon * by.sizes.u;
    let columns: [[f64; D]; D] = from_fn(|j| {
        let moved = |h: f64| f(&from_fn(|d| if d == j { x[d] + h } else { x[d] }));
        let (from, to) = (if by.is_central() { moved(-h) } else { value }, moved(h));
        from_fn(|i| (to[i] - from[i]) / if by.is_central() { 2.0 * h } else { h })
    });
    from_fn(|i| from_fn(|j| columns[j][i]))
}
