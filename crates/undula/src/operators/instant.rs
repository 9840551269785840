//! Fields at a point of a facet at a time within the step.

use super::StepView;
use crate::physics::Fields;
use crate::sampling::{FacetPoint, fields_at};
use crate::space::State;

/// v and u, or v and ∂_t u of the step, at (1 − τ) U⁻ + τ U.
pub(super) fn fields<const D: usize>(
    rate: bool,
    (nodes, point): (&[u32], &FacetPoint<D>),
    step: &StepView<'_>,
    tau: f64,
) -> Fields<f64, D> {
    let of = |state: &State| fields_at(nodes, &point.value, &point.grad, state);
    if rate {
        let (old, new) = (of(step.old), of(step.new));
        return Fields { u: step.rule.per_k * (new.u - old.u), ..old.lerp(&new, tau) };
    }
    if tau == 1.0 { of(step.new) } else { of(step.old).lerp(&of(step.new), tau) }
}

/// By how much circles around an axis are longer there than in the reference domain, (r + u_r)/r; 1 in the plane.
pub(super) fn stretch<const D: usize>(
    (nodes, point): (&[u32], &FacetPoint<D>),
    step: &StepView<'_>,
    tau: f64,
) -> f64 {
    if point.radius.is_none() {
        return 1.0;
    }
    point.stretch(&fields(false, (nodes, point), step, tau).u)
}
