//! Where the mesh may slide along the outer boundary of the fluid: n·u = 0 instead of u = 0, section 5.3.5.1.

use super::{FsiSpace, PsiOwner};
use crate::mesh::INTERFACE;

/// Normals of facets agree with an axis up to this part of the facet's size.
const STRAIGHT: f64 = 1e-9;

/// For every node that may slide the axis of its normal n.
///
/// A node slides where all facets at it carry one name and lie in one plane normal to one axis: not at corners,
/// not where names meet (inflow data would leave their part), not at the solid, not on curved or inclined parts.
pub fn normals<const D: usize>(space: &FsiSpace<D>) -> Vec<Option<usize>> {
    #[derive(Copy, Clone, PartialEq)]
    enum Found {
        Nothing,
        One { axis: usize, boundary: u16 },
        Several,
    }
    let mut found = vec![Found::Nothing; space.nodes.len()];
    for facet in &space.mesh.facets {
        let interface = space.mesh.boundaries[facet.boundary as usize] == INTERFACE;
        let nodes = space.facet_nodes(facet);
        let here = match axis(space, &nodes).filter(|_| !interface) {
            Some(axis) => Found::One { axis, boundary: facet.boundary },
            None => Found::Several,
        };
        for node in nodes {
            let at = &mut found[node as usize];
            *at = if *at == Found::Nothing || *at == here { here } else { Found::Several };
        }
    }
    let in_fluid = |node: usize| space.owner[node] == PsiOwner::Extension;
    let normal = |(node, found)| match found {
        Found::One { axis, .. } if in_fluid(node) => Some(axis),
        _ => None,
    };
    found.into_iter().enumerate().map(normal).collect()
}

/// The axis that is normal to the plane through `nodes`, if there is one.
fn axis<const D: usize>(space: &FsiSpace<D>, nodes: &[u32]) -> Option<usize> {
    let extent = |d: usize| {
        let along = nodes.iter().map(|&n| space.nodes.points[n as usize][d]);
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    };
    let size = (0..D).map(extent).fold(0.0, f64::max);
    (0..D).find(|&d| extent(d) <= STRAIGHT * size)
}
