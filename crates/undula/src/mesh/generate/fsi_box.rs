//! The elastic box in a channel of space (Richter, 2012).

use super::blocks::{Blocks, Path, Point, even, growing, parts};
use crate::mesh::{INTERFACE, Mesh, MeshError};

/// Lines of the blocks \[m\]: the body is in the second column, the first row and the first layer.
const X: [f64; 4] = [0.0, 0.4, 0.5, 1.5];
const Y: [f64; 3] = [0.0, 0.2, 0.4];
const Z: [f64; 3] = [0.0, 0.2, 0.4];

/// Mesh of the half z > 0 of the channel `(0, 1.5) × (0, 0.4) × (−0.4, 0.4)` \[m\] with the elastic box
/// `(0.4, 0.5) × (0, 0.2) × (−0.2, 0.2)` on its bottom.
///
/// Regions `fluid`, `solid`; boundaries `inflow` (x = 0), `outflow` (x = 1.5), `walls`, `symmetry` (z = 0), `clamp` (foot
/// of the box), `interface`. Level 0 has 462 cells, 24 in the box, which are smallest at its sides and at its foot; each
/// further level has eight times as many. The layers of cells there are halved `grading` times towards them before
/// refinement.
///
/// # Errors
/// [`MeshError::Parameter`] for more nodes than 32 bits can number.
pub fn fsi_box(refine: usize, grading: usize) -> Result<Mesh<3>, MeshError> {
    let graded = |breaks: Vec<f64>| halved(breaks, grading);
    let at_both = |breaks: Vec<f64>| reversed(graded(reversed(graded(breaks))));
    let [before, behind, away, inwards] =
        [growing(4, 1.5), growing(5, 1.5), growing(3, 1.3), growing(3, 1.3)].map(graded);
    let columns = [reversed(before), at_both(even(2)), behind];
    let rows = [at_both(parts(&[1.0, 1.5, 1.5, 1.0])), away];
    let layers = [reversed(inwards), rows[1].clone()];
    let mut mesh = section(&columns, &rows).along(&levels(&layers))?;
    let [within, beside] = layers.map(|breaks| breaks.len() - 1);
    for (cell, region) in mesh.cell_region.iter_mut().enumerate() {
        *region *= u16::from(cell % (within + beside) < within);
    }
    let number = |mesh: &mut Mesh<3>, name| mesh.boundary_number(name);
    let [walls, clamp, symmetry] = ["walls", "clamp", "symmetry"].map(|name| number(&mut mesh, name));
    let [front, back] = ["front", "back"].map(|name| number(&mut mesh, name));
    let Mesh { facets, cell_region, .. } = &mut mesh;
    for facet in facets {
        facet.boundary = match facet.boundary {
            b if b == front => symmetry,
            b if b == back => walls,
            b if b == clamp && cell_region[facet.cell as usize] == 0 => walls,
            b => b,
        };
    }
    mesh.boundaries.retain(|name| name != "front" && name != "back");
    mesh.mark_interface("fluid", "solid")?;
    Ok(mesh.refined(refine, &[]))
}

/// The breaks seen from the other end.
fn reversed(breaks: Vec<f64>) -> Vec<f64> {
    breaks.iter().rev().map(|s| 1.0 - s).collect()
}

/// The breaks with the first part halved `times` times towards 0.
fn halved(breaks: Vec<f64>, times: usize) -> Vec<f64> {
    let mut all = vec![0.0];
    all.extend((1..=times).rev().map(|i| breaks[1] * 0.5_f64.powi(i as i32)));
    all.extend(&breaks[1..]);
    all
}

/// z of the sides of the layers beside the body and beyond it \[m\].
fn levels(layers: &[Vec<f64>; 2]) -> Vec<f64> {
    let of = |i: usize| layers[i].iter().map(move |s| Z[i] + s * (Z[i + 1] - Z[i]));
    of(0).chain(of(1).skip(1)).collect()
}

/// The section z = 0, without its interface.
fn section(columns: &[Vec<f64>; 3], rows: &[Vec<f64>; 2]) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    for name in ["inflow", "outflow", "walls", "symmetry", "clamp", INTERFACE] {
        blocks.boundary(name);
    }
    let points = Y.map(|y| X.map(|x| blocks.point(x, y)));
    for line in &points {
        for (i, breaks) in columns.iter().enumerate() {
            blocks.edge(line[i], line[i + 1], Path::Line, breaks);
        }
    }
    for (j, breaks) in rows.iter().enumerate() {
        let sides: Vec<(Point, Point)> = points[j].into_iter().zip(points[j + 1]).collect();
        for &(below, above) in &sides {
            blocks.edge(below, above, Path::Line, breaks);
        }
        blocks.name(sides[0].0, sides[0].1, "inflow");
        blocks.name(sides[3].0, sides[3].1, "outflow");
    }
    for (i, foot) in ["walls", "clamp", "walls"].into_iter().enumerate() {
        blocks.name(points[0][i], points[0][i + 1], foot);
        blocks.name(points[2][i], points[2][i + 1], "walls");
    }
    for j in 0..2 {
        for i in 0..3 {
            let corners = [points[j][i], points[j][i + 1], points[j + 1][i + 1], points[j + 1][i]];
            blocks.block(u16::from((i, j) == (1, 0)), corners);
        }
    }
    blocks.finish()
}
