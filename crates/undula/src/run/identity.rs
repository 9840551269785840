//! What a run is, for a checkpoint: all that must not change when it goes on.

use crate::case::expression::Table;
use crate::case::{Case, Initial, MeshSource, OutputSpec};
use crate::functional::nodal::DEFAULT_FIELDS;
use crate::output::hash;
use std::collections::BTreeMap;
use std::path::PathBuf;
use toml::Value;

/// How many keys a message names.
const SHOWN: usize = 8;

/// The case without what may change when a run goes on: its name, its end, its output, how its equations are
/// solved, where the files of its mesh and its tables are, and the run from which it started. A table is named by its
/// file and its content.
pub(super) fn identity(case: &Case) -> String {
    without_choices(case).to_toml_with(|table| format!("{}#{}", file_name(table), table.hash))
}

/// The same without the content of tables.
fn without_contents(case: &Case) -> String {
    without_choices(case).to_toml_with(file_name)
}

fn file_name(table: &Table) -> String {
    table.path.file_name().unwrap_or_default().to_string_lossy().into()
}

/// Tables whose file has another content, by their keys.
fn other_contents(former: &Case, now: &Case) -> Vec<String> {
    let (former, now) = (former.tables(), now.tables());
    let is_other = |((key, old), (other, new)): &((String, &Table), (String, &Table))| {
        key == other && file_name(old) == file_name(new) && old.hash != new.hash
    };
    let told = |((key, table), _)| format!("{key}: the content of the file {} is another", file_name(table));
    let mut told: Vec<String> = former.into_iter().zip(now).filter(is_other).map(told).collect();
    told.dedup();
    told
}

fn without_choices(case: &Case) -> Case {
    let mut case = case.clone();
    (case.name, case.title, case.reference) = ("run".into(), String::new(), None);
    if matches!(case.initial, Some(Initial::From(_))) {
        case.initial = None;
    }
    if let Some(time) = &mut case.time {
        time.end = time.start + time.step.eval(&[0.0; 3], time.start);
    }
    if let MeshSource::File(path) = &mut case.mesh.source {
        *path = PathBuf::from("mesh.msh");
    }
    // A run that broke down can go on with a smaller rate.
    (case.newton, case.linear) = Default::default();
    case.output = OutputSpec {
        fields_every: 0,
        fields_interval: case.output.fields_interval,
        fields_times: Vec::new(),
        fields: DEFAULT_FIELDS.to_vec(),
        window: case.output.window,
        deformed: true,
        curved: false,
        checkpoint_every: 0,
        checkpoint_minutes: 0.0,
        report: true,
        leading: None,
    };
    case
}

/// [`hash`] of the mesh file of `case`. `None` without a file, or if it cannot be read.
pub(crate) fn mesh_hash(case: &Case) -> Option<String> {
    let MeshSource::File(path) = &case.mesh.source else { return None };
    Some(hash(&std::fs::read(path).ok()?))
}

/// What of `case` is not as it was in a run with the identity `former` and the mesh file `mesh`; empty if it can go on.
pub(super) fn changes(former: &str, mesh: Option<&str>, case: &Case) -> Vec<String> {
    // Written anew: keys that came later have their defaults, numbers are written alike.
    let earlier = Case::from_record(former).ok();
    let now = identity(case);
    let mut changes = vec![];
    let same = earlier.as_ref().is_some_and(|earlier| {
        let again = Case::from_record(&now);
        again.is_ok_and(|again| without_choices(earlier) == without_choices(&again))
    });
    if !same {
        changes = match &earlier {
            Some(earlier) => {
                let others = differences(&without_contents(earlier), &without_contents(case));
                [other_contents(earlier, case), others].concat()
            }
            // No case any more: its text has no defaults, so that keys which it does not name are not told.
            None => differences(former, &now).into_iter().filter(|told| !told.contains(WAS_ABSENT)).collect(),
        };
    }
    if let (Some(mesh), Some(hash)) = (mesh, mesh_hash(case))
        && mesh != hash
    {
        changes.push("mesh.file: the content of the file is another".into());
    }
    let more = changes.len().saturating_sub(SHOWN);
    if more > 0 {
        changes.truncate(SHOWN);
        changes.push(format!("and {more} more"));
    }
    changes
}

/// In place of a value that is not given.
const ABSENT: &str = "absent";
const WAS_ABSENT: &str = " was absent, now ";

/// The files of the tables of `case` with the [`hash`] of their content.
pub(crate) fn table_hashes(case: &Case) -> BTreeMap<String, String> {
    case.tables()
        .into_iter()
        .map(|(_, table)| (table.path.display().to_string(), table.hash.clone()))
        .collect()
}

/// Keys that differ between two cases in TOML, with both values.
fn differences(former: &str, now: &str) -> Vec<String> {
    let table = |text: &str| {
        let mut values = BTreeMap::new();
        flatten("", &text.parse().map_or(Value::Boolean(false), Value::Table), &mut values);
        values
    };
    let (former, now) = (table(former), table(now));
    let absent = || ABSENT.to_string();
    let keys: BTreeMap<&String, ()> = former.keys().chain(now.keys()).map(|key| (key, ())).collect();
    // The end is free, and what stands there belongs to the step.
    let changed = keys.into_keys().filter(|key| former.get(*key) != now.get(*key) && *key != "time.end");
    changed
        .map(|key| {
            let [old, new] = [&former, &now].map(|values| values.get(key).cloned().unwrap_or_else(absent));
            format!("{key} was {old}, now {new}")
        })
        .collect()
}

fn flatten(path: &str, value: &Value, values: &mut BTreeMap<String, String>) {
    let Value::Table(table) = value else {
        values.insert(path.to_string(), value.to_string());
        return;
    };
    for (key, value) in table {
        let plain = key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
        let key = if plain { key.clone() } else { format!("{key:?}") };
        let path = if path.is_empty() { key } else { format!("{path}.{key}") };
        flatten(&path, value, values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(sets: &[&str]) -> Case {
        Case::builtin("fsi3", &sets.iter().map(|s| s.to_string()).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_run_may_go_on_with_another_end_output_and_solver() {
        let former = identity(&case(&[]));
        let free = [
            "time.end=99",
            "output.fields-every=3",
            "output.checkpoint-minutes=1",
            "output.report=false",
            "name=other",
        ];
        let solvers = ["newton.tolerance=1e-9", "linear.solver=faer", "newton.rate-max=0.1"];
        assert_eq!(changes(&former, None, &case(&[&free[..], &solvers].concat())), [""; 0]);
        // The same written in another way.
        assert_eq!(changes(&former, None, &case(&["fluid.density=1e3", "time.step=0.50e-2"])), [""; 0]);
    }

    #[test]
    fn changed_keys_are_named_with_both_values() {
        let former = identity(&case(&[]));
        let found = changes(&former, None, &case(&["fluid.density=999", "output.fields-interval=0.5"]));
        assert_eq!(
            found,
            ["fluid.density was 1000.0, now 999.0", "output.fields-interval was absent, now 0.5"]
        );
        let found = changes(&former, None, &case(&["solid=none"]));
        assert!(found.len() == SHOWN + 1 && found[SHOWN].starts_with("and "), "{found:?}");
        // A text of another version that is no case any more.
        let found = changes("[fluid]\ndensity = 1000.0\nviscosity = 3\n", None, &case(&[]));
        assert!(found.iter().any(|f| f == "fluid.viscosity was 3, now absent"), "{found:?}");
    }
}
