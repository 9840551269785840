//! Rectangles of equal cells.

use super::blocks::{Blocks, Path, even};
use crate::mesh::{Mesh, MeshError};

/// The rectangle from `lower` to `upper` \[m\] in `cells` equal cells, each halved `refine` times in both
/// directions: region `fluid`, boundaries `left`, `right`, `bottom`, `top`, geometry of degree 2.
///
/// # Errors
/// [`MeshError::Parameter`] unless `lower < upper` in both coordinates and there is a cell.
pub fn rectangle(
    lower: [f64; 2],
    upper: [f64; 2],
    cells: [usize; 2],
    refine: usize,
) -> Result<Mesh<2>, MeshError> {
    let reject = |reason| Err(MeshError::Parameter { generator: "rectangle", reason });
    for d in 0..2 {
        let extent = upper[d] - lower[d];
        if !(extent > 0.0 && extent.is_finite()) {
            return reject(format!("lower {lower:?} must be below upper {upper:?} in both coordinates"));
        }
        if cells[d] == 0 {
            return reject(format!("cells = {cells:?}: at least one in each direction is needed"));
        }
    }
    let mut blocks = Blocks::new(&["fluid"]);
    let corners = [
        blocks.point(lower[0], lower[1]),
        blocks.point(upper[0], lower[1]),
        blocks.point(upper[0], upper[1]),
        blocks.point(lower[0], upper[1]),
    ];
    let [a, b, c, d] = corners;
    for (from, to, n, name) in [
        (a, d, cells[1], "left"),
        (b, c, cells[1], "right"),
        (a, b, cells[0], "bottom"),
        (d, c, cells[0], "top"),
    ] {
        blocks.edge(from, to, Path::Line, &even(n));
        blocks.name(from, to, name);
    }
    blocks.block(0, corners);
    Ok(blocks.finish().refined(refine, &[]))
}
