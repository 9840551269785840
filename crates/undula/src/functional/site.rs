//! Cells in which functionals are evaluated.

use crate::space::{FsiSpace, Region};

/// The cells of a body, or those of them that lie in one region of the mesh.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The body.
    pub body: Region,
    /// Number of the region of the mesh; `None`: all that the body fills.
    pub region: Option<u16>,
}

impl From<Region> for Place {
    fn from(body: Region) -> Place {
        Place { body, region: None }
    }
}

impl Place {
    /// Whether `cell` is one of them.
    pub fn has<const D: usize>(self, space: &FsiSpace<D>, cell: usize) -> bool {
        space.regions[cell] == self.body
            && self.region.is_none_or(|region| space.mesh.cell_region[cell] == region)
    }
}
