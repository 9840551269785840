//! E and B: from global vectors to fields at a point, and back by Bᵀ.

use super::scatter::{DROP, Shared};
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::physics::Tested;

/// Geometry and data of one quadrature point in `L` cells, fixed for the run.
#[derive(Copy, Clone, Debug)]
pub struct Point<const D: usize, const L: usize> {
    /// ∂ξ_d/∂x_j \[1/m\].
    pub inverse: Tensor<Lanes<L>, D>,
    /// Quadrature weight times |det ∂x/∂ξ| \[m^D\], times 2π r in (r, z); zero in padded lanes.
    pub weight: Lanes<L>,
    /// Stiffness E_e of the extension.
    pub stiffness: Lanes<L>,
}

/// A vector field at a point, or what stands before a test function: value and reference gradient.
#[derive(Copy, Clone, Debug)]
pub struct AtPoint<const D: usize, const L: usize> {
    /// Value.
    pub value: Vector<Lanes<L>, D>,
    /// Derivatives with respect to ξ.
    pub grad: Tensor<Lanes<L>, D>,
}

impl<const D: usize, const L: usize> AtPoint<D, L> {
    /// Value and gradient with respect to x.
    #[inline(always)]
    pub fn mapped(&self, inverse: &Tensor<Lanes<L>, D>) -> (Vector<Lanes<L>, D>, Tensor<Lanes<L>, D>) {
        (self.value, self.grad * *inverse)
    }

    /// The value as part 0, the derivative with respect to ξ_d as part d = 1, …, D.
    #[inline(always)]
    pub fn part(&self, part: usize) -> Vector<Lanes<L>, D> {
        if part == 0 {
            return self.value;
        }
        let mut x = Vector::zero();
        for i in 0..D {
            x.0[i] = self.grad.0[i][part - 1];
        }
        x
    }

    /// Set [`AtPoint::part`].
    #[inline(always)]
    pub fn set(&mut self, part: usize, x: Vector<Lanes<L>, D>) {
        if part == 0 {
            self.value = x;
            return;
        }
        for i in 0..D {
            self.grad.0[i][part - 1] = x.0[i];
        }
    }
}

/// Coefficients of the nodes of `L` cells: `out[a][i]` from `x[node · D + i]`.
#[inline(always)]
pub fn gather<const D: usize, const L: usize>(
    nodes: &[[u32; L]],
    x: &[f64],
    out: &mut [Vector<Lanes<L>, D>],
) {
    for (lanes, c) in nodes.iter().zip(out) {
        for l in 0..L {
            let at = lanes[l] as usize * D;
            for i in 0..D {
                c.0[i].0[l] = x[at + i];
            }
        }
    }
}

/// Coefficients of scalar unknowns: `out[a]` from `x[dof]`.
#[inline(always)]
pub fn gather_scalar<const L: usize>(dofs: &[[u32; L]], x: &[f64], out: &mut [Lanes<L>]) {
    for (lanes, c) in dofs.iter().zip(out) {
        for l in 0..L {
            c.0[l] = x[lanes[l] as usize];
        }
    }
}

/// Value and gradient with respect to x of `Σ c_a φ_a`; `basis` is `[a][1 + D]` at the point.
#[inline(always)]
pub fn interpolate<const D: usize, const L: usize>(
    basis: &[f64],
    c: &[Vector<Lanes<L>, D>],
    inverse: &Tensor<Lanes<L>, D>,
) -> (Vector<Lanes<L>, D>, Tensor<Lanes<L>, D>) {
    let mut value = Vector::<Lanes<L>, D>::zero();
    let mut reference = Tensor::<Lanes<L>, D>::zero();
    for (c, b) in c.iter().zip(basis.chunks_exact(1 + D)) {
        for i in 0..D {
            value.0[i].add_product(b[0], c.0[i]);
            for d in 0..D {
                reference.0[i][d].add_product(b[1 + d], c.0[i]);
            }
        }
    }
    (value, reference * *inverse)
}

/// `Σ c_a q_a` with one value per lane for each basis function.
#[inline(always)]
pub fn interpolate_scalar<const L: usize>(basis: &[Lanes<L>], c: &[Lanes<L>]) -> Lanes<L> {
    let mut value = Lanes::<L>::zero();
    for (b, c) in basis.iter().zip(c) {
        value.add_product_lanes(*b, *c);
    }
    value
}

/// What stands before the test functions, pulled back to the reference cell and weighted:
/// gradients become those with respect to ξ.
#[inline(always)]
pub fn pull_back<const D: usize, const L: usize>(
    t: &Tested<Lanes<L>, D>,
    point: &Point<D, L>,
) -> Tested<Lanes<L>, D> {
    let w = point.weight;
    let inverse_t = point.inverse.t();
    Tested {
        phi: t.phi * w,
        grad_phi: (t.grad_phi * inverse_t) * w,
        psi: t.psi * w,
        grad_psi: (t.grad_psi * inverse_t) * w,
        xi: t.xi * w,
    }
}

/// `r[a] += (value, φ_a) + (grad, ∇φ_a)` for all basis functions of a vector space.
#[inline(always)]
pub fn test<const D: usize, const L: usize>(
    basis: &[f64],
    value: &Vector<Lanes<L>, D>,
    grad: &Tensor<Lanes<L>, D>,
    r: &mut [Vector<Lanes<L>, D>],
) {
    for (r, b) in r.iter_mut().zip(basis.chunks_exact(1 + D)) {
        for i in 0..D {
            r.0[i].add_product(b[0], value.0[i]);
            for d in 0..D {
                r.0[i].add_product(b[1 + d], grad.0[i][d]);
            }
        }
    }
}

/// Add element vectors to the global one; `rows[a]` is the first row of basis function a or [`DROP`].
#[inline(always)]
pub fn scatter<const D: usize, const L: usize>(
    rows: &[[u32; L]],
    r: &[Vector<Lanes<L>, D>],
    active: usize,
    out: &Shared<'_>,
) {
    for (rows, r) in rows.iter().zip(r) {
        for l in 0..active {
            if rows[l] != DROP {
                for i in 0..D {
                    out.add(rows[l] + i as u32, r.0[i].0[l]);
                }
            }
        }
    }
}
