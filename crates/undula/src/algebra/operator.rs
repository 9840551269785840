//! Linear maps that can be applied.

use super::{Csr, Value};

/// A square linear map, whether its entries are stored or not.
pub trait LinearOperator {
    /// Rows, and columns.
    fn size(&self) -> usize;

    /// `y ← A x`.
    ///
    /// # Panics
    /// If `x` or `y` does not have this size.
    fn apply(&self, x: &[f64], y: &mut [f64]);
}

impl<T: Value> LinearOperator for Csr<T> {
    fn size(&self) -> usize {
        self.pattern.n
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.mul(x, y);
    }
}
