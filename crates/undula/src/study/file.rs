//! The file of a study.
//!
//! ```toml
//! name = "stiffness"
//! title = "How far the tip sinks"
//! case = "csm1"                                  # of runs that name no other
//! functionals = ["uy_A"]                         # columns of the table of runs
//!
//! [set]                                          # for all runs
//! "mesh.refine" = 1
//!
//! [quick]                                        # for all runs of a quick study
//! "mesh.refine" = 0
//!
//! [[run]]                                        # soft_0, soft_1, soft_2
//! name = "soft"
//! over = [{ key = "solid.mu", values = [0.5e6, 1e6, 2e6] }]
//!
//! [[table]]
//! title = "Sinking"
//! head = ["mu [MPa]", "published [mm]", "computed [mm]"]
//! rows = [[0.5, -66.1, "=1e3*soft_0.uy_A"]]      # `=`: an expression over results
//!
//! [[figure]]
//! title = "Sinking over stiffness"
//! x = "mu [MPa]"
//! y = "uy_A [mm]"
//! curves = [{ name = "computed", points = [[0.5, "=1e3*soft_0.uy_A"], [1, "=1e3*soft_1.uy_A"]] }]
//!
//! [[statement]]
//! text = "Four times the stiffness sinks by less than half"
//! number = "soft_2.uy_A/soft_0.uy_A"
//! holds = "it < 0.5"                             # `it` is the number
//! ```

use super::quantities::{Also, Compute};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A study as its file says.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Study {
    /// Name, of its directory too.
    pub name: String,
    /// Title of its page.
    pub title: String,
    /// Section of the book.
    pub section: String,
    /// What it is, and what was taken where the book leaves something open; paragraphs.
    pub about: Vec<String>,
    /// Built-in case, one of `cases`, or file of runs that name no other.
    pub case: String,
    /// Cases of the study by name, each the text of a case file.
    pub cases: BTreeMap<String, String>,
    /// Functionals in the table of runs; all where it is empty.
    pub functionals: Vec<String>,
    /// Whether seconds are compared, so that runs do not share the processor.
    pub timed: bool,
    /// Settings of all runs by dotted key.
    pub set: Values,
    /// Settings of all runs of a quick study.
    pub quick: Values,
    /// Settings of all runs as on the command line, `key=value`.
    #[serde(skip)]
    pub assignments: Vec<String>,
    /// Runs.
    pub run: Vec<RunEntry>,
    /// Tables.
    pub table: Vec<TableEntry>,
    /// Figures.
    pub figure: Vec<FigureEntry>,
    /// Pictures.
    pub picture: Vec<PictureEntry>,
    /// Statements.
    pub statement: Vec<Statement>,
    /// What cannot be compared, since it is lost or not given.
    pub lost: Vec<Lost>,
}

/// Settings by dotted key; the text `none` removes a key or a table.
pub type Values = BTreeMap<String, toml::Value>;

/// One run, or one for each combination of values.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunEntry {
    /// Name in expressions; with `over` the numbers of the values follow, as in `name_0_2`.
    pub name: String,
    /// Built-in case or file, where it is another than that of the study.
    pub case: String,
    /// Settings besides those of the study.
    pub set: Values,
    /// Settings besides those, in a quick study.
    pub quick: Values,
    /// Run of the study from whose last state this one goes on.
    pub from: String,
    /// Keys with the values that they take.
    pub over: Vec<Axis>,
    /// Whether a quick study leaves it out.
    #[serde(rename = "full-only")]
    pub full_only: bool,
    /// What is computed of the case.
    pub compute: Compute,
    /// What is computed of the last state of the run.
    pub also: Vec<Also>,
}

/// A key with the values that it takes, one a run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Dotted key.
    pub key: String,
    /// Its values.
    pub values: Vec<toml::Value>,
    /// How many of them a quick study takes; all where it is not given.
    #[serde(default)]
    pub quick: Option<usize>,
}

/// A table.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TableEntry {
    /// Above it.
    pub title: String,
    /// Heads of the columns.
    pub head: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<Cell>>,
    /// A row for each of these: `{1}` in `row` is the first of them, `{2}` the second.
    pub each: Vec<Vec<Cell>>,
    /// The row that is made of them.
    pub row: Vec<Cell>,
    /// Below it.
    pub note: String,
}

/// A number, a text, or with `=` an expression over results.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// As published.
    Number(f64),
    /// Text, or an expression.
    Text(String),
}

/// A figure.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FigureEntry {
    /// Above it.
    pub title: String,
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// First and last value of the horizontal axis.
    pub from: Option<f64>,
    /// See `from`.
    pub to: Option<f64>,
    /// Lowest and highest value of the vertical axis.
    pub low: Option<f64>,
    /// See `low`.
    pub high: Option<f64>,
    /// Whether both axes are logarithmic.
    pub logarithmic: bool,
    /// Curves.
    pub curves: Vec<CurveEntry>,
    /// Below it.
    pub note: String,
}

/// A curve of a figure: a signal, its spectrum, or points.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CurveEntry {
    /// In the legend.
    pub name: String,
    /// A signal, such as `run.drag`.
    pub of: String,
    /// Its values are multiplied by this expression.
    pub factor: String,
    /// First and last time of the spectrum of the signal, which is drawn instead of it.
    pub spectrum: Option<[f64; 2]>,
    /// Points.
    pub points: Vec<[Cell; 2]>,
    /// A curve for each of these, or a point where `point` is given: `{1}` is the first of them, `{2}` the second.
    pub each: Vec<Vec<Cell>>,
    /// The point that is made of them.
    pub point: Vec<Cell>,
}

/// A picture of a run, of the fields that it has written last before a time.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PictureEntry {
    /// Above it.
    pub title: String,
    /// Run.
    pub run: String,
    /// Time \[s\]; the last where it is not given.
    pub time: Option<Cell>,
    /// `velocity`, `pressure` or `deformation`.
    pub field: String,
    /// A picture for each of these.
    pub each: Vec<Vec<Cell>>,
}

/// A statement.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Statement {
    /// In words.
    pub text: String,
    /// Section, figure or table of the book.
    pub section: String,
    /// The number that decides.
    pub number: String,
    /// Its unit.
    pub unit: String,
    /// The published number, if there is one.
    pub published: Option<Cell>,
    /// The condition; `it` is the number.
    pub holds: String,
    /// What is known about a statement that is not reproduced.
    pub because: String,
    /// A statement for each of these: `{1}` is the first of them, `{2}` the second.
    pub each: Vec<Vec<Cell>>,
}

impl Cell {
    /// The number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Cell::Number(number) => Some(*number),
            Cell::Text(_) => None,
        }
    }
}

impl Statement {
    /// The published number.
    pub fn published(&self) -> Option<f64> {
        self.published.as_ref().and_then(Cell::number)
    }
}

/// Something that cannot be compared.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lost {
    /// What.
    pub text: String,
    /// Section, figure or table of the book.
    pub section: String,
    /// Why.
    pub because: String,
}

/// Why a study cannot be taken.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The file.
    #[error("{0}")]
    File(String),
    /// A run.
    #[error("{file}: run {run}: {message}")]
    Run {
        /// Study.
        file: String,
        /// Name of the run.
        run: String,
        /// What is wrong with it.
        message: String,
    },
    /// An expression.
    #[error("{file}: {place}: `{expression}`: {message}")]
    Expression {
        /// Study.
        file: String,
        /// Where it is.
        place: String,
        /// It.
        expression: String,
        /// What is wrong with it.
        message: String,
    },
}

impl Study {
    /// Reads a study; `file` is its name in messages.
    ///
    /// # Errors
    /// Unknown keys, missing names, two runs of the same name.
    pub fn from_toml(text: &str, file: &str) -> Result<Study, StudyError> {
        let error = |message: String| StudyError::File(format!("{file}: {message}"));
        let mut study: Study = toml::from_str(text).map_err(|e| error(e.to_string().trim_end().into()))?;
        if study.name.is_empty() {
            let stem = Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned());
            study.name = stem.unwrap_or_else(|| "study".into());
        }
        if study.name.contains(['/', '\\']) || study.name.starts_with('.') {
            return Err(error(format!("name = {:?}: expected a name of a directory", study.name)));
        }
        if study.run.is_empty() {
            return Err(error("expected at least one [[run]]".into()));
        }
        study.expand().map_err(error)?;
        let mut names: Vec<&str> = study.run.iter().map(|run| run.name.as_str()).collect();
        let plain = |name: &&str| {
            name.starts_with(|c: char| c.is_ascii_alphabetic())
                && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        if let Some(name) = names.iter().find(|name| !plain(name)) {
            return Err(error(format!(
                "run.name = {name:?}: expected a letter, then letters, digits and `_`: it is a name in expressions"
            )));
        }
        names.sort_unstable();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(error(format!("two runs have the name {:?}", twice[0])));
        }
        if let Some(run) = study.run.iter().find(|run| run.case.is_empty() && study.case.is_empty()) {
            return Err(error(format!("run {}: expected `case`, here or for the whole study", run.name)));
        }
        let is_more = |run: &&RunEntry| !run.from.is_empty() || !run.also.is_empty();
        if let Some(run) = study.run.iter().filter(|run| run.compute != Compute::Run).find(is_more) {
            return Err(error(format!(
                "run {}: `compute` goes neither with `from` nor with `also`",
                run.name
            )));
        }
        study.check_order().map_err(error)?;
        if let Some(run) = study.run.iter().find(|run| run.over.iter().any(|axis| axis.values.is_empty())) {
            return Err(error(format!("run {}: over: expected values", run.name)));
        }
        Ok(study)
    }

    /// Whether every run goes on from one that there is, and none from itself in the end.
    fn check_order(&self) -> Result<(), String> {
        let of_name = |name: &str| {
            self.run.iter().find(|run| run.name == name && run.over.is_empty() && run.compute == Compute::Run)
        };
        for run in &self.run {
            // The runs that it goes on from, one behind the other.
            let (mut at, mut steps) = (run, 0);
            while !at.from.is_empty() {
                at = of_name(&at.from).ok_or_else(|| {
                    let expected = "expected another run of the study, one without `over`";
                    format!("run {}: from = {:?}: {expected}", at.name, at.from)
                })?;
                steps += 1;
                if steps > self.run.len() {
                    return Err(format!("run {}: from = {:?} leads back to it", run.name, run.from));
                }
            }
        }
        Ok(())
    }
}
