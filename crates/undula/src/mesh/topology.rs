//! Which cells meet at which facet.

use super::Mesh;
use std::collections::HashMap;

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

/// Sorted vertices of a facet, filled up with `u32::MAX`: its identity.
pub(crate) type FacetKey = [u32; 4];

impl<const D: usize> Mesh<D> {
    /// Finds all facets, sorted by cell; linear but for a sort.
    pub fn facets_of_cells(&self) -> Facets {
        let mut facets = Facets::default();
        for group in self.sides_by_vertices().chunk_by(|a, b| a.0 == b.0) {
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

    /// For each side of a facet between two cells the other side.
    pub fn neighbours(&self) -> HashMap<Side, Side> {
        let inner = self.facets_of_cells().inner;
        inner.into_iter().flat_map(|[one, two]| [(one, two), (two, one)]).collect()
    }

    /// The connected part in which each cell is: cells of one region that hang together by facets. Parts are numbered
    /// in the order of their first cells.
    pub fn components(&self) -> Vec<u32> {
        self.components_by(&self.facets_of_cells().inner)
    }

    /// The same, if the facets between cells are known.
    pub fn components_by(&self, inner: &[[Side; 2]]) -> Vec<u32> {
        self.components_where(inner, |one, two| self.cell_region[one] == self.cell_region[two])
    }

    /// The same of neighbours that are `together`.
    pub fn components_where(&self, inner: &[[Side; 2]], together: impl Fn(usize, usize) -> bool) -> Vec<u32> {
        let mut next: Vec<Vec<u32>> = vec![vec![]; self.n_cells()];
        for [one, two] in inner {
            if together(one.cell as usize, two.cell as usize) {
                next[one.cell as usize].push(two.cell);
                next[two.cell as usize].push(one.cell);
            }
        }
        let (mut component, mut n) = (vec![u32::MAX; self.n_cells()], 0);
        for first in 0..self.n_cells() {
            if component[first] != u32::MAX {
                continue;
            }
            let mut stack = vec![first as u32];
            component[first] = n;
            while let Some(cell) = stack.pop() {
                for &other in &next[cell as usize] {
                    if component[other as usize] == u32::MAX {
                        component[other as usize] = n;
                        stack.push(other);
                    }
                }
            }
            n += 1;
        }
        component
    }

    /// All sides of all cells with their vertices, sorted.
    pub(crate) fn sides_by_vertices(&self) -> Vec<(FacetKey, Side)> {
        let corners = self.shape.vertices(self.degree);
        let on = |&c: &usize, local: usize| self.shape.on_facet(self.degree, c, local);
        let of_facet: Vec<Vec<usize>> = (0..self.shape.n_facets())
            .map(|local| corners.iter().copied().filter(|c| on(c, local)).collect())
            .collect();
        let mut sides = Vec::with_capacity(self.n_cells() * of_facet.len());
        for cell in 0..self.n_cells() {
            for (local, vertices) in of_facet.iter().enumerate() {
                let mut key = [u32::MAX; 4];
                key.iter_mut().zip(vertices).for_each(|(k, &v)| *k = self.cell(cell)[v]);
                key.sort_unstable();
                sides.push((key, Side { cell: cell as u32, local: local as u8 }));
            }
        }
        sides.sort_unstable();
        sides
    }

    /// Whether two sides have the same geometry nodes.
    fn same_nodes(&self, one: Side, two: Side) -> bool {
        let sorted = |side: Side| {
            let mut nodes = self.facet_nodes(side.cell as usize, side.local as usize);
            nodes.sort_unstable();
            nodes
        };
        self.degree == 1 || sorted(one) == sorted(two)
    }
}
