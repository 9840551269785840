//! The coarser meshes that a mesh was refined from.

use super::{Curve, Facet, Mesh, Split};
use std::collections::HashMap;
use std::ops::Range;

/// The coarser meshes that a mesh was refined from, and which cells of one level make a cell of the next.
///
/// The finest mesh is not part of it: it stands beside its hierarchy. Cell `n c + i` of a level is child `i` of cell `c`
/// of the level before, which is split into `n`: `2^D` in the order of [`Mesh::refine`], or fewer, see [`Split`]. The
/// order of the cells is the whole relation, so that nothing is stored for it, and a mesh that is not refined has an
/// empty list.
///
/// Names that the finest mesh gets after refinement are passed on by [`Hierarchy::named_as`], regions are left out on
/// all levels by [`Hierarchy::restrict`]. What changes the cells of a refined mesh in another way makes a mesh without
/// coarser ones: grading, triangulation, another order of cells, other places of nodes. There the hierarchy starts
/// anew, with the refinements that follow.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy<const D: usize> {
    pub(super) coarser: Vec<Mesh<D>>,
    /// How the cells of each of them are split.
    pub(super) splits: Vec<Split>,
    /// For each of them the diagonals along which its tetrahedra were split; empty for other shapes.
    pub(super) diagonals: Vec<Vec<u8>>,
}

/// A cell as part of the coarser one that it was made from.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Child {
    /// The coarser cell.
    pub parent: usize,
    /// Which of its children, in their order; [`Hierarchy::child_number`] is its number in [`Split::to_parent`].
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
        (finest, Hierarchy { splits: vec![Split::Whole; coarser.len()], coarser, diagonals })
    }

    /// The coarser meshes, the coarsest first.
    pub fn coarser(&self) -> &[Mesh<D>] {
        &self.coarser
    }

    /// All meshes from the coarsest to `finest`, the mesh that this is the hierarchy of.
    pub fn levels<'a>(&'a self, finest: &'a Mesh<D>) -> impl DoubleEndedIterator<Item = &'a Mesh<D>> {
        self.coarser.iter().chain([finest])
    }

    /// How the cells of coarser mesh `level` are split.
    pub fn split(&self, level: usize) -> Split {
        self.splits[level]
    }

    /// What cell `cell` is of a cell of coarser mesh `level`, the one before its own.
    pub fn child(&self, level: usize, cell: usize) -> Child {
        let n = self.splits[level].children(D);
        Child { parent: cell / n, number: cell % n }
    }

    /// The number in [`Split::to_parent`] of `child` of a cell of coarser mesh `level`.
    pub fn child_number(&self, level: usize, child: Child) -> usize {
        let diagonal = self.diagonals[level].get(child.parent).copied().unwrap_or(0);
        self.coarser[level].shape.child_number(child.number, diagonal)
    }

    /// The cells that cell `parent` of coarser mesh `level` is split into, in the order of their numbers.
    pub fn children(&self, level: usize, parent: usize) -> Range<usize> {
        let n = self.splits[level].children(D);
        parent * n..(parent + 1) * n
    }

    /// The hierarchy of `finest`, the same mesh with other names: coarser cells and facets are called as their
    /// children.
    ///
    /// It begins behind the last level on which the children of a cell are in several regions, or those of a facet have
    /// several names: there, a coarser mesh does not have the regions of `finest`.
    #[must_use]
    pub fn named_as(mut self, finest: &Mesh<D>) -> Self {
        let mut named: Vec<Mesh<D>> = vec![];
        for (mesh, &split) in self.coarser.into_iter().zip(&self.splits).rev() {
            let Some(mesh) = named_as_children(mesh, split, named.last().unwrap_or(finest)) else { break };
            named.push(mesh);
        }
        named.reverse();
        let first = self.diagonals.len() - named.len();
        let (splits, diagonals) = (self.splits.split_off(first), self.diagonals.split_off(first));
        Hierarchy { coarser: named, splits, diagonals }
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
        let diagonals = self.coarser.iter().zip(&self.diagonals).map(kept).collect();
        Hierarchy { coarser, splits: self.splits.clone(), diagonals }
    }
}

/// `mesh` with the names of `finer`, into whose cells its own are `split`; `None` if these do not fit its cells and facets.
fn named_as_children<const D: usize>(mut mesh: Mesh<D>, split: Split, finer: &Mesh<D>) -> Option<Mesh<D>> {
    let n = split.children(D);
    if finer.shape != mesh.shape || finer.n_cells() != n * mesh.n_cells() {
        return None;
    }
    let region_of = |children: &[u16]| children.iter().all(|r| *r == children[0]).then_some(children[0]);
    mesh.cell_region = finer.cell_region.chunks(n).map(region_of).collect::<Option<_>>()?;
    mesh.facets = parent_facets(split, finer, &finer.facets)?;
    mesh.parts = parent_facets(split, finer, &finer.parts)?;
    mesh.regions.clone_from(&finer.regions);
    mesh.boundaries.clone_from(&finer.boundaries);
    Some(mesh)
}

/// The coarser facets that `facets` of `finer` are the parts of, in the order of these; `None` if some of the parts of
/// one are missing, or if a facet lies inside of a coarser cell.
fn parent_facets<const D: usize>(split: Split, finer: &Mesh<D>, facets: &[Facet]) -> Option<Vec<Facet>> {
    let mut found: Vec<Facet> = vec![];
    let mut count: HashMap<(u32, u8, u16), usize> = HashMap::new();
    for facet in facets {
        let cell = facet.cell as usize;
        let (parent, number) = (cell / split.children(D), cell % split.children(D));
        if !split.child_on_facet(finer.shape, number, facet.local as usize) {
            return None;
        }
        let coarse = Facet { cell: parent as u32, ..*facet };
        let parts = count.entry((coarse.cell, coarse.local, coarse.boundary)).or_default();
        if *parts == 0 {
            found.push(coarse);
        }
        *parts += 1;
    }
    let whole = |(&(_, local, _), parts): (&(u32, u8, u16), &usize)| *parts == split.parts(D, local as usize);
    count.iter().all(whole).then_some(found)
}
