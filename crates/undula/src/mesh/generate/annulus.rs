//! The ring between two concentric circles.

use super::blocks::{Blocks, Path, growing};
use crate::mesh::{Curve, Mesh, MeshError};

/// Mesh of `radii[0] < |x| < radii[1]` \[m\]: `cells[0]` cells round and `cells[1]` across, whose thickness grows
/// outwards like their width, each halved `refine` times in both directions.
///
/// Region `fluid`, boundaries `inner` and `outer`, geometry of degree 2 with the nodes of both on their circles. There
/// are vertices on the axes.
///
/// # Errors
/// [`MeshError::Parameter`] unless 0 < `radii[0]` < `radii[1]`, four divides `cells[0]`, and there is a cell.
pub fn annulus(radii: [f64; 2], cells: [usize; 2], refine: usize) -> Result<Mesh<2>, MeshError> {
    let reject = |reason| Err(MeshError::Parameter { generator: "annulus", reason });
    let [inner, outer] = radii;
    if !(inner > 0.0 && inner < outer && outer.is_finite()) {
        return reject(format!("radii {radii:?}: expected 0 < inner < outer"));
    }
    let [round, across] = cells;
    if round == 0 || !round.is_multiple_of(4) || across == 0 {
        return reject(format!(
            "cells = {cells:?}: a multiple of 4 round and at least one across are needed"
        ));
    }
    let mut blocks = Blocks::new(&["fluid"]);
    let directions = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    let points = radii.map(|r| directions.map(|[x, y]| blocks.point(r * x, r * y)));
    let radial = growing(across, (outer / inner).powf(1.0 / across as f64));
    for (&a, &b) in points[0].iter().zip(&points[1]) {
        blocks.edge(a, b, Path::Line, &radial);
    }
    let even = super::blocks::even(round / 4);
    for i in 0..4 {
        let j = (i + 1) % 4;
        for (circle, name) in points.iter().zip(["inner", "outer"]) {
            blocks.edge(circle[i], circle[j], Path::Arc([0.0, 0.0]), &even);
            blocks.name(circle[i], circle[j], name);
        }
        blocks.block(0, [points[0][j], points[0][i], points[1][i], points[1][j]]);
    }
    Ok(blocks.finish().refined(refine, &circles(radii)))
}

/// The two circles.
pub fn circles(radii: [f64; 2]) -> Vec<Curve<2>> {
    let circle =
        |name: &str, radius| Curve::Sphere { boundaries: vec![name.into()], centre: [0.0, 0.0], radius };
    vec![circle("inner", radii[0]), circle("outer", radii[1])]
}
