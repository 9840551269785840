//! Which cells meet at which facet.

use super::Mesh;

/// A facet as seen from one of its cells.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Side {
    /// The cell.
    pub cell: u32,
    /// Number of the facet within the cell, in the order of [`crate::element::Shape`].
    pub local: u8,
}

/// All facets of a mesh.
#[derive(Clone, Debug, Default)]
pub struct Facets {
    /// Facets of one cell only: the outer boundary, in the order of cells.
    pub outer: Vec<Side>,
    /// Facets between two cells, the one with the lower number first.
    pub inner: Vec<[Side; 2]>,
    /// Cells at a facet that more than two cells share, or that two share with different mid nodes.
    pub bad: Vec<u32>,
}

/// Sorted vertices of a facet: its identity.
pub(crate) type FacetKey = [u32; 4];

impl<const D: usize> Mesh<D> {
    /// Sorted vertices of facet `local` of `cell`, filled up with `u32::MAX`.
    pub(crate) fn facet_key(&self, cell: usize, local: usize) -> FacetKey {
        let mut key = [u32::MAX; 4];
        let (axis, side) = (local / 2, local % 2);
        let corners = self.shape.vertices(self.degree);
        let on_facet = corners
            .iter()
            .filter(|&&c| self.shape.lattice(self.degree, c)[axis] == side * self.degree);
        for (entry, &corner) in key.iter_mut().zip(on_facet) {
            *entry = self.cell(cell)[corner];
        }
        key.sort_unstable();
        key
    }

    /// Finds all facets, sorted by cell; linear but for a sort.
    pub fn facets_of_cells(&self) -> Facets {
        let n_facets = self.shape.n_facets();
        let mut keyed: Vec<(FacetKey, Side)> = (0..self.n_cells())
            .flat_map(|cell| (0..n_facets).map(move |local| (cell, local)))
            .map(|(cell, local)| {
                (self.facet_key(cell, local), Side { cell: cell as u32, local: local as u8 })
            })
            .collect();
        keyed.sort_unstable();
        let mut facets = Facets::default();
        for group in keyed.chunk_by(|a, b| a.0 == b.0) {
            match *group {
                [(_, side)] => facets.outer.push(side),
                [(_, one), (_, two)] if self.same_nodes(one, two) => facets.inner.push([one, two]),
                _ => facets.bad.extend(group.iter().map(|(_, side)| side.cell)),
            }
        }
        facets.outer.sort_unstable();
        facets.inner.sort_unstable();
        facets.bad.sort_unstable();
        facets.bad.dedup();
        facets
    }

    /// Whether two sides have the same geometry nodes.
    fn same_nodes(&self, one: Side, two: Side) -> bool {
        if self.degree == 1 {
            return true;
        }
        let sorted = |side: Side| {
            let mut nodes = self.facet_nodes(side.cell as usize, side.local as usize);
            nodes.sort_unstable();
            nodes
        };
        sorted(one) == sorted(two)
    }
}
