//! Meshes of triangles or quadrilaterals from Gmsh: `.msh` files of version 2.2 or 4.1, ASCII.
//!
//! Every cell and every boundary line must be in exactly one *named* physical group; the names of
//! surfaces become regions, those of curves boundaries. Triangles have 3 or 6 nodes, quadrilaterals 4 or 9. In Gmsh:
//! `Physical Surface("fluid") = {…};`, `Physical Curve("walls") = {…};`, `Mesh.ElementOrder = 2`, and for
//! quadrilaterals `Mesh.RecombineAll = 1` and for 9 nodes `Mesh.SecondOrderIncomplete = 0`.

mod build;
mod lines;
mod sections;
mod write;

pub use write::write;

use super::{Mesh, MeshError};
use std::path::Path;

/// Reads the mesh in file `path`.
///
/// Cells numbered clockwise are turned round, nodes without a cell are dropped. Facets inside of the mesh
/// that carry a name are seen from the cell of the region named first in the file. Nothing else is
/// checked here, see [`Mesh::check`].
///
/// # Errors
/// [`MeshError::Unreadable`] if there is no such file, [`MeshError::File`] with the line that cannot be
/// used and what would be right.
pub fn read(path: &Path) -> Result<Mesh<2>, MeshError> {
    let bytes = std::fs::read(path)
        .map_err(|e| MeshError::Unreadable { path: path.to_path_buf(), reason: e.to_string() })?;
    // Binary files are recognised by their header; the rest of them need not be text.
    parse(&String::from_utf8_lossy(&bytes), path)
}

/// Reads a mesh from the text of a file; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Mesh<2>, MeshError> {
    let raw = sections::parse(&mut lines::Lines::new(text, path))?;
    build::mesh(raw, path)
}

#[cfg(test)]
mod tests;
