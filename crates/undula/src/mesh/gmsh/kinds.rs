//! The elements that Gmsh and we have in common.

use crate::element::Shape;

/// A type of elements.
pub(super) struct Kind {
    /// Its number in files.
    pub number: i64,
    /// Its dimension.
    pub dim: usize,
    /// Of those that can be cells.
    pub shape: Option<Shape>,
    /// Degree of the map.
    pub degree: usize,
    /// Numbers of its nodes in Gmsh, in lexicographic order. Gmsh has vertices first, then the middles of edges, of sides
    /// and of the cell.
    pub order: &'static [usize],
}

impl Kind {
    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.order.len()
    }

    /// Number of vertices, which come first in Gmsh.
    pub fn n_vertices(&self) -> usize {
        match self.shape {
            Some(shape) => shape.n_nodes(1),
            None => self.dim + 1,
        }
    }

    /// `nodes` in lexicographic order as Gmsh has them.
    pub fn in_gmsh(&self, nodes: &[u32]) -> Vec<u32> {
        let mut found = vec![0; nodes.len()];
        self.order.iter().zip(nodes).for_each(|(&i, &node)| found[i] = node);
        found
    }

    /// One and many of them, in words.
    pub fn names(&self) -> [&'static str; 2] {
        match (self.shape, self.dim) {
            (Some(Shape::Triangle), _) => ["triangle", "triangles"],
            (Some(Shape::Quadrilateral), _) => ["quadrilateral", "quadrilaterals"],
            (Some(Shape::Tetrahedron), _) => ["tetrahedron", "tetrahedra"],
            (Some(Shape::Hexahedron), _) => ["hexahedron", "hexahedra"],
            (None, 0) => ["point", "points"],
            (None, _) => ["line", "lines"],
        }
    }
}

/// All of them; those that can be cells in the order of messages.
pub(super) const KINDS: [Kind; 11] = [
    Kind { number: 15, dim: 0, shape: None, degree: 1, order: &[0] },
    Kind { number: 1, dim: 1, shape: None, degree: 1, order: &[0, 1] },
    Kind { number: 8, dim: 1, shape: None, degree: 2, order: &[0, 2, 1] },
    Kind { number: 2, dim: 2, shape: Some(Shape::Triangle), degree: 1, order: &[0, 1, 2] },
    Kind { number: 9, dim: 2, shape: Some(Shape::Triangle), degree: 2, order: &[0, 3, 1, 5, 4, 2] },
    Kind { number: 3, dim: 2, shape: Some(Shape::Quadrilateral), degree: 1, order: &[0, 1, 3, 2] },
    Kind {
        number: 10,
        dim: 2,
        shape: Some(Shape::Quadrilateral),
        degree: 2,
        order: &[0, 4, 1, 7, 8, 5, 3, 6, 2],
    },
    Kind { number: 4, dim: 3, shape: Some(Shape::Tetrahedron), degree: 1, order: &[0, 1, 2, 3] },
    Kind {
        number: 11,
        dim: 3,
        shape: Some(Shape::Tetrahedron),
        degree: 2,
        order: &[0, 4, 1, 6, 5, 2, 7, 9, 8, 3],
    },
    Kind { number: 5, dim: 3, shape: Some(Shape::Hexahedron), degree: 1, order: &[0, 1, 3, 2, 4, 5, 7, 6] },
    Kind { number: 12, dim: 3, shape: Some(Shape::Hexahedron), degree: 2, order: &HEXAHEDRON_27 },
];

/// The three layers of nodes of a hexahedron of degree 2.
const HEXAHEDRON_27: [usize; 27] = [
    0, 8, 1, 9, 20, 11, 3, 13, 2, // bottom
    10, 21, 12, 22, 26, 23, 15, 24, 14, // middle
    4, 16, 5, 17, 25, 18, 7, 19, 6, // top
];
