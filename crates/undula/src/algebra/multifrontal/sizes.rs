//! How many numbers a front has, and where they lie.

/// Pivots applied at a time: as many columns of the factors are read side by side.
pub(super) const BLOCK: usize = 8;

/// Numbers behind matrices and vectors that may be read, so that all vectors are whole.
pub(super) const SLACK: usize = 16;

/// Rounded up to whole vectors.
pub(super) fn padded(n: usize) -> usize {
    n.next_multiple_of(8)
}

/// What determines the places of all numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sizes {
    /// Pivots tried.
    pub k: usize,
    /// Pivots eliminated.
    pub e: usize,
    /// Rows behind the pivots tried.
    pub r: usize,
}

impl Sizes {
    /// Of a front in which no pivot is delayed.
    pub fn whole(k: usize, r: usize) -> Self {
        Self { k, e: k, r }
    }

    /// Numbers of L.
    pub fn lower(self) -> usize {
        let j = self.e / BLOCK * BLOCK;
        let width = self.e - j;
        self.lower_at(j) + width * (BLOCK + self.below(j + width))
    }

    /// Numbers of U.
    pub fn upper(self) -> usize {
        self.triangle() + self.above(self.e)
    }

    /// Where the block of L that starts with pivot `j` begins.
    pub fn lower_at(self, j: usize) -> usize {
        let b = j / BLOCK;
        // Σ BLOCK (BLOCK + P − BLOCK (i + 1)) over the blocks i before.
        j * (BLOCK + padded(self.k + self.r)) - BLOCK * BLOCK * b * (b + 1) / 2
    }

    /// Leading dimension of the rows below the first `j` pivots.
    pub fn below(self, j: usize) -> usize {
        padded(self.k + self.r - j)
    }

    /// Where the triangle of U begins.
    pub fn triangle(self) -> usize {
        self.e * padded(self.r) + (self.k - self.e) * padded(self.e)
    }

    /// Numbers of the triangle of U in the first `j` pivots.
    pub fn above(self, j: usize) -> usize {
        let b = j / BLOCK;
        let width = j - b * BLOCK;
        BLOCK * BLOCK * b * (b + 1) / 2 + width * (b + 1) * BLOCK
    }
}

/// Numbers of a front in the memory of L and in that of U.
pub(super) fn stored(sizes: Sizes, definite: bool) -> (usize, usize) {
    if definite { (0, sizes.lower()) } else { (sizes.lower(), sizes.upper()) }
}
