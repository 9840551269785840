//! Regions and the interface between them.

use super::{Facet, Mesh, MeshError, Side};
use std::collections::HashMap;

/// Name of the boundary between fluid and solid.
pub const INTERFACE: &str = "interface";

/// A cell is not cut where the function that describes a region changes sign by no more than this part
/// of its largest value.
const ROUNDING: f64 = 1e-10;

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
        let mut attached: HashMap<Side, usize> = HashMap::new();
        mesh.facets.retain_mut(|facet| {
            let mut side = facet.side();
            if !kept(side.cell) {
                match beyond.get(&side) {
                    Some(&other) if kept(other.cell) => side = other,
                    _ => return false,
                }
            }
            (facet.cell, facet.local) = (side.cell, side.local);
            attached.insert(side, 0);
            true
        });
        let interface = mesh.boundary_number(INTERFACE);
        let mut exposed: Vec<Side> = beyond
            .iter()
            .filter(|(here, other)| kept(here.cell) && !kept(other.cell) && !attached.contains_key(here))
            .map(|(&here, _)| here)
            .collect();
        exposed.sort_unstable();
        mesh.facets.extend(exposed.into_iter().map(|side| side.named(interface)));
        mesh.drop_cells(kept);
        mesh
    }

    /// Names all facets between regions `first` and `second` `interface`, seen from the cell of `first`;
    /// returns how many there are. Other names of these facets are forgotten.
    ///
    /// # Errors
    /// [`MeshError::UnknownName`] for an unknown region, [`MeshError::NoInterface`] without such facets.
    pub fn mark_interface(&mut self, first: &str, second: &str) -> Result<usize, MeshError> {
        let sides = self.sides_between(first, second)?;
        if sides.is_empty() {
            return Err(MeshError::NoInterface { first: first.into(), second: second.into() });
        }
        let both: std::collections::HashSet<Side> = sides.iter().flatten().copied().collect();
        self.facets.retain(|f| !both.contains(&f.side()));
        let interface = self.boundary_number(INTERFACE);
        self.facets.extend(sides.iter().map(|[here, _]| here.named(interface)));
        Ok(sides.len())
    }

    /// Puts every cell where `inside` is positive in region `name`, a new one unless there is one of that
    /// name; returns the number of these cells.
    ///
    /// A cell belongs to the region if `inside >= 0` at all of its geometry nodes and not 0 at all, and does
    /// not if `inside <= 0` at all of them: a condition such as `x < 0.5`, 0 or 1, serves as well. Facets keep their names; see [`Mesh::mark_interface`].
    ///
    /// # Errors
    /// [`MeshError::CutCells`] if there are other cells; the mesh is then unchanged.
    pub fn assign_region(
        &mut self,
        name: &str,
        inside: impl Fn([f64; D]) -> f64,
    ) -> Result<usize, MeshError> {
        let values: Vec<f64> = self.nodes.iter().map(|&x| inside(x)).collect();
        let rounding = ROUNDING * values.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
        let (mut belong, mut cut) = (vec![], vec![]);
        for cell in 0..self.n_cells() {
            let at = self.cell(cell).iter().map(|&n| values[n as usize]);
            let (some_in, some_out) = (at.clone().any(|v| v > rounding), at.clone().any(|v| v < -rounding));
            match (some_in, some_out) {
                (true, false) => belong.push(cell),
                (true, true) => cut.push(cell),
                (false, _) => {}
            }
        }
        if !cut.is_empty() {
            return Err(MeshError::CutCells { region: name.into(), cells: self.list_cells(&cut) });
        }
        let region = self.region(name).unwrap_or_else(|| {
            self.regions.push(name.into());
            self.regions.len() as u16 - 1
        });
        belong.iter().for_each(|&cell| self.cell_region[cell] = region);
        Ok(belong.len())
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

    /// Drops all cells but those `kept`, with their facets, and all nodes and names that are then unused.
    pub(crate) fn drop_cells(&mut self, kept: impl Fn(u32) -> bool) {
        let cells: Vec<usize> = (0..self.n_cells()).filter(|&c| kept(c as u32)).collect();
        self.facets.retain(|f| kept(f.cell));
        let new_cell: HashMap<u32, u32> =
            cells.iter().zip(0..).map(|(&old, new)| (old as u32, new)).collect();
        self.facets.iter_mut().for_each(|f| f.cell = new_cell[&f.cell]);
        self.cell_nodes = cells.iter().flat_map(|&c| self.cell(c)).copied().collect();
        self.cell_region = cells.iter().map(|&c| self.cell_region[c]).collect();
        let nodes = renumber(self.nodes.len(), self.cell_nodes.iter_mut());
        self.nodes = nodes.into_iter().map(|n| self.nodes[n]).collect();
        let regions = renumber(self.regions.len(), self.cell_region.iter_mut());
        self.regions = regions.into_iter().map(|r| std::mem::take(&mut self.regions[r])).collect();
        let used = self.facets.iter_mut().map(|f| &mut f.boundary);
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
