//! The manual: its commands run, its links lead somewhere, its numbers are those of the files that they come from.

use super::Place;
use std::fs;
use std::path::{Path, PathBuf};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().join("docs")
}

/// The pages of the manual with their texts.
fn pages() -> Vec<(PathBuf, String)> {
    let folders = ["manual", "manual/examples", "manual/method"].map(|folder| docs().join(folder));
    let files =
        folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap()).map(|entry| entry.unwrap().path());
    let mut pages: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    pages.sort();
    assert!(pages.len() >= 40, "{pages:?}");
    pages.into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect()
}

/// The words behind ```` ```sh ```` and the commands of each box.
fn boxes(text: &str) -> Vec<(Vec<&str>, Vec<&str>)> {
    let mut found = vec![];
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(words) = line.strip_prefix("```sh") {
            let commands = lines.by_ref().take_while(|line| *line != "```").collect();
            found.push((words.split_whitespace().collect(), commands));
        }
    }
    found
}

/// Copies the files of a folder.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for file in fs::read_dir(from).unwrap().map(|file| file.unwrap()).filter(|file| file.path().is_file()) {
        fs::copy(file.path(), to.join(file.file_name())).unwrap();
    }
}

/// Runs the commands of the page `name` in a directory of its own, where boxes `in NAME` have a copy of that folder.
/// Settings behind a box shorten its runs; `expect N` is the exit code. Pictures are drawn on the first page only.
fn run_page(name: &str) {
    let here = Place::new(&format!("manual-{}", name.replace('/', "-")));
    let text = fs::read_to_string(docs().join(format!("manual/{name}.md"))).unwrap();
    let boxes = boxes(&text);
    assert!(!boxes.is_empty(), "{name} has no commands");
    if text.contains(" examples/") {
        copy(&docs().join("../examples"), &here.file("examples"));
    }
    for (words, commands) in boxes {
        let (mut sets, mut code, mut folder) = (vec![], 0, here.0.clone());
        for pair in words.chunks_exact(2) {
            match pair[0] {
                "--set" => sets.push(pair[1]),
                "expect" => code = pair[1].parse().unwrap(),
                "in" => {
                    folder = here.file(pair[1]);
                    if !folder.exists() {
                        copy(&docs().join("manual").join(pair[1]), &folder);
                    }
                }
                other => panic!("{name}: {other}"),
            }
        }
        for line in commands {
            let arguments = line.strip_prefix("undula ").unwrap_or_else(|| panic!("{name}: {line}"));
            let takes_sets = arguments.starts_with("run ") || arguments.starts_with("check ");
            let mut command = here.command(arguments, if takes_sets { &sets } else { &[] });
            if arguments.starts_with("run ") && name != "first-run" {
                // Pictures take most of the time of a short run.
                command.arg("--quiet");
            }
            let said = super::Said::of(command.current_dir(&folder).output().unwrap());
            assert_eq!(said.code, Some(code), "{name}: {line}\n{}{}", said.out, said.err);
        }
    }
}

#[test]
#[ignore = "long"]
fn the_first_run_goes_as_the_manual_says() {
    run_page("first-run");
}

#[test]
#[ignore = "long"]
fn a_geometry_of_its_own_goes_as_the_manual_says() {
    run_page("own-geometry");
}

#[test]
fn what_is_chosen_and_what_goes_wrong_is_as_the_manual_says() {
    let method = ["method/newton", "method/materials", "method/conditions"];
    ["choosing", "trouble", "coming-from", "extending"].into_iter().chain(method).for_each(run_page);
}

#[test]
#[ignore = "long"]
fn the_examples_go_as_their_pages_say() {
    let pages: Vec<_> =
        pages().into_iter().filter(|(path, _)| path.parent().unwrap().ends_with("examples")).collect();
    assert!(pages.len() >= 26, "{} pages", pages.len());
    for (path, _) in pages {
        run_page(&format!("examples/{}", path.file_stem().unwrap().to_str().unwrap()));
    }
}

#[test]
fn links_of_the_manual_lead_somewhere() {
    let mut pages = pages();
    for other in ["SUMMARY.md", "python.md", "log.md", "report.md"] {
        let path = docs().join(other);
        pages.push((path.clone(), fs::read_to_string(path).unwrap()));
    }
    let mut count = 0;
    for (path, text) in &pages {
        let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link);
        let includes =
            text.split("{{#include ").skip(1).filter_map(|rest| rest.split_once("}}")).map(|(file, _)| file);
        for link in links.chain(includes).filter(|link| !link.contains("://")) {
            let file = link.split('#').next().unwrap();
            assert!(path.parent().unwrap().join(file).exists(), "{}: {link}", path.display());
            count += 1;
        }
    }
    assert!(count > 150, "{count} links");
}

#[test]
fn numbers_of_the_manual_are_those_of_the_files_they_come_from() {
    let mut rows = 0;
    for (path, text) in pages() {
        let lines: Vec<&str> = text.lines().collect();
        for (n, line) in lines.iter().enumerate() {
            let Some(source) = line.strip_prefix("<!-- numbers: ").and_then(|rest| rest.strip_suffix(" -->"))
            else {
                continue;
            };
            let source = fs::read_to_string(docs().parent().unwrap().join(source)).unwrap();
            let cells = |row: &str| -> Vec<String> {
                let marks = [' ', '¹', '²', '³', '⁴', '⁵', '⁶'];
                row.trim_matches('|')
                    .split('|')
                    .map(|cell| cell.trim().trim_end_matches(marks).into())
                    .collect()
            };
            let table: Vec<Vec<String>> = source.lines().filter(|l| l.starts_with('|')).map(cells).collect();
            let above = lines[..n].iter().rev().skip(1).take_while(|row| row.starts_with('|'));
            for row in above.filter(|row| !row.starts_with("| ---")) {
                let found = table.iter().any(|known| cells(row).iter().all(|cell| known.contains(cell)));
                assert!(found, "{}:{}: {row}", path.display(), n + 1);
                rows += 1;
            }
        }
    }
    assert!(rows > 70, "{rows} rows");
}

#[test]
fn every_built_in_case_has_a_page_with_picture_command_and_numbers() {
    let index = fs::read_to_string(docs().join("manual/examples.md")).unwrap();
    let summary = fs::read_to_string(docs().join("SUMMARY.md")).unwrap();
    for case in undula::case::builtin::builtin_cases() {
        let name = case.name;
        let text = fs::read_to_string(docs().join(format!("manual/examples/{name}.md"))).unwrap();
        let title = undula::case::Case::builtin(name, &[]).unwrap().title;
        for part in
            [&format!("\nundula run {name}"), &title, &format!("pictures/{name}.png)"), "<!-- numbers: "]
        {
            assert!(text.contains(part), "{name}: {part}");
        }
        assert!(docs().join(format!("pictures/{name}.png")).exists(), "{name}");
        assert!(index.contains(&format!("[{name}](examples/{name}.md) | {title} |")), "{name}");
        assert!(summary.contains(&format!("(manual/examples/{name}.md)")), "{name}");
    }
    // Every page of the manual is in the book.
    for (path, _) in pages() {
        let path = path.strip_prefix(docs()).unwrap().display().to_string();
        assert!(summary.contains(&format!("({path})")), "{path}");
    }
}
