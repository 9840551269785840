//! Cell shapes and their faces.

/// The reference cell: `[0, 1]^D` for tensor-product shapes, `ξ, η ≥ 0, ξ + η ≤ 1` for triangles.
///
/// Nodes of a cell of degree `k` are numbered lexicographically, the first coordinate running fastest: node `(i, j)`
/// of a quadrilateral has number `i + (k + 1) j`. Of a triangle there are those with `i + j ≤ k`.
/// Facet `2 d + s` of a tensor-product cell is the one on which coordinate `d` equals `s`; facet `l` of a triangle
/// is opposite to its vertex `l`, that is where λ_l = 0 of (λ_0, λ_1, λ_2) = (1 − ξ − η, ξ, η).
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Three edges.
    Triangle,
    /// `[0, 1]²`, four edges.
    Quadrilateral,
    /// `[0, 1]³`, six faces.
    Hexahedron,
}

impl Shape {
    /// Space dimension.
    pub const fn dim(self) -> usize {
        match self {
            Shape::Triangle | Shape::Quadrilateral => 2,
            Shape::Hexahedron => 3,
        }
    }

    /// Name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Shape::Triangle => "triangles",
            Shape::Quadrilateral => "quadrilaterals",
            Shape::Hexahedron => "hexahedra",
        }
    }

    /// Number of facets (edges in 2D, faces in 3D).
    pub const fn n_facets(self) -> usize {
        match self {
            Shape::Triangle => 3,
            _ => 2 * self.dim(),
        }
    }

    /// Number of nodes of the cell at degree `degree`.
    pub const fn n_nodes(self, degree: usize) -> usize {
        match self {
            Shape::Triangle => (degree + 1) * (degree + 2) / 2,
            _ => (degree + 1).pow(self.dim() as u32),
        }
    }

    /// Number of nodes on one facet at degree `degree`.
    pub const fn n_facet_nodes(self, degree: usize) -> usize {
        (degree + 1).pow(self.dim() as u32 - 1)
    }

    /// Lattice position of node `node`: entries in `0..=degree`, unused entries zero.
    pub fn lattice(self, degree: usize, node: usize) -> [usize; 3] {
        let n = degree + 1;
        match self {
            Shape::Triangle => {
                let (mut i, mut j) = (node, 0);
                while i > degree - j {
                    i -= n - j;
                    j += 1;
                }
                [i, j, 0]
            }
            Shape::Quadrilateral => [node % n, node / n, 0],
            Shape::Hexahedron => [node % n, node / n % n, node / (n * n)],
        }
    }

    /// Number of the node at lattice position `at`, the inverse of [`Shape::lattice`].
    pub fn number(self, degree: usize, at: [usize; 3]) -> usize {
        let n = degree + 1;
        match self {
            Shape::Triangle => at[0] + (0..at[1]).map(|j| n - j).sum::<usize>(),
            _ => at[0] + n * (at[1] + n * at[2]),
        }
    }

    /// Whether child `child` of a cell that is refined in `2^D` is turned round: ξ ↦ ½ (b − ξ) instead of ½ (b + ξ), b_d
    /// being bit d of `child`. The last one of a triangle is: that in the middle.
    pub fn is_turned(self, child: usize) -> bool {
        self == Shape::Triangle && child == 3
    }

    /// Lattice position of degree `2 degree` of the node at `at` of child `child`.
    pub fn in_parent(self, degree: usize, child: usize, at: [usize; 3]) -> [usize; 3] {
        let corner = |d: usize| (child >> d & 1) * degree;
        std::array::from_fn(|d| if self.is_turned(child) { corner(d) - at[d] } else { corner(d) + at[d] })
    }

    /// Reference coordinates in a refined cell of the point at `xi` of its child `child`.
    pub fn to_parent<const D: usize>(self, child: usize, xi: [f64; D]) -> [f64; D] {
        let corner = |d: usize| (child >> d & 1) as f64;
        std::array::from_fn(|d| {
            0.5 * if self.is_turned(child) { corner(d) - xi[d] } else { corner(d) + xi[d] }
        })
    }

    /// Whether child `child` of a refined cell has a part of facet `facet`; that is facet `facet` of the child, too.
    pub fn child_on_facet(self, child: usize, facet: usize) -> bool {
        match self {
            // The children at the two vertices of the edge.
            Shape::Triangle => child < 3 && child != facet,
            _ => child >> (facet / 2) & 1 == facet % 2,
        }
    }

    /// Whether node `node` of degree `degree` lies on facet `facet`.
    pub fn on_facet(self, degree: usize, node: usize, facet: usize) -> bool {
        let at = self.lattice(degree, node);
        match (self, facet) {
            (Shape::Triangle, 0) => at[0] + at[1] == degree,
            (Shape::Triangle, _) => at[facet - 1] == 0,
            _ => at[facet / 2] == facet % 2 * degree,
        }
    }

    /// Whether node `node` of degree `degree` lies on no facet.
    pub fn is_inner(self, degree: usize, node: usize) -> bool {
        (0..self.n_facets()).all(|facet| !self.on_facet(degree, node, facet))
    }

    /// Cell-local numbers of the nodes on facet `facet`, in lexicographic order.
    pub fn facet_nodes(self, degree: usize, facet: usize) -> Vec<usize> {
        (0..self.n_nodes(degree)).filter(|&n| self.on_facet(degree, n, facet)).collect()
    }

    /// Cell-local numbers (at degree `degree`) of the vertices, in lexicographic order.
    pub fn vertices(self, degree: usize) -> Vec<usize> {
        let corners = (0..self.n_nodes(1)).map(|v| self.lattice(1, v));
        corners.map(|at| self.number(degree, at.map(|i| i * degree))).collect()
    }

    /// Coordinates of node `node` with respect to the vertices, times the smallest number that makes them whole:
    /// multilinear ones times k^D, barycentric ones times k. Vertices of facets that the node is not on have 0.
    pub fn vertex_weights(self, degree: usize, node: usize) -> Vec<u32> {
        let at = self.lattice(degree, node);
        if self == Shape::Triangle {
            return [degree - at[0] - at[1], at[0], at[1]].map(|w| w as u32).to_vec();
        }
        let factor =
            |corner: [usize; 3], d: usize| if corner[d] == 1 { at[d] } else { degree - at[d] } as u32;
        let corners = (0..self.n_nodes(1)).map(|v| self.lattice(1, v));
        corners.map(|corner| (0..self.dim()).map(|d| factor(corner, d)).product()).collect()
    }

    /// Centre of the reference cell, unused entries zero.
    pub const fn centre(self) -> [f64; 3] {
        match self {
            Shape::Triangle => [1.0 / 3.0, 1.0 / 3.0, 0.0],
            Shape::Quadrilateral => [0.5, 0.5, 0.0],
            Shape::Hexahedron => [0.5; 3],
        }
    }

    /// Outer normal of facet `facet`, as long as the facet is large in units of the facet of a rule with weights 1.
    pub fn facet_normal(self, facet: usize) -> [f64; 3] {
        let mut normal = [0.0; 3];
        match (self, facet) {
            (Shape::Triangle, 0) => normal = [1.0, 1.0, 0.0],
            (Shape::Triangle, _) => normal[facet - 1] = -1.0,
            _ => normal[facet / 2] = if facet % 2 == 1 { 1.0 } else { -1.0 },
        }
        normal
    }

    /// How far `xi` lies outside of the reference cell; 0 inside.
    pub fn outside(self, xi: &[f64]) -> f64 {
        let sum: f64 = if self == Shape::Triangle { xi.iter().sum() } else { 0.0 };
        xi.iter().map(|s| (s - 1.0).max(-s)).fold((sum - 1.0).max(0.0), f64::max)
    }

    /// A point of the reference cell close to `xi`, itself if it lies inside.
    pub fn clamp<const D: usize>(self, xi: [f64; D]) -> [f64; D] {
        let inside = xi.map(|s| s.clamp(0.0, 1.0));
        let sum: f64 = inside.iter().sum();
        if self == Shape::Triangle && sum > 1.0 { inside.map(|s| s / sum) } else { inside }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Shape; 3] = [Shape::Triangle, Shape::Quadrilateral, Shape::Hexahedron];

    #[test]
    fn nodes_have_one_number_and_facets_their_own_nodes() {
        for shape in ALL {
            for k in 1..5 {
                for node in 0..shape.n_nodes(k) {
                    assert_eq!(shape.number(k, shape.lattice(k, node)), node);
                    let weights = shape.vertex_weights(k, node);
                    assert!(shape.is_inner(k, node) == weights.iter().all(|w| *w > 0));
                }
                for facet in 0..shape.n_facets() {
                    assert_eq!(shape.facet_nodes(k, facet).len(), shape.n_facet_nodes(k));
                }
                let on_vertex =
                    |&n: &usize| shape.vertex_weights(k, n).iter().filter(|w| **w > 0).count() == 1;
                let vertices: Vec<_> = (0..shape.n_nodes(k)).filter(on_vertex).collect();
                assert_eq!(shape.vertices(k), vertices);
            }
        }
        assert_eq!(Shape::Triangle.facet_nodes(2, 0), [2, 4, 5]);
    }

    #[test]
    fn points_outside_are_moved_into_the_cell() {
        for shape in ALL {
            let centre: [f64; 3] = shape.centre();
            assert_eq!(shape.outside(&centre[..shape.dim()]), 0.0);
        }
        assert!((Shape::Triangle.outside(&[0.7, 0.6]) - 0.3).abs() < 1e-15);
        let moved: [f64; 2] = Shape::Triangle.clamp([0.7, 0.6]);
        assert!(Shape::Triangle.outside(&moved) < 1e-15 && (moved[0] - 7.0 / 13.0).abs() < 1e-15);
        assert_eq!(Shape::Quadrilateral.clamp([1.2, 0.3]), [1.0, 0.3]);
    }
}
