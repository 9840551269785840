//! The map from the reference cell to a cell, `X(ξ) = Σ_i L_i(ξ) x_i`.

use super::{CellAt, CellList, LISTED, Mesh};
use crate::element::Shape;
use crate::math::rounded;

/// Lagrange basis of degree 1 or 2 on `[0, 1]` at `s`; unused entries zero.
pub(crate) fn lagrange(degree: usize, s: f64) -> [f64; 3] {
    match degree {
        1 => [1.0 - s, s, 0.0],
        _ => [(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)],
    }
}

/// Derivatives of [`lagrange`].
pub(crate) fn lagrange_slope(degree: usize, s: f64) -> [f64; 3] {
    match degree {
        1 => [-1.0, 1.0, 0.0],
        _ => [4.0 * s - 3.0, 4.0 - 8.0 * s, 4.0 * s - 1.0],
    }
}

/// Determinant by elimination with pivoting.
pub(crate) fn determinant<const D: usize>(mut a: [[f64; D]; D]) -> f64 {
    let mut det = 1.0;
    for k in 0..D {
        let pivot = (k..D).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        if a[pivot][k] == 0.0 {
            return 0.0;
        }
        if pivot != k {
            a.swap(pivot, k);
            det = -det;
        }
        det *= a[k][k];
        for i in k + 1..D {
            let factor = a[i][k] / a[k][k];
            for j in k..D {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    det
}

/// Euclidean distance of two points.
pub(crate) fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
}

/// Basis of degree 1 or 2 on a triangle with its derivatives, nodes in the order of [`Shape`]; unused entries zero.
fn triangle(degree: usize, [x, y]: [f64; 2]) -> [(f64, [f64; 2]); 6] {
    let z = 1.0 - x - y;
    if degree == 1 {
        let none = (0.0, [0.0; 2]);
        return [(z, [-1.0, -1.0]), (x, [1.0, 0.0]), (y, [0.0, 1.0]), none, none, none];
    }
    [
        (z * (2.0 * z - 1.0), [1.0 - 4.0 * z, 1.0 - 4.0 * z]),
        (4.0 * x * z, [4.0 * (z - x), -4.0 * x]),
        (x * (2.0 * x - 1.0), [4.0 * x - 1.0, 0.0]),
        (4.0 * y * z, [-4.0 * y, 4.0 * (z - y)]),
        (4.0 * x * y, [4.0 * y, 4.0 * x]),
        (y * (2.0 * y - 1.0), [0.0, 4.0 * y - 1.0]),
    ]
}

/// The same on a tetrahedron.
fn tetrahedron(degree: usize, xi: [f64; 3]) -> [(f64, [f64; 3]); 10] {
    let lambda = [1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]];
    let slope = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut basis = [(0.0, [0.0; 3]); 10];
    if degree == 1 {
        (0..4).for_each(|v| basis[v] = (lambda[v], slope[v]));
        return basis;
    }
    // Vertices of the nodes in the order of the shape; those between two vertices have both.
    const NODES: [[usize; 2]; 10] =
        [[0, 0], [0, 1], [1, 1], [0, 2], [1, 2], [2, 2], [0, 3], [1, 3], [2, 3], [3, 3]];
    for (entry, [v, w]) in basis.iter_mut().zip(NODES) {
        let grad = |d: usize| {
            if v == w {
                (4.0 * lambda[v] - 1.0) * slope[v][d]
            } else {
                4.0 * (lambda[v] * slope[w][d] + lambda[w] * slope[v][d])
            }
        };
        let value = if v == w { lambda[v] * (2.0 * lambda[v] - 1.0) } else { 4.0 * lambda[v] * lambda[w] };
        *entry = (value, [grad(0), grad(1), grad(2)]);
    }
    basis
}

impl<const D: usize> Mesh<D> {
    /// Image `X(ξ)` \[m\] of reference point `xi` in `cell`.
    pub fn map(&self, cell: usize, xi: [f64; D]) -> [f64; D] {
        if self.shape.is_simplex() {
            return self.map_simplex(cell, xi).0;
        }
        let basis = xi.map(|s| lagrange(self.degree, s));
        let mut x = [0.0; D];
        for (local, &node) in self.cell(cell).iter().enumerate() {
            let at = self.shape.lattice(self.degree, local);
            let weight: f64 = (0..D).map(|d| basis[d][at[d]]).product();
            for d in 0..D {
                x[d] += weight * self.nodes[node as usize][d];
            }
        }
        x
    }

    /// Gradient `DX(ξ)` \[m\] of the map, `[i][j] = ∂X_i/∂ξ_j`.
    pub fn map_gradient(&self, cell: usize, xi: [f64; D]) -> [[f64; D]; D] {
        if self.shape.is_simplex() {
            return self.map_simplex(cell, xi).1;
        }
        let basis = xi.map(|s| lagrange(self.degree, s));
        let slope = xi.map(|s| lagrange_slope(self.degree, s));
        let mut gradient = [[0.0; D]; D];
        for (local, &node) in self.cell(cell).iter().enumerate() {
            let at = self.shape.lattice(self.degree, local);
            for j in 0..D {
                let factor = |d: usize| if d == j { slope[d][at[d]] } else { basis[d][at[d]] };
                let weight: f64 = (0..D).map(factor).product();
                for i in 0..D {
                    gradient[i][j] += weight * self.nodes[node as usize][i];
                }
            }
        }
        gradient
    }

    /// What each node adds to DX at `xi`: `∂X_i/∂ξ_j = Σ_n w_nj x_ni`, for many cells at one point.
    pub(super) fn gradient_weights(&self, xi: [f64; D]) -> Vec<[f64; D]> {
        let n = self.shape.n_nodes(self.degree);
        if self.shape == Shape::Triangle {
            let slopes = triangle(self.degree, [xi[0], xi[1]]).into_iter().take(n);
            return slopes.map(|(_, slope)| std::array::from_fn(|d| slope[d])).collect();
        }
        if self.shape == Shape::Tetrahedron {
            let slopes = tetrahedron(self.degree, std::array::from_fn(|d| xi[d])).into_iter().take(n);
            return slopes.map(|(_, slope)| std::array::from_fn(|d| slope[d])).collect();
        }
        let basis = xi.map(|s| lagrange(self.degree, s));
        let slope = xi.map(|s| lagrange_slope(self.degree, s));
        let weights = (0..n).map(|local| {
            let at = self.shape.lattice(self.degree, local);
            let factor = |j: usize, d: usize| if d == j { slope[d][at[d]] } else { basis[d][at[d]] };
            std::array::from_fn(|j| (0..D).map(|d| factor(j, d)).product())
        });
        weights.collect()
    }

    /// DX of `cell` at the point of `weights`, to the bit what [`Mesh::map_gradient`] gives.
    pub(super) fn gradient_by(&self, cell: usize, weights: &[[f64; D]]) -> [[f64; D]; D] {
        let mut gradient = [[0.0; D]; D];
        for (&node, weights) in self.cell(cell).iter().zip(weights) {
            let x = self.nodes[node as usize];
            for i in 0..D {
                (0..D).for_each(|j| gradient[i][j] += weights[j] * x[i]);
            }
        }
        gradient
    }

    /// The map of a triangle or tetrahedron and its gradient.
    fn map_simplex(&self, cell: usize, xi: [f64; D]) -> ([f64; D], [[f64; D]; D]) {
        let (mut x, mut gradient) = ([0.0; D], [[0.0; D]; D]);
        if self.shape == Shape::Tetrahedron {
            let basis = tetrahedron(self.degree, std::array::from_fn(|d| xi[d]));
            for (&node, (value, slope)) in self.cell(cell).iter().zip(basis) {
                let at = self.nodes[node as usize];
                for i in 0..D {
                    x[i] += value * at[i];
                    gradient[i].iter_mut().zip(slope).for_each(|(g, s)| *g += s * at[i]);
                }
            }
            return (x, gradient);
        }
        for (&node, (value, slope)) in self.cell(cell).iter().zip(triangle(self.degree, [xi[0], xi[1]])) {
            let at = self.nodes[node as usize];
            for i in 0..D {
                x[i] += value * at[i];
                gradient[i].iter_mut().zip(slope).for_each(|(g, s)| *g += s * at[i]);
            }
        }
        (x, gradient)
    }

    /// Centre of the reference cell.
    pub(crate) fn reference_centre(&self) -> [f64; D] {
        std::array::from_fn(|d| self.shape.centre()[d])
    }

    /// Mean of the vertices of `cell` \[m\].
    pub fn centre(&self, cell: usize) -> [f64; D] {
        let vertices = self.cell_vertices(cell);
        let mut centre = [0.0; D];
        for &v in &vertices {
            for d in 0..D {
                centre[d] += self.nodes[v as usize][d] / vertices.len() as f64;
            }
        }
        centre
    }

    /// Nodes at the vertices of `cell`, in lexicographic order.
    pub fn cell_vertices(&self, cell: usize) -> Vec<u32> {
        let nodes = self.cell(cell);
        self.shape.vertices(self.degree).into_iter().map(|v| nodes[v]).collect()
    }

    /// Nodes on facet `local` of `cell`, in lexicographic order.
    pub fn facet_nodes(&self, cell: usize, local: usize) -> Vec<u32> {
        let nodes = self.cell(cell);
        self.shape.facet_nodes(self.degree, local).into_iter().map(|n| nodes[n]).collect()
    }

    /// Diagonal of the smallest box with axis-parallel sides around all nodes \[m\].
    pub fn diameter(&self) -> f64 {
        let (lower, upper) = bounds(self.nodes.iter().copied());
        if self.nodes.is_empty() { 0.0 } else { distance(lower, upper) }
    }

    /// Longest distance between two vertices of `cell` \[m\].
    pub fn cell_diameter(&self, cell: usize) -> f64 {
        let at: Vec<_> = self.cell_vertices(cell).iter().map(|&v| self.nodes[v as usize]).collect();
        at.iter().flat_map(|&a| at.iter().map(move |&b| distance(a, b))).fold(0.0, f64::max)
    }

    /// Distances of the centres of opposite facets of a cell \[m\], for quadrilaterals and hexahedra.
    pub(crate) fn sizes(&self, cell: usize) -> [f64; D] {
        std::array::from_fn(|d| {
            let at = |end: f64| self.map(cell, std::array::from_fn(|e| if e == d { end } else { 0.5 }));
            distance(at(0.0), at(1.0))
        })
    }

    /// The given cells as they appear in a message.
    pub(crate) fn list_cells(&self, cells: &[usize]) -> CellList {
        let size = self.diameter();
        let centre = |cell| self.centre(cell).iter().map(|&x| rounded(x, size, 6)).collect();
        let at = |&cell: &usize| CellAt { cell, centre: centre(cell) };
        CellList { first: cells.iter().take(LISTED).map(at).collect(), count: cells.len() }
    }
}

/// Smallest box with axis-parallel sides around `points`.
pub(crate) fn bounds<const D: usize>(points: impl Iterator<Item = [f64; D]>) -> ([f64; D], [f64; D]) {
    let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for x in points {
        for d in 0..D {
            lower[d] = lower[d].min(x[d]);
            upper[d] = upper[d].max(x[d]);
        }
    }
    (lower, upper)
}
