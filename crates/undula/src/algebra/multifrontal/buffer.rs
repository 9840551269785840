//! Memory aligned to cache lines.

/// Numbers at an address that suits whole cache lines; resizing leaves them unspecified.
#[derive(Debug, Default)]
pub(super) struct Buffer {
    memory: Vec<f64>,
    len: usize,
}

impl Buffer {
    const LINE: usize = 64;

    /// An empty buffer with memory for `n` numbers.
    pub fn with_capacity(n: usize) -> Self {
        Self { memory: vec![0.0; n + Self::LINE / 8], len: 0 }
    }

    /// Numbers there is memory for.
    pub fn capacity(&self) -> usize {
        self.memory.len().saturating_sub(Self::LINE / 8)
    }

    /// Makes it `n` numbers, whatever they are.
    pub fn resize(&mut self, n: usize) {
        if self.capacity() < n {
            *self = Self::with_capacity(n);
        }
        self.len = n;
    }

    fn start(&self) -> usize {
        self.memory.as_ptr().align_offset(Self::LINE).min(Self::LINE / 8)
    }
}

impl std::ops::Deref for Buffer {
    type Target = [f64];

    #[inline(always)]
    fn deref(&self) -> &[f64] {
        if self.len == 0 { &[] } else { &self.memory[self.start()..][..self.len] }
    }
}

impl std::ops::DerefMut for Buffer {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64] {
        let start = self.start();
        if self.len == 0 { &mut [] } else { &mut self.memory[start..][..self.len] }
    }
}
