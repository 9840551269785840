//! The equations of chapter 5, one quadrature point at a time.
//!
//! A form sees values and gradients at one point and returns what stands before each test function.
//! It knows no mesh, no index, no time step: [`step`] composes a form into the residual of one step.
#![allow(non_snake_case)]

pub mod axisymmetric;
pub mod damping;
pub mod extension;
pub mod fibres;
pub mod fields;
pub mod fluid;
pub mod form;
pub mod isochoric;
pub mod kinematics;
mod law;
mod loaded;
pub mod material;
pub mod ogden;
pub mod outflow;
pub mod pressure;
pub mod reference;
pub mod rule;
pub mod solid;
pub mod solid_law;
pub mod spring;
pub mod stabilization;
pub mod step;
pub mod stored_energy;
pub mod stress;
pub mod theorem_5_2;
pub mod viscosity;

pub use axisymmetric::Axisymmetric;
pub use damping::Damping;
pub use extension::{Extension, MotionModel};
pub use fibres::{Artery, Muscle};
pub use fields::{Dots, Fabric, Fields, Place, Tested};
pub use fluid::Fluid;
pub use form::{Couplings, FacetForm, Inertia, WeakForm};
pub use isochoric::IsochoricNeoHookean;
pub use kinematics::Kinematics;
pub use material::Material;
pub use ogden::Ogden;
pub use outflow::{Backflow, Outflow};
pub use pressure::Pressure;
pub use reference::Reference;
pub use rule::StepRule;
pub use solid::Solid;
pub use solid_law::SolidLaw;
pub use spring::Spring;
pub use stabilization::{Mapping, PressureTerm, Projection, Stabilization, TransportTerm};
pub use stored_energy::{Deformation, OwnLaw, StoredEnergy};
pub use viscosity::{CarreauYasuda, FluidLaw};
