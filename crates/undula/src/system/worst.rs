//! Where the map of the domain is close to folding.

use super::Assembler;
use crate::operators::RegionOperator;
use crate::parallel::Reduce;
use crate::space::State;

/// Where J is smallest.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// Smallest J at a quadrature point or node, fluid and solid.
    pub min_j: f64,
    /// The cell in which it lies, then all others with J ≤ 0.
    pub cells: Vec<u32>,
}

impl<const D: usize> Assembler<D> {
    /// The smallest J of the last residual and at the nodes of `state`: quadrature points alone do not see cells
    /// that fold at a corner.
    pub fn nodal_min_j(&mut self, state: &State) -> f64 {
        if !self.space.deforms {
            return 1.0;
        }
        let Self { space, regions, .. } = self;
        let least = |region: &mut Box<dyn RegionOperator<D>>| region.nodal_min_j(space, &state.u);
        let here = regions.iter_mut().map(least).fold(f64::INFINITY, f64::min);
        space.over_all(Reduce::Min, here)
    }

    /// Where J was smallest in the last residual, and at the nodes if that was asked for since.
    pub fn worst(&self) -> Worst {
        let mut list: Vec<_> = self.regions.iter().filter_map(|region| region.worst()).collect();
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let min_j = list.first().map_or(1.0, |worst| worst.0);
        // Of the other region those cells that are folded, too.
        let cells = |(j, cells): (f64, Vec<u32>)| if j <= 0.0 || j == min_j { cells } else { vec![] };
        Worst { min_j, cells: list.into_iter().flat_map(cells).collect() }
    }
}
