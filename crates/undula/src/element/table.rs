//! An element as numbers: basis functions at given points.

use super::quadrature::gauss;
use super::{Quadrature, Shape, lagrange};

/// Values and reference gradients of a nodal basis at the points of a rule.
#[derive(Clone, Debug)]
pub struct BasisTable {
    /// Number of basis functions.
    pub n_basis: usize,
    /// Number of points.
    pub n_points: usize,
    /// Space dimension.
    pub dim: usize,
    /// `[point][basis]`.
    pub value: Vec<f64>,
    /// `[point][basis][ξ_d]`.
    pub grad: Vec<f64>,
}

impl BasisTable {
    /// Q_k or P_k of `shape` at the points of `rule`.
    pub fn lagrange(shape: Shape, k: usize, rule: &Quadrature) -> BasisTable {
        let (dim, n_basis, n_points) = (shape.dim(), shape.n_nodes(k), rule.points.len());
        let (mut value, mut grad) = (vec![], vec![]);
        for point in &rule.points {
            let (v, g) = lagrange::basis(shape, k, point);
            value.extend(v);
            grad.extend(g.iter().flat_map(|g| g[..dim].to_vec()));
        }
        BasisTable { n_basis, n_points, dim, value, grad }
    }

    /// The same with the bubbles of `shape` behind, see [`lagrange::bubbles`].
    pub fn with_bubbles(&self, shape: Shape, rule: &Quadrature) -> BasisTable {
        let dim = self.dim;
        let (mut value, mut grad) = (vec![], vec![]);
        for (q, point) in rule.points.iter().enumerate() {
            let bubbles = lagrange::bubbles(shape, point);
            value.extend(self.value(q).iter().copied().chain(bubbles.iter().map(|(v, _)| *v)));
            grad.extend(self.grad(q));
            bubbles.iter().for_each(|(_, g)| grad.extend(&g[..dim]));
        }
        let n_basis = self.n_basis + lagrange::n_bubbles(shape);
        BasisTable { n_basis, n_points: self.n_points, dim, value, grad }
    }

    /// Values at point `q`, `[basis]`.
    #[inline(always)]
    pub fn value(&self, q: usize) -> &[f64] {
        &self.value[q * self.n_basis..(q + 1) * self.n_basis]
    }

    /// Gradients at point `q`, `[basis][ξ_d]` flattened.
    #[inline(always)]
    pub fn grad(&self, q: usize) -> &[f64] {
        let n = self.n_basis * self.dim;
        &self.grad[q * n..(q + 1) * n]
    }
}

/// The basis of degree k on `[0, 1]` at Gauss points: what a table of a tensor-product cell consists of,
/// φ_a(ξ_q) = Π_d φ_{a_d}(ξ_{q_d}), first coordinate fastest in a and in q.
#[derive(Clone, Debug)]
pub struct LineTable {
    /// Number of basis functions, k + 1.
    pub n_basis: usize,
    /// Number of points.
    pub n_points: usize,
    /// `[point][basis]`.
    pub value: Vec<f64>,
    /// `[point][basis]`.
    pub slope: Vec<f64>,
}

impl LineTable {
    /// Degree `k` at the points of the Gauss rule with `n_points` points, those of [`Quadrature::cell`].
    pub fn lagrange(k: usize, n_points: usize) -> LineTable {
        let (mut value, mut slope) = (vec![], vec![]);
        for x in gauss(n_points).0 {
            let (v, s) = lagrange::basis_1d(k, x);
            value.extend(v);
            slope.extend(s);
        }
        LineTable { n_basis: k + 1, n_points, value, slope }
    }
}
