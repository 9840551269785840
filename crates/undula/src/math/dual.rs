//! Forward-mode automatic differentiation.

use super::Scalar;
use super::apart::Task;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `re + eps·ε` with `ε² = 0`: a value and its derivative in one direction.
///
/// One direction per pass: more directions at once gained nothing and cost registers.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Dual<S> {
    /// Value.
    pub re: S,
    /// Derivative.
    pub eps: S,
}

impl<S: Scalar> Add for Dual<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Dual { re: self.re + o.re, eps: self.eps + o.eps }
    }
}

impl<S: Scalar> Sub for Dual<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Dual { re: self.re - o.re, eps: self.eps - o.eps }
    }
}

impl<S: Scalar> Mul for Dual<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Dual { re: self.re * o.re, eps: self.eps * o.re + self.re * o.eps }
    }
}

impl<S: Scalar> Div for Dual<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let inverse = S::one() / o.re;
        let quotient = self.re * inverse;
        Dual { re: quotient, eps: (self.eps - quotient * o.eps) * inverse }
    }
}

impl<S: Scalar> Neg for Dual<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Dual { re: -self.re, eps: -self.eps }
    }
}

impl<S: Scalar> Mul<f64> for Dual<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        Dual { re: self.re * o, eps: self.eps * o }
    }
}

impl<S: Scalar> AddAssign for Dual<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Scalar> SubAssign for Dual<S> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<S: Scalar<Value = S>> Scalar for Dual<S> {
    type Value = S;
    const LANES: usize = S::LANES;

    #[inline(always)]
    fn constant(x: f64) -> Self {
        Dual { re: S::constant(x), eps: S::zero() }
    }

    #[inline(always)]
    fn lift(x: S) -> Self {
        Dual { re: x, eps: S::zero() }
    }

    #[inline(always)]
    fn with_slope(value: S, slope: &[S], x: &[Self]) -> Self {
        let mut eps = S::zero();
        for (s, x) in slope.iter().zip(x) {
            eps += *s * x.eps;
        }
        Dual { re: value, eps }
    }

    #[inline(always)]
    fn frozen(self) -> Self {
        Dual { re: self.re, eps: S::zero() }
    }

    #[inline(always)]
    fn ln(self) -> Self {
        Dual { re: self.re.ln(), eps: self.eps / self.re }
    }

    #[inline(always)]
    fn exp(self) -> Self {
        let re = self.re.exp();
        Dual { re, eps: self.eps * re }
    }

    #[inline(always)]
    fn powf(self, n: f64) -> Self {
        Dual { re: self.re.powf(n), eps: self.eps * self.re.powf(n - 1.0) * n }
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> [f64; 2] {
        [self.re.lane(lane)[0], self.eps.lane(lane)[0]]
    }

    #[inline(always)]
    fn apart(task: impl Task) {
        S::apart(task);
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, number: [f64; 2]) {
        self.re.set_lane(lane, [number[0], 0.0]);
        self.eps.set_lane(lane, [number[1], 0.0]);
    }

    #[inline(always)]
    fn below_zero(self) -> Self {
        Dual { re: self.re.below_zero(), eps: S::zero() }
    }
}
