//! The equations of space at a point, in functions of their own.
//!
//! Each is compiled once for a width and a kind of number, whoever asks for it: inlined into every loop, the equations of
//! space would take minutes to compile. Where a lane is alone its numbers are plain ones, which have these functions
//! anyway.

use super::ByHand;
use super::one_lane::{add_lane, at_lane, place_at};
use crate::math::apart::Task;
use crate::math::{Dual, Scalar};
use crate::physics::{Fields, Place, StepRule, Tested};

/// A form of space whose terms are evaluated out of line.
pub struct InSpace<F>(pub F);

/// [`StepRule::residual`].
struct Residual<'a, F, T: Scalar> {
    form: &'a F,
    rule: &'a StepRule,
    place: &'a Place<T::Value, 3>,
    new: &'a Fields<T, 3>,
    lag: &'a Fields<T, 3>,
    old: &'a Fields<T::Value, 3>,
    r: &'a mut Tested<T, 3>,
}

impl<F: ByHand<3>, T: Scalar> Task for Residual<'_, F, T> {
    #[inline(always)]
    fn run(self) {
        self.rule.residual(self.form, self.place, self.new, self.lag, self.old, self.r);
    }
}

/// [`StepRule::explicit`].
struct Explicit<'a, F, S> {
    form: &'a F,
    rule: &'a StepRule,
    place: &'a Place<S, 3>,
    old: &'a Fields<S, 3>,
    r: &'a mut Tested<S, 3>,
}

impl<F: ByHand<3>, S: Scalar<Value = S>> Task for Explicit<'_, F, S> {
    #[inline(always)]
    fn run(self) {
        self.rule.explicit(self.form, self.place, self.old, self.r);
    }
}

/// [`ByHand::by_hand`].
struct Analytic<'a, F, S> {
    form: &'a F,
    rule: &'a StepRule,
    place: &'a Place<S, 3>,
    ends: [&'a Fields<S, 3>; 2],
    direction: &'a Fields<S, 3>,
    r: &'a mut Tested<S, 3>,
}

impl<F: ByHand<3>, S: Scalar<Value = S>> Task for Analytic<'_, F, S> {
    #[inline(always)]
    fn run(self) {
        let [new, old] = self.ends;
        *self.r = self.form.by_hand(self.rule, self.place, new, old, self.direction);
    }
}

/// All terms of the step but the explicit part, added to `r`.
#[inline(always)]
pub(super) fn residual<F: ByHand<3>, T: Scalar>(
    form: &F,
    rule: &StepRule,
    place: &Place<T::Value, 3>,
    [new, lag]: [&Fields<T, 3>; 2],
    old: &Fields<T::Value, 3>,
    r: &mut Tested<T, 3>,
) {
    if const { T::LANES > 1 } {
        T::apart(Residual { form, rule, place, new, lag, old, r });
    } else if const { size_of::<T>() > size_of::<T::Value>() } {
        residual_of_numbers::<F, T, Dual<f64>>(form, rule, place, [new, lag], old, r);
    } else {
        residual_of_numbers::<F, T, f64>(form, rule, place, [new, lag], old, r);
    }
}

/// The same in the only lane, whose number is an `N`.
#[inline(always)]
fn residual_of_numbers<F: ByHand<3>, T: Scalar, N: Scalar<Value = f64>>(
    form: &F,
    rule: &StepRule,
    place: &Place<T::Value, 3>,
    [new, lag]: [&Fields<T, 3>; 2],
    old: &Fields<T::Value, 3>,
    r: &mut Tested<T, 3>,
) {
    let (place, new, lag, old) = (&place_at(place, 0), &at_lane(new, 0), &at_lane(lag, 0), &at_lane(old, 0));
    let mut one = Tested::<N, 3>::zero();
    N::apart(Residual { form, rule, place, new, lag, old, r: &mut one });
    add_lane(&one, 0, r);
}

/// The explicit part, added to `r`.
#[inline(always)]
pub(super) fn explicit<F: ByHand<3>, S: Scalar<Value = S>>(
    form: &F,
    rule: &StepRule,
    place: &Place<S, 3>,
    old: &Fields<S, 3>,
    r: &mut Tested<S, 3>,
) {
    if const { S::LANES > 1 } {
        return S::apart(Explicit { form, rule, place, old, r });
    }
    let (place, old) = (&place_at(place, 0), &at_lane(old, 0));
    let mut one = Tested::<f64, 3>::zero();
    f64::apart(Explicit { form, rule, place, old, r: &mut one });
    add_lane(&one, 0, r);
}

/// A'(U)(W, ·) by hand.
#[inline(always)]
pub(super) fn analytic<F: ByHand<3>, S: Scalar<Value = S>>(
    form: &F,
    rule: &StepRule,
    place: &Place<S, 3>,
    ends: [&Fields<S, 3>; 2],
    direction: &Fields<S, 3>,
) -> Tested<S, 3> {
    let mut r = Tested::zero();
    S::apart(Analytic { form, rule, place, ends, direction, r: &mut r });
    r
}
