//! PVTU files: the fields of one moment in several VTU files, the pieces of the processes that share a mesh.

use super::vtu::{Precision, read_vtu};
use super::{Field, FieldSnapshot, OutputError, write_atomic};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::Path;

impl FieldSnapshot {
    /// The cells where `keep` holds, with their points.
    #[must_use]
    pub fn restricted(&self, keep: impl Fn(usize) -> bool) -> FieldSnapshot {
        let n = self.points_per_cell();
        let kept: Vec<usize> = (0..self.n_cells()).filter(|&cell| keep(cell)).collect();
        let mut new = vec![u32::MAX; self.points.len()];
        let of_cells = || kept.iter().flat_map(|&cell| &self.cells[cell * n..(cell + 1) * n]);
        of_cells().for_each(|&point| new[point as usize] = 0);
        let old: Vec<usize> = (0..new.len()).filter(|&point| new[point] == 0).collect();
        old.iter().zip(0..).for_each(|(&point, number)| new[point] = number);
        let of = |fields: &[Field], which: &[usize]| {
            let values = |field: &Field| -> Vec<f64> {
                let k = field.components;
                which.iter().flat_map(|&i| &field.values[i * k..(i + 1) * k]).copied().collect()
            };
            fields.iter().map(|field| Field { values: values(field), ..field.clone() }).collect()
        };
        FieldSnapshot {
            kind: self.kind,
            degree: self.degree,
            points: old.iter().map(|&point| self.points[point]).collect(),
            cells: of_cells().map(|&point| new[point as usize]).collect(),
            point_data: of(&self.point_data, &old),
            cell_data: of(&self.cell_data, &kept),
        }
    }

    /// Together with the cells of `other`, which has the same fields; points at the same place become one.
    fn joined(mut self, other: &FieldSnapshot, known: &mut HashMap<[u64; 3], u32>) -> Result<Self, String> {
        if self.points.is_empty() {
            (self.kind, self.degree) = (other.kind, other.degree);
            let empty = |field: &Field| Field { values: vec![], ..field.clone() };
            self.point_data = other.point_data.iter().map(empty).collect();
            self.cell_data = other.cell_data.iter().map(empty).collect();
        }
        let names = |fields: &[Field]| fields.iter().map(|f| f.name.clone()).collect::<Vec<_>>();
        let alike = (self.kind, self.degree) == (other.kind, other.degree)
            && names(&self.point_data) == names(&other.point_data)
            && names(&self.cell_data) == names(&other.cell_data);
        if !alike {
            return Err("pieces with other fields or cells than the first".into());
        }
        let mut numbers = vec![];
        for (n, x) in other.points.iter().enumerate() {
            let next = self.points.len() as u32;
            // Zero has two signs.
            let number = *known.entry(x.map(|x| (x + 0.0).to_bits())).or_insert(next);
            if number == next {
                self.points.push(*x);
                for (field, from) in self.point_data.iter_mut().zip(&other.point_data) {
                    let k = field.components;
                    field.values.extend(&from.values[n * k..(n + 1) * k]);
                }
            }
            numbers.push(number);
        }
        self.cells.extend(other.cells.iter().map(|&point| numbers[point as usize]));
        for (field, from) in self.cell_data.iter_mut().zip(&other.cell_data) {
            field.values.extend(&from.values);
        }
        Ok(self)
    }
}

/// Writes the file that names the `pieces`, files beside it; `snapshot` is one of them.
///
/// # Errors
/// [`OutputError::Io`].
pub fn write_pvtu(
    path: impl AsRef<Path>,
    snapshot: &FieldSnapshot,
    pieces: &[String],
    precision: Precision,
) -> Result<(), OutputError> {
    let kind = if precision == Precision::Single { "Float32" } else { "Float64" };
    let arrays = |fields: &[Field]| {
        let mut text = String::new();
        for Field { name, components, .. } in fields {
            let components = match components {
                1 => String::new(),
                2 => " NumberOfComponents=\"3\"".into(),
                n => format!(" NumberOfComponents=\"{n}\""),
            };
            let _ = writeln!(text, "<PDataArray type=\"{kind}\" Name=\"{name}\"{components}/>");
        }
        text
    };
    let (points, cells) = (arrays(&snapshot.point_data), arrays(&snapshot.cell_data));
    let list: String = pieces.iter().map(|piece| format!("<Piece Source=\"{piece}\"/>\n")).collect();
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<PUnstructuredGrid GhostLevel=\"0\">\n\
         <PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n</PPoints>\n\
         <PPointData>\n{points}</PPointData>\n<PCellData>\n{cells}</PCellData>\n{list}</PUnstructuredGrid>\n</VTKFile>\n"
    );
    write_atomic(path, |file| file.write_all(text.as_bytes()))
}

/// The pieces of a file of [`write_pvtu`], relative to its folder.
///
/// # Errors
/// [`OutputError::Io`].
pub fn pieces_of(path: &Path) -> Result<Vec<String>, OutputError> {
    let text = fs::read_to_string(path).map_err(OutputError::io("read", path))?;
    let of = |tag: &str| Some(tag.strip_prefix("Piece Source=\"")?.split('"').next()?.to_string());
    Ok(text.split('<').filter_map(of).collect())
}

/// Reads a VTU file, or a PVTU file with all its pieces as one: the snapshot and its time \[s\].
///
/// # Errors
/// [`OutputError::Io`]; [`OutputError::Format`] if a file is damaged or of another kind.
pub fn read_snapshot(path: impl AsRef<Path>) -> Result<(FieldSnapshot, f64), OutputError> {
    let path = path.as_ref();
    if path.extension().is_none_or(|extension| extension != "pvtu") {
        return read_vtu(path);
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let (mut whole, mut time, mut known) = (FieldSnapshot::default(), f64::NAN, HashMap::new());
    for piece in pieces_of(path)? {
        let (snapshot, of_piece) = read_vtu(folder.join(piece))?;
        time = of_piece;
        whole = whole.joined(&snapshot, &mut known).map_err(|message| OutputError::format(path, message))?;
    }
    Ok((whole, time))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{CellKind, write_vtu};

    /// Three squares beside each other.
    fn squares() -> FieldSnapshot {
        let points: Vec<[f64; 3]> = (0..8).map(|n| [f64::from(n % 4), f64::from(n / 4), 0.0]).collect();
        let cells = (0..3u32).flat_map(|c| [c, c + 1, c + 4, c + 5]).collect();
        let velocity = points.iter().flat_map(|x| [x[0], 10.0 * x[1]]).collect();
        FieldSnapshot {
            kind: CellKind::Quadrilateral,
            degree: 1,
            points,
            cells,
            point_data: vec![Field::new("velocity", 2, velocity)],
            cell_data: vec![Field::new("solid", 1, vec![0.0, 0.0, 1.0])],
        }
    }

    #[test]
    fn pieces_are_read_as_one() {
        let folder = std::env::temp_dir().join(format!("undula-pvtu-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let whole = squares();
        let pieces: Vec<FieldSnapshot> =
            [0, 1].map(|rank| whole.restricted(|cell| (cell == 0) == (rank == 0))).to_vec();
        assert_eq!(pieces.iter().map(|piece| piece.points.len()).collect::<Vec<_>>(), [4, 6]);
        let names: Vec<String> = (0..2).map(|n| format!("f_{n}.vtu")).collect();
        for (piece, name) in pieces.iter().zip(&names) {
            write_vtu(folder.join(name), piece, 0.5, Precision::Double).unwrap();
        }
        let path = folder.join("f.pvtu");
        write_pvtu(&path, &pieces[0], &names, Precision::Double).unwrap();
        assert_eq!(pieces_of(&path).unwrap(), names);
        let (read, time) = read_snapshot(&path).unwrap();
        assert_eq!((time, read.points.len(), read.n_cells()), (0.5, 8, 3));
        assert_eq!(read.cell_data, whole.cell_data);
        for (point, v) in read.points.iter().zip(read.point_data[0].values.chunks_exact(3)) {
            assert_eq!(v, [point[0], 10.0 * point[1], 0.0]);
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
