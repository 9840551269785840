//! Meshes of the benchmarks and of examples, of rectangles, rings and cuboids.
//!
//! Level 0 is made of blocks; level `L` is its `L`-fold uniform refinement, with the nodes on the
//! cylinder exactly on the circle at every level.

mod annulus;
mod blocks;
mod cavity;
mod channel;
mod flap;
mod hexahedra;
mod rectangle;
mod rotor;
mod schaefer_turek;
mod tube;
mod turek_hron;
mod valve;

pub use annulus::{annulus, circles};
pub use cavity::cavity;
pub use flap::flap;
pub use hexahedra::hexahedra;
pub use rectangle::rectangle;
pub use rotor::rotor;
pub use schaefer_turek::schaefer_turek;
pub use tube::{cylinders, tube, tube_2d};
pub use turek_hron::turek_hron;
pub use valve::valve;

use super::Curve;

/// Centre of the cylinder \[m\].
const CENTRE: [f64; 2] = [0.2, 0.2];
/// Radius of the cylinder \[m\].
const RADIUS: f64 = 0.05;
/// Height of the channel \[m\].
const HEIGHT: f64 = 0.41;

/// The circle of the cylinder in both benchmarks, with boundaries `cylinder` and `clamp`.
pub fn cylinder() -> Curve<2> {
    Curve::Sphere { boundaries: vec!["cylinder".into(), "clamp".into()], centre: CENTRE, radius: RADIUS }
}
