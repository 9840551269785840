//! Reading of tables of values: text files with two columns.

use super::own::Functions;
use super::table::{Interpolation, Row, Table};
use crate::output::hash;
use std::path::{Path, PathBuf};

/// Values at the first and the last row of a period may differ by this part of the range of values: they are decimals.
const ROUNDING: f64 = 1e-9;

/// Where tables are read from.
#[derive(Copy, Clone, Debug)]
pub(crate) enum Files<'a> {
    /// Beside the files of this folder, where their paths are relative; a function of the program comes first.
    In(&'a Path, &'a Functions),
    /// Nowhere: a table is known by its name and the hash that may stand behind it, as in `inflow.csv#6c62…`.
    Unread,
}

impl Files<'_> {
    /// The table in the file `name`.
    ///
    /// # Errors
    /// What is wrong with the file, with its path and line.
    pub(super) fn table(&self, name: &str, how: Interpolation) -> Result<Table, String> {
        let relative = Path::new(name).is_relative();
        let folder = match self {
            Files::In(_, Functions(own)) if own.contains_key(name) => {
                return Ok(Table::of_program(name, own[name].clone()));
            }
            Files::In(folder, _) => folder,
            Files::Unread => {
                let (path, hash) = name.rsplit_once('#').unwrap_or((name, name));
                return Ok(Table::new((PathBuf::from(path), relative), hash.into(), how, vec![]));
            }
        };
        let path = folder.join(name);
        let told = |message: &str| format!("table {}: {message}", path.display());
        let bytes = std::fs::read(&path).map_err(|e| told(&e.to_string()))?;
        let text = std::str::from_utf8(&bytes).map_err(|_| told("not a text file in UTF-8"))?;
        let rows = read(text, how.periodic).map_err(|(line, message)| match line {
            0 => told(&message),
            line => format!("table {}:{line}: {message}", path.display()),
        })?;
        let absolute = std::path::absolute(&path).unwrap_or_else(|_| path.clone());
        let shown = absolute.to_string_lossy();
        if shown.contains('"') && shown.contains('\'') {
            return Err(told("expected a path with one kind of quotes at most"));
        }
        Ok(Table::new((absolute, relative), hash(&bytes), how, rows))
    }
}

/// The rows of a text, or its first mistake with its line; line 0: the whole text.
fn read(text: &str, periodic: bool) -> Result<Vec<Row>, (usize, String)> {
    let mut rows: Vec<Row> = vec![];
    let (mut begun, mut last) = (false, 0);
    for (line, content) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let content = content.trim();
        if content.is_empty() || content.starts_with('#') {
            continue;
        }
        let cells = cells(content);
        let header = !begun && cells.iter().all(|cell| cell.parse::<f64>().is_err());
        begun = true;
        if header {
            continue;
        }
        let row = row(&cells).map_err(|message| (line, message))?;
        if let Some(before) = rows.last()
            && row.argument <= before.argument
        {
            let message = format!(
                "the argument {} is not above {}, that of the row before; expected arguments that rise",
                row.argument, before.argument
            );
            return Err((line, message));
        }
        rows.push(row);
        last = line;
    }
    let [first, .., end] = rows.as_slice() else {
        let message =
            format!("expected at least two rows of two numbers, argument and value, not {}", rows.len());
        return Err((last, message));
    };
    if !(end.argument - first.argument).is_finite() {
        return Err((last, "the arguments lie too far apart".into()));
    }
    if periodic {
        let (start, seam) = (first.value, end.value);
        let largest = rows.iter().map(|row| row.value.abs()).fold(0.0, f64::max);
        if (seam - start).abs() > ROUNDING * largest {
            let message = format!(
                "the last value, {seam}, is not the first one, {start}; expected the row that ends the period"
            );
            return Err((last, message));
        }
        if let Some(end) = rows.last_mut() {
            end.value = start;
        }
    }
    Ok(rows)
}

/// The cells of a line, with a comma, a semicolon or blanks between them.
fn cells(line: &str) -> Vec<&str> {
    match [',', ';', '\t'].into_iter().find(|separator| line.contains(*separator)) {
        Some(separator) => line.split(separator).map(str::trim).collect(),
        None => line.split_whitespace().collect(),
    }
}

fn row(cells: &[&str]) -> Result<Row, String> {
    let [argument, value] = cells else {
        return Err(format!("expected two columns, argument and value, as `0.1, 2.5`, not {}", cells.len()));
    };
    let number = |cell: &str| match cell.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("expected finite numbers, not `{cell}`")),
        Err(_) => Err(format!("expected two numbers, argument and value, as `0.1, 2.5`; `{cell}` is none")),
    };
    Ok(Row { argument: number(argument)?, value: number(value)? })
}
