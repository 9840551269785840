//! The channel with a cylinder and an elastic beam behind it (Turek and Hron, 2006).

use super::blocks::{Blocks, Path, Point, even, growing, mixed, parts};
use super::channel::{Rows, Sector};
use super::{CENTRE, HEIGHT, RADIUS, cylinder};
use crate::mesh::{INTERFACE, Mesh};

/// Length of the channel \[m\].
const LENGTH: f64 = 2.5;
/// Right end of the beam \[m\].
const TIP: f64 = 0.6;
/// Half the thickness of the beam, and half the width of the square of four cells at a tip corner \[m\].
const HALF: f64 = 0.01;
/// Half the height of the ring of cells around the cylinder \[m\].
const RING: f64 = 0.11;

/// Mesh of the Turek-Hron benchmark: channel `2.5 × 0.41`, cylinder at `(0.2, 0.2)` of radius 0.05, beam
/// up to `x = 0.6` between `y = 0.19` and `0.21` \[m\].
///
/// Regions `fluid`, `solid`; boundaries `inflow`, `outflow`, `walls`, `cylinder` (fluid on the circle),
/// `clamp` (solid on the circle), `interface` (seen from the fluid). Level 0 has 244 cells, each further
/// level four times as many. Tip centre `(0.6, 0.2)` and stagnation point `(0.15, 0.2)` are vertices.
/// Around each of the two corners of the tip are `grading` nested rings of 8 cells, each halving the
/// smallest cell; they are laid before refinement.
pub fn turek_hron(refine: usize, grading: usize) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    // Names in the order of the stream.
    for name in ["inflow", "outflow", "walls", "cylinder", "clamp", INTERFACE] {
        blocks.boundary(name);
    }
    let right = ring(&mut blocks);
    behind_ring(&mut blocks, right);
    let mut mesh = blocks.finish();
    for corner in [[TIP, CENTRE[1] - HALF], [TIP, CENTRE[1] + HALF]] {
        mesh = mesh.graded(corner, grading);
    }
    mesh.refined(refine, &[cylinder()])
}

/// The ring of cells around the cylinder with the root of the beam, and the cells before, above and
/// below it; returns the points of the first column behind the ring, from wall to wall.
fn ring(blocks: &mut Blocks) -> Vec<Point> {
    let [x, y] = CENTRE;
    let root = (RADIUS * RADIUS - HALF * HALF).sqrt();
    let right_centre = [x - 0.08, y];
    let reach = f64::hypot(0.18, RING);
    let on_right = |dy: f64| [right_centre[0] + (reach * reach - dy * dy).sqrt(), y + dy];
    let mut outer = [-RING, -0.027, -HALF, HALF, 0.027, RING].map(on_right).to_vec();
    outer.extend([[x - 0.1, y + RING], [x - 0.1, y - RING]]);
    let outer: Vec<Point> = outer.into_iter().map(|[x, y]| blocks.point(x, y)).collect();
    let mut inner = [-54.0, -25.0].map(|angle| blocks.on_cylinder(angle)).to_vec();
    inner.extend([-HALF, HALF].map(|dy| blocks.point(x + root, y + dy)));
    inner.extend([25.0, 54.0, 130.0, -130.0].map(|angle| blocks.on_cylinder(angle)));

    let right = |n| Sector::fluid(n, Path::Arc(right_centre));
    let sectors = [
        Sector { outer: parts(&[0.046, 0.037]), ..right(2) },
        right(1),
        Sector { region: 1, boundary: "clamp", ..right(2) },
        right(1),
        Sector { outer: parts(&[0.037, 0.046]), ..right(2) },
        Sector::fluid(4, Path::Arc([x + 0.02, y - 0.15])),
        Sector::fluid(4, Path::Arc([x + 0.2, y])),
        Sector::fluid(4, Path::Arc([x + 0.02, y + 0.15])),
    ];
    blocks.ring(&inner, &outer, &growing(3, 1.8), &sectors);
    let walls = [0.0, HEIGHT].map(|height| blocks.point(x + 0.13, height));
    blocks.before_ring([outer[0], outer[5], outer[6], outer[7]], walls, [4, 4], (0.0, &even(1)));
    [&walls[..1], &outer[..6], &walls[1..]].concat()
}

/// Points behind the ring by column (in front of the tip, at it, behind it, end of the near wake,
/// outflow) and, from wall to wall, by row; a square of `2 HALF` is left round each tip corner.
fn points_behind_ring() -> [[[f64; 2]; 8]; 5] {
    let tip = [-0.115, -0.02, -HALF, HALF, 0.02, 0.118];
    let near = [-0.138, -0.064, -0.031, 0.031, 0.064, 0.144];
    let far = [-0.145, -0.074, -0.037, 0.037, 0.074, 0.151];
    let y = [tip, tip, tip, near, far];
    // At the walls, between them and the beam, and at the beam.
    let x = [[0.57, 0.577, 0.59], [0.612, 0.605, TIP], [0.66, 0.64, 0.61], [1.2; 3], [LENGTH; 3]];
    std::array::from_fn(|column| {
        std::array::from_fn(|row| match row {
            0 => [x[column][0], 0.0],
            7 => [x[column][0], HEIGHT],
            1 | 6 => [x[column][1], CENTRE[1] + y[column][row - 1]],
            _ => [x[column][2], CENTRE[1] + y[column][row - 1]],
        })
    })
}

/// The rows of cells from the ring to the outflow: along the beam, round its tip, and the wake.
fn behind_ring(blocks: &mut Blocks, first: Vec<Point>) {
    let mut columns = vec![first];
    for column in points_behind_ring() {
        columns.push(column.map(|[x, y]| blocks.point(x, y)).to_vec());
    }
    let along_beam = parts(&[0.055, 0.055, 0.055, 0.05, 0.035, 0.02]);
    let near_wake = parts(&[0.018, 0.036, 0.07, 0.11, 0.155, 0.195]);
    let along = |column: usize, row: usize| {
        // Towards the walls the columns are less drawn together.
        let share = [1.0, 0.65, 0.1, 0.0, 0.0, 0.1, 0.65, 1.0][row];
        match column {
            0 => mixed(&along_beam, &even(6), share),
            3 => mixed(&near_wake, &growing(6, 1.24), share),
            4 => parts(&[0.3, 0.42, 0.58]),
            _ => even(1),
        }
    };
    let across = |column: usize, row: usize| match row {
        1 if column < 4 => parts(&[0.055, 0.035]),
        5 if column < 4 => parts(&[0.035, 0.055]),
        1 | 3 | 5 => even(2),
        _ => even(1),
    };
    let region = |column: usize, row: usize| u16::from(column < 2 && row == 3);
    Rows { columns: &columns, along: &along, across: &across, region: &region }.add(blocks);
}
