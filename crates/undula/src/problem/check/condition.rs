//! The tables `[boundary.*]` and `[functional.*]`.

use super::is_name;
use crate::output::history::COLUMNS;
use crate::problem::case::{Condition, EnergyKind, FunctionalSpec, SolidLaw};
use crate::problem::error::quoted;
use crate::problem::read::{ANY, POSITIVE, Section};
use std::collections::{BTreeMap, BTreeSet};

#[derive(Copy, Clone, PartialEq)]
enum Kind {
    Velocity,
    NoSlip,
    DoNothing,
    TractionFree,
    Clamped,
}

/// Conditions by name, and the names of outlets with the directional term.
pub(super) fn boundary(mut all: Section<'_, '_>) -> (BTreeMap<String, Condition>, BTreeSet<String>) {
    let (mut boundary, mut directional) = (BTreeMap::new(), BTreeSet::new());
    for name in all.keys() {
        let mut s = all.section(&name);
        if name == "interface" {
            all.wrong(
                &name,
                "nothing can be imposed on the interface between fluid and solid; remove this table",
            );
            continue;
        }
        let kinds = [
            ("velocity", Kind::Velocity),
            ("no-slip", Kind::NoSlip),
            ("do-nothing", Kind::DoNothing),
            ("traction-free", Kind::TractionFree),
            ("clamped", Kind::Clamped),
        ];
        let kind =
            s.choice("condition", &kinds, &["sliding", "pressure", "traction", "periodic", "symmetry"]);
        let velocity = s.expressions("velocity");
        if !s.has("condition") {
            s.missing("condition", "one of `velocity`, `no-slip`, `do-nothing`, `traction-free`, `clamped`");
        }
        if kind == Some(Kind::Velocity) && !s.has("velocity") {
            s.missing("velocity", "two expressions [m/s], as velocity = [\"1.5*y\", \"0\"]");
        } else if kind.is_some_and(|k| k != Kind::Velocity) && s.has("velocity") {
            let key = s.dotted("velocity");
            let note = format!("{key} has no effect: the condition is not `velocity`");
            s.checker.notes.borrow_mut().push(note);
        }
        let against = s.choice("backflow", &[("none", false), ("directional", true)], &[]);
        let outlet = matches!(kind, Some(Kind::DoNothing | Kind::TractionFree) | None);
        if against == Some(true) && outlet {
            directional.insert(name.clone());
        } else if against == Some(true) {
            let note = format!(
                "boundary.{name}.backflow has no effect: the condition is neither `do-nothing` nor `traction-free`"
            );
            s.checker.notes.borrow_mut().push(note);
        }
        s.finish();
        let condition = match kind {
            Some(Kind::Velocity) => Condition::Velocity(velocity.unwrap_or_default()),
            Some(Kind::DoNothing) => Condition::DoNothing,
            Some(Kind::TractionFree) => Condition::TractionFree,
            Some(Kind::Clamped) => Condition::Clamped,
            Some(Kind::NoSlip) | None => Condition::NoSlip,
        };
        boundary.insert(name, condition);
    }
    (boundary, directional)
}

#[derive(Copy, Clone)]
enum Functional {
    Force,
    Displacement,
    PressureDifference,
    Energy,
    Rotation,
}

/// The functionals that have a meaning for the bodies that are there, and the names of all.
pub(super) fn functional(
    mut all: Section<'_, '_>,
    fluid: bool,
    solid: Option<SolidLaw>,
) -> (Vec<(String, FunctionalSpec)>, Vec<String>) {
    let mut functionals = Vec::new();
    let names = all.keys();
    for name in &names {
        let mut s = all.section(name);
        if !is_name(name) || COLUMNS.contains(&name.as_str()) {
            let others = quoted(COLUMNS);
            all.wrong(
                name,
                format!(
                    "expected a name of letters, digits, `-` and `_`; {others} are other columns of history.csv"
                ),
            );
        }
        let kinds = [
            ("force", Functional::Force),
            ("displacement", Functional::Displacement),
            ("pressure-difference", Functional::PressureDifference),
            ("energy", Functional::Energy),
            ("rotation", Functional::Rotation),
        ];
        let Some(kind) = s.choice("kind", &kinds, &["flux", "pressure", "velocity"]) else {
            if !s.has("kind") {
                s.missing(
                    "kind",
                    "one of `force`, `displacement`, `pressure-difference`, `energy`, `rotation`",
                );
            }
            continue;
        };
        let spec = match kind {
            Functional::Force => force(&mut s),
            Functional::Displacement => FunctionalSpec::Displacement {
                point: required_point(&mut s, "point"),
                component: component(&mut s),
            },
            Functional::PressureDifference => FunctionalSpec::PressureDifference {
                a: required_point(&mut s, "a"),
                b: required_point(&mut s, "b"),
            },
            Functional::Energy => FunctionalSpec::Energy(energy(&mut s)),
            Functional::Rotation => FunctionalSpec::Rotation,
        };
        s.finish();
        let needs_fluid = match &spec {
            FunctionalSpec::Force { .. } => true,
            FunctionalSpec::PressureDifference { .. } => !solid.is_some_and(SolidLaw::is_incompressible),
            FunctionalSpec::Energy(kind) => {
                matches!(kind, EnergyKind::FluidKinetic | EnergyKind::Dissipation)
            }
            FunctionalSpec::Displacement { .. } | FunctionalSpec::Rotation => false,
        };
        if if needs_fluid { fluid } else { solid.is_some() } {
            functionals.push((name.clone(), spec));
        } else {
            let body = if needs_fluid { "fluid" } else { "solid" };
            let note = format!("functional.{name} is left out: there is no [{body}]");
            all.checker.notes.borrow_mut().push(note);
        }
    }
    (functionals, names)
}

fn force(s: &mut Section<'_, '_>) -> FunctionalSpec {
    let on = s.strings("on");
    if !s.has("on") {
        s.missing("on", "the boundaries, such as on = [\"cylinder\", \"interface\"]");
    }
    let method = s.choice("method", &[("residual", false), ("surface-integral", true)], &[]);
    FunctionalSpec::Force {
        on: on.unwrap_or_default(),
        component: component(s),
        surface_integral: method.unwrap_or(false),
        coefficient: s.pair("coefficient", POSITIVE),
    }
}

fn component(s: &mut Section<'_, '_>) -> usize {
    let component = s.choice("component", &[("x", 0), ("y", 1)], &[]);
    if !s.has("component") {
        s.missing("component", "\"x\" or \"y\"");
    }
    component.unwrap_or(0)
}

fn required_point(s: &mut Section<'_, '_>, key: &str) -> [f64; 2] {
    let point = s.pair(key, ANY);
    if !s.has(key) {
        s.missing(key, "a point of the reference domain [m], such as [0.6, 0.2]");
    }
    point.unwrap_or_default()
}

fn energy(s: &mut Section<'_, '_>) -> EnergyKind {
    let terms = [
        ("fluid-kinetic", EnergyKind::FluidKinetic),
        ("solid-kinetic", EnergyKind::SolidKinetic),
        ("elastic", EnergyKind::Elastic),
        ("dissipation", EnergyKind::Dissipation),
    ];
    let term = s.choice("term", &terms, &[]);
    if !s.has("term") {
        s.missing("term", "one of `fluid-kinetic`, `solid-kinetic`, `elastic`, `dissipation`");
    }
    term.unwrap_or(EnergyKind::FluidKinetic)
}
