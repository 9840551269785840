//! From a case file to a checked, runnable description.
//!
//! `expression` and `error` stand alone; `raw` is the TOML with overrides, `read` reads one table,
//! `check` makes a [`case::Case`] of it and `fit` compares that with a mesh: `regions` with its regions, `bodies` with
//! their connected parts, `enclosed` with those of the fluid that nothing opens. `write` is the way back,
//! `builtin` the cases shipped with the program, `reference` their published results and `compare` the
//! tables that set results side by side. `manufactured` makes problems whose solution is known.

mod bodies;
pub mod build;
pub mod builtin;
pub mod case;
mod check;
pub mod compare;
pub mod element;
mod enclosed;
pub mod error;
pub mod expression;
pub mod fit;
pub mod manufactured;
pub mod overview;
mod raw;
mod read;
pub mod reference;
mod regions;
mod write;
