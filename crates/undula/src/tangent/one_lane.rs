//! The numbers in one lane, and back.

use crate::math::Scalar;
use crate::physics::{Fields, Place, Tested};

#[inline(always)]
fn number<T: Scalar, N: Scalar>(x: T, lane: usize) -> N {
    let mut one = N::zero();
    one.set_lane(0, x.lane(lane));
    one
}

/// The fields in one lane.
#[inline(always)]
pub(super) fn at_lane<T: Scalar, N: Scalar, const D: usize>(at: &Fields<T, D>, lane: usize) -> Fields<N, D> {
    at.map(|x| number(x, lane))
}

/// The data in one lane.
#[inline(always)]
pub(super) fn place_at<S: Scalar, const D: usize>(place: &Place<S, D>, lane: usize) -> Place<f64, D> {
    place.map(|x| number(x, lane))
}

/// Add what stands before the test functions in one lane.
#[inline(always)]
pub(super) fn add_lane<T: Scalar, N: Scalar, const D: usize>(
    one: &Tested<N, D>,
    lane: usize,
    r: &mut Tested<T, D>,
) {
    let one = one.map(|x| {
        let mut all = T::zero();
        all.set_lane(lane, x.lane(0));
        all
    });
    r.phi += one.phi;
    r.grad_phi += one.grad_phi;
    r.psi += one.psi;
    r.grad_psi += one.grad_psi;
    r.xi += one.xi;
}
