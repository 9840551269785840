//! Who may know whom, see ARCHITECTURE.md: imports go from a higher layer to a lower one, and the files of a folder do
//! not import each other in circles.
//!
//! An import of a sibling is a path that begins with `crate::folder::file`, `super::file` or `self::`, in a `use` or in
//! the code; a subfolder counts as one of the files of its folder. A name that the parent of a file (`mod.rs`, or
//! `file.rs` beside the folder `file`) takes from one of its children counts as that child, as in `super::Name`.
//!
//! Parents are exempt: they name their children by `mod`, and what they define themselves stands for the whole folder.
//! A child may use it, though the parent uses the child. What makes a circle with others does not belong there, but in a
//! file of its own. Tests are exempt, too.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// From the bottom to the top: a module, and what it may import besides itself. `*`: everything above it here.
const LAYERS: [(&str, &str); 30] = [
    ("choice", ""),
    ("math", ""),
    ("parallel", ""),
    ("algebra", "choice parallel"),
    ("physics", "choice math"),
    ("element", "math"),
    ("tangent", "choice math physics"),
    ("mesh", "math element"),
    ("nonlinear", "algebra"),
    ("space", "choice math element mesh algebra parallel"),
    ("multigrid", "parallel algebra element mesh space"),
    ("sampling", "math physics element mesh space"),
    ("loops", "math physics element mesh space algebra"),
    ("operators", "parallel math physics tangent element mesh space algebra sampling loops"),
    ("system", "parallel math physics tangent mesh space algebra loops operators"),
    ("functional", "choice parallel math physics element mesh space sampling system"),
    ("linear", "parallel physics tangent algebra nonlinear space multigrid system"),
    // The summary of a run has the statistics of its functionals.
    ("output", "functional"),
    ("time", "choice parallel math physics tangent algebra nonlinear space system linear"),
    ("case", "choice math physics tangent algebra element mesh space functional output time"),
    // The errors of all layers, those of reading a case among them.
    ("error", "parallel algebra mesh nonlinear output time case"),
    (
        "setup",
        "choice parallel math physics tangent algebra element mesh nonlinear space multigrid sampling operators system functional linear output time case error",
    ),
    ("builder", "physics mesh case error"),
    ("simulation", "*"),
    ("results", "functional output case"),
    ("run", "*"),
    ("verification", "*"),
    ("modes", "*"),
    ("study", "*"),
    ("bench", "*"),
];

pub fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
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

/// Source texts by their path below `src`.
type Sources = BTreeMap<String, String>;

/// An import of a sibling.
struct Import {
    folder: String,
    from: String,
    to: String,
    place: String,
}

/// The module of a file: `a/b/mod.rs` and `a/b.rs` are `[a, b]`.
fn module(file: &str) -> Vec<String> {
    let path = file.trim_end_matches(".rs").trim_end_matches("/mod");
    path.split('/').map(String::from).collect()
}

/// The lines of code that are no tests: number, depth in modules within the file, text.
fn code(text: &str) -> Vec<(usize, usize, &str)> {
    let (mut found, mut test, mut skipped, mut inner) = (vec![], false, None, vec![]);
    for (number, line) in text.lines().enumerate() {
        let (body, indent) = (line.trim(), line.len() - line.trim_start().len());
        if let Some(end) = skipped {
            skipped = if indent == end && body.starts_with('}') { None } else { skipped };
        } else if body == "#[cfg(test)]" {
            test = true;
        } else if test && !body.starts_with("#[") {
            test = false;
            skipped = if body.ends_with('{') { Some(indent) } else { None };
        } else if !body.starts_with("//") {
            if inner.last() == Some(&indent) && body == "}" {
                inner.pop();
            }
            found.push((number + 1, inner.len(), line));
            let words: Vec<&str> = body.split_whitespace().collect();
            if let ["mod", _, "{"] | [_, "mod", _, "{"] = words[..] {
                inner.push(indent);
            }
        }
    }
    found
}

/// The paths of a tree such as `a::{b::C, d as e}`, and what follows it. The last part of a path with `as` is
/// `name as other`.
fn tree(text: &str) -> (Vec<Vec<String>>, &str) {
    let text = text.trim_start();
    if let Some(mut rest) = text.strip_prefix('{') {
        let mut all = vec![];
        loop {
            rest = rest.trim_start().trim_start_matches(',').trim_start();
            if rest.is_empty() || rest.starts_with('}') {
                return (all, rest.get(1..).unwrap_or(""));
            }
            let (paths, after) = tree(rest);
            assert!(after.len() < rest.len(), "no tree of paths: {rest:.60}");
            all.extend(paths);
            rest = after;
        }
    }
    let part = |c: char| c.is_alphanumeric() || c == '_' || c == '*';
    let end = text.find(|c| !part(c)).unwrap_or(text.len());
    let (name, rest) = text.split_at(end);
    match rest.strip_prefix("::") {
        Some(below) if below.starts_with(|c| part(c) || c == '{') => {
            let (paths, rest) = tree(below);
            (paths.into_iter().map(|path| [vec![name.to_string()], path].concat()).collect(), rest)
        }
        _ => match rest.strip_prefix(" as ") {
            Some(other) => {
                let end = other.find(|c| !part(c)).unwrap_or(other.len());
                (vec![vec![format!("{name} as {}", &other[..end])]], &other[end..])
            }
            None => (vec![vec![name.to_string()]], rest),
        },
    }
}

/// All paths of a source text that begin with one of `roots`, with their lines and depths; what follows `use`.
fn paths(text: &str, roots: &[&str]) -> Vec<(usize, usize, Vec<String>)> {
    let lines = code(text);
    let mut found = vec![];
    for (n, &(number, depth, line)) in lines.iter().enumerate() {
        let before = |at: usize| line[..at].ends_with(|c: char| c.is_alphanumeric() || "_:".contains(c));
        let starts = roots.iter().flat_map(|root| line.match_indices(root));
        for (at, root) in starts.filter(|&(at, _)| !before(at) && !line[..at].ends_with("(in ")) {
            let mut text = line[if root == "use " { at + root.len() } else { at }..].to_string();
            if text.matches('{').count() > text.matches('}').count() {
                lines[n + 1..].iter().for_each(|(_, _, line)| text += &format!("\n{line}"));
            }
            found.extend(tree(&text).0.into_iter().map(|path| (number, depth, path)));
        }
    }
    found
}

/// `path`, as it stands in the module `base`, from the root of the crate.
fn absolute(base: &[String], path: &[String]) -> Vec<String> {
    let mut at = base.to_vec();
    for (n, part) in path.iter().enumerate() {
        match part.as_str() {
            "crate" => at.clear(),
            "super" => drop(at.pop()),
            "self" => {}
            _ => return [at, path[n..].to_vec()].concat(),
        }
    }
    at
}

/// The imports of siblings, folder by folder.
fn siblings(sources: &Sources) -> Vec<Import> {
    let modules: BTreeMap<Vec<String>, &str> = sources.keys().map(|f| (module(f), f.as_str())).collect();
    let is_parent = |of: &[String]| modules.keys().any(|m| m.len() > of.len() && m.starts_with(of));
    // What parents take from their children, by the path that it has then.
    let mut taken: BTreeMap<Vec<String>, Vec<String>> = BTreeMap::new();
    for (parent, file) in modules.iter().filter(|(m, _)| is_parent(m)) {
        for (_, _, path) in paths(&sources[*file], &["use "]) {
            let path: Vec<String> = path.into_iter().filter(|part| part != "self").collect();
            let (Some(first), Some(last)) = (path.first(), path.last()) else { continue };
            let child = [parent.clone(), vec![first.clone()]].concat();
            if modules.contains_key(&child) {
                assert!(last != "*", "{file}: names, not `{first}::*`: a circle could hide behind it");
                let name = last.rsplit(" as ").next().unwrap().to_string();
                taken.insert([parent.clone(), vec![name]].concat(), child);
            }
        }
    }
    let mut found = vec![];
    for (own, file) in modules.iter().filter(|(_, file)| !file.ends_with("tests.rs")) {
        for (line, depth, path) in paths(&sources[*file], &["crate::", "super::", "self::"]) {
            // Modules within a file have no names here: `super` leads to the next one.
            let base = [own.clone(), vec![String::new(); depth]].concat();
            let mut path = absolute(&base, &path);
            while let Some(child) = (1..=path.len()).rev().find_map(|n| {
                let whole = !modules.contains_key(&path[..n]);
                taken.get(&path[..n]).filter(|_| whole)
            }) {
                path.clone_from(child);
            }
            let common = own.iter().zip(&path).take_while(|(a, b)| a == b).count();
            let there = common < own.len() && common < path.len();
            if there && common > 0 && modules.contains_key(&path[..=common]) {
                found.push(Import {
                    folder: own[..common].join("/"),
                    from: own[common].clone(),
                    to: path[common].clone(),
                    place: format!("{file}:{line}"),
                });
            }
        }
    }
    found
}

/// The imports that close circles, or lie between two of them.
fn circles(sources: &Sources) -> Vec<Import> {
    let mut left = siblings(sources);
    loop {
        let sides = |side: fn(&Import) -> &String| -> BTreeSet<(String, String)> {
            left.iter().map(|i| (i.folder.clone(), side(i).clone())).collect()
        };
        let (from, to) = (sides(|i| &i.from), sides(|i| &i.to));
        let n = left.len();
        left.retain(|i| to.contains(&(i.folder.clone(), i.from.clone())));
        left.retain(|i| from.contains(&(i.folder.clone(), i.to.clone())));
        if left.len() == n {
            return left;
        }
    }
}

#[test]
fn files_of_a_folder_import_each_other_in_no_circle() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = vec![];
    sources(&src, &mut files);
    let name = |file: &PathBuf| file.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
    let sources: Sources = files.iter().map(|file| (name(file), fs::read_to_string(file).unwrap())).collect();
    let all = siblings(&sources).len();
    assert!(all > 300, "{all} imports of siblings are seen");
    let show = |i: &Import| format!("{}: in {}, {} imports {}", i.place, i.folder, i.from, i.to);
    let wrong: Vec<String> = circles(&sources).iter().map(show).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_kind_of_import_closes_a_circle() {
    let parent = "mod b;\nmod c;\npub use b::{B, other as Named};\nuse self::c::C;\n";
    let count = |c: &str, more: &[(&str, &str)]| {
        let own = [("a/mod.rs", parent), ("a/b.rs", "use super::c::C;\n"), ("a/c.rs", c)];
        let sources = own.iter().chain(more).map(|(file, text)| (file.to_string(), text.to_string()));
        circles(&sources.collect()).len()
    };
    for closing in [
        "use super::b::B;",
        "use crate::a::b;",
        "use super::{\n    b::{\n        B,\n    },\n};",
        "use crate::a::{Other, b::B};",
        "use super::B;",
        "use super::Named;",
        "fn f() -> usize {\n    super::b::n()\n}",
        "mod inner {\n    use super::super::b::B;\n}",
        "pub use super::b::B as Same;",
    ] {
        assert_eq!(count(closing, &[]), 2, "{closing}");
    }
    for open in [
        "use super::Other;",
        "use crate::other::b::B;",
        "// use super::b::B;",
        "#[cfg(test)]\nmod tests {\n    use super::super::b::B;\n}",
        "pub(in crate::a) fn f() {}",
        "mod inner {\n    use super::b::B;\n}",
    ] {
        assert_eq!(count(open, &[]), 0, "{open}");
    }
    // A folder is one of the files of its folder; its own files are looked at by themselves.
    assert_eq!(count("use super::d::D;", &[("a/d.rs", ""), ("a/d/e.rs", "use crate::a::b::B;")]), 3);
    assert_eq!(count("", &[("a/d.rs", "use e::E;"), ("a/d/e.rs", "use super::D;")]), 0);
    assert_eq!(
        count("", &[("a/d.rs", ""), ("a/d/e.rs", "use super::f::F;"), ("a/d/f.rs", "use super::e::E;")]),
        2
    );
}
