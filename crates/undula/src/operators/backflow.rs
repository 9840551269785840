//! The directional term on outlets, against flow that comes in.

use super::End;
use super::facets::{FacetOperator, FacetTerm};
use crate::mesh::Facet;
use crate::physics::{Backflow, Fluid};
use crate::space::{BoundaryCondition, FsiSpace, Region};

/// ρ of the term.
pub struct Directional(Backflow);

impl<const D: usize> FacetTerm<D> for Directional {
    type Form = Backflow;
    const RATE: bool = true;
    const DEPENDS: [bool; 2] = [true, true];

    fn form(&self, _: usize, _: End) -> Backflow {
        self.0
    }
}

/// The term on the outlets of a fluid with its material, whose condition has it, `n` Gauss points per direction.
pub fn directional<const D: usize>(
    space: &FsiSpace<D>,
    (material, fluid): (u16, Fluid),
    conditions: &[BoundaryCondition<D>],
    n: usize,
) -> FacetOperator<Directional, D> {
    let here = |facet: &Facet| {
        let condition = &conditions[facet.boundary as usize];
        space.material[facet.cell as usize] == material
            && matches!(condition, BoundaryCondition::Outflow { directional: true, .. })
    };
    let form = Backflow { density: fluid.rho };
    FacetOperator::new(space, Region::Fluid, |facet| here(facet), n, |_| Directional(form))
}
