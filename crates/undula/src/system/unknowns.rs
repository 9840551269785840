//! What linear solvers may know of the unknowns.

use super::Assembler;
use crate::algebra::{Kind, Unknown};
use crate::space::{Constraints, FsiSpace, PressureKind};

impl<const D: usize> Assembler<D> {
    /// What the linear solver may know of each unknown.
    pub fn unknowns(&self) -> Vec<Unknown> {
        let space = &self.space;
        let position = |x: &[f64; D]| std::array::from_fn(|d| if d < D { x[d] } else { 0.0 });
        let mut list = vec![];
        for kind in [Kind::Velocity, Kind::Deformation] {
            if kind == Kind::Velocity || space.deforms {
                for (node, x) in space.nodes.points.iter().enumerate() {
                    list.extend([Unknown { node: node as u32, kind, at: position(x) }; D]);
                }
            }
        }
        let first = space.nodes.len() as u32;
        let given = self.is_given();
        let homes = homes(space, |node| !given[node as usize * D..][..D].iter().all(|given| *given));
        for (dof, x) in space.pressure.points.iter().enumerate() {
            let node = match space.pressure.kind {
                PressureKind::Pdc(_) => first + dof as u32 / space.pressure.per_cell as u32,
                PressureKind::Continuous(_) => homes[dof],
            };
            list.push(Unknown { node, kind: Kind::Pressure, at: position(x) });
        }
        list
    }
}

/// The nodes that continuous pressures are eliminated with; no others if the pressure is discontinuous.
///
/// It is their own, which is one of the velocity, too. Where v is not free there, it is the nearest node of a facet around
/// it at which v is: no pressure has a pivot before a velocity beside it is eliminated.
pub(crate) fn homes<const D: usize>(space: &FsiSpace<D>, is_free: impl Fn(u32) -> bool) -> Vec<u32> {
    if !matches!(space.pressure.kind, PressureKind::Continuous(_)) {
        return vec![];
    }
    let (nodes, shape) = (&space.nodes, space.mesh.shape);
    let mut on_facets: Vec<usize> =
        (0..shape.n_facets()).flat_map(|facet| shape.facet_nodes(nodes.degree, facet)).collect();
    on_facets.sort_unstable();
    on_facets.dedup();
    let mut homes: Vec<u32> = (0..space.pressure.n).map(|dof| space.pressure_node(dof)).collect();
    let mut nearest = vec![f64::INFINITY; homes.len()];
    for cell in 0..space.mesh.n_cells() {
        for &dof in space.pressure.cell(cell) {
            let own = space.pressure_node(dof as usize);
            if is_free(own) {
                continue;
            }
            let around = on_facets.iter().map(|&local| nodes.cell(cell)[local]);
            for node in around.filter(|&node| is_free(node)) {
                let [own, other] = [own, node].map(|node| &nodes.points[node as usize]);
                let far: f64 = own.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
                if far < nearest[dof as usize] {
                    (nearest[dof as usize], homes[dof as usize]) = (far, node);
                }
            }
        }
    }
    homes
}

/// Rows of unknowns that are given, ascending.
pub(super) fn given_rows<const D: usize>(space: &FsiSpace<D>, constraints: &Constraints<D>) -> Vec<u32> {
    let velocity = constraints.v.iter().flatten().copied();
    let deformation = constraints.u.iter().flatten().copied();
    let all = velocity.chain(deformation.filter(|_| space.deforms));
    all.zip(0..).filter(|(given, _)| *given).map(|(_, row)| row).collect()
}
