//! What the command line says of itself: completions for shells and manual pages.

use crate::args::{Cli, CompletionsArgs, ManArgs, print};
use anyhow::Context;
use clap::CommandFactory;
use std::process::ExitCode;

/// Prints the completions for a shell.
///
/// # Errors
/// Standard output cannot be written.
pub fn completions(args: &CompletionsArgs) -> anyhow::Result<ExitCode> {
    let mut text = vec![];
    clap_complete::generate(args.shell, &mut Cli::command(), "undula", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Writes the manual pages and names their directory.
///
/// # Errors
/// Pages that cannot be written.
pub fn manual(args: &ManArgs) -> anyhow::Result<ExitCode> {
    let dir = args.dir.display();
    std::fs::create_dir_all(&args.dir).with_context(|| format!("cannot create {dir}"))?;
    clap_mangen::generate_to(Cli::command(), &args.dir)
        .with_context(|| format!("cannot write into {dir}"))?;
    print(&format!("{dir}\n"))
}
