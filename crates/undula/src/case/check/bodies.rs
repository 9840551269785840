//! The tables of fluids and solids: `[solid]` for one, `[solid.NAME]` for each of several; and what bodies may not be.

use super::body;
use crate::case::Initial;
use crate::case::error::quoted;
use crate::case::key::{NAME, quote};
use crate::case::keys;
use crate::case::raw::Origin;
use crate::case::read::Section;
use crate::case::schema::{FluidSpec, SolidSpec, SpaceSpec};
use crate::physics::{Reference, Stabilization};
use std::collections::BTreeMap;

/// The bodies of one `kind`, each read by `body`, in the order of the file.
pub(super) fn read<'c, 'd, T>(
    root: &mut Section<'c, 'd>,
    kind: &str,
    body: impl Fn(Section<'c, 'd>, Option<String>, Vec<String>) -> T,
) -> Vec<T> {
    if root.is_array_of_tables(kind) {
        let _ = root.item(kind);
        root.wrong(kind, format!("expected tables with names: write [{kind}.NAME] for [[{kind}]]"));
        return vec![];
    }
    let mut whole = root.section(kind);
    let own: Vec<&str> = keys::names_in(kind).into_iter().filter(|name| *name != NAME).collect();
    let (tables, values): (Vec<String>, Vec<String>) =
        whole.keys().into_iter().partition(|key| whole.is_table(key) && !own.contains(&key.as_str()));
    if tables.is_empty() {
        let regions = regions(&mut whole, kind);
        return if whole.is_present() { vec![body(whole, None, regions)] } else { vec![] };
    }
    let example = format!("{kind}.{}", quote(&tables[0]));
    for key in &values {
        whole.wrong(
            key,
            format!("[{kind}] has tables for each body: it belongs into one of them, as [{example}]"),
        );
    }
    for name in tables.iter().filter(|name| !body::names_something(name)) {
        whole.wrong(name, body::NAME);
    }
    let of_table = |name: String| {
        let mut s = whole.section(&name);
        let regions = regions(&mut s, &name);
        body(s, Some(name), regions)
    };
    tables.into_iter().map(of_table).collect()
}

/// The regions of a body; without them the one that is called like its table.
fn regions(s: &mut Section<'_, '_>, default: &str) -> Vec<String> {
    let regions = s.names("region", "[\"flap\", \"base\"]", 1).unwrap_or_else(|| vec![default.into()]);
    if !regions.iter().all(|region| body::names_something(region)) {
        s.wrong("region", body::NAME);
    }
    regions
}

/// The table of a body.
pub(super) fn section<'c, 'd>(root: &mut Section<'c, 'd>, kind: &str, name: Option<&str>) -> Section<'c, 'd> {
    let mut whole = root.section(kind);
    match name {
        Some(name) => whole.section(name),
        None => whole,
    }
}

/// Solids whose elements are not stable, a case without bodies, regions of two bodies, and what is for one fluid alone.
pub(super) fn refuse(
    root: &mut Section<'_, '_>,
    fluids: &[FluidSpec],
    solids: &[SolidSpec],
    space: &SpaceSpec,
    how: &Stabilization,
) {
    for solid in solids {
        body::refuse_unstable_solid(&section(root, "solid", solid.name.as_deref()), solid, space);
    }
    if fluids.is_empty() && solids.is_empty() && !root.has("fluid") && !root.has("solid") {
        let message = "the case has neither [fluid] nor [solid]";
        root.checker.error(&Origin::File(0..0), "", None, message.into());
    }
    if fluids.len() > 1 && how.acts() {
        let names: Vec<String> = fluids.iter().map(FluidSpec::table).collect();
        let message = format!(
            "stabilisation is for one fluid, and there are {}: take `off` with a stable pair such as Q2 with P1dc",
            quoted(names.iter().map(String::as_str))
        );
        root.checker.error(&root.section("stabilization").origin, "stabilization", None, message);
    }
    let fluids = fluids.iter().map(|fluid| ("fluid", &fluid.name, fluid.table(), &fluid.regions));
    let solids = solids.iter().map(|solid| ("solid", &solid.name, solid.table(), &solid.regions));
    let mut filled: BTreeMap<&str, String> = BTreeMap::new();
    for (kind, name, table, regions) in fluids.chain(solids) {
        for region in regions {
            let Some(other) = filled.insert(region, table.clone()) else { continue };
            let message = match &*other {
                _ if other == table => format!("the region `{region}` is there twice"),
                "fluid" => format!("the fluid fills the region `{region}` already"),
                _ => format!("[{other}] fills the region `{region}` already"),
            };
            section(root, kind, name.as_deref()).wrong("region", message);
        }
    }
}

/// Prestress of a part of the solids, or where it has no sense.
pub(super) fn refuse_prestress(
    root: &mut Section<'_, '_>,
    solids: &[SolidSpec],
    in_time: bool,
    initial: Option<&Initial>,
) {
    let has = |solid: &&SolidSpec| solid.reference != Reference::Free;
    let Some(solid) = solids.iter().find(has) else { return };
    let table = section(root, "solid", solid.name.as_deref());
    if let Some(other) = solids.iter().find(|solid| !has(solid)) {
        let message = format!("expected `prestress` in all solids or in none; [{}] has none", other.table());
        table.wrong("prestress", message);
    }
    if !in_time {
        let message = "only for a case in time, with [time]: under the loads of the start u is 0";
        table.wrong("prestress", message);
    }
    match initial {
        Some(fields @ Initial::Fields { .. }) => {
            for (key, _) in fields.fields() {
                let key = key.trim_start_matches("initial.");
                let message = "with solid.prestress the start is the flow and the stress under the loads there, and u = 0";
                root.section("initial").wrong(key, message);
            }
        }
        Some(Initial::Static) => {
            let note = "initial.static has no effect: with solid.prestress the run starts in equilibrium";
            root.note(note);
        }
        None | Some(Initial::From(_)) => {}
    }
}
