//! Names of results in the expressions of a study.
//!
//! | expression | number |
//! | --- | --- |
//! | `run.drag` | last value of a functional |
//! | `run.drag.mean`, `.amplitude`, `.frequency`, `.min`, `.max` | as `undula compare` prints them; those over a period are missing where nothing is periodic |
//! | `run.end_time` | time reached \[s\] |
//! | `run.completed`, `run.broke_down` | 1 or 0 |
//! | `run.unknowns`, `run.cells`, `run.steps`, `run.newton_steps`, `run.jacobians`, `run.factorizations` | counts |
//! | `run.seconds`, `run.assembly`, `run.factorization`, `run.solve`, `run.memory` | s, and B |
//! | `run.min_J`, `run.mass_balance` | smallest J of all steps; see `summary.json` |
//! | `run.inf_sup`, … | numbers of `quantities`, where the study has them computed |
//! | `at(s, t)`, `highest(s, a, b)`, `lowest(s, a, b)` | of a signal such as `run.drag`; a and b are times \[s\] |
//! | `middle(s, a, b)`, `amplitude(s, a, b)` | (max ± min)/2 |
//! | `average(s, a, b)`, `total(s, a, b)` | mean value in time; sum over the steps |
//! | `frequency(s, a, b)` | of the periodic signal \[Hz\] |
//! | `line(s, a, b, f, g)`, `line_frequency(s, a, b, f, g)` | highest line of the spectrum between the frequencies f and g |
//! | `zigzag(s, a, b)` | largest \|s(tₙ₊₁) − 2 s(tₙ) + s(tₙ₋₁)\|/4: the amplitude of an oscillation from step to step |
//! | `onset(s, level, a, b)` | first time at which the zigzag exceeds a level; b where it never does |
//! | `distance(s, r, a, b)` | largest difference of two signals at the times of the first |
//! | `prominence(s, a, b, f, g)` | highest peak between f and g over the median of the lines there |
//! | `order(e, d)` | log₂(e/d) of the error e on a mesh, or with a step, and d on one of half the size |
//!
//! Signals are the functionals and the columns `min_J`, `newton_steps` and `jacobians` of `history.csv`.

use super::measures;
use crate::case::error::did_you_mean;
use crate::case::expression::Names;
use crate::output::Status;
use crate::results::computed::{Results, Signal};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Results of every run that are no functionals.
pub(super) const NUMBERS: [&str; 16] = [
    "end_time",
    "completed",
    "broke_down",
    "unknowns",
    "cells",
    "steps",
    "newton_steps",
    "jacobians",
    "factorizations",
    "seconds",
    "assembly",
    "factorization",
    "solve",
    "memory",
    "mass_balance",
    "min_J",
];

/// Signals of every run that are no functionals.
const SIGNALS: [&str; 3] = ["min_J", "newton_steps", "jacobians"];

fn unknown(result: &str, names: &[&str]) -> String {
    let hint = did_you_mean(result, names.iter().copied());
    let hint = if hint.is_empty() { format!("; there are {}", names.join(", ")) } else { hint };
    format!("unknown result `{result}`{hint}")
}

/// Results of runs by name.
#[derive(Default)]
pub struct Known {
    runs: BTreeMap<String, Of>,
    /// Runs of the study without results.
    absent: BTreeMap<String, Absent>,
    /// What `it` is.
    it: Option<f64>,
    /// Names that were asked for and have no number.
    missing: RefCell<Vec<String>>,
}

/// Names of the results that a run would have.
struct Absent {
    /// Functionals.
    functionals: Vec<String>,
    /// Other numbers.
    numbers: Vec<String>,
    /// Whether it has a history.
    is_run: bool,
}

/// Results of one run.
#[derive(Default)]
struct Of {
    numbers: BTreeMap<String, f64>,
    signals: BTreeMap<String, Signal>,
}

impl Known {
    /// Adds a run, with numbers that were computed besides or instead of its history.
    pub fn insert(&mut self, name: &str, results: Option<&Results>, numbers: &BTreeMap<String, f64>) {
        let mut of = results.map_or_else(Of::default, Of::new);
        of.numbers.extend(numbers.clone());
        self.runs.insert(name.into(), of);
    }

    /// Names a run that has no results, with its functionals where it is one, and the names of other numbers: names of
    /// others are mistakes all the same.
    pub fn insert_absent(&mut self, name: &str, functionals: Option<Vec<String>>, mut numbers: Vec<String>) {
        let is_run = functionals.is_some();
        if is_run {
            numbers.extend(NUMBERS.map(String::from));
        } else {
            numbers.push("seconds".into());
        }
        let functionals = functionals.unwrap_or_default();
        self.absent.insert(name.into(), Absent { functionals, numbers, is_run });
    }

    /// A signal such as `run.drag`.
    pub fn signal(&self, name: &str) -> Option<&Signal> {
        let (run, signal) = name.split_once('.')?;
        self.runs.get(run)?.signals.get(signal)
    }

    /// The number of an expression, `None` where a result that it names is missing; `it` is a number of the statement.
    ///
    /// # Errors
    /// What is wrong with the expression.
    pub fn evaluate(&mut self, expression: &str, it: Option<f64>) -> Result<Option<f64>, String> {
        self.it = it;
        self.missing.borrow_mut().clear();
        let value = crate::case::expression::evaluate(expression, self).map_err(|e| e.to_string())?;
        Ok(Some(value).filter(|_| self.missing.borrow().is_empty()))
    }

    /// What was missing for the last number.
    pub fn missing(&self) -> Vec<String> {
        self.missing.borrow().clone()
    }

    fn lacks(&self, what: &str) -> f64 {
        self.missing.borrow_mut().push(what.into());
        f64::NAN
    }

    /// Whether a run without results would have a signal of this name.
    fn is_absent_signal(&self, name: &str) -> bool {
        let Some((run, of)) = name.split_once('.') else { return false };
        let known = |absent: &Absent| {
            absent.functionals.iter().any(|f| f == of) || (absent.is_run && SIGNALS.contains(&of))
        };
        self.absent.get(run).is_some_and(known)
    }

    /// A result of a run without results.
    fn absent(&self, name: &str, of: &str, absent: &Absent) -> Result<f64, String> {
        let quantities = ["mean", "amplitude", "frequency", "min", "max"];
        let is_of = |f: &String| {
            of.strip_prefix(f.as_str()).is_some_and(|rest| {
                rest.is_empty() || rest.strip_prefix('.').is_some_and(|q| quantities.contains(&q))
            })
        };
        if absent.numbers.iter().any(|number| number == of) || absent.functionals.iter().any(is_of) {
            return Ok(self.lacks(name));
        }
        let names: Vec<&str> = absent.numbers.iter().chain(&absent.functionals).map(String::as_str).collect();
        Err(unknown(of, &names))
    }
}

impl Names for Known {
    fn value(&self, name: &str) -> Option<Result<f64, String>> {
        if name == "it" {
            return self.it.map(Ok);
        }
        let (run, of) = name.split_once('.')?;
        if let Some(absent) = self.absent.get(run) {
            return Some(self.absent(name, of, absent));
        }
        let Some(known) = self.runs.get(run) else {
            let runs: Vec<&str> = self.runs.keys().chain(self.absent.keys()).map(String::as_str).collect();
            return Some(Err(format!("unknown run `{run}`; there are {}", runs.join(", "))));
        };
        Some(match known.numbers.get(of) {
            Some(number) if number.is_nan() => Ok(self.lacks(name)),
            Some(number) => Ok(*number),
            None => {
                let names: Vec<&str> = known.numbers.keys().map(String::as_str).collect();
                Err(unknown(of, &names))
            }
        })
    }

    fn is_signal(&self, name: &str) -> bool {
        self.is_absent_signal(name) || self.signal(name).is_some()
    }

    fn has_function(&self, name: &str) -> bool {
        measures::of(name).is_some()
    }

    fn call(&self, function: &str, of: &[&str], numbers: &[f64]) -> Result<f64, String> {
        let measure = measures::of(function).ok_or("unknown function")?;
        if of.len() != measure.signals || numbers.len() != measure.numbers {
            return Err(format!("`{function}` takes {}", measure.usage));
        }
        if let Some(absent) = of.iter().find(|name| self.is_absent_signal(name)) {
            return Ok(self.lacks(absent));
        }
        let signals: Vec<&Signal> = of.iter().filter_map(|name| self.signal(name)).collect();
        match (measure.compute)(&signals, numbers).filter(|value| value.is_finite()) {
            Some(value) => Ok(value),
            None => Ok(self.lacks(&format!("{function}({}, …)", of.join(", ")))),
        }
    }
}

impl Of {
    fn new(results: &Results) -> Of {
        let summary = &results.summary;
        let mut signals: BTreeMap<String, Signal> =
            results.signals().into_iter().map(|signal| (signal.name.clone(), signal)).collect();
        let times = results.history.column("time").unwrap_or_default();
        for name in SIGNALS {
            let Some(values) = results.history.column(name) else { continue };
            let (name, times) = (name.to_string(), times.clone());
            signals.insert(name.clone(), Signal { name, unit: String::new(), times, values });
        }
        let flag = |is: bool| f64::from(u8::from(is));
        let min_j = signals.get("min_J").map(|s| s.values.iter().copied().fold(f64::NAN, f64::min));
        let values = [
            times.last().copied().unwrap_or(f64::NAN),
            flag(summary.status == Status::Completed),
            flag(summary.status == Status::Breakdown),
            summary.unknowns.total as f64,
            summary.cells as f64,
            summary.steps as f64,
            summary.newton_steps as f64,
            summary.jacobians as f64,
            summary.factorizations as f64,
            summary.wall_seconds,
            summary.phases.assembly,
            summary.phases.factorization,
            summary.phases.solve,
            summary.peak_memory_bytes.map_or(f64::NAN, |bytes| bytes as f64),
            summary.mass_balance.unwrap_or(f64::NAN),
            min_j.unwrap_or(f64::NAN),
        ];
        let mut numbers: BTreeMap<String, f64> =
            NUMBERS.iter().map(ToString::to_string).zip(values).collect();
        for (name, computed) in results.computed() {
            for (quantity, value) in computed.numbers.named() {
                let name = if quantity == "value" { name.clone() } else { format!("{name}.{quantity}") };
                numbers.insert(name, value.unwrap_or(f64::NAN));
            }
        }
        Of { numbers, signals }
    }
}
