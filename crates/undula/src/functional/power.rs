//! Power of the force of the fluid on boundaries.

use super::force::Surfaces;
use super::{Functional, Snapshot};

/// −R_f(v): the residual of the fluid alone, tested with the velocity at the nodes of boundaries where it is not free,
/// and with 0 elsewhere \[W/m\].
///
/// That is what the fluid does to an elastic body, to the order of the time scheme the change of its energy: the
/// residual of the solid is the opposite at the interface. v is (1 − θ) v⁻ + θ v. A node at which the boundaries end
/// counts as a whole; v is 0 there where they end at a wall.
pub struct Power {
    nodes: Vec<u32>,
}

impl Power {
    /// On the boundaries `names`.
    pub fn new<const D: usize>(surfaces: &Surfaces<'_, D>, names: &[String]) -> Self {
        Power { nodes: surfaces.nodes_on(names) }
    }
}

impl<const D: usize> Functional<D> for Power {
    fn unit(&self) -> &'static str {
        "W/m"
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn residual_nodes(&self) -> &[u32] {
        &self.nodes
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let theta = at.rule.theta;
        let power = |n: usize| ((1.0 - theta) * at.old.v[n] + theta * at.new.v[n]) * at.fluid_residual[n];
        let entries = self.nodes.iter().flat_map(|&node| (0..D).map(move |i| node as usize * D + i));
        -at.space.sum(entries.map(power).sum::<f64>())
    }
}
