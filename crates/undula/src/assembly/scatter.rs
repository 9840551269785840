//! Writing from several threads into one array.
#![allow(unsafe_code)]

use std::marker::PhantomData;

/// Marks a row or entry that is not there: a constrained unknown, or a row of another owner.
pub const DROP: u32 = u32::MAX;

/// An array that several threads write at the same time, at places that never coincide, and copies of
/// its entries behind it, see [`super::chunks`].
#[derive(Copy, Clone)]
pub struct Shared<'a> {
    start: *mut f64,
    len: usize,
    copies: *mut f64,
    n_copies: usize,
    array: PhantomData<&'a mut [f64]>,
}

// SAFETY: concurrent writers are kept apart, see `Shared::add`.
unsafe impl Send for Shared<'_> {}
// SAFETY: as above.
unsafe impl Sync for Shared<'_> {}

impl<'a> Shared<'a> {
    /// Share `array` for the length of its borrow.
    pub fn new(array: &'a mut [f64]) -> Shared<'a> {
        Self::with_copies(array, &mut [])
    }

    /// Share `array` and `copies`, whose first one has the number behind the last entry.
    pub fn with_copies(array: &'a mut [f64], copies: &'a mut [f64]) -> Shared<'a> {
        Shared {
            start: array.as_mut_ptr(),
            len: array.len(),
            copies: copies.as_mut_ptr(),
            n_copies: copies.len(),
            array: PhantomData,
        }
    }

    /// `array[at] += x` or that of a copy, nothing for [`DROP`].
    ///
    /// Two threads never call this with the same `at` at the same time: what several chunks of batches
    /// write has a copy for each.
    #[inline(always)]
    pub fn add(&self, at: u32, x: f64) {
        let at = at as usize;
        if at < self.len {
            // SAFETY: within bounds; no other thread touches this entry now.
            unsafe { *self.start.add(at) += x };
        } else if at - self.len < self.n_copies {
            // SAFETY: as above.
            unsafe { *self.copies.add(at - self.len) += x };
        } else {
            debug_assert!(at == DROP as usize);
        }
    }

    /// `array[at]`; no thread writes this entry now.
    #[inline(always)]
    pub fn get(&self, at: u32) -> f64 {
        assert!((at as usize) < self.len);
        // SAFETY: within bounds, and not written meanwhile.
        unsafe { *self.start.add(at as usize) }
    }

    /// `array[at] = x`, under the same condition.
    #[inline(always)]
    pub fn set(&self, at: usize, x: f64) {
        assert!(at < self.len);
        // SAFETY: within bounds; each batch writes its own entry.
        unsafe { *self.start.add(at) = x };
    }
}

/// An array in pieces of one size, each worked on by its own batch.
#[derive(Copy, Clone)]
pub struct Pieces<'a, T> {
    start: *mut T,
    len: usize,
    size: usize,
    array: PhantomData<&'a mut [T]>,
}

// SAFETY: each batch reaches its own piece only, see `Pieces::of`.
unsafe impl<T: Send> Send for Pieces<'_, T> {}
// SAFETY: as above.
unsafe impl<T: Send> Sync for Pieces<'_, T> {}

impl<'a, T> Pieces<'a, T> {
    /// Cut `array` into pieces of `size`.
    pub fn new(array: &'a mut [T], size: usize) -> Pieces<'a, T> {
        Pieces { start: array.as_mut_ptr(), len: array.len(), size, array: PhantomData }
    }

    /// The piece of `batch`, which is worked on by one thread and asked for once in that work.
    #[inline(always)]
    #[allow(clippy::mut_from_ref)]
    pub fn of(&self, batch: usize) -> &mut [T] {
        assert!((batch + 1) * self.size <= self.len);
        // SAFETY: within bounds; pieces are disjoint, and a batch is in the hands of one thread.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(batch * self.size), self.size) }
    }
}

/// One object per thread, reached from within a parallel loop.
pub struct PerThread<T>(Vec<std::cell::UnsafeCell<T>>);

// SAFETY: each thread of the pool reaches its own element only, see `PerThread::get`.
unsafe impl<T: Send> Sync for PerThread<T> {}

impl<T> PerThread<T> {
    /// One object for each of `threads` threads.
    pub fn new(threads: usize, mut make: impl FnMut() -> T) -> Self {
        PerThread((0..threads.max(1)).map(|_| std::cell::UnsafeCell::new(make())).collect())
    }

    /// Use the object of the current thread.
    ///
    /// `f` must not wait for other work of the pool, or this thread could enter a second time.
    #[inline(always)]
    pub fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        let index = rayon::current_thread_index().unwrap_or(0);
        // SAFETY: an index belongs to one thread, and `f` does not come back here.
        f(unsafe { &mut *self.0[index].get() })
    }
}
