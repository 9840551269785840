//! Results of a run beside published ones, or beside those of another run.

use super::computed::{Results, Signal, numbers};
use super::reference::{Departure, Numbers, Published, References};
use std::collections::BTreeMap;
use std::fmt;

/// A run beside the published results of its case.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Name of the case.
    pub case: String,
    /// How the run ended.
    pub status: String,
    /// One row per published number, grouped by functional and number.
    pub rows: Vec<Row>,
    /// Functionals of the run that nobody published.
    pub unpublished: Vec<String>,
    /// What makes functionals others than those published.
    pub left_out: Vec<Departure>,
}

/// A published number and the computed one.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Functional.
    pub functional: String,
    /// `value`, `mean`, `amplitude`, `frequency`, `min` or `max`.
    pub quantity: &'static str,
    /// SI unit, Hz for a frequency.
    pub unit: String,
    /// From the run, if it has it.
    pub computed: Option<f64>,
    /// From the source.
    pub published: f64,
    /// (computed − published) relative to the published number; a mean is taken relative to the
    /// amplitude if that is larger.
    pub deviation: Option<f64>,
    /// Relative uncertainty of the published number.
    pub uncertainty: Option<f64>,
    /// Who published it.
    pub source: String,
    /// Whether this is the source to compare with.
    pub primary: bool,
}

/// Two runs side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Names of the two runs.
    pub names: [String; 2],
    /// First and last time of both \[s\], over which all is compared; `None` where one is stationary.
    pub common: Option<(f64, f64)>,
    /// One row per number that both have.
    pub rows: Vec<DifferenceRow>,
    /// Functionals that only one of them has.
    pub unmatched: Vec<String>,
    /// Functionals with different units, as those of a plane and of a body in space.
    pub other_units: Vec<String>,
}

/// A number of two runs.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceRow {
    /// Functional.
    pub functional: String,
    /// Which number.
    pub quantity: &'static str,
    /// SI unit, Hz for a frequency.
    pub unit: String,
    /// Of the first and the second run.
    pub values: [f64; 2],
    /// (second − first) relative to the first, as in [`Row::deviation`].
    pub deviation: Option<f64>,
}

/// (x − y) over the size of y; a mean over the amplitude if that is larger. `None` if the size is 0.
fn deviation(x: f64, y: f64, quantity: &str, numbers: &Numbers) -> Option<f64> {
    let amplitude = if quantity == "mean" { numbers.amplitude.map_or(0.0, f64::abs) } else { 0.0 };
    let size = y.abs().max(amplitude);
    (size > 0.0).then(|| (x - y) / size)
}

fn unit_of(quantity: &str, unit: &str) -> String {
    if quantity == "frequency" { "Hz".into() } else { unit.into() }
}

/// Sets the numbers of `run` beside those of `references`.
pub fn compare(run: &Results, references: &References) -> Comparison {
    let (mut rows, found) = (Vec::new(), run.computed());
    for (functional, sources) in &references.results {
        let computed = found.get(functional);
        let numbers = computed.map_or(Numbers::default(), |c| c.numbers);
        for (quantity, value) in numbers.named() {
            let of = |p: &Published| {
                p.numbers.named().into_iter().find(|(q, _)| *q == quantity).and_then(|(_, x)| x)
            };
            for (i, source) in sources.iter().enumerate() {
                let Some(published) = of(source) else { continue };
                let uncertainty = source.uncertainty.named().into_iter().find(|(q, _)| *q == quantity);
                let note = if source.note.is_empty() { String::new() } else { format!(" ({})", source.note) };
                rows.push(Row {
                    functional: functional.clone(),
                    quantity,
                    unit: unit_of(quantity, &source.unit),
                    computed: value,
                    published,
                    deviation: value.and_then(|x| deviation(x, published, quantity, &source.numbers)),
                    uncertainty: uncertainty.and_then(|(_, x)| x),
                    source: format!("{}{note}", source.source),
                    primary: i == 0,
                });
            }
        }
    }
    let unpublished = found.keys().filter(|name| !references.results.contains_key(*name));
    Comparison {
        case: run.summary.case.clone(),
        status: run.summary.status.to_string(),
        rows,
        unpublished: unpublished.cloned().collect(),
        left_out: vec![],
    }
}

/// First and last time that both runs have \[s\]; the last is below the first if they have none in common.
fn common_time(first: &Results, second: &Results) -> Option<(f64, f64)> {
    let span = |run: &Results| {
        let times = run.history.column("time")?;
        Some((*times.first()?, *times.last()?)).filter(|_| !run.is_stationary())
    };
    let (a, b) = (span(first)?, span(second)?);
    Some((a.0.max(b.0), a.1.min(b.1)))
}

/// The signals of `run` over the time for which `other` has them, too.
fn cut(run: &Results, other: &Results, common: (f64, f64)) -> Vec<Signal> {
    let others = other.signals();
    let cut = |signal: Signal| {
        let partner = others.iter().find(|s| s.name == signal.name);
        // Forces end a part of a step earlier.
        let own = |s: &Signal| s.span().unwrap_or(common);
        let span = partner.map_or(common, |p| (own(p).0.max(own(&signal).0), own(p).1.min(own(&signal).1)));
        signal.within(span)
    };
    run.signals().into_iter().map(cut).collect()
}

/// Sets the numbers of `second` beside those of `first`, both over the time that they have in common: what a run
/// computed later does not count, and periods are looked for before.
///
/// `None` if they have no time in common.
pub fn difference(first: &Results, second: &Results) -> Option<Difference> {
    let common = common_time(first, second);
    if common.is_some_and(|(start, end)| end < start) {
        return None;
    }
    let found = |run: &Results, other: &Results| match common {
        Some(common) => numbers(&cut(run, other, common), run.leading()),
        None => run.computed(),
    };
    let (first_found, second_found) = (found(first, second), found(second, first));
    let (mut rows, mut other_units) = (Vec::new(), Vec::new());
    for (functional, a) in &first_found {
        let Some(b) = second_found.get(functional) else { continue };
        if a.unit != b.unit {
            other_units.push(format!("{functional} in {} and {}", a.unit, b.unit));
            continue;
        }
        for ((quantity, x), (_, y)) in a.numbers.named().into_iter().zip(b.numbers.named()) {
            if let (Some(x), Some(y)) = (x, y) {
                rows.push(DifferenceRow {
                    functional: functional.clone(),
                    quantity,
                    unit: unit_of(quantity, &a.unit),
                    values: [x, y],
                    deviation: deviation(y, x, quantity, &a.numbers),
                });
            }
        }
    }
    let only = |a: &BTreeMap<String, _>, b: &BTreeMap<String, _>| -> Vec<String> {
        a.keys().filter(|name| !b.contains_key(*name)).cloned().collect()
    };
    let unmatched = [only(&first_found, &second_found), only(&second_found, &first_found)].concat();
    Some(Difference {
        names: [first.name.clone(), second.name.clone()],
        common,
        rows,
        unmatched,
        other_units,
    })
}

/// Six significant digits.
fn digits(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e6).contains(&size) {
        let before = size.log10().floor() as i32;
        format!("{x:.*}", usize::try_from(5 - before).unwrap_or(0))
    } else {
        format!("{x:.5e}")
    }
}

/// A time as it was computed, but for rounding.
fn time(t: f64) -> f64 {
    (t * 1e9).round() / 1e9
}

/// As many digits as were published.
fn as_published(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

fn percent(x: Option<f64>, signed: bool) -> String {
    match x {
        None => "-".into(),
        Some(x) if signed => format!("{:+.3} %", 100.0 * x),
        Some(x) => format!("{} %", (1e8 * x).round() / 1e6),
    }
}

/// Writes rows in columns; `right` names the columns that are flush right.
fn columns(f: &mut fmt::Formatter<'_>, rows: &[Vec<String>], right: &[usize]) -> fmt::Result {
    let n = rows.first().map_or(0, Vec::len);
    let width = |j: usize| rows.iter().map(|r| r[j].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..n).map(width).collect();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate();
        let line: Vec<String> = cells
            .map(
                |(j, (cell, w))| {
                    if right.contains(&j) { format!("{cell:>w$}") } else { format!("{cell:<w$}") }
                },
            )
            .collect();
        writeln!(f, "{}", line.join("  ").trim_end())?;
    }
    Ok(())
}

fn heading(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| w.to_string()).collect()
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}\n", self.case, self.status)?;
        let words = ["functional", "", "unit", "computed", "published", "deviation", "uncertainty", "source"];
        let mut rows = vec![heading(&words)];
        let mut last = None;
        for row in &self.rows {
            // What stays the same from row to row is written once.
            let first = last != Some((&row.functional, row.quantity));
            let same_functional = last.is_some_and(|(functional, _)| *functional == row.functional);
            last = Some((&row.functional, row.quantity));
            let once = |text: String, shown: bool| if shown { text } else { String::new() };
            rows.push(vec![
                once(row.functional.clone(), !same_functional),
                once(row.quantity.into(), first),
                once(row.unit.clone(), first),
                once(row.computed.map_or("-".into(), digits), first),
                as_published(row.published),
                percent(row.deviation, true),
                row.uncertainty.map_or(String::new(), |x| percent(Some(x), false)),
                row.source.clone(),
            ]);
        }
        columns(f, &rows, &[3, 4, 5, 6])?;
        if self.rows.iter().any(|r| r.quantity == "mean") {
            writeln!(f, "\nDeviations of a mean are relative to the amplitude where that is larger.")?;
        }
        if !self.unpublished.is_empty() {
            writeln!(f, "\nWithout published values: {}", self.unpublished.join(", "))?;
        }
        for departure in &self.left_out {
            writeln!(f, "\nNot what was published: {departure}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((start, end)) = self.common {
            writeln!(f, "From {} s to {} s, which both runs have:\n", time(start), time(end))?;
        }
        let mut rows =
            vec![heading(&["functional", "", "unit", &self.names[0], &self.names[1], "deviation"])];
        let mut last = None;
        for row in &self.rows {
            let same = last == Some(&row.functional);
            last = Some(&row.functional);
            rows.push(vec![
                if same { String::new() } else { row.functional.clone() },
                row.quantity.into(),
                row.unit.clone(),
                digits(row.values[0]),
                digits(row.values[1]),
                percent(row.deviation, true),
            ]);
        }
        columns(f, &rows, &[3, 4, 5])?;
        if !self.unmatched.is_empty() {
            writeln!(f, "\nOnly in one of them: {}", self.unmatched.join(", "))?;
        }
        if !self.other_units.is_empty() {
            writeln!(f, "\nNot compared, in different units: {}", self.other_units.join(", "))?;
        }
        Ok(())
    }
}
