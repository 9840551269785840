//! Whether a mesh can be computed on: sound cells, no gaps, every outer facet named, and an interface
//! that the cells respect.

use super::box_tree::{Bounds, BoxTree};
use super::distance::FacetMap;
use super::geometry::distance;
use super::regions::INTERFACE;
use super::{Curve, Facets, Mesh, MeshError, Side};
use std::collections::HashSet;

/// Nodes closer than this part of the facets they belong to are the same place.
const SAME_PLACE: f64 = 1e-6;

impl<const D: usize> Mesh<D> {
    /// Checks orientation, conformity and names: no folded cells, no facet of more than two cells, no
    /// duplicated or hanging nodes, a name for every outer facet.
    ///
    /// # Errors
    /// The first of these defects, with the cells that have it.
    pub fn check(&self) -> Result<(), MeshError> {
        self.check_orientation()?;
        let facets = self.facets_of_cells();
        if !facets.bad.is_empty() {
            let cells: Vec<usize> = facets.bad.iter().map(|&c| c as usize).collect();
            return Err(MeshError::NotConforming(self.list_cells(&cells)));
        }
        self.check_gaps(&facets)?;
        let named: HashSet<Side> = self.facets.iter().map(|f| f.side()).collect();
        match self.cells_of(facets.outer.iter().filter(|side| !named.contains(side))) {
            none if none.is_empty() => Ok(()),
            cells => Err(MeshError::UnnamedBoundary(self.list_cells(&cells))),
        }
    }

    /// Checks in addition that the mesh *matches* the two regions: boundary `interface` is exactly the
    /// set of facets between `first` and `second` (every cell being in one region), and all geometry
    /// nodes of boundaries that follow one of `curves` lie on it.
    ///
    /// # Errors
    /// Those of [`Mesh::check`], then [`MeshError::NoInterface`], [`MeshError::UnmarkedInterface`],
    /// [`MeshError::StrayInterface`], [`MeshError::OffCurve`].
    pub fn check_matching(&self, first: &str, second: &str, curves: &[Curve<D>]) -> Result<(), MeshError> {
        self.check()?;
        let sides = self.sides_between(first, second)?;
        let names = || (first.to_string(), second.to_string());
        if sides.is_empty() {
            let (first, second) = names();
            return Err(MeshError::NoInterface { first, second });
        }
        let interface = self.boundary(INTERFACE);
        let marked: HashSet<Side> =
            self.facets.iter().filter(|f| Some(f.boundary) == interface).map(|f| f.side()).collect();
        let unmarked = self.cells_of(sides.iter().map(|[here, _]| here).filter(|s| !marked.contains(s)));
        if !unmarked.is_empty() {
            let ((first, second), cells) = (names(), self.list_cells(&unmarked));
            return Err(MeshError::UnmarkedInterface { first, second, cells });
        }
        let between: HashSet<Side> = sides.iter().map(|[here, _]| *here).collect();
        let stray = self.cells_of(marked.iter().filter(|s| !between.contains(s)));
        if !stray.is_empty() {
            let ((first, second), cells) = (names(), self.list_cells(&stray));
            return Err(MeshError::StrayInterface { first, second, cells });
        }
        self.check_curves(curves)
    }

    /// Checks that all geometry nodes of boundaries that follow one of `curves` lie on it, to within
    /// 1e-6 of the size of the cell.
    ///
    /// # Errors
    /// [`MeshError::OffCurve`].
    pub fn check_curves(&self, curves: &[Curve<D>]) -> Result<(), MeshError> {
        for curve in curves {
            for name in curve.boundaries() {
                let Some(boundary) = self.boundary(name) else { continue };
                let (mut off, mut furthest) = (vec![], 0.0);
                for f in self.facets.iter().filter(|f| f.boundary == boundary) {
                    let nodes = self.facet_nodes(f.cell as usize, f.local as usize);
                    let at = nodes.into_iter().map(|n| self.nodes[n as usize]);
                    let away = at.map(|x| distance(x, curve.project(x))).fold(0.0, f64::max);
                    if away > SAME_PLACE * self.cell_diameter(f.cell as usize) {
                        off.push(f.side());
                        furthest = f64::max(furthest, away);
                    }
                }
                if !off.is_empty() {
                    let cells = self.list_cells(&self.cells_of(off.iter()));
                    return Err(MeshError::OffCurve { boundary: name.clone(), distance: furthest, cells });
                }
            }
        }
        Ok(())
    }

    /// Looks for places where the mesh is cut open though it should not be: outer facets with a node of
    /// another cell on them that is none of theirs.
    fn check_gaps(&self, facets: &Facets) -> Result<(), MeshError> {
        let maps: Vec<FacetMap<D>> =
            facets.outer.iter().map(|s| FacetMap::new(self, s.cell as usize, s.local as usize)).collect();
        let nodes: Vec<Vec<u32>> =
            facets.outer.iter().map(|s| self.facet_nodes(s.cell as usize, s.local as usize)).collect();
        let sizes: Vec<f64> = nodes.iter().map(|n| self.extent(n)).collect();
        let tree = BoxTree::new(maps.iter().map(FacetMap::bounds).collect::<Vec<Bounds<D>>>());
        let (mut duplicated, mut hanging) = (HashSet::new(), HashSet::new());
        let mut seen = HashSet::new();
        for (here, node) in nodes.iter().enumerate().flat_map(|(i, n)| n.iter().map(move |&n| (i, n))) {
            if !seen.insert(node) {
                continue;
            }
            let x = self.nodes[node as usize];
            tree.near(x, SAME_PLACE * sizes[here], |there| {
                let close = SAME_PLACE * f64::min(sizes[here], sizes[there]);
                if nodes[there].contains(&node) || maps[there].distance(x) > close {
                    return;
                }
                let twin = nodes[there].iter().any(|&n| distance(self.nodes[n as usize], x) <= close);
                let cells = if twin { &mut duplicated } else { &mut hanging };
                cells.extend([facets.outer[here], facets.outer[there]]);
            });
        }
        let (duplicated, hanging) = (self.cells_of(&duplicated), self.cells_of(&hanging));
        match (duplicated.is_empty(), hanging.is_empty()) {
            (true, true) => Ok(()),
            (_, false) => Err(MeshError::HangingNodes(self.list_cells(&hanging))),
            (false, true) => Err(MeshError::DuplicatedNodes(self.list_cells(&duplicated))),
        }
    }

    /// Largest distance of `nodes` from the first of them.
    fn extent(&self, nodes: &[u32]) -> f64 {
        let at = |n: u32| self.nodes[n as usize];
        nodes.iter().map(|&n| distance(at(n), at(nodes[0]))).fold(0.0, f64::max)
    }

    /// Cells of the given sides, each once, in order.
    fn cells_of<'a>(&self, sides: impl IntoIterator<Item = &'a Side>) -> Vec<usize> {
        let mut cells: Vec<usize> = sides.into_iter().map(|side| side.cell as usize).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}
