//! `history.csv`: one row per step, readable while the run goes on.

use super::OutputError;
use super::directory::Identity;
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
        let bytes = fs::read(path).map_err(OutputError::io("read", path))?;
        let (_, columns, rows) = parse(path, &bytes, None)?;
        Ok(History { columns, rows })
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
    /// Bytes written so far.
    length: u64,
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
        let length = header.len() as u64;
        Ok(HistoryWriter { path: path.to_path_buf(), file, n_columns: columns.len(), length })
    }

    /// Continues after step `step`: whatever follows its row is cut off, the rows up to it are returned. If that row
    /// is the only one that could not be written, `row` stands in for it.
    ///
    /// # Errors
    /// [`OutputError::Format`] if the columns differ from `columns`, if there is no column `step`, or if
    /// the last row kept is not that of step `step` (an empty history is allowed at step 0).
    pub fn resume(
        path: impl AsRef<Path>,
        columns: &[String],
        step: u64,
        row: Option<&str>,
    ) -> Result<(Self, History), OutputError> {
        let path = path.as_ref();
        let Kept { end, mut rows, own } = kept(path, columns, step, row)?;
        let mut file = OpenOptions::new().write(true).open(path).map_err(OutputError::io("write", path))?;
        file.set_len(end)
            .and_then(|()| file.seek(SeekFrom::Start(end)))
            .map_err(OutputError::io("truncate", path))?;
        let mut writer =
            HistoryWriter { path: path.to_path_buf(), file, n_columns: columns.len(), length: end };
        if let Some(own) = own {
            writer.append(&own)?;
            rows.push(own);
        }
        Ok((writer, History { columns: columns.to_vec(), rows }))
    }

    /// Whether [`HistoryWriter::resume`] can continue there; nothing is changed.
    ///
    /// # Errors
    /// As there.
    pub fn can_resume(
        path: impl AsRef<Path>,
        columns: &[String],
        step: u64,
        row: Option<&str>,
    ) -> Result<(), OutputError> {
        kept(path.as_ref(), columns, step, row).map(|_| ())
    }

    /// Appends one row; reading it back gives the same bits. One that cannot be written leaves nothing behind.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    ///
    /// # Panics
    /// If the row is not as long as the header.
    pub fn append(&mut self, row: &[f64]) -> Result<(), OutputError> {
        assert_eq!(row.len(), self.n_columns, "a value for every column");
        let line = text_of(row) + "\n";
        if let Err(error) = self.file.write_all(line.as_bytes()) {
            let _ = self.file.set_len(self.length);
            return Err(OutputError::io("write", &self.path)(error));
        }
        self.length += line.len() as u64;
        Ok(())
    }

    /// Checks that the file is still there, and as it was written.
    ///
    /// # Errors
    /// [`OutputError::Lost`].
    pub fn verify(&self) -> Result<(), OutputError> {
        let untouched = self.file.metadata().is_ok_and(|metadata| metadata.len() == self.length);
        match untouched && Identity::is_of(&self.file, &self.path) {
            true => Ok(()),
            false => Err(OutputError::Lost { path: self.path.clone(), content: "into it" }),
        }
    }

    /// Waits until all rows are on the disk; call it before saving a checkpoint.
    ///
    /// # Errors
    /// [`OutputError::Io`].
    pub fn sync(&self) -> Result<(), OutputError> {
        self.file.sync_data().map_err(OutputError::io("write", &self.path))
    }
}

/// The numbers of a row as a line without its end.
pub(crate) fn text_of(row: &[f64]) -> String {
    row.iter().map(|&x| number(x)).collect::<Vec<_>>().join(",")
}

/// The shortest decimal number that reads back as `x`.
pub(crate) fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() || (1e-4..1e15).contains(&x.abs()) {
        format!("{x}")
    } else {
        format!("{x:e}")
    }
}

/// What stays of a history that is continued.
struct Kept {
    /// Its bytes.
    end: u64,
    rows: Vec<Vec<f64>>,
    /// The row that is missing at its end, from elsewhere.
    own: Option<Vec<f64>>,
}

/// What of the history at `path` stays where it is continued after step `step`.
fn kept(path: &Path, columns: &[String], step: u64, row: Option<&str>) -> Result<Kept, OutputError> {
    let bytes = fs::read(path).map_err(OutputError::io("read", path))?;
    let (end, found, rows) = parse(path, &bytes, Some(step))?;
    if found != columns {
        let message = format!("columns `{}` where the case has `{}`", found.join(","), columns.join(","));
        return Err(OutputError::format(path, message));
    }
    let Some(at) = columns.iter().position(|c| c == "step") else {
        return Err(OutputError::format(path, "no column `step`"));
    };
    let last = rows.last().map_or(0.0, |row| row[at]);
    let own = row.and_then(|row| numbers(row, columns.len())).filter(|own| own[at] == step as f64);
    let own = own.filter(|_| last + 1.0 == step as f64);
    if last != step as f64 && own.is_none() {
        let message = format!("ends at step {last}, before step {step} of the checkpoint");
        return Err(OutputError::format(path, message));
    }
    Ok(Kept { end, rows, own })
}

/// Columns and rows of a history, and the position after the last of them. With `step` it ends at the row of that
/// step, whatever follows, or at the last sound row before.
#[expect(clippy::type_complexity)]
fn parse(
    path: &Path,
    bytes: &[u8],
    step: Option<u64>,
) -> Result<(u64, Vec<String>, Vec<Vec<f64>>), OutputError> {
    let mut lines = bytes.split_inclusive(|byte| *byte == b'\n').filter(|line| line.ends_with(b"\n"));
    let header = lines.next().and_then(|line| std::str::from_utf8(line).ok());
    let Some(header) = header else {
        return Err(OutputError::format(path, "no header line"));
    };
    let columns: Vec<String> = header.trim_end().split(',').map(str::to_string).collect();
    let at = columns.iter().position(|c| c == "step");
    let step = step.zip(at).map(|(step, at)| (step as f64, at));
    let mut end = header.len() as u64;
    let mut rows = Vec::new();
    for (n, line) in lines.enumerate() {
        if step.is_some_and(|(step, at)| rows.last().map_or(0.0, |row: &Vec<f64>| row[at]) >= step) {
            break;
        }
        match std::str::from_utf8(line).ok().and_then(|line| numbers(line, columns.len())) {
            Some(row) => rows.push(row),
            None if step.is_some() => break,
            None => {
                let expected = format!("line {}: expected {} numbers", n + 2, columns.len());
                return Err(OutputError::format(path, expected));
            }
        }
        end += line.len() as u64;
    }
    Ok((end, columns, rows))
}

/// The `n` numbers of a line; `None` if it has others.
fn numbers(line: &str, n: usize) -> Option<Vec<f64>> {
    let row: Result<Vec<f64>, _> = line.trim_end().split(',').map(|field| field.trim().parse()).collect();
    row.ok().filter(|row| row.len() == n)
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
        let (mut writer, kept) = HistoryWriter::resume(&path, &columns(), 3, None).unwrap();
        assert_eq!(kept.rows.len(), 3);
        (4..=5).for_each(|n| writer.append(&[n as f64, 0.1 * n as f64, 0.5]).unwrap());
        writer.sync().unwrap();
        assert_eq!(fs::read(&path).unwrap(), complete);
        let (mut writer, kept) = HistoryWriter::resume(&path, &columns(), 0, None).unwrap();
        assert!(kept.rows.is_empty());
        writer.append(&[1.0, 0.1, f64::NAN]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "step,time,drag\n1,0.1,NaN\n");
    }

    #[test]
    fn whatever_follows_the_last_row_needed_is_cut_off() {
        let directory = scratch("history-garbage");
        let path = directory.join("history.csv");
        let good = "step,time,drag\n1,0.1,2\n2,0.2,2\n";
        for garbage in [&b"\xff\xfe\x00\n\x80"[..], b"3,oops,2\n", b"\n\n", b"3,0.3", b"2,0.2,2\n3,0.3,2\n"] {
            fs::write(&path, [good.as_bytes(), garbage].concat()).unwrap();
            let (writer, kept) = HistoryWriter::resume(&path, &columns(), 2, None).unwrap();
            assert_eq!((kept.rows.len(), fs::read_to_string(&path).unwrap()), (2, good.to_string()));
            writer.verify().unwrap();
        }
        // Damage before it.
        fs::write(&path, "step,time,drag\n1,0.1,\n2,0.2,2\n").unwrap();
        assert!(HistoryWriter::resume(&path, &columns(), 2, None).is_err());
        assert!(HistoryWriter::resume(&path, &columns(), 0, None).is_ok());
    }

    #[test]
    fn the_row_of_a_checkpoint_stands_in_for_one_that_could_not_be_written() {
        let directory = scratch("history-row");
        let path = directory.join("history.csv");
        fs::write(&path, "step,time,drag\n1,0.1,2\n2,0.").unwrap();
        for other in [None, Some("3,0.3,2"), Some("2,0.2")] {
            assert!(HistoryWriter::resume(&path, &columns(), 2, other).is_err());
        }
        let (_, kept) = HistoryWriter::resume(&path, &columns(), 2, Some("2,0.2,NaN")).unwrap();
        assert_eq!((kept.rows.len(), kept.rows[1][1]), (2, 0.2));
        assert_eq!(fs::read_to_string(&path).unwrap(), "step,time,drag\n1,0.1,2\n2,0.2,NaN\n");
        assert!(HistoryWriter::resume(&path, &columns(), 4, Some("4,0.4,1")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_gone_or_changed_is_noticed() {
        let directory = scratch("history-gone");
        let path = directory.join("history.csv");
        let mut writer = HistoryWriter::create(&path, &columns()).unwrap();
        writer.append(&[1.0, 2.0, 3.0]).unwrap();
        writer.verify().unwrap();
        let copy = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        assert!(writer.verify().unwrap_err().to_string().contains("history.csv: was removed"));
        fs::write(&path, copy).unwrap();
        assert!(writer.verify().is_err(), "the same bytes in another file");
        let writer = HistoryWriter::create(&path, &columns()).unwrap();
        fs::write(&path, "").unwrap();
        assert!(writer.verify().is_err(), "another length");
    }

    #[test]
    fn mismatches_are_named() {
        let directory = scratch("history-errors");
        let path = directory.join("history.csv");
        fs::write(&path, "step,time,drag\n1,0.1,2\n2,oops,2\n").unwrap();
        assert!(History::read(&path).unwrap_err().to_string().contains("line 3: expected 3 numbers"));
        fs::write(&path, "step,time,drag\n1,0.1,2\n").unwrap();
        let later = HistoryWriter::resume(&path, &columns(), 7, None).unwrap_err().to_string();
        assert!(later.contains("ends at step 1, before step 7"), "{later}");
        assert!(HistoryWriter::resume(&path, &columns()[..2], 1, None).is_err());
        assert!(History::read(path.with_extension("missing")).is_err());
    }
}
