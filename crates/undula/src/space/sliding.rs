//! Where the mesh may slide along the outer boundary of the fluid: n·u = 0 instead of u = 0, section 5.3.5.1.

use super::{FsiSpace, PsiOwner, normals};
use crate::math::Vector;
use crate::mesh::INTERFACE;

/// For every node that may slide its normal n.
///
/// A node slides where all facets at it carry one name and are parts of one smooth boundary: not at corners, not where
/// names meet (inflow data would leave their part), not at the solid.
pub fn sliding<const D: usize>(space: &FsiSpace<D>) -> Vec<Option<Vector<f64, D>>> {
    #[derive(Copy, Clone, PartialEq)]
    enum Found {
        Nothing,
        One(u16),
        Several,
    }
    let mut found = vec![Found::Nothing; space.nodes.len()];
    let seams = space.seam_sides();
    let outer = || space.mesh.facets.iter().filter(|facet| !seams.contains(&facet.side()));
    for facet in outer() {
        let interface = space.mesh.boundaries[facet.boundary as usize] == INTERFACE;
        let here = if interface { Found::Several } else { Found::One(facet.boundary) };
        for node in space.facet_nodes(facet) {
            let at = &mut found[node as usize];
            *at = if *at == Found::Nothing || *at == here { here } else { Found::Several };
        }
    }
    let mut slide = vec![None; space.nodes.len()];
    for (node, normals) in normals::normals(space, outer()) {
        let at = node as usize;
        if let ([normal], Found::One(_), PsiOwner::Extension) = (&normals[..], found[at], space.owner[at]) {
            slide[at] = Some(*normal);
        }
    }
    slide
}
