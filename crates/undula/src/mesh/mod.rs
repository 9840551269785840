//! Geometry and topology of the reference domain; nothing here knows that there is a fluid.

pub mod generate;
pub mod gmsh;

mod affine;
mod box_tree;
mod curve;
mod distance;
mod error;
mod extrude;
mod fold;
mod from_cells;
mod geometry;
mod grade;
mod hierarchy;
mod locate;
mod matching;
mod partition;
mod place;
mod quality;
mod refine;
mod regions;
mod seams;
mod split;
mod tetrahedra;
mod topology;
mod triangulate;
mod wall;

pub use curve::Curve;
pub use distance::FacetDistance;
pub use error::{CellAt, CellList, LISTED, Least, MeshError};
pub use extrude::Extrusion;
pub use hierarchy::{Child, Hierarchy};
pub use locate::{Located, Locator};
pub use quality::Quality;
pub use regions::INTERFACE;
pub use seams::Seam;
pub use split::Split;
pub use topology::{Facets, Side};
pub use wall::{Wall, ring};

use crate::element::Shape;
use std::collections::HashSet;

/// A conforming mesh of curved cells with named regions and boundaries.
///
/// All cells share one shape and one geometry degree; geometry is isoparametric, so a cell is the
/// image of the reference cell under the Lagrange interpolation of its nodes.
#[derive(Clone, Debug)]
pub struct Mesh<const D: usize> {
    /// Shape of every cell.
    pub shape: Shape,
    /// Degree of the geometry map: 1 straight, 2 (bi)quadratic.
    pub degree: usize,
    /// Coordinates of the geometry nodes \[m\].
    pub nodes: Vec<[f64; D]>,
    /// Nodes of each cell in the order of [`Shape`], `n_cells × shape.n_nodes(degree)`.
    pub cell_nodes: Vec<u32>,
    /// Index into `regions` for each cell.
    pub cell_region: Vec<u16>,
    /// Names of the regions, such as `fluid` and `solid`.
    pub regions: Vec<String>,
    /// Facets that carry a name: every facet of the outer boundary, and those of the interface
    /// (once, seen from the cell of the region named first in `regions`).
    pub facets: Vec<Facet>,
    /// Names of the boundaries, such as `inflow`, `walls`, `interface`.
    pub boundaries: Vec<String>,
    /// Further names of facets, such as those of parts of the interface: each entry is a facet of `facets` but for its
    /// boundary.
    pub parts: Vec<Facet>,
}

/// One named facet.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Facet {
    /// The cell it belongs to.
    pub cell: u32,
    /// Its number within the cell, in the order of [`Shape`].
    pub local: u8,
    /// Index into [`Mesh::boundaries`].
    pub boundary: u16,
}

impl<const D: usize> Mesh<D> {
    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.cell_region.len()
    }

    /// Geometry nodes of cell `cell`.
    pub fn cell(&self, cell: usize) -> &[u32] {
        let n = self.shape.n_nodes(self.degree);
        &self.cell_nodes[cell * n..(cell + 1) * n]
    }

    /// Index of the boundary called `name`.
    pub fn boundary(&self, name: &str) -> Option<u16> {
        self.boundaries.iter().position(|b| b == name).map(|i| i as u16)
    }

    /// All facets that bear one of `names`, further names counted: each once, in the order of `facets`.
    pub fn facets_on<S: AsRef<str>>(&self, names: &[S]) -> Vec<Facet> {
        let numbers: Vec<u16> = names.iter().filter_map(|name| self.boundary(name.as_ref())).collect();
        let wanted = |f: &&Facet| numbers.contains(&f.boundary);
        let parts: HashSet<Side> = self.parts.iter().filter(wanted).map(Facet::side).collect();
        self.facets.iter().filter(|f| wanted(f) || parts.contains(&f.side())).copied().collect()
    }

    /// Index of the region called `name`.
    pub fn region(&self, name: &str) -> Option<u16> {
        self.regions.iter().position(|r| r == name).map(|i| i as u16)
    }
}
