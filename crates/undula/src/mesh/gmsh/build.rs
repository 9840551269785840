//! From the sections of a file to a mesh.

use super::raw::{Element, Node, Raw, Version};
use super::source::{At, Source, error};
use crate::element::Shape;
use crate::mesh::topology::FacetKey;
use crate::mesh::{Mesh, MeshError, Side};
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Cells that Gmsh has a type for.
pub(super) struct Kind {
    pub shape: Shape,
    degree: usize,
    n_nodes: usize,
    /// Nodes in lexicographic order; Gmsh has corners first, then mid nodes, both counter-clockwise.
    order: &'static [usize],
}

const KINDS: [Kind; 4] = [
    Kind { shape: Shape::Triangle, degree: 1, n_nodes: 3, order: &[0, 1, 2] },
    Kind { shape: Shape::Triangle, degree: 2, n_nodes: 6, order: &[0, 3, 1, 5, 4, 2] },
    Kind { shape: Shape::Quadrilateral, degree: 1, n_nodes: 4, order: &[0, 1, 3, 2] },
    Kind { shape: Shape::Quadrilateral, degree: 2, n_nodes: 9, order: &[0, 4, 1, 7, 8, 5, 3, 6, 2] },
];

/// The one kind that all cells have.
pub(super) fn kind(raw: &Raw, source: &Source) -> Result<&'static Kind, MeshError> {
    let mut cells = raw.elements.iter().filter(|e| e.dim == 2);
    let Some(first) = cells.next() else {
        let advice = "give surfaces a named one, such as `Physical Surface(\"fluid\") = {…};`, and mesh with `gmsh -2`";
        let reason = format!("the mesh has no triangles or quadrilaterals in a physical group: {advice}");
        return Err(source.error(reason));
    };
    match cells.find(|e| e.nodes.len() != first.nodes.len()) {
        None => Ok(KINDS.iter().find(|k| k.n_nodes == first.nodes.len()).unwrap_or(&KINDS[0])),
        Some(other) => Err(error(source.path, other.at, mixed(raw))),
    }
}

/// What is wrong with cells of several kinds.
fn mixed(raw: &Raw) -> String {
    let count = |n: usize| raw.elements.iter().filter(|e| e.dim == 2 && e.nodes.len() == n).count();
    let some: Vec<_> = KINDS.iter().map(|kind| (kind, count(kind.n_nodes))).filter(|(_, n)| *n > 0).collect();
    let degrees = some.iter().any(|(kind, _)| kind.degree != some[0].0.degree);
    let name = |&(kind, n): &(&Kind, usize)| {
        let name = if kind.shape == Shape::Triangle { "triangle" } else { "quadrilateral" };
        let nodes = if degrees { format!(" with {} nodes", kind.n_nodes) } else { String::new() };
        format!("{n} {name}{}{nodes}", if n == 1 { "" } else { "s" })
    };
    let counts = some.iter().map(name).collect::<Vec<_>>().join(" and ");
    let mut advice = vec![];
    if some.iter().any(|(kind, _)| kind.shape != some[0].0.shape) {
        advice.push(
            "`Mesh.SubdivisionAlgorithm = 1;` makes quadrilaterals of all of them, `Mesh.RecombineAll = 0;` without \
             `Recombine Surface` triangles",
        );
    }
    if degrees {
        advice.push("`Mesh.ElementOrder = 2;` gives all of them nodes of the second order");
    }
    format!("the mesh has {counts}; all must be alike: {}", advice.join("; "))
}

/// Builds the mesh.
pub(super) fn mesh(raw: Raw, source: &Source) -> Result<Mesh<2>, MeshError> {
    let (surfaces, curves): (Vec<&Element>, Vec<&Element>) = raw.elements.iter().partition(|e| e.dim == 2);
    let kind = kind(&raw, source)?;
    let mut mesh = Mesh {
        shape: kind.shape,
        degree: kind.degree,
        nodes: vec![],
        cell_nodes: vec![],
        cell_region: vec![],
        regions: vec![],
        facets: vec![],
        boundaries: vec![],
        parts: vec![],
    };
    let number = nodes(&raw, &surfaces, &mut mesh, source)?;
    let regions = Groups::new(&raw, 2, source);
    mesh.regions = regions.names.clone();
    let mut once: HashMap<Vec<u64>, (&Element, u16)> = HashMap::new();
    for element in &surfaces {
        let region = regions.index(element)?;
        let mut key = element.nodes.clone();
        key.sort_unstable();
        match once.entry(key) {
            Entry::Vacant(free) => drop(free.insert((element, region))),
            // A field that was appended to the file may have brought its mesh once more.
            Entry::Occupied(before) if before.get().1 == region => continue,
            Entry::Occupied(before) => return Err(regions.twice(before.get().0, element)?),
        }
        mesh.cell_nodes.extend(kind.order.iter().map(|&i| number[&element.nodes[i]]));
        mesh.cell_region.push(region);
    }
    mesh.turn_clockwise_cells();
    let boundaries = Groups::new(&raw, 1, source);
    facets(&curves, &number, &boundaries, &mut mesh)?;
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
    source: &Source,
) -> Result<HashMap<u64, u32>, MeshError> {
    let refuse = |at: At, reason: String| Err(error(source.path, at, reason));
    let mut at: HashMap<u64, &Node> = HashMap::new();
    for node in &raw.nodes {
        if let Some(before) = at.insert(node.tag, node)
            && before.x != node.x
        {
            return refuse(
                node.at,
                format!("node {} is in {} already, at another place", node.tag, before.at),
            );
        }
    }
    let mut used: HashSet<u64> = HashSet::new();
    for element in surfaces {
        if let Some(tag) = element.nodes.iter().find(|tag| !at.contains_key(tag)) {
            return refuse(element.at, format!("node {tag} is not in section `$Nodes`"));
        }
        used.extend(&element.nodes);
    }
    let mut number = HashMap::new();
    for node in raw.nodes.iter().filter(|node| used.contains(&node.tag)) {
        if let Entry::Vacant(free) = number.entry(node.tag) {
            free.insert(mesh.nodes.len() as u32);
            mesh.nodes.push([node.x[0], node.x[1]]);
        }
    }
    let mut used = raw.nodes.iter().filter(|node| used.contains(&node.tag));
    let level = used.next().map_or(0.0, |node| node.x[2]);
    let rounding = FLAT * mesh.diameter();
    if let Some(&Node { at, tag, x: [_, _, z] }) = used.find(|node| (node.x[2] - level).abs() > rounding) {
        let reason =
            format!("node {tag} at z = {z}, others at z = {level}; a plane mesh in x and y is needed");
        return refuse(at, reason);
    }
    Ok(number)
}

/// A mesh is plane if its nodes are on one level, but for this part of its diameter.
const FLAT: f64 = 1e-10;

/// Adds the named facets.
fn facets(
    curves: &[&Element],
    number: &HashMap<u64, u32>,
    groups: &Groups,
    mesh: &mut Mesh<2>,
) -> Result<(), MeshError> {
    let mut sides: HashMap<FacetKey, Vec<Side>> = HashMap::new();
    for (key, side) in mesh.sides_by_vertices() {
        sides.entry(key).or_default().push(side);
    }
    let mut named: BTreeMap<Side, (u16, &Element)> = BTreeMap::new();
    for &element in curves {
        let refuse = |reason: String| Err(error(groups.source.path, element.at, reason));
        if groups.raw.group(element, groups.source)? == 0 {
            continue;
        }
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
        if let Some((other, before)) = named.insert(side, (boundary, element))
            && other != boundary
        {
            return Err(groups.twice(before, element)?);
        }
    }
    mesh.facets = named.into_iter().map(|(side, (boundary, _))| side.named(boundary)).collect();
    Ok(())
}

/// The physical groups of one dimension.
struct Groups<'a> {
    raw: &'a Raw,
    source: &'a Source<'a>,
    dim: usize,
    /// Their names in the order of the file, each once.
    names: Vec<String>,
    /// Index into `names` by tag.
    by_tag: HashMap<i64, u16>,
}

impl<'a> Groups<'a> {
    fn new(raw: &'a Raw, dim: usize, source: &'a Source) -> Self {
        let mut groups = Groups { raw, source, dim, names: vec![], by_tag: HashMap::new() };
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
        let group = self.raw.group(element, self.source)?;
        let reason = match self.by_tag.get(&group) {
            Some(&index) => return Ok(index),
            None if group == 0 && self.raw.has_lost_groups() => {
                let reason = "the elements are in no physical group: in version 2.2, `Mesh.SaveAll = 1;` leaves all \
                              groups out: write the file with `Mesh.SaveAll = 0;`, or with `Mesh.MshFileVersion = 4.1;`";
                return Err(error(self.source.path, element.at, reason.into()));
            }
            None if group == 0 => format!("a {what} in no physical group"),
            None => format!("a {what} in physical group {group}, which has no name"),
        };
        let advice = format!(
            "give its {} a named one, such as `Physical {kind}(\"{example}\") = {{…}};`",
            kind.to_lowercase()
        );
        Err(error(self.source.path, element.at, format!("{reason}: {advice}")))
    }

    /// What is wrong with an element that is in the file twice, as version 2.2 has those of several groups.
    fn twice(&self, before: &Element, element: &Element) -> Result<MeshError, MeshError> {
        let what = if self.dim == 1 { "line" } else { "cell" };
        let name = |e: &Element| self.raw.group(e, self.source).map(|group| self.raw.name(self.dim, group));
        let reason = format!(
            "a {what} in physical groups {} and {} (it is in {} already); it can be in one only",
            name(before)?,
            name(element)?,
            before.at
        );
        Ok(error(self.source.path, element.at, reason))
    }
}

impl Raw {
    /// Whether the file has groups but was written without saying which elements are in them.
    fn has_lost_groups(&self) -> bool {
        self.version == Version::V2
            && !self.names.is_empty()
            && self.elements.iter().all(|e| e.is_in_no_group())
    }
}
