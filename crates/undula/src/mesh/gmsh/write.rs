//! Writing meshes for Gmsh and other codes.

use super::kinds::{KINDS, Kind};
use crate::element::Shape;
use crate::mesh::Mesh;

/// The mesh as text in format 2.2 (ASCII), with a named physical group for each region and boundary;
/// [`super::parse_any`] reads the same mesh, to the last bit, but for the order of facets.
pub fn write<const D: usize>(mesh: &Mesh<D>) -> String {
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    let mut put = |line: std::fmt::Arguments| text.push_str(&format!("{line}\n"));
    put(format_args!("$PhysicalNames\n{}", mesh.boundaries.len() + mesh.regions.len()));
    for (i, name) in mesh.boundaries.iter().enumerate() {
        put(format_args!("{} {} \"{name}\"", D - 1, i + 1));
    }
    for (i, name) in mesh.regions.iter().enumerate() {
        put(format_args!("{D} {} \"{name}\"", mesh.boundaries.len() + i + 1));
    }
    put(format_args!("$EndPhysicalNames\n$Nodes\n{}", mesh.nodes.len()));
    for (i, x) in mesh.nodes.iter().enumerate() {
        let x = |d: usize| x.get(d).copied().unwrap_or(0.0);
        put(format_args!("{} {} {} {}", i + 1, x(0), x(1), x(2)));
    }
    put(format_args!("$EndNodes\n$Elements\n{}", mesh.facets.len() + mesh.n_cells()));
    let side = if mesh.shape == Shape::Tetrahedron { Shape::Triangle } else { Shape::Quadrilateral };
    let facet = KINDS
        .iter()
        .find(|kind| kind.dim == D - 1 && kind.degree == mesh.degree && kind.shape.is_none_or(|s| s == side));
    let cell = KINDS.iter().find(|kind| kind.shape == Some(mesh.shape) && kind.degree == mesh.degree);
    let mut element = |number: usize, kind: Option<&Kind>, group: usize, nodes: &[u32]| {
        let Some(kind) = kind else { return };
        let tags: String = kind.in_gmsh(nodes).iter().map(|node| format!(" {}", node + 1)).collect();
        put(format_args!("{number} {} 2 {group} {group}{tags}", kind.number));
    };
    for (i, f) in mesh.facets.iter().enumerate() {
        let nodes = mesh.facet_nodes(f.cell as usize, f.local as usize);
        element(i + 1, facet, f.boundary as usize + 1, &nodes);
    }
    for i in 0..mesh.n_cells() {
        let group = mesh.boundaries.len() + mesh.cell_region[i] as usize + 1;
        element(mesh.facets.len() + i + 1, cell, group, mesh.cell(i));
    }
    put(format_args!("$EndElements"));
    text
}
