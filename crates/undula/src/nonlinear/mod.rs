//! Solving the nonlinear system of a step.

pub mod newton;
pub mod secants;
mod system;

pub use newton::{Age, Counters, Newton, NewtonError, NewtonReport, Settings};
pub use system::{NonlinearSystem, Seconds};
