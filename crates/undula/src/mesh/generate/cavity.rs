//! The driven cavity with a flexible bottom (Wall 1999; Mok 2001; Valdés 2007).

use super::blocks::{Blocks, Path, even};
use crate::mesh::{INTERFACE, Mesh};

/// Thickness of the bottom \[m\].
const THICKNESS: f64 = 0.002;
/// Lower end of the openings \[m\].
const OPENING: f64 = 0.875;

/// Mesh of the unit square, the fluid, over a solid `(0, 1) × (−0.002, 0)` \[m\].
///
/// Regions `fluid`, `solid`; boundaries `lid` (y = 1), `inlet` and `outlet` (x = 0 and x = 1 above y = 0.875), `walls`
/// (the rest of the sides), `clamp` (both ends of the bottom), `below` (its lower side), `interface`. Level 0 has 72
/// cells, one across the bottom.
pub fn cavity(refine: usize) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    for name in ["lid", "inlet", "outlet", "walls", "clamp", "below", INTERFACE] {
        blocks.boundary(name);
    }
    let heights = [-THICKNESS, 0.0, OPENING, 1.0];
    let points = heights.map(|y| [0.0, 1.0].map(|x| blocks.point(x, y)));
    for (line, name) in points.iter().zip(["below", INTERFACE, "", "lid"]) {
        blocks.edge(line[0], line[1], Path::Line, &even(8));
        if !name.is_empty() {
            blocks.name(line[0], line[1], name);
        }
    }
    let sides = [(1, ["clamp", "clamp"]), (7, ["walls", "walls"]), (1, ["inlet", "outlet"])];
    for (j, (cells, names)) in sides.into_iter().enumerate() {
        for (i, name) in names.into_iter().enumerate() {
            blocks.edge(points[j][i], points[j + 1][i], Path::Line, &even(cells));
            blocks.name(points[j][i], points[j + 1][i], name);
        }
        let corners = [points[j][0], points[j][1], points[j + 1][1], points[j + 1][0]];
        blocks.block(u16::from(j == 0), corners);
    }
    blocks.finish().refined(refine, &[])
}
