//! Writing meshes for Gmsh and other codes.

use crate::element::Shape;
use crate::mesh::Mesh;

/// The mesh as text in format 2.2 (ASCII), with a named physical group for each region and boundary;
/// [`super::parse`] reads the same mesh, to the last bit, but for the order of facets.
pub fn write(mesh: &Mesh<2>) -> String {
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    let mut put = |line: std::fmt::Arguments| text.push_str(&format!("{line}\n"));
    put(format_args!("$PhysicalNames\n{}", mesh.boundaries.len() + mesh.regions.len()));
    for (i, name) in mesh.boundaries.iter().enumerate() {
        put(format_args!("1 {} \"{name}\"", i + 1));
    }
    for (i, name) in mesh.regions.iter().enumerate() {
        put(format_args!("2 {} \"{name}\"", mesh.boundaries.len() + i + 1));
    }
    put(format_args!("$EndPhysicalNames\n$Nodes\n{}", mesh.nodes.len()));
    for (i, [x, y]) in mesh.nodes.iter().enumerate() {
        put(format_args!("{} {x} {y} 0", i + 1));
    }
    put(format_args!("$EndNodes\n$Elements\n{}", mesh.facets.len() + mesh.n_cells()));
    for (i, f) in mesh.facets.iter().enumerate() {
        let nodes = mesh.facet_nodes(f.cell as usize, f.local as usize);
        let (kind, order): (u32, &[usize]) = if mesh.degree == 1 { (1, &[0, 1]) } else { (8, &[0, 2, 1]) };
        let group = f.boundary + 1;
        put(format_args!("{} {kind} 2 {group} {group}{}", i + 1, tags(&nodes, order)));
    }
    for cell in 0..mesh.n_cells() {
        let (kind, order): (u32, &[usize]) = match (mesh.shape, mesh.degree) {
            (Shape::Triangle, 1) => (2, &[0, 1, 2]),
            (Shape::Triangle, _) => (9, &[0, 2, 5, 1, 4, 3]),
            (_, 1) => (3, &[0, 1, 3, 2]),
            _ => (10, &[0, 2, 8, 6, 1, 5, 7, 3, 4]),
        };
        let group = mesh.boundaries.len() + mesh.cell_region[cell] as usize + 1;
        let number = mesh.facets.len() + cell + 1;
        put(format_args!("{number} {kind} 2 {group} {group}{}", tags(mesh.cell(cell), order)));
    }
    put(format_args!("$EndElements"));
    text
}

/// The nodes in the given order, each after a space, from 1.
fn tags(nodes: &[u32], order: &[usize]) -> String {
    order.iter().map(|&i| format!(" {}", nodes[i] + 1)).collect()
}
