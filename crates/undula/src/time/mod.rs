//! Steps in time.

pub mod adaptive;
pub mod linear;
pub mod parts;
pub mod scheme;
pub mod stepper;
pub mod system;

pub use adaptive::{Adaptive, AdaptiveSettings};
pub use linear::{Linear, Linearization, MakeSolver, Purpose};
pub use scheme::{Damping, DomainMotion, Scheme};
pub use stepper::{Clock, Force, JacobianPoint, StepFailure, StepReport, Stepper, StepperSettings};
pub use system::{BlockNorms, Scales};
