//! Memory aligned to cache lines.

use super::real::Real;

/// Numbers at an address that suits whole cache lines; resizing leaves them unspecified.
#[derive(Debug, Default)]
pub(super) struct Buffer<T> {
    memory: Vec<T>,
    len: usize,
}

impl<T: Real> Buffer<T> {
    /// Numbers in a cache line.
    const LINE: usize = 64 / size_of::<T>();

    /// An empty buffer with memory for `n` numbers.
    pub fn with_capacity(n: usize) -> Self {
        Self { memory: vec![T::ZERO; n + Self::LINE], len: 0 }
    }

    /// Numbers there is memory for.
    pub fn capacity(&self) -> usize {
        self.memory.len().saturating_sub(Self::LINE)
    }

    /// Makes it `n` numbers, whatever they are.
    pub fn resize(&mut self, n: usize) {
        if self.capacity() < n {
            *self = Self::with_capacity(n);
        }
        self.len = n;
    }

    fn start(&self) -> usize {
        self.memory.as_ptr().align_offset(64).min(Self::LINE)
    }
}

impl<T: Real> std::ops::Deref for Buffer<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        if self.len == 0 { &[] } else { &self.memory[self.start()..][..self.len] }
    }
}

impl<T: Real> std::ops::DerefMut for Buffer<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        let start = self.start();
        if self.len == 0 { &mut [] } else { &mut self.memory[start..][..self.len] }
    }
}
