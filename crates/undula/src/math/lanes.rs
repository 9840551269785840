//! Several elements side by side.
//!
//! Four and eight lanes are one vector register on processors that have AVX2 with FMA or AVX-512; any
//! other number is computed lane by lane.
#![allow(unsafe_code)]

use super::Scalar;
use super::apart::{Task, run};
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `L` elements of a batch in one number, one lane each.
///
/// Operations must inline into a function compiled for the processor, see [`crate::loops::width`]: a
/// call boundary would cost more than the operation. Arithmetic with 4 or 8 lanes on a processor
/// without the instructions is not allowed. Therefore the type is of this crate alone, and only
/// kernels of a width that [`crate::loops::width::available`] grants compute with it.
#[derive(Copy, Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const L: usize>(pub [f64; L]);

#[cfg(target_arch = "x86_64")]
impl<const L: usize> Lanes<L> {
    #[inline(always)]
    fn v8(self) -> __m512d {
        // SAFETY: only called for L = 8, where both types are 64 bytes.
        unsafe { std::mem::transmute_copy(&self) }
    }

    #[inline(always)]
    fn of_v8(x: __m512d) -> Self {
        // SAFETY: only called for L = 8, where both types are 64 bytes.
        unsafe { std::mem::transmute_copy(&x) }
    }

    #[inline(always)]
    fn v4(self) -> __m256d {
        // SAFETY: only called for L = 4; the first 32 bytes are the four lanes.
        unsafe { std::mem::transmute_copy(&self) }
    }

    #[inline(always)]
    fn of_v4(x: __m256d) -> Self {
        let mut r = Lanes([0.0; L]);
        // SAFETY: only called for L = 4, where the array has 32 bytes.
        unsafe { _mm256_storeu_pd(r.0.as_mut_ptr(), x) };
        r
    }
}

macro_rules! lanes_operator {
    ($trait:ident, $method:ident, $op:tt, $v8:ident, $v4:ident) => {
        impl<const L: usize> $trait for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: these widths are in use only where the processor has the instructions.
                #[cfg(target_arch = "x86_64")]
                unsafe {
                    if L == 8 {
                        return Self::of_v8($v8(self.v8(), other.v8()));
                    }
                    if L == 4 {
                        return Self::of_v4($v4(self.v4(), other.v4()));
                    }
                }
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
                self $op Self::splat(other)
            }
        }
    };
}
lanes_operator!(Add, add, +, _mm512_add_pd, _mm256_add_pd);
lanes_operator!(Sub, sub, -, _mm512_sub_pd, _mm256_sub_pd);
lanes_operator!(Mul, mul, *, _mm512_mul_pd, _mm256_mul_pd);
lanes_operator!(Div, div, /, _mm512_div_pd, _mm256_div_pd);

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::splat(-0.0) - self
    }
}

impl<const L: usize> AddAssign for Lanes<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const L: usize> SubAssign for Lanes<L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const L: usize> Lanes<L> {
    /// The same number in all lanes.
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        // SAFETY: these widths are in use only where the processor has the instructions.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            if L == 8 {
                return Self::of_v8(_mm512_set1_pd(x));
            }
            if L == 4 {
                return Self::of_v4(_mm256_set1_pd(x));
            }
        }
        Lanes([x; L])
    }

    /// `self += a · x`, fused where the processor has the instruction (4 and 8 lanes).
    #[inline(always)]
    pub fn add_product(&mut self, a: f64, x: Self) {
        self.add_product_lanes(Self::splat(a), x);
    }

    /// `self += a · x` lane by lane, fused likewise.
    #[inline(always)]
    pub fn add_product_lanes(&mut self, a: Self, x: Self) {
        // SAFETY: these widths are in use only where the processor has the instructions.
        #[cfg(target_arch = "x86_64")]
        unsafe {
            if L == 8 {
                *self = Self::of_v8(_mm512_fmadd_pd(a.v8(), x.v8(), self.v8()));
                return;
            }
            if L == 4 {
                *self = Self::of_v4(_mm256_fmadd_pd(a.v4(), x.v4(), self.v4()));
                return;
            }
        }
        for l in 0..L {
            self.0[l] += a.0[l] * x.0[l];
        }
    }
}

impl<const L: usize> Scalar for Lanes<L> {
    type Value = Self;
    const LANES: usize = L;

    #[inline(always)]
    fn constant(x: f64) -> Self {
        Self::splat(x)
    }

    #[inline(always)]
    fn lift(x: Self) -> Self {
        x
    }

    #[inline(always)]
    fn with_slope(value: Self, _: &[Self], _: &[Self]) -> Self {
        value
    }

    #[inline(always)]
    fn frozen(self) -> Self {
        self
    }

    #[inline(always)]
    fn ln(self) -> Self {
        Lanes(self.0.map(f64::ln))
    }

    #[inline(always)]
    fn exp(self) -> Self {
        Lanes(self.0.map(f64::exp))
    }

    #[inline(always)]
    fn powf(self, n: f64) -> Self {
        Lanes(self.0.map(|x| x.powf(n)))
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> [f64; 2] {
        [self.0[lane], 0.0]
    }

    #[inline(always)]
    fn apart(task: impl Task) {
        // SAFETY: a width is in use only where the processor has the instructions.
        unsafe { run::<L>(task) };
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, number: [f64; 2]) {
        self.0[lane] = number[0];
    }

    #[inline(always)]
    fn below_zero(self) -> Self {
        Lanes(self.0.map(Scalar::below_zero))
    }
}
