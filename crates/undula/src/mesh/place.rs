//! Places in words.

use super::Mesh;
use crate::math::{rounded, shortest};

/// Digits of coordinates, relative to the size of the mesh.
const DIGITS: i32 = 6;

impl<const D: usize> Mesh<D> {
    /// The place `x` \[m\] with digits for the size of the mesh, as `(0.41234, 0.2) m`.
    pub fn shown(&self, x: &[f64; D]) -> String {
        let size = self.diameter();
        let coordinates: Vec<String> = x.iter().map(|x| shortest(rounded(*x, size, DIGITS))).collect();
        format!("({}) m", coordinates.join(", "))
    }
}
