//! The one number type that the equations are generic over.

use super::apart::{Task, run_baseline};
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number the equations can compute with: `f64`, lanes of several elements, or a [`super::Dual`].
///
/// `Copy`, so that no clone hides in a formula. Parameters of the model stay `f64`.
pub trait Scalar:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Mul<f64, Output = Self>
{
    /// The number without its derivatives: `f64` or lanes.
    type Value: Scalar<Value = Self::Value>;

    /// Numbers side by side in one: 1, or the lanes.
    const LANES: usize;

    /// The same constant everywhere.
    fn constant(x: f64) -> Self;

    /// A value that does not depend on the unknowns.
    fn lift(x: Self::Value) -> Self;

    /// A function of `x` by its value and its partial derivatives there: the chain rule.
    fn with_slope(value: Self::Value, slope: &[Self::Value], x: &[Self]) -> Self;

    /// The same value with its derivative dropped (identity unless `Self` carries one).
    fn frozen(self) -> Self;

    /// Natural logarithm.
    fn ln(self) -> Self;

    /// Exponential function.
    fn exp(self) -> Self;

    /// The power with exponent `n`, for numbers above 0.
    fn powf(self, n: f64) -> Self;

    /// Value and derivative in lane `lane`; the derivative is 0 unless the number has one.
    fn lane(&self, lane: usize) -> [f64; 2];

    /// Does `task`, whose numbers have these lanes, in a function of its own.
    fn apart(task: impl Task);

    /// Sets value and derivative in lane `lane`, the inverse of [`Scalar::lane`].
    fn set_lane(&mut self, lane: usize, number: [f64; 2]);

    /// Square root of a number above 0.
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.powf(0.5)
    }

    /// 1 where the value is below 0, else 0; without derivative.
    fn below_zero(self) -> Self;

    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::constant(0.0)
    }

    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::constant(1.0)
    }
}

impl Scalar for f64 {
    type Value = f64;
    const LANES: usize = 1;

    #[inline(always)]
    fn constant(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn lift(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn with_slope(value: f64, _: &[f64], _: &[f64]) -> f64 {
        value
    }

    #[inline(always)]
    fn frozen(self) -> f64 {
        self
    }

    #[inline(always)]
    fn ln(self) -> f64 {
        f64::ln(self)
    }

    #[inline(always)]
    fn exp(self) -> f64 {
        f64::exp(self)
    }

    #[inline(always)]
    fn powf(self, n: f64) -> f64 {
        f64::powf(self, n)
    }

    #[inline(always)]
    fn lane(&self, _: usize) -> [f64; 2] {
        [*self, 0.0]
    }

    #[inline(always)]
    fn apart(task: impl Task) {
        run_baseline(task);
    }

    #[inline(always)]
    fn set_lane(&mut self, _: usize, number: [f64; 2]) {
        *self = number[0];
    }

    #[inline(always)]
    fn below_zero(self) -> f64 {
        if self < 0.0 { 1.0 } else { 0.0 }
    }
}
