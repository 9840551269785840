//! The command line of `undula plot`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `undula plot`.
#[derive(Debug, Args)]
pub struct PlotArgs {
    /// Output directory of a run
    pub dir: PathBuf,
    /// Directory for the pictures [default: DIR/plots]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Cut a run in three dimensions by this plane, such as x=0.2 [m]; z alone is the middle of the domain; may be
    /// repeated [default: across the shortest side of the domain, in its middle]
    #[arg(long, value_name = "PLANE", value_parser = plane)]
    pub cut: Vec<Plane>,
    /// What colours the surface of the bodies of a run in three dimensions; may be repeated [default: displacement]
    #[arg(long, value_name = "FIELD", require_equals = true, num_args = 0..=1, default_missing_value = "displacement")]
    pub surface: Vec<SurfaceField>,
    /// Draw all moments that the run has written into one moving picture instead: an animated PNG, or a GIF where the
    /// name ends with .gif
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "cut", "surface"])]
    pub animate: Option<PathBuf>,
    /// What a moving picture shows [default: speed, of bodies alone displacement]
    #[arg(long, value_name = "FIELD", requires = "animate")]
    pub field: Option<AnimatedField>,
    /// Moments a second of a moving picture
    #[arg(long, value_name = "N", default_value_t = 20, requires = "animate",
        value_parser = clap::value_parser!(u16).range(1..=50))]
    pub rate: u16,
}

/// What a moving picture shows.
#[derive(Copy, Clone, Debug, PartialEq, Eq, ValueEnum)]
pub enum AnimatedField {
    /// Size of the velocity
    Speed,
    /// Pressure of the fluid
    Pressure,
    /// Size of the displacement
    Displacement,
}

impl AnimatedField {
    /// Its array in a field file.
    pub fn name(self) -> &'static str {
        match self {
            AnimatedField::Speed => "velocity",
            AnimatedField::Pressure => "pressure",
            AnimatedField::Displacement => "deformation",
        }
    }
}

/// A plane across a coordinate.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Plane {
    /// The coordinate, 0 for x.
    pub axis: usize,
    /// Its value \[m\]; the middle of the domain where it is not said.
    pub at: Option<f64>,
}

/// What colours the surface of the bodies.
#[derive(Copy, Clone, Debug, PartialEq, Eq, ValueEnum)]
pub enum SurfaceField {
    /// Size of the displacement
    Displacement,
    /// Equivalent stress after von Mises
    Stress,
    /// Pressure of the fluid
    Pressure,
}

/// A plane from text such as `x=0.2` or `y`.
pub fn plane(text: &str) -> Result<Plane, String> {
    let (name, place) = text.split_once('=').map_or((text, None), |(name, place)| (name, Some(place)));
    let axis = ["x", "y", "z"].iter().position(|axis| *axis == name.trim());
    let at = place.map(|place| place.trim().parse::<f64>().ok().filter(|at| at.is_finite()));
    match (axis, at) {
        (Some(axis), None) => Ok(Plane { axis, at: None }),
        (Some(axis), Some(Some(at))) => Ok(Plane { axis, at: Some(at) }),
        (None, _) => Err(format!("`{name}` is no coordinate: expected x, y or z, such as x=0.2")),
        _ => {
            Err(format!("`{}` is no number: expected a place in m, such as {name}=0.2", place.unwrap_or("")))
        }
    }
}
