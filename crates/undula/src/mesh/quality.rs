//! Shape of the cells: orientation, scaled Jacobian, volume.

use super::Mesh;
use super::geometry::determinant;
use crate::element::{Quadrature, Shape, lagrange};

/// Three-point Gauss rule on `[0, 1]`: points and weights.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Shape of the cells of a mesh.
#[derive(Clone, Debug)]
pub struct Quality {
    /// Smallest `det DX / Π_j |∂X/∂ξ_j|` of each cell over its geometry nodes and Gauss points: 1 for a
    /// rectangle, 0 for a degenerate cell. Of triangles that for all pairs of edges, times 2/√3, of tetrahedra that for
    /// the three edges at each vertex, times √2: 1 for a regular one.
    pub scaled_jacobian: Vec<f64>,
    /// Area or volume of each cell \[m^D\].
    pub volume: Vec<f64>,
    /// Cells with `det DX <= 0` at one of these points; [`Mesh::check_orientation`] looks between them, too.
    pub inverted: Vec<usize>,
}

impl Quality {
    /// Smallest scaled Jacobian; 1 for a mesh without cells.
    pub fn min_scaled_jacobian(&self) -> f64 {
        self.scaled_jacobian.iter().copied().fold(1.0, f64::min)
    }

    /// Area or volume of the mesh \[m^D\].
    pub fn total_volume(&self) -> f64 {
        self.volume.iter().sum()
    }
}

impl<const D: usize> Mesh<D> {
    /// Measures all cells.
    pub fn quality(&self) -> Quality {
        let mut points: Vec<([f64; D], f64)> = match self.shape {
            Shape::Triangle | Shape::Tetrahedron => {
                let rule = Quadrature::cell(self.shape, 3);
                let at = |x: &[f64; 3]| std::array::from_fn(|d| x[d]);
                rule.points.iter().map(at).zip(rule.weights).collect()
            }
            _ => (0..3_usize.pow(D as u32))
                .map(|i| {
                    let at: [usize; D] = std::array::from_fn(|d| i / 3_usize.pow(d as u32) % 3);
                    (at.map(|k| GAUSS[k].0), at.iter().map(|&k| GAUSS[k].1).product())
                })
                .collect(),
        };
        points.extend((0..self.shape.n_nodes(self.degree)).map(|n| {
            let at = lagrange::node(self.shape, self.degree, n);
            (std::array::from_fn(|d| at[d]), 0.0)
        }));
        let points: Vec<_> = points.into_iter().map(|(xi, w)| (self.gradient_weights(xi), w)).collect();
        let mut quality = Quality { scaled_jacobian: vec![], volume: vec![], inverted: vec![] };
        for cell in 0..self.n_cells() {
            let (mut worst, mut volume) = (f64::INFINITY, 0.0);
            for (weights, weight) in &points {
                let gradient = self.gradient_by(cell, weights);
                let det = determinant(gradient);
                worst = worst.min(scaled(self.shape, gradient, det));
                volume += weight * det;
            }
            if worst <= 0.0 {
                quality.inverted.push(cell);
            }
            quality.scaled_jacobian.push(worst);
            quality.volume.push(volume);
        }
        quality
    }

    /// Renumbers cells whose nodes run clockwise so that they run counter-clockwise; returns how many.
    pub fn turn_clockwise_cells(&mut self) -> usize {
        let n = self.shape.n_nodes(self.degree);
        // The node with the first two coordinates exchanged.
        let turned: Vec<usize> = (0..n)
            .map(|i| {
                let [x, y, z] = self.shape.lattice(self.degree, i);
                self.shape.number(self.degree, [y, x, z])
            })
            .collect();
        let centre = self.reference_centre();
        let clockwise: Vec<usize> =
            (0..self.n_cells()).filter(|&c| determinant(self.map_gradient(c, centre)) < 0.0).collect();
        for &cell in &clockwise {
            let nodes = self.cell(cell).to_vec();
            turned.iter().enumerate().for_each(|(i, &j)| self.cell_nodes[cell * n + i] = nodes[j]);
            let facets = self.facets.iter_mut().chain(&mut self.parts);
            for facet in facets.filter(|f| f.cell as usize == cell) {
                facet.local = match (self.shape, facet.local) {
                    (Shape::Triangle | Shape::Tetrahedron, 1) => 2,
                    (Shape::Triangle | Shape::Tetrahedron, 2) => 1,
                    (Shape::Quadrilateral | Shape::Hexahedron, local @ 0..4) => local ^ 2,
                    (_, local) => local,
                };
            }
        }
        clockwise.len()
    }
}

/// `det DX / Π_j |∂X/∂ξ_j|`; 0 where a column vanishes. On triangles the smallest of that for the three pairs of
/// edges, times 2/√3; on tetrahedra of that for the edges at the four vertices, times √2.
fn scaled<const D: usize>(shape: Shape, gradient: [[f64; D]; D], det: f64) -> f64 {
    let column = |j: usize| (0..D).map(|i| gradient[i][j].powi(2)).sum::<f64>().sqrt();
    let mut product: f64 = (0..D).map(column).product();
    let mut factor = 1.0;
    if shape == Shape::Triangle {
        let third = (0..D).map(|i| (gradient[i][1] - gradient[i][0]).powi(2)).sum::<f64>().sqrt();
        product = product.max(column(0) * third).max(column(1) * third);
        factor = 2.0 / 3f64.sqrt();
    }
    if shape == Shape::Tetrahedron {
        let between = |j: usize, k: usize| {
            (0..D).map(|i| (gradient[i][k] - gradient[i][j]).powi(2)).sum::<f64>().sqrt()
        };
        for j in 0..D {
            let others = (0..D).filter(|&k| k != j).map(|k| between(j, k));
            product = product.max(column(j) * others.product::<f64>());
        }
        factor = 2f64.sqrt();
    }
    if product > 0.0 { factor * det / product } else { 0.0 }
}
