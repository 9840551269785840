//! Steps in time.

pub mod linear;
pub mod scheme;
pub mod stepper;
pub mod system;

pub use crate::tangent::Linearization;
pub use linear::{Linear, MakeSolver, Purpose};
pub use scheme::Scheme;
pub use stepper::{Clock, Force, JacobianPoint, StepFailure, StepReport, Stepper, StepperSettings};
pub use system::{BlockNorms, Scales};
