//! What runs have computed, beside published values and beside each other.
//!
//! `computed` is what one run left in its directory, read by the readers of [`crate::output`]; `reference` has the
//! published values of a case, and `compare` makes the tables that set all of these side by side.

pub mod compare;
pub mod computed;
pub mod reference;
