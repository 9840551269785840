//! The language of cases: what a case file may say, and what it means.
//!
//! [`Case`] and its parts stand in `schema`. On the way from a text to a case, `raw` reads TOML with the overrides,
//! `read` one table, `check` the whole case, so that all mistakes are told at once (`error`); `write` is the way back,
//! and `builtin` has the cases of the program. Of the language itself, `keys` has the table of all keys, `synonyms`
//! their other names, `choices` and `element` values by name, `conditions` those on boundaries, `backflow` their terms against flow that comes in, `profile` profiles of flows, `functionals` the kinds of
//! functionals, `bodies` fluids and solids, `expression` the
//! formulas in x, y and t with tables of values, `expressions` those of a case, `fibres` the directions of fibres, `unit` units, `key` dotted keys and `literal` numbers and words. Nothing here looks at the cells of a mesh:
//! that is `crate::setup`.

mod backflow;
mod bodies;
pub mod builtin;
mod check;
pub mod choices;
pub mod conditions;
pub mod element;
pub mod error;
pub mod expression;
mod expressions;
mod fibres;
pub mod functionals;
pub mod initial;
pub(crate) mod key;
pub mod keys;
pub(crate) mod literal;
mod material_keys;
mod mesh_keys;
pub mod profile;
mod raw;
mod read;
pub mod schema;
mod synonyms;
pub mod unit;
mod write;

pub(crate) use bodies::Load;
pub use check::name_of_file;
pub use conditions::{CONDITIONS, Condition};
pub use element::{PressureElement, VelocityElement};
pub use functionals::{FUNCTIONALS, FunctionalSpec, Site};
pub use initial::Initial;
pub use profile::Profile;
pub use schema::{
    AdaptiveSettings, Case, DomainMotion, FluidSpec, GENERATORS, GMRES, Integral, KRYLOV, LinearSolverKind,
    LinearSpec, Linearization, MeshSource, MeshSpec, MotionModel, MotionSpec, NewtonSpec, OutputSpec,
    OwnMesh, Precision, Record, Scheme, SolidLaw, SolidSpec, SpaceSpec, Tangent, TimeSpec, WITH_MULTIGRID,
};
