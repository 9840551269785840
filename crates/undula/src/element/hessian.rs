//! Second derivatives of nodal bases, and of their images on curved cells.

use super::{Shape, lagrange};
use crate::math::Tensor;

/// Second derivatives `[a][d][e]` = ∂²φ_a/∂ξ_d∂ξ_e of the basis of degree `k` at `xi`.
///
/// First derivatives of a complete space lie in it, so that they are their own interpolation:
/// ∂_e∂_d φ_a = Σ_b (∂_d φ_a)(ξ_b) ∂_e φ_b, for any shape.
pub fn hessians(shape: Shape, k: usize, xi: &[f64]) -> Vec<[[f64; 3]; 3]> {
    let (n, dim) = (shape.n_nodes(k), shape.dim());
    let here = lagrange::basis(shape, k, xi).1;
    let mut hessians = vec![[[0.0; 3]; 3]; n];
    for (b, slope) in here.iter().enumerate() {
        let there = lagrange::basis(shape, k, &lagrange::node(shape, k, b)).1;
        for (hessian, there) in hessians.iter_mut().zip(&there) {
            for d in 0..dim {
                for e in 0..dim {
                    hessian[d][e] += there[d] * slope[e];
                }
            }
        }
    }
    hessians
}

/// Second derivatives with respect to x of a function on a curved cell.
///
/// ∂²φ/∂x_i∂x_j = (∂²φ/∂ξ_a∂ξ_b − (∂φ/∂x_m) ∂²X_m/∂ξ_a∂ξ_b) (∂ξ_a/∂x_i) (∂ξ_b/∂x_j): the curvature of the map
/// is taken off before the derivatives are turned.
///
/// `slope` is ∇φ with respect to x, `reference` the second derivatives with respect to ξ, `inverse[a][i]` =
/// ∂ξ_a/∂x_i, `curvature[m][a][b]` = ∂²X_m/∂ξ_a∂ξ_b \[m\].
pub fn mapped<const D: usize>(
    slope: [f64; D],
    reference: &[[f64; 3]; 3],
    inverse: &Tensor<f64, D>,
    curvature: &[[[f64; D]; D]; D],
) -> Tensor<f64, D> {
    let mut straight = Tensor::zero();
    for a in 0..D {
        for b in 0..D {
            let bent: f64 = (0..D).map(|m| slope[m] * curvature[m][a][b]).sum();
            straight.0[a][b] = reference[a][b] - bent;
        }
    }
    inverse.t() * straight * *inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hessians_are_differences_of_gradients() {
        for shape in [Shape::Triangle, Shape::Quadrilateral, Shape::Tetrahedron, Shape::Hexahedron] {
            for k in 1..5 {
                let xi = [0.3, 0.41, 0.22];
                let exact = hessians(shape, k, &xi);
                for e in 0..shape.dim() {
                    let moved = |h: f64| {
                        let mut at = xi;
                        at[e] += h;
                        lagrange::basis(shape, k, &at).1
                    };
                    let (plus, minus) = (moved(1e-6), moved(-1e-6));
                    for a in 0..shape.n_nodes(k) {
                        for d in 0..shape.dim() {
                            let difference = (plus[a][d] - minus[a][d]) / 2e-6;
                            assert!((exact[a][d][e] - difference).abs() < 1e-6, "{shape:?} {k} {a}");
                        }
                    }
                }
            }
        }
    }
}
