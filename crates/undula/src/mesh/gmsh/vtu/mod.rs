//! Meshes from VTU files, as ParaView, PyVista and meshio write them: text, base64 or appended, compressed by zlib or not.
//!
//! Cells are of the types 10 and 24 (tetrahedra with 4 and 10 nodes), 12 and 29 (hexahedra with 8 and 27), in the plane 5
//! and 22 (triangles with 3 and 6) and 9 and 28 (quadrilaterals with 4 and 9). Boundaries are cells of one dimension less.
//! [`groups::names`] says how both get names. Data of points and fields of the file are skipped.

mod data;
mod groups;
mod xml;

use super::raw::{Node, Raw};
use super::source::{At, error};
use crate::mesh::MeshError;
use std::collections::HashMap;
use std::path::Path;
use xml::Piece;

/// Cell types of VTK: the type of Gmsh, the dimension, and the places in VTK of the nodes in the order of Gmsh.
const TYPES: [(i64, usize, &[usize]); 11] = [
    (1, 0, &[0]),
    (3, 1, &[0, 1]),
    (21, 1, &[0, 1, 2]),
    (5, 2, &[0, 1, 2]),
    (22, 2, &[0, 1, 2, 3, 4, 5]),
    (9, 2, &[0, 1, 2, 3]),
    (28, 2, &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
    (10, 3, &[0, 1, 2, 3]),
    (24, 3, &[0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    (12, 3, &[0, 1, 2, 3, 4, 5, 6, 7]),
    (29, 3, &HEXAHEDRON_27),
];

/// Gmsh has the edges of a hexahedron by their lower vertices, VTK those of the bottom, of the top and upright ones; faces
/// are z-, y-, x-, x+, y+, z+ and x-, x+, y-, y+, z-, z+.
const HEXAHEDRON_27: [usize; 27] =
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14, 24, 22, 20, 21, 23, 25, 26];

/// Whether these are the first bytes of a VTU file rather than of one of Gmsh.
pub(super) fn is_vtu(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    bytes.starts_with(b"<?xml") || bytes.starts_with(b"<VTKFile")
}

/// What is wrong at a byte of a file.
fn refuse<T>(path: &Path, byte: usize, reason: String) -> Result<T, MeshError> {
    Err(MeshError::Binary { path: path.to_path_buf(), byte, reason })
}

/// Reads nodes and elements, with a group for each name.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Raw, MeshError> {
    let mut raw = Raw::of_cells();
    for piece in xml::pieces(bytes, path)? {
        add(piece, path, &mut raw)?;
    }
    if raw.nodes.is_empty() {
        return refuse(path, 0, "the file has no points".into());
    }
    Ok(raw)
}

/// Adds the points and cells of a piece.
fn add(piece: Piece, path: &Path, raw: &mut Raw) -> Result<(), MeshError> {
    let missing = |what: &str| refuse(path, 0, format!("a piece of the grid has no {what}"));
    let Some(points) = piece.points.as_ref().filter(|a| a.components == 3).and_then(data::Array::reals)
    else {
        return missing("points with three coordinates");
    };
    let whole = |array: &Option<data::Array>| array.as_ref().and_then(data::Array::whole);
    let (Some(nodes), Some(offsets), Some(types)) =
        (whole(&piece.connectivity), whole(&piece.offsets), whole(&piece.types))
    else {
        return missing("cells (`connectivity`, `offsets` and `types`)");
    };
    if offsets.len() != types.len() || offsets.last().is_some_and(|&end| end != nodes.len() as i64) {
        let reason = format!(
            "`types` has {} cells, `offsets` {} up to {}, `connectivity` {} points: expected as many of each",
            types.len(),
            offsets.len(),
            offsets.last().unwrap_or(&0),
            nodes.len()
        );
        return refuse(path, 0, reason);
    }
    let (first, before) = (raw.nodes.len() as u64, raw.n_cells);
    for (i, x) in points.chunks_exact(3).enumerate() {
        let (at, tag) = (At::Point(first as usize + i), first + i as u64);
        if !x.iter().all(|x| x.is_finite()) {
            let reason = format!("it lies at ({}, {}, {}): expected finite numbers", x[0], x[1], x[2]);
            return Err(error(path, at, reason));
        }
        raw.nodes.push(Node { at, tag, x: [x[0], x[1], x[2]] });
    }
    let n_points = (points.len() / 3) as u64;
    let mut dims = Vec::with_capacity(types.len());
    let mut cells = Vec::with_capacity(types.len());
    let mut start = 0;
    for (i, (&end, &kind)) in offsets.iter().zip(&types).enumerate() {
        let wrong = |reason: String| Err(error(path, At::Cell(before + i), reason));
        let Some((_, dim, order)) = TYPES.iter().find(|(known, ..)| *known == kind) else {
            return wrong(refusal(kind));
        };
        let of_cell = usize::try_from(end).ok().and_then(|end| nodes.get(start..end));
        let Some(of_cell) = of_cell.filter(|nodes| nodes.len() == order.len()) else {
            return wrong(format!(
                "a cell of type {kind} has {} points; the array `offsets` says else",
                order.len()
            ));
        };
        let inside = |&&p: &&i64| u64::try_from(p).is_ok_and(|p| p < n_points);
        if let Some(point) = of_cell.iter().find(|p| !inside(p)) {
            return wrong(format!("it has point {point}, but there are {n_points} points"));
        }
        cells.push(order.iter().map(|&k| first + of_cell[k] as u64).collect());
        dims.push(*dim);
        start += order.len();
    }
    let names = groups::names(&piece.cell_data, &dims);
    add_cells(cells, &dims, names, path, raw)
}

/// Adds elements with their groups.
fn add_cells(
    cells: Vec<Vec<u64>>,
    dims: &[usize],
    names: Vec<groups::Names>,
    path: &Path,
    raw: &mut Raw,
) -> Result<(), MeshError> {
    let mut tags: HashMap<(usize, String), i64> =
        raw.names.iter().map(|(dim, tag, name)| ((*dim, name.clone()), *tag)).collect();
    for ((nodes, &dim), names) in cells.into_iter().zip(dims).zip(names) {
        let at = At::Cell(raw.n_cells);
        raw.n_cells += 1;
        if names.len() > 1 {
            let both: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            let reason = format!("it is in the groups {}; it can be in one only", both.join(" and "));
            return Err(error(path, at, reason + &raw.place_of(&nodes)));
        }
        let tag = names.into_iter().next().map_or(0, |name| {
            let next = tags.len() as i64 + 1;
            *tags.entry((dim, name.clone())).or_insert_with(|| {
                raw.names.push((dim, next, name));
                next
            })
        });
        raw.add(at, dim, tag, nodes);
    }
    Ok(())
}

/// Why cells of type `kind` cannot be used, and what to do.
fn refusal(kind: i64) -> String {
    let cells = match kind {
        23 => return "quadrilaterals with 8 nodes are not supported: write 9 nodes (type 28)".into(),
        25 => return "hexahedra with 20 nodes are not supported: write 27 nodes (type 29)".into(),
        34 => return "triangles with 7 nodes are not supported: write 6 nodes (type 22)".into(),
        13 | 26 | 31 | 32 | 73 => "wedges are",
        14 | 27 | 37 | 74 => "pyramids are",
        42 => "polyhedra are",
        _ => "cells of this type are",
    };
    format!(
        "type {kind}: {cells} not supported; tetrahedra (10, 24) and hexahedra (12, 29), in the plane triangles (5, 22) \
         and quadrilaterals (9, 28) are"
    )
}
