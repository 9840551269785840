//! A case to start from, for a mesh of one's own: every region and boundary of the mesh is in it, with a comment.

use super::names::MeshNames;
use super::overview::{Boundary, Overview};
use crate::case::error::{LoadError, quoted};
use crate::case::key::quote;
use crate::case::literal::string;
use crate::case::{Case, Condition};
use crate::error::Error;
use crate::mesh::INTERFACE;
use crate::mesh::gmsh::{AnyMesh, read_any};
use std::fmt::Write;
use std::path::Path;

/// Parts of names of regions that are bodies; all others are fluid.
const BODIES: [&str; 15] = [
    "solid", "struct", "beam", "flap", "leaf", "valve", "membrane", "tissue", "elastic", "body", "wall",
    "box", "rubber", "plate", "foil",
];

/// Reynolds number of the flow through the largest inlet.
const REYNOLDS: f64 = 100.0;

/// Kinematic viscosity \[m²/s\].
const VISCOSITY: f64 = 1e-3;

/// What a boundary is taken for, by its name.
#[derive(Copy, Clone, Debug, PartialEq)]
enum Guess {
    Inlet,
    Outlet,
    Symmetry,
    Slip,
    Wall,
    Clamp,
}

impl Guess {
    /// The name of its condition.
    fn condition(self) -> &'static str {
        match self {
            // The only one with data of its own.
            Guess::Inlet => "flux",
            Guess::Outlet => Condition::DoNothing.name(),
            Guess::Symmetry => Condition::Symmetry.name(),
            Guess::Slip => Condition::Slip.name(),
            Guess::Wall => Condition::NoSlip.name(),
            Guess::Clamp => Condition::Clamped.name(),
        }
    }
}

/// What is known of a mesh.
struct Known {
    fluid: Vec<String>,
    solid: Vec<String>,
    /// Boundaries that need a condition, with what they are taken for.
    boundaries: Vec<(String, Guess)>,
    overview: Overview,
}

/// A case to start from.
pub struct Starter {
    /// The case file.
    pub text: String,
    /// What should be known of it.
    pub notes: Vec<String>,
}

/// A case called `name` for the Gmsh file `mesh`, which it names as `written`.
///
/// Regions and boundaries are taken for what their names say; what is not known, such as materials, has values to begin
/// with. The case can be run as it is.
///
/// # Errors
/// As [`read_any`]; [`Error::Case`] if the mesh cannot be used, as by a boundary between two regions with a gap.
pub fn starter(mesh: &Path, written: &str, name: &str) -> Result<Starter, Error> {
    let (names, dim) = match read_any(mesh)? {
        AnyMesh::Plane(mesh) => (MeshNames::of(&mesh), 2),
        AnyMesh::Space(mesh) => (MeshNames::of(&mesh), 3),
    };
    let is_body = |region: &&String| {
        let region = region.to_lowercase();
        names.regions.len() > 1 && BODIES.iter().any(|part| region.contains(part)) || region == "solid"
    };
    let (solid, fluid): (Vec<String>, Vec<String>) = {
        let (solid, fluid): (Vec<&String>, Vec<&String>) = names.regions.iter().partition(is_body);
        (solid.into_iter().cloned().collect(), fluid.into_iter().cloned().collect())
    };
    let boundaries = boundaries(&names, &fluid);
    // Its own measures need a case; walls all around are one.
    let mut first = regions(written, &fluid, &solid, dim);
    for (boundary, _) in &boundaries {
        let wall = if fluid.is_empty() { Guess::Clamp } else { Guess::Wall };
        let _ = write!(first, "[boundary.{}]\ncondition = \"{}\"\n", quote(boundary), wall.condition());
    }
    // At rest the pressure of a fluid that is closed in would not be determined.
    first += "[time]\nstep = 1\nend = 1\n";
    let place = mesh.with_file_name(format!("{name}.toml"));
    let case = Case::from_toml(&first, &place.to_string_lossy(), &[]);
    let case = case.map_err(|errors| Error::Load(LoadError::Invalid(errors)))?;
    let overview = case.check_mesh_and_measure()?;
    let known = Known { fluid, solid, boundaries, overview };
    Ok(Starter { text: known.write(written, name, dim), notes: known.closed_in().into_iter().collect() })
}

/// The boundaries that need a condition.
fn boundaries(names: &MeshNames, fluid: &[String]) -> Vec<(String, Guess)> {
    let outer = names.outer.iter().filter(|(name, _)| name != INTERFACE);
    let mut found: Vec<(String, Guess)> = outer
        .map(|(name, regions)| (name.clone(), guess(name, regions.iter().any(|r| fluid.contains(r)))))
        .collect();
    let has = |guess| found.iter().any(|(_, other)| *other == guess);
    if !has(Guess::Outlet) {
        // What comes in has to go out.
        found
            .iter_mut()
            .filter(|(_, guess)| *guess == Guess::Inlet)
            .for_each(|(_, guess)| *guess = Guess::Wall);
    }
    found
}

fn guess(name: &str, of_fluid: bool) -> Guess {
    let name = name.to_lowercase();
    let has = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
    match () {
        () if has(&["symm"]) => Guess::Symmetry,
        () if !of_fluid => Guess::Clamp,
        () if has(&["inflow", "inlet"]) || name == "in" => Guess::Inlet,
        () if has(&["outflow", "outlet"]) || name == "out" => Guess::Outlet,
        () if has(&["slip", "far"]) && !has(&[Condition::NoSlip.name(), "noslip"]) => Guess::Slip,
        () => Guess::Wall,
    }
}

/// Mesh and materials.
fn regions(written: &str, fluid: &[String], solid: &[String], dim: usize) -> String {
    let mut text = format!("[mesh]\nfile = {}\nrefine = 0  # uniform refinements\n\n", string(written));
    let list = |names: &[String]| match names {
        [one] => string(one),
        _ => format!("[{}]", names.iter().map(|name| string(name)).collect::<Vec<_>>().join(", ")),
    };
    if !fluid.is_empty() {
        let _ = write!(
            text,
            "[fluid]\nregion = {}\ndensity = 1000.0  # kg/m3\nkinematic-viscosity = {VISCOSITY:e}  # m2/s\n\n",
            list(fluid)
        );
    }
    if !solid.is_empty() {
        let _ = write!(
            text,
            "[solid]\nregion = {}\nlaw = \"st-venant-kirchhoff\"  # others: undula keys solid.law\n\
             density = 1000.0  # kg/m3\nyoung = 1.0e6  # Pa\npoisson = 0.4\n",
            list(solid)
        );
        if fluid.is_empty() {
            let weight = if dim == 2 { "[0, -9.81]" } else { "[0, -9.81, 0]" };
            let _ = writeln!(text, "body-force = {weight}  # m/s2");
        }
        text.push('\n');
    }
    text
}

impl Known {
    fn boundary(&self, name: &str) -> Option<&Boundary> {
        self.overview.boundaries.iter().find(|boundary| boundary.name == name)
    }

    /// What is to be said where no name of a boundary says that the fluid leaves there.
    fn closed_in(&self) -> Option<String> {
        let outer = |guess: Guess| self.boundaries.iter().filter(move |(_, other)| *other == guess);
        if self.fluid.is_empty() || outer(Guess::Outlet).next().is_some() {
            return None;
        }
        let walls: Vec<&str> = outer(Guess::Wall).map(|(name, _)| name.as_str()).collect();
        (!walls.is_empty()).then(|| {
            format!(
                "no boundary is called `outlet`, `outflow` or alike, so that the fluid is closed in: {} got `no-slip`. Where \
                 it flows in or out, give `flux` or `do-nothing`",
                quoted(walls)
            )
        })
    }

    /// Longest side of the domain \[m\].
    fn length(&self) -> f64 {
        let [lower, upper] = &self.overview.extents;
        lower.iter().zip(upper).fold(0.0, |length: f64, (a, b)| length.max(b - a))
    }

    fn write(&self, written: &str, name: &str, dim: usize) -> String {
        let mut text = format!(
            "# A case for the mesh {written}, made by `undula new --mesh`. Numbers and conditions are a start: go through\n\
             # them, then `undula check` and `undula run`. `undula keys boundary` lists all conditions with their data.\n"
        );
        let [lower, upper] = &self.overview.extents;
        let sides: Vec<String> = ["x", "y", "z"]
            .iter()
            .zip(lower.iter().zip(upper))
            .map(|(x, (a, b))| format!("{x} from {} to {} m", short(*a), short(*b)))
            .collect();
        let _ = write!(text, "#\n# {}. If that is not in metres, give mesh.scale.\n", sides.join(", "));
        for (region, cells, _) in &self.overview.regions {
            let body = if self.solid.contains(region) { "solid" } else { "fluid" };
            let _ = writeln!(text, "# Region {region}: {cells} cells, taken for {body}.");
        }
        if let Some(note) = self.closed_in() {
            wrapped(&note).iter().for_each(|line| text += &format!("# {line}\n"));
        }
        let _ = write!(text, "\nname = {}\ntitle = \"\"\n\n", string(name));
        text += &regions(written, &self.fluid, &self.solid, dim);
        let speed = self.speed(dim);
        for (boundary, guess) in &self.boundaries {
            self.write_boundary(&mut text, boundary, *guess, speed, dim);
        }
        if !self.fluid.is_empty() {
            let length = self.length();
            let (end, step) = (2.0 * length / speed, length / speed / 200.0);
            let _ = write!(
                text,
                "[time]\nstep = {}  # s\nend = {}  # s, twice the time through the domain\n\n",
                short(step),
                short(end)
            );
        }
        self.write_functionals(&mut text);
        text
    }

    /// Mean velocity of the inlet \[m/s\].
    fn speed(&self, dim: usize) -> f64 {
        let inlets = self.boundaries.iter().filter(|(_, guess)| *guess == Guess::Inlet);
        let sizes = inlets.filter_map(|(name, _)| self.boundary(name)).map(|boundary| match dim {
            2 => boundary.length,
            _ => boundary.length.sqrt(),
        });
        let size = sizes.fold(0.0, f64::max);
        REYNOLDS * VISCOSITY / if size > 0.0 { size } else { self.length() }
    }

    fn write_boundary(&self, text: &mut String, name: &str, guess: Guess, speed: f64, dim: usize) {
        let about = self.boundary(name).map_or(String::new(), |boundary| {
            let unit = if dim == 2 { "m" } else { "m2" };
            format!("  # {} {unit}, of the {}", short(boundary.length), boundary.bodies)
        });
        let _ = writeln!(text, "[boundary.{}]{about}", quote(name));
        let condition = guess.condition();
        let others = match guess {
            Guess::Clamp => "or traction-free, traction, displacement, spring",
            Guess::Outlet => "or pressure, resistance, windkessel",
            _ => "or velocity, do-nothing, slip, pressure",
        };
        let _ = writeln!(text, "condition = \"{condition}\"  # {others}");
        if let (Guess::Inlet, Some(boundary)) = (guess, self.boundary(name)) {
            let flow = short(speed * boundary.length);
            let time = short(0.2 * self.length() / speed);
            let unit = if dim == 2 { "m2/s" } else { "m3/s" };
            let mean = short(speed);
            let _ = write!(
                text,
                "profile = \"parabolic\"\nflow-rate = \"-{flow}*ramp(t,{time})\"  # {unit}, into the fluid: {mean} m/s on \
                 average, Re {REYNOLDS}, started within {time} s\n"
            );
        }
        text.push('\n');
    }

    fn write_functionals(&self, text: &mut String) {
        let wall = self.boundaries.iter().find(|(_, guess)| *guess == Guess::Wall);
        let on = match (self.fluid.is_empty(), self.solid.is_empty(), wall) {
            (false, false, _) => INTERFACE,
            (false, true, Some((wall, _))) => wall,
            (true, ..) => {
                *text += "[functional.energy]  # stored energy of the solid\nkind = \"energy\"\nterm = \"elastic\"\n\n";
                return;
            }
            _ => return,
        };
        for (name, component) in [("drag", "x"), ("lift", "y")] {
            let on = string(on);
            let _ = write!(
                text,
                "[functional.{name}]  # force of the fluid\nkind = \"force\"\non = [{on}]\ncomponent = \"{component}\"\n\n"
            );
        }
        *text += "[output]\nfields-every = 10  # steps, for the player of report.html and for ParaView\n";
    }
}

/// A sentence in lines that fit into a comment.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        if lines[last].chars().count() + word.chars().count() > 110 && !lines[last].is_empty() {
            lines.push(word.into());
        } else {
            let space = if lines[last].is_empty() { "" } else { " " };
            lines[last] += &format!("{space}{word}");
        }
    }
    lines
}

/// A number with three digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    if rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}
