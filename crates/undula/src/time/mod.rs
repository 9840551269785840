//! Steps in time.

pub mod adaptive;
pub mod cause;
pub mod fractional_step;
pub mod kept;
pub mod memory;
pub mod report;
mod retry;
mod runge_kutta;
pub mod schedule;
pub mod scheme;
mod single_step;
mod solver;
mod stages;
mod stationary;
pub mod stepper;
pub mod system;
pub mod tableau;

pub use crate::nonlinear::NewtonSettings;
pub use crate::tangent::Linearization;
pub use adaptive::{Adaptive, AdaptiveSettings};
pub use cause::{Cause, DataFault, DataKind};
pub use kept::JacobianPoint;
pub use memory::{Clock, Memory};
pub use report::{Attempt, Details, StepFailure, StepReport};
pub use schedule::{Next, Schedule};
pub use scheme::{Damping, DomainMotion, Scheme};
pub use stepper::{Force, MaterialForce, Stepper, StepperSettings};
