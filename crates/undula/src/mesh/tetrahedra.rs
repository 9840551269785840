//! Tetrahedra from hexahedra.

use super::{Facet, Mesh, Side};
use crate::element::Shape;
use std::collections::HashMap;

/// The corners of a hexahedron, in lexicographic order.
const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]];

impl Mesh<3> {
    /// The same domain in tetrahedra, six from each hexahedron.
    ///
    /// Vertices have an order. Each side of a hexahedron is cut along the diagonal at its first vertex, so that neighbours
    /// agree, and the hexahedron in six tetrahedra at its own first vertex: one for each half of a side that does not meet
    /// it (Dompierre, Labbé, Vallet and Camarero 1999). In a regular grid these are the six of Kuhn.
    ///
    /// First come vertices at which several boundaries meet, then those on one, then the others: a tetrahedron has a vertex
    /// inside wherever the hexahedron has one, without which a given velocity would leave nothing free. Edges keep their
    /// nodes, and diagonals are bent as much as the side or the cell is: not at all between straight edges. Names are kept.
    /// Other shapes are returned as they are.
    pub fn in_tetrahedra(&self) -> Self {
        if self.shape != Shape::Hexahedron {
            return self.clone();
        }
        let mut mesh = Mesh {
            shape: Shape::Tetrahedron,
            cell_nodes: vec![],
            cell_region: vec![],
            facets: vec![],
            parts: vec![],
            ..self.clone()
        };
        let rank = self.ranks();
        let mut sides: HashMap<Side, [Side; 2]> = HashMap::new();
        for cell in 0..self.n_cells() {
            self.straighten(cell, &rank, &mut mesh.nodes);
            for (number, corners) in self.parts_of(cell, &rank).into_iter().enumerate() {
                let new = (6 * cell + number) as u32;
                mesh.add_tetrahedron(self, cell, corners);
                for (side, local) in sides_of(corners) {
                    let of = Side { cell: cell as u32, local: side };
                    let part = Side { cell: new, local };
                    sides.entry(of).and_modify(|parts| parts[1] = part).or_insert([part; 2]);
                }
            }
        }
        let cut = |facets: &[Facet]| -> Vec<Facet> {
            let halves = |facet: &Facet| sides[&facet.side()].map(|side| side.named(facet.boundary));
            facets.iter().flat_map(halves).collect()
        };
        (mesh.facets, mesh.parts) = (cut(&self.facets), cut(&self.parts));
        mesh
    }

    /// The order of the vertices, by node: how many named sides a cell has there at most, and the number of the node.
    fn ranks(&self) -> HashMap<u32, (usize, u32)> {
        let mut named: HashMap<(u32, u32), usize> = HashMap::new();
        let corners = self.shape.vertices(self.degree);
        for facet in &self.facets {
            let on = |&&corner: &&usize| self.shape.on_facet(self.degree, corner, facet.local as usize);
            for &corner in corners.iter().filter(on) {
                *named.entry((facet.cell, self.cell(facet.cell as usize)[corner])).or_default() += 1;
            }
        }
        let mut rank: HashMap<u32, (usize, u32)> = HashMap::new();
        for cell in 0..self.n_cells() {
            for node in self.cell_vertices(cell) {
                let sides = named.get(&(cell as u32, node)).copied().unwrap_or(0);
                let entry = rank.entry(node).or_insert((3, node));
                entry.0 = entry.0.min(3 - sides.min(3));
            }
        }
        rank
    }

    /// The corners of the six tetrahedra of a hexahedron, each turned as the reference cell is.
    fn parts_of(&self, cell: usize, rank: &HashMap<u32, (usize, u32)>) -> [[usize; 4]; 6] {
        let vertices = self.cell_vertices(cell);
        let first =
            |corners: &[usize]| corners.iter().copied().min_by_key(|&c| rank[&vertices[c]]).unwrap_or(0);
        let apex = first(&[0, 1, 2, 3, 4, 5, 6, 7]);
        let mut parts = [[0; 4]; 6];
        for axis in 0..3 {
            // The four corners of the side across the axis, beyond the apex, in a row and its neighbour.
            let beyond = 1 - CORNERS[apex][axis];
            let side: Vec<usize> = (0..8).filter(|&c| CORNERS[c][axis] == beyond).collect();
            let start = first(&side);
            let place = side.iter().position(|&c| c == start).unwrap_or(0);
            let end = side[3 - place];
            for (half, other) in [side[place ^ 1], side[place ^ 2]].into_iter().enumerate() {
                parts[2 * axis + half] = turned([apex, start, end, other]);
            }
        }
        parts
    }

    /// Moves the nodes on diagonals of `cell` to the middle of these, and from there by as much as the middle of the side
    /// or of the cell is away from the mean of its vertices.
    fn straighten(&self, cell: usize, rank: &HashMap<u32, (usize, u32)>, nodes: &mut [[f64; 3]]) {
        if self.degree < 2 {
            return;
        }
        for [v, w] in self.parts_of(cell, rank).into_iter().flat_map(pairs) {
            let spanned: Vec<usize> = (0..8)
                .filter(|&c| {
                    let same = |d: usize| CORNERS[v][d] == CORNERS[w][d];
                    (0..3).all(|d| !same(d) || CORNERS[c][d] == CORNERS[v][d])
                })
                .collect();
            if spanned.len() == 2 {
                continue;
            }
            let middle = self.cell(cell)[self.between(v, w)] as usize;
            let at = |corner: usize| self.nodes[self.cell(cell)[self.between(corner, corner)] as usize];
            nodes[middle] = std::array::from_fn(|d| {
                let mean = spanned.iter().map(|&c| at(c)[d]).sum::<f64>() / spanned.len() as f64;
                0.5 * (at(v)[d] + at(w)[d]) + (self.nodes[middle][d] - mean)
            });
        }
    }

    /// The place in a hexahedron of the node in the middle between two corners, or at one.
    fn between(&self, v: usize, w: usize) -> usize {
        let at = std::array::from_fn(|d| (CORNERS[v][d] + CORNERS[w][d]) * self.degree / 2);
        Shape::Hexahedron.number(self.degree, at)
    }

    /// Adds the tetrahedron between four corners of hexahedron `cell` of `of`.
    fn add_tetrahedron(&mut self, of: &Mesh<3>, cell: usize, corners: [usize; 4]) {
        let degree = of.degree;
        for node in 0..Shape::Tetrahedron.n_nodes(degree) {
            let weights = Shape::Tetrahedron.vertex_weights(degree, node);
            let sum = |d: usize| weights.iter().zip(corners).map(|(w, c)| *w as usize * CORNERS[c][d]).sum();
            let place = Shape::Hexahedron.number(degree, std::array::from_fn(sum));
            self.cell_nodes.push(of.cell(cell)[place]);
        }
        self.cell_region.push(of.cell_region[cell]);
    }
}

/// The edges between four corners.
fn pairs(corners: [usize; 4]) -> [[usize; 2]; 6] {
    [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].map(|pair| pair.map(|i| corners[i]))
}

/// The same corners with a positive volume.
fn turned([a, b, c, d]: [usize; 4]) -> [usize; 4] {
    let [b_, c_, d_] = [b, c, d].map(|v| [0, 1, 2].map(|i| CORNERS[v][i] as i64 - CORNERS[a][i] as i64));
    let cross = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        c_[j] * d_[k] - c_[k] * d_[j]
    };
    let volume: i64 = (0..3).map(|i| b_[i] * cross(i)).sum();
    if volume > 0 { [a, b, c, d] } else { [a, c, b, d] }
}

/// The sides of the hexahedron that a tetrahedron has a half of, with the number of that facet of the tetrahedron.
fn sides_of(corners: [usize; 4]) -> Vec<(u8, u8)> {
    let side_opposite = |local: usize| {
        let on = |side: &usize| {
            let mut others = (0..4).filter(|v| *v != local);
            others.all(|v| CORNERS[corners[v]][side / 2] == side % 2)
        };
        (0..6).find(on).map(|side| (side as u8, local as u8))
    };
    (0..4).filter_map(side_opposite).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate;

    /// All pass the checks of imported meshes, and have the volume and the named areas of the hexahedra.
    #[test]
    fn generated_meshes_become_sound_tetrahedra() {
        let meshes = [
            ("box", generate::hexahedra([0.0; 3], [2.0, 1.0, 1.5], [2, 3, 2], 0).unwrap(), 0.2),
            ("fsi-box", generate::fsi_box(0, 0).unwrap(), 0.01),
            ("tube", generate::tube_graded([0.02, 0.01, 0.002], [4, 8, 1], 0, 0).unwrap(), 0.01),
        ];
        for (name, hexahedra, least) in meshes {
            let mesh = hexahedra.in_tetrahedra();
            mesh.check().unwrap();
            assert_eq!(mesh.n_cells(), 6 * hexahedra.n_cells());
            let worst = mesh.quality().min_scaled_jacobian();
            println!("{name}: {} tetrahedra, worst {worst:.3}", mesh.n_cells());
            assert!(worst > least, "{name}: {worst}");
            let volumes = [&hexahedra, &mesh].map(|m| m.quality().total_volume());
            assert!((volumes[0] - volumes[1]).abs() < 2e-3 * volumes[0], "{name}: {volumes:?}");
            for boundary in 0..hexahedra.boundaries.len() as u16 {
                let count = |m: &Mesh<3>| m.facets.iter().filter(|f| f.boundary == boundary).count();
                assert_eq!(count(&mesh), 2 * count(&hexahedra), "{name}");
            }
            let inner = mesh.facets_of_cells();
            assert!(inner.bad.is_empty());
        }
    }

    /// In a grid of several cells per direction every tetrahedron has a vertex inside.
    #[test]
    fn no_tetrahedron_has_all_vertices_on_the_boundary() {
        let mesh = generate::hexahedra([0.0; 3], [1.0; 3], [3, 2, 4], 0).unwrap().in_tetrahedra();
        for cell in 0..mesh.n_cells() {
            let inside = |x: [f64; 3]| x.iter().all(|x| *x > 1e-9 && *x < 1.0 - 1e-9);
            let vertices = mesh.cell_vertices(cell);
            assert!(vertices.iter().any(|&v| inside(mesh.nodes[v as usize])), "{cell}");
        }
    }

    /// Tetrahedra of a parallelepiped are straight: their maps are affine.
    #[test]
    fn straight_hexahedra_give_affine_tetrahedra() {
        let mut cells = generate::hexahedra([0.0; 3], [1.0; 3], [2, 2, 2], 0).unwrap();
        // A trapezoid: trilinear, straight edges.
        cells.nodes.iter_mut().for_each(|x| x[0] *= 1.0 + 0.3 * x[1]);
        let mesh = cells.in_tetrahedra();
        for cell in 0..mesh.n_cells() {
            let [a, b] = [[0.1, 0.2, 0.3], [0.6, 0.1, 0.1]].map(|xi| mesh.map_gradient(cell, xi));
            for i in 0..3 {
                (0..3).for_each(|j| assert!((a[i][j] - b[i][j]).abs() < 1e-13, "{cell}"));
            }
        }
    }
}
