//! Numbers and small tensors; this layer knows nothing else of the library.

pub(crate) mod apart;
mod decimal;
pub mod dual;
mod erf;
pub mod hyper_dual;
pub(crate) mod lanes;
pub mod scalar;
pub mod tensor;

pub use decimal::{rounded, shortest};
pub use dual::Dual;
pub use erf::erf;
pub use hyper_dual::HyperDual;
pub(crate) use lanes::Lanes;
pub use scalar::Scalar;
pub use tensor::{Tensor, Vector};
