//! The tables `[boundary.*]` and `[functional.*]`.

use super::is_name;
use crate::case::conditions::{CONDITIONS, Condition, DATA, Datum};
use crate::case::error::{did_you_mean, quoted, suggestion};
use crate::case::functionals::{FUNCTIONALS, FunctionalSpec};
use crate::case::key::Key;
use crate::case::profile::{PROFILE_KEYS, PROFILES, Profile};
use crate::case::raw::Origin;
use crate::case::read::{Checker, POSITIVE, Section, Vectors};
use crate::case::schema::{FluidSpec, SolidSpec};
use crate::mesh::INTERFACE;
use crate::output::history::COLUMNS;
use crate::space::{Against, BACKFLOW};
use std::collections::BTreeMap;

/// Conditions by name, and the terms of outlets against flow that comes in where they are not those of the condition.
pub(super) fn boundary(mut all: Section<'_, '_>) -> (BTreeMap<String, Condition>, BTreeMap<String, Against>) {
    let (mut boundary, mut backflow) = (BTreeMap::new(), BTreeMap::new());
    for name in all.keys() {
        let mut s = all.section(&name);
        if name == INTERFACE {
            all.wrong(
                &name,
                "nothing can be imposed on the interface between fluid and solid; remove this table",
            );
            continue;
        }
        let later = ["sliding"];
        let condition = s.choice("condition", &CONDITIONS, &later);
        let condition = read_data(&mut s, condition);
        match other_boundary(&s, &name, &all.keys()) {
            Some(message) => s.missing("condition", &message),
            None => s.require_choice("condition", &CONDITIONS),
        }
        let against = s.choice("backflow", &BACKFLOW, &[]);
        let outlet = condition.as_ref().is_none_or(Condition::is_natural);
        let default = condition.as_ref().map_or(Against::None, Condition::against);
        let given = against.filter(|against| *against != default);
        if let (Some(against), true) = (given, outlet) {
            backflow.insert(name.clone(), against);
        } else if given.is_some() {
            let why = match condition {
                Some(Condition::Periodic(_)) => "the flow goes on behind it",
                _ => "the velocity is given",
            };
            let note =
                format!("boundary.{name}.backflow has no effect: {why}, so that the boundary is no outlet");
            s.note(note);
        }
        s.finish();
        boundary.insert(name, condition.unwrap_or(Condition::NoSlip));
    }
    if matches!(all.checker.vectors.get(), Vectors::Extruded { .. }) {
        // The plane goes on behind them, unless one is the partner of the other.
        for [side, other] in [["front", "back"], ["back", "front"]] {
            let is_partner =
                matches!(boundary.get(other), Some(Condition::Periodic(with)) if with.as_str() == side);
            if !is_partner {
                boundary.entry(side.into()).or_insert(Condition::Symmetry);
            }
        }
    }
    partners(&mut boundary, &mut all);
    (boundary, backflow)
}

/// What is to be said of a table without a condition that `--set` has made, if its name is close to that of another one.
fn other_boundary(s: &Section<'_, '_>, name: &str, names: &[String]) -> Option<String> {
    let hint = did_you_mean(name, names.iter().map(String::as_str).filter(|other| *other != name));
    let is_new = matches!(s.origin, Origin::Set(_)) && !s.has("condition");
    (is_new && !hint.is_empty())
        .then(|| format!("the case has no boundary `{name}`{hint} A boundary of its own needs a condition"))
}

/// Two boundaries that are one name each other; one of the two tables may be left out.
fn partners(boundary: &mut BTreeMap<String, Condition>, all: &mut Section<'_, '_>) {
    for (name, condition) in boundary.clone() {
        let Condition::Periodic(with) = condition else { continue };
        let message = match boundary.get(&with) {
            // Told before.
            _ if with.is_empty() => continue,
            _ if with == name || with == INTERFACE => {
                "expected the name of another outer boundary, of which this one is a translation".to_string()
            }
            None => {
                boundary.insert(with, Condition::Periodic(name));
                continue;
            }
            Some(Condition::Periodic(back)) if *back == name || back.is_empty() => continue,
            Some(Condition::Periodic(back)) => {
                format!("`{with}` is one with `{back}`: expected two boundaries that name each other")
            }
            Some(other) => format!(
                "`{with}` has condition = `{}`: expected `periodic` with `{name}`, or no table of its own",
                other.name()
            ),
        };
        all.section(&name).wrong("with", message);
    }
}

/// The condition with its data. Data of other conditions have no effect.
fn read_data(s: &mut Section<'_, '_>, mut condition: Option<Condition>) -> Option<Condition> {
    let all = || DATA.iter().chain(&PROFILE_KEYS);
    let about = |name: &str| all().find(|key| last(key) == name);
    let required = format!("{}: required", condition.as_ref().map_or("", Condition::name));
    let womersley = s.is_word("profile", "womersley");
    if let Some(Condition::Flux { profile, .. }) = condition.as_mut().filter(|_| womersley) {
        *profile = Profile::Womersley;
    }
    let (mut taken, asked) = (vec![], condition.clone());
    for (name, datum) in condition.iter_mut().flat_map(Condition::data_mut) {
        taken.push(name);
        let has_effect = asked.as_ref().is_none_or(|condition| condition.has_effect(name));
        let of_profile = ["fourier", "period"].contains(&name);
        let needed = about(name).filter(|key| key.default.contains(&required) || of_profile);
        let needed = needed.filter(|_| has_effect && !s.has(name));
        if !has_effect && s.has(name) {
            let of =
                if of_profile { "is for profile = `womersley`" } else { "is not for profile = `womersley`" };
            let note = format!("{} has no effect: it {of}", s.dotted(name));
            s.note(note);
        }
        if let Some(key) = needed {
            let unit = s.checker.unit(key.unit);
            s.missing(name, &format!("{} [{unit}]", key.about));
        }
        read_datum(s, name, datum);
    }
    if let Some(condition) = &condition {
        check_lumped(s, condition);
        check_series(s, condition);
    }
    for name in all().map(last).filter(|name| !taken.contains(name)) {
        let others = CONDITIONS.iter().filter(|row| takes(&row.value, name));
        let mut all = others.clone().map(|row| row.value.clone()).collect::<Vec<_>>();
        let datum = all.iter_mut().flat_map(Condition::data_mut).find(|(own, _)| *own == name);
        datum.into_iter().for_each(|(name, datum)| read_datum(s, name, datum));
        if s.has(name) && condition.is_some() {
            let note =
                format!("{} has no effect: it is for {}", s.dotted(name), quoted(others.map(|row| row.name)));
            s.note(note);
        }
    }
    condition
}

/// Outlets with one pressure have numbers that are the same on all of them, and circuits take no negative ones.
fn check_lumped(s: &Section<'_, '_>, condition: &Condition) {
    let spring = matches!(condition, Condition::Spring { .. });
    let looked_at = condition.is_lumped() || condition.has_profile() || spring;
    for (name, data) in condition.data().into_iter().filter(|_| looked_at) {
        let number = data[0].constant_value();
        if data[0].depends_on_space() && !spring {
            s.wrong(name, "depends on x or y, and there is one pressure on all of the boundary: expected a function of t");
        } else if name == "initial" && data[0].depends_on_time() {
            s.wrong(name, "depends on t: expected the value at the start");
        } else if name == "distal" && s.has(name) && number.is_some_and(|x| x <= 0.0) {
            s.wrong(name, "expected a number above 0");
        } else if !["pressure", "initial", "flow-rate"].contains(&name) && number.is_some_and(|x| x < 0.0) {
            s.wrong(name, "expected a number, 0 or above");
        }
    }
}

/// What dashpots do in a stationary case.
pub(super) fn note_still(checker: &Checker<'_>, boundary: &BTreeMap<String, Condition>) {
    for (name, condition) in boundary {
        if let Condition::Spring { damping, .. } = condition
            && damping.constant_value() != Some(0.0)
        {
            let note = format!("boundary.{name}.damping has no effect: the case is stationary");
            checker.note(note);
        }
    }
}

/// The mean of a flow has no sine.
fn check_series(s: &Section<'_, '_>, condition: &Condition) {
    let Condition::Flux { fourier, profile: Profile::Womersley, .. } = condition else { return };
    if fourier.first().is_some_and(|[_, b]| *b != 0.0) {
        s.wrong("fourier", "the first pair is the mean a_0 of the flow: expected [a_0, 0] there");
    }
}

/// Reads one datum; it stays as it is if it is not given.
fn read_datum(s: &mut Section<'_, '_>, name: &str, datum: Datum<'_>) {
    match datum {
        Datum::Vector(vector) => *vector = s.expressions(name).unwrap_or_default(),
        Datum::Partial(vector) => *vector = s.components(name).unwrap_or_default(),
        Datum::Scalar(one) => *one = s.expression(name).unwrap_or_default(),
        Datum::Number(number) => *number = s.optional_number(name, POSITIVE).unwrap_or(*number),
        Datum::Series(list) => *list = s.series(name).unwrap_or_default(),
        Datum::Profile(profile) => *profile = s.choice(name, &PROFILES, &[]).unwrap_or(*profile),
        Datum::Name(name_of) => *name_of = s.string(name).unwrap_or_default(),
        Datum::Word(choices, value) => *value = s.choice(name, choices, &[]).unwrap_or(*value),
    }
}

/// The last part of a key of data.
fn last(key: &Key) -> &'static str {
    key.key.rsplit('.').next().unwrap_or_default()
}

/// Whether a condition has this datum.
fn takes(condition: &Condition, name: &str) -> bool {
    condition.clone().data_mut().iter().any(|(own, _)| *own == name)
}

/// The functionals that have a meaning for the bodies that are there, and the names of all.
pub(super) fn functional(
    mut all: Section<'_, '_>,
    fluids: &[FluidSpec],
    solids: &[SolidSpec],
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
        refuse_region(&s, &spec, fluids, solids);
        s.finish();
        let needs_fluid = spec.needs_fluid(solids.iter().any(|s| s.law.is_incompressible()));
        let is_there = |fluid: bool| if fluid { !fluids.is_empty() } else { !solids.is_empty() };
        if needs_fluid.is_none_or(is_there) {
            functionals.push((name.clone(), spec));
        } else {
            let body = if needs_fluid == Some(true) { "fluid" } else { "solid" };
            let note = format!("functional.{name} is left out: there is no [{body}]");
            all.note(note);
        }
    }
    (functionals, names)
}

/// A region that no body fills, or one without a pressure that is asked for. Without one of the bodies its region is
/// not known; [`crate::setup::fit`] compares it with the mesh.
fn refuse_region(s: &Section<'_, '_>, spec: &FunctionalSpec, fluids: &[FluidSpec], solids: &[SolidSpec]) {
    let Some(region) = spec.region().filter(|region| !region.is_empty()) else { return };
    let in_solid = solids.iter().find(|solid| solid.regions.iter().any(|other| other == region));
    let filled = fluids.iter().flat_map(|f| &f.regions).chain(solids.iter().flat_map(|s| &s.regions));
    let filled = filled.map(String::as_str);
    if !fluids.is_empty() && !solids.is_empty() && filled.clone().all(|other| other != region) {
        s.wrong("region", format!("no body fills this region{}", suggestion(region, filled)));
    }
    if matches!(spec, FunctionalSpec::Pressure(_)) && in_solid.is_some_and(|s| !s.law.is_incompressible()) {
        let message = "a compressible solid has no pressure; `stress` has its components";
        s.wrong("region", message);
    }
}
