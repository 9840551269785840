//! In which direction a wall grows at each node of its surface.

use super::rim::{Rim, cross, dot, norm, unit};
use super::surface::{Surface, SurfaceFacet, pairs};
use super::{place, refuse};
use crate::element::{Shape, lagrange};
use crate::mesh::geometry::distance;
use crate::mesh::{Mesh, MeshError};
use std::f64::consts::PI;

/// The mean of the normals at a node is at least so long: at a tip of 157 degrees it is.
const TIP: f64 = 0.2;
/// Sine of the least angle between an opening and the surface.
const FLAT: f64 = 0.2;
/// Nodes lean with the rim up to this many times the way by which it leans.
const REACH: f64 = 3.0;

/// A direction for each node of a surface; the wall reaches to X + h d.
pub(super) struct Directions(pub Vec<[f64; 3]>);

impl Directions {
    /// As [`Mesh::with_wall`] says, for a wall of `thickness` \[m\] at the nodes.
    pub fn new(mesh: &Mesh<3>, surface: &Surface, rim: &Rim, thickness: &[f64]) -> Result<Self, MeshError> {
        let mut directions = Vec::with_capacity(thickness.len());
        let means = means(mesh, surface);
        // Nodes of the rim, by how much they lean, and how far that is felt.
        let mut leaning: Vec<([f64; 3], [f64; 3], f64)> = vec![];
        for (i, mean) in means.iter().enumerate() {
            let x = mesh.nodes[surface.nodes[i] as usize];
            let length = norm(*mean);
            if length < TIP {
                return refuse(
                    "surface",
                    format!("it has a tip at {}, where a wall has no direction", place(mesh, x)),
                );
            }
            let normal = unit(*mean);
            let straight = normal.map(|n| n / length);
            let Some((planes, name)) = rim.planes.get(&surface.nodes[i]) else {
                directions.push(straight);
                continue;
            };
            let within = within(normal, planes);
            let square = dot(within, within);
            if square < FLAT * FLAT {
                let name = &mesh.boundaries[*name as usize];
                let reason = format!(
                    "the opening `{name}` is nearly tangential to the surface at {}: a wall cannot end in its plane there",
                    place(mesh, x)
                );
                return refuse("surface", reason);
            }
            let direction = within.map(|d| d / (square * length));
            let lean: [f64; 3] = std::array::from_fn(|d| direction[d] - straight[d]);
            let reach = REACH * thickness[i] * norm(lean);
            if reach > 1e-9 * thickness[i] {
                leaning.push((x, lean, reach));
            }
            directions.push(direction);
        }
        for (i, direction) in directions.iter_mut().enumerate() {
            if !rim.planes.contains_key(&surface.nodes[i]) {
                lean(direction, mesh.nodes[surface.nodes[i] as usize], unit(means[i]), &leaning);
            }
        }
        Ok(Directions(directions))
    }
}

/// Lets the node at `x` lean with the nearest node of the rim, along the surface.
fn lean(direction: &mut [f64; 3], x: [f64; 3], normal: [f64; 3], rim: &[([f64; 3], [f64; 3], f64)]) {
    let near = rim.iter().map(|(at, lean, reach)| (distance(*at, x), lean, reach));
    let Some((away, lean, reach)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    if away < *reach {
        let s = 1.0 - away / reach;
        let part = s * s * (3.0 - 2.0 * s);
        let across = dot(*lean, normal);
        (0..3).for_each(|d| direction[d] += part * (lean[d] - across * normal[d]));
    }
}

/// The part of `normal` that lies in all of the planes with these normals.
fn within(normal: [f64; 3], planes: &[[f64; 3]]) -> [f64; 3] {
    let along = |n: [f64; 3], e: [f64; 3]| {
        let part = dot(n, e);
        std::array::from_fn(|d| n[d] - part * e[d])
    };
    match planes {
        [] => normal,
        // Twice: what is left of the first time is rounding.
        [one] => along(along(normal, *one), *one),
        [one, two] => {
            let line = unit(cross(*one, *two));
            let part = dot(normal, line);
            line.map(|e| part * e)
        }
        _ => [0.0; 3],
    }
}

/// Σ w n / Σ w over the facets at each node: n is the outer unit normal of a facet there and w its angle.
fn means(mesh: &Mesh<3>, surface: &Surface) -> Vec<[f64; 3]> {
    let (mut sums, mut weights) = (vec![[0.0; 3]; surface.nodes.len()], vec![0.0; surface.nodes.len()]);
    for facet in &surface.facets {
        let in_cell = mesh.shape.facet_nodes(mesh.degree, facet.side.local as usize);
        for (place, (&node, local)) in facet.nodes.iter().zip(in_cell).enumerate() {
            let normal = outer_normal(mesh, facet, local);
            let weight = angle(mesh, surface.shape, facet, place);
            (0..3).for_each(|d| sums[node as usize][d] += weight * normal[d]);
            weights[node as usize] += weight;
        }
    }
    sums.into_iter().zip(weights).map(|(sum, weight)| sum.map(|s| s / weight)).collect()
}

/// Reference coordinates of node `local` of a cell.
fn reference(mesh: &Mesh<3>, local: usize) -> [f64; 3] {
    let at = lagrange::node(mesh.shape, mesh.degree, local);
    std::array::from_fn(|d| at[d])
}

/// The outer unit normal of a facet at node `local` of its cell: cof(DX) N.
fn outer_normal(mesh: &Mesh<3>, facet: &SurfaceFacet, local: usize) -> [f64; 3] {
    let g = mesh.map_gradient(facet.side.cell as usize, reference(mesh, local));
    let column = |j: usize| [g[0][j], g[1][j], g[2][j]];
    let cofactors = [[1, 2], [2, 0], [0, 1]].map(|[a, b]| cross(column(a), column(b)));
    let n = mesh.shape.facet_normal(facet.side.local as usize);
    unit(std::array::from_fn(|d| (0..3).map(|j| n[j] * cofactors[j][d]).sum()))
}

/// The angle of a facet at its node number `place`: between its edges at a vertex, π on an edge, 2π inside.
fn angle(mesh: &Mesh<3>, shape: Shape, facet: &SurfaceFacet, place: usize) -> f64 {
    let weights = shape.vertex_weights(mesh.degree, place);
    let own = match weights.iter().filter(|w| **w > 0).count() {
        1 => weights.iter().position(|w| *w > 0).unwrap_or(0),
        2 => return PI,
        _ => return 2.0 * PI,
    };
    let in_cell = mesh.shape.facet_nodes(mesh.degree, facet.side.local as usize);
    let vertices = shape.vertices(mesh.degree);
    let at = |vertex: usize| reference(mesh, in_cell[vertices[vertex]]);
    let g = mesh.map_gradient(facet.side.cell as usize, at(own));
    let along = |other: usize| -> [f64; 3] {
        let (from, to) = (at(own), at(other));
        std::array::from_fn(|i| (0..3).map(|j| g[i][j] * (to[j] - from[j])).sum())
    };
    let others = pairs(shape).iter().filter(|pair| pair.contains(&own));
    let tangents: Vec<[f64; 3]> = others.map(|[a, b]| along(if *a == own { *b } else { *a })).collect();
    norm(cross(tangents[0], tangents[1])).atan2(dot(tangents[0], tangents[1]))
}
