//! Second derivatives by automatic differentiation.

use super::Scalar;
use super::apart::{Task, run_baseline};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `re + a ε + b η + ab ε η` with `ε² = η² = 0`: a value, its derivatives in two directions and the mixed second one.
///
/// For functions that are evaluated rarely and written once, such as the energy of an own material; the equations
/// take [`super::Dual`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct HyperDual {
    /// Value.
    pub re: f64,
    /// Derivative in the first direction.
    pub a: f64,
    /// Derivative in the second direction.
    pub b: f64,
    /// Second derivative in both directions.
    pub ab: f64,
}

impl HyperDual {
    /// A function of the number by its value and its first and second derivative there: the chain rule.
    fn chain(self, value: f64, first: f64, second: f64) -> Self {
        HyperDual {
            re: value,
            a: first * self.a,
            b: first * self.b,
            ab: first * self.ab + second * self.a * self.b,
        }
    }
}

impl Add for HyperDual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        HyperDual { re: self.re + o.re, a: self.a + o.a, b: self.b + o.b, ab: self.ab + o.ab }
    }
}

impl Sub for HyperDual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for HyperDual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        HyperDual {
            re: self.re * o.re,
            a: self.a * o.re + self.re * o.a,
            b: self.b * o.re + self.re * o.b,
            ab: self.ab * o.re + self.a * o.b + self.b * o.a + self.re * o.ab,
        }
    }
}

impl Div for HyperDual {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn div(self, o: Self) -> Self {
        let inverse = 1.0 / o.re;
        let square = inverse * inverse;
        self * o.chain(inverse, -square, 2.0 * square * inverse)
    }
}

impl Neg for HyperDual {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul<f64> for HyperDual {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        HyperDual { re: self.re * o, a: self.a * o, b: self.b * o, ab: self.ab * o }
    }
}

impl AddAssign for HyperDual {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl SubAssign for HyperDual {
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl Scalar for HyperDual {
    type Value = f64;
    const LANES: usize = 1;

    fn constant(x: f64) -> Self {
        HyperDual { re: x, a: 0.0, b: 0.0, ab: 0.0 }
    }

    fn lift(x: f64) -> Self {
        Self::constant(x)
    }

    /// To first order: the second derivatives of the function are taken as 0.
    fn with_slope(value: f64, slope: &[f64], x: &[Self]) -> Self {
        let mut sum = Self::constant(value);
        for (s, x) in slope.iter().zip(x) {
            sum += HyperDual { re: 0.0, ..*x } * *s;
        }
        sum
    }

    fn frozen(self) -> Self {
        Self::constant(self.re)
    }

    fn ln(self) -> Self {
        self.chain(self.re.ln(), 1.0 / self.re, -1.0 / (self.re * self.re))
    }

    fn exp(self) -> Self {
        let value = self.re.exp();
        self.chain(value, value, value)
    }

    fn powf(self, n: f64) -> Self {
        let power = |n: f64| self.re.powf(n);
        self.chain(power(n), n * power(n - 1.0), n * (n - 1.0) * power(n - 2.0))
    }

    fn lane(&self, _: usize) -> [f64; 2] {
        [self.re, self.a]
    }

    fn apart(task: impl Task) {
        run_baseline(task);
    }

    fn set_lane(&mut self, _: usize, [re, a]: [f64; 2]) {
        *self = HyperDual { re, a, b: 0.0, ab: 0.0 };
    }

    fn below_zero(self) -> Self {
        Self::constant(self.re.below_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Dual;

    fn functions<T: Scalar>(x: T, y: T) -> [T; 5] {
        [x * y / (x + y), x.ln() * y, (x * y).exp(), x.powf(1.7) * y, (x - y * 0.25).sqrt() - y]
    }

    #[test]
    fn second_derivatives_are_differences_of_first_ones() {
        let (x, y, h) = (1.3, 0.8, 1e-5);
        let number = |re, a, b| HyperDual { re, a, b, ab: 0.0 };
        // Directions (1, 0.5) and (0.25, 1).
        let exact = functions(number(x, 1.0, 0.25), number(y, 0.5, 1.0));
        let along = |s: f64| functions(Dual { re: x + 0.25 * s, eps: 1.0 }, Dual { re: y + s, eps: 0.5 });
        let (plus, minus, here) = (along(h), along(-h), along(0.0));
        for n in 0..exact.len() {
            assert_eq!(exact[n].re, here[n].re);
            assert!((exact[n].a - here[n].eps).abs() < 1e-14, "{n}: {:?} {:?}", exact[n], here[n]);
            let first = (plus[n].re - minus[n].re) / (2.0 * h);
            let second = (plus[n].eps - minus[n].eps) / (2.0 * h);
            assert!((exact[n].b - first).abs() < 1e-9, "{n}: {} and {first}", exact[n].b);
            assert!((exact[n].ab - second).abs() < 1e-9, "{n}: {} and {second}", exact[n].ab);
        }
    }
}
