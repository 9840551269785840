//! One run of a study: its case and its settings.

use super::file::{RunEntry, Study, StudyError, Values};
use super::known::NUMBERS;
use super::quantities::{Also, Compute};
use crate::case::Case;
use crate::case::builtin::builtin_case;
use crate::error::Error;
use std::path::Path;

/// One run of a study.
#[derive(Clone, Debug)]
pub struct Job {
    /// Name in expressions.
    pub name: String,
    /// Built-in case or file.
    pub of: String,
    /// Settings of this run that others of the study do not have, `key = value`.
    pub settings: Vec<(String, String)>,
    /// The case; that of a run that goes on from another is at rest.
    pub case: Case,
    /// The case of the file, and its settings.
    source: (Source, Vec<String>),
    /// Run from whose last state it goes on.
    pub(super) from: String,
    /// Whether a quick study leaves it out.
    pub left_out: bool,
    /// What is computed of the case.
    pub compute: Compute,
    /// What is computed of the last state of the run.
    pub also: Vec<Also>,
}

impl Job {
    /// The case, from the state that another run of the study in `directory` has reached.
    pub(super) fn case_in(&self, directory: &Path) -> Result<Case, Error> {
        if self.from.is_empty() {
            return Ok(self.case.clone());
        }
        self.after(&directory.join(&self.from), &[])
    }

    /// The case from the last state in `directory`, with more settings.
    pub(super) fn after(&self, directory: &Path, more: &[String]) -> Result<Case, Error> {
        let from = std::path::absolute(directory).unwrap_or_else(|_| directory.into());
        let assignment = format!("initial.from={}", toml::Value::String(from.to_string_lossy().into_owned()));
        let (source, settings) = &self.source;
        source.load(&[&settings[..], &[assignment], more].concat())
    }

    /// Names of its functionals, where it is a run.
    pub(super) fn functionals(&self) -> Option<Vec<String>> {
        let names = || self.case.functional.iter().map(|(name, _)| name.clone()).collect();
        (self.compute == Compute::Run).then(names)
    }

    /// Names of the numbers that it has besides or instead of a history.
    pub(super) fn numbers(&self) -> Vec<String> {
        let mut names = self.compute.names();
        names.extend(self.also.iter().flat_map(|also| also.names()));
        names
    }

    /// What makes its numbers others; nothing where it has none.
    pub(super) fn asked_numbers(&self) -> String {
        match (self.compute, &self.also[..]) {
            (Compute::Run, []) => String::new(),
            (compute, also) => format!("# computes {compute:?} {also:?}\n"),
        }
    }
}

/// Where a case comes from.
#[derive(Clone, Debug)]
enum Source {
    /// A built-in case or a file.
    Path(String),
    /// A text in the study, with a name for messages.
    Text(String, String),
}

impl Source {
    fn load(&self, settings: &[String]) -> Result<Case, Error> {
        Ok(match self {
            Source::Path(path) => Case::load(path, settings)?,
            Source::Text(text, name) => Case::from_toml(text, name, settings)?,
        })
    }
}

impl Study {
    /// The runs with their cases. Relative paths of cases are relative to `base`; `file` is the name of the study in
    /// messages.
    ///
    /// # Errors
    /// A run whose case has mistakes.
    pub fn jobs(&self, quick: bool, base: &Path, file: &str) -> Result<Vec<Job>, StudyError> {
        let mut jobs = vec![];
        for entry in &self.run {
            for (name, values, is_quick) in combinations(entry) {
                let mut all = defaults();
                all.extend(self.set.clone());
                if quick {
                    all.extend(self.quick.clone());
                }
                let mut own = entry.set.clone();
                if quick {
                    own.extend(entry.quick.clone());
                }
                own.extend(values);
                all.extend(own.clone());
                let of = if entry.case.is_empty() { &self.case } else { &entry.case };
                let source = match (self.cases.get(of), builtin_case(of)) {
                    (Some(text), _) => Source::Text(text.clone(), format!("{file}, cases.{of}")),
                    (None, Some(_)) => Source::Path(of.clone()),
                    (None, None) => Source::Path(base.join(of).to_string_lossy().into_owned()),
                };
                let wrong =
                    |message: String| StudyError::Run { file: file.into(), run: name.clone(), message };
                if jobs.iter().any(|job: &Job| job.name == name) {
                    return Err(wrong("another run has this name, of which `over` makes some".into()));
                }
                let left_out = quick && (entry.full_only || !is_quick);
                let all = [self.assignments.clone(), assignments(&all)].concat();
                let case = source.load(&all).map_err(|e| wrong(e.to_string()))?;
                let (source, from) = ((source, all), entry.from.clone());
                let settings = own.iter().map(|(key, value)| (key.clone(), text(value))).collect();
                let (of, compute, also) = (of.clone(), entry.compute, entry.also.clone());
                let job =
                    Job { name: name.clone(), of, settings, case, left_out, source, from, compute, also };
                if let Some(twice) = job.reserved() {
                    return Err(wrong(format!("functional.{twice}: every run has a result of this name")));
                }
                jobs.push(job);
            }
        }
        Ok(jobs)
    }
}

impl Job {
    /// A functional whose name is that of another result in expressions.
    fn reserved(&self) -> Option<String> {
        let others = self.numbers();
        let is_other = |name: &String| NUMBERS.contains(&name.as_str()) || others.contains(name);
        self.functionals().unwrap_or_default().into_iter().find(is_other)
    }
}

/// Runs of a study write what expressions need.
fn defaults() -> Values {
    ["output.fields-every", "output.checkpoint-every"]
        .map(|key| (key.to_string(), toml::Value::Integer(0)))
        .into()
}

/// Names and settings of all combinations, and whether a quick study has them.
fn combinations(entry: &RunEntry) -> Vec<(String, Values, bool)> {
    let mut all = vec![(entry.name.clone(), Values::new(), true)];
    for axis in &entry.over {
        let more = |(name, values, is_quick): &(String, Values, bool)| {
            let with = |(n, value): (usize, &toml::Value)| {
                let mut values = values.clone();
                values.insert(axis.key.clone(), value.clone());
                (format!("{name}_{n}"), values, *is_quick && axis.quick.is_none_or(|count| n < count))
            };
            axis.values.iter().enumerate().map(with).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(more).collect();
    }
    all
}

fn text(value: &toml::Value) -> String {
    match value {
        toml::Value::String(word) if word == "none" => word.clone(),
        value => value.to_string(),
    }
}

fn assignments(values: &Values) -> Vec<String> {
    values.iter().map(|(key, value)| format!("{key}={}", text(value))).collect()
}
