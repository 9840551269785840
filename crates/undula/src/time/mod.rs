//! Steps in time.

pub mod adaptive;
pub mod cause;
mod condensed;
mod extension;
pub mod factors;
pub mod fractional_step;
pub mod kept;
mod krylov;
pub mod linear;
mod preconditioned;
pub mod report;
pub mod restart;
mod retry;
pub mod scales;
pub mod schedule;
pub mod scheme;
mod single_step;
mod stationary;
pub mod stepper;
pub mod system;

pub use crate::tangent::Linearization;
pub use adaptive::{Adaptive, AdaptiveSettings};
pub use cause::{Cause, DataFault, DataKind};
pub use factors::{MakeSolver, Purpose};
pub use kept::JacobianPoint;
pub use krylov::KrylovSettings;
pub use linear::Linear;
pub use report::{Attempt, Details, StepFailure, StepReport};
pub use restart::Clock;
pub use scales::{BlockNorms, Scales};
pub use schedule::{Next, Schedule};
pub use scheme::{Damping, DomainMotion, Scheme};
pub use stepper::{Force, Stepper, StepperSettings};
