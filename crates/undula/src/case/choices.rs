//! Tables of the choices whose values are numbers or truth values in a [`super::schema::Case`]. All other tables stand
//! beside the types of their values.

use crate::choice::{Choice, choice};

/// Whether the body force is taken at the current position.
pub static BODY_FORCE_AT: [Choice<bool>; 2] = [
    choice("reference", false, "at the position x in the reference domain"),
    choice("current", true, "at the current position x + u"),
];

/// Whether a pressure acts on the boundary in motion.
pub static PRESSURE_AT: [Choice<bool>; 2] = [
    choice("current", true, "normal and area of the boundary in motion, J F⁻ᵀ n: the load follows it"),
    choice("reference", false, "normal and area of the reference boundary: a dead load"),
];

/// Whether a spring acts on the normal part alone.
pub static SPRING_DIRECTIONS: [Choice<bool>; 2] = [
    choice("all", false, "on all components of u and v"),
    choice("normal", true, "on the part normal to the reference boundary"),
];

/// Whether a force is a surface integral.
pub static METHODS: [Choice<bool>; 2] = [
    choice("residual", false, "residual of the fluid; the more accurate way"),
    choice("surface-integral", true, "integral of the traction over the boundary"),
];

/// Whether Newton's method starts from an extrapolation.
pub static STARTS: [Choice<bool>; 2] = [
    choice("extrapolated", true, "linear extrapolation of the last two solutions"),
    choice("old", false, "last solution"),
];

/// Whether fields are written on the deformed mesh.
pub static OUTPUT_MESH: [Choice<bool>; 2] = [
    choice("deformed", true, "current positions x + u"),
    choice("reference", false, "positions x in the reference domain"),
];

/// Whether cells are written as curved as they are.
pub static OUTPUT_CELLS: [Choice<bool>; 2] = [
    choice("linear", false, "each cell divided into linear cells"),
    choice("curved", true, "cells of the degree of the velocity; VTK 9.2 to 9.7 cannot find points in them"),
];
