//! One time step at one point: how its two ends are weighed.

use super::kinematics::cofactor;
use super::{Dots, Fields, Inertia, Place, Tested, WeakForm};
use crate::math::{Scalar, Tensor, Vector};

/// Weights of a step. A time scheme is a table of these.
///
/// With `per_k = 0`, `theta = 1` the step is the stationary problem. A multistep formula is a step with θ = 1
/// whose old state is the combination of the old ones that it takes the difference from.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StepRule {
    /// 1/k, what multiplies the difference of new and old \[1/s\].
    pub per_k: f64,
    /// θ: weight of the new time in transport, 1 − θ that of the old.
    pub theta: f64,
    /// Where in the step the factors of ∂_t are taken.
    pub inertia: &'static [TimePoint],
    /// (weight, τ) at (1 − τ) U⁻ + τ U: cG(1), all terms but those that hold at the new time integrated by
    /// this rule. Empty: a θ-scheme. Then `inertia` is empty and `theta` ½, which is what
    /// ∂_t u = v comes to.
    pub quadrature: &'static [(f64, f64)],
}

/// A time in the products of ∂_t with J and G(u, v) = J ∇v F⁻¹, section 5.1.2.1.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TimePoint {
    /// What the weight of the moment is multiplied by.
    pub share: f64,
    /// When.
    pub at: Moment,
}

/// A moment of a step, with its weight.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Moment {
    /// The old time, 1 − θ.
    Old,
    /// The new time, θ.
    New,
    /// (1 − θ) U⁻ + θ U, 1.
    Between,
}

const fn point(share: f64, at: Moment) -> TimePoint {
    TimePoint { share, at }
}

/// Secant form: (1 − θ) G(u⁻, v⁻) + θ G(u, v). All three are fully implicit for θ = 1.
pub const SECANT: &[TimePoint] = &[point(1.0, Moment::Old), point(1.0, Moment::New)];
/// Midpoint tangent: G at (1 − θ) U⁻ + θ U.
pub const MIDPOINT: &[TimePoint] = &[point(1.0, Moment::Between)];
/// Galerkin form, ⅙ G(u⁻, v⁻) + ⅔ G(ū, v̄) + ⅙ G(u, v) for θ = ½: a third of the secant form and two of the
/// midpoint tangent, which keeps the order for any θ.
pub const GALERKIN: &[TimePoint] =
    &[point(1.0 / 3.0, Moment::Old), point(2.0 / 3.0, Moment::Between), point(1.0 / 3.0, Moment::New)];
/// Two Gauss points, exact to degree 3: in 2D for all terms along linear u and v but the viscous stress.
pub const GAUSS: &[(f64, f64)] = &[(0.5, 0.211_324_865_405_187_1), (0.5, 0.788_675_134_594_812_9)];

/// (new − old)/k; no closure, since one that is called twice is compiled apart, for the baseline processor.
#[inline(always)]
fn difference<T: Scalar, const D: usize>(
    new: Vector<T, D>,
    old: Vector<T::Value, D>,
    per_k: f64,
) -> Vector<T, D> {
    (new - old.map(T::lift)) * T::constant(per_k)
}

impl TimePoint {
    /// Weight and τ, the point being (1 − τ) U⁻ + τ U.
    #[inline(always)]
    pub fn resolve(&self, theta: f64) -> (f64, f64) {
        match self.at {
            Moment::Old => (self.share * (1.0 - theta), 0.0),
            Moment::New => (self.share * theta, 1.0),
            Moment::Between => (self.share, theta),
        }
    }
}

impl StepRule {
    /// The stationary problem.
    pub const STATIONARY: StepRule = StepRule { per_k: 0.0, theta: 1.0, inertia: SECANT, quadrature: &[] };

    /// A θ-step of length `k` \[s\] with the secant domain-motion term.
    pub fn theta(k: f64, theta: f64) -> StepRule {
        StepRule { per_k: 1.0 / k, theta, inertia: SECANT, quadrature: &[] }
    }

    /// A step of length `k` \[s\] of cG(1): linear trial functions, constant test functions.
    pub fn galerkin(k: f64) -> StepRule {
        StepRule { per_k: 1.0 / k, theta: 0.5, inertia: &[], quadrature: GAUSS }
    }

    /// Whether the old time has a part of its own, [`StepRule::explicit`].
    pub fn has_explicit(&self) -> bool {
        self.theta < 1.0 && self.quadrature.is_empty()
    }

    /// (weight, τ) of transport, that of the explicit part left out.
    #[inline(always)]
    pub fn transport_points(&self) -> impl Iterator<Item = (f64, f64)> {
        let theta = self.quadrature.is_empty().then_some((self.theta, 1.0));
        theta.into_iter().chain(self.quadrature.iter().copied())
    }

    /// (weight, τ) of the factors of ∂_t.
    #[inline(always)]
    pub fn inertia_points(&self) -> impl Iterator<Item = (f64, f64)> {
        let theta = self.theta;
        self.inertia.iter().map(move |point| point.resolve(theta)).chain(self.quadrature.iter().copied())
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
        form.volume(self, new, lag, old, r);
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
        for &(weight, tau) in self.quadrature {
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
