//! `undula check --inf-sup`: the constants (5.24) and (5.25), and condition numbers of the matrix (5.35).

use crate::args::{CheckArgs, print, say_notes};
use crate::{check, run};
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;
use undula::case::Case;
use undula::error::Error;
use undula::simulation::SetUp;
use undula::system::Dim;
use undula::verification::stability::{Conditions, Constants, InfSup, conditions, constants};

/// Below this a constant is zero: it is the root of a rounding error.
const ZERO: f64 = 1e-4;

/// Loads the case and prints what there is to say.
pub fn run(args: &CheckArgs) -> anyhow::Result<ExitCode> {
    let case = match check::of(args)? {
        Ok(case) => case,
        Err(code) => return Ok(code),
    };
    let report = match case.mesh.dimension {
        3 => report::<3>(case, args.from.as_deref()),
        _ => report::<2>(case, args.from.as_deref()),
    };
    match report {
        Ok(text) => print(&text),
        Err(error) => run::failed(error),
    }
}

/// What there is to say of `case`, with the state of the last checkpoint of the run in `from`.
///
/// # Errors
/// If the case does not fit its mesh, the run has no checkpoint, or a matrix cannot be factorised.
fn report<const D: usize>(case: Case, from: Option<&Path>) -> Result<String, Error>
where
    Dim<D>: SetUp<D>,
{
    case.needs_plane("inf-sup constants")?;
    // The state is that of the run in `from`.
    let mut simulation = match from {
        Some(_) => Dim::<D>::at_rest(case, 1)?,
        None => Dim::<D>::set_up(case, 1)?,
    };
    if let Some(from) = from {
        say_notes(&undula::run::restore_latest(&mut simulation, from)?);
    }
    let moved = from.is_some() && !simulation.stepper.new.u.is_empty();
    let constants = constants(&simulation, moved)?;
    let conditions = simulation.install(conditions)?;
    let domain = match moved {
        true => format!("at t = {} s", simulation.stepper.time),
        false => "with a smooth deformation".into(),
    };
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = write_constants(&mut out, constants.as_ref(), &domain);
    let _ = write_conditions(&mut out, &conditions);
    Ok(out)
}

fn write_constants(out: &mut String, constants: Option<&Constants>, domain: &str) -> std::fmt::Result {
    let Some(Constants { reference, moved, min_j }) = constants else {
        return writeln!(out, "inf-sup   no fluid, no constant");
    };
    writeln!(out, "inf-sup   {:<8} on the reference domain, (5.25)", number(reference))?;
    writeln!(out, "          {:<8} on the domain {domain}, smallest J {min_j:.3}, (5.24)", number(moved))?;
    if reference.constant < ZERO {
        writeln!(
            out,
            "          There are pressures that do no work on any velocity: the pair alone does not determine the \
             pressure.\n          [stabilization] pressure = \"lps\" does; the constant is that of the pair without it."
        )?;
    } else {
        writeln!(
            out,
            "          The error of the pressure is bounded with the inverse of the constant. It should not fall \
             when the\n          mesh is refined: compare --set mesh.refine."
        )?;
        let ratio = moved.constant / reference.constant;
        writeln!(
            out,
            "          Moved : reference = {ratio:.3}. {}",
            match ratio {
                r if r < 0.1 =>
                    "The deformation costs most of the stability: improve the extension or the mesh.",
                r if r < 0.5 => "Large deformations cost stability, and more where J is small.",
                _ => "The deformation does not endanger the pair.",
            }
        )?;
    }
    if reference.closed {
        writeln!(
            out,
            "          The fluid, or a part of it, is closed in; constant pressures are left out there."
        )?;
    }
    Ok(())
}

fn number(constant: &InfSup) -> String {
    if constant.constant < ZERO { "0".into() } else { format!("{:.5}", constant.constant) }
}

fn write_conditions(out: &mut String, conditions: &Conditions) -> std::fmt::Result {
    writeln!(out, "condition unknowns  with units  scaled    in the 2-norm, by Lanczos' method from below")?;
    for (name, c) in conditions {
        writeln!(out, "          {:<8}  {:<10.2e}  {:<8.1e}  {name}", c.n, c.plain, c.scaled)?;
    }
    let whole = conditions.first().map_or(1.0, |(_, c)| c.scaled);
    let digits = (15.95 - whole.log10()).max(0.0).floor();
    writeln!(
        out,
        "          A direct solver scales the matrix and keeps about {digits} of 16 digits, before refinement; {}",
        match digits {
            d if d < 4.0 => "too few: expect it to fail.",
            d if d < 8.0 => "single precision has none left.",
            _ => "that is enough.",
        }
    )
}
