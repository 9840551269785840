//! One time step at one point: how its two ends are weighed.

use super::kinematics::cofactor;
use super::rule::{Moment, TimePoint};
use super::{Dots, Fields, Inertia, Place, StepRule, Tested, WeakForm};
use crate::math::{Scalar, Tensor, Vector};

/// (new − old)/k; no closure, since one that is called twice is compiled apart, for the baseline processor.
#[inline(always)]
fn difference<T: Scalar, const D: usize>(
    new: Vector<T, D>,
    old: Vector<T::Value, D>,
    per_k: f64,
) -> Vector<T, D> {
    (new - old.map(T::lift)) * T::constant(per_k)
}

impl StepRule {
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
            v: difference(new.v, old.v, self.per_k),
            u: difference(new.u, old.u, self.per_k),
            domain: difference(lag.u, old.u, self.per_k),
        };
        let (inertia, geometry) = if self.quadrature.is_empty() {
            form.transport(place, new, lag, self.theta, r);
            // The pressure is one multiplier per step and acts on the geometry of both ends; J p F⁻ᵀ at the
            // new time alone would be first order on a moving domain.
            let mut geometry = self.theta * cofactor(&lag.grad_u);
            geometry += ((1.0 - self.theta) * cofactor(&old.grad_u)).map(T::lift);
            (self.weighted_inertia(form, new, lag, old), geometry)
        } else {
            self.integrated(form, place, new, lag, old, r)
        };
        form.rate(&dots, &inertia, r);
        form.pressure(new.p, &geometry, r);
        form.constraint(&form.place(place, old), new, lag, r);
        form.volume(self, place, new, lag, old, r);
    }

    /// 1/k \[1/s\]; 1 if stationary.
    #[inline(always)]
    pub fn rate(&self) -> f64 {
        if self.per_k > 0.0 { self.per_k } else { 1.0 }
    }

    /// Factors of J − 1 and of J F⁻ᵀ : ∇v in the volume of an incompressible solid: 1/k \[1/s\] and 1 − θ.
    ///
    /// θ below ½ is the middle part of fractional-step θ. There J differs from 1 by k²(½ − θ) times a derivative of
    /// J, as u does from the solution, and v would take up 1/k times that. With (J − 1)/k + (1 − θ/2) J F⁻ᵀ : ∇v in
    /// the middle what the three parts leave in v cancels, to second order; divided by 1 + θ/2, so that all
    /// parts have one matrix still.
    #[inline(always)]
    pub fn volume(&self) -> (f64, f64) {
        if self.theta >= 0.5 {
            return (self.rate(), 1.0 - self.theta);
        }
        let flux = 1.0 - 0.5 * self.theta;
        let sum = self.theta + flux;
        (self.rate() / sum, flux / sum)
    }

    /// Factor 1/(θ² k) \[1/s\] of the volume of a nearly incompressible solid: parts of fractional-step θ have one
    /// matrix with it.
    #[inline(always)]
    pub fn compression(&self) -> f64 {
        self.rate() / (self.theta * self.theta)
    }

    /// Transport integrated over the step; returns the factors of ∂_t and J F⁻ᵀ integrated alike.
    #[inline(always)]
    fn integrated<T: Scalar, F: WeakForm<D>, const D: usize>(
        &self,
        form: &F,
        place: &Place<T::Value, D>,
        new: &Fields<T, D>,
        lag: &Fields<T, D>,
        old: &Fields<T::Value, D>,
        r: &mut Tested<T, D>,
    ) -> (Inertia<T, D>, Tensor<T, D>) {
        let old = Fields::lift(old);
        let mut sum = Inertia { mass: T::zero(), motion: Tensor::zero() };
        let mut geometry = Tensor::zero();
        for &(weight, tau) in self.gauss_points::<D>() {
            let (at, lag) = (old.lerp(new, tau), old.lerp(lag, tau));
            let part = form.inertia(&at, &lag);
            sum.mass += part.mass * weight;
            sum.motion += weight * part.motion;
            geometry += weight * cofactor(&lag.grad_u);
            form.transport(place, &at, &lag, weight, r);
        }
        (sum, geometry)
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
        let mut sum = Inertia { mass: T::zero(), motion: Tensor::zero() };
        for &TimePoint { share, at } in self.inertia {
            let (weight, part) = match at {
                // At the old time nothing depends on the unknowns: computed without derivatives.
                Moment::Old => {
                    let known = form.inertia(old, old);
                    let lifted = Inertia { mass: T::lift(known.mass), motion: known.motion.map(T::lift) };
                    (share * (1.0 - self.theta), lifted)
                }
                Moment::New => (share * self.theta, form.inertia(new, lag)),
                Moment::Between => {
                    let old = Fields::lift(old);
                    (share, form.inertia(&old.lerp(new, self.theta), &old.lerp(lag, self.theta)))
                }
            };
            sum.mass += part.mass * weight;
            sum.motion += weight * part.motion;
        }
        sum
    }
}
