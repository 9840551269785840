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

use serde::Deserialize;
use std::collections::BTreeMap;

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
        Self::from_toml(super::builtin::builtin_case(name)?.reference).ok()
    }
}

/// What one run computed for one functional.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Computed {
    /// Its numbers; `value` is the last one.
    pub numbers: Numbers,
    /// Unit.
    pub unit: String,
}

/// The results of one run, as in `summary.json`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Name of the case.
    pub case: String,
    /// How it ended.
    pub status: String,
    /// Results by functional.
    pub functionals: BTreeMap<String, Computed>,
}

impl Run {
    /// Reads the text of `summary.json`.
    ///
    /// # Errors
    /// The parser's message.
    pub fn from_json(text: &str) -> Result<Self, serde_json::Error> {
        #[derive(Deserialize)]
        struct Item {
            last: Option<f64>,
            mean: Option<f64>,
            amplitude: Option<f64>,
            frequency: Option<f64>,
            min: Option<f64>,
            max: Option<f64>,
            unit: Option<String>,
        }
        #[derive(Deserialize)]
        struct Summary {
            #[serde(default)]
            status: String,
            case: String,
            functionals: BTreeMap<String, Item>,
        }
        let summary: Summary = serde_json::from_str(text)?;
        let computed = |item: Item| {
            let Item { last, mean, amplitude, frequency, min, max, unit } = item;
            let numbers = Numbers { value: last, mean, amplitude, frequency, min, max };
            Computed { numbers, unit: unit.unwrap_or_default() }
        };
        let functionals =
            summary.functionals.into_iter().map(|(name, item)| (name, computed(item))).collect();
        Ok(Self { case: summary.case, status: summary.status, functionals })
    }

    /// Fills in least and greatest values from the text of `history.csv`, a column per functional.
    pub fn add_history(&mut self, csv: &str) {
        let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
        let Some(header) = lines.next() else { return };
        let columns: Vec<&str> = header.split(',').map(str::trim).collect();
        for line in lines {
            for (column, cell) in columns.iter().zip(line.split(',')) {
                let (Some(computed), Ok(x)) = (self.functionals.get_mut(*column), cell.trim().parse::<f64>())
                else {
                    continue;
                };
                let numbers = &mut computed.numbers;
                numbers.min = Some(numbers.min.map_or(x, |old| old.min(x)));
                numbers.max = Some(numbers.max.map_or(x, |old| old.max(x)));
            }
        }
    }
}
