//! The surface that a wall grows from.

use super::{Wall, place, refuse};
use crate::element::Shape;
use crate::math::rounded;
use crate::mesh::geometry::bounds;
use crate::mesh::{Facet, Mesh, MeshError, Side};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A wall is at least so thick in parts of the longest side of the mesh: places of points are known to about 1e-10 of it.
const THINNEST: f64 = 1e-8;

/// An edge by its two vertices, the lower number first.
pub(super) type Edge = [u32; 2];

/// The facets of a surface, with its nodes numbered from 0.
pub(super) struct Surface {
    /// Shape of the facets.
    pub shape: Shape,
    pub facets: Vec<SurfaceFacet>,
    /// Number in the mesh of each node, rising.
    pub nodes: Vec<u32>,
}

/// One of its facets.
pub(super) struct SurfaceFacet {
    pub side: Side,
    /// Its nodes in lexicographic order, by their numbers in the surface.
    pub nodes: Vec<u32>,
}

impl Surface {
    /// The facets of the boundaries `names`.
    pub fn new(mesh: &Mesh<3>, names: &[String]) -> Result<Self, MeshError> {
        names.iter().try_for_each(|name| mesh.require_boundary(name).map(drop))?;
        let named = mesh.facets_on(names);
        let outer: HashSet<Side> = mesh.facets_of_cells().outer.into_iter().collect();
        if let Some(inner) = named.iter().find(|f| !outer.contains(&f.side())) {
            let at = place(mesh, mesh.centre(inner.cell as usize));
            let reason =
                format!("expected an outer boundary: there are cells on both sides of it, as beside {at}");
            return refuse("surface", reason);
        }
        let in_mesh = |f: &Facet| mesh.facet_nodes(f.cell as usize, f.local as usize);
        let mut number: BTreeMap<u32, u32> = named.iter().flat_map(in_mesh).map(|n| (n, 0)).collect();
        number.values_mut().zip(0..).for_each(|(entry, i)| *entry = i);
        let facet = |f: &Facet| SurfaceFacet {
            side: f.side(),
            nodes: in_mesh(f).into_iter().map(|node| number[&node]).collect(),
        };
        let shape = if mesh.shape == Shape::Tetrahedron { Shape::Triangle } else { Shape::Quadrilateral };
        let surface = Surface {
            shape,
            facets: named.iter().map(facet).collect(),
            nodes: number.keys().copied().collect(),
        };
        surface.check_edges(mesh)?;
        Ok(surface)
    }

    /// Refuses edges at which more than two facets meet.
    fn check_edges(&self, mesh: &Mesh<3>) -> Result<(), MeshError> {
        let mut count: HashMap<Edge, usize> = HashMap::new();
        let all = self.facets.iter().flat_map(|f| edges(mesh, f.side));
        all.for_each(|(edge, _)| *count.entry(edge).or_default() += 1);
        match count.into_iter().filter(|(_, n)| *n > 2).map(|(edge, _)| edge).min() {
            Some(edge) => {
                let at = place(mesh, mesh.nodes[edge[0] as usize]);
                refuse("surface", format!("more than two of its facets meet at the edge at {at}"))
            }
            None => Ok(()),
        }
    }

    /// The thickness above each node.
    pub fn thickness(&self, mesh: &Mesh<3>, wall: &Wall<'_>) -> Result<Vec<f64>, MeshError> {
        let at = |node: u32| mesh.nodes[node as usize];
        let thickness: Vec<f64> = self.nodes.iter().map(|&node| (wall.thickness)(at(node))).collect();
        let told = |i: usize, expected: &str| {
            let (h, at) = (rounded(thickness[i], thickness[i], 6), place(mesh, at(self.nodes[i])));
            refuse("thickness", format!("it is {h} at {at}: expected {expected}"))
        };
        if let Some(i) = thickness.iter().position(|h| !(*h > 0.0 && h.is_finite())) {
            return told(i, "a number above 0 everywhere");
        }
        let (low, high) = bounds(mesh.nodes.iter().copied());
        let size = low.iter().zip(high).fold(0.0, |size: f64, (low, high)| size.max(high - low));
        if let Some(i) = thickness.iter().position(|h| *h < THINNEST * size) {
            let size = rounded(size, size, 3);
            return told(i, &format!("a thickness [m] that is not lost beside the {size} m of the mesh"));
        }
        Ok(thickness)
    }
}

/// Pairs of vertices of a facet, by their places among its vertices.
pub(super) fn pairs(shape: Shape) -> &'static [[usize; 2]] {
    match shape {
        Shape::Triangle => &[[0, 1], [0, 2], [1, 2]],
        _ => &[[0, 1], [0, 2], [1, 3], [2, 3]],
    }
}

/// The edges of a facet of a mesh of space, with all of their nodes.
pub(super) fn edges(mesh: &Mesh<3>, side: Side) -> Vec<(Edge, Vec<u32>)> {
    let shape = if mesh.shape == Shape::Tetrahedron { Shape::Triangle } else { Shape::Quadrilateral };
    let nodes = mesh.facet_nodes(side.cell as usize, side.local as usize);
    let vertices = shape.vertices(mesh.degree);
    let of_pair = |&[a, b]: &[usize; 2]| {
        let on = |node: usize| {
            let weights = shape.vertex_weights(mesh.degree, node);
            weights.iter().enumerate().all(|(v, w)| *w == 0 || v == a || v == b)
        };
        let ends = [a, b].map(|v| nodes[vertices[v]]);
        let on_edge = (0..nodes.len()).filter(|&node| on(node)).map(|node| nodes[node]);
        ([ends[0].min(ends[1]), ends[0].max(ends[1])], on_edge.collect())
    };
    pairs(shape).iter().map(of_pair).collect()
}
