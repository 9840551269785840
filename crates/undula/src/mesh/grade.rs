//! Nested rings of cells around a vertex, for the singularities at corners.

use super::geometry::distance;
use super::{Facet, Mesh};
use std::collections::HashMap;

/// Mid nodes of the edges that one ring adds, by the ends of the edge in increasing order.
type MidNodes = HashMap<(u32, u32), u32>;

/// Vertices of the three parts of a cell in quarters of it, seen from the corner that is graded.
const PARTS: [[[usize; 2]; 4]; 3] = [
    [[2, 0], [4, 0], [2, 2], [4, 4]],
    [[0, 2], [2, 2], [0, 4], [4, 4]],
    // Last, because it takes the place of the cell.
    [[0, 0], [2, 0], [0, 2], [2, 2]],
];

impl Mesh<2> {
    /// Lays `rings` nested rings of cells around the vertex at `corner` \[m\].
    ///
    /// Each ring splits every cell with that vertex in three: a quadrilateral of half the size at the
    /// vertex and two trapezoids around it, so that the mesh stays conforming and the patch keeps its
    /// outline. Four squares become four squares of half the width and 8 trapezoids with angles of 45°
    /// (scaled Jacobian 0.707). Regions and names are kept. Without a vertex at `corner`, or at geometry
    /// degree 1, nothing changes.
    pub fn graded(mut self, corner: [f64; 2], rings: usize) -> Self {
        let tolerance = 1e-9 * self.diameter();
        for _ in 0..rings {
            let mut middle = MidNodes::new();
            for cell in 0..self.n_cells() {
                let is_corner = |&v: &u32| distance(self.nodes[v as usize], corner) <= tolerance;
                let at = self.cell_vertices(cell).iter().position(is_corner);
                if let (Some(at), 2) = (at, self.degree) {
                    self.split_in_three(cell, at, &mut middle);
                }
            }
        }
        self
    }

    /// Splits `cell` around its vertex `corner`.
    fn split_in_three(&mut self, cell: usize, corner: usize, middle: &mut MidNodes) {
        let facets: Vec<Facet> = self.facets.extract_if(.., |f| f.cell as usize == cell).collect();
        let names: Vec<Facet> = self.parts.extract_if(.., |f| f.cell as usize == cell).collect();
        for (part, vertices) in PARTS.into_iter().enumerate() {
            let mut quarters = [[0; 2]; 4];
            for (i, at) in vertices.into_iter().enumerate() {
                let flip = |d: usize| if corner >> d & 1 == 1 { 4 - at[d] } else { at[d] };
                quarters[i ^ corner] = [flip(0), flip(1)];
            }
            let nodes = self.part_nodes(cell, quarters, middle);
            let number = if part == 2 { cell } else { self.n_cells() };
            if part == 2 {
                self.cell_nodes[9 * cell..9 * cell + 9].copy_from_slice(&nodes);
            } else {
                self.cell_nodes.extend(nodes);
                self.cell_region.push(self.cell_region[cell]);
            }
            let named = facets.iter().map(|f| (f, true)).chain(names.iter().map(|f| (f, false)));
            for (&facet, first) in named {
                let (axis, side) = (facet.local as usize / 2, facet.local as usize % 2);
                let mut ends = (0..4).filter(|v| v >> axis & 1 == side);
                if ends.all(|v| quarters[v][axis] == 4 * side) {
                    let list = if first { &mut self.facets } else { &mut self.parts };
                    list.push(Facet { cell: number as u32, ..facet });
                }
            }
        }
    }

    /// The nine nodes of the part of `cell` with vertices at `quarters` of it.
    fn part_nodes(&mut self, cell: usize, quarters: [[usize; 2]; 4], middle: &mut MidNodes) -> [u32; 9] {
        std::array::from_fn(|i| {
            // The vertices of the part that this node is the mean of: one, two or four.
            let among =
                |v: &usize| [i % 3, i / 3].iter().zip([v & 1, v >> 1]).all(|(&x, b)| x == 1 || x == 2 * b);
            let vertices: Vec<[usize; 2]> = (0..4).filter(among).map(|v| quarters[v]).collect();
            let n = vertices.len();
            let total = [0, 1].map(|d| vertices.iter().map(|q| q[d]).sum::<usize>());
            if total.iter().all(|t| t % (2 * n) == 0) {
                return self.cell(cell)[total[0] / (2 * n) + 3 * (total[1] / (2 * n))];
            }
            let new = self.nodes.len() as u32;
            let ends = [vertices[0], vertices[n - 1]].map(|[x, y]| self.cell(cell)[x / 2 + 3 * (y / 2)]);
            let number = match n {
                2 => *middle.entry((ends[0].min(ends[1]), ends[0].max(ends[1]))).or_insert(new),
                _ => new,
            };
            if number == new {
                let x = self.map(cell, total.map(|t| t as f64 / (4 * n) as f64));
                self.nodes.push(x);
            }
            number
        })
    }
}
