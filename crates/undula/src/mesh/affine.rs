//! Cells whose map is close to an affine one.

use super::Mesh;
use crate::element::Shape;
use crate::math::Tensor;

impl<const D: usize> Mesh<D> {
    /// Whether det DX > 0 in all of `cell` because DX is nowhere far from its value A in the middle: det A > 0, and
    /// A⁻¹ DX − 1 is below 1 in the norm of row sums. Column j of DX lies between differences of the Bernstein
    /// coefficients of X along ξ_j; of a tetrahedron of degree 2 DX is linear, and furthest from A at a vertex. `false`
    /// says nothing, and is the answer for triangles.
    pub(super) fn is_nearly_affine(&self, cell: usize) -> bool {
        if self.shape == Shape::Triangle {
            return false;
        }
        let middle = Tensor(self.map_gradient(cell, self.reference_centre()));
        let (det, cofactor) = (middle.det(), middle.cofactor());
        if det.is_nan() || det <= 0.0 {
            return false;
        }
        if self.shape == Shape::Tetrahedron {
            return self.degree == 1 || self.is_nearly_affine_at_vertices(cell, &cofactor, det);
        }
        let n = self.degree + 1;
        let points = self.bernstein_points(cell);
        let mut rows = [0.0; D];
        for axis in 0..D {
            let stride = n.pow(axis as u32);
            let mut largest = [0.0_f64; D];
            for i in (0..points.len()).filter(|i| i / stride % n + 1 < n) {
                let difference = |d: usize| self.degree as f64 * (points[i + stride][d] - points[i][d]);
                for (row, largest) in largest.iter_mut().enumerate() {
                    let value = (0..D).map(|d| cofactor.0[d][row] * difference(d)).sum::<f64>() / det;
                    *largest = largest.max((value - f64::from(u8::from(row == axis))).abs());
                }
            }
            rows.iter_mut().zip(largest).for_each(|(row, largest)| *row += largest);
        }
        rows.iter().all(|row| *row < 1.0 - 1e-9)
    }

    /// Whether A⁻¹ DX − 1 is below 1 at all vertices of a tetrahedron, A⁻¹ being `cofactor`ᵀ/`det`.
    fn is_nearly_affine_at_vertices(&self, cell: usize, cofactor: &Tensor<f64, D>, det: f64) -> bool {
        (0..=D).all(|vertex| {
            let xi = std::array::from_fn(|d| if d + 1 == vertex { 1.0 } else { 0.0 });
            let gradient = self.map_gradient(cell, xi);
            let entry = |row: usize, axis: usize| {
                let value = (0..D).map(|d| cofactor.0[d][row] * gradient[d][axis]).sum::<f64>() / det;
                (value - f64::from(u8::from(row == axis))).abs()
            };
            (0..D).all(|row| (0..D).map(|axis| entry(row, axis)).sum::<f64>() < 1.0 - 1e-9)
        })
    }

    /// Bernstein coefficients of the map of a tensor-product cell, in the order of its nodes.
    fn bernstein_points(&self, cell: usize) -> Vec<[f64; D]> {
        let mut points: Vec<_> = self.cell(cell).iter().map(|&n| self.nodes[n as usize]).collect();
        if self.degree == 1 {
            return points;
        }
        for stride in (0..D as u32).map(|axis| 3_usize.pow(axis)) {
            for i in (0..points.len()).filter(|i| i / stride % 3 == 1) {
                let (before, after) = (points[i - stride], points[i + stride]);
                (0..D).for_each(|d| points[i][d] = 2.0 * points[i][d] - 0.5 * (before[d] + after[d]));
            }
        }
        points
    }
}
