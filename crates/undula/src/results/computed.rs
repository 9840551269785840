//! What a run left in its directory, read again.

use super::reference::Numbers;
use crate::case::Case;
use crate::functional::statistics::{Series, summarize, value_at};
use crate::output::directory::{CASE, HISTORY, SUMMARY};
use crate::output::history::COLUMNS;
use crate::output::{FunctionalSummary, History, OutputError, Summary};
use std::collections::BTreeMap;
use std::path::Path;

/// The results of one run.
#[derive(Clone, Debug, Default)]
pub struct Results {
    /// What the run is called: its directory.
    pub name: String,
    /// `summary.json`.
    pub summary: Summary,
    /// `history.csv`; empty without it.
    pub history: History,
    /// `case.toml`, see [`case_of`].
    pub case: Option<Case>,
}

/// The history of one functional.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Times to which its values belong \[s\].
    pub times: Vec<f64>,
    /// A value for every time.
    pub values: Vec<f64>,
}

/// What one run computed for one functional.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Computed {
    /// Its numbers; `value` is the last one.
    pub numbers: Numbers,
    /// Unit.
    pub unit: String,
}

impl Results {
    /// Those in `directory`.
    ///
    /// # Errors
    /// [`OutputError`] if the summary or the history cannot be read.
    pub fn read(directory: &Path) -> Result<Results, OutputError> {
        let summary = Summary::read(directory.join(SUMMARY))?;
        let history = directory.join(HISTORY);
        let history = if history.is_file() { History::read(history)? } else { History::default() };
        Ok(Results { name: directory.display().to_string(), summary, history, case: case_of(directory) })
    }

    /// The signal that `output.leading` names.
    pub fn leading(&self) -> Option<&str> {
        self.case.as_ref()?.output.leading.as_deref()
    }

    /// The histories of all functionals in the order of the columns; empty without a history.
    pub fn signals(&self) -> Vec<Signal> {
        let signal = |name: &String| {
            let unit = self.summary.functionals.get(name).map_or_else(String::new, |f| f.unit.clone());
            let at = if self.at_force_time(name, &unit) { "force_time" } else { "time" };
            let times = self.history.column(at).or_else(|| self.history.column("time"))?;
            Some(Signal { name: name.clone(), unit, times, values: self.history.column(name)? })
        };
        let functionals = self.history.columns.iter().filter(|name| !COLUMNS.contains(&name.as_str()));
        functionals.filter_map(signal).collect()
    }

    /// Whether a functional belongs to a time inside the step: the case says so, else its unit.
    fn at_force_time(&self, name: &str, unit: &str) -> bool {
        let spec = self.case.iter().flat_map(|case| &case.functional).find(|(n, _)| n == name);
        spec.map_or(unit.contains("N/m") || unit == "Pa", |(_, spec)| spec.at_force_time())
    }

    /// Whether there is one solution only, at no time.
    pub fn is_stationary(&self) -> bool {
        self.history.column("step").is_some_and(|steps| steps == [0.0])
    }

    /// The numbers of all functionals.
    pub fn computed(&self) -> BTreeMap<String, Computed> {
        let signals = self.signals();
        if signals.is_empty() {
            return self.summary.functionals.iter().map(|(name, f)| (name.clone(), of_summary(f))).collect();
        }
        numbers(&signals, self.leading())
    }
}

/// The case of the run in `directory`; `None` if it is missing or of another version of the program.
pub fn case_of(directory: &Path) -> Option<Case> {
    let text = std::fs::read_to_string(directory.join(CASE)).ok()?;
    Case::from_record(&text).ok()
}

fn of_summary(f: &FunctionalSummary) -> Computed {
    let value = Some(f.last).filter(|x| x.is_finite());
    let (mean, amplitude, frequency) = (f.mean, f.amplitude, f.frequency);
    let numbers = Numbers { value, mean, amplitude, frequency, min: None, max: None };
    Computed { numbers, unit: f.unit.clone() }
}

/// The numbers of `signals`, those over a period by the rule of [`crate::functional::statistics`].
pub fn numbers(signals: &[Signal], leading: Option<&str>) -> BTreeMap<String, Computed> {
    let series: Vec<Series<'_>> = signals.iter().map(Signal::series).collect();
    let (_, found) = summarize(&series, leading);
    let finite = |x: f64| Some(x).filter(|x| x.is_finite());
    let mut all = BTreeMap::new();
    for (signal, s) in signals.iter().zip(found) {
        let values = signal.values.iter().copied().filter(|x| x.is_finite());
        let (min, max) = (values.clone().reduce(f64::min), values.reduce(f64::max));
        let (mean, amplitude, frequency) = (s.mean, s.amplitude, s.frequency);
        let numbers = Numbers { value: finite(s.last), mean, amplitude, frequency, min, max };
        all.insert(signal.name.clone(), Computed { numbers, unit: signal.unit.clone() });
    }
    all
}

impl Signal {
    /// As statistics take it.
    pub fn series(&self) -> Series<'_> {
        Series { name: &self.name, times: &self.times, values: &self.values }
    }

    /// First and last time \[s\].
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((*self.times.first()?, *self.times.last()?))
    }

    /// The signal from `start` to `end` \[s\], with the value at `end` where that lies between two samples.
    pub fn within(&self, (start, end): (f64, f64)) -> Signal {
        let inside = self.times.iter().zip(&self.values).filter(|(t, _)| (start..=end).contains(*t));
        let (mut times, mut values): (Vec<f64>, Vec<f64>) = inside.map(|(&t, &v)| (t, v)).unzip();
        if times.last().is_none_or(|&last| last < end)
            && let Some(value) = value_at(&self.times, &self.values, end)
        {
            times.push(end);
            values.push(value);
        }
        Signal { name: self.name.clone(), unit: self.unit.clone(), times, values }
    }
}
