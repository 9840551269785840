//! The square with a free bar in its middle (Richter 2017, section 5.3.5).

use super::blocks::{Blocks, Path, even};
use crate::mesh::{INTERFACE, Mesh};

/// Lines of the blocks \[m\] in both directions, and cells between them at level 0.
const X: [f64; 4] = [-1.0, -0.5, 0.5, 1.0];
const Y: [f64; 4] = [-1.0, -0.125, 0.125, 1.0];
const CELLS: [[usize; 3]; 2] = [[2, 4, 2], [4, 1, 4]];

/// Mesh of the rotor: `(−1, 1)²` with the solid `(−½, ½) × (−⅛, ⅛)` \[m\].
///
/// Regions `fluid`, `solid`; boundaries `inflow-top` (y = 1, x < −½), `inflow-bottom` (y = −1, x > ½), `outflow`
/// (y = 1, x > ½ and y = −1, x < −½), `walls`, `interface`. Level 0 has 72 cells of ¼ m and a little less in y.
/// Around each of the four corners of the solid are `grading` nested rings of cells, each halving the smallest
/// cell; they are laid before refinement.
pub fn rotor(refine: usize, grading: usize) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    for name in ["inflow-top", "inflow-bottom", "outflow", "walls", INTERFACE] {
        blocks.boundary(name);
    }
    let points = Y.map(|y| X.map(|x| blocks.point(x, y)));
    for j in 0..4 {
        for i in 0..3 {
            blocks.edge(points[j][i], points[j][i + 1], Path::Line, &even(CELLS[0][i]));
            blocks.edge(points[i][j], points[i + 1][j], Path::Line, &even(CELLS[1][i]));
        }
    }
    let sides = [(0, ["outflow", "walls", "inflow-bottom"]), (3, ["inflow-top", "walls", "outflow"])];
    for (j, names) in sides {
        for (i, name) in names.into_iter().enumerate() {
            blocks.name(points[j][i], points[j][i + 1], name);
            blocks.name(points[i][j], points[i + 1][j], "walls");
        }
    }
    for at in [1, 2] {
        blocks.name(points[at][1], points[at][2], INTERFACE);
        blocks.name(points[1][at], points[2][at], INTERFACE);
    }
    for j in 0..3 {
        for i in 0..3 {
            let corners = [points[j][i], points[j][i + 1], points[j + 1][i + 1], points[j + 1][i]];
            blocks.block(u16::from(i == 1 && j == 1), corners);
        }
    }
    let mut mesh = blocks.finish();
    for corner in [[X[1], Y[1]], [X[2], Y[1]], [X[1], Y[2]], [X[2], Y[2]]] {
        mesh = mesh.graded(corner, grading);
    }
    mesh.refined(refine, &[])
}
