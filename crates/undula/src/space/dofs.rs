//! Numbering of continuous nodal spaces.

use crate::element::{BasisTable, Quadrature, Shape, lagrange};
use crate::mesh::Mesh;
use std::collections::HashMap;

/// The nodes of a continuous nodal space of one degree.
#[derive(Clone, Debug)]
pub struct Nodes<const D: usize> {
    /// Polynomial degree k.
    pub degree: usize,
    /// Coordinates \[m\], on the curved geometry.
    pub points: Vec<[f64; D]>,
    /// Nodes of each cell, `n_cells × per_cell`, in the order of [`Shape`].
    pub cell_nodes: Vec<u32>,
    /// Number of nodes of a cell, at most.
    pub per_cell: usize,
    /// Number of nodes of the Lagrange basis. Those behind are bubbles, the last nodes of their cells in the order of
    /// [`lagrange::bubbles`].
    pub n_lagrange: usize,
}

impl<const D: usize> Nodes<D> {
    /// Number the nodes of degree `degree` on `mesh`, in the order in which cells meet them.
    ///
    /// A node is a combination of the vertices of its cell with whole-number weights, see
    /// [`Shape::vertex_weights`]. Those of the facet, edge or vertex on which it lies are the only ones not
    /// zero, so that the combination names the node whichever cell asks, in any dimension and orientation.
    pub fn new(mesh: &Mesh<D>, degree: usize) -> Nodes<D> {
        Self::on_cells(mesh, degree, |_| true)
    }

    /// The same on the cells where `keep` holds; other cells get `u32::MAX` entries.
    pub fn on_cells(mesh: &Mesh<D>, degree: usize, keep: impl Fn(usize) -> bool) -> Nodes<D> {
        let shape = mesh.shape;
        let per_cell = shape.n_nodes(degree);
        let weights: Vec<Vec<u32>> = (0..per_cell).map(|a| shape.vertex_weights(degree, a)).collect();
        let vertices = shape.vertices(mesh.degree);
        let local: Vec<[f64; D]> = (0..per_cell)
            .map(|a| {
                let xi = lagrange::node(shape, degree, a);
                std::array::from_fn(|d| xi[d])
            })
            .collect();
        let mut known: HashMap<Vec<(u32, u32)>, u32> = HashMap::new();
        let mut points = vec![];
        let mut cell_nodes = vec![u32::MAX; mesh.n_cells() * per_cell];
        for c in (0..mesh.n_cells()).filter(|&c| keep(c)) {
            let corners = mesh.cell(c);
            for a in 0..per_cell {
                let mut key: Vec<(u32, u32)> = (weights[a].iter().zip(&vertices))
                    .filter(|(w, _)| **w > 0)
                    .map(|(w, v)| (corners[*v], *w))
                    .collect();
                key.sort_unstable();
                let number = *known.entry(key).or_insert_with(|| {
                    points.push(mesh.map(c, local[a]));
                    points.len() as u32 - 1
                });
                cell_nodes[c * per_cell + a] = number;
            }
        }
        let n_lagrange = points.len();
        Nodes { degree, points, cell_nodes, per_cell, n_lagrange }
    }

    /// With the bubbles of a simplex in every cell where `there` holds: at the centre, of tetrahedra at the centres of the
    /// faces, too. Two cells that share a face share its bubble.
    pub fn with_bubbles(mut self, mesh: &Mesh<D>, there: impl Fn(usize) -> bool) -> Nodes<D> {
        let n = lagrange::n_bubbles(mesh.shape);
        let mut of_faces: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut cell_nodes = Vec::with_capacity(self.cell_nodes.len() + n * mesh.n_cells());
        for (cell, nodes) in self.cell_nodes.chunks_exact(self.per_cell).enumerate() {
            cell_nodes.extend(nodes);
            if !there(cell) {
                cell_nodes.extend(vec![u32::MAX; n]);
                continue;
            }
            let vertices = mesh.cell_vertices(cell);
            for face in 0..n - 1 {
                let mut key: Vec<u32> = vertices.clone();
                key.remove(face);
                key.sort_unstable();
                let number = *of_faces.entry(key).or_insert_with(|| {
                    let third = |d: usize| if d + 1 == face { 0.0 } else { 1.0 / 3.0 };
                    self.points.push(mesh.map(cell, std::array::from_fn(third)));
                    self.points.len() as u32 - 1
                });
                cell_nodes.push(number);
            }
            cell_nodes.push(self.points.len() as u32);
            self.points.push(mesh.map(cell, mesh.reference_centre()));
        }
        Nodes { cell_nodes, per_cell: self.per_cell + n, ..self }
    }

    /// The bubble of facet `local` of `cell`, if there is one.
    pub fn facet_bubble(&self, shape: Shape, cell: usize, local: usize) -> Option<u32> {
        let first = shape.n_nodes(self.degree);
        let own = self.cell(cell);
        (own.len() > first && local + 1 < lagrange::n_bubbles(shape)).then(|| own[first + local])
    }

    /// The basis at the points of `rule`: that of the nodes, and behind it the bubbles if there are any.
    pub fn table(&self, shape: Shape, rule: &Quadrature) -> BasisTable {
        let table = BasisTable::lagrange(shape, self.degree, rule);
        if self.per_cell > table.n_basis { table.with_bubbles(shape, rule) } else { table }
    }

    /// Whether `cell` has bubbles.
    pub fn has_bubble(&self, cell: usize) -> bool {
        self.cell(cell).last().is_some_and(|&node| node as usize >= self.n_lagrange)
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Nodes of cell `cell`.
    pub fn cell(&self, cell: usize) -> &[u32] {
        let nodes = &self.cell_nodes[cell * self.per_cell..(cell + 1) * self.per_cell];
        match nodes.last() {
            Some(&u32::MAX) => &nodes[..nodes.iter().position(|&n| n == u32::MAX).unwrap_or(0)],
            _ => nodes,
        }
    }
}
