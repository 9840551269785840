//! Who may know whom: imports go from a higher layer to a lower one, see ARCHITECTURE.md.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// From the bottom to the top: a module, and what it may import besides itself. `*`: everything above it here.
const LAYERS: [(&str, &str); 21] = [
    ("choice", ""),
    ("math", ""),
    ("algebra", "choice"),
    ("physics", "choice math"),
    ("element", "math"),
    ("tangent", "choice math physics"),
    ("mesh", "math element"),
    ("nonlinear", "algebra"),
    ("space", "choice math element mesh algebra"),
    ("assembly", "math physics tangent element mesh space algebra"),
    ("functional", "choice math physics element mesh space assembly"),
    // The summary of a run has the statistics of its functionals.
    ("output", "functional"),
    ("time", "choice math physics tangent algebra nonlinear space assembly"),
    // `error` gathers the errors of all layers, those of reading a case among them.
    ("problem", "* error"),
    ("error", "*"),
    ("simulation", "*"),
    ("jacobian", "*"),
    ("stability", "*"),
    ("run", "*"),
    ("modes", "*"),
    ("bench", "*"),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => sources(&path, found),
            false => found.push(path),
        }
    }
}

/// Modules that a source text names after `crate::`, with the line.
fn imports(text: &str) -> Vec<(usize, String)> {
    let mut found = vec![];
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//")) {
        for after in line.split("crate::").skip(1) {
            let end = after.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(after.len());
            // An opening brace gives an empty name, which no layer has: one `use` per module reads better.
            found.push((number + 1, after[..end].to_string()));
        }
    }
    found
}

#[test]
fn imports_go_down() {
    let mut allowed: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (n, (module, below)) in LAYERS.iter().enumerate() {
        let mut names: Vec<&str> = below.split_whitespace().filter(|name| *name != "*").collect();
        if below.contains('*') {
            names.extend(LAYERS[..n].iter().map(|(name, _)| *name));
        }
        names.push(module);
        allowed.insert(module, names);
    }
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut files, mut wrong) = (vec![], vec![]);
    sources(&src, &mut files);
    for file in &files {
        let inner = file.strip_prefix(&src).unwrap();
        let module = inner.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs");
        if module == "lib" {
            continue;
        }
        let allowed = allowed.get(module).unwrap_or_else(|| panic!("`{module}` is in no layer"));
        for (line, name) in imports(&fs::read_to_string(file).unwrap()) {
            if !allowed.contains(&name.as_str()) {
                wrong.push(format!("{}:{line}: {module} may not import `{name}`", inner.display()));
            }
        }
    }
    assert!(files.len() > 50 && wrong.is_empty(), "\n{}", wrong.join("\n"));
}
