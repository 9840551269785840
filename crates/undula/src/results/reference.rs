//! Published results of a case, and how computed ones compare.
//!
//! ```toml
//! case = "fsi3"
//!
//! [[reference.drag]]  # the first entry of a functional is the one to compare with
//! mean = 460.5
//! amplitude = 27.74
//! frequency = 10.93   # Hz
//! unit = "N/m"
//! source = "featflow 4+0, dt = 2.5e-4"
//! uncertainty = { mean = 0.01, amplitude = 0.05, frequency = 0.01 }  # relative
//! ```
//! A single entry may be `[reference.drag]`. Stationary cases give `value`; `min` and `max` are those
//! over the whole time.

use crate::case::Case;
use crate::case::builtin::builtin_case;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Published results of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct References {
    /// Name of the case.
    pub case: String,
    /// Results by functional, sorted by its name; the first of a functional is the one to compare with.
    pub results: BTreeMap<String, Vec<Published>>,
}

/// What one source says about one functional.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(from = "Entry")]
pub struct Published {
    /// Its numbers.
    pub numbers: Numbers,
    /// SI unit, empty for a coefficient.
    pub unit: String,
    /// Who, on which mesh, with which step.
    pub source: String,
    /// Relative uncertainty of each number as far as it is known.
    pub uncertainty: Numbers,
    /// What else must be known.
    pub note: String,
}

/// One table of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    value: Option<f64>,
    mean: Option<f64>,
    amplitude: Option<f64>,
    frequency: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    #[serde(default)]
    unit: String,
    source: String,
    #[serde(default)]
    uncertainty: Numbers,
    #[serde(default)]
    note: String,
}

impl From<Entry> for Published {
    fn from(entry: Entry) -> Self {
        let Entry { value, mean, amplitude, frequency, min, max, unit, source, uncertainty, note } = entry;
        Self {
            numbers: Numbers { value, mean, amplitude, frequency, min, max },
            unit,
            source,
            uncertainty,
            note,
        }
    }
}

/// The numbers a history is described by.
#[derive(Copy, Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Numbers {
    /// The stationary value, or that at the last time.
    pub value: Option<f64>,
    /// (max + min)/2 over the last period.
    pub mean: Option<f64>,
    /// (max − min)/2 over the last period.
    pub amplitude: Option<f64>,
    /// 1/period \[Hz\].
    pub frequency: Option<f64>,
    /// Least value of all times.
    pub min: Option<f64>,
    /// Greatest value of all times.
    pub max: Option<f64>,
}

impl Numbers {
    /// The numbers with their names.
    pub fn named(&self) -> [(&'static str, Option<f64>); 6] {
        [
            ("value", self.value),
            ("mean", self.mean),
            ("amplitude", self.amplitude),
            ("frequency", self.frequency),
            ("min", self.min),
            ("max", self.max),
        ]
    }
}

impl References {
    /// Reads a reference file.
    ///
    /// # Errors
    /// The parser's message, with line and column.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct File {
            case: String,
            reference: BTreeMap<String, toml::Value>,
        }
        let file: File = toml::from_str(text)?;
        let mut results = BTreeMap::new();
        for (name, value) in file.reference {
            let entries = match value {
                toml::Value::Array(entries) => entries,
                single => vec![single],
            };
            let published: Result<Vec<Published>, _> =
                entries.into_iter().map(toml::Value::try_into).collect();
            results.insert(name, published?);
        }
        Ok(Self { case: file.case, results })
    }

    /// The published results of the built-in case `name`; none for other cases.
    pub fn builtin(name: &str) -> Option<Self> {
        Self::from_toml(builtin_case(name)?.reference).ok()
    }
}

/// What published results may be set beside a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Beside {
    /// The case refers to none.
    Nothing,
    /// The case is not the one that it refers to: in these keys.
    Departs(&'static str, Vec<Departure>),
    /// These; functionals that are others than those of the case referred to are left out, see the keys.
    Results(References, Vec<Departure>),
}

/// A key that is not as in the case referred to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Departure {
    /// Dotted key, or a table such as `[solid]`.
    pub key: String,
    /// Its value (of a table nothing but that it is there); `None` if it is missing.
    pub value: Option<String>,
    /// That in the case referred to.
    pub original: Option<String>,
}

impl fmt::Display for Departure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let key = &self.key;
        match (&self.value, &self.original) {
            (Some(value), Some(original)) => write!(f, "{key} = {value} instead of {original}"),
            (Some(value), None) if !key.starts_with('[') => write!(f, "{key} = {value} is added"),
            (Some(_), None) => write!(f, "{key} is added"),
            (None, Some(original)) if !key.starts_with('[') => write!(f, "{key} = {original} is missing"),
            (None, _) => write!(f, "{key} is missing"),
        }
    }
}

impl Beside {
    /// The published results for `case`: those of the built-in case named by `reference`, as long as fluid, solid,
    /// boundaries and geometry are those of that case. How it is computed, from the mesh size to the motion of the
    /// mesh, does not matter.
    pub fn of(case: &Case) -> Beside {
        let Some(shipped) = case.reference.as_deref().and_then(builtin_case) else { return Beside::Nothing };
        let (Ok(original), Some(mut references)) =
            (Case::builtin(shipped.name, &[]), References::builtin(shipped.name))
        else {
            return Beside::Nothing;
        };
        let all = departures(case, &original);
        let (functionals, physics): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|departure| departure.functional().is_some());
        if !physics.is_empty() {
            return Beside::Departs(shipped.name, physics);
        }
        let others: Vec<&str> = functionals.iter().filter_map(Departure::functional).collect();
        let published = |name: &str| references.results.contains_key(name);
        let left_out =
            functionals.iter().filter(|d| d.functional().is_some_and(published)).cloned().collect();
        references.results.retain(|name, _| !others.contains(&name.as_str()));
        Beside::Results(references, left_out)
    }
}

impl Departure {
    /// The functional that it is about.
    fn functional(&self) -> Option<&str> {
        let name = self.key.trim_matches(['[', ']']).strip_prefix("functional.")?;
        Some(name.split('.').next().unwrap_or(name))
    }
}

/// Where `case` is another problem than `original`, or has another functional of the same name.
fn departures(case: &Case, original: &Case) -> Vec<Departure> {
    let (ours, theirs) = (keys(case), keys(original));
    let table = |key: &str| key.rsplit_once('.').map_or(String::new(), |(table, _)| table.to_string());
    let there = |keys: &BTreeMap<String, String>, name: &str| {
        keys.keys().any(|key| key.starts_with(name) && key[name.len()..].starts_with('.'))
    };
    let mut found: Vec<Departure> = vec![];
    for key in ours.keys().chain(theirs.keys()).collect::<BTreeSet<_>>() {
        let (value, original) = (ours.get(key), theirs.get(key));
        let name = table(key);
        let whole = [there(&ours, &name), there(&theirs, &name)];
        if name.starts_with("functional.") && whole != [true; 2] {
            // One of its own, or none: no other functional of the same name.
            continue;
        }
        let departure = if whole == [true; 2] {
            Departure { key: key.clone(), value: value.cloned(), original: original.cloned() }
        } else {
            let shown = |there: bool| there.then(String::new);
            Departure { key: format!("[{name}]"), value: shown(whole[0]), original: shown(whole[1]) }
        };
        if value != original && !found.contains(&departure) {
            found.push(departure);
        }
    }
    found
}

/// The keys that make the problem, and those of the functionals, by dotted name.
fn keys(case: &Case) -> BTreeMap<String, String> {
    let mut keys = BTreeMap::new();
    if let Ok(table) = case.to_toml().parse::<toml::Table>() {
        flatten("", &toml::Value::Table(table), &mut keys);
    }
    keys.retain(|key, _| {
        let numerical = ["mesh.refine", "mesh.grading"].contains(&key.as_str());
        let method = key.starts_with("functional.") && key.ends_with(".method");
        let counts = ["fluid.", "solid.", "boundary.", "mesh.", "functional."];
        !numerical && !method && counts.iter().any(|table| key.starts_with(table))
    });
    keys
}

fn flatten(path: &str, value: &toml::Value, into: &mut BTreeMap<String, String>) {
    let toml::Value::Table(table) = value else {
        // Spaces do not make another expression.
        into.insert(path.to_string(), value.to_string().replace(' ', ""));
        return;
    };
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        flatten(&path, value, into);
    }
}
