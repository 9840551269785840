//! Meshes of triangles or quadrilaterals from Gmsh: `.msh` files of version 2.2 or 4.1, text or binary (of either order
//! of bytes), whole or divided into partitions, with parameters of the nodes or without.
//!
//! Sections may come in any order; unknown ones, and what stands between sections, are skipped. Every cell and every
//! boundary line must be in exactly one *named* physical group; the names of
//! surfaces become regions, those of curves boundaries. Triangles have 3 or 6 nodes, quadrilaterals 4 or 9. In Gmsh:
//! `Physical Surface("fluid") = {…};`, `Physical Curve("walls") = {…};`, `Mesh.ElementOrder = 2`, and for
//! quadrilaterals `Mesh.RecombineAll = 1` and for 9 nodes `Mesh.SecondOrderIncomplete = 0`.

mod build;
mod raw;
mod sections;
mod source;
mod write;

pub use write::write;

use super::{Mesh, MeshError};
use crate::element::Shape;
use source::Source;
use std::path::Path;

/// Reads the mesh in file `path`.
///
/// Cells numbered clockwise are turned round, nodes without a cell are dropped. Facets inside of the mesh
/// that carry a name are seen from the cell of the region named first in the file. Nothing else is
/// checked here, see [`Mesh::check`].
///
/// # Errors
/// [`MeshError::Unreadable`] if there is no such file, [`MeshError::File`] with the line, of binary files
/// [`MeshError::Binary`] with the byte, that cannot be used and what would be right.
pub fn read(path: &Path) -> Result<Mesh<2>, MeshError> {
    parse(bytes(path)?, path)
}

/// STUB
pub fn dimension(_: &Path) -> Result<usize, MeshError> { Ok(2) }
/// STUB
pub fn read_in_space(path: &Path) -> Result<Mesh<3>, MeshError> { let _ = path; unimplemented!() }

/// Shape of the cells of the mesh in file `path`; nothing but the cells is looked at.
///
/// # Errors
/// As [`read`].
pub fn shape(path: &Path) -> Result<Shape, MeshError> {
    let bytes = bytes(path)?;
    let mut source = Source::new(&bytes, path);
    let raw = sections::parse(&mut source)?;
    build::kind(&raw, &source).map(|kind| kind.shape)
}

/// Reads a mesh from the bytes of a file; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: impl AsRef<[u8]>, path: &Path) -> Result<Mesh<2>, MeshError> {
    let mut source = Source::new(bytes.as_ref(), path);
    let raw = sections::parse(&mut source)?;
    build::mesh(raw, &source)
}

fn bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    std::fs::read(path).map_err(|e| MeshError::Unreadable { path: path.to_path_buf(), reason: e.to_string() })
}

#[cfg(test)]
mod tests;
