//! Meshes of the benchmarks and of examples, of rectangles, rings and cuboids.
//!
//! Level 0 is made of blocks; level `L` is its `L`-fold uniform refinement, with the nodes on the
//! cylinder exactly on the circle at every level.

mod annulus;
mod blocks;
mod cavity;
mod channel;
mod cook;
mod flap;
mod fsi_box;
mod hexahedra;
mod rectangle;
mod rotor;
mod schaefer_turek;
mod tube;
mod turek_hron;
mod valve;

pub use annulus::{annulus, circles};
pub use cavity::cavity;
pub use cook::cook;
pub use flap::flap;
pub use fsi_box::fsi_box;
pub use hexahedra::hexahedra;
pub use rectangle::rectangle;
pub use rotor::rotor;
pub use schaefer_turek::{dfg_3d, schaefer_turek};
pub use tube::{bend, cylinders, tube, tube_2d, tube_graded};
pub use turek_hron::turek_hron;
pub use valve::valve;

use super::Curve;

/// Centre of the cylinder \[m\].
const CENTRE: [f64; 2] = [0.2, 0.2];
/// Radius of the cylinder \[m\].
const RADIUS: f64 = 0.05;
/// Height of the channel \[m\].
const HEIGHT: f64 = 0.41;
/// What the channel of the benchmark in space is longer before the cylinder \[m\].
const BEFORE: f64 = 0.3;

/// The circle of the cylinder in both benchmarks, with boundaries `cylinder` and `clamp`.
pub fn cylinder() -> Curve<2> {
    Curve::Sphere { boundaries: vec!["cylinder".into(), "clamp".into()], centre: CENTRE, radius: RADIUS }
}

/// That of the section of the benchmark in space.
pub fn cylinder_of_dfg_3d() -> Curve<2> {
    let centre = [CENTRE[0] + BEFORE, CENTRE[1]];
    Curve::Sphere { boundaries: vec!["cylinder".into()], centre, radius: RADIUS }
}
