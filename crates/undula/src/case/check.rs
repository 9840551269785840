//! From TOML to [`Case`]: every key read, every default resolved, all mistakes told at once.
//!
//! The tables are read by one function each: bodies and mesh in `body`, conditions and functionals in
//! `condition`, time and solvers in `solver`, what is written in `output`. What needs the mesh is in [`crate::setup::fit`].

mod axis;
mod bodies;
mod body;
mod condition;
mod functional;
mod initial;
mod material;
mod mesh;
mod output;
mod solver;
mod stabilization;

use super::builtin::{builtin_case, builtin_cases};
use super::conditions::Condition;
use super::error::{CaseErrors, suggestion};
use super::expression::Functions;
use super::profile::Profile;
use super::raw::{Document, Origin, Value};
use super::read::{Checker, Section};
use super::schema::{Case, FunctionalSpec, OwnMesh, Record, Scheme, SolidSpec, TimeSpec};
use crate::functional::body_energy::Part;
use crate::physics::{PressureTerm, Stabilization, TransportTerm};
use crate::space::Region;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

impl Case {
    /// The case that the TOML `text` means after `overrides` (`key=value`, as after `--set`; the value
    /// `none` removes a key). `file_name` is shown in messages; a mesh file is looked for beside it.
    ///
    /// # Errors
    /// All mistakes, each with its place.
    ///
    /// ```
    /// use undula::Case;
    /// let text = "[mesh]\ngenerator = \"turek-hron\"\n[fluid]\ndensity = -1\nkinematic-viscosity = 1e-3\n";
    /// let errors = Case::from_toml(text, "own.toml", &[]).unwrap_err();
    /// assert_eq!(errors.to_string(), "own.toml:4:11: fluid.density = -1: expected a number above 0");
    /// ```
    pub fn from_toml(text: &str, file_name: &str, overrides: &[String]) -> Result<Self, CaseErrors> {
        Self::from_toml_on(text, file_name, overrides, None, Functions::NONE)
    }

    /// The same on the `mesh` that the program gives, if it does, with its `functions`.
    pub(crate) fn from_toml_on(
        text: &str,
        file_name: &str,
        overrides: &[String],
        mesh: Option<&OwnMesh>,
        functions: &Functions,
    ) -> Result<Self, CaseErrors> {
        let document = Document::parse(text, file_name, overrides).map_err(CaseErrors)?;
        Self::from_document(&document, Checker::new(&document, mesh, functions))
    }

    /// The case in the `text` that a run has left. Tables of values are not read: wherever their files are now, the
    /// text tells what is asked of it.
    ///
    /// # Errors
    /// As [`Case::from_toml`].
    pub(crate) fn from_record(text: &str) -> Result<Self, CaseErrors> {
        let document = Document::parse(text, "case.toml", &[]).map_err(CaseErrors)?;
        let mut checker = Checker::new(&document, None, Functions::NONE);
        checker.reads_tables = false;
        Self::from_document(&document, checker)
    }

    fn from_document<'d>(document: &'d Document, checker: Checker<'d>) -> Result<Self, CaseErrors> {
        let case = read(&checker);
        let places =
            checker.origins.borrow().iter().map(|(key, o)| (key.clone(), document.place(o))).collect();
        let notes = checker.notes.take();
        let errors = checker.into_errors();
        match case {
            Some(mut case) if errors.is_empty() => {
                let relative_mesh = relative_mesh(document);
                let file_name = document.file_name.clone();
                case.record = Record { file_name, places, notes, relative_mesh };
                Ok(case)
            }
            _ => Err(CaseErrors(errors)),
        }
    }
}

/// The case; meaningless if the checker found mistakes.
fn read(checker: &Checker<'_>) -> Option<Case> {
    let mut root = checker.root();
    let name = name(&mut root);
    let title = root.string("title").unwrap_or_default();
    let reference = reference(&mut root);
    let mesh = mesh::mesh(root.section("mesh"), &root);
    let space = body::space(root.section("space"), mesh.as_ref());
    let fluids = bodies::read(&mut root, "fluid", body::fluid);
    if !fluids.is_empty() {
        body::refuse_pair(&root.section("space"), &space);
    }
    let how = stabilization::stabilization(root.section("stabilization"), &space, !fluids.is_empty());
    material::refuse_residuals(&root.section("stabilization"), &fluids, &how);
    let solids = bodies::read(&mut root, "solid", body::solid);
    bodies::refuse(&mut root, &fluids, &solids, &space, &how);
    let motion = root.section("motion");
    let (boundary, backflow) = condition::boundary(root.section("boundary"));
    let (time, at_time) = solver::time(root.section("time"));
    let initial = initial::initial(root.section("initial"), time.is_some());
    bodies::refuse_prestress(&mut root, &solids, time.is_some(), initial.as_ref());
    for fluid in fluids.iter().filter(|fluid| fluid.force_at_current) {
        refuse_current(&bodies::section(&mut root, "fluid", fluid.name.as_deref()), time.as_ref(), &how);
    }
    let motion = body::motion(motion, time.is_some(), space.velocity);
    let at_rest = (time.is_none() && !solids.is_empty()).then_some(&solids[..]);
    let newton = solver::newton(root.section("newton"), at_rest.is_none());
    let linear = solver::linear(root.section("linear"), (newton.linearization, at_rest), mesh.as_ref());
    let (functional, names) = condition::functional(root.section("functional"), &fluids, &solids);
    let output = output::output(root.section("output"), &names, &functional, time.as_ref());
    refuse_balance(&mut root, &functional, time.as_ref(), how.acts(), &solids);
    if time.is_none() {
        note_still(&mut root, &output, &solids, &boundary);
    }
    let case = Case {
        name,
        title,
        reference,
        mesh: mesh?,
        space,
        stabilization: how,
        fluids,
        solids,
        motion,
        boundary,
        backflow,
        time,
        at_time: at_time.unwrap_or(0.0),
        initial,
        newton,
        linear,
        functional,
        output,
        record: Record::default(),
    };
    axis::refuse(&mut root, &case);
    refuse_time(&case, at_time, &mut root);
    root.finish();
    Some(case)
}

/// Methods that take the body force at other places than those where the flow is.
fn refuse_current(fluid: &Section<'_, '_>, time: Option<&TimeSpec>, how: &Stabilization) {
    if time.is_some_and(|time| time.scheme == Scheme::Galerkin) {
        fluid.wrong(
            "body-force-at",
            "cg1 takes forces at the middle of a step; expected `reference`, or another scheme",
        );
    }
    if how.pressure == PressureTerm::Pspg || how.transport == TransportTerm::Supg {
        let message = "the residuals of pspg and supg take forces on the reference domain; expected `reference`, or lps";
        fluid.wrong("body-force-at", message);
    }
}

/// Balances of energy of steps that are none, or of what the balance does not know.
fn refuse_balance(
    root: &mut Section<'_, '_>,
    functionals: &[(String, FunctionalSpec)],
    time: Option<&TimeSpec>,
    stabilized: bool,
    solids: &[SolidSpec],
) {
    // The pressure of a step belongs to no end of it, so that the rate of its energy is not known.
    let compressed = solids.iter().find(|solid| solid.bulk.is_some());
    for (name, spec) in functionals {
        if let (FunctionalSpec::Balance { part, .. }, Some(_)) = (spec, compressed)
            && matches!(part, Part::Rate | Part::Residual)
        {
            let message = "is not available with `bulk`; expected another part, or a solid without it";
            root.section("functional").section(name).wrong("part", message);
        }
    }
    let message = match time.map(|time| time.scheme) {
        None => "only for a case in time, with [time]: it is the balance of a step",
        Some(Scheme::Bdf2) => {
            "bdf2 relates three solutions, and the balance is that of two: take another scheme"
        }
        Some(Scheme::Esdirk3 | Scheme::Esdirk4) => {
            "a Runge-Kutta method has several stages, and the balance is that of two solutions: take another scheme"
        }
        Some(_) if stabilized => {
            "the balance does not know the power of stabilisation: take a stable pair without it"
        }
        Some(_) => return,
    };
    for (name, _) in functionals.iter().filter(|(_, spec)| matches!(spec, FunctionalSpec::Balance { .. })) {
        root.section("functional").section(name).wrong("kind", message);
    }
}

/// What has no effect in a stationary case.
fn note_still(
    root: &mut Section<'_, '_>,
    output: &super::schema::OutputSpec,
    solids: &[SolidSpec],
    boundary: &BTreeMap<String, Condition>,
) {
    note_steps(root.checker, output);
    note_damping(root, solids);
    condition::note_still(root.checker, boundary);
}

/// Settings of output that only matter where there are steps in time.
fn note_steps(checker: &Checker<'_>, output: &super::schema::OutputSpec) {
    let minutes = output.checkpoint_minutes;
    for (key, given) in [
        ("fields-every", output.fields_every > 0),
        ("fields-interval", output.fields_interval.is_some()),
        ("fields-times", !output.fields_times.is_empty()),
        ("window", output.window.is_some()),
        ("checkpoint-every", output.checkpoint_every > 0),
        ("checkpoint-minutes", minutes != 0.0 && minutes != output::CHECKPOINT_MINUTES),
    ] {
        if given {
            let note = format!("output.{key} has no effect: the case is stationary");
            checker.note(note);
        }
    }
}

/// The damping of a stationary case has no effect.
fn note_damping(root: &mut Section<'_, '_>, solids: &[SolidSpec]) {
    for solid in solids {
        material::note_still(&bodies::section(root, "solid", solid.name.as_deref()));
    }
}

/// A stationary case takes its data at one time; that time must be known if it matters.
fn refuse_time(case: &Case, at_time: Option<f64>, root: &mut Section<'_, '_>) {
    if case.time.is_some() || at_time.is_some() {
        return;
    }
    let message =
        "depends on t, but the case is stationary: give time.end, the time [s] at which it is taken";
    for (name, condition) in &case.boundary {
        if matches!(condition, Condition::Flux { profile: Profile::Womersley, .. }) {
            root.section("boundary").section(name).wrong("profile", message);
        }
        for (key, data) in condition.expressions() {
            if data.iter().any(super::expression::Expression::depends_on_time) {
                root.section("boundary").section(name).wrong(key, message);
            }
        }
    }
    let forces = case.loads().into_iter().map(|load| (load.body, load.material, load.force));
    for (body, material, force) in forces {
        if force.iter().any(super::expression::Expression::depends_on_time) {
            let (kind, name) = match body {
                Region::Fluid => ("fluid", &case.fluids[usize::from(material)].name),
                Region::Solid => ("solid", &case.solids[usize::from(material)].name),
            };
            bodies::section(root, kind, name.as_deref()).wrong("body-force", message);
        }
    }
}

/// `name`, else the file name without its folder and ending.
fn name(root: &mut Section<'_, '_>) -> String {
    let fallback = name_of_file(Path::new(&root.checker.document.file_name));
    match root.string("name") {
        Some(name) if name.trim_matches('.').is_empty() || !name.chars().all(in_name) => {
            root.wrong(
                "name",
                "expected letters, digits, `-`, `_` and `.` only (it names the output directory)",
            );
            fallback
        }
        Some(name) => name,
        None => fallback,
    }
}

/// Whether the document names its mesh file by a relative path.
fn relative_mesh(document: &Document) -> bool {
    let mesh = document.root.get("mesh").map(|item| &item.value);
    let file = match mesh {
        Some(Value::Table(table)) => table.get("file").map(|item| &item.value),
        _ => None,
    };
    matches!(file, Some(Value::String(path)) if Path::new(path).is_relative())
}

/// The name that a case in this file has unless it gives one: without folder and ending, in letters, digits, `-`, `_` and
/// `.` only.
pub fn name_of_file(file: &Path) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let name: String = stem.chars().map(|c| if in_name(c) { c } else { '_' }).collect();
    if name.trim_matches('.').is_empty() { "case".into() } else { name }
}

fn in_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.')
}

/// `reference`, the built-in case whose published results are asked for.
fn reference(root: &mut Section<'_, '_>) -> Option<String> {
    let name = root.string("reference")?;
    if builtin_case(&name).is_none() {
        let message =
            format!("no published results{}", suggestion(&name, builtin_cases().iter().map(|c| c.name)));
        root.wrong("reference", message);
    }
    Some(name)
}

/// A path of the case: beside the case file, or in the working directory if it comes from `--set`.
fn resolve(section: &Section<'_, '_>, key: &str, path: &str) -> PathBuf {
    let origins = section.checker.origins.borrow();
    let from_file = matches!(origins.get(&section.dotted(key)), Some(Origin::File(_)));
    let folder = Path::new(&section.checker.document.file_name).parent().filter(|_| from_file);
    let path = folder.map_or(PathBuf::from(path), |folder| folder.join(path));
    std::path::absolute(&path).unwrap_or(path)
}

/// Names of regions and boundaries as they occur in meshes.
pub(super) fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}
