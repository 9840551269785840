//! `undula check`: what a case is, without computing it.

use crate::args::{CaseArgs, CheckArgs, bad_input, print};
use crate::digits::fixed;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;
use undula::case::error::LoadError;
use undula::case::expression::Expression;
use undula::case::{Case, Condition, FluidSpec, GENERATORS, Initial, MeshSource, SolidSpec};
use undula::choice::row_of;
use undula::error::Error;
use undula::output::{OutputError, RunDirectory};
use undula::setup::overview::Overview;
use undula::simulation::with_start;

/// Loads the case and prints its summary, or all its mistakes.
pub fn run(args: &CheckArgs) -> anyhow::Result<ExitCode> {
    match of(args)? {
        Ok(case) if args.toml => print(&case.resolved().to_toml()),
        Ok(case) => match measured(case) {
            Ok((case, overview)) => print(&summary(&case, Some(&overview))?),
            Err(error) => bad_input(error),
        },
        Err(code) => Ok(code),
    }
}

/// The case with its start, and what its mesh is.
///
/// # Errors
/// If the run from which it starts is not there, or if it does not fit its mesh.
pub fn measured(case: Case) -> Result<(Case, Overview), Error> {
    let case = with_start(case)?;
    let overview = case.check_mesh_and_measure()?;
    Ok((case, overview))
}

/// The case that is named, else that of the run whose state is asked for.
///
/// # Errors
/// Files that are there but cannot be read.
pub fn of(args: &CheckArgs) -> anyhow::Result<Result<Case, ExitCode>> {
    match &args.case {
        Some(case) => load_from(None, case, &args.set),
        None => load_from(args.from.as_deref(), "", &args.set),
    }
}

/// The `case`, or that of the run in the directory `from` if there is one; else as [`load`].
///
/// # Errors
/// Files that are there but cannot be read.
pub fn load_from(from: Option<&Path>, case: &str, set: &[String]) -> anyhow::Result<Result<Case, ExitCode>> {
    let set = set.to_vec();
    let Some(from) = from else {
        return load(&CaseArgs { case: case.into(), set });
    };
    match RunDirectory::open(from) {
        Ok(directory) => load(&CaseArgs { case: directory.case().to_string_lossy().into_owned(), set }),
        Err(error @ OutputError::NoRun { .. }) => {
            Ok(Err(bad_input(format_args!("{error}; --from expects the output directory of `undula run`"))?))
        }
        Err(error) => Err(error.into()),
    }
}

/// The case, or the exit code after its mistakes were printed.
///
/// # Errors
/// A file that is there but cannot be read.
pub fn load(args: &CaseArgs) -> anyhow::Result<Result<Case, ExitCode>> {
    match Case::load(&args.case, &args.set) {
        Ok(case) => Ok(Ok(case)),
        Err(e) if e.is_bad_input() => {
            let count = match &e {
                LoadError::Invalid(errors) if errors.0.len() > 1 => format!("\n{} mistakes", errors.0.len()),
                _ => String::new(),
            };
            Ok(Err(bad_input(format_args!("{e}{count}"))?))
        }
        Err(e) => Err(e.into()),
    }
}

/// The case in physical terms, with its size if that is known.
///
/// # Errors
/// None in practice; writing to a string does not fail.
pub fn summary(case: &Case, overview: Option<&Overview>) -> Result<String, std::fmt::Error> {
    let mut out = String::new();
    writeln!(out, "{}: {}\n", case.name, case.title)?;
    writeln!(out, "mesh      {}, refine {}, grading {}", source(case), case.mesh.refine, case.mesh.grading)?;
    if let Some(overview) = overview {
        write!(out, "{overview}")?;
    }
    writeln!(out, "space     {}/{}", case.space.velocity.name(), case.space.pressure.name())?;
    if case.stabilization.acts() {
        let how = &case.stabilization;
        writeln!(out, "          stabilisation: pressure {:?}, transport {:?}", how.pressure, how.transport)?;
    }
    if case.fluids.is_empty() {
        writeln!(out, "fluid     none: the interface is traction-free")?;
    }
    for fluid in &case.fluids {
        write_fluid(&mut out, fluid)?;
    }
    write_velocities(&mut out, case)?;
    if case.solids.is_empty() {
        writeln!(out, "solid     none: the interface is a no-slip wall")?;
    }
    for solid in &case.solids {
        write_solid(&mut out, solid)?;
    }
    if let ([fluid], [solid]) = (&case.fluids[..], &case.solids[..]) {
        let ratio = solid.density / fluid.density;
        writeln!(out, "          density ratio solid/fluid {}", fixed(ratio, ratio, 3))?;
    }
    write_time(&mut out, case)?;
    let names: Vec<&str> = case.functional.iter().map(|(name, _)| name.as_str()).collect();
    writeln!(out, "output    {}", if names.is_empty() { "no functionals".into() } else { names.join(", ") })?;
    for note in case.notes().iter().chain(overview.iter().flat_map(|overview| &overview.notes)) {
        writeln!(out, "note      {note}")?;
    }
    Ok(out)
}

/// The kind of a body with its name and its regions if there are others of the kind.
fn write_body(out: &mut String, kind: &str, name: Option<&String>, regions: &[String]) -> std::fmt::Result {
    write!(out, "{kind:<10}")?;
    match name {
        Some(name) => write!(out, "{name} in {}: ", regions.join(", ")),
        None => Ok(()),
    }
}

fn write_fluid(out: &mut String, fluid: &FluidSpec) -> std::fmt::Result {
    let (rho, nu) = (fluid.density, fluid.kinematic_viscosity);
    write_body(out, "fluid", fluid.name.as_ref(), &fluid.regions)?;
    writeln!(out, "density {rho} kg/m³, viscosity {nu} m²/s ({:.3e} Pa s)", rho * nu)
}

fn write_velocities(out: &mut String, case: &Case) -> std::fmt::Result {
    if case.fluids.is_empty() {
        return Ok(());
    }
    for (name, condition) in &case.boundary {
        let Condition::Velocity(velocity) = condition else { continue };
        writeln!(out, "          {name}: v = {} m/s", vector(velocity))?;
    }
    Ok(())
}

/// Components in words.
fn vector(components: &[Expression]) -> String {
    format!("({})", components.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
}

fn source(case: &Case) -> String {
    let extruded = |source: String| match case.mesh.extrude {
        Some(extrude) => {
            let (depth, layers) = (extrude.depth, extrude.all_layers());
            format!("{source}, extruded by {depth} m in {layers} layer{}", if layers == 1 { "" } else { "s" })
        }
        None => source,
    };
    extruded(plane(case))
}

fn plane(case: &Case) -> String {
    match &case.mesh.source {
        MeshSource::Box { lower, upper, cells } => format!("box {lower:?} to {upper:?} m of {cells:?} cells"),
        MeshSource::Tube { length, radii: [inner, outer], cells: [along, round, through], axis } => format!(
            "tube of length {length} m, radii {inner} and {outer} m, {along} cells along, {round} round, {through} through \
             the wall{}",
            if axis.is_empty() { String::new() } else { format!(", its axis {}", vector(axis)) }
        ),
        MeshSource::File(path) => path.display().to_string(),
        MeshSource::Own(_) => "given by a program".into(),
        generator => row_of(&GENERATORS, generator)
            .map_or(String::new(), |row| format!("{} ({})", row.about, row.name)),
    }
}

fn write_solid(out: &mut String, solid: &SolidSpec) -> std::fmt::Result {
    let (rho, mu, lambda) = (solid.density, solid.mu, solid.lambda);
    write_body(out, "solid", solid.name.as_ref(), &solid.regions)?;
    writeln!(out, "density {rho} kg/m³, {}", solid.law.name())?;
    if solid.c2 > 0.0 {
        writeln!(out, "          c1 {:.4e} Pa, c2 {:.4e} Pa", 0.5 * mu - solid.c2, solid.c2)?;
    }
    if lambda.is_infinite() {
        writeln!(out, "          mu {mu:.4e} Pa (Young {:.4e} Pa), incompressible", 3.0 * mu)?;
        let shear = (mu / rho).sqrt();
        return writeln!(out, "          waves {} m/s (shear)", fixed(shear, shear, 4));
    }
    let poisson = lambda / (2.0 * (lambda + mu));
    let young = 2.0 * mu * (1.0 + poisson);
    writeln!(
        out,
        "          mu {mu:.4e} Pa, lambda {lambda:.4e} Pa (Young {young:.4e} Pa, Poisson {poisson:.4})"
    )?;
    let (shear, pressure) = ((mu / rho).sqrt(), ((lambda + 2.0 * mu) / rho).sqrt());
    let [shear, pressure] = [shear, pressure].map(|speed| fixed(speed, speed, 4));
    writeln!(out, "          waves {shear} m/s (shear), {pressure} m/s (pressure)")
}

fn write_time(out: &mut String, case: &Case) -> std::fmt::Result {
    let Some(time) = &case.time else {
        return writeln!(out, "time      stationary");
    };
    let theta = case.theta().unwrap_or(1.0);
    write!(out, "time      {} to {} s, step {} s", time.start, time.end, time.step)?;
    if let Some(k) = time.step.constant_value() {
        // A rest of a per mille of a step is not worth its own.
        write!(out, ", {} steps", ((time.end - time.start) / k - 1e-3).ceil().max(1.0))?;
    }
    writeln!(out, ", theta {theta}")?;
    match &case.initial {
        Some(initial @ (Initial::From(_) | Initial::Static)) => writeln!(out, "          from the {initial}"),
        Some(Initial::Fields { velocity, displacement }) => {
            for (name, unit, pair) in [("u", "m", displacement), ("v", "m/s", velocity)] {
                if let Some(field) = pair {
                    writeln!(out, "          from {name} = {} {unit}", vector(field))?;
                }
            }
            Ok(())
        }
        None => Ok(()),
    }
}
