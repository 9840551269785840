//! `undula new`: a built-in case, or one for a mesh, as the start of an own one.

use crate::args::{NewArgs, bad_input, print, say_notes};
use anyhow::Context;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use undula::case::builtin::{BuiltinCase, builtin_case, builtin_cases};
use undula::case::error::did_you_mean;
use undula::case::name_of_file;
use undula::setup::starter::{Starter, starter};

/// Writes a case to start from; an existing file is kept unless `--force` is given.
pub fn run(args: &NewArgs) -> anyhow::Result<ExitCode> {
    let name = args.name.as_deref().unwrap_or_default();
    if let Some(mesh) = &args.mesh {
        return of_mesh(mesh, args);
    }
    let Some(shipped) = builtin_case(name) else {
        let hint = did_you_mean(name, builtin_cases().iter().map(|c| c.name));
        let mesh = if Path::new(name).extension().is_some_and(|end| end == "msh") {
            format!("; `undula new --mesh {name}` writes a case for a mesh")
        } else {
            String::new()
        };
        return bad_input(format_args!("no built-in case `{name}`{hint}{mesh} (`undula cases` lists them)"));
    };
    let path = args.file.clone().unwrap_or_else(|| PathBuf::from(format!("{}.toml", shipped.name)));
    let text = if is_out(&path) { shipped.toml.to_string() } else { named(shipped, &path) };
    write(&path, &text, args.force)
}

/// Writes a case for a mesh.
fn of_mesh(mesh: &Path, args: &NewArgs) -> anyhow::Result<ExitCode> {
    let path = args.name.as_ref().map_or_else(|| mesh.with_extension("toml"), PathBuf::from);
    if !args.force && !is_out(&path) && path.exists() {
        return exists(&path);
    }
    let named = if is_out(&path) { mesh } else { &path };
    match starter(mesh, &relative(mesh, &path), &name_of_file(named)) {
        Ok(Starter { text, notes }) => {
            say_notes(&notes);
            write(&path, &text, args.force)
        }
        Err(error) => bad_input(format_args!("{}: {error}", mesh.display())),
    }
}

/// Whether `-` stands for standard output.
fn is_out(path: &Path) -> bool {
    path == Path::new("-")
}

fn exists(path: &Path) -> anyhow::Result<ExitCode> {
    bad_input(format_args!("{} exists already; --force overwrites it", path.display()))
}

/// Writes a case and says what comes next; `-` prints it.
fn write(path: &Path, text: &str, force: bool) -> anyhow::Result<ExitCode> {
    if is_out(path) {
        return print(text);
    }
    let opened =
        if force { File::create(path) } else { File::options().write(true).create_new(true).open(path) };
    let mut file = match opened {
        Ok(file) => file,
        Err(e) if e.kind() == ErrorKind::AlreadyExists => return exists(path),
        Err(e) => return Err(e).with_context(|| format!("cannot write {}", path.display())),
    };
    file.write_all(text.as_bytes()).with_context(|| format!("cannot write {}", path.display()))?;
    let shown = path.display();
    print(&format!("Wrote {shown}. Edit it, then: undula check {shown}; undula run {shown}\n"))
}

/// The mesh as a case in the file `case` names it: relative to it where both lie in one directory.
fn relative(mesh: &Path, case: &Path) -> String {
    let folder = |path: &Path| match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.canonicalize().ok(),
        _ => Path::new(".").canonicalize().ok(),
    };
    let whole = mesh.canonicalize().unwrap_or_else(|_| mesh.to_path_buf());
    let found = match (mesh.file_name(), folder(mesh).zip(folder(case))) {
        (Some(name), Some((of_mesh, of_case))) if of_mesh == of_case => PathBuf::from(name),
        _ => whole,
    };
    found.to_string_lossy().into_owned()
}

/// The case file with the name of the file that it goes to: results then lie in a directory of that name.
fn named(shipped: &BuiltinCase, file: &Path) -> String {
    let line = |name: &str| format!("name = \"{name}\"\n");
    shipped.toml.replacen(&line(shipped.name), &line(&name_of_file(file)), 1)
}
