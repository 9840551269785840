//! What a study shows: its runs, tables, figures and statements with their numbers.

use super::engine::Computed;
use super::file::{
    Cell, CurveEntry, FigureEntry, Lost, PictureEntry, Statement, Study, StudyError, TableEntry,
};
use super::known::Known;
use super::quantities::{Compute, Numbers};
use crate::functional::statistics::spectrum;
use crate::output::Status;
use std::fmt;
use std::path::PathBuf;

/// The results of a study.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Name.
    pub name: String,
    /// Title.
    pub title: String,
    /// Section of the book.
    pub section: String,
    /// Paragraphs.
    pub about: Vec<String>,
    /// Whether it was a quick study.
    pub quick: bool,
    /// Statements.
    pub statements: Vec<Weighed>,
    /// What cannot be compared.
    pub lost: Vec<Lost>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Pictures.
    pub pictures: Vec<Picture>,
    /// Runs.
    pub runs: Vec<RunRow>,
    /// Functionals of the table of runs.
    pub functionals: Vec<String>,
}

/// What the results say about a statement.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Its condition holds.
    Reproduced,
    /// It does not.
    NotReproduced,
    /// A result that it needs is missing.
    Undecided,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Reproduced => "reproduced",
            Verdict::NotReproduced => "not reproduced",
            Verdict::Undecided => "undecided",
        })
    }
}

/// A statement with its number and verdict.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// As in the file.
    pub statement: Statement,
    /// The number that decides.
    pub number: Option<f64>,
    /// What the condition says.
    pub verdict: Verdict,
    /// Results that are missing.
    pub missing: Vec<String>,
}

/// A table with its numbers.
#[derive(Clone, Debug)]
pub struct Table {
    /// Above it.
    pub title: String,
    /// Heads of the columns.
    pub head: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<Shown>>,
    /// Below it.
    pub note: String,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Shown {
    /// Text.
    Text(String),
    /// As published.
    Published(f64),
    /// Computed; `None` where a result is missing.
    Computed(Option<f64>),
    /// Computed, with more digits.
    Exact(f64),
}

/// A figure with its curves.
#[derive(Clone, Debug)]
pub struct Figure {
    /// As in the file.
    pub entry: FigureEntry,
    /// Curves that have points.
    pub curves: Vec<Curve>,
}

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// In the legend.
    pub name: String,
    /// Points with marks instead of a line.
    pub marked: bool,
    /// Whether all its points are published ones.
    pub published: bool,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
}

/// A picture of fields that a run has written.
#[derive(Clone, Debug)]
pub struct Picture {
    /// As in the file.
    pub entry: PictureEntry,
    /// Directory of the run; `None` where it has no results.
    pub directory: Option<PathBuf>,
}

/// A run in the table of runs.
#[derive(Clone, Debug)]
pub struct RunRow {
    /// Name.
    pub name: String,
    /// Case.
    pub case: String,
    /// Settings, `key = value`.
    pub settings: Vec<(String, String)>,
    /// How it ended; `None` where it has no results.
    pub status: Option<Status>,
    /// Time reached \[s\]; `None` where it is stationary.
    pub time: Option<f64>,
    /// Unknowns.
    pub unknowns: usize,
    /// Elapsed time \[s\].
    pub seconds: f64,
    /// Commit of the program that computed it.
    pub commit: Option<String>,
    /// Last value, mean, amplitude and frequency of each functional of the report.
    pub values: Vec<[Option<f64>; 4]>,
    /// Unit of each functional.
    pub units: Vec<String>,
    /// Numbers that were computed besides or instead of a history.
    pub numbers: Numbers,
}

/// Evaluates expressions with a message that says where they are.
struct Reader<'a> {
    known: Known,
    file: &'a str,
}

impl Study {
    /// Tables, figures and statements of computed runs; `file` is the name of the study in messages.
    ///
    /// # Errors
    /// An expression that is none, or names a run or a result that is none.
    pub fn report(&self, computed: &[Computed], quick: bool, file: &str) -> Result<Report, StudyError> {
        let mut known = Known::default();
        for run in computed {
            let name = &run.job.name;
            if run.is_there() {
                known.insert(name, run.results.as_ref(), &run.numbers);
            } else {
                known.insert_absent(name, run.job.functionals(), run.job.numbers());
            }
        }
        let mut reader = Reader { known, file };
        let functionals = self.functionals(computed);
        Ok(Report {
            name: self.name.clone(),
            title: if self.title.is_empty() { self.name.clone() } else { self.title.clone() },
            section: self.section.clone(),
            about: self.about.clone(),
            quick,
            statements: self.statement.iter().map(|s| reader.weigh(s)).collect::<Result<_, _>>()?,
            lost: self.lost.clone(),
            tables: self.table.iter().map(|t| reader.table(t)).collect::<Result<_, _>>()?,
            figures: self.figure.iter().map(|f| reader.figure(f)).collect::<Result<_, _>>()?,
            pictures: self.picture.iter().map(|p| picture(p, computed, file)).collect::<Result<_, _>>()?,
            runs: computed.iter().map(|run| RunRow::new(run, &functionals)).collect(),
            functionals,
        })
    }

    /// Those asked for, else all.
    fn functionals(&self, computed: &[Computed]) -> Vec<String> {
        let mut names = self.functionals.clone();
        if names.is_empty() {
            for results in computed.iter().filter_map(|run| run.results.as_ref()) {
                for signal in results.signals() {
                    if !names.contains(&signal.name) {
                        names.push(signal.name);
                    }
                }
            }
        }
        names
    }
}

/// The picture, with the directory of its run.
fn picture(entry: &PictureEntry, computed: &[Computed], file: &str) -> Result<Picture, StudyError> {
    let Some(run) = computed.iter().find(|run| run.job.name == entry.run) else {
        return Err(StudyError::File(format!(
            "{file}: picture {:?}: no run is called {:?}",
            entry.title, entry.run
        )));
    };
    let fields = ["velocity", "pressure", "deformation"];
    if !fields.contains(&entry.field.as_str()) {
        let (title, field) = (&entry.title, &entry.field);
        let fields = fields.join("`, `");
        return Err(StudyError::File(format!(
            "{file}: picture {title:?}: field = {field:?}: expected `{fields}`"
        )));
    }
    let directory = run.results.is_some().then(|| run.directory.clone());
    Ok(Picture { entry: entry.clone(), directory })
}

impl Reader<'_> {
    fn number(&mut self, place: &str, expression: &str, it: Option<f64>) -> Result<Option<f64>, StudyError> {
        self.known.evaluate(expression, it).map_err(|message| StudyError::Expression {
            file: self.file.into(),
            place: place.into(),
            expression: expression.into(),
            message,
        })
    }

    fn weigh(&mut self, statement: &Statement) -> Result<Weighed, StudyError> {
        let place = format!("statement {:?}", statement.text);
        let mut missing = vec![];
        let mut number = None;
        if !statement.number.is_empty() {
            number = self.number(&place, &statement.number, None)?;
            missing.extend(self.known.missing());
        }
        // A missing number is no number, so that conditions on it do not hold.
        let it = (!statement.number.is_empty()).then(|| number.unwrap_or(f64::NAN));
        let holds = self.number(&place, &statement.holds, it)?;
        missing.extend(self.known.missing());
        missing.sort();
        missing.dedup();
        let verdict = match holds {
            _ if !missing.is_empty() => Verdict::Undecided,
            Some(holds) if holds != 0.0 => Verdict::Reproduced,
            _ => Verdict::NotReproduced,
        };
        Ok(Weighed { statement: statement.clone(), number, verdict, missing })
    }

    fn table(&mut self, table: &TableEntry) -> Result<Table, StudyError> {
        let place = format!("table {:?}", table.title);
        let mut rows = vec![];
        for row in &table.rows {
            let cells = row.iter().map(|cell| match cell {
                Cell::Number(x) => Ok(Shown::Published(*x)),
                Cell::Text(text) => match text.strip_prefix('=') {
                    Some(expression) => Ok(Shown::Computed(self.number(&place, expression, None)?)),
                    None => Ok(Shown::Text(text.clone())),
                },
            });
            rows.push(cells.collect::<Result<_, StudyError>>()?);
        }
        Ok(Table { title: table.title.clone(), head: table.head.clone(), rows, note: table.note.clone() })
    }

    fn figure(&mut self, figure: &FigureEntry) -> Result<Figure, StudyError> {
        let place = format!("figure {:?}", figure.title);
        let curves =
            figure.curves.iter().map(|curve| self.curve(curve, &place)).collect::<Result<Vec<_>, _>>()?;
        Ok(Figure { entry: figure.clone(), curves: curves.into_iter().filter(|c| !c.x.is_empty()).collect() })
    }

    fn curve(&mut self, entry: &CurveEntry, place: &str) -> Result<Curve, StudyError> {
        let mut curve = Curve {
            name: entry.name.clone(),
            marked: !entry.points.is_empty(),
            published: !entry.points.is_empty(),
            x: vec![],
            y: vec![],
        };
        for point in &entry.points {
            let mut coordinates = [None; 2];
            for (coordinate, cell) in coordinates.iter_mut().zip(point) {
                *coordinate = match cell {
                    Cell::Number(x) => Some(*x),
                    Cell::Text(text) => {
                        curve.published = false;
                        self.number(place, text.trim_start_matches('='), None)?
                    }
                };
            }
            if let [Some(x), Some(y)] = coordinates {
                curve.x.push(x);
                curve.y.push(y);
            }
        }
        if entry.of.is_empty() {
            return Ok(curve);
        }
        let factor = match entry.factor.is_empty() {
            true => Some(1.0),
            false => self.number(place, &entry.factor, None)?,
        };
        let Some(signal) = self.known.signal(&entry.of) else {
            // Names of runs are checked; a run that is left out has no signal.
            self.number(place, &format!("at({}, 0)", entry.of), None)?;
            return Ok(curve);
        };
        (curve.x, curve.y) = match entry.spectrum {
            None => (signal.times.clone(), signal.values.clone()),
            Some([start, end]) => {
                let part = signal.within((start, end));
                let spectrum = spectrum(&part.times, &part.values);
                (spectrum.frequencies, spectrum.amplitudes)
            }
        };
        curve.y.iter_mut().for_each(|y| *y *= factor.unwrap_or(f64::NAN));
        Ok(curve)
    }
}

impl RunRow {
    fn new(run: &Computed, functionals: &[String]) -> RunRow {
        let results = run.results.as_ref();
        let summary = results.map(|results| &results.summary);
        let computed = results.map(crate::results::computed::Results::computed).unwrap_or_default();
        let values = functionals.iter().map(|name| match computed.get(name) {
            Some(c) => [c.numbers.value, c.numbers.mean, c.numbers.amplitude, c.numbers.frequency],
            None => [None; 4],
        });
        let unit = |name: &String| computed.get(name).map_or_else(String::new, |c| c.unit.clone());
        let time = results
            .filter(|results| !results.is_stationary())
            .and_then(|results| results.history.column("time"));
        RunRow {
            name: run.job.name.clone(),
            case: run.job.of.clone(),
            settings: run.job.settings.clone(),
            status: match run.job.compute {
                Compute::Run => summary.map(|summary| summary.status),
                _ if run.has_failed() => Some(Status::Breakdown),
                _ => run.is_there().then_some(Status::Completed),
            },
            time: time.and_then(|times| times.last().copied()),
            unknowns: summary.map_or(0, |summary| summary.unknowns.total),
            seconds: match run.numbers.get("seconds") {
                Some(seconds) => *seconds,
                None => summary.map_or(0.0, |summary| summary.wall_seconds),
            },
            numbers: run.numbers.clone(),
            commit: summary.and_then(|summary| summary.provenance.commit.clone()),
            values: values.collect(),
            units: functionals.iter().map(unit).collect(),
        }
    }
}
