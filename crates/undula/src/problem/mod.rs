//! From a case file to a checked, runnable description.
//!
//! `expression` and `error` stand alone; `raw` is the TOML with overrides, `read` reads one table,
//! `check` makes a [`case::Case`] of it and `fit` compares that with a mesh; `write` is the way back,
//! `builtin` the cases shipped with the program, `reference` their published results, `results` what a run has
//! left, and `compare` the tables that set results side by side. `manufactured` makes problems whose solution is known.

pub mod build;
pub mod builtin;
pub mod case;
mod check;
pub mod compare;
pub mod element;
pub mod error;
pub mod expression;
pub mod fit;
pub mod manufactured;
pub mod overview;
mod raw;
mod read;
pub mod reference;
pub mod results;
mod write;
