//! The sections of a `.msh` file, of either version, as they are.

use super::lines::{Line, Lines};
use crate::mesh::MeshError;
use std::collections::HashMap;

/// What a file contains that a plane mesh is made of.
#[derive(Default)]
pub(super) struct Raw {
    /// Names of the physical groups by dimension and tag, in the order of the file.
    pub names: Vec<(usize, i64, String)>,
    /// The nodes.
    pub nodes: Vec<Node>,
    /// Lines, triangles and quadrilaterals.
    pub elements: Vec<Element>,
}

/// A node.
pub(super) struct Node {
    /// Line number in the file.
    pub line: usize,
    /// Its tag.
    pub tag: u64,
    /// Its coordinates.
    pub x: [f64; 3],
}

/// A line, a triangle or a quadrilateral.
pub(super) struct Element {
    /// Line number in the file.
    pub line: usize,
    /// Dimension: 1 or 2.
    pub dim: usize,
    /// Physical group; 0 for none.
    pub group: i64,
    /// Tags of the nodes in the order of Gmsh.
    pub nodes: Vec<u64>,
}

/// The two versions of the format.
#[derive(Copy, Clone, PartialEq)]
enum Version {
    V2,
    V4,
}

/// Physical groups of the entities of a version 4 file, by dimension and tag.
type Groups = HashMap<(usize, i64), Vec<i64>>;

/// Reads all sections; unknown ones are skipped.
pub(super) fn parse(lines: &mut Lines) -> Result<Raw, MeshError> {
    let version = format(lines)?;
    let mut raw = Raw::default();
    let mut groups = Groups::new();
    let (mut has_nodes, mut has_elements) = (false, false);
    while let Some(line) = lines.next() {
        let Some(section) = line.text.strip_prefix('$') else {
            return Err(line
                .error(format!("expected the start of a section such as `$Nodes`, found `{}`", line.text)));
        };
        match (section, version) {
            ("PhysicalNames", _) => physical_names(lines, &mut raw)?,
            ("Entities", Version::V4) => entities(lines, &mut groups)?,
            ("Nodes", Version::V2) => nodes_2(lines, &mut raw)?,
            ("Nodes", Version::V4) => nodes_4(lines, &mut raw)?,
            ("Elements", Version::V2) => elements_2(lines, &mut raw)?,
            ("Elements", Version::V4) => elements_4(lines, &mut raw, &groups)?,
            _ => {
                lines.skip(section)?;
                continue;
            }
        }
        has_nodes |= section == "Nodes";
        has_elements |= section == "Elements";
        lines.end(section)?;
    }
    match (has_nodes, has_elements) {
        (true, true) => Ok(raw),
        (false, _) => Err(lines.error("the file has no section `$Nodes`".into())),
        (_, false) => Err(lines.error("the file has no section `$Elements`".into())),
    }
}

/// Reads the header, which must be that of an ASCII file of a known version.
fn format(lines: &mut Lines) -> Result<Version, MeshError> {
    let first = lines.expect("`$MeshFormat`")?;
    if first.text != "$MeshFormat" {
        return Err(first.error("not a Gmsh mesh: the first line must be `$MeshFormat`".into()));
    }
    let mut line = lines.expect("the version")?;
    let (version, binary): (f64, i64) = (line.number("the version")?, line.number("the file type")?);
    let again = "write it again with `gmsh -save -bin 0 -format msh41` or `Mesh.Binary = 0; Mesh.MshFileVersion = 4.1;`";
    if binary != 0 {
        return Err(line.error(format!("the file is binary, ASCII is needed: {again}")));
    }
    let version = match version {
        2.2 => Version::V2,
        4.1 => Version::V4,
        _ => {
            return Err(line.error(format!("version {version} of the format, 2.2 or 4.1 is needed: {again}")));
        }
    };
    lines.end("MeshFormat")?;
    Ok(version)
}

fn physical_names(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let n: usize = lines.expect("the number of physical names")?.number("the number of physical names")?;
    for _ in 0..n {
        let mut line = lines.expect("a physical name")?;
        let (dim, tag) = (line.number("the dimension")?, line.number("the tag")?);
        let quoted = line.text.find('"').zip(line.text.rfind('"')).filter(|(a, b)| a < b);
        let Some((a, b)) = quoted else {
            return Err(line.error(format!("expected a name in double quotes, found `{}`", line.text)));
        };
        raw.names.push((dim, tag, line.text[a + 1..b].to_string()));
    }
    Ok(())
}

/// Reads the physical groups of all entities; their shape is of no interest.
fn entities(lines: &mut Lines, groups: &mut Groups) -> Result<(), MeshError> {
    let counts: Vec<usize> = lines.expect("numbers of entities")?.numbers(4, "a number of entities")?;
    for (dim, &n) in counts.iter().enumerate() {
        for _ in 0..n {
            let mut line = lines.expect("an entity")?;
            let tag = line.number("the tag of an entity")?;
            line.numbers::<f64>(if dim == 0 { 3 } else { 6 }, "a coordinate")?;
            let n_groups = line.number("the number of physical groups")?;
            let tags: Vec<i64> = line.numbers(n_groups, "the tag of a physical group")?;
            // Gmsh marks reversed orientation by a sign.
            groups.insert((dim, tag), tags.into_iter().map(i64::abs).collect());
        }
    }
    Ok(())
}

fn node(line: &mut Line, tag: u64, raw: &mut Raw) -> Result<(), MeshError> {
    let x = [line.coordinate("x")?, line.coordinate("y")?, line.coordinate("z")?];
    raw.nodes.push(Node { line: line.number, tag, x });
    Ok(())
}

fn nodes_2(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let n: usize = lines.expect("the number of nodes")?.number("the number of nodes")?;
    for _ in 0..n {
        let mut line = lines.expect("a node")?;
        let tag = line.number("the tag of a node")?;
        node(&mut line, tag, raw)?;
    }
    Ok(())
}

fn nodes_4(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let blocks: usize = lines.expect("the number of blocks")?.number("the number of blocks of nodes")?;
    for _ in 0..blocks {
        let mut head = lines.expect("a block of nodes")?;
        head.numbers::<i64>(3, "dimension, tag and parametric")?;
        let n: usize = head.number("the number of nodes in the block")?;
        let mut tags = vec![];
        for _ in 0..n {
            tags.push(lines.expect("the tag of a node")?.number("the tag of a node")?);
        }
        for tag in tags {
            node(&mut lines.expect("a node")?, tag, raw)?;
        }
    }
    Ok(())
}

fn elements_2(lines: &mut Lines, raw: &mut Raw) -> Result<(), MeshError> {
    let n: usize = lines.expect("the number of elements")?.number("the number of elements")?;
    for _ in 0..n {
        let mut line = lines.expect("an element")?;
        let _tag: u64 = line.number("the tag of an element")?;
        let kind = line.number("the type of an element")?;
        let n_tags = line.number("the number of tags")?;
        let tags: Vec<i64> = line.numbers(n_tags, "a tag")?;
        let group = tags.first().copied().unwrap_or(0).abs();
        element(&mut line, kind, group, raw)?;
    }
    Ok(())
}

fn elements_4(lines: &mut Lines, raw: &mut Raw, groups: &Groups) -> Result<(), MeshError> {
    let blocks: usize = lines.expect("the number of blocks")?.number("the number of blocks of elements")?;
    for _ in 0..blocks {
        let mut head = lines.expect("a block of elements")?;
        let (dim, tag): (usize, i64) = (head.number("the dimension")?, head.number("the tag of an entity")?);
        let (kind, n): (u32, usize) = (head.number("the type")?, head.number("the number of elements")?);
        let group = match groups.get(&(dim, tag)).map_or(&[][..], |g| &g[..]) {
            [] => 0,
            [group] => *group,
            several => {
                let reason = format!(
                    "entity {tag} of dimension {dim} is in physical groups {several:?}; it can be in one only"
                );
                return Err(head.error(reason));
            }
        };
        for _ in 0..n {
            let mut line = lines.expect("an element")?;
            let _tag: u64 = line.number("the tag of an element")?;
            element(&mut line, kind, group, raw)?;
        }
    }
    Ok(())
}

/// Reads the nodes of an element of type `kind`; points are left out.
fn element(line: &mut Line, kind: u32, group: i64, raw: &mut Raw) -> Result<(), MeshError> {
    let (dim, n) = match kind {
        1 => (1, 2),
        8 => (1, 3),
        2 => (2, 3),
        9 => (2, 6),
        3 => (2, 4),
        10 => (2, 9),
        15 => return Ok(()),
        _ => return Err(line.error(refusal(kind))),
    };
    let nodes = line.numbers(n, "the tag of a node")?;
    raw.elements.push(Element { line: line.number, dim, group, nodes });
    Ok(())
}

/// Why elements of type `kind` cannot be used, and what to do.
fn refusal(kind: u32) -> String {
    match kind {
        16 => "quadrilaterals with 8 nodes are not supported: write 9 nodes with \
             `Mesh.SecondOrderIncomplete = 0;`"
            .into(),
        20..=28 | 36..=39 => {
            "elements of order above 2 are not supported: write order 2 with `Mesh.ElementOrder = 2;`".into()
        }
        4..=7 | 11..=14 | 17..=19 | 29..=35 => "elements of three dimensions are not supported".into(),
        _ => {
            format!(
                "elements of type {kind} are not supported; lines (1, 8), triangles (2, 9) and quadrilaterals (3, 10) are"
            )
        }
    }
}
