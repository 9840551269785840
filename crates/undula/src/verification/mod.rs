//! Whether the program solves its equations, and how well they can be solved.
//!
//! `manufactured` has problems whose solution is known, `unit_square` two of them with their errors, `newmark` another
//! method for the elastic body, `jacobians` compares all Jacobians of a case with each other, `matrix` describes the
//! blocks of one, and `stability` computes inf-sup constants and condition numbers. No simulation needs this.

pub mod jacobians;
pub mod manufactured;
pub mod matrix;
pub mod newmark;
pub mod stability;
pub mod unit_square;
