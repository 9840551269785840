//! Numbers of bodies in space.

use super::body_energy::Body;
use super::{Functional, Snapshot};
use crate::space::coordinates::unit_of_space;

/// A functional whose integrals are those over bodies in space or of revolution, so that the units are those of space
/// instead of those per depth.
pub struct Spatial<const D: usize>(pub Box<dyn Functional<D>>);

impl<const D: usize> Functional<D> for Spatial<D> {
    fn unit(&self) -> &'static str {
        unit_of_space(self.0.unit())
    }

    fn at_force_time(&self) -> bool {
        self.0.at_force_time()
    }

    fn residual_nodes(&self) -> &[u32] {
        self.0.residual_nodes()
    }

    fn residual_body(&self) -> Option<Body> {
        self.0.residual_body()
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        self.0.evaluate(at)
    }
}
