//! `A'(U)(W, ·)` of any form at a point: by dual numbers, by hand or by differences.
#![allow(non_snake_case)]

mod difference;
mod in_space;
mod one_lane;
mod step_form;

pub use difference::{DIFFERENCES, Difference, EPSILON, Sizes, Stencil};
pub use in_space::InSpace;
pub use step_form::StepForm;

use crate::choice::{Choice, choice};
use crate::math::{Dual, Scalar, Tensor, Vector};
use crate::physics::axisymmetric::{self, Seen};
use crate::physics::{
    Backflow, FacetForm, Fields, Fluid, Outflow, Place, Pressure, Reference, Solid, Spring, StepRule, Tested,
    WeakForm, theorem_5_2,
};

/// Which derivatives the matrix of an iteration holds; the residual is always that of the whole problem.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Linearization {
    /// All with respect to v, u and p: Newton's method, Theorem 5.2.
    Newton,
    /// All but those of the flow, momentum and divergence, with respect to u: the reduced Jacobian of section
    /// 5.2.3.
    Reduced,
    /// Of the equations of section 5.2.1, which are linear in the new iterate: the domain map, the transport
    /// velocity and one factor of the strain are those of the last.
    FixedPoint,
    /// (v, p) with δu = kθ δv in the solid and the extension afterwards, else as reduced (Failer and Richter,
    /// 2020).
    Condensed,
}

/// Their names in a case.
pub static LINEARIZATIONS: [Choice<Linearization>; 4] = [
    choice("newton", Linearization::Newton, "full Jacobian of v, u and p"),
    choice("reduced", Linearization::Reduced, "without the derivatives of the flow with respect to u"),
    choice(
        "fixed-point",
        Linearization::FixedPoint,
        "domain map, transport velocity and one factor of the strain lagged",
    ),
    choice(
        "condensed",
        Linearization::Condensed,
        "system of v and p; u by δu = kθ δv, the extension afterwards",
    ),
];

/// How derivatives are computed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Tangent {
    /// Dual numbers at the quadrature point.
    Automatic,
    /// Theorem 5.2.
    Analytic,
    /// Differences of the residual, at the quadrature point or of a cell.
    Difference(Difference),
}

impl Tangent {
    /// The differences, if they are those of the residuals of cells.
    pub fn nodal(&self) -> Option<&Difference> {
        match self {
            Tangent::Difference(by) if matches!(by.stencil, Stencil::Nodal | Stencil::NodalAbsolute) => {
                Some(by)
            }
            _ => None,
        }
    }
}

/// Their names in a case.
pub static TANGENTS: [Choice<Tangent>; 3] = [
    choice("automatic", Tangent::Automatic, "dual numbers at the quadrature points"),
    choice("analytic", Tangent::Analytic, "by hand, Theorem 5.2"),
    choice(
        "finite-difference",
        Tangent::Difference(Difference::new(Stencil::OneSided, EPSILON)),
        "differences of the residual",
    ),
];

/// `U + ε W` as dual numbers.
#[inline(always)]
pub fn seeded<S: Scalar<Value = S>, const D: usize>(
    at: &Fields<S, D>,
    W: &Fields<S, D>,
) -> Fields<Dual<S>, D> {
    let mut dual = Fields::zero();
    let (mut re, mut eps) = (*at, *W);
    for n in 0..Fields::<S, D>::COMPONENTS {
        *dual.component(n) = Dual { re: *re.component(n), eps: *eps.component(n) };
    }
    dual
}

/// Exact derivative of the step's residual in direction `W` by one dual evaluation.
#[inline(always)]
pub fn automatic<S: Scalar<Value = S>, F: StepForm<D>, const D: usize>(
    form: &F,
    rule: &StepRule,
    place: &Place<S, D>,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
) -> Tested<S, D> {
    let new = seeded(new, W);
    let mut r = Tested::zero();
    form.residual(rule, place, &new, &new, old, &mut r);
    r.map(|x| x.eps)
}

/// Derivative in direction `W` of what a fixed-point iteration solves, section 5.2.1: the geometry, the
/// transport velocity and one factor of the strain stay those of `new`.
#[inline(always)]
pub fn fixed_point<S: Scalar<Value = S>, F: StepForm<D>, const D: usize>(
    form: &F,
    rule: &StepRule,
    place: &Place<S, D>,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
) -> Tested<S, D> {
    let at = seeded(new, W);
    let mut r = Tested::zero();
    form.residual(rule, place, &at, &at.frozen(), old, &mut r);
    r.map(|x| x.eps)
}

/// A form whose derivative is also known by hand.
pub trait ByHand<const D: usize>: WeakForm<D> {
    /// A'(U)(W, ·).
    fn by_hand<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D>;

    /// What stands before ∇ψ there, if `W` moves u alone: the extension; 0 outside of the fluid.
    fn extension_by_hand<S: Scalar<Value = S>>(
        &self,
        _place: &Place<S, D>,
        _new: &Fields<S, D>,
        _old: &Fields<S, D>,
        _W: &Fields<S, D>,
    ) -> Tensor<S, D> {
        Tensor::zero()
    }
}

impl<const D: usize> ByHand<D> for Fluid {
    #[inline(always)]
    fn by_hand<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D> {
        theorem_5_2::fluid(self, rule, place, new, old, W)
    }

    #[inline(always)]
    fn extension_by_hand<S: Scalar<Value = S>>(
        &self,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tensor<S, D> {
        theorem_5_2::extension(self, place, new, old, W)
    }
}

impl<const D: usize> ByHand<D> for Solid {
    #[inline(always)]
    fn by_hand<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D> {
        // Of the inverse problem nothing is written by hand.
        if self.reference == Reference::Sought {
            return automatic(self, rule, place, new, old, W);
        }
        theorem_5_2::solid(self, rule, place, new, old, W)
    }
}

/// A term on facets whose derivative is also known by hand.
pub trait FacetByHand<const D: usize>: FacetForm<D> {
    /// Derivative of the traction in direction `W`.
    fn by_hand(
        &self,
        weight: f64,
        at: &Fields<f64, D>,
        normal: &Vector<f64, D>,
        W: &Fields<f64, D>,
    ) -> Vector<f64, D>;
}

/// Implements [`FacetByHand`] by a function of [`theorem_5_2`].
macro_rules! by_hand {
    ($form:ty, $function:path) => {
        impl<const D: usize> FacetByHand<D> for $form {
            #[inline(always)]
            fn by_hand(
                &self,
                weight: f64,
                at: &Fields<f64, D>,
                normal: &Vector<f64, D>,
                W: &Fields<f64, D>,
            ) -> Vector<f64, D> {
                $function(self, weight, at, normal, W)
            }
        }
    };
}

impl<F: FacetByHand<D> + FacetByHand<3>, const D: usize> FacetByHand<D> for Seen<F> {
    #[inline(always)]
    fn by_hand(
        &self,
        weight: f64,
        at: &Fields<f64, D>,
        normal: &Vector<f64, D>,
        W: &Fields<f64, D>,
    ) -> Vector<f64, D> {
        let Some(r) = self.radius else {
            return FacetByHand::<D>::by_hand(&self.form, weight, at, normal, W);
        };
        let fields = |of| axisymmetric::fields(of, 1.0 / r);
        let normal = axisymmetric::vector(normal);
        axisymmetric::plane(&FacetByHand::<3>::by_hand(&self.form, weight, &fields(at), &normal, &fields(W)))
    }
}

by_hand!(Outflow, theorem_5_2::outflow);
by_hand!(Backflow, theorem_5_2::backflow);
by_hand!(Pressure, theorem_5_2::pressure_load);
by_hand!(Spring, theorem_5_2::spring);

/// Derivative of a facet term in direction `W` by one dual evaluation.
#[inline(always)]
pub fn automatic_facet<S: Scalar<Value = S>, F: FacetForm<D>, const D: usize>(
    form: &F,
    weight: f64,
    at: &Fields<S, D>,
    normal: &Vector<S, D>,
    W: &Fields<S, D>,
) -> Vector<S, D> {
    let moved = seeded(at, W);
    form.traction(&moved, &moved, normal, weight).map(|x: Dual<S>| x.eps)
}

/// Derivative of a facet term in direction `W`, whichever way; `lagged`: what a fixed-point iteration keeps stays that of
/// `at`.
#[inline(always)]
pub fn facet<F: FacetByHand<D>, const D: usize>(
    (tangent, lagged): (Tangent, bool),
    form: &F,
    weight: f64,
    at: &Fields<f64, D>,
    normal: &Vector<f64, D>,
    W: &Fields<f64, D>,
) -> Vector<f64, D> {
    if lagged {
        let moved = seeded(at, W);
        return form.traction(&moved, &moved.frozen(), normal, weight).map(|x: Dual<f64>| x.eps);
    }
    match tangent {
        Tangent::Automatic => automatic_facet(form, weight, at, normal, W),
        Tangent::Analytic => form.by_hand(weight, at, normal, W),
        Tangent::Difference(by) => by.facet(form, weight, at, normal, W),
    }
}
