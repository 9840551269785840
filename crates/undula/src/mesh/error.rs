//! What can be wrong with a mesh, said so that it can be put right.

use crate::math::shortest;
use std::fmt;
use std::path::PathBuf;

/// At most this many cells are listed in a message.
pub const LISTED: usize = 10;

/// One cell named in a message.
#[derive(Clone, Debug, PartialEq)]
pub struct CellAt {
    /// Number of the cell, from 0.
    pub cell: usize,
    /// Mean of its vertices \[m\], with six digits of the size of the mesh.
    pub centre: Vec<f64>,
}

/// Cells that share a defect: the first [`LISTED`] of them, and how many there are.
#[derive(Clone, Debug, PartialEq)]
pub struct CellList {
    /// The first cells with the defect.
    pub first: Vec<CellAt>,
    /// Number of all cells with the defect.
    pub count: usize,
}

impl fmt::Display for CellList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, at) in self.first.iter().enumerate() {
            let centre: Vec<_> = at.centre.iter().map(|&x| shortest(x)).collect();
            write!(f, "{}{} at ({})", if i == 0 { "" } else { ", " }, at.cell, centre.join(", "))?;
        }
        match self.count - self.first.len() {
            0 => Ok(()),
            more => write!(f, " and {more} more"),
        }
    }
}

/// The smallest det(DX) of some cells, and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Least {
    /// Number of the cell, from 0.
    pub cell: usize,
    /// The smallest det(DX) in it \[m^D\], the reference cell being of size 1.
    pub det: f64,
    /// The same, divided by the largest |det(DX)| in the cell.
    pub relative: f64,
    /// The place X(ξ) \[m\].
    pub at: Vec<f64>,
}

impl Least {
    /// How the nodes of a cell run that has det(DX) < 0 everywhere.
    fn sense(&self) -> &'static str {
        if self.at.len() > 2 { "against the right-hand rule" } else { "clockwise" }
    }
}

impl fmt::Display for Least {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Six digits, however small the numbers are.
        let digits = |x: &f64| format!("{x:.5e}").parse().unwrap_or(*x).to_string();
        let at: Vec<_> = self.at.iter().map(digits).collect();
        write!(
            f,
            "the smallest det(DX) is {:.3e} m^{} in cell {} at ({}), {:.2e} of its largest",
            self.det,
            self.at.len(),
            self.cell,
            at.join(", "),
            self.relative
        )
    }
}

/// Errors of mesh generation, reading and checking.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A parameter of a generator that makes no mesh.
    #[error("mesh generator `{generator}`: {reason}")]
    Parameter {
        /// Name of the generator.
        generator: &'static str,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// The file cannot be opened or is no text.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// A line of a mesh file that cannot be used.
    #[error("{}:{line}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A place of a binary mesh file that cannot be used.
    #[error("{}: byte {byte}: {reason}", path.display())]
    Binary {
        /// The file.
        path: PathBuf,
        /// Number of the byte, from 0.
        byte: usize,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A cell or point of a mesh file that cannot be used.
    #[error("{}: {item}: {reason}", path.display())]
    Item {
        /// The file.
        path: PathBuf,
        /// `cell` or `point` with its number, from 0.
        item: String,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// Cells of a shape on which the finite elements do not live, in words.
    #[error("{0}")]
    WrongCells(String),
    /// A wall that cannot be grown.
    #[error("{reason}")]
    Wall {
        /// Its key that is to blame.
        key: &'static str,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A name that the mesh does not have.
    #[error("the mesh has no {kind} `{name}`; it has {known}")]
    UnknownName {
        /// `region` or `boundary`.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// Cells whose map is not orientation-preserving.
    #[error("cells with det(DX) <= 0 somewhere (folded or numbered {sense}): {0}; {1}", sense = .1.sense())]
    Inverted(CellList, Least),
    /// A facet shared by more than two cells, or by two cells with different mid nodes.
    #[error(
        "cells that do not fit their neighbour (a facet used more than twice, or with two mid nodes): {0}"
    )]
    NotConforming(CellList),
    /// Coincident but distinct nodes.
    #[error(
        "cells with duplicated nodes, equal in position but not in number, so that the mesh is cut open there \
         (in Gmsh, `Coherence;` or `BooleanFragments` merges them): {0}"
    )]
    DuplicatedNodes(CellList),
    /// Nodes on the facet of a cell that are not its nodes.
    #[error("cells with a hanging node, a node of a neighbour on their facet: {0}")]
    HangingNodes(CellList),
    /// Facets of the outer boundary without a name.
    #[error("cells with an outer facet that belongs to no named boundary: {0}")]
    UnnamedBoundary(CellList),
    /// Cells neither in nor outside a region.
    #[error(
        "cells cut by the interface of region `{region}`; every cell must lie wholly inside or outside of it, \
         with all its interface nodes on the interface: {cells}"
    )]
    CutCells {
        /// The region that was to be assigned.
        region: String,
        /// The cells cut.
        cells: CellList,
    },
    /// A function without a value.
    #[error("the expression of region `{region}` is not a number in cells {cells}")]
    NotANumber {
        /// The region that was to be assigned.
        region: String,
        /// The cells.
        cells: CellList,
    },
    /// A region without cells.
    #[error(
        "no cell lies in region `{region}`: its expression is positive nowhere in the mesh, or in parts of cells only"
    )]
    NoCells {
        /// The region that was to be assigned.
        region: String,
    },
    /// Facets between the two regions that are not marked as interface.
    #[error("facets between `{first}` and `{second}` that are not in boundary `interface`, at cells {cells}")]
    UnmarkedInterface {
        /// First region.
        first: String,
        /// Second region.
        second: String,
        /// Cells of the first region.
        cells: CellList,
    },
    /// Facets called `interface` that do not lie between the two regions.
    #[error("facets of boundary `interface` that are not between `{first}` and `{second}`, at cells {cells}")]
    StrayInterface {
        /// First region.
        first: String,
        /// Second region.
        second: String,
        /// The cells of these facets.
        cells: CellList,
    },
    /// The two regions do not touch.
    #[error(
        "regions `{first}` and `{second}` share no facet: they lie apart, overlap, or were meshed without \
         regard to each other (in Gmsh, `BooleanFragments` makes them share their interface)"
    )]
    NoInterface {
        /// First region.
        first: String,
        /// Second region.
        second: String,
    },
    /// Nodes of a curved boundary off the curve.
    #[error("nodes of boundary `{boundary}` up to {distance:.3e} m off its curve, in cells {cells}")]
    OffCurve {
        /// Name of the boundary.
        boundary: String,
        /// Largest distance \[m\].
        distance: f64,
        /// The cells.
        cells: CellList,
    },
    /// A point outside of the mesh.
    #[error("point {point:?} lies in no cell; the nearest node is {nearest:?}")]
    Outside {
        /// The point \[m\].
        point: Vec<f64>,
        /// Position of the nearest node \[m\].
        nearest: Vec<f64>,
    },
    /// A point in another body than the one that is meant.
    #[error("point {point:?} lies in another region")]
    OtherRegion {
        /// The point \[m\].
        point: Vec<f64>,
    },
    /// A point where there is no pressure.
    #[error("there is no pressure at {point:?}, inside a compressible solid")]
    NoPressure {
        /// The point \[m\].
        point: Vec<f64>,
    },
}
