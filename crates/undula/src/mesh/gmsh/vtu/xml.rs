//! The arrays of a VTU file as they stand in it.

use super::data::{Array, Coding, Format, decode};
use super::refuse;
use crate::mesh::MeshError;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::path::Path;

/// The unstructured grid of a file, or one of its pieces.
#[derive(Default)]
pub(super) struct Piece {
    pub points: Option<Array>,
    pub connectivity: Option<Array>,
    pub offsets: Option<Array>,
    pub types: Option<Array>,
    /// Data of the cells.
    pub cell_data: Vec<Array>,
}

/// An array whose values have not been read yet.
struct Head {
    name: String,
    kind: String,
    components: usize,
    format: Format,
    /// Byte of the file where it begins.
    byte: usize,
}

/// Where the reader is.
struct State<'a> {
    path: &'a Path,
    coding: Coding,
    /// Behind the underscore of the appended data.
    appended: &'a [u8],
    pieces: Vec<Piece>,
    /// The element around the arrays: `Points`, `Cells`, `CellData` and others.
    section: String,
    array: Option<(Head, String)>,
    is_grid: bool,
}

/// Reads all pieces of a file.
pub(super) fn pieces(bytes: &[u8], path: &Path) -> Result<Vec<Piece>, MeshError> {
    // What is appended need not be text.
    let (header, tail) = match find(bytes, b"<AppendedData") {
        Some(at) => bytes.split_at(at),
        None => (bytes, &[][..]),
    };
    let Ok(header) = std::str::from_utf8(header) else {
        return refuse(path, 0, "the file is no text in UTF-8 before its appended data".into());
    };
    let mut state = State {
        path,
        coding: Coding::default(),
        appended: &[],
        pieces: vec![],
        section: String::new(),
        array: None,
        is_grid: false,
    };
    if let (Some(end), begin) = (find(tail, b">"), header.len()) {
        state.coding.is_raw = find(&tail[..end], b"\"base64\"").is_none();
        let Some(mark) = find(&tail[end..], b"_") else {
            return refuse(path, begin, "the appended data do not begin with `_`".into());
        };
        state.appended = &tail[end + mark + 1..];
    }
    let mut reader = Reader::from_str(header);
    // The last element is open where the appended data were cut off.
    reader.config_mut().check_end_names = false;
    loop {
        let byte = reader.buffer_position() as usize;
        match reader.read_event() {
            Ok(Event::Eof) => break,
            Ok(Event::Start(element)) => state.begins(&element, byte)?,
            Ok(Event::Empty(element)) => {
                state.begins(&element, byte)?;
                state.ends(element.name().as_ref())?;
            }
            Ok(Event::End(element)) => state.ends(element.name().as_ref())?,
            Ok(Event::Text(text)) => {
                if let Some((_, content)) = &mut state.array {
                    content.push_str(&text.into_inner());
                }
            }
            Ok(_) => {}
            Err(e) => return refuse(path, byte, format!("the XML is broken: {e}")),
        }
    }
    if !state.is_grid {
        let advice = "expected `<VTKFile type=\"UnstructuredGrid\">`, as ParaView, PyVista and meshio write with `.vtu`";
        return refuse(path, 0, format!("no VTU file: {advice}"));
    }
    if find(if tail.is_empty() { header.as_bytes() } else { tail }, b"</VTKFile>").is_none() {
        return refuse(
            path,
            bytes.len(),
            "the file ends before `</VTKFile>`: a part of it is missing".into(),
        );
    }
    Ok(state.pieces)
}

impl State<'_> {
    fn begins(&mut self, element: &BytesStart<'_>, byte: usize) -> Result<(), MeshError> {
        let get = |name: &str| -> Option<String> {
            let attribute = element.try_get_attribute(name).ok()??;
            attribute.normalized_value(XmlVersion::Implicit1_0).ok().map(|value| value.into_owned())
        };
        match element.name().as_ref() {
            "VTKFile" => {
                self.is_grid = get("type").as_deref() == Some("UnstructuredGrid");
                self.coding.is_big = get("byte_order").as_deref() == Some("BigEndian");
                self.coding.is_wide = get("header_type").as_deref() == Some("UInt64");
                self.coding.is_compressed = match get("compressor").as_deref() {
                    None | Some("") => false,
                    Some("vtkZLibDataCompressor") => true,
                    Some(other) => {
                        let advice = "write the file with zlib or without compression";
                        return refuse(self.path, byte, format!("data compressed by `{other}`: {advice}"));
                    }
                };
            }
            "Piece" => self.pieces.push(Piece::default()),
            name @ ("Points" | "Cells" | "PointData" | "CellData" | "FieldData") => {
                self.section = name.into()
            }
            "DataArray" | "Array" => {
                let number = |name: &str| get(name).and_then(|n| n.trim().parse::<usize>().ok());
                let format = match get("format").as_deref() {
                    None | Some("ascii") => Format::Text,
                    Some("binary") => Format::Inline,
                    Some("appended") => Format::Appended(number("offset").unwrap_or(0)),
                    Some(other) => {
                        return refuse(self.path, byte, format!("an array of the format `{other}`"));
                    }
                };
                let head = Head {
                    name: get("Name").unwrap_or_default(),
                    kind: get("type").unwrap_or_default(),
                    components: number("NumberOfComponents").unwrap_or(1).max(1),
                    format,
                    byte,
                };
                self.array = Some((head, String::new()));
            }
            _ => {}
        }
        Ok(())
    }

    fn ends(&mut self, name: &str) -> Result<(), MeshError> {
        if !matches!(name, "DataArray" | "Array") {
            if name == self.section {
                self.section.clear();
            }
            return Ok(());
        }
        let (Some((head, text)), Some(piece)) = (self.array.take(), self.pieces.last_mut()) else {
            return Ok(());
        };
        if !matches!(self.section.as_str(), "Points" | "Cells" | "CellData") {
            return Ok(());
        }
        let values = decode(&self.coding, &head.kind, &head.format, &text, self.appended)
            .or_else(|reason| refuse(self.path, head.byte, format!("array `{}`: {reason}", head.name)))?;
        let array = Array { name: head.name, components: head.components, values };
        match (self.section.as_str(), array.name.as_str()) {
            ("Points", _) => piece.points = Some(array),
            ("Cells", "connectivity") => piece.connectivity = Some(array),
            ("Cells", "offsets") => piece.offsets = Some(array),
            ("Cells", "types") => piece.types = Some(array),
            ("Cells", _) => {}
            _ => piece.cell_data.push(array),
        }
        Ok(())
    }
}

/// Where `what` begins in `bytes`.
fn find(bytes: &[u8], what: &[u8]) -> Option<usize> {
    bytes.windows(what.len()).position(|window| window == what)
}
