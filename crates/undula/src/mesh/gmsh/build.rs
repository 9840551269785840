//! From the sections of a file to a mesh.

use super::kinds::{KINDS, Kind};
use super::raw::{Element, Node, Raw, Version};
use super::source::{At, Source, error};
use crate::mesh::topology::FacetKey;
use crate::mesh::{Mesh, MeshError, Side};
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};

/// The dimension of the mesh: the highest of its elements.
pub(super) fn dimension(raw: &Raw) -> usize {
    raw.elements.iter().map(|e| e.dim).max().unwrap_or(0).max(2)
}

/// The one kind that all cells have.
pub(super) fn kind(raw: &Raw, source: &Source) -> Result<&'static Kind, MeshError> {
    let dim = dimension(raw);
    let mut cells = raw.elements.iter().filter(|e| e.dim == dim);
    let Some(first) = cells.next() else {
        let advice = "give surfaces a named one, such as `Physical Surface(\"fluid\") = {…};`, and mesh with `gmsh -2`";
        let reason = format!("the mesh has no triangles or quadrilaterals in a physical group: {advice}");
        return Err(source.error(reason));
    };
    match cells.find(|e| e.nodes.len() != first.nodes.len()) {
        None => Ok(kinds(dim).find(|k| k.n_nodes() == first.nodes.len()).unwrap_or(&KINDS[0])),
        Some(other) => Err(error(source.path, other.at, mixed(raw, dim))),
    }
}

/// What cells of this dimension can be.
fn kinds(dim: usize) -> impl Iterator<Item = &'static Kind> {
    KINDS.iter().filter(move |kind| kind.dim == dim)
}

/// What is wrong with cells of several kinds.
fn mixed(raw: &Raw, dim: usize) -> String {
    let count = |n: usize| raw.elements.iter().filter(|e| e.dim == dim && e.nodes.len() == n).count();
    let some: Vec<_> = kinds(dim).map(|kind| (kind, count(kind.n_nodes()))).filter(|(_, n)| *n > 0).collect();
    let degrees = some.iter().any(|(kind, _)| kind.degree != some[0].0.degree);
    let name = |&(kind, n): &(&Kind, usize)| {
        let nodes = if degrees { format!(" with {} nodes", kind.n_nodes()) } else { String::new() };
        format!("{n} {}{nodes}", kind.names()[usize::from(n != 1)])
    };
    let counts = some.iter().map(name).collect::<Vec<_>>().join(" and ");
    let mut advice = vec![];
    if some.iter().any(|(kind, _)| kind.shape != some[0].0.shape) {
        advice.push(match dim {
            2 => {
                "`Mesh.SubdivisionAlgorithm = 1;` makes quadrilaterals of all of them, `Mesh.RecombineAll = 0;` without \
                 `Recombine Surface` triangles"
            }
            _ => {
                "`Mesh.SubdivisionAlgorithm = 2;` makes hexahedra of all of them, `Mesh.RecombineAll = 0;` without \
                 `Recombine Surface` tetrahedra"
            }
        });
    }
    if degrees {
        advice.push("`Mesh.ElementOrder = 2;` gives all of them nodes of the second order");
    }
    format!("the mesh has {counts}; all must be alike: {}", advice.join("; "))
}

/// Builds the mesh, which must be one of dimension `D`.
pub(super) fn mesh<const D: usize>(raw: Raw, source: &Source) -> Result<Mesh<D>, MeshError> {
    let of_dim = |dim: usize| raw.elements.iter().filter(|e| e.dim == dim).collect::<Vec<_>>();
    let kind = kind(&raw, source)?;
    let Some(shape) = kind.shape.filter(|_| kind.dim == D) else {
        return Err(other_dimension(&raw, source, kind));
    };
    let (cells, sides) = (of_dim(D), of_dim(D - 1));
    let mut mesh = Mesh {
        shape,
        degree: kind.degree,
        nodes: vec![],
        cell_nodes: vec![],
        cell_region: vec![],
        regions: vec![],
        facets: vec![],
        boundaries: vec![],
        parts: vec![],
    };
    let number = nodes(&raw, &cells, &mut mesh, source)?;
    let regions = Groups::new(&raw, D, true, source);
    mesh.regions = regions.names.clone();
    let mut once: HashMap<Vec<u64>, (&Element, u16)> = HashMap::new();
    for element in &cells {
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
    let boundaries = Groups::new(&raw, D - 1, false, source);
    facets(&sides, &number, &boundaries, &mut mesh)?;
    mesh.boundaries = boundaries.names;
    // Groups without elements go.
    mesh.drop_cells(|_| true);
    Ok(mesh)
}

/// What is wrong with a mesh of space where a plane one is needed, or the other way round.
fn other_dimension(raw: &Raw, source: &Source, kind: &Kind) -> MeshError {
    let [_, cells] = kind.names();
    let reason = match kind.dim {
        2 => {
            format!(
                "a plane mesh of {cells}, where one of hexahedra or tetrahedra is needed: give volumes physical groups"
            )
        }
        _ => format!(
            "a mesh of {cells}, where a plane one is needed: give physical groups to surfaces and curves of a plane \
             geometry only, and mesh it with `gmsh -2`"
        ),
    };
    let first = raw.elements.iter().find(|e| e.dim == kind.dim);
    first.map_or_else(|| source.error(reason.clone()), |e| error(source.path, e.at, reason.clone()))
}

/// Adds the nodes of the cells in the order of the file; returns their numbers by tag.
fn nodes<const D: usize>(
    raw: &Raw,
    cells: &[&Element],
    mesh: &mut Mesh<D>,
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
    for element in cells {
        if let Some(tag) = element.nodes.iter().find(|tag| !at.contains_key(tag)) {
            return refuse(element.at, format!("node {tag} is not in section `$Nodes`"));
        }
        used.extend(&element.nodes);
    }
    let mut number = HashMap::new();
    for node in raw.nodes.iter().filter(|node| used.contains(&node.tag)) {
        if let Entry::Vacant(free) = number.entry(node.tag) {
            free.insert(mesh.nodes.len() as u32);
            mesh.nodes.push(std::array::from_fn(|d| node.x[d]));
        }
    }
    if D == 2 {
        let used: Vec<&Node> = raw.nodes.iter().filter(|node| used.contains(&node.tag)).collect();
        check_level(&used, FLAT * mesh.diameter(), source)?;
    }
    Ok(number)
}

/// Refuses nodes that are not on one level but for `rounding`.
fn check_level(nodes: &[&Node], rounding: f64, source: &Source) -> Result<(), MeshError> {
    let level = nodes.first().map_or(0.0, |node| node.x[2]);
    let Some(Node { at, tag, x: [_, _, z] }) = nodes.iter().find(|node| (node.x[2] - level).abs() > rounding)
    else {
        return Ok(());
    };
    let reason = format!("node {tag} at z = {z}, others at z = {level}; a plane mesh in x and y is needed");
    Err(error(source.path, *at, reason))
}

/// A mesh is plane if its nodes are on one level, but for this part of its diameter.
const FLAT: f64 = 1e-10;

/// Adds the named facets.
fn facets<const D: usize>(
    elements: &[&Element],
    number: &HashMap<u64, u32>,
    groups: &Groups,
    mesh: &mut Mesh<D>,
) -> Result<(), MeshError> {
    let mut sides: HashMap<FacetKey, Vec<Side>> = HashMap::new();
    for (key, side) in mesh.sides_by_vertices() {
        sides.entry(key).or_default().push(side);
    }
    let mut named: BTreeMap<Side, (u16, &Element)> = BTreeMap::new();
    let what = groups.what;
    for &element in elements {
        let refuse = |reason: String| Err(groups.refuse(element, &reason));
        if groups.raw.group(element, groups.source)? == 0 {
            continue;
        }
        let boundary = groups.index(element)?;
        let mut key = [u32::MAX; 4];
        let corners =
            kinds(D - 1).find(|kind| kind.n_nodes() == element.nodes.len()).map_or(0, Kind::n_vertices);
        for (entry, tag) in key.iter_mut().zip(&element.nodes[..corners]) {
            *entry = number.get(tag).copied().unwrap_or(u32::MAX);
        }
        key.sort_unstable();
        let region = |side: &Side| mesh.cell_region[side.cell as usize];
        let side = match sides.get(&key).map_or(&[][..], |at| &at[..]) {
            [] => {
                let side = if D == 2 { "edge" } else { "side" };
                return refuse(format!("a {what} that is no {side} of a cell"));
            }
            [one, two] if region(one) == region(two) => {
                let region = &mesh.regions[region(one) as usize];
                return refuse(format!(
                    "a {what} inside of region `{region}`; boundaries and interfaces only have names"
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
    /// What their elements are in the mesh.
    what: &'static str,
    /// Their names in the order of the file, each once.
    names: Vec<String>,
    /// Index into `names` by tag.
    by_tag: HashMap<i64, u16>,
}

impl<'a> Groups<'a> {
    fn new(raw: &'a Raw, dim: usize, cells: bool, source: &'a Source) -> Self {
        let what = match (cells, dim) {
            (true, _) => "cell",
            (_, 1) => "line",
            _ => "facet",
        };
        let mut groups = Groups { raw, source, dim, what, names: vec![], by_tag: HashMap::new() };
        for (_, tag, name) in raw.names.iter().filter(|(d, _, _)| *d == dim) {
            let index = groups.names.iter().position(|n| n == name).unwrap_or(groups.names.len());
            if index == groups.names.len() {
                groups.names.push(name.clone());
            }
            groups.by_tag.insert(*tag, index as u16);
        }
        if groups.names.is_empty() {
            groups.number();
        }
        groups
    }

    /// Where no group has a name, as in files of meshio, their numbers are their names.
    fn number(&mut self) {
        let of_dim = self.raw.elements.iter().filter(|e| e.dim == self.dim);
        let mut tags: Vec<i64> = of_dim.filter_map(|e| self.raw.group(e, self.source).ok()).collect();
        tags.sort_unstable();
        tags.dedup();
        tags.retain(|tag| *tag != 0);
        self.by_tag = tags.iter().zip(0..).map(|(&tag, index)| (tag, index)).collect();
        self.names = tags.iter().map(i64::to_string).collect();
    }

    /// A mistake at an element, with the place of its middle.
    fn refuse(&self, element: &Element, reason: &str) -> MeshError {
        error(self.source.path, element.at, format!("{reason}{}", self.raw.place_of(&element.nodes)))
    }

    /// Index of the group of `element`, which must have a name.
    fn index(&self, element: &Element) -> Result<u16, MeshError> {
        let what = self.what;
        let kind = ["Point", "Curve", "Surface", "Volume"][self.dim];
        let example = if what == "cell" { "fluid" } else { "walls" };
        let group = self.raw.group(element, self.source)?;
        let reason = match self.by_tag.get(&group) {
            Some(&index) => return Ok(index),
            None if group == 0 && self.raw.has_lost_groups() => {
                let reason = "the elements are in no physical group: in version 2.2, `Mesh.SaveAll = 1;` leaves all \
                              groups out: write the file with `Mesh.SaveAll = 0;`, or with `Mesh.MshFileVersion = 4.1;`";
                return Err(error(self.source.path, element.at, reason.into()));
            }
            None if group == 0 && self.raw.version == Version::Vtu => format!("a {what} in no group"),
            None if group == 0 => format!("a {what} in no physical group"),
            None => format!("a {what} in physical group {group}, which has no name"),
        };
        let advice = match self.raw.version {
            Version::Vtu => format!(
                "give it a number in an array of the cells called `region`, or 1 in one of 0 and 1 called `{example}`"
            ),
            _ => format!(
                "give its {} a named one, such as `Physical {kind}(\"{example}\") = {{…}};`",
                kind.to_lowercase()
            ),
        };
        Err(self.refuse(element, &format!("{reason}: {advice}")))
    }

    /// What is wrong with an element that is in the file twice, as version 2.2 has those of several groups.
    fn twice(&self, before: &Element, element: &Element) -> Result<MeshError, MeshError> {
        let what = self.what;
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
