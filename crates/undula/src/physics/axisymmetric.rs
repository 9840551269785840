//! Bodies of revolution in the coordinates (r, z).
//!
//! Nothing depends on the angle, and nothing moves around the axis: v = (v_r, v_z), u = (u_r, u_z). In the basis
//! (e_r, e_z, e_θ) of space the gradient of such a field has one entry besides those of the plane,
//! ```text
//!          ( ∂_r v_r  ∂_z v_r    0    )
//!     ∇v = ( ∂_r v_z  ∂_z v_z    0    ),        (A, ∇φ) = Σ A_ij ∂_j φ_i + A_θθ φ_r / r,
//!          (    0        0     v_r/r  )
//! ```
//! and volumes have the weight 2π r. So an equation of space, evaluated with these tensors, is that of the body of
//! revolution: every law, every motion of the mesh and every derivative is the one that holds in space.

use super::form::Block;
use super::{Couplings, Fabric, FacetForm, Fields, Place, Tested};
use crate::math::{Scalar, Tensor, Vector};

/// An equation of space for a body of revolution.
#[derive(Copy, Clone, Debug)]
pub struct Axisymmetric<F>(pub F);

/// (x_r, x_z, 0).
#[inline(always)]
pub fn vector<T: Scalar, const D: usize>(x: &Vector<T, D>) -> Vector<T, 3> {
    let mut out = Vector::zero();
    for i in 0..D {
        out.0[i] = x.0[i];
    }
    out
}

/// The entries of a tensor of the plane, `hoop` at θθ, 0 elsewhere.
#[inline(always)]
fn tensor<T: Scalar, const D: usize>(x: &Tensor<T, D>, hoop: T) -> Tensor<T, 3> {
    let mut out = Tensor::zero();
    for i in 0..D {
        for j in 0..D {
            out.0[i][j] = x.0[i][j];
        }
    }
    out.0[2][2] = hoop;
    out
}

/// The fields in space at the distance r from the axis, where `per_radius` is 1/r \[1/m\].
#[inline(always)]
pub fn fields<T: Scalar, const D: usize>(at: &Fields<T, D>, per_radius: T::Value) -> Fields<T, 3> {
    let per_radius = T::lift(per_radius);
    Fields {
        v: vector(&at.v),
        grad_v: tensor(&at.grad_v, at.v.0[0] * per_radius),
        u: vector(&at.u),
        grad_u: tensor(&at.grad_u, at.u.0[0] * per_radius),
        p: at.p,
    }
}

/// The same at any distance r ≥ 0 \[m\]; on the axis v_r/r is ∂_r v_r.
pub fn fields_at<const D: usize>(at: &Fields<f64, D>, r: f64) -> Fields<f64, 3> {
    if r > 0.0 {
        return fields(at, 1.0 / r);
    }
    let mut out = fields(at, 0.0);
    (out.grad_v.0[2][2], out.grad_u.0[2][2]) = (at.grad_v.0[0][0], at.grad_u.0[0][0]);
    out
}

/// What a point of the plane knows, for the equation of space.
#[inline(always)]
pub fn place<S: Scalar, const D: usize>(place: &Place<S, D>) -> Place<S, 3> {
    Place {
        force: vector(&place.force),
        force_slope: tensor(&place.force_slope, S::zero()),
        stiffness: place.stiffness,
        per_radius: place.per_radius,
        fabric: fabric(&place.fabric),
    }
}

/// What a solid has at a point of the plane, for the equation of space.
#[inline(always)]
pub fn fabric<S: Scalar, const D: usize>(of: &Fabric<S, D>) -> Fabric<S, 3> {
    Fabric { fibre: vector(&of.fibre), unloading: tensor(&of.unloading, of.hoop), hoop: S::zero() }
}

/// Add what stands before the test functions of the plane: A_θθ stands before φ_r / r.
#[inline(always)]
pub fn add_tested<T: Scalar, const D: usize>(of: &Tested<T, 3>, per_radius: T::Value, r: &mut Tested<T, D>) {
    let per_radius = T::lift(per_radius);
    for i in 0..D {
        r.phi.0[i] += of.phi.0[i];
        r.psi.0[i] += of.psi.0[i];
        for j in 0..D {
            r.grad_phi.0[i][j] += of.grad_phi.0[i][j];
            r.grad_psi.0[i][j] += of.grad_psi.0[i][j];
        }
    }
    r.phi.0[0] += of.grad_phi.0[2][2] * per_radius;
    r.psi.0[0] += of.grad_psi.0[2][2] * per_radius;
    r.xi += of.xi;
}

/// Where gradients take part, values do, too.
pub fn couplings(of: Couplings) -> Couplings {
    let full = |block| if block == Block::Stiffness { Block::Full } else { block };
    Couplings {
        phi_v: full(of.phi_v),
        phi_u: full(of.phi_u),
        pressure: full(of.pressure),
        xi_v: full(of.xi_v),
        xi_p: of.xi_p,
        psi_v: full(of.psi_v),
        psi_u: full(of.psi_u),
    }
}

/// A term on facets as the points see it: that of the plane, or at the distance r from an axis that of space.
pub struct Seen<F> {
    /// The term.
    pub form: F,
    /// r \[m\], above 0; `None` in the plane.
    pub radius: Option<f64>,
}

impl<F: FacetForm<D> + FacetForm<3>, const D: usize> FacetForm<D> for Seen<F> {
    #[inline(always)]
    fn traction<T: Scalar>(
        &self,
        at: &Fields<T, D>,
        lag: &Fields<T, D>,
        normal: &Vector<T::Value, D>,
        weight: f64,
    ) -> Vector<T, D> {
        let Some(r) = self.radius else {
            return FacetForm::<D>::traction(&self.form, at, lag, normal, weight);
        };
        let per_radius = T::Value::constant(1.0 / r);
        let (at, lag) = (fields(at, per_radius), fields(lag, per_radius));
        plane(&FacetForm::<3>::traction(&self.form, &at, &lag, &vector(normal), weight))
    }
}

/// The components along e_r and e_z.
#[inline(always)]
pub fn plane<T: Scalar, const D: usize>(x: &Vector<T, 3>) -> Vector<T, D> {
    let mut out = Vector::zero();
    for i in 0..D {
        out.0[i] = x.0[i];
    }
    out
}
