//! Numbers and small tensors; this layer knows nothing else of the library.

pub mod dual;
pub mod lanes;
pub mod scalar;
pub mod tensor;

pub use dual::Dual;
pub use lanes::Lanes;
pub use scalar::Scalar;
pub use tensor::{Tensor, Vector};
