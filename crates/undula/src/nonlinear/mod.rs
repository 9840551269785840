//! Solving the nonlinear system of a step.

pub mod newton;
pub mod secants;

pub use newton::{Age, Counters, Newton, NewtonError, NewtonReport, NonlinearSystem, Seconds, Settings};
