//! Cell shapes and their faces.

/// The reference cell: `[0, 1]^D` for tensor-product shapes.
///
/// Nodes of a tensor-product cell of degree `k` are numbered lexicographically, the first
/// coordinate running fastest: node `(i, j)` of a quadrilateral has number `i + (k + 1) j`.
/// Facet `2 d + s` is the one on which coordinate `d` equals `s`.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// `[0, 1]²`, four edges.
    Quadrilateral,
    /// `[0, 1]³`, six faces.
    Hexahedron,
}

impl Shape {
    /// Space dimension.
    pub const fn dim(self) -> usize {
        match self {
            Shape::Quadrilateral => 2,
            Shape::Hexahedron => 3,
        }
    }

    /// Number of facets (edges in 2D, faces in 3D).
    pub const fn n_facets(self) -> usize {
        2 * self.dim()
    }

    /// Number of nodes of the cell at degree `degree`.
    pub const fn n_nodes(self, degree: usize) -> usize {
        (degree + 1).pow(self.dim() as u32)
    }

    /// Number of nodes on one facet at degree `degree`.
    pub const fn n_facet_nodes(self, degree: usize) -> usize {
        (degree + 1).pow(self.dim() as u32 - 1)
    }

    /// Lattice position of node `node`: entries in `0..=degree`, unused entries zero.
    pub fn lattice(self, degree: usize, node: usize) -> [usize; 3] {
        let n = degree + 1;
        match self {
            Shape::Quadrilateral => [node % n, node / n, 0],
            Shape::Hexahedron => [node % n, node / n % n, node / (n * n)],
        }
    }

    /// Whether node `node` of degree `degree` lies on no facet.
    pub fn is_inner(self, degree: usize, node: usize) -> bool {
        let at = self.lattice(degree, node);
        (0..self.dim()).all(|d| at[d] != 0 && at[d] != degree)
    }

    /// Cell-local numbers of the nodes on facet `facet`, in lexicographic order.
    pub fn facet_nodes(self, degree: usize, facet: usize) -> Vec<usize> {
        let (axis, side) = (facet / 2, facet % 2);
        (0..self.n_nodes(degree)).filter(|&n| self.lattice(degree, n)[axis] == side * degree).collect()
    }

    /// Cell-local numbers (at degree `degree`) of the vertices, in lexicographic order.
    pub fn vertices(self, degree: usize) -> Vec<usize> {
        let on_corner = |&n: &usize| {
            let at = self.lattice(degree, n);
            (0..self.dim()).all(|d| at[d] == 0 || at[d] == degree)
        };
        (0..self.n_nodes(degree)).filter(on_corner).collect()
    }
}
