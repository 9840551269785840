//! Solving the nonlinear system of a step.

mod error;
mod newton;
mod renewal;
mod report;
mod secants;
mod system;

pub use error::NewtonError;
pub use newton::{GROWTH, Memory, Newton, NewtonSettings};
pub use renewal::Age;
pub use report::{Counters, NewtonReport, Seconds};
pub use system::NonlinearSystem;
