//! A case as TOML with all defaults resolved.

mod functional;
mod material;

use super::choices::{OUTPUT_CELLS, OUTPUT_MESH, STARTS};
use super::conditions::Datum;
use super::expression::{Expression, Table};
use super::initial::Initial;
use super::literal::{number, numbers, string};
use super::profile::PROFILES;
use super::schema::{
    Case, Condition, Extrude, GENERATORS, KRYLOV, MeshSource, MotionModel, Scheme, Tangent, WallSpec,
};
use super::{key, keys};
use crate::algebra::{ENGINES, Engine, PRECISIONS, SOLVERS};
use crate::choice::{Choice, name_of, row_of};
use crate::functional::nodal::FIELDS;
use crate::physics::extension::{MOTIONS, OUTER, STIFFENING};
use crate::physics::stabilization::{MAPPINGS, PRESSURE_TERMS, PROJECTIONS, TRANSPORT_TERMS};
use crate::physics::{PressureTerm, TransportTerm};
use crate::space::{Against, BACKFLOW, COORDINATES, WALLS};
use crate::tangent::{DIFFERENCES, LINEARIZATIONS, TANGENTS};
use crate::time::scheme::{DOMAIN_MOTIONS, SCHEMES};
use std::path::{Component, Path, PathBuf};

fn expression(e: &Expression) -> String {
    match e.source().parse::<f64>() {
        Ok(x) => number(x),
        Err(_) => string(e.source()),
    }
}

fn expressions(vector: &[Expression]) -> String {
    format!("[{}]", vector.iter().map(expression).collect::<Vec<_>>().join(", "))
}

/// What stands for parts that a program gives.
const OWN: &str = "own";

/// Lines of TOML.
#[derive(Default)]
struct Lines {
    text: String,
    /// The table of the next line.
    table: String,
}

impl Lines {
    fn table(&mut self, name: &str) {
        self.text += &format!("\n[{name}]\n");
        self.table = name.into();
    }

    /// A value with its unit, or else its meaning, as a comment.
    fn key(&mut self, key: &str, value: impl AsRef<str>) {
        let dotted = if self.table.is_empty() { key.into() } else { format!("{}.{key}", self.table) };
        let known = keys::find(&dotted);
        debug_assert!(known.is_some(), "{dotted} is not in the table of keys");
        let comment = known.map_or("", keys::Key::comment);
        self.text += &format!("{key} = {}  # {comment}\n", value.as_ref());
    }

    /// The regions of a body.
    fn regions(&mut self, regions: &[String]) {
        match regions {
            [one] => self.word("region", one),
            several => self.key("region", names(several)),
        }
    }

    /// A word, which says itself what it means.
    fn word(&mut self, key: &str, value: &str) {
        self.text += &format!("{key} = {}\n", string(value));
    }

    fn choice<T: PartialEq>(&mut self, key: &str, table: &[Choice<T>], value: &T) {
        self.word(key, name_of(table, value));
    }

    /// The name of a variant, whatever its parameters are.
    fn variant<T>(&mut self, key: &str, table: &[Choice<T>], value: &T) {
        self.word(key, row_of(table, value).map_or("", |row| row.name));
    }
}

impl Case {
    /// The case as TOML, every default written out; it loads again to an equal case.
    pub fn to_toml(&self) -> String {
        self.to_toml_with(|table| table.path.display().to_string())
    }

    /// The same with the files of tables named by `name`.
    pub(crate) fn to_toml_with(&self, name: impl Fn(&Table) -> String) -> String {
        let mut case = self.clone();
        case.name_tables(name);
        case.text()
    }

    fn text(&self) -> String {
        let mut out = Lines::default();
        out.word("name", &self.name);
        out.word("title", &self.title);
        if let Some(reference) = &self.reference {
            out.key("reference", string(reference));
        }
        self.write_mesh(&mut out);
        self.write_stabilization(&mut out);
        self.write_bodies(&mut out);
        for (name, condition) in &self.boundary {
            out.table(&key::join("boundary", name));
            write_condition(&mut out, condition);
            let of_fluid = !self.fluids.is_empty() && self.against(name) != Against::None;
            if of_fluid || self.backflow.contains_key(name) {
                out.choice("backflow", &BACKFLOW, &self.against(name));
            }
        }
        self.write_time(&mut out);
        self.write_initial(&mut out);
        self.write_solvers(&mut out);
        for (name, functional) in &self.functional {
            out.table(&key::join("functional", name));
            functional.write(&mut out);
        }
        out.table("output");
        out.key("fields-every", self.output.fields_every.to_string());
        if let Some(interval) = self.output.fields_interval {
            out.key("fields-interval", number(interval));
        }
        if !self.output.fields_times.is_empty() {
            out.key("fields-times", numbers(&self.output.fields_times));
        }
        out.key("fields", names(self.output.fields.iter().map(|field| name_of(&FIELDS, field))));
        if let Some(window) = &self.output.window {
            out.key("window", numbers(window));
        }
        out.choice("mesh", &OUTPUT_MESH, &self.output.deformed);
        out.choice("cells", &OUTPUT_CELLS, &self.output.curved);
        out.key("checkpoint-every", self.output.checkpoint_every.to_string());
        out.key("checkpoint-minutes", number(self.output.checkpoint_minutes));
        out.key("report", self.output.report.to_string());
        if let Some(leading) = &self.output.leading {
            out.word("leading", leading);
        }
        out.text
    }

    /// The same for a file in `directory`: files of a mesh and of tables that the case names by a relative path are named
    /// relative to it, so that all can be moved together.
    pub fn to_toml_in(&self, directory: &Path) -> String {
        let mut case = self.clone();
        if let MeshSource::File(path) = &mut case.mesh.source
            && self.record.relative_mesh
            && let Some(relative) = relative(path, directory)
        {
            *path = relative;
        }
        case.to_toml_with(|table| {
            let moves = table.relative.then(|| relative(&table.path, directory)).flatten();
            moves.as_ref().unwrap_or(&table.path).display().to_string()
        })
    }

    fn write_mesh(&self, out: &mut Lines) {
        out.table("mesh");
        match &self.mesh.source {
            // The mesh of a program: give it one to read this.
            MeshSource::Own(_) => out.key("generator", string(OWN)),
            MeshSource::File(path) => {
                out.word("file", &path.to_string_lossy());
                out.key("scale", number(self.mesh.scale));
            }
            generator => out.variant("generator", &GENERATORS, generator),
        }
        if let MeshSource::Box { lower, upper, cells } = &self.mesh.source {
            out.key("lower", numbers(lower));
            out.key("upper", numbers(upper));
            out.key("cells", format!("{cells:?}"));
        }
        if let MeshSource::Annulus { radii, cells } = &self.mesh.source {
            out.key("radii", numbers(radii));
            out.key("cells", format!("{cells:?}"));
        }
        if let MeshSource::Tube { length, radii, cells, axis } = &self.mesh.source {
            out.key("length", number(*length));
            out.key("radii", numbers(radii));
            out.key("cells", format!("{cells:?}"));
            if !axis.is_empty() {
                out.key("axis", expressions(axis));
            }
        }
        if let Some(Extrude { depth, layers, grading }) = self.mesh.extrude {
            out.key("extrude.depth", number(depth));
            out.key("extrude.layers", layers.to_string());
            out.key("extrude.grading", grading.to_string());
        }
        if let Some(WallSpec { surface, thickness, layers }) = &self.mesh.wall {
            out.key("wall.surface", names(surface));
            out.key("wall.thickness", expression(thickness));
            out.key("wall.layers", layers.to_string());
        }
        out.choice("coordinates", &COORDINATES, &self.mesh.coordinates);
        out.key("refine", self.mesh.refine.to_string());
        out.key("grading", self.mesh.grading.to_string());
        if !self.mesh.leave_out.is_empty() {
            out.key("leave-out", names(&self.mesh.leave_out));
        }
        if !self.mesh.region.is_empty() {
            out.table("mesh.region");
            for (name, inside) in &self.mesh.region {
                out.key(&key::quote(name), expression(inside));
            }
        }
        out.table("space");
        out.word("velocity", self.space.velocity.name());
        out.word("pressure", self.space.pressure.name());
        out.key("quadrature", self.space.quadrature.to_string());
    }

    /// Keys that matter only: others would be refused when read again.
    fn write_stabilization(&self, out: &mut Lines) {
        let how = &self.stabilization;
        if self.fluids.is_empty() {
            return;
        }
        out.table("stabilization");
        out.choice("pressure", &PRESSURE_TERMS, &how.pressure);
        out.choice("transport", &TRANSPORT_TERMS, &how.transport);
        if how.pressure != PressureTerm::None {
            out.key("alpha", number(how.alpha));
            out.key("directional", how.directional.to_string());
        }
        if how.transport != TransportTerm::None {
            out.key("delta", number(how.delta));
        }
        if how.projects() {
            out.choice("projection", &PROJECTIONS, &how.projection);
        }
        if how.acts() {
            out.choice("map", &MAPPINGS, &how.map);
        }
    }

    fn write_bodies(&self, out: &mut Lines) {
        self.fluids.iter().for_each(|fluid| fluid.write(out));
        self.solids.iter().for_each(|solid| solid.write(out));
        out.table("motion");
        out.choice("model", &MOTIONS, &self.motion.model);
        out.key("poisson", number(self.motion.poisson));
        if let Some(offset) = self.motion.offset {
            out.key("offset", number(offset));
        }
        out.key("exponent", number(self.motion.exponent));
        if let Some(scale) = self.motion.scale {
            out.key("scale", number(scale));
        }
        if self.motion.model == MotionModel::JacobianStiffened {
            out.choice("jacobian", &STIFFENING, &self.motion.lagged);
        }
        if self.motion.hinged || self.motion.model == MotionModel::Biharmonic {
            out.choice("outer", &OUTER, &self.motion.hinged);
        }
        out.choice("walls", &WALLS, &self.motion.walls);
    }

    fn write_time(&self, out: &mut Lines) {
        out.table("time");
        let Some(time) = &self.time else {
            out.choice("scheme", &SCHEMES, &None);
            return out.key("end", number(self.at_time));
        };
        out.word("scheme", time.scheme.name());
        match time.scheme {
            Scheme::Theta { theta } => out.key("theta", number(theta)),
            Scheme::ShiftedCrankNicolson { shift } => out.key("shift", number(shift)),
            Scheme::Rannacher { steps, interval } => {
                out.key("rannacher-steps", steps.to_string());
                out.key("rannacher-interval", number(interval));
            }
            _ => {}
        }
        if !time.scheme.has_own_domain_motion() {
            out.choice("domain-motion", &DOMAIN_MOTIONS, &time.domain_motion);
        }
        out.key("step", expression(&time.step));
        out.key("start", number(time.start));
        out.key("end", number(time.end));
        out.key("max-halvings", time.max_halvings.to_string());
        if let Some(adaptive) = &time.adaptive {
            out.table("time.adaptive");
            out.key("tolerance", number(adaptive.tolerance));
            out.key("min-step", number(adaptive.min_step));
            out.key("max-step", number(adaptive.max_step));
            out.key("safety", number(adaptive.safety));
        }
    }

    fn write_initial(&self, out: &mut Lines) {
        let Some(initial) = &self.initial else { return };
        out.table("initial");
        match initial {
            Initial::From(directory) => out.key("from", string(&directory.to_string_lossy())),
            Initial::Fields { velocity, displacement } => {
                for (key, pair) in [("velocity", velocity), ("displacement", displacement)] {
                    pair.iter().for_each(|pair| out.key(key, expressions(pair)));
                }
            }
            Initial::Static => out.key("static", "true"),
        }
    }

    fn write_solvers(&self, out: &mut Lines) {
        let newton = &self.newton;
        out.table("newton");
        out.choice("linearization", &LINEARIZATIONS, &newton.linearization);
        out.variant("jacobian", &TANGENTS, &newton.jacobian);
        if let Tangent::Difference(difference) = newton.jacobian {
            out.choice("difference", &DIFFERENCES, &difference.stencil);
            out.key("epsilon", number(difference.epsilon));
        }
        if let Some(rate_max) = newton.settings.rate_max {
            out.key("rate-max", number(rate_max));
        }
        out.key("secants", newton.settings.secants.to_string());
        out.key("tolerance", number(newton.settings.tolerance));
        if let Some(floor) = newton.settings.floor {
            out.key("floor", number(floor));
        }
        out.key("max-steps", newton.settings.max_steps.to_string());
        out.choice("start", &STARTS, &newton.extrapolate);
        out.key("line-search", newton.settings.line_search.to_string());
        out.table("linear");
        out.choice("engine", &ENGINES, &self.linear.engine);
        out.choice("solver", &SOLVERS, &self.linear.solver);
        out.choice("precision", &PRECISIONS, &self.linear.precision);
        out.variant("krylov", &KRYLOV, &self.linear.krylov);
        if let Some(krylov) = &self.linear.krylov {
            out.key("krylov-tolerance", number(krylov.tolerance));
            out.key("krylov-size", krylov.size.to_string());
        }
        out.key("refinement", self.linear.refinement.to_string());
        if self.linear.engine == Engine::Petsc {
            out.table("linear.petsc");
            out.key("options", string(&self.linear.petsc));
        }
    }
}

/// The path of `file` as seen from `directory`; `None` if they have no folder in common but the root.
fn relative(file: &Path, directory: &Path) -> Option<PathBuf> {
    let name = file.file_name()?;
    let folder = file.parent()?.canonicalize().ok()?;
    let directory = directory.canonicalize().ok()?;
    let (to, from): (Vec<_>, Vec<_>) = (folder.components().collect(), directory.components().collect());
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let named = to[..common].iter().any(|part| matches!(part, Component::Normal(_)));
    let up = from[common..].iter().map(|_| Component::ParentDir);
    named.then(|| up.chain(to[common..].iter().copied()).collect::<PathBuf>().join(name))
}

fn write_condition(out: &mut Lines, condition: &Condition) {
    out.word("condition", condition.name());
    for (name, datum) in
        condition.clone().data_mut().into_iter().filter(|(name, _)| condition.has_effect(name))
    {
        match datum {
            Datum::Vector(vector) => out.key(name, expressions(vector)),
            Datum::Partial(vector) => {
                let text = |e: &Option<Expression>| e.as_ref().map_or_else(|| string("free"), expression);
                out.key(name, format!("[{}]", vector.iter().map(text).collect::<Vec<_>>().join(", ")));
            }
            Datum::Scalar(one) => out.key(name, expression(one)),
            Datum::Name(of_boundary) => out.key(name, string(of_boundary)),
            Datum::Number(value) => out.key(name, number(*value)),
            Datum::Series(list) => {
                let list: Vec<String> = list.iter().map(|pair| numbers(pair)).collect();
                out.key(name, format!("[{}]", list.join(", ")));
            }
            Datum::Profile(profile) => out.choice(name, &PROFILES, profile),
            Datum::Word(choices, value) => out.word(name, name_of(choices, value)),
        }
    }
}

/// An array of strings.
fn names(list: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    format!("[{}]", list.into_iter().map(|name| string(name.as_ref())).collect::<Vec<_>>().join(", "))
}
