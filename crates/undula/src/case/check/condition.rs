//! The tables `[boundary.*]` and `[functional.*]`.

use super::is_name;
use crate::case::choices::BACKFLOW;
use crate::case::conditions::{CONDITIONS, Condition, DATA};
use crate::case::error::{quoted, suggestion};
use crate::case::functionals::{FUNCTIONALS, FunctionalSpec};
use crate::case::read::Section;
use crate::case::schema::{FluidSpec, SolidSpec};
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
    fluid: Option<&FluidSpec>,
    solid: Option<&SolidSpec>,
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
        let Some(spec) = s.choice("kind", &FUNCTIONALS, &[]) else { continue };
        let spec = spec.read(&mut s);
        refuse_region(&s, &spec, fluid, solid);
        s.finish();
        let needs_fluid = spec.needs_fluid(solid.map(|s| s.law));
        if needs_fluid.is_none_or(|fluids| if fluids { fluid.is_some() } else { solid.is_some() }) {
            functionals.push((name.clone(), spec));
        } else {
            let body = if needs_fluid == Some(true) { "fluid" } else { "solid" };
            let note = format!("functional.{name} is left out: there is no [{body}]");
            all.checker.notes.borrow_mut().push(note);
        }
    }
    (functionals, names)
}

/// A region that no body fills, or one without a pressure that is asked for. Without one of the bodies its region is
/// not known; [`crate::setup::fit`] compares it with the mesh.
fn refuse_region(
    s: &Section<'_, '_>,
    spec: &FunctionalSpec,
    fluid: Option<&FluidSpec>,
    solid: Option<&SolidSpec>,
) {
    let Some(region) = spec.region().filter(|region| !region.is_empty()) else { return };
    let in_solid = solid.filter(|solid| solid.region == region);
    let bodies = [fluid.map(|f| f.region.as_str()), solid.map(|s| s.region.as_str())];
    if let [Some(one), Some(two)] = bodies
        && ![one, two].contains(&region)
    {
        s.wrong("region", format!("no body fills this region{}", suggestion(region, [one, two].into_iter())));
    }
    if matches!(spec, FunctionalSpec::Pressure(_)) && in_solid.is_some_and(|s| !s.law.is_incompressible()) {
        let message = "a compressible solid has no pressure; `stress` has its components";
        s.wrong("region", message);
    }
}
