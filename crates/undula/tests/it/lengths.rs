//! How long files and functions are, see STYLE.md.

use crate::layering::sources;
use std::fs;
use std::path::Path;

/// Lines of a file, and of a function from `fn` to its closing brace.
const FILE: usize = 400;
const FUNCTION: usize = 60;

/// Where the comment or literal at the beginning of `text` ends; 0 if there is none.
fn skipped(text: &str, before: Option<char>) -> usize {
    let behind = |end: &str, from: usize| text[from..].find(end).map_or(text.len(), |n| from + n + end.len());
    if text.starts_with("//") {
        return text.find('\n').unwrap_or(text.len());
    }
    if text.starts_with("/*") {
        return behind("*/", 2);
    }
    let hashes = text.strip_prefix('r').map(|rest| rest.len() - rest.trim_start_matches('#').len());
    let in_name = before.is_some_and(|c| c.is_alphanumeric() && c != 'b' || c == '_');
    if let Some(n) = hashes.filter(|n| !in_name && text[1 + n..].starts_with('"')) {
        return behind(&format!("\"{}", "#".repeat(n)), n + 2);
    }
    let mut chars = text.char_indices().skip(1);
    match text.chars().next() {
        Some('"') => {
            while let Some((at, c)) = chars.next() {
                match c {
                    '\\' => drop(chars.next()),
                    '"' => return at + 1,
                    _ => {}
                }
            }
            text.len()
        }
        // A character, not a lifetime.
        Some('\'') if text.starts_with("'\\") => behind("'", 3),
        Some('\'') => chars.nth(1).filter(|(_, c)| *c == '\'').map_or(0, |(at, _)| at + 1),
        _ => 0,
    }
}

/// `text` without what stands in comments and literals, but with its lines.
fn code(text: &str) -> String {
    let (mut code, mut at, mut before) = (String::new(), 0, None);
    while let Some(c) = text[at..].chars().next() {
        let end = at + skipped(&text[at..], before);
        if end > at {
            // What stands on both sides stays apart.
            code.push(' ');
            code.extend(text[at..end].chars().filter(|c| *c == '\n'));
            (at, before) = (end, None);
        } else {
            code.push(c);
            (at, before) = (at + c.len_utf8(), Some(c));
        }
    }
    code
}

/// The functions with a body in `code`: name, first line and number of lines.
fn functions(code: &str) -> Vec<(&str, usize, usize)> {
    let line = |at: usize| code[..at].matches('\n').count() + 1;
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = vec![];
    for (at, _) in code.match_indices("fn ").filter(|&(at, _)| !code[..at].ends_with(is_part)) {
        let (mut brackets, mut braces, name) = (0, 0, code[at + 3..].split(|c| !is_part(c)).next().unwrap());
        for (n, c) in code[at..].char_indices() {
            match c {
                '(' | '[' => brackets += 1,
                ')' | ']' => brackets -= 1,
                // There is no body.
                ';' if brackets == 0 && braces == 0 => break,
                '{' => braces += 1,
                '}' => braces -= 1,
                _ => {}
            }
            if c == '}' && braces == 0 {
                found.push((name, line(at), line(at + n) - line(at) + 1));
            }
            // The end of this function, or of what a type of a function stands in.
            if c == '}' && braces <= 0 {
                break;
            }
        }
    }
    found.retain(|(name, ..)| !name.is_empty());
    found
}

#[test]
fn files_and_functions_are_short() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut files = vec![];
    for member in fs::read_dir(crates).unwrap() {
        sources(&member.unwrap().path().join("src"), &mut files);
    }
    files.retain(|file| file.extension().is_some_and(|ending| ending == "rs"));
    files.sort();
    let (mut n_functions, mut wrong) = (0, vec![]);
    for path in &files {
        let file = path.strip_prefix(crates).unwrap().to_str().unwrap().replace('\\', "/");
        let text = fs::read_to_string(path).unwrap();
        let (n, code) = (text.lines().count(), code(&text));
        if n > FILE {
            wrong.push(format!("{file}: {n} lines: expected at most {FILE}"));
        }
        for (name, line, n) in functions(&code) {
            n_functions += 1;
            if n > FUNCTION {
                wrong.push(format!("{file}:{line}: {name}: {n} lines: expected at most {FUNCTION}"));
            }
        }
    }
    assert!(files.len() > 200 && n_functions > 2000, "{} files, {n_functions} functions", files.len());
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn comments_and_literals_are_no_code() {
    let text = "fn a<'s>(x: &'s [u8; 2], call: fn (u8)) -> char {\n    // fn no() {\n    let c = '{';\n    /* } */ 'b'\n}\n\
                fn declared();\nimpl fn_like for r {\n    fn inner() {\n        let s = \"}\\\"}\"; let r = r#\"}\"\n\
                }\"#; let q = '\\''; let b = br\"{\";\n        let f: fn() = || ();\n    }\n}\n";
    assert_eq!(functions(&code(text)), [("a", 1, 5), ("inner", 8, 5)], "{}", code(text));
    assert_eq!(code(text).lines().count(), text.lines().count());
}
