//! Numbers of a whole body of revolution.

use super::body_energy::Body;
use super::{Functional, Snapshot};
use crate::space::Coordinates;

/// A functional whose integrals are those over a body of revolution: the units of space instead of those per depth.
pub struct AroundAxis<const D: usize>(pub Box<dyn Functional<D>>);

impl<const D: usize> Functional<D> for AroundAxis<D> {
    fn unit(&self) -> &'static str {
        Coordinates::Axisymmetric.unit(self.0.unit())
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
