//! What the loops over cells know of an equation: one step at a point.

use super::in_space::InSpace;
use super::one_lane::{add_lane, at_lane, place_at};
use super::{ByHand, in_space};
use crate::math::{Dual, Scalar, Tensor};
use crate::physics::axisymmetric::{self, Axisymmetric};
use crate::physics::{Couplings, Fields, Place, StepRule, Tested};

/// The residual of a step at a point, in the coordinates of the mesh, with its derivative by hand.
///
/// Every weak form is one; [`Axisymmetric`] makes one for the coordinates (r, z) of a form of space.
pub trait StepForm<const D: usize>: Sync {
    /// Whether places know the distance to an axis.
    const HAS_AXIS: bool;

    /// Blocks that are not zero.
    fn blocks(&self) -> Couplings;

    /// All terms of the step but the explicit part, added to `r`.
    fn residual<T: Scalar>(
        &self,
        rule: &StepRule,
        place: &Place<T::Value, D>,
        new: &Fields<T, D>,
        lag: &Fields<T, D>,
        old: &Fields<T::Value, D>,
        r: &mut Tested<T, D>,
    );

    /// The explicit part, added to `r`.
    fn explicit<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, D>,
        old: &Fields<S, D>,
        r: &mut Tested<S, D>,
    );

    /// A'(U)(W, ·).
    #[allow(non_snake_case)]
    fn analytic<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D>;

    /// What of it stands before ψ in the fluid, where `W` moves u alone: the extension, which the reduced Jacobian
    /// keeps.
    #[allow(non_snake_case)]
    fn extension<S: Scalar<Value = S>>(
        &self,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D>;

    /// J.
    fn volume_ratio<S: Scalar>(&self, place: &Place<S, D>, at: &Fields<S, D>) -> S;
}

impl<F: ByHand<D>, const D: usize> StepForm<D> for F {
    const HAS_AXIS: bool = false;

    fn blocks(&self) -> Couplings {
        self.couplings()
    }

    #[inline(always)]
    fn residual<T: Scalar>(
        &self,
        rule: &StepRule,
        place: &Place<T::Value, D>,
        new: &Fields<T, D>,
        lag: &Fields<T, D>,
        old: &Fields<T::Value, D>,
        r: &mut Tested<T, D>,
    ) {
        rule.residual(self, place, new, lag, old, r);
    }

    #[inline(always)]
    fn explicit<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, D>,
        old: &Fields<S, D>,
        r: &mut Tested<S, D>,
    ) {
        rule.explicit(self, place, old, r);
    }

    #[inline(always)]
    fn analytic<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D> {
        self.by_hand(rule, place, new, old, W)
    }

    #[inline(always)]
    fn extension<S: Scalar<Value = S>>(
        &self,
        place: &Place<S, D>,
        new: &Fields<S, D>,
        old: &Fields<S, D>,
        W: &Fields<S, D>,
    ) -> Tested<S, D> {
        Tested { grad_psi: self.extension_by_hand(place, new, old, W), ..Tested::zero() }
    }

    #[inline(always)]
    fn volume_ratio<S: Scalar>(&self, _: &Place<S, D>, at: &Fields<S, D>) -> S {
        (Tensor::identity() + at.grad_u).det()
    }
}

impl<F: ByHand<3>> StepForm<3> for InSpace<F> {
    const HAS_AXIS: bool = false;

    fn blocks(&self) -> Couplings {
        self.0.couplings()
    }

    #[inline(always)]
    fn residual<T: Scalar>(
        &self,
        rule: &StepRule,
        place: &Place<T::Value, 3>,
        new: &Fields<T, 3>,
        lag: &Fields<T, 3>,
        old: &Fields<T::Value, 3>,
        r: &mut Tested<T, 3>,
    ) {
        in_space::residual(&self.0, rule, place, [new, lag], old, r);
    }

    #[inline(always)]
    fn explicit<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, 3>,
        old: &Fields<S, 3>,
        r: &mut Tested<S, 3>,
    ) {
        in_space::explicit(&self.0, rule, place, old, r);
    }

    #[allow(non_snake_case)]
    #[inline(always)]
    fn analytic<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, 3>,
        new: &Fields<S, 3>,
        old: &Fields<S, 3>,
        W: &Fields<S, 3>,
    ) -> Tested<S, 3> {
        in_space::analytic(&self.0, rule, place, [new, old], W)
    }

    #[allow(non_snake_case)]
    #[inline(always)]
    fn extension<S: Scalar<Value = S>>(
        &self,
        place: &Place<S, 3>,
        new: &Fields<S, 3>,
        old: &Fields<S, 3>,
        W: &Fields<S, 3>,
    ) -> Tested<S, 3> {
        Tested { grad_psi: self.0.extension_by_hand(place, new, old, W), ..Tested::zero() }
    }

    #[inline(always)]
    fn volume_ratio<S: Scalar>(&self, _: &Place<S, 3>, at: &Fields<S, 3>) -> S {
        (Tensor::identity() + at.grad_u).det()
    }
}

/// Evaluated cell by cell, out of line: compiled in all lanes, every equation of space would cost minutes.
impl<F: ByHand<3>> StepForm<2> for Axisymmetric<F> {
    const HAS_AXIS: bool = true;

    fn blocks(&self) -> Couplings {
        axisymmetric::couplings(self.0.couplings())
    }

    #[inline(always)]
    fn residual<T: Scalar>(
        &self,
        rule: &StepRule,
        place: &Place<T::Value, 2>,
        new: &Fields<T, 2>,
        lag: &Fields<T, 2>,
        old: &Fields<T::Value, 2>,
        r: &mut Tested<T, 2>,
    ) {
        let has_slope = size_of::<T>() > size_of::<T::Value>();
        for lane in 0..T::LANES {
            let (place, old) = (place_at(place, lane), at_lane::<_, f64, 2>(old, lane));
            if has_slope {
                let (new, lag) = (at_lane(new, lane), at_lane(lag, lane));
                add_lane(&around::<F, Dual<f64>>(&self.0, rule, &place, [&new, &lag], &old), lane, r);
            } else {
                let (new, lag) = (at_lane(new, lane), at_lane(lag, lane));
                add_lane(&around::<F, f64>(&self.0, rule, &place, [&new, &lag], &old), lane, r);
            }
        }
    }

    #[inline(always)]
    fn explicit<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, 2>,
        old: &Fields<S, 2>,
        r: &mut Tested<S, 2>,
    ) {
        for lane in 0..S::LANES {
            let (place, old) = (place_at(place, lane), at_lane::<_, f64, 2>(old, lane));
            add_lane(&explicit_around(&self.0, rule, &place, &old), lane, r);
        }
    }

    #[inline(always)]
    fn analytic<S: Scalar<Value = S>>(
        &self,
        rule: &StepRule,
        place: &Place<S, 2>,
        new: &Fields<S, 2>,
        old: &Fields<S, 2>,
        W: &Fields<S, 2>,
    ) -> Tested<S, 2> {
        let mut r = Tested::zero();
        for lane in 0..S::LANES {
            let (place, direction) = (place_at(place, lane), at_lane(W, lane));
            let ends = [&at_lane(new, lane), &at_lane(old, lane)];
            add_lane(&by_hand_around(&self.0, rule, &place, ends, &direction), lane, &mut r);
        }
        r
    }

    #[inline(always)]
    fn extension<S: Scalar<Value = S>>(
        &self,
        place: &Place<S, 2>,
        new: &Fields<S, 2>,
        old: &Fields<S, 2>,
        W: &Fields<S, 2>,
    ) -> Tested<S, 2> {
        let per_radius = place.per_radius;
        let in_space = |at| axisymmetric::fields(at, per_radius);
        let (place, new, old) = (axisymmetric::place(place), in_space(new), in_space(old));
        let grad_psi = self.0.extension_by_hand(&place, &new, &old, &in_space(W));
        let mut r = Tested::zero();
        axisymmetric::add_tested(&Tested { grad_psi, ..Tested::zero() }, per_radius, &mut r);
        r
    }

    #[inline(always)]
    fn volume_ratio<S: Scalar>(&self, place: &Place<S, 2>, at: &Fields<S, 2>) -> S {
        let in_plane = (Tensor::identity() + at.grad_u).det();
        in_plane * (S::one() + at.u.0[0] * place.per_radius)
    }
}

/// The residual in space; the fields are those of the new time and what a fixed-point iteration keeps.
#[inline(never)]
fn around<F: ByHand<3>, N: Scalar<Value = f64>>(
    form: &F,
    rule: &StepRule,
    place: &Place<f64, 2>,
    [new, lag]: [&Fields<N, 2>; 2],
    old: &Fields<f64, 2>,
) -> Tested<N, 2> {
    let per_radius = place.per_radius;
    let (new, lag) = (axisymmetric::fields(new, per_radius), axisymmetric::fields(lag, per_radius));
    let (old, mut of, mut r) = (axisymmetric::fields(old, per_radius), Tested::zero(), Tested::zero());
    in_space::residual(form, rule, &axisymmetric::place(place), [&new, &lag], &old, &mut of);
    axisymmetric::add_tested(&of, per_radius, &mut r);
    r
}

#[inline(never)]
fn explicit_around<F: ByHand<3>>(
    form: &F,
    rule: &StepRule,
    place: &Place<f64, 2>,
    old: &Fields<f64, 2>,
) -> Tested<f64, 2> {
    let (mut of, mut r) = (Tested::zero(), Tested::zero());
    let old = axisymmetric::fields(old, place.per_radius);
    in_space::explicit(form, rule, &axisymmetric::place(place), &old, &mut of);
    axisymmetric::add_tested(&of, place.per_radius, &mut r);
    r
}

#[inline(never)]
fn by_hand_around<F: ByHand<3>>(
    form: &F,
    rule: &StepRule,
    place: &Place<f64, 2>,
    [new, old]: [&Fields<f64, 2>; 2],
    direction: &Fields<f64, 2>,
) -> Tested<f64, 2> {
    let per_radius = place.per_radius;
    let (new, old) = (axisymmetric::fields(new, per_radius), axisymmetric::fields(old, per_radius));
    let (direction, mut r) = (axisymmetric::fields(direction, per_radius), Tested::zero());
    let of = in_space::analytic(form, rule, &axisymmetric::place(place), [&new, &old], &direction);
    axisymmetric::add_tested(&of, per_radius, &mut r);
    r
}
