//! The terms on outlets against flow that comes in.

use super::End;
use super::facets::{FacetOperator, FacetTerm};
use crate::mesh::Facet;
use crate::physics::{Backflow, Fluid};
use crate::space::{Against, BoundaryCondition, FsiSpace, Region};

/// The term at every point.
pub struct Term(Backflow);

impl<const D: usize> FacetTerm<D> for Term {
    type Form = Backflow;
    const RATE: bool = true;
    const DEPENDS: [bool; 2] = [true, true];

    fn form(&self, _: usize, _: End) -> Backflow {
        self.0
    }
}

/// The term `against` on the outlets of a fluid with its material, whose condition has it, `n` Gauss points per direction.
pub fn backflow<const D: usize>(
    space: &FsiSpace<D>,
    (material, fluid): (u16, Fluid),
    conditions: &[BoundaryCondition<D>],
    against: Against,
    n: usize,
) -> FacetOperator<Term, D> {
    let here = |facet: &Facet| {
        let condition = &conditions[facet.boundary as usize];
        space.material[facet.cell as usize] == material
            && matches!(condition, BoundaryCondition::Outflow { backflow, .. } if *backflow == against)
    };
    let form = Backflow { density: fluid.rho, tangential: against == Against::Tangential };
    FacetOperator::new(space, Region::Fluid, |facet| here(facet), n, |_| Term(form))
}
