//! `undula cases`: the built-in cases, one line each.

use crate::args::print;
use std::process::ExitCode;
use undula::case::Case;
use undula::case::builtin::builtin_cases;

/// Prints name and title of every built-in case.
pub fn run() -> anyhow::Result<ExitCode> {
    let width = builtin_cases().iter().map(|c| c.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for shipped in builtin_cases() {
        let case = Case::builtin(shipped.name, &[])?;
        text += &format!("{:width$}  {}\n", shipped.name, case.title);
    }
    print(&text)
}
