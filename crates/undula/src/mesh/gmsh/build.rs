//! From the sections of a file to a mesh.

use super::lines::error;
use super::sections::{Element, Node, Raw};
use crate::element::Shape;
use crate::mesh::topology::FacetKey;
use crate::mesh::{Mesh, MeshError, Side};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

/// Shape, degree and nodes in lexicographic order of cells with `n` nodes; Gmsh has corners first, then mid nodes,
/// both counter-clockwise.
fn kind(n: usize) -> (Shape, usize, &'static [usize]) {
    match n {
        3 => (Shape::Triangle, 1, &[0, 1, 2]),
        6 => (Shape::Triangle, 2, &[0, 3, 1, 5, 4, 2]),
        4 => (Shape::Quadrilateral, 1, &[0, 1, 3, 2]),
        _ => (Shape::Quadrilateral, 2, &[0, 4, 1, 7, 8, 5, 3, 6, 2]),
    }
}

/// Builds the mesh.
pub(super) fn mesh(raw: Raw, path: &Path) -> Result<Mesh<2>, MeshError> {
    let (surfaces, curves): (Vec<&Element>, Vec<&Element>) = raw.elements.iter().partition(|e| e.dim == 2);
    let Some(first) = surfaces.first() else {
        return Err(error(path, 1, "the mesh has no triangles or quadrilaterals".into()));
    };
    let (shape, degree, order) = kind(first.nodes.len());
    let mut mesh = Mesh {
        shape,
        degree,
        nodes: vec![],
        cell_nodes: vec![],
        cell_region: vec![],
        regions: vec![],
        facets: vec![],
        boundaries: vec![],
        parts: vec![],
    };
    let number = nodes(&raw, &surfaces, &mut mesh, path)?;
    let regions = Groups::new(&raw, 2, path);
    mesh.regions = regions.names.clone();
    for element in &surfaces {
        if element.nodes.len() != first.nodes.len() {
            let reason = format!(
                "a cell of {} nodes after one of {} in line {}; all must be alike",
                element.nodes.len(),
                first.nodes.len(),
                first.line
            );
            return Err(error(path, element.line, reason));
        }
        mesh.cell_nodes.extend(order.iter().map(|&i| number[&element.nodes[i]]));
        mesh.cell_region.push(regions.index(element)?);
    }
    mesh.turn_clockwise_cells();
    let boundaries = Groups::new(&raw, 1, path);
    facets(&curves, &number, &boundaries, &mut mesh, path)?;
    mesh.boundaries = boundaries.names;
    // Groups without elements go.
    mesh.drop_cells(|_| true);
    Ok(mesh)
}

/// Adds the nodes of the cells in the order of the file; returns their numbers by tag.
fn nodes(
    raw: &Raw,
    surfaces: &[&Element],
    mesh: &mut Mesh<2>,
    path: &Path,
) -> Result<HashMap<u64, u32>, MeshError> {
    let mut at: HashMap<u64, &Node> = HashMap::new();
    for node in &raw.nodes {
        if let Some(before) = at.insert(node.tag, node) {
            let reason = format!("node {} is in line {} already", node.tag, before.line);
            return Err(error(path, node.line, reason));
        }
    }
    let mut used: HashSet<u64> = HashSet::new();
    for element in surfaces {
        if let Some(tag) = element.nodes.iter().find(|tag| !at.contains_key(tag)) {
            return Err(error(path, element.line, format!("node {tag} is not in section `$Nodes`")));
        }
        used.extend(&element.nodes);
    }
    let mut number = HashMap::new();
    let mut plane = None;
    for &Node { line, tag, x: [x, y, z] } in raw.nodes.iter().filter(|node| used.contains(&node.tag)) {
        let level = *plane.get_or_insert(z);
        if (z - level).abs() > 1e-10 * (1.0 + x.abs() + y.abs()) {
            let reason =
                format!("node {tag} at z = {z}, others at z = {level}; a plane mesh in x and y is needed");
            return Err(error(path, line, reason));
        }
        number.insert(tag, mesh.nodes.len() as u32);
        mesh.nodes.push([x, y]);
    }
    Ok(number)
}

/// Adds the named facets.
fn facets(
    curves: &[&Element],
    number: &HashMap<u64, u32>,
    groups: &Groups,
    mesh: &mut Mesh<2>,
    path: &Path,
) -> Result<(), MeshError> {
    let mut sides: HashMap<FacetKey, Vec<Side>> = HashMap::new();
    for (key, side) in mesh.sides_by_vertices() {
        sides.entry(key).or_default().push(side);
    }
    let mut named: BTreeMap<Side, (u16, usize)> = BTreeMap::new();
    for element in curves.iter().filter(|e| e.group != 0) {
        let refuse = |reason: String| Err(error(path, element.line, reason));
        let boundary = groups.index(element)?;
        let mut key = [u32::MAX; 4];
        for (entry, tag) in key.iter_mut().zip(&element.nodes[..2]) {
            *entry = number.get(tag).copied().unwrap_or(u32::MAX);
        }
        key.sort_unstable();
        let region = |side: &Side| mesh.cell_region[side.cell as usize];
        let side = match sides.get(&key).map_or(&[][..], |at| &at[..]) {
            [] => return refuse("a line that is no edge of a cell".into()),
            [one, two] if region(one) == region(two) => {
                let region = &mesh.regions[region(one) as usize];
                return refuse(format!(
                    "a line inside of region `{region}`; boundaries and interfaces only have names"
                ));
            }
            at => *at.iter().min_by_key(|side| (region(side), **side)).unwrap_or(&at[0]),
        };
        if let Some((other, line)) = named.insert(side, (boundary, element.line))
            && other != boundary
        {
            return refuse(format!(
                "a line that is in another physical group in line {line}; it can be in one only"
            ));
        }
    }
    mesh.facets = named.into_iter().map(|(side, (boundary, _))| side.named(boundary)).collect();
    Ok(())
}

/// The physical groups of one dimension.
struct Groups<'a> {
    path: &'a Path,
    dim: usize,
    /// Their names in the order of the file, each once.
    names: Vec<String>,
    /// Index into `names` by tag.
    by_tag: HashMap<i64, u16>,
}

impl<'a> Groups<'a> {
    fn new(raw: &Raw, dim: usize, path: &'a Path) -> Self {
        let mut groups = Groups { path, dim, names: vec![], by_tag: HashMap::new() };
        for (_, tag, name) in raw.names.iter().filter(|(d, _, _)| *d == dim) {
            let index = groups.names.iter().position(|n| n == name).unwrap_or(groups.names.len());
            if index == groups.names.len() {
                groups.names.push(name.clone());
            }
            groups.by_tag.insert(*tag, index as u16);
        }
        groups
    }

    /// Index of the group of `element`, which must have a name.
    fn index(&self, element: &Element) -> Result<u16, MeshError> {
        let (kind, what, example) = match self.dim {
            1 => ("Curve", "line", "walls"),
            _ => ("Surface", "cell", "fluid"),
        };
        let group = element.group;
        let reason = match self.by_tag.get(&group) {
            Some(&index) => return Ok(index),
            None if group == 0 => format!("a {what} in no physical group"),
            None => format!("a {what} in physical group {group}, which has no name"),
        };
        let advice = format!(
            "give its {} a named one, such as `Physical {kind}(\"{example}\") = {{…}};`",
            kind.to_lowercase()
        );
        Err(error(self.path, element.line, format!("{reason}: {advice}")))
    }
}
