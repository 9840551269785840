//! What a solid has at the points of a region from the start, taken when the operator is made.

use super::nodal::interpolate;
use crate::loops::batch::Batches;
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
    let mut nodal = vec![Vector::<f64, D>::zero(); n];
    let mut all = Vec::with_capacity(batches.positions.len());
    for (index, position) in batches.positions.iter().enumerate() {
        let (batch, q) = (index / n_points, index % n_points);
        let basis = &batches.basis[q * n * (1 + D)..(q + 1) * n * (1 + D)];
        let mut fabric = Fabric::<Lanes<L>, D>::plain();
        for l in 0..L {
            let at = space.fibre_at(material, &position.0.map(|x| x.0[l]));
            (0..D).for_each(|i| fabric.fibre.0[i].0[l] = at[i]);
            if space.fabrics.unloading.is_empty() {
                continue;
            }
            for (u, lanes) in nodal.iter_mut().zip(&batches.nodes[batch * n..]) {
                *u = Vector(std::array::from_fn(|i| space.fabrics.unloading[lanes[l] as usize * D + i]));
            }
            let inverse = batches.points[index].inverse.map(|x| x.0[l]);
            let (value, grad) = interpolate(basis, &nodal, &inverse);
            for i in 0..D {
                (0..D).for_each(|j| fabric.unloading.0[i][j].0[l] = grad.0[i][j]);
            }
            if space.coordinates.is_axisymmetric() {
                fabric.hoop.0[l] = value.0[0] / position.0[0].0[l];
            }
        }
        all.push(fabric);
    }
    all
}
