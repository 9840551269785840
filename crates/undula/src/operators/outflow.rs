//! The do-nothing correction on outlets.

use super::End;
use super::facets::{FacetOperator, FacetTerm};
use crate::mesh::Facet;
use crate::physics::{Fluid, Outflow};
use crate::space::{BoundaryCondition, FsiSpace, Region};

/// ρν of the correction.
pub struct Correction(Outflow);

impl<const D: usize> FacetTerm<D> for Correction {
    type Form = Outflow;
    const DEPENDS: [bool; 2] = [true, true];

    fn form(&self, _: usize, _: End) -> Outflow {
        self.0
    }
}

/// The correction on the outlets of a fluid with its material, whose condition has it, `n` Gauss points per direction.
pub fn correction<const D: usize>(
    space: &FsiSpace<D>,
    (material, fluid): (u16, Fluid),
    conditions: &[BoundaryCondition<D>],
    n: usize,
) -> FacetOperator<Correction, D> {
    let here = |facet: &Facet| {
        let condition = &conditions[facet.boundary as usize];
        space.material[facet.cell as usize] == material
            && matches!(condition, BoundaryCondition::Outflow { do_nothing: true, .. })
    };
    let form = Outflow { viscosity: fluid.rho * fluid.nu, thinning: fluid.thinning };
    FacetOperator::new(space, Region::Fluid, |facet| here(facet), n, |_| Correction(form))
}
