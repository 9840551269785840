//! The cells above one facet of a surface.

use super::Growth;
use super::rim::{cross, dot};
use super::surface::Edge;
use crate::element::Shape;
use crate::mesh::{Facet, Mesh};

/// The three tetrahedra of a prism by vertices i < j < k of its bottom, each with its end: 0 below, 1 above. Sides are cut
/// along the diagonal from the lower end at the lower vertex. All are turned as the reference cell is if i, j, k run round
/// the direction of growth.
const PRISM: [[(usize, usize); 4]; 3] =
    [[(0, 0), (1, 0), (2, 0), (2, 1)], [(0, 0), (1, 0), (2, 1), (1, 1)], [(0, 0), (0, 1), (1, 1), (2, 1)]];

impl Growth<'_> {
    /// Adds the tetrahedra above facet `column`.
    pub(super) fn add_tetrahedra(&self, column: usize, wall: &mut Mesh<3>) {
        let shape = self.surface.shape;
        let nodes = &self.surface.facets[column].nodes;
        let places = shape.vertices(self.mesh.degree);
        // Corners in the order of their numbers, which is the same in the surface and in the mesh.
        let mut corners = [0, 1, 2];
        corners.sort_unstable_by_key(|&v| nodes[places[v]]);
        let turned = self.is_turned(column, corners);
        for layer in 0..self.layers {
            for mut part in PRISM {
                if turned {
                    part.swap(0, 1);
                }
                let cell = wall.cell_region.len() as u32;
                for node in 0..Shape::Tetrahedron.n_nodes(self.mesh.degree) {
                    let weights = Shape::Tetrahedron.vertex_weights(self.mesh.degree, node);
                    let mut at = [0; 3];
                    let mut level = 0;
                    for (&(corner, end), &weight) in part.iter().zip(&weights) {
                        at[corners[corner]] += weight as usize;
                        level += end * weight as usize;
                    }
                    let place = shape.number(self.mesh.degree, [at[1], at[2], 0]);
                    wall.cell_nodes.push(self.node(nodes[place], layer * self.mesh.degree + level));
                }
                wall.cell_region.push(0);
                for local in 0..4 {
                    let side: Vec<(usize, usize)> = (0..4).filter(|v| *v != local).map(|v| part[v]).collect();
                    let is_top = side.iter().all(|(_, end)| *end == 1);
                    let mut below: Vec<usize> = side.iter().map(|&(corner, _)| corners[corner]).collect();
                    below.sort_unstable();
                    below.dedup();
                    let boundary = match below[..] {
                        [a, b] => self.ring_at(column, [a, b]),
                        _ => (is_top && layer + 1 == self.layers).then_some(0),
                    };
                    wall.facets.extend(boundary.map(|boundary| Facet { cell, local: local as u8, boundary }));
                }
            }
        }
    }

    /// Adds the hexahedra above facet `column`.
    pub(super) fn add_hexahedra(&self, column: usize, wall: &mut Mesh<3>) {
        let (shape, degree) = (self.surface.shape, self.mesh.degree);
        let nodes = &self.surface.facets[column].nodes;
        let turned = self.is_turned(column, [0, 1, 2]);
        let flip = |[s, t]: [usize; 2]| if turned { [t, s] } else { [s, t] };
        for layer in 0..self.layers {
            let cell = wall.cell_region.len() as u32;
            for node in 0..Shape::Hexahedron.n_nodes(degree) {
                let [s, t, level] = Shape::Hexahedron.lattice(degree, node);
                let [s, t] = flip([s, t]);
                let place = shape.number(degree, [s, t, 0]);
                wall.cell_nodes.push(self.node(nodes[place], layer * degree + level));
            }
            wall.cell_region.push(0);
            // Sides 0 and 1 across the first coordinate, 2 and 3 across the second.
            for (local, ends) in [[0, 2], [1, 3], [0, 1], [2, 3]].into_iter().enumerate() {
                let ends = ends.map(|v| if turned { [0, 2, 1, 3][v] } else { v });
                let boundary = self.ring_at(column, ends);
                wall.facets.extend(boundary.map(|boundary| Facet { cell, local: local as u8, boundary }));
            }
            if layer + 1 == self.layers {
                wall.facets.push(Facet { cell, local: 5, boundary: 0 });
            }
        }
    }

    /// Number in the wall of the node at `level` above node `node` of the surface.
    fn node(&self, node: u32, level: usize) -> u32 {
        node * (self.levels() as u32 + 1) + level as u32
    }

    /// The ring above the edge between two vertices of a facet, if the surface ends there.
    fn ring_at(&self, column: usize, ends: [usize; 2]) -> Option<u16> {
        let places = self.surface.shape.vertices(self.mesh.degree);
        let facet = &self.surface.facets[column];
        let [a, b] = ends.map(|v| self.surface.nodes[facet.nodes[places[v]] as usize]);
        let edge: Edge = [a.min(b), a.max(b)];
        self.rim.edges.get(&edge).map(|name| *name as u16 + 1)
    }

    /// Whether these vertices of a facet run round the inner side of it.
    fn is_turned(&self, column: usize, vertices: [usize; 3]) -> bool {
        let facet = &self.surface.facets[column];
        let places = self.surface.shape.vertices(self.mesh.degree);
        let at = |v: usize| self.mesh.nodes[self.surface.nodes[facet.nodes[places[v]] as usize] as usize];
        let to = |p: usize, q: usize| -> [f64; 3] {
            let (p, q) = (at(p), at(q));
            std::array::from_fn(|d| q[d] - p[d])
        };
        let [a, b, c] = vertices;
        // Of a quadrilateral both diagonals, as one vertex may be bent.
        let across = if places.len() == 4 { cross(to(0, 3), to(1, 2)) } else { cross(to(a, b), to(a, c)) };
        let growth = |place: &usize| dot(across, self.growth[facet.nodes[*place] as usize]);
        places.iter().map(growth).sum::<f64>() < 0.0
    }
}
