//! The tables `[boundary.*]` and `[functional.*]`.

use super::is_name;
use crate::case::choices::BACKFLOW;
use crate::case::conditions::{CONDITIONS, Condition, DATA};
use crate::case::error::quoted;
use crate::case::functionals::{FUNCTIONALS, FunctionalSpec};
use crate::case::read::Section;
use crate::case::schema::SolidLaw;
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
        let later = ["sliding", "pressure", "periodic", "symmetry"];
        let condition = s.choice("condition", &CONDITIONS, &later);
        let condition = read_data(&mut s, condition);
        s.require_choice("condition", &CONDITIONS);
        let against = s.choice("backflow", &BACKFLOW, &[]);
        let outlet = condition.as_ref().is_none_or(Condition::is_natural);
        if against == Some(true) && outlet {
            directional.insert(name.clone());
        } else if against == Some(true) {
            let note = format!(
                "boundary.{name}.backflow has no effect: the velocity is given, so that the boundary is no outlet"
            );
            s.checker.notes.borrow_mut().push(note);
        }
        s.finish();
        boundary.insert(name, condition.unwrap_or(Condition::NoSlip));
    }
    (boundary, directional)
}

/// The condition with its data. Data of other conditions have no effect.
fn read_data(s: &mut Section<'_, '_>, mut condition: Option<Condition>) -> Option<Condition> {
    for key in &DATA {
        let name = key.key.rsplit('.').next().unwrap_or_default();
        let given = s.expressions(name);
        let takes = condition.as_ref().is_some_and(|condition| condition.name() == name);
        if takes && !s.has(name) {
            s.missing(name, &format!("{} [{}]", key.about, key.unit));
        } else if condition.is_some() && !takes && s.has(name) {
            let note = format!("{} has no effect: the condition is not `{name}`", s.dotted(name));
            s.checker.notes.borrow_mut().push(note);
        }
        if let (true, Some(data)) = (takes, condition.as_mut().and_then(Condition::data_mut)) {
            *data = given.unwrap_or_default();
        }
    }
    condition
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
