//! Moment of the force of the fluid on boundaries.

use super::force::{Surfaces, Tractions};
use super::{Functional, Snapshot};
use crate::math::{Tensor, Vector};
use crate::space::State;

/// −R_f(e × (x + u − c)): the residual of the fluid alone, tested with the rotation about a point c in space on the
/// nodes of boundaries. In the plane e is e_z, and it is in N, N m per m of depth, positive if it turns from x to y; in
/// space e is the direction of an axis \[N m\].
///
/// x + u is the mean over the step, (1 − θ) u⁻ + θ u. Nodes at the ends of the boundaries are shared out as those of
/// [`super::force::ForceByResidual`]; a facet with an outflow condition takes its surface integral.
pub struct Moment<const D: usize> {
    about: Vector<f64, D>,
    /// The coordinates that it turns into each other.
    turns: [usize; 2],
    nodes: Vec<u32>,
    /// Nodes, and what of their residual counts.
    parts: Vec<(u32, Tensor<f64, D>)>,
    /// Surface integrals of facets, tested with a node.
    tractions: Vec<(u32, Tractions<D>)>,
}

impl<const D: usize> Moment<D> {
    /// On the boundaries `names`, about a point \[m\], around the direction `axis`: 2, z, in the plane.
    pub fn new(surfaces: &Surfaces<'_, D>, names: &[String], about: [f64; D], axis: usize) -> Self {
        let shares = surfaces.shares(names);
        let whole = shares.whole.iter().map(|&node| (node, Tensor::identity()));
        let ends = shares.integrals.iter().flat_map(|(&n, at)| at.iter().map(move |&at| (n, at)));
        let outflow = shares
            .outflow
            .iter()
            .flat_map(|&n| surfaces.nodes(n).into_iter().map(move |node| (n, (node, Tensor::identity()))));
        let tested = |(n, at): (usize, (u32, Tensor<f64, D>))| (at.0, surfaces.tested(n, &[at]));
        Moment {
            about: Vector(about),
            turns: [(axis + 1) % 3, (axis + 2) % 3],
            parts: whole.chain(shares.shared.iter().copied()).collect(),
            tractions: ends.chain(outflow).map(tested).collect(),
            nodes: shares.nodes,
        }
    }
}

impl<const D: usize> Functional<D> for Moment<D> {
    fn unit(&self) -> &'static str {
        "N"
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn residual_nodes(&self) -> &[u32] {
        &self.nodes
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let theta = at.rule.theta;
        let turned = |node: u32, force: Vector<f64, D>| {
            let x = at.space.nodes.points[node as usize];
            let arm: [f64; D] = std::array::from_fn(|i| {
                let n = D * node as usize + i;
                // Without a body and walls that move there is no displacement.
                let u = |state: &State| state.u.get(n).copied().unwrap_or(0.0);
                x[i] + (1.0 - theta) * u(at.old) + theta * u(at.new) - self.about.0[i]
            });
            let [i, j] = self.turns;
            arm[i] * force.0[j] - arm[j] * force.0[i]
        };
        let residual =
            |node: u32| Vector(std::array::from_fn::<_, D, _>(|i| at.fluid_residual[D * node as usize + i]));
        let nodes: f64 = self.parts.iter().map(|&(node, part)| turned(node, part * residual(node))).sum();
        let facets: f64 = self.tractions.iter().map(|(node, facet)| turned(*node, facet.sum(at))).sum();
        -at.space.sum(nodes + facets)
    }
}
