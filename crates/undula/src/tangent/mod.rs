//! `A'(U)(W, ·)` of any form at a point: by dual numbers or by hand.
#![allow(non_snake_case)]

use crate::math::{Dual, Scalar, Vector};
use crate::physics::{
    FacetForm, Fields, Fluid, Outflow, Place, Solid, StepRule, Tested, WeakForm, theorem_5_2,
};

/// How derivatives are computed.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Tangent {
    /// Dual numbers at the quadrature point.
    Automatic,
    /// Theorem 5.2.
    Analytic,
}

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
pub fn automatic<S: Scalar<Value = S>, F: WeakForm<D>, const D: usize>(
    form: &F,
    rule: &StepRule,
    place: &Place<S, D>,
    new: &Fields<S, D>,
    old: &Fields<S, D>,
    W: &Fields<S, D>,
) -> Tested<S, D> {
    let new = seeded(new, W);
    let mut r = Tested::zero();
    rule.residual(form, place, &new, &new, old, &mut r);
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
}

impl<const D: usize> ByHand<D> for Solid {
    #[inline(always)]
    fn by_hand<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        _: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D> {
        theorem_5_2::solid(self, rule, new, old, W)
    }
}

/// Derivative of a facet term in direction `W` by one dual evaluation.
#[inline(always)]
pub fn automatic_facet<S: Scalar<Value = S>, F: FacetForm<D>, const D: usize>(
    form: &F,
    theta: f64,
    at: &Fields<S, D>,
    normal: &Vector<S, D>,
    W: &Fields<S, D>,
) -> Vector<S, D> {
    form.traction(&seeded(at, W), normal, theta).map(|x: Dual<S>| x.eps)
}

/// Derivative of the outflow term in direction `W`, either way.
#[inline(always)]
pub fn outflow<S: Scalar<Value = S>, const D: usize>(
    tangent: Tangent,
    form: &Outflow,
    theta: f64,
    at: &Fields<S, D>,
    normal: &Vector<S, D>,
    W: &Fields<S, D>,
) -> Vector<S, D> {
    match tangent {
        Tangent::Automatic => automatic_facet(form, theta, at, normal, W),
        Tangent::Analytic => theorem_5_2::outflow(form, theta, at, normal, W),
    }
}
