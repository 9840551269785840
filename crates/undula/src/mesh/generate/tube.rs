//! The half of a section through an elastic tube (Formaggia et al. 2001; Gerbeau and Vidrascu 2003).

use super::blocks::{Blocks, Path, even};
use crate::mesh::{INTERFACE, Mesh};

/// Axis, inner and outer radius \[m\].
const R: [f64; 3] = [0.0, 0.005, 0.006];
/// Length \[m\].
const LENGTH: f64 = 0.05;

/// Mesh in (r, z) of the fluid `(0, 0.005) × (0, 0.05)` \[m\] and of the wall `(0.005, 0.006) × (0, 0.05)` around it.
///
/// Regions `fluid`, `solid`; boundaries `axis` (r = 0), `inflow` (z = 0), `outflow` (z = 0.05), `clamp` (both ends of the
/// wall), `outside` (r = 0.006), `interface`. Level 0 has 80 cells, one across the wall.
pub fn tube_2d(refine: usize) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    for name in ["axis", "inflow", "outflow", "clamp", "outside", INTERFACE] {
        blocks.boundary(name);
    }
    let points = R.map(|r| [0.0, LENGTH].map(|z| blocks.point(r, z)));
    for (line, name) in points.iter().zip(["axis", INTERFACE, "outside"]) {
        blocks.edge(line[0], line[1], Path::Line, &even(20));
        blocks.name(line[0], line[1], name);
    }
    for (body, (cells, names)) in
        [(3, ["inflow", "outflow"]), (1, ["clamp", "clamp"])].into_iter().enumerate()
    {
        let (inner, outer) = (points[body], points[body + 1]);
        for (end, name) in names.into_iter().enumerate() {
            blocks.edge(inner[end], outer[end], Path::Line, &even(cells));
            blocks.name(inner[end], outer[end], name);
        }
        blocks.block(body as u16, [inner[0], outer[0], outer[1], inner[1]]);
    }
    blocks.finish().refined(refine, &[])
}
