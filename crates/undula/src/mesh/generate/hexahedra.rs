//! Cuboids of equal cells.

use super::rectangle;
use crate::mesh::{Mesh, MeshError};

/// The cuboid from `lower` to `upper` \[m\] in `cells` equal cells, each halved `refine` times in all directions: region
/// `fluid`, boundaries `left` and `right` (x), `bottom` and `top` (y), `front` and `back` (z), the lower side first,
/// geometry of degree 2.
///
/// # Errors
/// [`MeshError::Parameter`] unless `lower < upper` in all coordinates, there is a cell, and 32 bits can number the nodes.
pub fn hexahedra(
    lower: [f64; 3],
    upper: [f64; 3],
    cells: [usize; 3],
    refine: usize,
) -> Result<Mesh<3>, MeshError> {
    let reject = |reason| Err(MeshError::Parameter { generator: "hexahedra", reason });
    let below = |d: usize| upper[d] - lower[d] > 0.0 && (upper[d] - lower[d]).is_finite();
    if !(0..3).all(below) {
        return reject(format!("lower {lower:?} must be below upper {upper:?} in all coordinates"));
    }
    if cells.contains(&0) {
        return reject(format!("cells = {cells:?}: at least one in each direction is needed"));
    }
    let nodes = cells.iter().try_fold(1_usize, |n, cells| {
        let side = cells.checked_mul(2)?.checked_mul(1_usize.checked_shl(refine as u32)?)?;
        n.checked_mul(side.checked_add(1)?)
    });
    if nodes.is_none_or(|n| u32::try_from(n).is_err()) {
        return reject(format!(
            "cells = {cells:?}, refine = {refine}: the mesh would have more nodes than 32 bits can number"
        ));
    }
    let plane = rectangle([lower[0], lower[1]], [upper[0], upper[1]], [cells[0], cells[1]], 0)?;
    Ok(plane.between(lower[2], upper[2], cells[2])?.refined(refine, &[]))
}
