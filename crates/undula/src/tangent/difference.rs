//! Derivatives by differences of the residual at a point.
#![allow(non_snake_case)]

use crate::choice::{Choice, choice};
use crate::math::{Scalar, Vector};
use crate::physics::{FacetForm, Fields, Place, StepRule, Tested, WeakForm};

/// (A(U + h W) − A(U)) / h or, central, (A(U + h W) − A(U − h W)) / 2h at a quadrature point.
///
/// h is `epsilon` times the size of what moves: the largest velocity and pressure of the iterate, and for the
/// deformation such that ∇u moves by `epsilon`, since F = I + ∇u is of size 1. All terms are polynomials of
/// degree one in each component of v, ∇v, u and p alone, so that only ∇u has an error of truncation.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Difference {
    /// Both sides: an error of h² instead of h, for a residual more.
    pub central: bool,
    /// Relative size of the perturbation.
    pub epsilon: f64,
    /// Sizes of the fields.
    pub sizes: Sizes,
}

/// Perturbation unless another is asked for: best in the study of section 5.2.3.
pub const EPSILON: f64 = 1e-6;

/// Whether differences are central, by the names in a case.
pub static DIFFERENCES: [Choice<bool>; 2] = [
    choice("one-sided", false, "(A(U + h W) − A(U)) / h"),
    choice("central", true, "(A(U + h W) − A(U − h W)) / 2h"),
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
    pub const fn new(central: bool, epsilon: f64) -> Difference {
        Difference { central, epsilon, sizes: Sizes { v: 1.0, u: 1.0, p: 1.0 } }
    }

    /// (A(U + h W) − A(U)) / h, central if so chosen; `base` is A(U). With `lagged` what a fixed-point
    /// iteration keeps does not move.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub fn derivative<S: Scalar<Value = S>, F: WeakForm<D>, const D: usize>(
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
        for &h in &ends[..if self.central { 2 } else { 1 }] {
            let at = moved(new, W, h);
            let lag = if lagged { *new } else { at };
            let mut there = *place;
            there.force += there.force_slope * (lag.u - new.u);
            let mut r = Tested::zero();
            rule.residual(form, &there, &at, &lag, old, &mut r);
            add(&mut difference, &r, base, S::one() / h);
        }
        let weight = if self.central { 0.5 } else { 1.0 };
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
        let value = |h: f64| form.traction(&moved(at, W, h), normal, theta);
        match self.central {
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
