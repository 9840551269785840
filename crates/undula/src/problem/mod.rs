//! From a case file to a checked, runnable description.
//!
//! `expression` and `error` stand alone; `raw` is the TOML with overrides, `read` reads one table,
//! `check` makes a [`case::Case`] of it, `fit` compares that with a mesh, `data` evaluates what is given on it; `write` is the way back,
//! `builtin` the cases shipped with the program, `reference` their published results and `compare` the
//! tables that set results side by side. `manufactured` makes problems whose solution is known.

pub mod build;
pub mod builtin;
pub mod case;
mod check;
pub mod compare;
mod data;
pub mod element;
pub mod error;
pub mod expression;
pub mod fit;
pub mod manufactured;
mod raw;
mod read;
pub mod reference;
mod write;
