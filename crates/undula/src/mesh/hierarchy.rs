//! The coarser meshes that a mesh was refined from.

use super::{Curve, Facet, Mesh};
use std::collections::HashMap;
use std::ops::Range;

/// The coarser meshes that a mesh was refined from, and which cells of one level make a cell of the next.
///
/// The finest mesh is not part of it: it stands beside its hierarchy. Cell `2^D c + i` of a level is child `i` of cell
/// `c` of the level before, in the order of [`Mesh::refine`]. The order of the cells is the whole relation, so that
/// nothing is stored for it, and a mesh that is not refined has an empty list.
///
/// Names that the finest mesh gets after refinement are passed on by [`Hierarchy::named_as`], regions are left out on
/// all levels by [`Hierarchy::restrict`]. What changes the cells of a refined mesh in another way makes a mesh without
/// coarser ones: grading, triangulation, another order of cells, other places of nodes. There the hierarchy starts
/// anew, with the refinements that follow.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy<const D: usize> {
    pub(super) coarser: Vec<Mesh<D>>,
    /// For each of them the diagonals along which its tetrahedra were split; empty for other shapes.
    pub(super) diagonals: Vec<Vec<u8>>,
}

/// A cell as part of the coarser one that it was made from.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Child {
    /// The coarser cell.
    pub parent: usize,
    /// Which of its children, in the order of [`Mesh::refine`]; [`Hierarchy::child_number`] is its number in
    /// [`Shape::to_parent`](crate::element::Shape::to_parent).
    pub number: usize,
}

impl<const D: usize> Hierarchy<D> {
    /// Refines `mesh` `times` times, with boundaries on `curves`: the finest mesh and those before it.
    pub fn refine(mesh: Mesh<D>, times: usize, curves: &[Curve<D>]) -> (Mesh<D>, Hierarchy<D>) {
        let (mut finest, mut coarser, mut diagonals) = (mesh, vec![], vec![]);
        for _ in 0..times {
            let along = finest.diagonals();
            let finer = finest.refine_along(&along, curves);
            coarser.push(std::mem::replace(&mut finest, finer));
            diagonals.push(along);
        }
        (finest, Hierarchy { coarser, diagonals })
    }

    /// The coarser meshes, the coarsest first.
    pub fn coarser(&self) -> &[Mesh<D>] {
        &self.coarser
    }

    /// All meshes from the coarsest to `finest`, the mesh that this is the hierarchy of.
    pub fn levels<'a>(&'a self, finest: &'a Mesh<D>) -> impl DoubleEndedIterator<Item = &'a Mesh<D>> {
        self.coarser.iter().chain([finest])
    }

    /// What cell `cell` of a level is of a cell of the level before.
    pub const fn child(cell: usize) -> Child {
        Child { parent: cell >> D, number: cell % (1 << D) }
    }

    /// The number in [`Shape::to_parent`](crate::element::Shape::to_parent) of `child` of a cell of coarser mesh `level`.
    pub fn child_number(&self, level: usize, child: Child) -> usize {
        let diagonal = self.diagonals[level].get(child.parent).copied().unwrap_or(0);
        self.coarser[level].shape.child_number(child.number, diagonal)
    }

    /// The cells of a level that cell `parent` of the level before was split into, in the order of their numbers.
    pub const fn children(parent: usize) -> Range<usize> {
        parent << D..(parent + 1) << D
    }

    /// The hierarchy of `finest`, the same mesh with other names: coarser cells and facets are called as their
    /// children.
    ///
    /// It begins behind the last level on which the children of a cell are in several regions, or those of a facet have
    /// several names: there, a coarser mesh does not have the regions of `finest`.
    #[must_use]
    pub fn named_as(mut self, finest: &Mesh<D>) -> Self {
        let mut named: Vec<Mesh<D>> = vec![];
        for mesh in self.coarser.into_iter().rev() {
            let Some(mesh) = named_as_children(mesh, named.last().unwrap_or(finest)) else { break };
            named.push(mesh);
        }
        named.reverse();
        let diagonals = self.diagonals.split_off(self.diagonals.len() - named.len());
        Hierarchy { coarser: named, diagonals }
    }

    /// The hierarchy of the finest mesh after its restriction to the regions `keep`, see [`Mesh::restrict`].
    #[must_use]
    pub fn restrict(&self, keep: &[&str]) -> Self {
        let coarser = self.coarser.iter().map(|mesh| mesh.restrict(keep)).collect();
        let kept = |(mesh, diagonals): (&Mesh<D>, &Vec<u8>)| {
            let stays = |region: u16| keep.contains(&mesh.regions[region as usize].as_str());
            let of_cells = mesh.cell_region.iter().zip(diagonals);
            of_cells.filter(|(region, _)| stays(**region)).map(|(_, diagonal)| *diagonal).collect()
        };
        Hierarchy { coarser, diagonals: self.coarser.iter().zip(&self.diagonals).map(kept).collect() }
    }
}

/// `mesh` with the names of `finer`; `None` if these do not fit its cells and facets.
fn named_as_children<const D: usize>(mut mesh: Mesh<D>, finer: &Mesh<D>) -> Option<Mesh<D>> {
    if finer.shape != mesh.shape || finer.n_cells() != mesh.n_cells() << D {
        return None;
    }
    let region_of = |children: &[u16]| children.iter().all(|r| *r == children[0]).then_some(children[0]);
    mesh.cell_region = finer.cell_region.chunks(1 << D).map(region_of).collect::<Option<_>>()?;
    mesh.facets = parent_facets(finer, &finer.facets)?;
    mesh.parts = parent_facets(finer, &finer.parts)?;
    mesh.regions.clone_from(&finer.regions);
    mesh.boundaries.clone_from(&finer.boundaries);
    Some(mesh)
}

/// The coarser facets that `facets` of `finer` are the parts of, in the order of these; `None` if some of the parts of
/// one are missing, or if a facet lies inside of a coarser cell.
fn parent_facets<const D: usize>(finer: &Mesh<D>, facets: &[Facet]) -> Option<Vec<Facet>> {
    let mut found: Vec<Facet> = vec![];
    let mut count: HashMap<(u32, u8, u16), usize> = HashMap::new();
    for facet in facets {
        let Child { parent, number } = Hierarchy::<D>::child(facet.cell as usize);
        if !finer.shape.child_on_facet(number, facet.local as usize) {
            return None;
        }
        let coarse = Facet { cell: parent as u32, ..*facet };
        let parts = count.entry((coarse.cell, coarse.local, coarse.boundary)).or_default();
        if *parts == 0 {
            found.push(coarse);
        }
        *parts += 1;
    }
    count.values().all(|parts| *parts == 1 << (D - 1)).then_some(found)
}
