//! Cook's membrane.

use super::blocks::{Blocks, Path, even};
use crate::mesh::Mesh;

/// Corners \[m\], counter-clockwise from the lower left.
const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [0.048, 0.044], [0.048, 0.06], [0.0, 0.044]];

/// Mesh of Cook's membrane: the panel with the corners (0, 0), (48, 44), (48, 60), (0, 44) mm.
///
/// Region `solid`; boundaries `clamp` (the left end), `load` (the right one), `free` (both others). Level 0 is one cell.
pub fn cook(refine: usize) -> Mesh<2> {
    let mut blocks = Blocks::new(&["solid"]);
    for name in ["clamp", "load", "free"] {
        blocks.boundary(name);
    }
    let points = CORNERS.map(|[x, y]| blocks.point(x, y));
    for (i, name) in ["free", "load", "free", "clamp"].into_iter().enumerate() {
        let j = (i + 1) % 4;
        blocks.edge(points[i], points[j], Path::Line, &even(1));
        blocks.name(points[i], points[j], name);
    }
    blocks.block(0, points);
    blocks.finish().refined(refine, &[])
}
