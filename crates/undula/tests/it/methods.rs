//! The tables of `docs/methods`: every setting is accepted, every file and every test is there.

use std::fs;
use std::path::{Path, PathBuf};
use undula::case::Case;

const HEADER: [&str; 5] = ["section", "method", "setting", "code", "test"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_path_buf()
}

/// A row of a table, with the place it stands in.
struct Row {
    place: String,
    cells: Vec<String>,
}

impl Row {
    /// What stands between backticks in column `column`.
    fn pieces(&self, column: usize) -> Vec<&str> {
        self.cells[column].split('`').skip(1).step_by(2).collect()
    }
}

/// All rows of the tables with the header above in the pages of `docs/methods`, and the names of the pages.
fn rows() -> (Vec<Row>, Vec<String>) {
    let (mut rows, mut pages) = (vec![], vec![]);
    for entry in fs::read_dir(root().join("docs/methods")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let mut in_table = false;
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            let cells: Vec<String> =
                line.trim().trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect();
            if !line.starts_with('|') {
                in_table = false;
            } else if cells == HEADER {
                in_table = true;
            } else if in_table && !line.starts_with("| ---") {
                let place = format!("docs/methods/{name}:{}", number + 1);
                assert_eq!(cells.len(), HEADER.len(), "{place}: a row has five cells");
                rows.push(Row { place, cells });
            }
        }
        pages.push(name);
    }
    assert!(rows.len() >= 58, "{} methods", rows.len());
    (rows, pages)
}

/// Whether the settings are accepted together by a case that moves in time or by a stationary one.
fn accepted(settings: &[&str]) -> Result<(), String> {
    let settings: Vec<String> = settings.iter().map(|s| (*s).to_string()).collect();
    Case::builtin("fsi3", &settings)
        .map(|_| ())
        .or_else(|first| Case::builtin("fsi1", &settings).map(|_| ()).map_err(|_| first.to_string()))
}

#[test]
fn every_setting_of_the_documentation_is_accepted() {
    for row in rows().0 {
        let pieces = row.pieces(2);
        assert!(!pieces.is_empty(), "{}: no setting", row.place);
        let settings: Vec<&str> = pieces.into_iter().filter(|piece| !piece.starts_with("undula ")).collect();
        if let Err(error) = accepted(&settings) {
            panic!("{}: {settings:?} is refused: {error}", row.place);
        }
    }
}

#[test]
fn every_file_and_test_of_the_documentation_is_there() {
    for row in rows().0 {
        let (files, tests) = (row.pieces(3), row.pieces(4));
        assert!(!files.is_empty() && !tests.is_empty(), "{}: no code or no test", row.place);
        for file in files {
            assert!(root().join(file).is_file(), "{}: no file {file}", row.place);
        }
        for test in tests {
            let (file, name) = test.split_once(':').unwrap_or_else(|| panic!("{}: {test}", row.place));
            let text = fs::read_to_string(root().join(file.trim())).unwrap_or_default();
            let known = text.contains(&format!("fn {}(", name.trim()));
            assert!(known, "{}: no test `{}` in `{file}`", row.place, name.trim());
        }
    }
}

#[test]
fn every_page_is_on_the_start_page() {
    let start = fs::read_to_string(root().join("docs/methods/README.md")).unwrap();
    for page in rows().1.iter().filter(|page| *page != "README.md") {
        assert!(start.contains(page.as_str()), "docs/methods/README.md does not name {page}");
    }
}
