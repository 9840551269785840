//! Whether the program solves its equations, and how well they can be solved.
//!
//! `manufactured` has problems whose solution is known, `jacobians` compares all Jacobians of a case with each other,
//! and `stability` computes its inf-sup constants and condition numbers. No simulation needs this.

pub mod jacobians;
pub mod manufactured;
pub mod stability;
