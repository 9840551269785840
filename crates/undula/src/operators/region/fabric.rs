//! What a solid has at the points of a region from the start, taken when the operator is made.

use crate::loops::batch::Batches;
use crate::loops::evaluate::{gather, interpolate};
use crate::math::{Lanes, Vector};
use crate::physics::Fabric;
use crate::space::{FsiSpace, Region};

/// The fabric at all points, `[batch][point]`; empty: plain.
pub(super) fn fabric<const D: usize, const L: usize>(
    space: &FsiSpace<D>,
    (region, material): (Region, u16),
    batches: &Batches<D, L>,
) -> Vec<Fabric<Lanes<L>, D>> {
    if region == Region::Fluid || !space.has_fabric(material) {
        return vec![];
    }
    let (n, n_points) = (batches.n_basis, batches.n_points);
    let mut nodal = vec![Vector::<Lanes<L>, D>::zero(); n];
    let mut all = Vec::with_capacity(batches.positions.len());
    for (index, position) in batches.positions.iter().enumerate() {
        let (batch, q) = (index / n_points, index % n_points);
        let mut fabric = Fabric::<Lanes<L>, D>::plain();
        for l in 0..L {
            let at = space.fibre_at(material, &position.0.map(|x| x.0[l]));
            (0..D).for_each(|i| fabric.fibre.0[i].0[l] = at[i]);
        }
        if !space.fabrics.unloading.is_empty() {
            gather(&batches.nodes[batch * n..(batch + 1) * n], &space.fabrics.unloading, &mut nodal);
            let basis = &batches.basis[q * n * (1 + D)..(q + 1) * n * (1 + D)];
            let (value, grad) = interpolate(basis, &nodal, &batches.points[index].inverse);
            fabric.unloading = grad;
            if space.coordinates.is_axisymmetric() {
                fabric.hoop = value.0[0] / position.0[0];
            }
        }
        all.push(fabric);
    }
    all
}
