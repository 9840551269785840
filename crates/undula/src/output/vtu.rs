//! VTU files: fields on the deformed mesh as ParaView reads them.
//!
//! An `UnstructuredGrid` with appended raw data in zlib-compressed blocks, little endian, `UInt64`
//! headers. Cells of degree 1 are `VTK_QUAD`, `VTK_TRIANGLE` and `VTK_HEXAHEDRON`; curved cells of degree 2 are
//! `VTK_BIQUADRATIC_QUAD`, `VTK_QUADRATIC_TRIANGLE` and `VTK_TRIQUADRATIC_HEXAHEDRON`. VTK 9.2 to 9.7 cannot find a
//! point in such a curved cell of the plane, so that lines through it have holes: [`FieldSnapshot::linear`]. It finds
//! points in `VTK_TRIQUADRATIC_HEXAHEDRON`, but not in the `VTK_LAGRANGE_HEXAHEDRON` of any degree. [`read_vtu`] reads
//! what [`write_vtu`] writes, nothing else.

use super::history::number;
use super::vtk_order::vtk_order;
use super::{CellKind, Field, FieldSnapshot, OutputError, write_atomic};
use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use std::fs;
use std::io::{Read, Write};
use std::path::Path;

/// Bits per field value in the file; points always have 64.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub enum Precision {
    /// Double, but single from 100 000 points on.
    #[default]
    Auto,
    /// 32 bits.
    Single,
    /// 64 bits: reading gives the same numbers.
    Double,
}

/// No file has cells of a higher degree.
const HIGHEST: usize = 16;

/// Bytes per compressed block.
const BLOCK: usize = 1 << 16;

/// Cell types of VTK of degree 1, 2 and above.
const TYPES: [(CellKind, [u8; 3]); 4] = [
    (CellKind::Quadrilateral, [9, 28, 70]),
    (CellKind::Triangle, [5, 22, 69]),
    (CellKind::Hexahedron, [12, 29, 72]),
    (CellKind::Tetrahedron, [10, 24, 71]),
];

/// Number of the cell type in VTK.
fn vtk_cell_type(kind: CellKind, degree: usize) -> u8 {
    let of_kind = TYPES.iter().find(|(other, _)| *other == kind);
    of_kind.map_or(0, |(_, types)| types[degree.clamp(1, 3) - 1])
}

/// Version of the file: readers before VTK 9 refuse 2.1, which means something for one type of cells only.
fn version(kind: CellKind, degree: usize) -> &'static str {
    if vtk_cell_type(kind, degree) == 72 { "2.1" } else { "1.0" }
}

impl FieldSnapshot {
    /// The number of the type of the cells in VTK, and the points of each cell in the order of VTK.
    pub fn vtk_cells(&self) -> (u8, Vec<i64>) {
        let order = vtk_order(self.kind, self.degree);
        let cells = self.cells.chunks_exact(self.points_per_cell());
        let nodes = cells.flat_map(|cell| order.iter().map(|&i| i64::from(cell[i]))).collect();
        (vtk_cell_type(self.kind, self.degree), nodes)
    }
}

/// Writes `snapshot` at time `time` \[s\], atomically.
///
/// # Errors
/// [`OutputError::Io`].
///
/// # Panics
/// If an array does not have the length its shape asks for, or a cell names a point that is not there.
pub fn write_vtu(
    path: impl AsRef<Path>,
    snapshot: &FieldSnapshot,
    time: f64,
    precision: Precision,
) -> Result<(), OutputError> {
    let (n_points, n_cells, n) = (snapshot.points.len(), snapshot.n_cells(), snapshot.points_per_cell());
    assert!(snapshot.degree >= 1 && snapshot.cells.len() == n * n_cells, "whole cells");
    assert!(snapshot.cells.iter().all(|&p| (p as usize) < n_points), "cells of existing points");
    let single = match precision {
        Precision::Auto => n_points >= 100_000,
        Precision::Single => true,
        Precision::Double => false,
    };
    let mut data = Appended::default();
    let (cell_type, nodes) = snapshot.vtk_cells();
    let flat: Vec<u8> = snapshot.points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let points = data.array("Float64", "Points", 3, &flat);
    let connectivity: Vec<u8> = nodes.iter().flat_map(|p| p.to_le_bytes()).collect();
    let offsets: Vec<u8> = (1..=n_cells).flat_map(|c| ((n * c) as i64).to_le_bytes()).collect();
    let cells = data.array("Int64", "connectivity", 1, &connectivity)
        + &data.array("Int64", "offsets", 1, &offsets)
        + &data.array("UInt8", "types", 1, &vec![cell_type; n_cells]);
    let point_data: String = snapshot.point_data.iter().map(|f| data.field(f, n_points, single)).collect();
    let cell_data: String = snapshot.cell_data.iter().map(|f| data.field(f, n_cells, single)).collect();
    let version = version(snapshot.kind, snapshot.degree);
    let header = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"{version}\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n\
         </FieldData>\n<Piece NumberOfPoints=\"{n_points}\" NumberOfCells=\"{n_cells}\">\n<Points>\n{points}\
         </Points>\n<Cells>\n{cells}</Cells>\n<PointData>\n{point_data}</PointData>\n<CellData>\n{cell_data}\
         </CellData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
        number(time)
    );
    write_atomic(path, |file| {
        file.write_all(header.as_bytes())?;
        file.write_all(&data.bytes)?;
        file.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    })
}

/// The binary part of a file.
#[derive(Default)]
struct Appended {
    bytes: Vec<u8>,
}

impl Appended {
    /// Appends `raw` in compressed blocks and returns the element that refers to it.
    fn array(&mut self, kind: &str, name: &str, components: usize, raw: &[u8]) -> String {
        let offset = self.bytes.len();
        let blocks: Vec<Vec<u8>> = raw.chunks(BLOCK).map(deflate).collect();
        let mut header = vec![blocks.len(), BLOCK, raw.len() % BLOCK];
        header.extend(blocks.iter().map(Vec::len));
        self.bytes.extend(header.iter().flat_map(|&n| (n as u64).to_le_bytes()));
        blocks.iter().for_each(|block| self.bytes.extend(block));
        let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        // As VTK writes it: with one component stated, meshio 5.3.5 makes an array of shape (n, 1) of it.
        let components = match components {
            1 => String::new(),
            n => format!(" NumberOfComponents=\"{n}\""),
        };
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }

    /// Appends a field of `n` points or cells.
    fn field(&mut self, field: &Field, n: usize, single: bool) -> String {
        assert_eq!(field.values.len(), n * field.components, "size of the field {}", field.name);
        let padding = if field.components == 2 { 1 } else { 0 };
        let mut raw = Vec::with_capacity(8 * n * (field.components + padding));
        for tuple in field.values.chunks_exact(field.components) {
            for x in tuple.iter().chain(&[0.0][..padding]) {
                if single { raw.extend((*x as f32).to_le_bytes()) } else { raw.extend(x.to_le_bytes()) }
            }
        }
        let kind = if single { "Float32" } else { "Float64" };
        self.array(kind, &field.name, field.components + padding, &raw)
    }
}

fn deflate(block: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    let written = encoder.write_all(block).and_then(|()| encoder.finish());
    written.unwrap_or_else(|_| unreachable!("writing to memory does not fail"))
}

/// Reads a file of [`write_vtu`]: the snapshot and its time \[s\] (NaN if the file has none).
///
/// # Errors
/// [`OutputError::Io`]; [`OutputError::Format`] if the file is damaged or of another kind.
pub fn read_vtu(path: impl AsRef<Path>) -> Result<(FieldSnapshot, f64), OutputError> {
    let path = path.as_ref();
    let bytes = fs::read(path).map_err(OutputError::io("read", path))?;
    parse(&bytes).map_err(|message| OutputError::format(path, message))
}

fn parse(bytes: &[u8]) -> Result<(FieldSnapshot, f64), String> {
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let at = bytes.windows(marker.len()).position(|w| w == marker);
    let at = at.ok_or("not a VTU file with appended raw data, or truncated")?;
    let header = std::str::from_utf8(&bytes[..at]).map_err(|_| "the header is not text")?;
    for expected in ["type=\"UnstructuredGrid\"", "header_type=\"UInt64\"", "vtkZLibDataCompressor"] {
        if !header.contains(expected) {
            return Err(format!("{expected} expected: not a file of this program"));
        }
    }
    let appended = &bytes[at + marker.len()..];
    let mut snapshot = FieldSnapshot::default();
    let (mut time, mut section) = (f64::NAN, "");
    let (mut connectivity, mut types) = (Vec::new(), Vec::new());
    for tag in header.split('<') {
        let name = tag.split([' ', '>']).next().unwrap_or("");
        match name {
            "FieldData" | "Points" | "Cells" | "PointData" | "CellData" => section = name,
            "DataArray" if section == "FieldData" => {
                let text = tag.split('>').nth(1).unwrap_or("");
                time = text.trim().parse().map_err(|_| format!("time `{text}`"))?;
            }
            "DataArray" => {
                let field = array(tag, appended)?;
                match (section, field.name.as_str()) {
                    ("Points", _) => snapshot.points = field.values.as_chunks().0.to_vec(),
                    ("Cells", "connectivity") => connectivity = field.values,
                    ("Cells", "types") => types = field.values,
                    ("PointData", _) => snapshot.point_data.push(field),
                    ("CellData", _) => snapshot.cell_data.push(field),
                    _ => {}
                }
            }
            _ => {}
        }
    }
    cells(&mut snapshot, &connectivity, &types)?;
    let sized = |fields: &[Field], n| fields.iter().all(|f| f.values.len() == n * f.components);
    if !sized(&snapshot.point_data, snapshot.points.len()) || !sized(&snapshot.cell_data, types.len()) {
        return Err("an array has the wrong length".into());
    }
    Ok((snapshot, time))
}

/// Fills in degree and cells.
fn cells(snapshot: &mut FieldSnapshot, connectivity: &[f64], types: &[f64]) -> Result<(), String> {
    let n = connectivity.len().checked_div(types.len()).unwrap_or(4);
    let first = types.first().copied().unwrap_or(9.0);
    let of_type = TYPES.iter().find(|(_, types)| types.iter().any(|t| f64::from(*t) == first));
    let Some((kind, _)) = of_type else {
        return Err(format!("cells of type {first} of VTK, which are not read here; ParaView shows them"));
    };
    let points_per_cell =
        |degree: usize| FieldSnapshot { kind: *kind, degree, ..FieldSnapshot::default() }.points_per_cell();
    (snapshot.kind, snapshot.degree) =
        (*kind, (1..HIGHEST).find(|&k| points_per_cell(k) >= n).unwrap_or(HIGHEST));
    let kind = f64::from(vtk_cell_type(snapshot.kind, snapshot.degree));
    if snapshot.points_per_cell() * types.len() != connectivity.len() || types.iter().any(|t| *t != kind) {
        return Err("cells that are not all of the same kind".into());
    }
    let order = vtk_order(snapshot.kind, snapshot.degree);
    snapshot.cells = vec![0; connectivity.len()];
    for (cell, from) in snapshot.cells.chunks_exact_mut(n).zip(connectivity.chunks_exact(n)) {
        for (&i, &point) in order.iter().zip(from) {
            if !(0.0..snapshot.points.len() as f64).contains(&point) {
                return Err(format!("a cell names point {point}, which does not exist"));
            }
            cell[i] = point as u32;
        }
    }
    Ok(())
}

/// The array that the element `tag` refers to.
fn array(tag: &str, appended: &[u8]) -> Result<Field, String> {
    let attribute = |key: &str| {
        let at = tag.find(&format!(" {key}=\""))? + key.len() + 3;
        tag[at..].split('"').next()
    };
    let name = attribute("Name").ok_or("an array without name")?;
    let name = name.replace("&quot;", "\"").replace("&lt;", "<").replace("&amp;", "&");
    let integer = |key: &str| attribute(key).and_then(|v| v.parse::<usize>().ok());
    let components = integer("NumberOfComponents").unwrap_or(1);
    let Some(offset) = integer("offset") else {
        return Err(format!("array `{name}`: no offset"));
    };
    let raw = inflate(appended, offset).ok_or_else(|| format!("array `{name}` is damaged or truncated"))?;
    let values = match attribute("type") {
        Some("Float64") => raw.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        Some("Float32") => raw.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
        Some("Int64") => raw.as_chunks().0.iter().map(|b| i64::from_le_bytes(*b) as f64).collect(),
        Some("UInt8") => raw.iter().map(|&b| f64::from(b)).collect(),
        other => return Err(format!("array `{name}`: type {other:?} is not read here")),
    };
    Ok(Field { name, components, values })
}

/// The uncompressed bytes of the array at `offset`; `None` if they are damaged.
fn inflate(appended: &[u8], offset: usize) -> Option<Vec<u8>> {
    let word = |n: usize| {
        let at = offset.checked_add(8 * n)?;
        Some(u64::from_le_bytes(appended.get(at..at.checked_add(8)?)?.try_into().ok()?) as usize)
    };
    let (n_blocks, size, rest) = (word(0)?, word(1)?, word(2)?);
    if n_blocks > appended.len() || size > 1 << 30 {
        return None;
    }
    let mut at = offset + 8 * (3 + n_blocks);
    let mut raw = Vec::new();
    for block in 0..n_blocks {
        let end = at.checked_add(word(3 + block)?)?;
        let full = if block + 1 == n_blocks && rest > 0 { rest } else { size };
        let before = raw.len();
        ZlibDecoder::new(appended.get(at..end)?).take(size as u64).read_to_end(&mut raw).ok()?;
        if raw.len() - before != full {
            return None;
        }
        at = end;
    }
    Some(raw)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_other_programs_are_named() {
        let mut snapshot = FieldSnapshot { points: vec![[0.0; 3]; 10], ..FieldSnapshot::default() };
        let numbers: Vec<f64> = (0..10).map(f64::from).collect();
        let error = cells(&mut snapshot, &numbers, &[13.0]).unwrap_err();
        assert_eq!(error, "cells of type 13 of VTK, which are not read here; ParaView shows them");
        assert!(cells(&mut snapshot, &numbers, &[12.0]).unwrap_err().contains("not all of the same kind"));
        assert!(cells(&mut snapshot, &numbers[..8], &[12.0]).is_ok());
        assert_eq!((snapshot.kind, snapshot.degree), (CellKind::Hexahedron, 1));
        assert_eq!(snapshot.cells, [0, 1, 3, 2, 4, 5, 7, 6]);
    }
}
