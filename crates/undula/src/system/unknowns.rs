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
        for (dof, x) in space.pressure.points.iter().enumerate() {
            // Continuous pressures sit on vertices, which are nodes of the velocity, too.
            let node = match space.pressure.kind {
                PressureKind::Pdc(_) => first + dof as u32 / space.pressure.per_cell as u32,
                PressureKind::Continuous(_) => space.pressure_node(dof),
            };
            list.push(Unknown { node, kind: Kind::Pressure, at: position(x) });
        }
        list
    }
}

/// Rows of unknowns that are given, ascending.
pub(super) fn given_rows<const D: usize>(space: &FsiSpace<D>, constraints: &Constraints<D>) -> Vec<u32> {
    let velocity = constraints.v.iter().flatten().copied();
    let deformation = constraints.u.iter().flatten().copied();
    let all = velocity.chain(deformation.filter(|_| space.deforms));
    all.zip(0..).filter(|(given, _)| *given).map(|(_, row)| row).collect()
}
