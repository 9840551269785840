//! Meshes of space from plane ones: each quadrilateral is drawn out into a column of hexahedra.

use super::{Facet, Hierarchy, Mesh, MeshError, Split};
use crate::element::Shape;

/// The sides at both ends, with the number of their facets in a hexahedron.
const ENDS: [(&str, u8); 2] = [("front", 4), ("back", 5)];

/// Layers are halved with a refinement if they are at most so many times as thick as small cells of the section.
const THICK: f64 = 1.5;

impl Mesh<2> {
    /// The mesh times `0 < z < depth` \[m\] in `layers` equal layers: hexahedra of the same geometry degree.
    ///
    /// Regions, boundaries and further names stay: those of an edge are those of the sides above it. New boundaries are
    /// `front` (z = 0) and `back` (z = `depth`). Cell `layers c + l` is layer `l` above cell `c`, node
    /// `(degree layers + 1) n + k` lies above node `n`. A curved edge becomes a part of a cylinder, so that the sides
    /// are as close to their curves as the edges are.
    ///
    /// # Errors
    /// [`MeshError::Parameter`] unless `depth` is finite and above 0 and there is a layer, for triangles, for a mesh
    /// that has a name `front` or `back`, and for more nodes than 32 bits can number.
    ///
    /// ```
    /// let plane = undula::mesh::generate::rectangle([0.0, 0.0], [2.0, 1.0], [2, 1], 0)?;
    /// let space = plane.extruded(0.5, 3)?;
    /// assert_eq!(space.n_cells(), 6);
    /// assert_eq!(space.boundaries, ["left", "right", "bottom", "top", "front", "back"]);
    /// # Ok::<(), undula::mesh::MeshError>(())
    /// ```
    pub fn extruded(&self, depth: f64, layers: usize) -> Result<Mesh<3>, MeshError> {
        if !(depth > 0.0 && depth.is_finite()) {
            return reject(format!("depth = {depth}: expected a number above 0"));
        }
        self.between(0.0, depth, layers)
    }

    /// The same with the first and the last layer halved `grading` times towards `front` and `back`: `layers + 2 grading`
    /// layers in all.
    ///
    /// # Errors
    /// Those of [`Mesh::extruded`].
    pub fn extruded_graded(&self, depth: f64, layers: usize, grading: usize) -> Result<Mesh<3>, MeshError> {
        if grading == 0 || layers == 0 || !(depth > 0.0 && depth.is_finite()) {
            return self.extruded(depth, layers);
        }
        if layers == 1 {
            return reject("layers = 1: at least two are needed, one at each end, to be halved".into());
        }
        let layer = depth / layers as f64;
        let near: Vec<f64> = (1..=grading).rev().map(|i| layer * 0.5_f64.powi(i as i32)).collect();
        let mut sides = vec![0.0];
        sides.extend(&near);
        sides.extend((1..layers).map(|i| layer * i as f64));
        sides.extend(near.iter().rev().map(|z| depth - z));
        sides.push(depth);
        self.along(&sides)
    }

    /// The same between z = `lower` and z = `upper`, exactly.
    pub(super) fn between(&self, lower: f64, upper: f64, layers: usize) -> Result<Mesh<3>, MeshError> {
        self.check_extrusion(layers)?;
        let n = self.degree * layers;
        let level = |k: usize| match k as f64 / n as f64 {
            1.0 => upper,
            s => lower + s * (upper - lower),
        };
        let levels: Vec<f64> = (0..=n).map(level).collect();
        Ok(self.drawn_along(&levels, &Columns { layers, splits: &[] }))
    }

    /// The same with layers between the `sides` \[m\], which rise.
    pub(super) fn along(&self, sides: &[f64]) -> Result<Mesh<3>, MeshError> {
        let layers = sides.len() - 1;
        self.check_extrusion(layers)?;
        let level = |k: usize| {
            let (layer, part) = (k / self.degree, (k % self.degree) as f64 / self.degree as f64);
            sides[layer] + if part > 0.0 { part * (sides[layer + 1] - sides[layer]) } else { 0.0 }
        };
        let levels: Vec<f64> = (0..=self.degree * layers).map(level).collect();
        Ok(self.drawn_along(&levels, &Columns { layers, splits: &[] }))
    }

    /// Whether it can be drawn out.
    fn check_extrusion(&self, layers: usize) -> Result<(), MeshError> {
        if self.shape != Shape::Quadrilateral {
            return reject(format!("the mesh has {}: expected quadrilaterals", self.shape.name()));
        }
        if layers == 0 {
            return reject("layers = 0: at least one is needed".into());
        }
        let taken = |name: &&str| self.boundary(name).is_some() || self.region(name).is_some();
        if let Some(name) = ENDS.iter().map(|(name, _)| *name).find(taken) {
            return reject(format!(
                "the mesh has the name `{name}` already, which the sides across z get: give it another name"
            ));
        }
        let levels = self.degree.checked_mul(layers).and_then(|n| n.checked_add(1));
        let nodes = levels.and_then(|levels| levels.checked_mul(self.nodes.len()));
        match nodes.is_some_and(|n| u32::try_from(n).is_ok()) {
            true => Ok(()),
            false => {
                reject(format!("layers = {layers}: the mesh would have more nodes than 32 bits can number"))
            }
        }
    }

    /// The mesh with the nodes at each of `levels`, and cells in the order of `columns`.
    fn drawn_along(&self, levels: &[f64], columns: &Columns<'_>) -> Mesh<3> {
        let (k, layers) = (self.degree, columns.layers);
        let mut mesh = Mesh {
            shape: Shape::Hexahedron,
            degree: k,
            nodes: self.nodes.iter().flat_map(|&[x, y]| levels.iter().map(move |&z| [x, y, z])).collect(),
            cell_nodes: vec![0; self.cell_nodes.len() * layers * (k + 1)],
            cell_region: vec![0; self.n_cells() * layers],
            regions: self.regions.clone(),
            facets: columns.sides(&self.facets),
            boundaries: self.boundaries.clone(),
            parts: columns.sides(&self.parts),
        };
        let plane = self.shape.n_nodes(k);
        let n = plane * (k + 1);
        for (cell, &region) in self.cell_region.iter().enumerate() {
            for layer in 0..layers {
                let here = columns.cell(cell, layer);
                mesh.cell_region[here] = region;
                for (i, node) in mesh.cell_nodes[here * n..(here + 1) * n].iter_mut().enumerate() {
                    let level = layer * k + i / plane;
                    *node = self.cell(cell)[i % plane] * levels.len() as u32 + level as u32;
                }
            }
        }
        for ((name, local), layer) in ENDS.into_iter().zip([0, layers - 1]) {
            let boundary = mesh.boundary_number(name);
            let facet = |c| Facet { cell: columns.cell(c, layer) as u32, local, boundary };
            mesh.facets.extend((0..self.n_cells()).map(facet));
        }
        mesh
    }
}

/// How a plane mesh is drawn out.
#[derive(Copy, Clone, Debug)]
pub struct Extrusion {
    /// Of all layers \[m\].
    pub depth: f64,
    /// Layers before the outer ones are halved.
    pub layers: usize,
    /// How often the first and the last layer are halved.
    pub grading: usize,
    /// Whether coarser meshes have half as many layers wherever that can be, as patches of eight cells need.
    pub halved: bool,
}

impl Hierarchy<2> {
    /// `finest`, the mesh that this is the hierarchy of, drawn out as by [`Mesh::extruded_graded`], and its coarser meshes.
    ///
    /// Each is the coarser plane mesh. It has half as many layers if they are alike, their number is even and they are
    /// not thicker than the cells of the section are large; else it has the same layers, so that multigrid coarsens along
    /// the strong couplings alone. The children of a cell are those of the plane cell, then in half as many layers
    /// those of the upper half.
    ///
    /// # Errors
    /// Those of [`Mesh::extruded_graded`].
    pub fn extruded(&self, finest: &Mesh<2>, how: Extrusion) -> Result<(Mesh<3>, Hierarchy<3>), MeshError> {
        let Extrusion { depth, layers, grading, .. } = how;
        let whole = finest.extruded_graded(depth, layers, grading)?;
        if self.coarser().is_empty() {
            return Ok((whole, Hierarchy::default()));
        }
        let layers = if grading == 0 { layers } else { layers + 2 * grading };
        let levels: Vec<f64> = whole.nodes[..=finest.degree * layers].iter().map(|x| x[2]).collect();
        let splits = self.splits_of_layers(finest, layers, how);
        let mut meshes = vec![];
        let halvings = |from: usize| splits[from..].iter().filter(|s| **s == Split::Whole).count();
        for (j, plane) in self.levels(finest).enumerate() {
            let step = 1 << halvings(j);
            let levels: Vec<f64> = levels.iter().copied().step_by(step).collect();
            let columns = Columns { layers: layers / step, splits: &splits[..j] };
            meshes.push(plane.drawn_along(&levels, &columns));
        }
        let finest = meshes.pop().unwrap_or(whole);
        let diagonals = vec![vec![]; meshes.len()];
        Ok((finest, Hierarchy { coarser: meshes, splits, diagonals }))
    }

    /// Whether the `layers` are halved with each refinement.
    fn splits_of_layers(&self, finest: &Mesh<2>, layers: usize, how: Extrusion) -> Vec<Split> {
        let mut layers = layers;
        let mut splits = vec![];
        let levels: Vec<&Mesh<2>> = self.levels(finest).skip(1).collect();
        for plane in levels.into_iter().rev() {
            let thickness = how.depth / layers as f64;
            let fits = how.halved || thickness <= THICK * size_of_small_cells(plane);
            let halves = how.grading == 0 && layers.is_multiple_of(2) && fits;
            splits.push(if halves { Split::Whole } else { Split::Section });
            layers /= if halves { 2 } else { 1 };
        }
        splits.reverse();
        splits
    }
}

/// The size that a tenth of the cells are below \[m\].
fn size_of_small_cells(mesh: &Mesh<2>) -> f64 {
    let of = |cell| mesh.sizes(cell).into_iter().fold(0.0, f64::max);
    let mut sizes: Vec<f64> = (0..mesh.n_cells()).map(of).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 10).copied().unwrap_or(0.0)
}

/// The order of cells that stand above those of a plane mesh.
struct Columns<'a> {
    layers: usize,
    /// How the cells of the coarser levels are split, the coarsest first.
    splits: &'a [Split],
}

impl Columns<'_> {
    /// Number of the cell in `layer` above plane cell `cell`.
    fn cell(&self, cell: usize, layer: usize) -> usize {
        let mut finer = self.splits.len();
        let mut halvings = self.splits.iter().filter(|split| **split == Split::Whole).count();
        let coarsest = (self.layers >> halvings) * (cell >> (2 * finer)) + (layer >> halvings);
        self.splits.iter().fold(coarsest, |parent, split| {
            finer -= 1;
            let child = cell >> (2 * finer) & 3;
            match split {
                Split::Whole => {
                    halvings -= 1;
                    8 * parent + child + 4 * (layer >> halvings & 1)
                }
                Split::Section => 4 * parent + child,
            }
        })
    }

    /// The sides above the edges `facets`; their numbers in the cells are those of the edges.
    fn sides(&self, facets: &[Facet]) -> Vec<Facet> {
        let above = |f: &Facet| {
            let f = *f;
            (0..self.layers).map(move |layer| Facet { cell: self.cell(f.cell as usize, layer) as u32, ..f })
        };
        facets.iter().flat_map(above).collect()
    }
}

fn reject<T>(reason: String) -> Result<T, MeshError> {
    Err(MeshError::Parameter { generator: "extrude", reason })
}
