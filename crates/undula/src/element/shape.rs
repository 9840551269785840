//! Cell shapes and their faces.

/// The reference cell: `[0, 1]^D` for tensor-product shapes, `ξ_d ≥ 0, Σ ξ_d ≤ 1` for simplices.
///
/// Nodes of a cell of degree `k` are numbered lexicographically, the first coordinate running fastest: node `(i, j)`
/// of a quadrilateral has number `i + (k + 1) j`. Of a simplex there are those with `Σ i_d ≤ k`.
/// Facet `2 d + s` of a tensor-product cell is the one on which coordinate `d` equals `s`; facet `l` of a simplex
/// is opposite to its vertex `l`, that is where λ_l = 0 of (λ_0, λ_1, …) = (1 − Σ ξ_d, ξ, η, …).
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Three edges.
    Triangle,
    /// `[0, 1]²`, four edges.
    Quadrilateral,
    /// Four faces.
    Tetrahedron,
    /// `[0, 1]³`, six faces.
    Hexahedron,
}

impl Shape {
    /// Space dimension.
    pub const fn dim(self) -> usize {
        match self {
            Shape::Triangle | Shape::Quadrilateral => 2,
            Shape::Tetrahedron | Shape::Hexahedron => 3,
        }
    }

    /// Whether it is a triangle or a tetrahedron.
    pub const fn is_simplex(self) -> bool {
        matches!(self, Shape::Triangle | Shape::Tetrahedron)
    }

    /// Name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Shape::Triangle => "triangles",
            Shape::Quadrilateral => "quadrilaterals",
            Shape::Tetrahedron => "tetrahedra",
            Shape::Hexahedron => "hexahedra",
        }
    }

    /// Number of facets (edges in 2D, faces in 3D).
    pub const fn n_facets(self) -> usize {
        match self {
            Shape::Triangle | Shape::Tetrahedron => self.dim() + 1,
            _ => 2 * self.dim(),
        }
    }

    /// Number of nodes of the cell at degree `degree`.
    pub const fn n_nodes(self, degree: usize) -> usize {
        match self {
            Shape::Triangle => (degree + 1) * (degree + 2) / 2,
            Shape::Tetrahedron => (degree + 1) * (degree + 2) * (degree + 3) / 6,
            _ => (degree + 1).pow(self.dim() as u32),
        }
    }

    /// Number of nodes on one facet at degree `degree`.
    pub const fn n_facet_nodes(self, degree: usize) -> usize {
        match self {
            Shape::Tetrahedron => Shape::Triangle.n_nodes(degree),
            _ => (degree + 1).pow(self.dim() as u32 - 1),
        }
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
            Shape::Tetrahedron => {
                let (mut rest, mut k) = (node, 0);
                while rest >= Shape::Triangle.n_nodes(degree - k) {
                    rest -= Shape::Triangle.n_nodes(degree - k);
                    k += 1;
                }
                let [i, j, _] = Shape::Triangle.lattice(degree - k, rest);
                [i, j, k]
            }
            Shape::Hexahedron => [node % n, node / n % n, node / (n * n)],
        }
    }

    /// Number of the node at lattice position `at`, the inverse of [`Shape::lattice`].
    pub fn number(self, degree: usize, at: [usize; 3]) -> usize {
        let n = degree + 1;
        match self {
            Shape::Triangle => at[0] + (0..at[1]).map(|j| n - j).sum::<usize>(),
            Shape::Tetrahedron => {
                let below: usize = (0..at[2]).map(|k| Shape::Triangle.n_nodes(degree - k)).sum();
                below + Shape::Triangle.number(degree - at[2], [at[0], at[1], 0])
            }
            _ => at[0] + n * (at[1] + n * at[2]),
        }
    }

    /// The number of child `place` of a cell that is refined in `2^D`, for [`Shape::to_parent`] and [`Shape::in_parent`]:
    /// the place itself. In the middle of a tetrahedron it depends on the `diagonal` that the four children there share:
    /// that between the middles of the edges 0–1 and 2–3 (0), 0–2 and 1–3 (1), 0–3 and 1–2 (2).
    pub const fn child_number(self, place: usize, diagonal: u8) -> usize {
        match self {
            Shape::Tetrahedron if place >= 4 => place + 4 * diagonal as usize,
            _ => place,
        }
    }

    /// Whether child `child` of a cell that is refined in `2^D` is turned round: ξ ↦ ½ (b − ξ) instead of ½ (b + ξ), b_d
    /// being bit d of `child`. The last one of a triangle is: that in the middle.
    pub fn is_turned(self, child: usize) -> bool {
        self == Shape::Triangle && child == 3
    }

    /// Lattice position of degree `2 degree` of the node at `at` of the child with number `child`.
    pub fn in_parent(self, degree: usize, child: usize, at: [usize; 3]) -> [usize; 3] {
        if self == Shape::Tetrahedron {
            let shares = [degree - at.iter().sum::<usize>(), at[0], at[1], at[2]];
            let sum = |i: usize| (0..4).map(|j| shares[j] * child_of_tetrahedron(child, j)[i]).sum();
            return [sum(1), sum(2), sum(3)];
        }
        let corner = |d: usize| (child >> d & 1) * degree;
        std::array::from_fn(|d| if self.is_turned(child) { corner(d) - at[d] } else { corner(d) + at[d] })
    }

    /// Reference coordinates in a refined cell of the point at `xi` of its child with number `child`.
    pub fn to_parent<const D: usize>(self, child: usize, xi: [f64; D]) -> [f64; D] {
        if self == Shape::Tetrahedron {
            let vertices: [[usize; 4]; 4] = std::array::from_fn(|j| child_of_tetrahedron(child, j));
            let first = 1.0 - xi.iter().sum::<f64>();
            let along = |d: usize| (0..D).map(|j| xi[j] * vertices[j + 1][d + 1] as f64).sum::<f64>();
            return std::array::from_fn(|d| 0.5 * (first * vertices[0][d + 1] as f64 + along(d)));
        }
        let corner = |d: usize| (child >> d & 1) as f64;
        std::array::from_fn(|d| {
            0.5 * if self.is_turned(child) { corner(d) - xi[d] } else { corner(d) + xi[d] }
        })
    }

    /// Whether child `place` of a refined cell has a part of facet `facet`; that is facet `facet` of the child, too.
    pub fn child_on_facet(self, place: usize, facet: usize) -> bool {
        match self {
            // The children at the vertices of the facet, and on tetrahedra one of those in the middle.
            Shape::Triangle => place < 3 && place != facet,
            Shape::Tetrahedron => {
                if place < 4 {
                    place != facet
                } else {
                    place - 4 == facet
                }
            }
            _ => place >> (facet / 2) & 1 == facet % 2,
        }
    }

    /// Whether node `node` of degree `degree` lies on facet `facet`.
    pub fn on_facet(self, degree: usize, node: usize, facet: usize) -> bool {
        let at = self.lattice(degree, node);
        match (self, facet) {
            (Shape::Triangle | Shape::Tetrahedron, 0) => at.iter().sum::<usize>() == degree,
            (Shape::Triangle | Shape::Tetrahedron, _) => at[facet - 1] == 0,
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
        if self.is_simplex() {
            let first = degree - at.iter().sum::<usize>();
            return [first].iter().chain(&at[..self.dim()]).map(|&w| w as u32).collect();
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
            Shape::Tetrahedron => [0.25; 3],
            Shape::Hexahedron => [0.5; 3],
        }
    }

    /// Outer normal of facet `facet`, as long as the facet is large in units of the facet of a rule with weights 1.
    pub fn facet_normal(self, facet: usize) -> [f64; 3] {
        let mut normal = [0.0; 3];
        match (self, facet) {
            (Shape::Triangle, 0) => normal = [1.0, 1.0, 0.0],
            (Shape::Triangle, _) => normal[facet - 1] = -1.0,
            (Shape::Tetrahedron, 0) => normal = [0.5; 3],
            (Shape::Tetrahedron, _) => normal[facet - 1] = -0.5,
            _ => normal[facet / 2] = if facet % 2 == 1 { 1.0 } else { -1.0 },
        }
        normal
    }

    /// How far `xi` lies outside of the reference cell; 0 inside.
    pub fn outside(self, xi: &[f64]) -> f64 {
        let sum: f64 = if self.is_simplex() { xi.iter().sum() } else { 0.0 };
        xi.iter().map(|s| (s - 1.0).max(-s)).fold((sum - 1.0).max(0.0), f64::max)
    }

    /// A point of the reference cell close to `xi`, itself if it lies inside.
    pub fn clamp<const D: usize>(self, xi: [f64; D]) -> [f64; D] {
        let inside = xi.map(|s| s.clamp(0.0, 1.0));
        let sum: f64 = inside.iter().sum();
        if self.is_simplex() && sum > 1.0 { inside.map(|s| s / sum) } else { inside }
    }
}

/// Barycentric coordinates, times two, of vertex `vertex` of a child of a tetrahedron.
///
/// Child `c < 4` stands at vertex c. The octahedron that they leave has a face in each face l of the parent; child
/// `4 + 4 diagonal + l` is the one with that face, which is its own face l, and with the end of the diagonal beyond it.
fn child_of_tetrahedron(child: usize, vertex: usize) -> [usize; 4] {
    let mut at = [0; 4];
    if child < 4 {
        at[child] += 1;
        at[vertex] += 1;
        return at;
    }
    let (diagonal, face) = ((child - 4) / 4, child % 4);
    if vertex == face {
        (at[face], at[face ^ (diagonal + 1)]) = (1, 1);
    } else {
        at = [1; 4];
        (at[face], at[vertex]) = (0, 0);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Shape; 4] = [Shape::Triangle, Shape::Quadrilateral, Shape::Tetrahedron, Shape::Hexahedron];

    /// Children fill the cell: their volumes are positive and equal, and their facets are parts of its facets.
    #[test]
    fn children_of_tetrahedra_are_eighths_for_every_diagonal() {
        let shape = Shape::Tetrahedron;
        for diagonal in 0..3 {
            for place in 0..8 {
                let child = shape.child_number(place, diagonal);
                let vertex = |i: usize| -> [f64; 3] {
                    shape.to_parent(child, std::array::from_fn(|d| if d + 1 == i { 1.0 } else { 0.0 }))
                };
                let [o, a, b, c] = [0, 1, 2, 3].map(vertex);
                let [a, b, c] = [a, b, c].map(|x| [x[0] - o[0], x[1] - o[1], x[2] - o[2]]);
                let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
                assert_eq!((0..3).map(|d| a[d] * cross[d]).sum::<f64>(), 0.125, "{place} {diagonal}");
                for facet in 0..4 {
                    let inside = |v: usize| {
                        let at = shape.in_parent(1, child, shape.lattice(1, v));
                        shape.on_facet(2, shape.number(2, at), facet)
                    };
                    let on = (0..4).filter(|v| *v != facet).all(inside);
                    assert_eq!(on, shape.child_on_facet(place, facet), "{place} {diagonal} {facet}");
                }
                for node in 0..shape.n_nodes(3) {
                    let at = shape.lattice(3, node);
                    let there = shape.to_parent(child, at.map(|i| i as f64 / 3.0));
                    let lattice = shape.in_parent(3, child, at).map(|i| i as f64 / 6.0);
                    assert!((0..3).all(|d| (there[d] - lattice[d]).abs() < 1e-15));
                }
            }
        }
    }

    /// Σ n = 0 over the facets of a closed surface, and Gauss: Σ n·x over the centres is the volume times the dimension.
    #[test]
    fn normals_close_the_surface() {
        for shape in ALL {
            let (mut sum, mut volume) = ([0.0; 3], 0.0);
            for facet in 0..shape.n_facets() {
                let n = shape.facet_normal(facet);
                let nodes = shape.facet_nodes(1, facet);
                for &node in &nodes {
                    let x = shape.lattice(1, node);
                    let flux: f64 = (0..3).map(|d| n[d] * x[d] as f64).sum();
                    volume += flux / nodes.len() as f64;
                }
                (0..3).for_each(|d| sum[d] += n[d]);
            }
            let exact = match shape {
                Shape::Triangle => 0.5,
                Shape::Tetrahedron => 1.0 / 6.0,
                _ => 1.0,
            };
            assert!(sum.iter().all(|s: &f64| s.abs() < 1e-15), "{shape:?}");
            assert!((volume - exact * shape.dim() as f64).abs() < 1e-15, "{shape:?} {volume}");
        }
    }

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
        let moved: [f64; 3] = Shape::Tetrahedron.clamp([0.7, 0.6, -0.2]);
        assert!(Shape::Tetrahedron.outside(&moved) < 1e-15 && moved[2] == 0.0);
    }
}
