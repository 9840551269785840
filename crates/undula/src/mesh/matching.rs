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
        let all: Vec<&str> = self.regions.iter().map(String::as_str).collect();
        self.check_kept(&all)
    }

    /// The same, but the outer facets of regions that are not in `keep` need no name.
    ///
    /// # Errors
    /// Those of [`Mesh::check`].
    pub fn check_kept(&self, keep: &[&str]) -> Result<(), MeshError> {
        self.check_orientation()?;
        let facets = self.facets_of_cells();
        if !facets.bad.is_empty() {
            let cells: Vec<usize> = facets.bad.iter().map(|&c| c as usize).collect();
            return Err(MeshError::NotConforming(self.list_cells(&cells)));
        }
        self.check_gaps(&facets)?;
        let named: HashSet<Side> = self.facets.iter().map(|f| f.side()).collect();
        let kept =
            |side: &&Side| keep.contains(&&*self.regions[self.cell_region[side.cell as usize] as usize]);
        match self.cells_of(facets.outer.iter().filter(kept).filter(|side| !named.contains(side))) {
            none if none.is_empty() => Ok(()),
            cells => Err(MeshError::UnnamedBoundary(self.list_cells(&cells))),
        }
    }

    /// Checks in addition that the mesh *matches* the two regions, see [`Mesh::check_interface`], and that all geometry
    /// nodes of boundaries that follow one of `curves` lie on it.
    ///
    /// # Errors
    /// Those of [`Mesh::check`], [`Mesh::check_interface`] and [`Mesh::check_curves`].
    pub fn check_matching(&self, first: &str, second: &str, curves: &[Curve<D>]) -> Result<(), MeshError> {
        self.check()?;
        self.check_interface(first, second)?;
        self.check_curves(curves)
    }

    /// Checks that the mesh matches the two regions (Definition 5.9, Remark 5.10): boundary `interface` is exactly the
    /// set of facets between `first` and `second` (every cell being in one region).
    ///
    /// # Errors
    /// [`MeshError::NoInterface`], [`MeshError::UnmarkedInterface`], [`MeshError::StrayInterface`].
    pub fn check_interface(&self, first: &str, second: &str) -> Result<(), MeshError> {
        self.check_interface_of(&[first], &[second])
    }

    /// The same of several regions on each side, the first one that of a cell from which the interface is seen.
    ///
    /// # Errors
    /// As [`Mesh::check_interface`].
    pub fn check_interface_of(&self, firsts: &[&str], seconds: &[&str]) -> Result<(), MeshError> {
        let mut sides = vec![];
        for first in firsts {
            for second in seconds {
                sides.extend(self.sides_between(first, second)?);
            }
        }
        let names = || (firsts.join(", "), seconds.join(", "));
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
        Ok(())
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

#[cfg(test)]
mod tests {
    use crate::mesh::generate::{cylinder, rectangle, turek_hron};
    use crate::mesh::{Facet, Mesh, MeshError};

    fn unit_square(n: usize) -> Mesh<2> {
        rectangle([0.0, 0.0], [1.0, 1.0], [n, n], 0).unwrap()
    }

    /// Gives the cells of region `region` nodes of their own.
    fn cut_open(mesh: &mut Mesh<2>, region: u16) {
        let n = mesh.nodes.len() as u32;
        mesh.nodes.extend(mesh.nodes.clone());
        for cell in (0..mesh.n_cells()).filter(|&c| mesh.cell_region[c] == region).collect::<Vec<_>>() {
            mesh.cell_nodes[9 * cell..9 * cell + 9].iter_mut().for_each(|node| *node += n);
        }
    }

    #[test]
    fn duplicated_interface_nodes_are_refused() {
        let mut mesh = turek_hron(0, 0);
        cut_open(&mut mesh, 1);
        match mesh.check_matching("fluid", "solid", &[cylinder()]) {
            Err(MeshError::DuplicatedNodes(cells)) => {
                assert_eq!(cells.first.len(), 10);
                let more = format!("and {} more", cells.count - 10);
                assert!(MeshError::DuplicatedNodes(cells).to_string().ends_with(&more));
            }
            other => panic!("{other:?}"),
        }
    }

    /// The unit square with the right half twice as fine and not connected in between.
    fn hanging() -> Mesh<2> {
        let mut mesh = rectangle([0.0, 0.0], [0.5, 1.0], [1, 2], 0).unwrap();
        let right = rectangle([0.5, 0.0], [1.0, 1.0], [2, 4], 0).unwrap();
        let (nodes, cells) = (mesh.nodes.len() as u32, mesh.n_cells() as u32);
        mesh.nodes.extend(&right.nodes);
        mesh.cell_nodes.extend(right.cell_nodes.iter().map(|n| n + nodes));
        mesh.cell_region.extend(&right.cell_region);
        mesh.facets.extend(right.facets.iter().map(|&f| Facet { cell: f.cell + cells, ..f }));
        mesh
    }

    #[test]
    fn hanging_nodes_are_refused() {
        match hanging().check() {
            Err(MeshError::HangingNodes(cells)) => assert_eq!(cells.count, 6),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn folded_unnamed_and_misfitting_cells_are_refused() {
        let mut folded = unit_square(3);
        let (node, _) = folded.nearest_node([1.0 / 3.0, 1.0 / 3.0]).unwrap();
        folded.nodes[node as usize] = [0.9, 0.9];
        assert!(matches!(folded.check(), Err(MeshError::Inverted(..))));

        let mut unnamed = unit_square(3);
        unnamed.facets.retain(|f| f.boundary != 3);
        match unnamed.check() {
            Err(MeshError::UnnamedBoundary(cells)) => {
                assert_eq!(cells.first.iter().map(|c| c.cell).collect::<Vec<_>>(), [6, 7, 8]);
            }
            other => panic!("{other:?}"),
        }

        let mut twice = unit_square(2);
        twice.cell_nodes.extend(twice.cell(0).to_vec());
        twice.cell_region.push(0);
        assert!(matches!(twice.check(), Err(MeshError::NotConforming(_))));
    }

    #[test]
    fn misplaced_names_and_nodes_off_the_circle_are_refused() {
        let mut off = turek_hron(0, 0);
        let f = *off.facets.iter().find(|f| off.boundaries[f.boundary as usize] == "cylinder").unwrap();
        let node = off.facet_nodes(f.cell as usize, f.local as usize)[1] as usize;
        off.nodes[node][0] += 1e-4;
        match off.check_matching("fluid", "solid", &[cylinder()]) {
            Err(MeshError::OffCurve { boundary, distance, .. }) => {
                assert!(boundary == "cylinder" && distance > 1e-5 && distance < 2e-4);
            }
            other => panic!("{other:?}"),
        }

        let mut stray = turek_hron(0, 0);
        let (walls, interface) = (stray.boundary("walls").unwrap(), stray.boundary("interface").unwrap());
        stray.facets.iter_mut().find(|f| f.boundary == walls).unwrap().boundary = interface;
        assert!(matches!(stray.check_matching("fluid", "solid", &[]), Err(MeshError::StrayInterface { .. })));
    }
}
