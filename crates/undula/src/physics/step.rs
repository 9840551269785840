//! One time step at one point: how its two ends are weighed.

use super::kinematics::cofactor;
use super::{Dots, Fields, Inertia, Place, Tested, WeakForm};
use crate::math::Scalar;

/// Weights of a one-step scheme. A time scheme is a table of these.
///
/// With `per_k = 0`, `theta = 1` the step is the stationary problem.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StepRule {
    /// 1/k \[1/s\].
    pub per_k: f64,
    /// θ: weight of the new time in transport, 1 − θ that of the old.
    pub theta: f64,
    /// Where in the step the factors of ∂_t are taken: (weight, τ) with τ = 0 the old, 1 the new time.
    pub inertia: &'static [TimePoint],
}

/// Weight of a time in the products of ∂_t with J and G(u, v) = J ∇v F⁻¹, section 5.1.2.1.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum TimePoint {
    /// The old time with weight 1 − θ.
    Old,
    /// The new time with weight θ.
    New,
    /// A fixed weight at (1 − τ) U⁻ + τ U.
    At {
        /// Weight.
        weight: f64,
        /// τ in \[0, 1\].
        tau: f64,
    },
}

/// Secant form: (1 − θ) G(u⁻, v⁻) + θ G(u, v). Fully implicit for θ = 1.
pub const SECANT: &[TimePoint] = &[TimePoint::Old, TimePoint::New];

impl StepRule {
    /// The stationary problem.
    pub const STATIONARY: StepRule = StepRule { per_k: 0.0, theta: 1.0, inertia: SECANT };

    /// A θ-step of length `k` \[s\] with the secant domain-motion term.
    pub fn theta(k: f64, theta: f64) -> StepRule {
        StepRule { per_k: 1.0 / k, theta, inertia: SECANT }
    }

    /// All terms of the step but the explicit part, added to `r`.
    #[inline(always)]
    pub fn residual<T: Scalar, F: WeakForm<D>, const D: usize>(
        &self,
        form: &F,
        place: &Place<T::Value, D>,
        new: &Fields<T, D>,
        lag: &Fields<T, D>,
        old: &Fields<T::Value, D>,
        r: &mut Tested<T, D>,
    ) {
        let dots = Dots {
            v: (new.v - old.v.map(T::lift)) * T::constant(self.per_k),
            u: (lag.u - old.u.map(T::lift)) * T::constant(self.per_k),
        };
        form.rate(&dots, &self.weighted_inertia(form, new, lag, old), r);
        form.transport(place, new, lag, self.theta, r);
        // The pressure is one multiplier per step and acts on the geometry of both ends; J p F⁻ᵀ at the
        // new time alone would be first order on a moving domain.
        let mut geometry = self.theta * cofactor(&lag.grad_u);
        geometry += ((1.0 - self.theta) * cofactor(&old.grad_u)).map(T::lift);
        form.pressure(new.p, &geometry, r);
        form.constraint(&form.place(place, old), new, lag, r);
        form.volume(self, new, lag, old, r);
    }

    /// 1/k \[1/s\]; 1 if stationary.
    #[inline(always)]
    pub fn rate(&self) -> f64 {
        if self.per_k > 0.0 { self.per_k } else { 1.0 }
    }

    /// The explicit part: transport at the old time with weight 1 − θ, added to `r`.
    #[inline(always)]
    pub fn explicit<S: Scalar<Value = S>, F: WeakForm<D>, const D: usize>(
        &self,
        form: &F,
        place_old: &Place<S, D>,
        old: &Fields<S, D>,
        r: &mut Tested<S, D>,
    ) {
        form.transport(place_old, old, old, 1.0 - self.theta, r);
    }

    #[inline(always)]
    fn weighted_inertia<T: Scalar, F: WeakForm<D>, const D: usize>(
        &self,
        form: &F,
        new: &Fields<T, D>,
        lag: &Fields<T, D>,
        old: &Fields<T::Value, D>,
    ) -> Inertia<T, D> {
        let mut sum = Inertia { mass: T::zero(), motion: crate::math::Tensor::zero() };
        for &point in self.inertia {
            let (weight, part) = match point {
                // At the old time nothing depends on the unknowns: computed without derivatives.
                TimePoint::Old => {
                    let known = form.inertia(old, old);
                    let lifted = Inertia { mass: T::lift(known.mass), motion: known.motion.map(T::lift) };
                    (1.0 - self.theta, lifted)
                }
                TimePoint::New => (self.theta, form.inertia(new, lag)),
                TimePoint::At { weight, tau } => {
                    let old = Fields::lift(old);
                    (weight, form.inertia(&old.lerp(new, tau), &old.lerp(lag, tau)))
                }
            };
            sum.mass += part.mass * weight;
            sum.motion += weight * part.motion;
        }
        sum
    }
}
