//! A case as TOML with all defaults resolved.

use super::case::{
    Case, Condition, DomainMotion, EnergyKind, FunctionalSpec, JacobianKind, LinearSolverKind, Linearization,
    MeshSource, MotionModel, Precision, TimeScheme,
};
use super::check::stabilization::{PRESSURE, PROJECTION, TRANSPORT};
use super::expression::Expression;
use super::key;
use crate::physics::{PressureTerm, TransportTerm};
use crate::space::Walls;
use std::path::{Component, Path, PathBuf};

/// Shortest decimal that reads back as `x`, always with a point or exponent.
pub(super) fn number(x: f64) -> String {
    if x.is_nan() {
        return "nan".into();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf".into() } else { "-inf".into() };
    }
    let size = x.abs();
    if size != 0.0 && !(1e-3..1e7).contains(&size) {
        let text = format!("{x:e}");
        return if text.contains('.') { text } else { text.replace('e', ".0e") };
    }
    format!("{x:?}")
}

pub(super) fn string(s: &str) -> String {
    toml::Value::from(s).to_string()
}

fn expression(e: &Expression) -> String {
    match e.source().parse::<f64>() {
        Ok(x) => number(x),
        Err(_) => string(e.source()),
    }
}

fn expressions(pair: &[Expression; 2]) -> String {
    format!("[{}, {}]", expression(&pair[0]), expression(&pair[1]))
}

fn pair(x: &[f64; 2]) -> String {
    format!("[{}, {}]", number(x[0]), number(x[1]))
}

/// The name of `value` in a list of choices.
pub(crate) fn name<T: PartialEq>(choices: &[(&'static str, T)], value: T) -> &'static str {
    choices.iter().find(|(_, choice)| *choice == value).map_or("", |(name, _)| name)
}

/// What stands for parts that a program gives.
const OWN: &str = "own";

/// Lines of TOML.
struct Lines(String);

impl Lines {
    fn table(&mut self, name: &str) {
        self.0 += &format!("\n[{name}]\n");
    }

    fn key(&mut self, key: &str, value: impl AsRef<str>, comment: &str) {
        let space = if comment.is_empty() { "" } else { "  # " };
        self.0 += &format!("{key} = {}{space}{comment}\n", value.as_ref());
    }

    fn word(&mut self, key: &str, value: &str) {
        self.key(key, string(value), "");
    }
}

impl Case {
    /// The case as TOML, every default written out; it loads again to an equal case.
    pub fn to_toml(&self) -> String {
        let mut out = Lines(String::new());
        out.word("name", &self.name);
        out.word("title", &self.title);
        if let Some(reference) = &self.reference {
            out.key("reference", string(reference), "published results");
        }
        self.write_mesh(&mut out);
        self.write_stabilization(&mut out);
        self.write_bodies(&mut out);
        for (name, condition) in &self.boundary {
            out.table(&key::join("boundary", name));
            write_condition(&mut out, condition);
            if self.directional.contains(name) {
                out.word("backflow", "directional");
            }
        }
        self.write_time(&mut out);
        self.write_solvers(&mut out);
        for (name, functional) in &self.functional {
            out.table(&key::join("functional", name));
            write_functional(&mut out, functional);
        }
        out.table("output");
        out.key("fields-every", self.output.fields_every.to_string(), "steps; 0: only at the end");
        if let Some(interval) = self.output.fields_interval {
            out.key("fields-interval", number(interval), "s; steps end there");
        }
        out.word("mesh", if self.output.deformed { "deformed" } else { "reference" });
        out.word("cells", if self.output.curved { "curved" } else { "linear" });
        out.key("checkpoint-every", self.output.checkpoint_every.to_string(), "steps; 0: not by steps");
        out.key(
            "checkpoint-minutes",
            number(self.output.checkpoint_minutes),
            "by the clock on the wall; 0: not by time",
        );
        if let Some(leading) = &self.output.leading {
            out.word("leading", leading);
        }
        out.0
    }

    /// The same for a file in `directory`: a mesh file that the case names by a relative path is named relative to it,
    /// so that both can be moved together.
    pub fn to_toml_in(&self, directory: &Path) -> String {
        let mut case = self.clone();
        if let MeshSource::File(path) = &mut case.mesh.source
            && self.record.relative_mesh
            && let Some(relative) = relative(path, directory)
        {
            *path = relative;
        }
        case.to_toml()
    }

    fn write_mesh(&self, out: &mut Lines) {
        out.table("mesh");
        match &self.mesh.source {
            MeshSource::TurekHron => out.word("generator", "turek-hron"),
            MeshSource::SchaeferTurek => out.word("generator", "schaefer-turek"),
            MeshSource::Rotor => out.word("generator", "rotor"),
            MeshSource::Box { lower, upper, cells } => {
                out.word("generator", "box");
                out.key("lower", pair(lower), "m");
                out.key("upper", pair(upper), "m");
                out.key("cells", format!("{cells:?}"), "");
            }
            MeshSource::Own(_) => {
                out.key("generator", string(OWN), "the mesh of a program: give it one to read this")
            }
            MeshSource::File(path) => {
                out.word("file", &path.to_string_lossy());
                out.key("scale", number(self.mesh.scale), "m per unit of the file");
            }
        }
        out.key("refine", self.mesh.refine.to_string(), "uniform refinements");
        out.key("grading", self.mesh.grading.to_string(), "rings of half size at the corners");
        if !self.mesh.leave_out.is_empty() {
            let names: Vec<String> = self.mesh.leave_out.iter().map(|name| string(name)).collect();
            out.key("leave-out", format!("[{}]", names.join(", ")), "regions that are not computed on");
        }
        if !self.mesh.region.is_empty() {
            out.table("mesh.region");
            for (name, inside) in &self.mesh.region {
                out.key(&key::quote(name), expression(inside), "positive inside");
            }
        }
        out.table("space");
        out.word("velocity", self.space.velocity.name());
        out.word("pressure", self.space.pressure.name());
        out.key(
            "quadrature",
            self.space.quadrature.to_string(),
            "Gauss points per direction; exact to the same degree on triangles",
        );
    }

    /// Keys that matter only: others would be refused when read again.
    fn write_stabilization(&self, out: &mut Lines) {
        let how = &self.stabilization;
        if self.fluid.is_none() {
            return;
        }
        out.table("stabilization");
        out.word("pressure", name(&PRESSURE, how.pressure));
        out.word("transport", name(&TRANSPORT, how.transport));
        if how.pressure != PressureTerm::None {
            out.key("alpha", number(how.alpha), "");
            out.key("directional", how.directional.to_string(), "axes of a cell apart");
        }
        if how.transport != TransportTerm::None {
            out.key("delta", number(how.delta), "");
        }
        if how.projects() {
            out.word("projection", name(&PROJECTION, how.projection));
        }
    }

    fn write_bodies(&self, out: &mut Lines) {
        if let Some(fluid) = &self.fluid {
            out.table("fluid");
            out.word("region", &fluid.region);
            out.key("density", number(fluid.density), "kg/m³");
            out.key("kinematic-viscosity", number(fluid.kinematic_viscosity), "m²/s");
            out.key("body-force", expressions(&fluid.body_force), "m/s²");
            out.word("body-force-at", if fluid.force_at_current { "current" } else { "reference" });
        }
        if let Some(solid) = &self.solid {
            out.table("solid");
            out.word("region", &solid.region);
            match solid.own {
                Some(_) => {
                    out.key("law", string(OWN), "the stored energy of a program: give one to read this")
                }
                None => out.word("law", solid.law.name()),
            }
            out.key("density", number(solid.density), "kg/m³");
            out.key("mu", number(solid.mu), "Pa");
            if solid.law.is_mooney_rivlin() {
                out.key("c2", number(solid.c2), "Pa, c1 = mu/2 - c2");
            }
            if !solid.law.is_incompressible() {
                out.key("lambda", number(solid.lambda), "Pa");
            } else if let Some(bulk) = solid.bulk {
                out.key("bulk", number(bulk), "Pa");
            }
            out.key("body-force", expressions(&solid.body_force), "m/s²");
        }
        out.table("motion");
        out.word(
            "model",
            match self.motion.model {
                MotionModel::Harmonic => "harmonic",
                MotionModel::StiffenedHarmonic => "stiffened-harmonic",
                MotionModel::PseudoElastic => "pseudo-elastic",
                MotionModel::JacobianStiffened => "jacobian-stiffened",
                MotionModel::Biharmonic => "biharmonic",
            },
        );
        out.key("poisson", number(self.motion.poisson), "");
        if let Some(offset) = self.motion.offset {
            out.key("offset", number(offset), "m");
        }
        out.key("exponent", number(self.motion.exponent), "");
        if let Some(scale) = self.motion.scale {
            out.key("scale", number(scale), "m");
        }
        if self.motion.model == MotionModel::JacobianStiffened {
            out.word("jacobian", if self.motion.lagged { "lagged" } else { "implicit" });
        }
        if self.motion.hinged || self.motion.model == MotionModel::Biharmonic {
            out.word("outer", if self.motion.hinged { "hinged" } else { "clamped" });
        }
        out.word("walls", if self.motion.walls == Walls::Fixed { "fixed" } else { "sliding" });
    }

    fn write_time(&self, out: &mut Lines) {
        out.table("time");
        let Some(time) = &self.time else {
            out.word("scheme", "stationary");
            return out.key("end", number(self.at_time), "s, the time expressions are taken at");
        };
        match time.scheme {
            TimeScheme::BackwardEuler => out.word("scheme", "backward-euler"),
            TimeScheme::CrankNicolson => out.word("scheme", "crank-nicolson"),
            TimeScheme::Theta { theta } => {
                out.word("scheme", "theta");
                out.key("theta", number(theta), "");
            }
            TimeScheme::ShiftedCrankNicolson { shift } => {
                out.word("scheme", "shifted-crank-nicolson");
                out.key("shift", number(shift), "1/s, theta = 1/2 + shift * step");
            }
            TimeScheme::Rannacher { steps, interval } => {
                out.word("scheme", "rannacher");
                out.key("rannacher-steps", steps.to_string(), "of backward Euler from the start of every");
                out.key("rannacher-interval", number(interval), "s");
            }
            TimeScheme::FractionalStepTheta => out.word("scheme", "fractional-step-theta"),
            TimeScheme::Galerkin => out.word("scheme", "cg1"),
            TimeScheme::Bdf2 => out.word("scheme", "bdf2"),
        }
        if !matches!(time.scheme, TimeScheme::Galerkin | TimeScheme::Bdf2) {
            out.word(
                "domain-motion",
                match time.domain_motion {
                    DomainMotion::Secant => "secant",
                    DomainMotion::Midpoint => "midpoint",
                    DomainMotion::Galerkin => "galerkin",
                },
            );
        }
        out.key("step", expression(&time.step), "s");
        out.key("start", number(time.start), "s");
        out.key("end", number(time.end), "s");
        out.key("max-halvings", time.max_halvings.to_string(), "of a failed step");
        if let Some(adaptive) = &time.adaptive {
            out.table("time.adaptive");
            out.key(
                "tolerance",
                number(adaptive.tolerance),
                "of v in a step, relative to the largest so far",
            );
            out.key("min-step", number(adaptive.min_step), "s");
            out.key("max-step", number(adaptive.max_step), "s");
            out.key("safety", number(adaptive.safety), "");
        }
    }

    fn write_solvers(&self, out: &mut Lines) {
        let newton = &self.newton;
        out.table("newton");
        out.word(
            "linearization",
            match newton.linearization {
                Linearization::Newton => "newton",
                Linearization::Reduced => "reduced",
                Linearization::FixedPoint => "fixed-point",
                Linearization::Condensed => "condensed",
            },
        );
        out.word(
            "jacobian",
            match newton.jacobian {
                JacobianKind::Automatic => "automatic",
                JacobianKind::Analytic => "analytic",
                JacobianKind::FiniteDifference { .. } => "finite-difference",
            },
        );
        if let JacobianKind::FiniteDifference { central, epsilon } = newton.jacobian {
            out.word("difference", if central { "central" } else { "one-sided" });
            out.key("epsilon", number(epsilon), "relative to the size of what moves");
        }
        if let Some(rate_max) = newton.rate_max {
            let meaning = "a Jacobian is kept while residuals shrink by this factor";
            out.key("rate-max", number(rate_max), meaning);
        }
        out.key("secants", newton.secants.to_string(), "pairs that improve corrections of a kept Jacobian");
        out.key("tolerance", number(newton.tolerance), "relative to the old solution");
        if let Some(floor) = newton.floor {
            out.key("floor", number(floor), "m/s");
        }
        out.key("max-steps", newton.max_steps.to_string(), "");
        out.word("start", if newton.extrapolate { "extrapolated" } else { "old" });
        out.key("line-search", newton.line_search.to_string(), "halvings of an update");
        out.table("linear");
        out.word(
            "solver",
            match self.linear.solver {
                LinearSolverKind::Multifrontal => "multifrontal",
                LinearSolverKind::Faer => "faer",
            },
        );
        out.word(
            "precision",
            match self.linear.precision {
                Precision::Single => "single",
                Precision::Double => "double",
            },
        );
        out.word("krylov", if self.linear.krylov.is_some() { "gmres" } else { "none" });
        if let Some(krylov) = &self.linear.krylov {
            out.key("krylov-tolerance", number(krylov.tolerance), "relative to the right-hand side");
            out.key("krylov-size", krylov.size.to_string(), "iterations at most, then factors are renewed");
        }
        out.key("refinement", self.linear.refinement.to_string(), "steps of iterative refinement");
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
    if let Condition::Velocity(velocity) = condition {
        out.key("velocity", expressions(velocity), "m/s");
    }
}

fn write_functional(out: &mut Lines, functional: &FunctionalSpec) {
    let axis = |component: usize| if component == 0 { "x" } else { "y" };
    match functional {
        FunctionalSpec::Force { on, component, surface_integral, coefficient } => {
            out.word("kind", "force");
            out.key("on", format!("[{}]", on.iter().map(|n| string(n)).collect::<Vec<_>>().join(", ")), "");
            out.word("component", axis(*component));
            out.word("method", if *surface_integral { "surface-integral" } else { "residual" });
            if let Some(scales) = coefficient {
                out.key("coefficient", pair(scales), "m/s, m: times 2/(density v² L)");
            }
        }
        FunctionalSpec::Displacement { point, component } => {
            out.word("kind", "displacement");
            out.key("point", pair(point), "m");
            out.word("component", axis(*component));
        }
        FunctionalSpec::PressureDifference { a, b } => {
            out.word("kind", "pressure-difference");
            out.key("a", pair(a), "m");
            out.key("b", pair(b), "m");
        }
        FunctionalSpec::Energy(kind) => {
            out.word("kind", "energy");
            out.word(
                "term",
                match kind {
                    EnergyKind::FluidKinetic => "fluid-kinetic",
                    EnergyKind::SolidKinetic => "solid-kinetic",
                    EnergyKind::Elastic => "elastic",
                    EnergyKind::Dissipation => "dissipation",
                },
            );
        }
        FunctionalSpec::Rotation => out.word("kind", "rotation"),
    }
}
