//! Where a boundary of the fluid ends at the solid.

use super::{BoundaryCondition, FsiSpace, PsiOwner, Region};

/// What becomes of a node of the solid on a boundary of the fluid, where no condition of the solid holds it; from the
/// weakest to the strongest.
///
/// u and v of a node of the solid are one thing (∂_t u = v): both are free, or both are given.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EndKind {
    /// On an outflow: u and v are free, and u is free on all of that outflow.
    Free,
    /// On a boundary with velocity data, which must vanish there: u = 0.
    Inflow,
    /// On a fixed wall: u = 0, v = 0.
    Wall,
}

/// A node of the solid at which a boundary of the fluid ends.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct End {
    /// The node.
    pub node: u32,
    /// The boundary of the fluid that rules there.
    pub boundary: u16,
    /// What becomes of the node.
    pub kind: EndKind,
}

/// Nodes that a condition on a facet of the solid holds, in some direction at least.
fn held<const D: usize>(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Vec<bool> {
    let mut held = vec![false; space.nodes.len()];
    for facet in space.mesh.facets.iter().filter(|f| space.regions[f.cell as usize] == Region::Solid) {
        let condition = &conditions[facet.boundary as usize];
        if !matches!(condition, BoundaryCondition::Outflow { .. } | BoundaryCondition::Free) {
            space.facet_nodes(facet).into_iter().for_each(|node| held[node as usize] = true);
        }
    }
    held
}

/// All nodes of the solid at which a boundary of the fluid ends and which the solid's own conditions leave free,
/// ascending.
pub fn ends<const D: usize>(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Vec<End> {
    if !space.deforms {
        return vec![];
    }
    let held = held(space, conditions);
    let mut found: Vec<Option<(EndKind, u16)>> = vec![None; space.nodes.len()];
    for facet in space.mesh.facets.iter().filter(|f| space.regions[f.cell as usize] == Region::Fluid) {
        let kind = match &conditions[facet.boundary as usize] {
            BoundaryCondition::Fixed => EndKind::Wall,
            BoundaryCondition::Velocity(_) => EndKind::Inflow,
            BoundaryCondition::Outflow { .. } => EndKind::Free,
            BoundaryCondition::Slip | BoundaryCondition::Displacement(_) | BoundaryCondition::Free => {
                continue;
            }
        };
        for node in space.facet_nodes(facet).into_iter().map(|node| node as usize) {
            if space.owner[node] == PsiOwner::Relation && !held[node] {
                found[node] = found[node].max(Some((kind, facet.boundary)));
            }
        }
    }
    let end = |(node, found): (usize, Option<(EndKind, u16)>)| {
        found.map(|(kind, boundary)| End { node: node as u32, boundary, kind })
    };
    found.into_iter().enumerate().filter_map(end).collect()
}

/// For each boundary whether it is an outflow that moves along with a free end of the solid, or with a boundary whose
/// displacement is given.
pub fn moving<const D: usize>(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Vec<bool> {
    let mut free = vec![false; space.nodes.len()];
    for end in ends(space, conditions).iter().filter(|end| end.kind == EndKind::Free) {
        free[end.node as usize] = true;
    }
    let displaced = |b: u16| matches!(conditions[b as usize], BoundaryCondition::Displacement(_));
    for facet in space.mesh.facets.iter().filter(|facet| displaced(facet.boundary)) {
        space.facet_nodes(facet).into_iter().for_each(|node| free[node as usize] = true);
    }
    let mut moving = vec![false; space.mesh.boundaries.len()];
    for facet in space.mesh.facets.iter().filter(|f| space.regions[f.cell as usize] == Region::Fluid) {
        let outflow = matches!(conditions[facet.boundary as usize], BoundaryCondition::Outflow { .. });
        if outflow && space.facet_nodes(facet).iter().any(|&node| free[node as usize]) {
            moving[facet.boundary as usize] = true;
        }
    }
    moving
}
