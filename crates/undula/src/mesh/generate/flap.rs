//! The channel with an elastic flap (perpendicular flap of the preCICE tutorials).

use super::blocks::{Blocks, Path, even, growing};
use crate::mesh::{INTERFACE, Mesh};

/// Lines of the blocks \[m\].
const X: [f64; 4] = [-3.0, -0.05, 0.05, 3.0];
const Y: [f64; 3] = [0.0, 1.0, 4.0];
/// Growth of the cells away from the flap.
const RATIO: f64 = 1.25;

/// Mesh of `(−3, 3) × (0, 4)` \[m\] with the solid `(−0.05, 0.05) × (0, 1)`.
///
/// Regions `fluid`, `solid`; boundaries `inflow` (x = −3), `outflow` (x = 3), `walls` (top and bottom of the fluid),
/// `clamp` (foot of the flap), `interface`. Level 0 has 273 cells, one across the flap. Around both corners of its tip
/// are `grading` nested rings of cells, each halving the smallest cell; they are laid before refinement.
pub fn flap(refine: usize, grading: usize) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    for name in ["inflow", "outflow", "walls", "clamp", INTERFACE] {
        blocks.boundary(name);
    }
    let away = growing(10, RATIO);
    let towards: Vec<f64> = away.iter().rev().map(|x| 1.0 - x).collect();
    let columns = [towards, even(1), away];
    let rows = [even(7), growing(6, RATIO)];
    let points = Y.map(|y| X.map(|x| blocks.point(x, y)));
    for line in &points {
        for (i, breaks) in columns.iter().enumerate() {
            blocks.edge(line[i], line[i + 1], Path::Line, breaks);
        }
    }
    for (j, breaks) in rows.iter().enumerate() {
        for (&below, &above) in points[j].iter().zip(&points[j + 1]) {
            blocks.edge(below, above, Path::Line, breaks);
        }
        blocks.name(points[j][0], points[j + 1][0], "inflow");
        blocks.name(points[j][3], points[j + 1][3], "outflow");
    }
    for (i, foot) in ["walls", "clamp", "walls"].into_iter().enumerate() {
        blocks.name(points[0][i], points[0][i + 1], foot);
        blocks.name(points[2][i], points[2][i + 1], "walls");
    }
    for (a, b) in [([0, 1], [1, 1]), ([1, 1], [1, 2]), ([0, 2], [1, 2])] {
        blocks.name(points[a[0]][a[1]], points[b[0]][b[1]], INTERFACE);
    }
    for j in 0..2 {
        for i in 0..3 {
            let corners = [points[j][i], points[j][i + 1], points[j + 1][i + 1], points[j + 1][i]];
            blocks.block(u16::from((i, j) == (1, 0)), corners);
        }
    }
    let mut mesh = blocks.finish();
    for corner in [[X[1], Y[1]], [X[2], Y[1]]] {
        mesh = mesh.graded(corner, grading);
    }
    mesh.refined(refine, &[])
}
