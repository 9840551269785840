//! `history.csv`: one row per step, readable while the run goes on.

use super::OutputError;
use super::directory::Identity;
use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Columns of the history of a run that are no functionals; the last one is there where the linear solver is iterative.
pub const COLUMNS: [&str; 7] =
    ["step", "time", "force_time", "min_J", "newton_steps", "jacobians", "linear_iterations"];

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
        let opened = OpenOptions::new().read(true).write(true).create(true).truncate(true).open(path);
        let mut file = opened.map_err(OutputError::io("write", path))?;
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
        let mut file =
            OpenOptions::new().read(true).write(true).open(path).map_err(OutputError::io("write", path))?;
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

    /// Whether the file at `path` has a column of that name.
    pub fn has_column(path: impl AsRef<Path>, name: &str) -> bool {
        let mut header = String::new();
        let read =
            File::open(path).and_then(|file| BufReader::new(file.take(1 << 20)).read_line(&mut header));
        read.is_ok() && header.trim_end().split(',').any(|column| column == name)
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

    /// Calls `each` with the numbers of every row written so far, from the open file: also where its name is gone.
    ///
    /// # Errors
    /// [`OutputError::Io`], [`OutputError::Format`].
    pub fn for_each_row(&self, mut each: impl FnMut(&[f64])) -> Result<(), OutputError> {
        let failed = || OutputError::io("read", &self.path);
        let mut file = &self.file;
        file.seek(SeekFrom::Start(0)).map_err(failed())?;
        let mut lines = BufReader::new(file.take(self.length));
        let (mut line, mut n) = (String::new(), 0);
        let result = loop {
            line.clear();
            match lines.read_line(&mut line) {
                Ok(0) => break Ok(()),
                Ok(_) if n == 0 => {}
                Ok(_) => match numbers(&line, self.n_columns) {
                    Some(row) => each(&row),
                    None => break Err(OutputError::format(&self.path, format!("line {}: no row", n + 1))),
                },
                Err(error) => break Err(failed()(error)),
            }
            n += 1;
        };
        // Where the next row goes, whatever was read.
        let mut file = &self.file;
        file.seek(SeekFrom::Start(self.length)).map_err(failed())?;
        result
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
mod tests;
