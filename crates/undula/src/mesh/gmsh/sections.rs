//! The sections of a `.msh` file, of either version, as they are.

use super::kinds::KINDS;
use super::raw::{Entity, Node, Raw, Version};
use super::source::{Encoding, Record, Source};
use crate::mesh::MeshError;
use std::collections::HashMap;

/// Reads all sections, in whatever order; unknown ones and what stands between sections are skipped.
pub(super) fn parse(source: &mut Source) -> Result<Raw, MeshError> {
    let version = format(source)?;
    let entities = [HashMap::new(), HashMap::new()];
    let mut raw = Raw { version, names: vec![], nodes: vec![], elements: vec![], entities, n_cells: 0 };
    let (mut has_nodes, mut has_elements) = (false, false);
    while let Some(line) = source.line() {
        let Some(Ok(section)) = line.text.strip_prefix(b"$").map(std::str::from_utf8) else { continue };
        match (section, version) {
            ("PhysicalNames", _) => physical_names(source, &mut raw)?,
            ("Entities", Version::V4) => entities_4(source, &mut raw, false)?,
            ("PartitionedEntities", Version::V4) => entities_4(source, &mut raw, true)?,
            ("Nodes", Version::V2) => nodes_2(source, &mut raw, false)?,
            ("ParametricNodes", Version::V2) => nodes_2(source, &mut raw, true)?,
            ("Nodes", Version::V4) => nodes_4(source, &mut raw)?,
            ("Elements", Version::V2) if source.is_binary() => elements_2_binary(source, &mut raw)?,
            ("Elements", Version::V2) => elements_2(source, &mut raw)?,
            ("Elements", Version::V4) => elements_4(source, &mut raw)?,
            _ => {
                source.skip(section);
                continue;
            }
        }
        has_nodes |= section.ends_with("Nodes");
        has_elements |= section == "Elements";
        source.end(section)?;
    }
    match (has_nodes, has_elements) {
        (true, true) => Ok(raw),
        (false, _) => Err(source.error("the file has no section `$Nodes`".into())),
        (_, false) => Err(source.error("the file has no section `$Elements`".into())),
    }
}

/// Reads the header, wherever it is, which must be that of a known version, and goes back to the beginning.
fn format(source: &mut Source) -> Result<Version, MeshError> {
    let again = "write it again with `gmsh OLD.msh -save -format msh41 -o NEW.msh`";
    loop {
        match source.line() {
            Some(line) if line.text == b"$MeshFormat" => break,
            Some(line) if line.text == b"$NOD" => {
                let reason = format!("version 1 of the format, 2.2 or 4.1 is needed: {again}");
                return Err(line.error(reason));
            }
            Some(_) => {}
            None => {
                source.rewind();
                let advice = "`gmsh -2 FILE -o own.msh` makes one of a geometry, or of another format";
                let reason = format!("not a Gmsh mesh: the file has no section `$MeshFormat` ({advice})");
                return Err(source.error(reason));
            }
        }
    }
    let mut line = source.expect("the version")?;
    let (version, binary): (f64, i64) = (line.number("the version")?, line.number("the file type")?);
    let version = match version {
        2.2 => Version::V2,
        4.1 => Version::V4,
        _ => {
            return Err(line.error(format!("version {version} of the format, 2.2 or 4.1 is needed: {again}")));
        }
    };
    if binary != 0 {
        let wide = line.number("the size of numbers")?;
        if version == Version::V4 && ![4, 8].contains(&wide) {
            return Err(line.error(format!("numbers of {wide} bytes, 4 or 8 are known: {again}")));
        }
        source.encoding = Encoding::Binary { swapped: false, wide };
        source.encoding = match source.record("the order of bytes")?.int("the order of bytes")? {
            1 => source.encoding,
            0x0100_0000 => Encoding::Binary { swapped: true, wide },
            _ => {
                let reason = "the binary file is damaged, perhaps by a transfer as text: its header must end with \
                              the number 1 in four bytes";
                return Err(source.error(reason.into()));
            }
        };
    }
    source.end("MeshFormat")?;
    source.rewind();
    Ok(version)
}

fn physical_names(source: &mut Source, raw: &mut Raw) -> Result<(), MeshError> {
    let n: usize = source.expect("the number of physical names")?.number("the number of physical names")?;
    for _ in 0..n {
        let mut line = source.expect("a physical name")?;
        let (dim, tag): (usize, i64) = (line.number("the dimension")?, line.number("the tag")?);
        let name = line.quoted()?;
        if !name.is_empty() {
            raw.names.push((dim, tag.abs(), name));
        }
    }
    Ok(())
}

/// Reads the physical groups of all entities, or of the parts of them; their shape is of no interest.
fn entities_4(source: &mut Source, raw: &mut Raw, parts: bool) -> Result<(), MeshError> {
    if parts {
        source.record("the number of partitions")?.size("the number of partitions")?;
        let n = source.record("the number of ghost entities")?.size("the number of ghost entities")?;
        for _ in 0..n {
            source.record("a ghost entity")?.ints(2, "tag and partition of a ghost entity")?;
        }
    }
    let counts = source.record("numbers of entities")?.sizes(4, "a number of entities")?;
    for (dim, &n) in counts.iter().enumerate() {
        for _ in 0..n {
            let mut record = source.record("an entity")?;
            let tag = record.int("the tag of an entity")?;
            let mut parent = None;
            if parts {
                let (dim, tag) =
                    (record.int("the dimension of the parent")?, record.int("the tag of the parent")?);
                parent = usize::try_from(dim).ok().map(|dim| (dim, tag));
                let n = record.size("the number of partitions")?;
                record.ints(n, "a partition")?;
            }
            (0..if dim == 0 { 3 } else { 6 }).try_for_each(|_| record.real("a coordinate").map(drop))?;
            let groups = physical_groups(&mut record)?;
            if dim > 0 && source.is_binary() {
                let mut record = source.record("the boundary of an entity")?;
                let n = record.size("the number of entities around")?;
                record.ints(n, "the tag of an entity around")?;
            }
            raw.entities[usize::from(parts)].insert((dim, tag), Entity { groups, parent });
        }
    }
    Ok(())
}

/// The physical groups of an entity, each once; Gmsh marks reversed orientation by a sign.
fn physical_groups(record: &mut Record) -> Result<Vec<i64>, MeshError> {
    let n = record.size("the number of physical groups")?;
    let mut groups = record.ints(n, "the tag of a physical group")?;
    groups.iter_mut().for_each(|tag| *tag = tag.abs());
    groups.sort_unstable();
    groups.dedup();
    Ok(groups)
}

/// Reads the coordinates of node `tag`, and of a binary file the `parameters` on its curve or surface behind them.
fn node(record: &mut Record, tag: u64, parameters: u64, raw: &mut Raw) -> Result<(), MeshError> {
    let at = record.at();
    let x = [record.coordinate("x")?, record.coordinate("y")?, record.coordinate("z")?];
    record.leave_reals(parameters, "a parameter")?;
    raw.nodes.push(Node { at, tag, x });
    Ok(())
}

fn nodes_2(source: &mut Source, raw: &mut Raw, parametric: bool) -> Result<(), MeshError> {
    let n: u64 = source.expect("the number of nodes")?.number("the number of nodes")?;
    for _ in 0..n {
        let mut record = source.record("a node")?;
        let tag = tag_2(&mut record)?;
        node(&mut record, tag, 0, raw)?;
        if parametric && source.is_binary() {
            let mut record = source.record("the entity of a node")?;
            let dim = record.int("the dimension of the entity")?;
            record.int("the tag of the entity")?;
            record.leave_reals(if dim == 1 || dim == 2 { dim as u64 } else { 0 }, "a parameter")?;
        }
    }
    Ok(())
}

/// The tag of a node of version 2.
fn tag_2(record: &mut Record) -> Result<u64, MeshError> {
    let tag = record.int("the tag of a node")?;
    u64::try_from(tag).map_err(|_| record.error(format!("expected the tag of a node, found `{tag}`")))
}

fn nodes_4(source: &mut Source, raw: &mut Raw) -> Result<(), MeshError> {
    let what = "the number of blocks of nodes";
    let blocks = source.record("the number of blocks")?.sizes(4, what)?[0];
    for _ in 0..blocks {
        let mut head = source.record("a block of nodes")?;
        let dim = u64::try_from(head.int("the dimension")?).unwrap_or(0);
        head.int("the tag of an entity")?;
        let parameters = if head.int("0 or 1 for parametric")? == 0 { 0 } else { dim };
        let n = head.size("the number of nodes in the block")?;
        let mut tags = vec![];
        for _ in 0..n {
            tags.push(source.record("the tag of a node")?.size("the tag of a node")?);
        }
        for tag in tags {
            node(&mut source.record("a node")?, tag, parameters, raw)?;
        }
    }
    Ok(())
}

fn elements_2(source: &mut Source, raw: &mut Raw) -> Result<(), MeshError> {
    let n: u64 = source.expect("the number of elements")?.number("the number of elements")?;
    for _ in 0..n {
        let mut record = source.record("an element")?;
        record.int("the tag of an element")?;
        let kind = record.int("the type of an element")?;
        let n_tags = record.size("the number of tags")?;
        element_2(&mut record, kind, n_tags, raw)?;
    }
    Ok(())
}

/// Elements of a binary file stand in blocks of one type each.
fn elements_2_binary(source: &mut Source, raw: &mut Raw) -> Result<(), MeshError> {
    let n: i64 = source.expect("the number of elements")?.number("the number of elements")?;
    let mut left = n;
    while left > 0 {
        let mut head = source.record("a block of elements")?;
        let kind = head.int("the type of elements")?;
        let (n, n_tags) = (head.int("the number of elements")?, head.int("the number of tags")?);
        let (true, Ok(n_tags)) = (n > 0 && n <= left, u64::try_from(n_tags)) else {
            return Err(
                head.error(format!("a block of {n} elements with {n_tags} tags each where {left} are left"))
            );
        };
        for _ in 0..n {
            let mut record = source.record("an element")?;
            record.int("the tag of an element")?;
            element_2(&mut record, kind, n_tags, raw)?;
        }
        left -= n;
    }
    Ok(())
}

/// Tags and nodes of an element of version 2. The first tag is the physical group, partitions come last.
fn element_2(record: &mut Record, kind: i64, n_tags: u64, raw: &mut Raw) -> Result<(), MeshError> {
    let at = record.at();
    let group = record.ints(n_tags, "a tag")?.first().map_or(0, |group| group.abs());
    let (dim, n) = shape(kind, record)?;
    let nodes = (0..n).map(|_| tag_2(record)).collect::<Result<_, _>>()?;
    raw.add(at, dim, group, nodes);
    Ok(())
}

fn elements_4(source: &mut Source, raw: &mut Raw) -> Result<(), MeshError> {
    let what = "the number of blocks of elements";
    let blocks = source.record("the number of blocks")?.sizes(4, what)?[0];
    for _ in 0..blocks {
        let mut head = source.record("a block of elements")?;
        head.int("the dimension")?;
        let (entity, kind) = (head.int("the tag of an entity")?, head.int("the type")?);
        let count = head.size("the number of elements")?;
        for _ in 0..count {
            let mut record = source.record("an element")?;
            let at = record.at();
            record.size("the tag of an element")?;
            let (dim, n) = shape(kind, &record)?;
            let nodes = record.sizes(n, "the tag of a node")?;
            raw.add(at, dim, entity, nodes);
        }
    }
    Ok(())
}

/// Dimension and number of nodes of elements of type `kind`.
fn shape(kind: i64, record: &Record) -> Result<(usize, u64), MeshError> {
    match KINDS.iter().find(|known| known.number == kind) {
        Some(known) => Ok((known.dim, known.n_nodes() as u64)),
        None => Err(record.error(refusal(kind))),
    }
}

/// Why elements of type `kind` cannot be used, and what to do.
fn refusal(kind: i64) -> String {
    let cells = match kind {
        16 => {
            return "quadrilaterals with 8 nodes are not supported: write 9 nodes with \
                    `Mesh.SecondOrderIncomplete = 0;`"
                .into();
        }
        17 => {
            return "hexahedra with 20 nodes are not supported: write 27 nodes with \
                    `Mesh.SecondOrderIncomplete = 0;`"
                .into();
        }
        20..=33 | 35..=66 | 71..=83 | 92..=105 | 137 => {
            return "elements of order above 2 are not supported: write order 2 with `Mesh.ElementOrder = 2;`".into();
        }
        6 | 13 | 18 | 87..=91 | 106..=117 => "wedges",
        7 | 14 | 19 | 118..=132 => "pyramids",
        _ => {
            return format!(
                "elements of type {kind} are not supported; lines (1, 8), triangles (2, 9), quadrilaterals (3, 10), \
                 tetrahedra (4, 11) and hexahedra (5, 12) are"
            );
        }
    };
    format!(
        "{cells} are not supported in three dimensions, tetrahedra of 4 or 10 nodes and hexahedra of 8 or 27 are: in Gmsh, \
         tetrahedra are what volumes get without `Recombine`; `Extrude {{…}} {{…; Layers{{n}}; Recombine;}}` and \
         `Transfinite Volume` with `Mesh.RecombineAll = 1;` make hexahedra, and `Mesh.SubdivisionAlgorithm = 2;` makes \
         them of others; for a plane mesh, give physical groups to surfaces and \
         curves only and mesh with `gmsh -2`"
    )
}
