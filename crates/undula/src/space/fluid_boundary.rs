//! The boundary of the fluid, facet by facet.

use super::{FsiSpace, Region};
use crate::mesh::{Facet, Side};
use std::collections::{BTreeMap, HashMap};

/// One facet of the boundary of the fluid.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct FluidFacet {
    /// The facet as seen from the cell of the fluid.
    pub side: Side,
    /// Its boundary of the mesh; `None` without a name.
    pub boundary: Option<u16>,
    /// Whether a solid is behind it: it belongs to the interface.
    pub at_solid: bool,
    /// Whether the fluid goes on behind it, at a seam.
    pub at_seam: bool,
}

/// All facets between the fluid and what is not fluid.
#[derive(Clone, Debug, Default)]
pub struct FluidBoundary {
    /// The facets, sorted by cell.
    pub facets: Vec<FluidFacet>,
    /// Number of each facet by either of its sides.
    number: HashMap<Side, usize>,
}

impl FluidBoundary {
    /// That of the fluid of `space`; empty without fluid.
    pub fn new<const D: usize>(space: &FsiSpace<D>) -> FluidBoundary {
        let is_fluid = |side: &Side| space.regions[side.cell as usize] == Region::Fluid;
        let (all, seams) = (space.mesh.facets_of_cells(), space.seam_sides());
        let mut beyond: BTreeMap<Side, Option<Side>> =
            all.outer.iter().filter(|side| is_fluid(side)).map(|&side| (side, None)).collect();
        for [one, two] in all.inner {
            match (is_fluid(&one), is_fluid(&two)) {
                (true, false) => beyond.insert(one, Some(two)),
                (false, true) => beyond.insert(two, Some(one)),
                _ => None,
            };
        }
        let mut boundary = FluidBoundary::default();
        for (n, (side, other)) in beyond.into_iter().enumerate() {
            boundary.number.extend([(side, n)].into_iter().chain(other.map(|other| (other, n))));
            let (at_solid, at_seam) = (other.is_some(), seams.contains(&side));
            boundary.facets.push(FluidFacet { side, boundary: None, at_solid, at_seam });
        }
        for facet in &space.mesh.facets {
            if let Some(&n) = boundary.number.get(&facet.side()) {
                boundary.facets[n].boundary = Some(facet.boundary);
            }
        }
        if space.part.is_some() {
            boundary.drop_cuts();
        }
        boundary
    }

    /// Leaves out facets behind which the mesh goes on, on another process: they have no name.
    fn drop_cuts(&mut self) {
        let is_kept = |facet: &FluidFacet| facet.at_solid || facet.boundary.is_some();
        let mut kept = 0..;
        let number = |facet: &FluidFacet| if is_kept(facet) { kept.next() } else { None };
        let new: Vec<Option<usize>> = self.facets.iter().map(number).collect();
        self.number.retain(|_, number| {
            let is_there = new[*number].is_some();
            *number = new[*number].unwrap_or(0);
            is_there
        });
        self.facets.retain(is_kept);
    }

    /// Numbers of the facets that are among `named`, whichever side those are seen from; ascending, each once.
    pub fn numbers(&self, named: &[Facet]) -> Vec<usize> {
        let mut numbers: Vec<usize> =
            named.iter().filter_map(|facet| self.number.get(&facet.side()).copied()).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }
}

impl FluidFacet {
    /// The facet for functions that do not look at its name.
    pub fn facet(&self) -> Facet {
        self.side.named(self.boundary.unwrap_or(u16::MAX))
    }
}
