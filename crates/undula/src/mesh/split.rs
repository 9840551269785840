//! Into what the cells of a coarser mesh are split.

use crate::element::Shape;

/// Into what the cells of a coarser mesh are split.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Split {
    /// Into `2^D`, as by [`Mesh::refine`](super::Mesh::refine).
    Whole,
    /// A hexahedron into four along its first two axes, by the section of an extruded mesh whose layers stay.
    Section,
}

impl Split {
    /// Children of a cell in `dim` dimensions.
    pub const fn children(self, dim: usize) -> usize {
        match self {
            Split::Whole => 1 << dim,
            Split::Section => 4,
        }
    }

    /// How many of the first axes of a cell are halved in `dim` dimensions.
    pub const fn axes(self, dim: usize) -> usize {
        match self {
            Split::Whole => dim,
            Split::Section => 2,
        }
    }

    /// Parts of facet `facet` of a cell in `dim` dimensions.
    pub const fn parts(self, dim: usize, facet: usize) -> usize {
        match self {
            Split::Section if facet < 4 => 2,
            Split::Section => 4,
            Split::Whole => 1 << (dim - 1),
        }
    }

    /// Whether child `place` has a part of facet `facet` of a cell; that is facet `facet` of the child, too.
    pub fn child_on_facet(self, shape: Shape, place: usize, facet: usize) -> bool {
        self == Split::Section && facet >= 4 || shape.child_on_facet(place, facet)
    }

    /// Reference coordinates in a cell of the point at `xi` of its child with number `child`.
    pub fn to_parent<const D: usize>(self, shape: Shape, child: usize, xi: [f64; D]) -> [f64; D] {
        let at = shape.to_parent(child, xi);
        std::array::from_fn(|d| if d < self.axes(D) { at[d] } else { xi[d] })
    }

    /// Lattice position of degree `2 degree` in a cell of the node at `at` of its child with number `child`.
    pub fn in_parent(self, shape: Shape, degree: usize, child: usize, at: [usize; 3]) -> [usize; 3] {
        let place = shape.in_parent(degree, child, at);
        match self {
            Split::Whole => place,
            Split::Section => [place[0], place[1], 2 * at[2]],
        }
    }
}
