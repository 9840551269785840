//! Several elements side by side.

use super::Scalar;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `L` elements of a batch in one number, one lane each.
///
/// A plain array: the compiler keeps it in vector registers when the code around it is compiled for a
/// processor that has them, see [`crate::assembly::simd`]. Everything here must inline into such a
/// function, because a call boundary would lose its target features.
#[derive(Copy, Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const L: usize>(pub [f64; L]);

macro_rules! lanes_operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const L: usize> $trait for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let mut r = self;
                for l in 0..L {
                    r.0[l] = self.0[l] $op other.0[l];
                }
                r
            }
        }
        impl<const L: usize> $trait<f64> for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                let mut r = self;
                for l in 0..L {
                    r.0[l] = self.0[l] $op other;
                }
                r
            }
        }
    };
}
lanes_operator!(Add, add, +);
lanes_operator!(Sub, sub, -);
lanes_operator!(Mul, mul, *);
lanes_operator!(Div, div, /);

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let mut r = self;
        for l in 0..L {
            r.0[l] = -self.0[l];
        }
        r
    }
}

impl<const L: usize> AddAssign for Lanes<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for l in 0..L {
            self.0[l] += other.0[l];
        }
    }
}

impl<const L: usize> SubAssign for Lanes<L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        for l in 0..L {
            self.0[l] -= other.0[l];
        }
    }
}

impl<const L: usize> Scalar for Lanes<L> {
    type Value = Self;

    #[inline(always)]
    fn constant(x: f64) -> Self {
        Lanes([x; L])
    }

    #[inline(always)]
    fn lift(x: Self) -> Self {
        x
    }

    #[inline(always)]
    fn frozen(self) -> Self {
        self
    }
}

impl<const L: usize> Lanes<L> {
    /// `self += a · x`, fused where `L` stands for a processor that has the instruction (4 and 8 lanes).
    #[inline(always)]
    pub fn add_product(&mut self, a: f64, x: Self) {
        for l in 0..L {
            self.0[l] = if L >= 4 { a.mul_add(x.0[l], self.0[l]) } else { a * x.0[l] + self.0[l] };
        }
    }

    /// `self += a · x` lane by lane, fused likewise.
    #[inline(always)]
    pub fn add_product_lanes(&mut self, a: Self, x: Self) {
        for l in 0..L {
            self.0[l] = if L >= 4 { a.0[l].mul_add(x.0[l], self.0[l]) } else { a.0[l] * x.0[l] + self.0[l] };
        }
    }
}
