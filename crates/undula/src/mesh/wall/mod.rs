//! Elastic walls that are grown outward from a surface of a mesh of space, so that nobody has to match two meshes.

mod cells;
mod check;
mod directions;
mod rim;
mod surface;

use super::{Facet, Mesh, MeshError};
use crate::element::Shape;
use crate::math::{rounded, shortest};
use directions::Directions;
use rim::Rim;
use surface::Surface;

/// Name of the region of a wall.
pub const WALL: &str = "wall";
/// Name of its outer side.
pub const OUTER: &str = "outer";

/// Name of the ring of a wall in the plane of the boundary `opening`.
pub fn ring(opening: &str) -> String {
    format!("{WALL}-{opening}")
}

/// A wall to be grown.
#[derive(Copy, Clone)]
pub struct Wall<'a> {
    /// The boundaries that it grows from.
    pub surface: &'a [String],
    /// Its thickness \[m\] above a point of the surface.
    pub thickness: &'a dyn Fn([f64; 3]) -> f64,
    /// Layers of cells through it.
    pub layers: usize,
}

/// What is wrong with `key` of the wall.
fn refuse<T>(key: &'static str, reason: String) -> Result<T, MeshError> {
    Err(MeshError::Wall { key, reason })
}

/// A place in a message, with six digits of the size of the mesh.
fn place(mesh: &Mesh<3>, x: [f64; 3]) -> String {
    let size = mesh.diameter();
    format!("({})", x.map(|x| shortest(rounded(x, size, 6))).join(", "))
}

/// The wall above a surface, before it is joined to the mesh.
struct Growth<'a> {
    mesh: &'a Mesh<3>,
    surface: Surface,
    rim: Rim,
    /// From each node of the surface to the outer side \[m\].
    growth: Vec<[f64; 3]>,
    layers: usize,
}

impl Mesh<3> {
    /// The mesh with a wall around it, a region `wall` of the same cells: above each facet of the surface a column of
    /// `layers` hexahedra, or of three times as many tetrahedra.
    ///
    /// Node k of n above node X of the surface is X + k/n h(X) d, h being the thickness. With m the mean of the normals
    /// of the facets at X, weighted with their angles there, d = m/|m|²: of unit length where the surface is smooth, and
    /// so long at edges that the wall has its thickness on both sides. At the rim d lies in the plane of the opening, with
    /// the same component along m: the ends of the wall are as plane as the openings. Near an opening that is not
    /// perpendicular to the surface, other nodes lean with it, less and less up to 3 h |d − m/|m|²| from it.
    ///
    /// Nodes of the surface are kept, so that both sides of it share them; nodes of second-order cells have directions of
    /// their own. Prisms above triangles are cut along the diagonals at the vertices with the lower numbers (Dompierre,
    /// Labbé, Vallet and Camarero 1999). New boundaries are `outer` and, for each boundary NAME that the surface
    /// ends at, `wall-NAME`.
    ///
    /// # Errors
    /// [`MeshError::UnknownName`] for an unknown boundary. [`MeshError::Wall`] if a name is taken, the surface is not a part
    /// of the outer boundary, a thickness is not above 0, an opening is not plane or nearly tangential to the surface, or
    /// the wall folds or meets itself or the mesh.
    ///
    /// ```
    /// use undula::mesh::{Wall, generate::hexahedra};
    /// let lumen = hexahedra([0.0; 3], [1.0; 3], [2, 2, 2], 0)?;
    /// let wall = Wall { surface: &["top".into()], thickness: &|_| 0.25, layers: 2 };
    /// let mesh = lumen.with_wall(&wall)?;
    /// assert_eq!(mesh.n_cells(), 16);
    /// assert!((mesh.quality().total_volume() - 1.25).abs() < 1e-14);
    /// # Ok::<(), undula::mesh::MeshError>(())
    /// ```
    pub fn with_wall(&self, wall: &Wall<'_>) -> Result<Mesh<3>, MeshError> {
        let surface = Surface::new(self, wall.surface)?;
        let rim = Rim::new(self, &surface)?;
        self.check_wall_names(&rim)?;
        self.check_orientation()?;
        let thickness = surface.thickness(self, wall)?;
        let directions = Directions::new(self, &surface, &rim, &thickness)?.0;
        let grown = |(h, d): (&f64, [f64; 3])| d.map(|d| h * d);
        let growth = thickness.iter().zip(directions).map(grown).collect();
        let growth = Growth { mesh: self, surface, rim, growth, layers: wall.layers };
        let alone = growth.alone(1.0);
        growth.check_folds(&alone)?;
        let mesh = growth.joined(alone)?;
        growth.check_overlaps(&mesh)?;
        Ok(mesh)
    }

    /// Refuses a mesh that has the names of the wall already.
    fn check_wall_names(&self, rim: &Rim) -> Result<(), MeshError> {
        if self.region(WALL).is_some() {
            return refuse("surface", format!("the mesh has a region `{WALL}` already, the name of a wall"));
        }
        let names = rim.names.iter().map(|&name| ring(&self.boundaries[name as usize]));
        match names.chain([OUTER.to_string()]).find(|name| self.boundary(name).is_some()) {
            Some(name) => refuse(
                "surface",
                format!("the mesh has a boundary `{name}` already, the name of a side of the wall"),
            ),
            None => Ok(()),
        }
    }
}

impl Growth<'_> {
    /// Levels of nodes above the surface.
    fn levels(&self) -> usize {
        self.layers * self.mesh.degree
    }

    /// The wall with `part` of its thickness as a mesh of its own; node `(levels + 1) s + k` is number k above node s of
    /// the surface. Ring facets have boundary numbers from 1 in the order of the rim, the outer side has 0.
    fn alone(&self, part: f64) -> Mesh<3> {
        let n = self.levels();
        let mut nodes = Vec::with_capacity((n + 1) * self.growth.len());
        for (&node, growth) in self.surface.nodes.iter().zip(&self.growth) {
            let x = self.mesh.nodes[node as usize];
            let at = |k: usize| std::array::from_fn(|d| x[d] + part * (k as f64 / n as f64) * growth[d]);
            nodes.extend((0..=n).map(at));
        }
        let rings = self.rim.names.iter().map(|&name| ring(&self.mesh.boundaries[name as usize]));
        let mut wall = Mesh {
            shape: self.mesh.shape,
            degree: self.mesh.degree,
            nodes,
            cell_nodes: vec![],
            cell_region: vec![],
            regions: vec![WALL.into()],
            facets: vec![],
            boundaries: std::iter::once(OUTER.to_string()).chain(rings).collect(),
            parts: vec![],
        };
        for column in 0..self.surface.facets.len() {
            match self.mesh.shape {
                Shape::Tetrahedron => self.add_tetrahedra(column, &mut wall),
                _ => self.add_hexahedra(column, &mut wall),
            }
        }
        wall
    }

    /// The mesh with the wall joined to it.
    fn joined(&self, wall: Mesh<3>) -> Result<Mesh<3>, MeshError> {
        let mut mesh = self.mesh.clone();
        let (n, first) = (self.levels() + 1, mesh.nodes.len());
        if u32::try_from(first + self.growth.len() * (n - 1)).is_err() {
            return refuse("layers", "the mesh would have more nodes than 32 bits can number".into());
        }
        let number = |node: u32| match (node as usize / n, node as usize % n) {
            (column, 0) => self.surface.nodes[column],
            (column, level) => (first + column * (n - 1) + level - 1) as u32,
        };
        let above = wall.nodes.iter().enumerate().filter(|(i, _)| !i.is_multiple_of(n));
        mesh.nodes.extend(above.map(|(_, x)| x));
        let cells = mesh.n_cells() as u32;
        mesh.cell_nodes.extend(wall.cell_nodes.into_iter().map(number));
        let region = mesh.regions.len() as u16;
        mesh.regions.extend(wall.regions);
        mesh.cell_region.extend(wall.cell_region.iter().map(|_| region));
        let names = mesh.boundaries.len() as u16;
        mesh.boundaries.extend(wall.boundaries);
        let moved = |f: Facet| Facet { cell: f.cell + cells, boundary: f.boundary + names, ..f };
        mesh.facets.extend(wall.facets.into_iter().map(moved));
        Ok(mesh)
    }
}
