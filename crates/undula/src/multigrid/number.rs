//! The number that cycles are computed in: single or double precision.

use crate::algebra::{Csr, Value};
use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{AddAssign, Mul, Sub, SubAssign};
use std::sync::Arc;

/// `f32` or `f64`.
pub trait Number:
    Value + AddAssign + SubAssign + Sum + Sub<Output = Self> + Mul<Output = Self> + 'static
{
    /// How an entry of factors is kept, as a multiple of a unit that its row has.
    type Entry: Copy + Default + Send + Sync + Debug;

    /// The unit of entries of this largest size.
    fn unit(largest: f64) -> f64;

    /// Rounds a number of units.
    fn entry(units: f64) -> Self::Entry;

    /// A number of units.
    fn units(entry: Self::Entry) -> Self;

    /// A matrix of others as one of its own, where it has such numbers.
    fn held(a: &Arc<Csr<f32>>) -> Option<Arc<Csr<Self>>>;
}

/// Entries have 16 bits: what they lose is 1.5e-5 of the largest one in their row. Corrections that a coarser level and GMRES
/// improve on hardly change, and half of the memory is saved.
impl Number for f32 {
    type Entry = i16;

    fn unit(largest: f64) -> f64 {
        largest / f64::from(i16::MAX)
    }

    fn entry(units: f64) -> i16 {
        units.round() as i16
    }

    #[inline(always)]
    fn units(entry: i16) -> f32 {
        f32::from(entry)
    }

    fn held(a: &Arc<Csr<f32>>) -> Option<Arc<Csr<f32>>> {
        Some(Arc::clone(a))
    }
}

impl Number for f64 {
    type Entry = f64;

    fn unit(_: f64) -> f64 {
        1.0
    }

    fn entry(units: f64) -> f64 {
        units
    }

    #[inline(always)]
    fn units(entry: f64) -> f64 {
        entry
    }

    fn held(_: &Arc<Csr<f32>>) -> Option<Arc<Csr<f64>>> {
        None
    }
}
