//! Numbering of continuous nodal spaces.

use crate::element::{Shape, lagrange};
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
    /// Number of nodes of a cell.
    pub per_cell: usize,
}

impl<const D: usize> Nodes<D> {
    /// Number the nodes of degree `degree` on `mesh`, in the order in which cells meet them.
    ///
    /// A node is a combination of the vertices of its cell with whole-number weights (the multilinear
    /// coordinates times k^D). Those of the facet, edge or vertex on which it lies are the only ones not
    /// zero, so that the combination names the node whichever cell asks, in any dimension and orientation.
    pub fn new(mesh: &Mesh<D>, degree: usize) -> Nodes<D> {
        Self::on_cells(mesh, degree, |_| true)
    }

    /// The same on the cells where `keep` holds; other cells get `u32::MAX` entries.
    pub fn on_cells(mesh: &Mesh<D>, degree: usize, keep: impl Fn(usize) -> bool) -> Nodes<D> {
        let shape = mesh.shape;
        let per_cell = shape.n_nodes(degree);
        let weights: Vec<Vec<u32>> = (0..per_cell).map(|a| vertex_weights(shape, degree, a)).collect();
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
        Nodes { degree, points, cell_nodes, per_cell }
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
        &self.cell_nodes[cell * self.per_cell..(cell + 1) * self.per_cell]
    }
}

/// Multilinear coordinates of node `a` with respect to the vertices, times k^D.
fn vertex_weights(shape: Shape, degree: usize, a: usize) -> Vec<u32> {
    let at = shape.lattice(degree, a);
    (0..shape.n_nodes(1))
        .map(|v| {
            let corner = shape.lattice(1, v);
            (0..shape.dim()).map(|d| if corner[d] == 1 { at[d] } else { degree - at[d] } as u32).product()
        })
        .collect()
}
