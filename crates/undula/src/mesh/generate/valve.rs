//! A channel with two elastic leaflets, a valve in the plane.

use super::blocks::{Blocks, Path, even, growing};
use crate::mesh::{INTERFACE, Mesh};

/// Lines of the blocks along the channel \[m\], at the feet of the leaflets and at their tips.
const FEET: [f64; 4] = [-0.03, 0.0, 0.001, 0.07];
const TIPS: [f64; 4] = [-0.03, 0.004, 0.005, 0.07];
/// Heights: walls and tips \[m\].
const Y: [f64; 4] = [-0.01, -0.002, 0.002, 0.01];
/// Growth of the cells away from the leaflets.
const RATIO: f64 = 1.15;

/// Mesh of the channel `(−30, 70) × (−10, 10)` mm with two leaflets on its walls, 1 mm thick, that lean downstream from
/// feet at x = 0 to tips at x = 4 mm and leave a gap of 4 mm.
///
/// Regions `fluid`, `solid`; boundaries `inflow` (x = −30 mm), `outflow` (x = 70 mm), `walls` (top and bottom of the
/// fluid), `clamp` (feet of the leaflets), `interface`. Level 0 has 432 cells, one across a leaflet. Around the four
/// corners of the tips are `grading` nested rings of cells, each halving the smallest cell; they are laid before
/// refinement.
pub fn valve(refine: usize, grading: usize) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    for name in ["inflow", "outflow", "walls", "clamp", INTERFACE] {
        blocks.boundary(name);
    }
    let upstream: Vec<f64> = growing(11, RATIO).iter().rev().map(|x| 1.0 - x).collect();
    let columns = [upstream, even(1), growing(15, RATIO)];
    let rows = [6, 4, 6].map(even);
    let lines = [FEET, TIPS, TIPS, FEET];
    let points: [_; 4] = std::array::from_fn(|j| lines[j].map(|x| blocks.point(x, Y[j])));
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
        blocks.name(points[3][i], points[3][i + 1], foot);
    }
    for (a, b) in [(0, 1), (2, 3)] {
        blocks.name(points[a][1], points[b][1], INTERFACE);
        blocks.name(points[a][2], points[b][2], INTERFACE);
    }
    for line in &points[1..3] {
        blocks.name(line[1], line[2], INTERFACE);
    }
    for j in 0..3 {
        for i in 0..3 {
            let corners = [points[j][i], points[j][i + 1], points[j + 1][i + 1], points[j + 1][i]];
            blocks.block(u16::from(i == 1 && j != 1), corners);
        }
    }
    let mut mesh = blocks.finish();
    for (x, y) in [(1, 1), (2, 1), (1, 2), (2, 2)] {
        mesh = mesh.graded([TIPS[x], Y[y]], grading);
    }
    mesh.refined(refine, &[])
}
