//! The channel with a cylinder (Schäfer and Turek, 1996).

use super::blocks::{Blocks, Path, Point, even, growing, mixed, parts};
use super::channel::{Rows, Sector};
use super::{BEFORE, CENTRE, HEIGHT, cylinder, cylinder_of_dfg_3d};
use crate::mesh::Mesh;

/// Length of the channel \[m\].
const LENGTH: f64 = 2.2;
/// Half the height of the ring of cells around the cylinder \[m\].
const RING: f64 = 0.11;

/// Mesh of the Schäfer-Turek benchmark: channel `2.2 × 0.41`, cylinder at `(0.2, 0.2)` of radius 0.05
/// \[m\].
///
/// Region `fluid`; boundaries `inflow`, `outflow`, `walls`, `cylinder`. Level 0 has 222 cells, 22 round
/// the cylinder in 6 layers that grow from 0.0035 at the circle; each further level has four times as many.
/// `(0.15, 0.2)` and `(0.25, 0.2)` are vertices.
pub fn schaefer_turek(refine: usize) -> Mesh<2> {
    channel((0.0, &even(1))).refined(refine, &[cylinder()])
}

/// Mesh of the section of the channel of the benchmark in space: `2.5 × 0.41`, cylinder at `(0.5, 0.2)` of radius 0.05
/// \[m\].
///
/// It is that of [`schaefer_turek`] with two more columns of cells before the cylinder, in all 234 cells at level 0.
/// `(0.45, 0.2)` and `(0.55, 0.2)` are vertices.
pub fn dfg_3d(refine: usize) -> Mesh<2> {
    let towards: Vec<f64> = growing(3, 1.35).iter().rev().map(|s| 1.0 - s).collect();
    let mut mesh = channel((-BEFORE, &towards));
    mesh.nodes.iter_mut().for_each(|[x, _]| *x += BEFORE);
    mesh.refined(refine, &[cylinder_of_dfg_3d()])
}

/// Both channels at level 0, with the inflow and the cells behind it as of [`Blocks::before_ring`].
fn channel(inflow: (f64, &[f64])) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid"]);
    for name in ["inflow", "outflow", "walls", "cylinder"] {
        blocks.boundary(name);
    }
    let first = ring(&mut blocks, inflow);
    behind_ring(&mut blocks, first);
    blocks.finish()
}

/// The ring of cells around the cylinder, and the cells before, above and below it; returns the points
/// of the first column behind the ring, from wall to wall.
fn ring(blocks: &mut Blocks, inflow: (f64, &[f64])) -> Vec<Point> {
    let [x, y] = CENTRE;
    let outer = [[0.1, -RING], [0.1, RING], [-0.1, RING], [-0.1, -RING]];
    let outer = outer.map(|[dx, dy]| blocks.point(x + dx, y + dy));
    let inner = [-52.0, 52.0, 130.0, -130.0].map(|angle| blocks.on_cylinder(angle));
    let right = Sector::fluid(6, Path::Arc([x - 0.08, y]));
    let sectors = [
        Sector { outer: parts(&[1.15, 1.0, 0.9, 0.9, 1.0, 1.15]), ..right },
        Sector::fluid(6, Path::Arc([x, y - 0.15])),
        Sector::fluid(4, Path::Arc([x + 0.2, y])),
        Sector::fluid(6, Path::Arc([x, y + 0.15])),
    ];
    blocks.ring(&inner, &outer, &growing(6, 1.4), &sectors);
    let walls = [0.0, HEIGHT].map(|height| blocks.point(x + 0.13, height));
    blocks.before_ring(outer, walls, [6, 4], inflow);
    vec![walls[0], outer[0], outer[1], walls[1]]
}

/// The rows of cells from the ring to the outflow.
fn behind_ring(blocks: &mut Blocks, first: Vec<Point>) {
    let mut columns = vec![first];
    for (x, y) in [(1.0, [0.06, 0.346]), (LENGTH, [0.06, 0.346])] {
        columns.push([0.0, y[0], y[1], HEIGHT].map(|y| blocks.point(x, y)).to_vec());
    }
    let along = |column: usize, row: usize| match (column, row) {
        (0, 0 | 3) => growing(6, 1.12),
        (0, _) => growing(6, 1.2),
        _ => growing(3, 1.3),
    };
    let across = |column: usize, row: usize| match (column, row) {
        (1, 1) => mixed(&even(6), &parts(&[1.15, 1.0, 0.9, 0.9, 1.0, 1.15]), 0.7),
        (_, 1) => even(6),
        _ => even(1),
    };
    Rows { columns: &columns, along: &along, across: &across, region: &|_, _| 0 }.add(blocks);
}
