//! Writing from several threads into one array.
#![allow(unsafe_code)]

use crate::algebra::Sink;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

/// Marks a row or entry that is not there: a constrained unknown, or a row of another owner.
pub const DROP: u32 = u32::MAX;

/// An array that several threads write at the same time, and copies of its entries behind it, see
/// [`super::chunks`].
///
/// Two threads never write the same entry at the same time, or sums would lose terms: what several chunks of
/// batches write has a copy for each. Entries are atomic, so that a mistake here would give wrong numbers, not
/// undefined behaviour. Relaxed loads and stores are the plain instructions of the processor.
#[derive(Copy, Clone)]
pub struct Shared<'a> {
    array: &'a [AtomicU64],
    /// Where the array is one in single precision.
    single: &'a [AtomicU32],
    copies: &'a [AtomicU64],
}

const _: () =
    assert!(align_of::<f64>() == align_of::<AtomicU64>() && size_of::<f64>() == size_of::<AtomicU64>());
const _: () =
    assert!(align_of::<f32>() == align_of::<AtomicU32>() && size_of::<f32>() == size_of::<AtomicU32>());

/// The same memory as atomic numbers.
fn atomic(array: &mut [f64]) -> &[AtomicU64] {
    // SAFETY: the two types have one size and alignment, every pattern of bits is valid for both, and the exclusive
    // borrow of the array lasts as long as the result, so that all access goes through it.
    unsafe { std::slice::from_raw_parts(array.as_mut_ptr().cast(), array.len()) }
}

/// The same in single precision.
fn single(array: &mut [f32]) -> &[AtomicU32] {
    // SAFETY: as above, with `f32` and `AtomicU32`.
    unsafe { std::slice::from_raw_parts(array.as_mut_ptr().cast(), array.len()) }
}

#[inline(always)]
fn load(entry: &AtomicU64) -> f64 {
    f64::from_bits(entry.load(Ordering::Relaxed))
}

#[inline(always)]
fn store(entry: &AtomicU64, x: f64) {
    entry.store(x.to_bits(), Ordering::Relaxed);
}

impl<'a> Shared<'a> {
    /// Share `array` for the length of its borrow.
    pub fn new(array: &'a mut [f64]) -> Shared<'a> {
        Self::with_copies(array, &mut [])
    }

    /// Share the first `n` entries of a matrix and `copies`.
    pub fn entries(sink: Sink<'a>, n: usize, copies: &'a mut [f64]) -> Shared<'a> {
        match sink {
            Sink::Double(array) => Self::with_copies(&mut array[..n], copies),
            Sink::Single(array) => {
                Shared { array: &[], single: single(&mut array[..n]), copies: atomic(copies) }
            }
        }
    }

    /// Share `array` and `copies`, whose first one has the number behind the last entry.
    pub fn with_copies(array: &'a mut [f64], copies: &'a mut [f64]) -> Shared<'a> {
        Shared { array: atomic(array), single: &[], copies: atomic(copies) }
    }

    /// `array[at] += x` or that of a copy, nothing for [`DROP`].
    #[inline(always)]
    pub fn add(&self, at: u32, x: f64) {
        let at = at as usize;
        if let Some(entry) = self.array.get(at) {
            store(entry, load(entry) + x);
        } else if let Some(entry) = self.single.get(at) {
            let sum = f32::from_bits(entry.load(Ordering::Relaxed)) + x as f32;
            entry.store(sum.to_bits(), Ordering::Relaxed);
        } else if let Some(copy) = self.copies.get(at - self.len()) {
            store(copy, load(copy) + x);
        } else {
            debug_assert!(at == DROP as usize);
        }
    }

    /// Entries that are no copies.
    #[inline(always)]
    fn len(&self) -> usize {
        self.array.len() + self.single.len()
    }

    /// Whether `at` is a copy.
    #[inline(always)]
    pub fn is_copy(&self, at: u32) -> bool {
        at as usize >= self.len()
    }

    /// `array[at]`.
    #[inline(always)]
    pub fn get(&self, at: u32) -> f64 {
        load(&self.array[at as usize])
    }

    /// `array[at] = x`.
    #[inline(always)]
    pub fn set(&self, at: usize, x: f64) {
        store(&self.array[at], x);
    }
}

/// Work space for parallel loops: one object for each thread that they are meant for.
///
/// With more threads than objects, as in the pool of somebody else, some wait: slower, and the same result.
pub struct PerThread<T>(Vec<Mutex<T>>);

impl<T> PerThread<T> {
    /// One object for each of `threads` threads.
    pub fn new(threads: usize, mut make: impl FnMut() -> T) -> Self {
        PerThread((0..threads.max(1)).map(|_| Mutex::new(make())).collect())
    }

    /// Use an object that no other thread uses now.
    ///
    /// `f` must not wait for other work of the pool, which may need the same object.
    #[inline(always)]
    pub fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        f(&mut self.free())
    }

    /// The object of this thread, else another one that is free, else that of this thread once it is.
    fn free(&self) -> MutexGuard<'_, T> {
        let n = self.0.len();
        let own = rayon::current_thread_index().unwrap_or(0) % n;
        for i in 0..n {
            match self.0[(own + i) % n].try_lock() {
                Ok(object) => return object,
                // What a panic left behind is overwritten before it is read.
                Err(TryLockError::Poisoned(object)) => return object.into_inner(),
                Err(TryLockError::WouldBlock) => {}
            }
        }
        self.0[own].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Threads of no pool all have the number 0, and so has the first one of each pool.
    #[test]
    fn an_object_is_used_by_one_thread_at_a_time() {
        for objects in [1, 3] {
            let counts = PerThread::new(objects, || 0_u64);
            std::thread::scope(|scope| {
                for _ in 0..4 {
                    scope.spawn(|| (0..10_000).for_each(|_| counts.with(|count| *count += 1)));
                }
            });
            let sum: u64 = counts.0.into_iter().map(|count| count.into_inner().unwrap()).sum();
            assert_eq!(sum, 40_000);
        }
    }
}
