//! What holds on a boundary.

use crate::choice::{Choice, choice};
use std::sync::Arc;

/// A velocity given as a function of position and time \[m/s\].
pub type VelocityData<const D: usize> = Arc<dyn Fn(&[f64; D], f64) -> [f64; D] + Send + Sync>;

/// A displacement given as a function of reference position and time: for each component u \[m\] and ∂_t u \[m/s\], or
/// `None` where it is free.
pub type MotionData<const D: usize> = Arc<dyn Fn(&[f64; D], f64) -> [Option<[f64; 2]>; D] + Send + Sync>;

/// What holds on a named boundary, as far as the spaces are concerned. On each facet it means what it can mean to the
/// body of its cell.
#[derive(Clone)]
pub enum BoundaryCondition<const D: usize> {
    /// v given, u = 0.
    Velocity(VelocityData<D>),
    /// v = 0, u = 0.
    Fixed,
    /// u given, v = ∂_t u; components may be free.
    Displacement(MotionData<D>),
    /// n·v = 0, n·u = 0, free along the boundary.
    Slip,
    /// Of the fluid: v free, u = 0. Where a free end of the solid meets the boundary, all of it moves along: u is
    /// free there, too, with the natural condition of the extension, see [`super::ends`]. Of the solid: as `Free`.
    Outflow {
        /// Apply the correction that makes the condition do-nothing instead of traction-free.
        do_nothing: bool,
        /// The term against flow that comes in.
        backflow: Against,
    },
    /// v and u free: surface of the solid without traction, and seams of the domain.
    Free,
}

/// The term against flow that comes in through an outlet, see [`crate::physics::Backflow`].
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Against {
    /// There is none.
    #[default]
    None,
    /// It takes out the kinetic energy of the flow.
    Directional,
    /// It takes out that of the flow along the boundary.
    Tangential,
}

/// Their names in a case.
pub static BACKFLOW: [Choice<Against>; 3] = [
    choice("none", Against::None, "no term against flow that comes in"),
    choice("directional", Against::Directional, "directional do-nothing condition (Braack and Mucha 2014)"),
    choice(
        "tangential",
        Against::Tangential,
        "its part along the boundary: flow straight in is as without it",
    ),
];

/// What the deformation does on the outer boundary of the fluid.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Walls {
    /// u = 0.
    #[default]
    Fixed,
    /// n·u = 0 with the normals of [`super::normals`]; u = 0 at corners and where boundaries meet.
    Sliding,
}

/// Their names in a case.
pub static WALLS: [Choice<Walls>; 2] = [
    choice("fixed", Walls::Fixed, "the mesh does not move on the outer boundary"),
    choice("sliding", Walls::Sliding, "the mesh slides along outer boundaries, n·u = 0"),
];
