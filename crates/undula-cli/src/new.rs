//! `undula new`: a built-in case as the start of an own one.

use crate::args::{NewArgs, bad_input, print};
use anyhow::Context;
use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use undula::case::builtin::{BuiltinCase, builtin_case, builtin_cases};
use undula::case::error::did_you_mean;
use undula::case::name_of_file;

/// Writes the TOML of the built-in case; an existing file is kept unless `--force` is given.
pub fn run(args: &NewArgs) -> anyhow::Result<ExitCode> {
    let Some(shipped) = builtin_case(&args.name) else {
        let hint = did_you_mean(&args.name, builtin_cases().iter().map(|c| c.name));
        return bad_input(format_args!("no built-in case `{}`{hint} (`undula cases` lists them)", args.name));
    };
    let path = args.file.clone().unwrap_or_else(|| PathBuf::from(format!("{}.toml", shipped.name)));
    let opened = if args.force {
        File::create(&path)
    } else {
        File::options().write(true).create_new(true).open(&path)
    };
    let mut file = match opened {
        Ok(file) => file,
        Err(e) if e.kind() == ErrorKind::AlreadyExists => {
            return bad_input(format_args!("{} exists already; --force overwrites it", path.display()));
        }
        Err(e) => return Err(e).with_context(|| format!("cannot write {}", path.display())),
    };
    file.write_all(named(shipped, &path).as_bytes())
        .with_context(|| format!("cannot write {}", path.display()))?;
    let shown = path.display();
    print(&format!("Wrote {shown}. Edit it, then: undula check {shown}; undula run {shown}\n"))
}

/// The case file with the name of the file that it goes to: results then lie in a directory of that name.
fn named(shipped: &BuiltinCase, file: &Path) -> String {
    let line = |name: &str| format!("name = \"{name}\"\n");
    shipped.toml.replacen(&line(shipped.name), &line(&name_of_file(file)), 1)
}
