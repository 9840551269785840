//! The number that cycles are computed in: single or double precision.

use std::iter::Sum;
use std::ops::{AddAssign, Mul, Sub, SubAssign};

/// `f32` or `f64`.
pub trait Number:
    Copy + Default + Send + Sync + AddAssign + SubAssign + Sum + Sub<Output = Self> + Mul<Output = Self> + 'static
{
    /// Rounds.
    fn of(x: f64) -> Self;
    /// The same number in double precision.
    fn double(self) -> f64;
}

impl Number for f32 {
    #[inline(always)]
    fn of(x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn double(self) -> f64 {
        f64::from(self)
    }
}

impl Number for f64 {
    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn double(self) -> f64 {
        self
    }
}
