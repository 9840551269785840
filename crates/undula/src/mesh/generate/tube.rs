//! An elastic tube (Formaggia et al. 2001; Gerbeau and Vidrascu 2003): the half of a section through it, and all of it.

use super::blocks::{Blocks, Path, even};
use crate::mesh::{Curve, INTERFACE, Mesh, MeshError};

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

/// Distance of the corners of the core from the axis, by the inner radius.
const CORE: f64 = 0.6;
/// Angle between a side of the core and its chord at the corners: with it three angles of 120° meet there.
const BULGE: f64 = std::f64::consts::PI / 12.0;

/// Mesh of the fluid r < `radius`, 0 < z < `length` and of the wall of thickness `wall` around it, `size` being
/// `[length, radius, wall]` \[m\]: `cells[0]` cells along the axis, `cells[1]` round it and `cells[2]` through the wall,
/// each halved `refine` times in all directions.
///
/// The section of the lumen is an O-grid: a core of `(cells[1] / 4)²` cells, whose sides bulge, and half as many rings
/// around it. Regions `fluid`, `solid`; boundaries `inflow` (z = 0), `outflow` (z = `length`), `clamp` (both ends of the
/// wall), `outside` and `interface`; geometry of degree 2 with the nodes of both on their cylinders. If 8 divides
/// `cells[1]`, no cell is cut by the planes x = 0 and y = 0.
///
/// # Errors
/// [`MeshError::Parameter`] unless all sizes are above 0, 4 divides `cells[1]`, there is a cell in each direction, and 32
/// bits can number the nodes.
pub fn tube(size: [f64; 3], cells: [usize; 3], refine: usize) -> Result<Mesh<3>, MeshError> {
    tube_graded(size, cells, 0, refine)
}

/// The same with the ring of the lumen at the wall halved `grading` times towards the wall: so many rings more.
///
/// # Errors
/// Those of [`tube`].
pub fn tube_graded(
    size: [f64; 3],
    cells: [usize; 3],
    grading: usize,
    refine: usize,
) -> Result<Mesh<3>, MeshError> {
    let reject = |reason| Err(MeshError::Parameter { generator: "tube", reason });
    if !size.iter().all(|x| *x > 0.0 && x.is_finite()) || size[1] + size[2] <= size[1] {
        return reject(format!("length, inner radius and wall {size:?}: expected numbers above 0"));
    }
    let [along, round, through] = cells;
    if along == 0 || round == 0 || !round.is_multiple_of(4) || through == 0 {
        return reject(format!(
            "cells = {cells:?}: at least one along, a multiple of 4 round and at least one through the wall are needed"
        ));
    }
    // Eight nodes to a cell, and those of the sides.
    let n = (round / 4) as f64;
    let in_section = n * (n + 4.0 * (0.5 * n + 0.5) + 4.0 * (through + grading) as f64);
    let nodes = 9.0 * in_section * along as f64 * 8_f64.powi(refine.min(1000) as i32);
    if nodes > f64::from(u32::MAX) {
        return reject(format!(
            "cells = {cells:?}, refine = {refine}: the mesh would have more nodes than 32 bits can number"
        ));
    }
    let mut mesh = section(size[1], size[2], [round / 4, through, grading]).extruded(size[0], along)?;
    // The sides across the axis are called as those of the plane section.
    let [front, clamp] = ["front", "clamp"].map(|name| mesh.boundary_number(name));
    for f in mesh.facets.iter_mut().filter(|f| f.boundary >= front) {
        let is_fluid = mesh.cell_region[f.cell as usize] == 0;
        f.boundary = if is_fluid { f.boundary - front } else { clamp };
    }
    mesh.boundaries.truncate(front as usize);
    Ok(mesh.refined(refine, &cylinders(size)))
}

/// The two cylinders of a [`tube`] of this `size`.
pub fn cylinders(size: [f64; 3]) -> Vec<Curve<3>> {
    let cylinder = |name: &str, radius| Curve::Cylinder {
        boundaries: vec![name.into()],
        point: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        radius,
    };
    vec![cylinder(INTERFACE, size[1]), cylinder("outside", size[1] + size[2])]
}

/// Bends a [`tube`]: the section at z = s goes to the point of a curve that `axis` has for s, into the plane across it;
/// `axis` gives the point \[m\] and its derivative. Sections turn by the least angle from their plane, so that the curve
/// must not run against z. The nodes are those of the curve; sides between them follow it to degree 2.
pub fn bend(mesh: &mut Mesh<3>, mut axis: impl FnMut(f64) -> [[f64; 3]; 2]) {
    for node in &mut mesh.nodes {
        let [x, y, s] = *node;
        let [at, slope] = axis(s);
        let length = slope.iter().map(|t| t * t).sum::<f64>().sqrt();
        let [a, b, c] = slope.map(|t| t / length);
        // The rotation about e_z × t that takes e_z to t.
        let along = (a * x + b * y) / (1.0 + c);
        *node = [at[0] + x - a * along, at[1] + y - b * along, at[2] - a * x - b * y];
    }
}

/// Fractions of `n` rings, the last one halved `grading` times towards its end.
fn rings(n: usize, grading: usize) -> Vec<f64> {
    let mut breaks = even(n);
    let last = 1.0 / n as f64;
    let halves = (1..=grading).map(|i| 1.0 - last * 0.5_f64.powi(i as i32));
    breaks.splice(n..n, halves);
    breaks
}

/// The section of a [`tube`] with `n` cells in a quarter, and the names of its ends.
fn section(radius: f64, wall: f64, [n, through, grading]: [usize; 3]) -> Mesh<2> {
    let mut blocks = Blocks::new(&["fluid", "solid"]);
    for name in ["inflow", "outflow", "clamp", "outside", INTERFACE] {
        blocks.boundary(name);
    }
    let diagonals = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let points = [CORE * radius, radius, radius + wall].map(|r| {
        let r = r * std::f64::consts::FRAC_1_SQRT_2;
        diagonals.map(|[x, y]| blocks.point(r * x, r * y))
    });
    // The centre of the arc that is a side of the core lies beyond the axis.
    let beyond = CORE * radius * std::f64::consts::FRAC_1_SQRT_2 * (1.0 / BULGE.tan() - 1.0);
    for (i, [x, y]) in [[0.0, beyond], [-beyond, 0.0], [0.0, -beyond], [beyond, 0.0]].into_iter().enumerate()
    {
        let j = (i + 1) % 4;
        blocks.edge(points[0][i], points[0][j], Path::Arc([x, y]), &even(n));
        blocks.edge(points[1][i], points[1][j], Path::Arc([0.0; 2]), &even(n));
        blocks.edge(points[2][i], points[2][j], Path::Arc([0.0; 2]), &even(n));
        blocks.name(points[1][i], points[1][j], INTERFACE);
        blocks.name(points[2][i], points[2][j], "outside");
        blocks.edge(points[0][i], points[1][i], Path::Line, &rings(n.div_ceil(2), grading));
        blocks.edge(points[1][i], points[2][i], Path::Line, &even(through));
    }
    blocks.block(0, points[0]);
    for (body, pair) in points.windows(2).enumerate() {
        for i in 0..4 {
            let j = (i + 1) % 4;
            blocks.block(body as u16, [pair[0][j], pair[0][i], pair[1][i], pair[1][j]]);
        }
    }
    blocks.finish()
}
