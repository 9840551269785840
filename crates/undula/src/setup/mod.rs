//! From a checked case to what a computation needs: its mesh, spaces, equations and solvers.
//!
//! `mesh` makes or reads the mesh, `build` creates all else, `functionals` the functionals. Before that, `fit` compares the case with its mesh, of
//! which it knows the `names`: `regions` looks at its regions, `bodies` at their connected parts, `enclosed` at the parts
//! of the fluid that nothing opens, `ends` at the nodes of the solid, `supports` at rigid motions, `periodic` at boundaries that are one. `prestress` has the shape without stress. `functions` makes functions of expressions, `data` evaluates what is prescribed, `engine` looks for the library that solves, `memory`
//! and `seconds` estimate what it takes, `lengths` has the numbers that come from the mesh, `overview` is what `undula check`
//! prints, and `starter` is a case for a mesh of one's own.

mod axis;
mod bodies;
pub mod build;
mod data;
pub mod dimension;
mod enclosed;
mod ends;
mod engine;
mod fit;
mod functionals;
mod functions;
pub(crate) mod initial;
mod lengths;
pub mod memory;
mod mesh;
mod multigrid;
pub mod names;
mod outlets;
pub mod overview;
mod periodic;
pub(crate) mod prestress;
pub mod profile;
mod regions;
mod seconds;
mod share;
mod solvers;
pub mod starter;
mod supports;
mod terms;
