//! Where the mesh may slide along the outer boundary of the fluid: n·u = 0 instead of u = 0, section 5.3.5.1.

use super::{FsiSpace, PsiOwner, normals};
use crate::math::Vector;
use crate::mesh::{Facet, INTERFACE};

/// Boundaries stand upright on each other up to this.
const UPRIGHT: f64 = 1e-9;

/// For every node that may slide its normal n.
///
/// A node slides where all facets at it carry one name and are parts of one smooth boundary: not at corners, not where
/// names meet (inflow data would leave their part), not at the solid. Boundaries that `slips` is true of, with `slip` or
/// `symmetry`, do not count where they stand upright on the other one: nodes slide along both.
pub fn sliding<const D: usize>(
    space: &FsiSpace<D>,
    slips: impl Fn(&Facet) -> bool,
) -> Vec<Option<Vector<f64, D>>> {
    #[derive(Copy, Clone, PartialEq)]
    enum Found {
        Nothing,
        One(u16),
        Several,
    }
    let mut found = vec![Found::Nothing; space.nodes.len()];
    let seams = space.seam_sides();
    let outer = || space.mesh.facets.iter().filter(|facet| !seams.contains(&facet.side()));
    let smooth = normals::normals(space, outer().filter(|facet| slips(facet)));
    for facet in outer().filter(|facet| !slips(facet)) {
        let interface = space.mesh.boundaries[facet.boundary as usize] == INTERFACE;
        let here = if interface { Found::Several } else { Found::One(facet.boundary) };
        for node in space.facet_nodes(facet) {
            let at = &mut found[node as usize];
            *at = if *at == Found::Nothing || *at == here { here } else { Found::Several };
        }
    }
    let mut slide = vec![None; space.nodes.len()];
    for (node, normals) in normals::normals(space, outer().filter(|facet| !slips(facet))) {
        let at = node as usize;
        let others = smooth.get(&node).map_or(&[][..], Vec::as_slice);
        if let ([normal], Found::One(_), PsiOwner::Extension) = (&normals[..], found[at], space.owner[at])
            && others.iter().all(|other| other.dot(*normal).abs() <= UPRIGHT)
        {
            slide[at] = Some(*normal);
        }
    }
    slide
}
