//! How the two ends of a time step are weighed. A time scheme is a table of these rules.

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
/// Two Gauss points, exact to degree 3: in the plane for all terms along linear u and v but the viscous stress.
pub const GAUSS: &[(f64, f64)] = &[(0.5, 0.211_324_865_405_187_1), (0.5, 0.788_675_134_594_812_9)];
/// Three Gauss points, exact to degree 5: the same in space, where the cofactor is quadratic in u.
pub const GAUSS_IN_SPACE: &[(f64, f64)] = &[
    (5.0 / 18.0, 0.112_701_665_379_258_3),
    (8.0 / 18.0, 0.5),
    (5.0 / 18.0, 0.887_298_334_620_741_7),
];

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

    /// (weight, τ) of the points of a step that is integrated, in `D` dimensions; else none.
    #[inline(always)]
    pub fn gauss_points<const D: usize>(&self) -> &'static [(f64, f64)] {
        if D == 3 && !self.quadrature.is_empty() { GAUSS_IN_SPACE } else { self.quadrature }
    }

    /// (weight, τ) of transport, that of the explicit part left out.
    #[inline(always)]
    pub fn transport_points<const D: usize>(&self) -> impl Iterator<Item = (f64, f64)> {
        let theta = self.quadrature.is_empty().then_some((self.theta, 1.0));
        theta.into_iter().chain(self.gauss_points::<D>().iter().copied())
    }

    /// (weight, τ) of the factors of ∂_t.
    #[inline(always)]
    pub fn inertia_points<const D: usize>(&self) -> impl Iterator<Item = (f64, f64)> {
        let theta = self.theta;
        let integrated = self.gauss_points::<D>().iter().copied();
        self.inertia.iter().map(move |point| point.resolve(theta)).chain(integrated)
    }
}
