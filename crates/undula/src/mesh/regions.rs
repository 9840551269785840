//! Regions and the interface between them.

use super::{Facet, Mesh, MeshError, Side};
use crate::element::{Quadrature, lagrange};
use std::collections::{HashMap, HashSet};

/// Name of the boundary between fluid and solid.
pub const INTERFACE: &str = "interface";

/// Intervals per direction of the lattice of points at which a function decides on a region, and the part of the
/// cell by which the lattice is drawn in from its sides.
const LATTICE: usize = 4;
const DRAWN_IN: f64 = 1e-6;

impl<const D: usize> Mesh<D> {
    /// The mesh of the regions named in `keep` alone.
    ///
    /// Facets between a cell kept and one left out become boundary facets of the former: they keep their
    /// name, or are called `interface` if they have none. Nodes, regions and boundaries that nothing
    /// refers to any more are dropped; the order of all that stays is kept.
    pub fn restrict(&self, keep: &[&str]) -> Self {
        let region_kept: Vec<bool> = self.regions.iter().map(|r| keep.contains(&r.as_str())).collect();
        let kept = |cell: u32| region_kept[self.cell_region[cell as usize] as usize];
        let beyond = self.neighbours();
        let mut mesh = self.clone();
        for list in [&mut mesh.facets, &mut mesh.parts] {
            list.retain_mut(|facet| {
                let here = Some(facet.side()).filter(|side| kept(side.cell));
                let side =
                    here.or_else(|| beyond.get(&facet.side()).copied().filter(|other| kept(other.cell)));
                side.is_some_and(|side| {
                    *facet = side.named(facet.boundary);
                    true
                })
            });
        }
        let attached: HashSet<Side> = mesh.facets.iter().map(Facet::side).collect();
        let interface = mesh.boundary_number(INTERFACE);
        let mut exposed: Vec<Side> = beyond
            .iter()
            .filter(|(here, other)| kept(here.cell) && !kept(other.cell) && !attached.contains(here))
            .map(|(&here, _)| here)
            .collect();
        exposed.sort_unstable();
        mesh.facets.extend(exposed.into_iter().map(|side| side.named(interface)));
        mesh.drop_cells(kept);
        mesh
    }

    /// Names all facets between regions `first` and `second` `interface`, seen from the cell of `first`;
    /// returns how many there are. Other names of these facets become further names.
    ///
    /// # Errors
    /// [`MeshError::UnknownName`] for an unknown region, [`MeshError::NoInterface`] without such facets.
    pub fn mark_interface(&mut self, first: &str, second: &str) -> Result<usize, MeshError> {
        let sides = self.sides_between(first, second)?;
        if sides.is_empty() {
            return Err(MeshError::NoInterface { first: first.into(), second: second.into() });
        }
        self.name_sides(&sides, INTERFACE, |_| false);
        Ok(sides.len())
    }

    /// Names the sides of `region` at the cells of the regions in `keep`, seen from these cells: those without a name
    /// of their own are called as the region. `interface` is no name of their own, but it stays as a further one.
    ///
    /// # Errors
    /// [`MeshError::UnknownName`] for an unknown region.
    pub fn mark_sides(&mut self, region: &str, keep: &[&str]) -> Result<(), MeshError> {
        let mut sides = vec![];
        for kept in keep {
            sides.extend(self.sides_between(kept, region)?);
        }
        let interface = self.boundary(INTERFACE);
        self.name_sides(&sides, region, |boundary| Some(boundary) != interface);
        Ok(())
    }

    /// Names the facets `sides` as the first cell of each pair sees them. Another name that they have stays where
    /// `own` holds, and becomes a further one elsewhere.
    fn name_sides(&mut self, sides: &[[Side; 2]], name: &str, own: impl Fn(u16) -> bool) {
        if sides.is_empty() {
            return;
        }
        let number = self.boundary_number(name);
        let seen_from: HashMap<Side, Side> = sides.iter().flat_map(|&[a, b]| [(a, a), (b, a)]).collect();
        let mut done: HashSet<Side> = HashSet::new();
        let Self { facets, parts, .. } = self;
        for part in parts.iter_mut() {
            *part = seen_from.get(&part.side()).map_or(*part, |side| side.named(part.boundary));
        }
        facets.retain_mut(|facet| {
            let Some(&side) = seen_from.get(&facet.side()) else { return true };
            let first = done.insert(side);
            let further = facet.boundary != number && (!first || !own(facet.boundary));
            if further {
                parts.push(side.named(facet.boundary));
            }
            *facet = side.named(if further { number } else { facet.boundary });
            first
        });
        facets.extend(sides.iter().filter(|[a, _]| !done.contains(a)).map(|[a, _]| a.named(number)));
    }

    /// Puts every cell where `inside` is positive in region `name`, a new one unless there is one of that
    /// name; returns these cells.
    ///
    /// The function is taken at points inside of the cells, some of them close to their corners and sides. A cell
    /// belongs to the region if it is positive at all of them, and does not if it is at none: a condition such as
    /// `x < 0.5`, 0 or 1, gives the same cells as `0.5 - x`, and rounding on the sides of cells does not matter.
    /// Facets keep their names; see [`Mesh::mark_interface`].
    ///
    /// # Errors
    /// [`MeshError::CutCells`] if there are other cells, [`MeshError::NoCells`] if none belongs to the region,
    /// [`MeshError::NotANumber`] where the function has no value; the mesh is then unchanged.
    pub fn assign_region(
        &mut self,
        name: &str,
        inside: impl Fn([f64; D]) -> f64,
    ) -> Result<Vec<u32>, MeshError> {
        let points = self.points_inside();
        let (mut belong, mut cut, mut unknown) = (vec![], vec![], vec![]);
        for cell in 0..self.n_cells() {
            let mut within = 0;
            for value in points.iter().map(|&xi| inside(self.map(cell, xi))) {
                within += usize::from(value > 0.0);
                if value.is_nan() && unknown.last() != Some(&cell) {
                    unknown.push(cell);
                }
            }
            match within {
                0 => {}
                n if n == points.len() => belong.push(cell as u32),
                _ => cut.push(cell),
            }
        }
        if !unknown.is_empty() {
            return Err(MeshError::NotANumber { region: name.into(), cells: self.list_cells(&unknown) });
        }
        if !cut.is_empty() {
            return Err(MeshError::CutCells { region: name.into(), cells: self.list_cells(&cut) });
        }
        if belong.is_empty() {
            return Err(MeshError::NoCells { region: name.into() });
        }
        let region = self.region(name).unwrap_or_else(|| {
            self.regions.push(name.into());
            self.regions.len() as u16 - 1
        });
        belong.iter().for_each(|&cell| self.cell_region[cell as usize] = region);
        Ok(belong)
    }

    /// Reference coordinates of points inside of a cell that see where it is cut: a lattice drawn in from the sides by
    /// [`DRAWN_IN`], and Gauss points.
    fn points_inside(&self) -> Vec<[f64; D]> {
        let centre = self.reference_centre();
        let lattice = (0..self.shape.n_nodes(LATTICE)).map(|n| {
            let at = lagrange::node(self.shape, LATTICE, n);
            std::array::from_fn(|d| centre[d] + (1.0 - DRAWN_IN) * (at[d] - centre[d]))
        });
        let gauss = Quadrature::cell(self.shape, 3).points;
        lattice.chain(gauss.into_iter().map(|x| std::array::from_fn(|d| x[d]))).collect()
    }

    /// Facets between regions `first` and `second`, the side of `first` first, in the order of its cells.
    pub(crate) fn sides_between(&self, first: &str, second: &str) -> Result<Vec<[Side; 2]>, MeshError> {
        let (first, second) = (self.require_region(first)?, self.require_region(second)?);
        let region = |side: &Side| self.cell_region[side.cell as usize];
        let inner = self.facets_of_cells().inner.into_iter();
        let mut sides: Vec<[Side; 2]> = inner
            .filter_map(|[one, two]| match (region(&one), region(&two)) {
                (a, b) if a == first && b == second => Some([one, two]),
                (a, b) if a == second && b == first => Some([two, one]),
                _ => None,
            })
            .collect();
        sides.sort_unstable();
        Ok(sides)
    }

    /// Boundaries all of whose facets lie between cells of different regions.
    pub fn boundaries_between_regions(&self) -> Vec<&str> {
        let different = |pair: &[Side; 2]| {
            let [one, two] = pair.map(|side| self.cell_region[side.cell as usize]);
            one != two
        };
        let inner = self.facets_of_cells().inner.into_iter().filter(different);
        let between: HashSet<Side> = inner.flatten().collect();
        let elsewhere = |n: u16| self.facets.iter().any(|f| f.boundary == n && !between.contains(&f.side()));
        let names = (0..).zip(&self.boundaries).filter(|(n, _)| !elsewhere(*n));
        names.map(|(_, name)| name.as_str()).collect()
    }

    /// Index of region `name`, or an error that names those there are.
    pub fn require_region(&self, name: &str) -> Result<u16, MeshError> {
        self.region(name).ok_or_else(|| unknown("region", name, &self.regions))
    }

    /// Index of boundary `name`, or an error that names those there are.
    pub fn require_boundary(&self, name: &str) -> Result<u16, MeshError> {
        self.boundary(name).ok_or_else(|| unknown("boundary", name, &self.boundaries))
    }

    /// Index of boundary `name`, a new one unless it is there.
    pub(crate) fn boundary_number(&mut self, name: &str) -> u16 {
        self.boundary(name).unwrap_or_else(|| {
            self.boundaries.push(name.to_string());
            self.boundaries.len() as u16 - 1
        })
    }

    /// The mesh of `cells` alone, ascending, with all names. Facets that lay inside have none; those that are named once, seen
    /// from a cell that is left out, are left out with it.
    pub(crate) fn part(&self, cells: &[u32]) -> Self {
        let place = |facet: &Facet| {
            let cell = cells.binary_search(&facet.cell).ok()? as u32;
            Some(Facet { cell, ..*facet })
        };
        let mut cell_nodes: Vec<u32> =
            cells.iter().flat_map(|&cell| self.cell(cell as usize)).copied().collect();
        let nodes = renumber(self.nodes.len(), cell_nodes.iter_mut());
        Mesh {
            shape: self.shape,
            degree: self.degree,
            nodes: nodes.into_iter().map(|node| self.nodes[node]).collect(),
            cell_nodes,
            cell_region: cells.iter().map(|&cell| self.cell_region[cell as usize]).collect(),
            regions: self.regions.clone(),
            facets: self.facets.iter().filter_map(place).collect(),
            boundaries: self.boundaries.clone(),
            parts: self.parts.iter().filter_map(place).collect(),
        }
    }

    /// Drops all cells but those `kept`, with their facets, and all nodes and names that are then unused.
    pub(crate) fn drop_cells(&mut self, kept: impl Fn(u32) -> bool) {
        let cells: Vec<usize> = (0..self.n_cells()).filter(|&c| kept(c as u32)).collect();
        self.facets.retain(|f| kept(f.cell));
        self.parts.retain(|f| kept(f.cell));
        let new_cell: HashMap<u32, u32> =
            cells.iter().zip(0..).map(|(&old, new)| (old as u32, new)).collect();
        self.facets.iter_mut().chain(&mut self.parts).for_each(|f| f.cell = new_cell[&f.cell]);
        self.cell_nodes = cells.iter().flat_map(|&c| self.cell(c)).copied().collect();
        self.cell_region = cells.iter().map(|&c| self.cell_region[c]).collect();
        let nodes = renumber(self.nodes.len(), self.cell_nodes.iter_mut());
        self.nodes = nodes.into_iter().map(|n| self.nodes[n]).collect();
        let regions = renumber(self.regions.len(), self.cell_region.iter_mut());
        self.regions = regions.into_iter().map(|r| std::mem::take(&mut self.regions[r])).collect();
        let used = self.facets.iter_mut().chain(&mut self.parts).map(|f| &mut f.boundary);
        let boundaries = renumber(self.boundaries.len(), used);
        self.boundaries = boundaries.into_iter().map(|b| std::mem::take(&mut self.boundaries[b])).collect();
    }
}

impl Facet {
    /// The facet without its name.
    pub fn side(&self) -> Side {
        Side { cell: self.cell, local: self.local }
    }
}

impl Side {
    /// The facet with a name.
    pub fn named(self, boundary: u16) -> Facet {
        Facet { cell: self.cell, local: self.local, boundary }
    }
}

fn unknown(kind: &'static str, name: &str, known: &[String]) -> MeshError {
    let known: Vec<_> = known.iter().map(|k| format!("`{k}`")).collect();
    let known = if known.is_empty() { "none".to_string() } else { known.join(", ") };
    MeshError::UnknownName { kind, name: name.to_string(), known }
}

/// Numbers the used ones of `n` things from 0 in their order; returns the old numbers.
fn renumber<'a, N>(n: usize, uses: impl Iterator<Item = &'a mut N>) -> Vec<usize>
where
    N: Copy + TryInto<usize> + TryFrom<usize> + 'a,
{
    let uses: Vec<&mut N> = uses.collect();
    let number = |use_: &N| (*use_).try_into().unwrap_or(n);
    let mut used = vec![false; n];
    uses.iter().for_each(|u| used[number(u)] = true);
    let old: Vec<usize> = (0..n).filter(|&i| used[i]).collect();
    let mut new = vec![0; n];
    old.iter().zip(0..).for_each(|(&o, i)| new[o] = i);
    for u in uses {
        let i = new[number(u)];
        if let Ok(i) = N::try_from(i) {
            *u = i;
        }
    }
    old
}
