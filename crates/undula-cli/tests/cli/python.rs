//! The Python module is built with maturin alone; what its two parts call each other is compared here, too.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Words that stand behind `before` in a text, up to the first sign that no name has.
fn names<'a>(text: &'a str, before: &str) -> BTreeSet<&'a str> {
    let end = |rest: &'a str| rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    text.match_indices(before)
        .map(|(at, _)| &text[at + before.len()..])
        .map(|rest| &rest[..end(rest)])
        .collect()
}

/// What `_undula.pyi` declares is what the module exports, and the Python part asks for nothing else.
#[test]
fn the_module_exports_what_its_python_part_calls() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../undula-py");
    let read = |name: &str| fs::read_to_string(package.join(name)).unwrap();
    let stub = format!("\n{}", read("python/undula/_undula.pyi"));
    let declared: BTreeSet<&str> =
        &(&names(&stub, "\ndef ") | &names(&stub, "\nclass ")) - &BTreeSet::from(["_Numbers"]);
    let source = read("src/lib.rs");
    let exports = source.split("#[pymodule_export]").skip(1).map(|item| item.split(';').next().unwrap());
    let exported: BTreeSet<&str> = exports
        .flat_map(|item| item.rsplit("::").next().unwrap().split(['{', '}', ',']))
        .map(str::trim)
        .filter(|name| !name.is_empty())
        .collect();
    assert_eq!(exported, declared);
    let own = exported.iter().filter(|name| name.starts_with(char::is_lowercase));
    for name in own {
        assert!(source.contains(&format!("#[pyfunction]\nfn {name}")), "{name} is no function of Python");
    }
    for entry in fs::read_dir(package.join("python/undula")).unwrap() {
        let text = fs::read_to_string(entry.unwrap().path()).unwrap();
        let called =
            names(&text, " _undula.").union(&names(&text, "(_undula.")).copied().collect::<BTreeSet<_>>();
        assert!(called.is_subset(&declared), "{called:?}");
    }
}
