//! Undula: monolithic fluid-structure interaction on a fixed reference domain.
//!
//! One flow, one elastic solid, one nonlinear system (strict ALE, Richter, *Fluid-structure
//! Interactions*, 2017, chapter 5). Everything lives on the reference domain `Ω = F ∪ S`; no mesh is
//! ever moved.

pub mod algebra;
pub mod assembly;
pub mod element;
pub mod error;
pub mod functional;
pub mod math;
pub mod mesh;
pub mod nonlinear;
pub mod output;
pub mod physics;
pub mod problem;
pub mod run;
pub mod simulation;
pub mod space;
pub mod tangent;
pub mod time;
