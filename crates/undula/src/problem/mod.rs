//! From a case file to a checked, runnable description.

pub mod case;
pub mod error;
pub mod expression;
