//! Steps in time.

pub mod adaptive;
mod attempt;
pub mod cause;
mod condensed;
mod extension;
mod halves;
mod krylov;
pub mod linear;
pub mod parts;
pub mod report;
pub mod restart;
pub mod schedule;
pub mod scheme;
mod stationary;
pub mod stepper;
pub mod system;

pub use crate::tangent::Linearization;
pub use adaptive::{Adaptive, AdaptiveSettings};
pub use cause::{Cause, DataFault, DataKind};
pub use krylov::KrylovSettings;
pub use linear::{Linear, MakeSolver, Purpose};
pub use report::{Attempt, Details, StepFailure, StepReport};
pub use restart::{Clock, JacobianPoint};
pub use schedule::{Next, Schedule};
pub use scheme::{Damping, DomainMotion, Scheme};
pub use stepper::{Force, Stepper, StepperSettings};
pub use system::{BlockNorms, Scales};
