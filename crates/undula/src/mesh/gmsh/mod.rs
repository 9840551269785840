//! Meshes of triangles, quadrilaterals, tetrahedra or hexahedra from Gmsh: `.msh` files of version 2.2 or 4.1, text or binary (of
//! either order of bytes), whole or divided into partitions, with parameters of the nodes or without.
//!
//! Sections may come in any order; unknown ones, and what stands between sections, are skipped. Every cell and every
//! facet of the boundary must be in exactly one *named* physical group. In a plane mesh the names of surfaces become
//! regions, those of curves boundaries; triangles have 3 or 6 nodes, quadrilaterals 4 or 9. A file with elements of
//! volumes is a mesh of space: the names of volumes become regions, those of surfaces boundaries, those of curves are left
//! out; tetrahedra have 4 or 10 nodes, hexahedra 8 or 27. In Gmsh: `Physical Surface("fluid") = {…};`, `Physical Curve("walls") = {…};` and
//! `Physical Volume("fluid") = {…};`, `Physical Surface("walls") = {…};` in space, `Mesh.ElementOrder = 2`, for
//! quadrilaterals and hexahedra `Mesh.RecombineAll = 1` and for 9 and 27 nodes `Mesh.SecondOrderIncomplete = 0`.
//!
//! If no group of a dimension has a name, as in files of meshio, groups are called by their numbers. VTU files are read
//! here, too, see `vtu`.

mod build;
mod kinds;
mod raw;
mod sections;
mod source;
mod vtu;
mod write;

pub use write::write;

use super::{Mesh, MeshError};
use crate::element::Shape;
use source::Source;
use std::path::Path;

/// A mesh of either dimension.
#[derive(Clone, Debug)]
pub enum AnyMesh {
    /// Of triangles or quadrilaterals.
    Plane(Mesh<2>),
    /// Of tetrahedra or hexahedra.
    Space(Mesh<3>),
}

/// Reads the mesh in file `path`: one of space if there are elements of volumes.
///
/// # Errors
/// As [`read`].
pub fn read_any(path: &Path) -> Result<AnyMesh, MeshError> {
    parse_any(bytes(path)?, path)
}

/// Reads the plane mesh in file `path`.
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

/// Dimension of the mesh in file `path`; nothing but the cells is looked at.
///
/// # Errors
/// As [`read`].
pub fn dimension(path: &Path) -> Result<usize, MeshError> {
    let bytes = bytes(path)?;
    Ok(build::dimension(&contents(&mut Source::new(&bytes, path))?))
}

/// Shape of the cells of the mesh in file `path`; nothing but the cells is looked at.
///
/// # Errors
/// As [`read`].
pub fn shape(path: &Path) -> Result<Shape, MeshError> {
    let bytes = bytes(path)?;
    let mut source = Source::new(&bytes, path);
    let raw = contents(&mut source)?;
    let kind = build::kind(&raw, &source)?;
    kind.shape.ok_or_else(|| source.error("the mesh has no cells".into()))
}

/// Reads a mesh from the bytes of a file; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse_any(bytes: impl AsRef<[u8]>, path: &Path) -> Result<AnyMesh, MeshError> {
    let mut source = Source::new(bytes.as_ref(), path);
    let raw = contents(&mut source)?;
    match build::dimension(&raw) {
        2 => build::mesh(raw, &source).map(AnyMesh::Plane),
        _ => build::mesh(raw, &source).map(AnyMesh::Space),
    }
}

/// Reads a plane mesh from the bytes of a file; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: impl AsRef<[u8]>, path: &Path) -> Result<Mesh<2>, MeshError> {
    let mut source = Source::new(bytes.as_ref(), path);
    let raw = contents(&mut source)?;
    build::mesh(raw, &source)
}

/// The nodes and elements of a file of either kind.
fn contents(source: &mut Source) -> Result<raw::Raw, MeshError> {
    if vtu::is_vtu(source.bytes()) {
        vtu::parse(source.bytes(), source.path)
    } else {
        sections::parse(source)
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    std::fs::read(path).map_err(|e| MeshError::Unreadable { path: path.to_path_buf(), reason: e.to_string() })
}

#[cfg(test)]
mod tests;
