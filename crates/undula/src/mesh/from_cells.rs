//! Meshes of other programs.

use super::{Mesh, MeshError};
use crate::element::Shape;

impl Mesh<2> {
    /// A mesh of straight triangles (`N` = 3) or quadrilaterals (`N` = 4): coordinates of the nodes \[m\], numbers of the
    /// nodes of every cell in order around it, the name of the region of a cell by its centre, and the name of the
    /// boundary of an outer edge by its midpoint.
    ///
    /// The edges between fluid and solid get the name `interface` when a case uses the mesh.
    ///
    /// # Errors
    /// [`MeshError::Parameter`] for numbers of nodes that are not there, for cells that overlap at a common edge and for
    /// `N` other than 3 and 4; all defects that [`Mesh::check`] finds.
    ///
    /// ```
    /// use undula::Mesh;
    /// let nodes = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]];
    /// let region = |x: [f64; 2]| if x[0] < 1.0 { "fluid" } else { "solid" };
    /// let side = |x: [f64; 2]| if x[0] == 0.0 { "inflow" } else { "walls" };
    /// let mesh = Mesh::from_cells(nodes.clone(), &[[0, 1, 4, 3], [1, 2, 5, 4]], region, side)?;
    /// assert_eq!(mesh.n_cells(), 2);
    /// assert_eq!(mesh.regions, ["fluid", "solid"]);
    /// assert!(Mesh::from_cells(nodes, &[[0, 1, 9, 3]], region, side).is_err());
    /// # Ok::<(), undula::Error>(())
    /// ```
    pub fn from_cells<'a, const N: usize>(
        nodes: Vec<[f64; 2]>,
        cells: &[[u32; N]],
        region: impl Fn([f64; 2]) -> &'a str,
        boundary: impl Fn([f64; 2]) -> &'a str,
    ) -> Result<Mesh<2>, MeshError> {
        // Cells count their nodes row by row.
        let (shape, order): (Shape, &[usize]) = match N {
            3 => (Shape::Triangle, &[0, 1, 2]),
            4 => (Shape::Quadrilateral, &[0, 1, 3, 2]),
            _ => return refuse(format!("cells of {N} nodes: expected triangles or quadrilaterals")),
        };
        check_numbers(&nodes, cells)?;
        let mut mesh = Mesh {
            shape,
            degree: 1,
            nodes,
            cell_nodes: cells.iter().flat_map(|cell| order.iter().map(|&i| cell[i])).collect(),
            cell_region: vec![],
            regions: vec![],
            facets: vec![],
            boundaries: vec![],
            parts: vec![],
        };
        for cell in cells {
            let number = mesh.region_number(region(mesh.mean(cell)));
            mesh.cell_region.push(number);
        }
        mesh.turn_clockwise_cells();
        for side in mesh.facets_of_cells().outer {
            let nodes = mesh.facet_nodes(side.cell as usize, side.local as usize);
            let number = mesh.boundary_number(boundary(mesh.mean(&nodes)));
            mesh.facets.push(side.named(number));
        }
        // Nodes that no cell has go.
        mesh.drop_cells(|_| true);
        mesh.check()?;
        mesh.check_overlaps()?;
        Ok(mesh)
    }

    /// Straight cells that share an edge lie on both sides of it.
    fn check_overlaps(&self) -> Result<(), MeshError> {
        for [one, two] in self.facets_of_cells().inner {
            let nodes = self.facet_nodes(one.cell as usize, one.local as usize);
            let [a, b] = [nodes[0], nodes[1]].map(|n| self.nodes[n as usize]);
            let side = |cell: u32| {
                let c = self.mean(self.cell(cell as usize));
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            };
            if side(one.cell) * side(two.cell) >= 0.0 {
                let (one, two) = (one.cell, two.cell);
                return refuse(format!(
                    "cells {one} and {two} overlap: they lie on one side of their common edge"
                ));
            }
        }
        Ok(())
    }

    /// Mean of the positions of `nodes` \[m\].
    fn mean(&self, nodes: &[u32]) -> [f64; 2] {
        let sum = |d: usize| nodes.iter().map(|&n| self.nodes[n as usize][d]).sum::<f64>();
        [0, 1].map(|d| sum(d) / nodes.len() as f64)
    }

    /// Index of region `name`, a new one unless it is there.
    fn region_number(&mut self, name: &str) -> u16 {
        self.region(name).unwrap_or_else(|| {
            self.regions.push(name.to_string());
            self.regions.len() as u16 - 1
        })
    }
}

fn refuse<T>(reason: String) -> Result<T, MeshError> {
    Err(MeshError::Parameter { generator: "from_cells", reason })
}

/// Cells of nodes that are there, at finite places.
fn check_numbers<const N: usize>(nodes: &[[f64; 2]], cells: &[[u32; N]]) -> Result<(), MeshError> {
    if cells.is_empty() {
        return refuse("there is no cell".into());
    }
    let there = |node: &u32| (*node as usize) < nodes.len();
    if let Some(cell) = cells.iter().position(|cell| !cell.iter().all(there)) {
        return refuse(format!("cell {cell} = {:?}, but there are {} nodes", cells[cell], nodes.len()));
    }
    match nodes.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
        Some(node) => refuse(format!("node {node} lies at {:?}", nodes[node])),
        None => Ok(()),
    }
}
