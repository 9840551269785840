//! What the coordinates of the mesh mean.

use crate::choice::{Choice, choice};
use std::f64::consts::TAU;

/// Coordinates of the mesh.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Coordinates {
    /// (x, y): the plane, or (x, y, z).
    #[default]
    Cartesian,
    /// (r, z): a body of revolution about the axis r = 0. Nothing depends on the angle or moves around the axis. Integrals
    /// are those over the whole body.
    Axisymmetric,
}

/// Their names in a case.
pub static COORDINATES: [Choice<Coordinates>; 2] = [
    choice("cartesian", Coordinates::Cartesian, "(x, y) in the plane; integrals are per unit depth"),
    choice(
        "axisymmetric",
        Coordinates::Axisymmetric,
        "(r, z) around the axis r = 0; integrals are those over the whole body",
    ),
];

impl Coordinates {
    /// Whether the mesh is the half of a section through a body of revolution.
    pub fn is_axisymmetric(self) -> bool {
        self == Coordinates::Axisymmetric
    }

    /// The volume that an element of the mesh at `x` \[m\] stands for, per volume of the mesh: 1, or 2π r \[m\].
    #[inline(always)]
    pub fn measure<const D: usize>(self, x: &[f64; D]) -> f64 {
        match self {
            Coordinates::Cartesian => 1.0,
            Coordinates::Axisymmetric => TAU * x[0],
        }
    }

    /// The distance r to the axis \[m\], if there is one.
    #[inline(always)]
    pub fn radius<const D: usize>(self, x: &[f64; D]) -> Option<f64> {
        self.is_axisymmetric().then_some(x[0])
    }

    /// Number of directions of what a mesh of dimension `dim` stands for: volumes are in m^n.
    pub fn dimension(self, dim: usize) -> usize {
        if self.is_axisymmetric() { dim + 1 } else { dim }
    }
}

/// The unit in space of an integral, or of what stands beside one, that has the unit `of_plane` per depth.
pub fn unit_of_space(of_plane: &str) -> &str {
    match of_plane {
        "m²" => "m³",
        "m²/s" => "m³/s",
        "m³/s" => "m⁴/s",
        "N/m" => "N",
        "N" => "N m",
        "J/m" => "J",
        "W/m" => "W",
        "Pa s/m²" => "Pa s/m³",
        "m²/Pa" => "m³/Pa",
        other => other,
    }
}
