//! The tables `[boundary.*]` and `[functional.*]`.

use super::is_name;
use crate::case::choices::BACKFLOW;
use crate::case::error::quoted;
use crate::case::functionals::{FUNCTIONALS, FunctionalSpec};
use crate::case::read::Section;
use crate::case::schema::{CONDITIONS, Condition, SolidLaw};
use crate::mesh::INTERFACE;
use crate::output::history::COLUMNS;
use std::collections::{BTreeMap, BTreeSet};

/// Conditions by name, and the names of outlets with the directional term.
pub(super) fn boundary(mut all: Section<'_, '_>) -> (BTreeMap<String, Condition>, BTreeSet<String>) {
    let (mut boundary, mut directional) = (BTreeMap::new(), BTreeSet::new());
    for name in all.keys() {
        let mut s = all.section(&name);
        if name == INTERFACE {
            all.wrong(
                &name,
                "nothing can be imposed on the interface between fluid and solid; remove this table",
            );
            continue;
        }
        let later = ["sliding", "pressure", "traction", "periodic", "symmetry"];
        let condition = s.choice("condition", &CONDITIONS, &later);
        let velocity = s.expressions("velocity");
        s.require_choice("condition", &CONDITIONS);
        let takes_velocity = matches!(condition, Some(Condition::Velocity(_)));
        if takes_velocity && !s.has("velocity") {
            s.missing("velocity", "two expressions [m/s], as velocity = [\"1.5*y\", \"0\"]");
        } else if condition.is_some() && !takes_velocity && s.has("velocity") {
            let key = s.dotted("velocity");
            let note = format!("{key} has no effect: the condition is not `velocity`");
            s.checker.notes.borrow_mut().push(note);
        }
        let against = s.choice("backflow", &BACKFLOW, &[]);
        let outlet = matches!(condition, Some(Condition::DoNothing | Condition::TractionFree) | None);
        if against == Some(true) && outlet {
            directional.insert(name.clone());
        } else if against == Some(true) {
            let note = format!(
                "boundary.{name}.backflow has no effect: the condition is neither `do-nothing` nor `traction-free`"
            );
            s.checker.notes.borrow_mut().push(note);
        }
        s.finish();
        let condition = match condition {
            Some(Condition::Velocity(_)) => Condition::Velocity(velocity.unwrap_or_default()),
            condition => condition.unwrap_or(Condition::NoSlip),
        };
        boundary.insert(name, condition);
    }
    (boundary, directional)
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
        s.require_choice("kind", &FUNCTIONALS);
        let Some(spec) = s.choice("kind", &FUNCTIONALS, &["flux", "pressure", "velocity"]) else { continue };
        let spec = spec.read(&mut s);
        s.finish();
        let needs_fluid = spec.needs_fluid(solid);
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
