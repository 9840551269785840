//! Steps in time.

pub mod scheme;
pub mod stepper;
pub mod system;

pub use scheme::Scheme;
pub use stepper::{Clock, Force, JacobianPoint, StepFailure, StepReport, Stepper, StepperSettings};
pub use system::{BlockNorms, Scales};
