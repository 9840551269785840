//! `history.csv`: one row per step, readable while the run goes on.

use super::OutputError;
use std::fs::{self, File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Columns of the history of a run that are no functionals.
pub const COLUMNS: [&str; 6] = ["step", "time", "force_time", "min_J", "newton_steps", "jacobians"];

/// A table of numbers with named columns.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct History {
    /// Names of the columns, such as `step`, `time`, `drag`.
    pub columns: Vec<String>,
    /// Rows, each as long as `columns`; SI units.
    pub rows: Vec<Vec<f64>>,
}

impl History {
    /// Reads a history; a last line without end, which a killed run may leave, does not count.
    ///
    /// # Errors
    /// [`OutputError::Io`]; [`OutputError::Format`] with the line number if a line is not as many numbers
    /// as there are columns.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(OutputError::io("read", path))?;
        let (columns, rows) = parse(path, &text)?;
        Ok(History { columns, rows: rows.into_iter().map(|(_, row)| row).collect() })
    }

    /// The values of column `name`, one per row.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let at = self.columns.iter().position(|c| c == name)?;
        Some(self.rows.iter().map(|row| row[at]).collect())
    }
}

/// Appends rows to `history.csv`; every row reaches the operating system at once.
#[derive(Debug)]
pub struct HistoryWriter {
    path: PathBuf,
    file: File,
    n_columns: usize,
}

impl HistoryWriter {
    /// A new file with a header; an old one is overwritten.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    ///
    /// # Panics
    /// If a column name is empty or contains a comma, a quote or a line break.
    pub fn create(path: impl AsRef<Path>, columns: &[String]) -> Result<Self, OutputError> {
        let path = path.as_ref();
        let plain = |name: &String| !name.is_empty() && !name.contains([',', '"', '\n', '\r']);
        assert!(columns.iter().all(plain), "column names are plain words");
        let mut file = File::create(path).map_err(OutputError::io("write", path))?;
        let header = columns.join(",") + "\n";
        file.write_all(header.as_bytes()).map_err(OutputError::io("write", path))?;
        Ok(HistoryWriter { path: path.to_path_buf(), file, n_columns: columns.len() })
    }

    /// Continues after step `step`: later rows are cut off, the earlier ones returned.
    ///
    /// # Errors
    /// [`OutputError::Format`] if the columns differ from `columns`, if there is no column `step`, or if
    /// the last row kept is not that of step `step` (an empty history is allowed at step 0).
    pub fn resume(
        path: impl AsRef<Path>,
        columns: &[String],
        step: u64,
    ) -> Result<(Self, History), OutputError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(OutputError::io("read", path))?;
        let (found, mut rows) = parse(path, &text)?;
        if found != columns {
            let message = format!("columns `{}` where the case has `{}`", found.join(","), columns.join(","));
            return Err(OutputError::format(path, message));
        }
        let Some(at) = columns.iter().position(|c| c == "step") else {
            return Err(OutputError::format(path, "no column `step`"));
        };
        rows.retain(|(_, row)| row[at] <= step as f64);
        let last = rows.last().map_or(0.0, |(_, row)| row[at]);
        if last != step as f64 {
            let message = format!("ends at step {last}, before step {step} of the checkpoint");
            return Err(OutputError::format(path, message));
        }
        let header = text.find('\n').map_or(text.len(), |at| at + 1);
        let end = rows.last().map_or(header, |(end, _)| *end) as u64;
        let mut file = OpenOptions::new().write(true).open(path).map_err(OutputError::io("write", path))?;
        file.set_len(end)
            .and_then(|()| file.seek(SeekFrom::Start(end)))
            .map_err(OutputError::io("truncate", path))?;
        let rows = rows.into_iter().map(|(_, row)| row).collect();
        let writer = HistoryWriter { path: path.to_path_buf(), file, n_columns: columns.len() };
        Ok((writer, History { columns: found, rows }))
    }

    /// Appends one row; reading it back gives the same bits.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    ///
    /// # Panics
    /// If the row is not as long as the header.
    pub fn append(&mut self, row: &[f64]) -> Result<(), OutputError> {
        assert_eq!(row.len(), self.n_columns, "a value for every column");
        let mut line = row.iter().map(|&x| number(x)).collect::<Vec<_>>().join(",");
        line.push('\n');
        self.file.write_all(line.as_bytes()).map_err(OutputError::io("write", &self.path))
    }

    /// Waits until all rows are on the disk; call it before saving a checkpoint.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn sync(&self) -> Result<(), OutputError> {
        self.file.sync_data().map_err(OutputError::io("write", &self.path))
    }
}

/// The shortest decimal number that reads back as `x`.
pub(crate) fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() || (1e-4..1e15).contains(&x.abs()) {
        format!("{x}")
    } else {
        format!("{x:e}")
    }
}

/// Columns and rows of a history, each row with the position after its line.
#[expect(clippy::type_complexity)]
fn parse(path: &Path, text: &str) -> Result<(Vec<String>, Vec<(usize, Vec<f64>)>), OutputError> {
    let mut lines = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
    let Some(header) = lines.next() else {
        return Err(OutputError::format(path, "no header line"));
    };
    let columns: Vec<String> = header.trim_end().split(',').map(str::to_string).collect();
    let mut end = header.len();
    let mut rows = Vec::new();
    for (n, line) in lines.enumerate() {
        end += line.len();
        let row: Result<Vec<f64>, _> = line.trim_end().split(',').map(|field| field.trim().parse()).collect();
        match row {
            Ok(row) if row.len() == columns.len() => rows.push((end, row)),
            _ => {
                let expected = format!("line {}: expected {} numbers", n + 2, columns.len());
                return Err(OutputError::format(path, expected));
            }
        }
    }
    Ok((columns, rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::testing::scratch;

    fn columns() -> Vec<String> {
        ["step", "time", "drag"].map(String::from).to_vec()
    }

    #[test]
    fn every_number_reads_back_with_the_same_bits() {
        let directory = scratch("history-bits");
        let path = directory.join("history.csv");
        let mut seed = 1u64;
        let mut values = vec![0.0, -0.0, 5e-324, f64::MAX, 1.0 / 3.0, 1e-4, 1e15, f64::INFINITY, 431.5];
        for _ in 0..3000 {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            values.extend(Some(f64::from_bits(seed)).filter(|x| x.is_finite()));
        }
        let mut writer = HistoryWriter::create(&path, &columns()).unwrap();
        for (n, &x) in values.iter().enumerate() {
            writer.append(&[n as f64, x, -x]).unwrap();
        }
        let history = History::read(&path).unwrap();
        assert_eq!(history.columns, columns());
        for (n, row) in history.rows.iter().enumerate() {
            assert_eq!(
                row.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
                [(n as f64).to_bits(), values[n].to_bits(), (-values[n]).to_bits()]
            );
        }
        assert_eq!(history.column("time").unwrap().len(), values.len());
        assert_eq!(history.column("lift"), None);
    }

    #[test]
    fn resuming_cuts_later_rows_and_half_written_lines() {
        let directory = scratch("history-resume");
        let path = directory.join("history.csv");
        let mut writer = HistoryWriter::create(&path, &columns()).unwrap();
        (1..=5).for_each(|n| writer.append(&[n as f64, 0.1 * n as f64, 0.5]).unwrap());
        let complete = fs::read(&path).unwrap();
        fs::write(&path, [&complete[..], b"6,0.6"].concat()).unwrap();
        assert_eq!(History::read(&path).unwrap().rows.len(), 5);
        let (mut writer, kept) = HistoryWriter::resume(&path, &columns(), 3).unwrap();
        assert_eq!(kept.rows.len(), 3);
        (4..=5).for_each(|n| writer.append(&[n as f64, 0.1 * n as f64, 0.5]).unwrap());
        writer.sync().unwrap();
        assert_eq!(fs::read(&path).unwrap(), complete);
        let (mut writer, kept) = HistoryWriter::resume(&path, &columns(), 0).unwrap();
        assert!(kept.rows.is_empty());
        writer.append(&[1.0, 0.1, f64::NAN]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "step,time,drag\n1,0.1,NaN\n");
    }

    #[test]
    fn mismatches_are_named() {
        let directory = scratch("history-errors");
        let path = directory.join("history.csv");
        fs::write(&path, "step,time,drag\n1,0.1,2\n2,oops,2\n").unwrap();
        assert!(History::read(&path).unwrap_err().to_string().contains("line 3: expected 3 numbers"));
        fs::write(&path, "step,time,drag\n1,0.1,2\n").unwrap();
        let later = HistoryWriter::resume(&path, &columns(), 7).unwrap_err().to_string();
        assert!(later.contains("ends at step 1, before step 7"), "{later}");
        assert!(HistoryWriter::resume(&path, &columns()[..2], 1).is_err());
        assert!(History::read(path.with_extension("missing")).is_err());
    }
}
