//! Derivatives by differences of the residual at a point.
#![allow(non_snake_case)]

use super::StepForm;
use crate::choice::{Choice, choice};
use crate::math::{Scalar, Vector};
use crate::physics::{FacetForm, Fields, Place, StepRule, Tested};

/// (A(U + h W) − A(U)) / h or, central, (A(U + h W) − A(U − h W)) / 2h.
///
/// h is `epsilon` times the size of what moves: the largest velocity and pressure of the iterate, and for the
/// deformation such that ∇u moves by `epsilon`, since F = I + ∇u is of size 1. All terms are polynomials of
/// degree one in each component of v, ∇v, u and p alone, so that only ∇u has an error of truncation.
///
/// With [`Stencil::Nodal`] W is a basis function, and ∇u moves by at most `epsilon` at the points of the cell. With
/// [`Stencil::NodalAbsolute`] h is `epsilon`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Difference {
    /// What is subtracted.
    pub stencil: Stencil,
    /// Relative size of the perturbation, or its size.
    pub epsilon: f64,
    /// Sizes of the fields.
    pub sizes: Sizes,
}

/// Perturbation unless another is asked for: best in the study of section 5.2.3.
pub const EPSILON: f64 = 1e-6;

/// Which residuals are subtracted from each other.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Stencil {
    /// At a quadrature point, on one side.
    OneSided,
    /// At a quadrature point, on both sides: an error of h² instead of h, for a residual more.
    Central,
    /// Of a cell, on one side, for each of its unknowns: R_{v_i} = A(U + ε z_i)(Φ) and so on, section 5.2.3.
    Nodal,
    /// The same with h = `epsilon` in the units of the case, as the section has it, whatever the sizes of the fields.
    NodalAbsolute,
}

/// Their names in a case.
pub static DIFFERENCES: [Choice<Stencil>; 4] = [
    choice("one-sided", Stencil::OneSided, "(A(U + h W) − A(U)) / h at the quadrature points"),
    choice("central", Stencil::Central, "(A(U + h W) − A(U − h W)) / 2h at the quadrature points"),
    choice(
        "nodal",
        Stencil::Nodal,
        "(A(U + h W) − A(U)) / h, the residual of a cell anew for each of its unknowns W (slow)",
    ),
    choice("nodal-absolute", Stencil::NodalAbsolute, "`nodal` with h = `epsilon` in the units of the case"),
];

/// Sizes of the fields that perturbations are relative to.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Sizes {
    /// Velocity \[m/s\].
    pub v: f64,
    /// Deformation \[m\].
    pub u: f64,
    /// Pressure \[Pa\].
    pub p: f64,
}

impl Sizes {
    /// The largest values of \[v, u, p\], 1 where all are zero.
    pub fn of(fields: [&[f64]; 3]) -> Sizes {
        let [v, u, p] = fields.map(|x| x.iter().fold(0.0f64, |m, x| m.max(x.abs())));
        let or_one = |x: f64| if x > 0.0 && x.is_finite() { x } else { 1.0 };
        Sizes { v: or_one(v), u: or_one(u), p: or_one(p) }
    }
}

impl Difference {
    /// With the relative perturbation `epsilon` of fields of size 1.
    pub const fn new(stencil: Stencil, epsilon: f64) -> Difference {
        Difference { stencil, epsilon, sizes: Sizes { v: 1.0, u: 1.0, p: 1.0 } }
    }

    /// Whether both sides are taken.
    #[inline(always)]
    pub fn is_central(&self) -> bool {
        self.stencil == Stencil::Central
    }

    /// h of nodal values of \[v, u, p\] in a cell or on a facet with `gradients` of the basis functions at its points
    /// \[1/m\].
    pub fn steps<const D: usize>(&self, gradients: impl Iterator<Item = Vector<f64, D>>) -> [f64; 3] {
        match self.stencil {
            Stencil::NodalAbsolute => [self.epsilon; 3],
            _ => {
                let steepest = gradients.fold(0.0f64, |most, grad| most.max(grad.dot(grad))).sqrt();
                [self.sizes.v, 1.0 / steepest, self.sizes.p].map(|size| self.epsilon * size)
            }
        }
    }

    /// (A(U + h W) − A(U)) / h, central if so chosen; `base` is A(U). With `lagged` what a fixed-point
    /// iteration keeps does not move.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub fn derivative<S: Scalar<Value = S>, F: StepForm<D>, const D: usize>(
        &self,
        lagged: bool,
        form: &F,
        rule: &StepRule,
        place: &Place<S, D>,
        (new, old): (&Fields<S, D>, &Fields<S, D>),
        base: &Tested<S, D>,
        (W, h): (&Fields<S, D>, S),
    ) -> Tested<S, D> {
        let mut difference = Tested::zero();
        let ends = [h, -h];
        for &h in &ends[..if self.is_central() { 2 } else { 1 }] {
            let at = moved(new, W, h);
            let lag = if lagged { *new } else { at };
            let mut there = *place;
            there.force += there.force_slope * (lag.u - new.u);
            let mut r = Tested::zero();
            form.residual(rule, &there, &at, &lag, old, &mut r);
            add(&mut difference, &r, base, S::one() / h);
        }
        let weight = if self.is_central() { 0.5 } else { 1.0 };
        difference.map(|x| x * weight)
    }

    /// The same for a term on a facet, in a direction of ∇u or of v and ∂_t u.
    pub fn facet<F: FacetForm<D>, const D: usize>(
        &self,
        form: &F,
        theta: f64,
        at: &Fields<f64, D>,
        normal: &Vector<f64, D>,
        W: &Fields<f64, D>,
    ) -> Vector<f64, D> {
        let h = self.epsilon * if W.grad_u.ddot(W.grad_u) > 0.0 { 1.0 } else { self.sizes.v };
        let value = |h: f64| {
            let moved = moved(at, W, h);
            form.traction(&moved, &moved, normal, theta)
        };
        match self.is_central() {
            true => (value(h) - value(-h)) * (0.5 / h),
            false => (value(h) - value(0.0)) * (1.0 / h),
        }
    }
}

/// `U + h W`.
#[inline(always)]
fn moved<S: Scalar, const D: usize>(U: &Fields<S, D>, W: &Fields<S, D>, h: S) -> Fields<S, D> {
    Fields {
        v: U.v + W.v * h,
        grad_v: U.grad_v + W.grad_v * h,
        u: U.u + W.u * h,
        grad_u: U.grad_u + W.grad_u * h,
        p: U.p + W.p * h,
    }
}

/// `sum += factor (a − b)`.
#[inline(always)]
fn add<S: Scalar, const D: usize>(sum: &mut Tested<S, D>, a: &Tested<S, D>, b: &Tested<S, D>, factor: S) {
    sum.phi += (a.phi - b.phi) * factor;
    sum.grad_phi += (a.grad_phi - b.grad_phi) * factor;
    sum.psi += (a.psi - b.psi) * factor;
    sum.grad_psi += (a.grad_psi - b.grad_psi) * factor;
    sum.xi += (a.xi - b.xi) * factor;
}
