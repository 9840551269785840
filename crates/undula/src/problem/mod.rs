//! From a case file to a checked, runnable description.
//!
//! `expression`, `error` and `key` stand alone; `keys` is the table of all keys, `choices` has tables of their values; `raw` is the TOML with overrides, `read` reads one table (`synonyms` has
//! other names of its keys),
//! `check` makes a [`case::Case`] of it and `fit` compares that with a mesh: `regions` with its regions, `bodies` with
//! their connected parts, `enclosed` with those of the fluid that nothing opens, `ends` with the nodes of the solid,
//! `data` evaluates what is given on it.
//! `functionals` has all that a case says of its functionals. `write` is the way back, `builder` makes cases in a
//! program,
//! `builtin` the cases shipped with the program. `lengths` has the numbers that come from the mesh.

mod bodies;
pub mod build;
pub mod builder;
pub mod builtin;
pub mod case;
mod check;
pub mod choices;
mod data;
pub mod element;
mod enclosed;
mod ends;
pub mod error;
pub mod expression;
pub mod fit;
pub mod functionals;
pub(crate) mod key;
pub mod keys;
mod lengths;
pub mod memory;
pub mod overview;
mod raw;
mod read;
mod regions;
mod synonyms;
mod write;

pub use check::name_of_file;
