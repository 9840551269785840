//! `undula modes`: eigenfrequencies of the solid in vacuum and with the mass of the fluid around it.

use crate::args::{ModesArgs, bad_input, print, say, threads};
use crate::{check, run};
use std::fmt::Write;
use std::process::ExitCode;
use undula::error::Error;
use undula::modes::{Mode, Modes, check_empty, of_case, unused_loads, write};

/// Loads the case, computes its modes and prints their frequencies.
pub fn run(args: &ModesArgs) -> anyhow::Result<ExitCode> {
    let case = match check::load(&args.case)? {
        Ok(case) => case,
        Err(code) => return Ok(code),
    };
    if let Some(directory) = &args.output
        && let Err(error) = check_empty(directory)
    {
        return bad_input(error);
    }
    let count = usize::from(args.count);
    let (space, modes) = match of_case(&case, count, threads(args.threads)) {
        Ok(found) => found,
        Err(error) => return run::failed(error),
    };
    if let Some(directory) = &args.output
        && let Err(error) = write(directory, &space, &modes, case.output.curved)
    {
        return run::failed(Error::Directory(error));
    }
    for key in unused_loads(&case) {
        say(format_args!(
            "note: {key} has no effect: modes are those of the body at rest without loads and damping"
        ));
    }
    let found = modes.with_fluid.as_ref().map_or(usize::MAX, Vec::len).min(modes.vacuum.len());
    if found < count {
        say(format_args!("note: {found} of {count} modes were found"));
    }
    let text = table(&modes).unwrap_or_default();
    let files = args.output.as_ref().map_or(String::new(), |directory| {
        let [csv, shapes] = ["modes.csv", "modes.vtu"].map(|name| directory.join(name).display().to_string());
        format!("results   {csv}\nshapes    {shapes}\n")
    });
    print(&format!("{}: {}\n\n{text}{files}", case.name, case.title))
}

/// The frequencies side by side.
///
/// # Errors
/// None in practice; writing to a string does not fail.
fn table(modes: &Modes) -> Result<String, std::fmt::Error> {
    let mut out = String::new();
    writeln!(out, "unknowns  {} of the displacement, {} of the pressure", modes.n_u, modes.n_p)?;
    match &modes.with_fluid {
        None => writeln!(out, "mode      frequency in vacuum (Hz)")?,
        Some(_) => {
            writeln!(out, "mode      frequency in vacuum (Hz)  with the added mass of the fluid (Hz)")?
        }
    }
    let fluid = modes.with_fluid.as_deref().unwrap_or_default();
    let of = |list: &[Mode], n: usize| list.get(n).map_or_else(String::new, |mode| digits(mode.frequency));
    for n in 0..modes.vacuum.len().max(fluid.len()) {
        let line = format!("{:<8}  {:<24}  {}", n + 1, of(&modes.vacuum, n), of(fluid, n));
        writeln!(out, "{}", line.trim_end())?;
    }
    Ok(out)
}

/// Six digits.
fn digits(frequency: f64) -> String {
    crate::digits::fixed(frequency, frequency, 6)
}
