//! Functions of one argument that are given by a table of values.

use super::own::OwnFunction;
use std::path::PathBuf;

/// Words for [`Interpolation`].
const WORDS: [&str; 3] = ["linear", "cubic", "periodic"];

/// An argument that lies beyond an end by this part of the arguments is at the end: sums of time steps are rounded.
const ROUNDING: f64 = 1e-9;

/// The hash of all functions of programs, whose content is not known.
const OWN: &str = "own";

/// How the values of a table are joined.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Interpolation {
    /// By cubic polynomials with continuous derivatives, instead of straight lines.
    pub cubic: bool,
    /// The table is one period.
    pub periodic: bool,
}

impl Interpolation {
    /// That of words such as `cubic periodic`.
    ///
    /// # Errors
    /// What is wrong with the words.
    pub(super) fn of(words: &str) -> Result<Interpolation, String> {
        let given: Vec<&str> = words.split_whitespace().collect();
        if let Some(other) = given.iter().find(|word| !WORDS.contains(word)) {
            let hint = crate::case::error::suggestion(other, WORDS.into_iter());
            return Err(format!("`{other}` is no way to join the values of a table{hint}"));
        }
        let has = |word| given.contains(&word);
        if has("linear") && has("cubic") {
            return Err("a table is either `linear` or `cubic`".into());
        }
        Ok(Interpolation { cubic: has("cubic"), periodic: has("periodic") })
    }
}

/// A row of a table.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Row {
    /// In the first column.
    pub argument: f64,
    /// In the second column.
    pub value: f64,
}

/// Values v_i at arguments a_0 < a_1 < … < a_n of a file, and a function that takes them.
///
/// With s = (a − a_i)/h between a_i and a_i+1 = a_i + h, the function is (1 − s) v_i + s v_i+1 if linear. If cubic, it is
/// the Hermite polynomial with the slopes d_i of Fritsch and Carlson (1980): those of the parabola through a_i and its
/// neighbours, but 0 where the values turn around and at most 3 times the slopes of the straight lines to both sides. Such a
/// function has a continuous derivative and rises and falls with the values only, so that it leaves their range nowhere.
/// Linear tables of a smooth function have errors of h²; cubic ones at most of h³, but of h² beside extrema between the
/// rows.
#[derive(Clone, Debug)]
pub struct Table {
    /// The file, an absolute path.
    pub(crate) path: PathBuf,
    /// Whether it was given by a path relative to the case: the two are moved together.
    pub(crate) relative: bool,
    /// [`crate::output::hash`] of its content.
    pub(crate) hash: String,
    interpolation: Interpolation,
    /// At least two, or none if the file was not read: the value is then 1, so that the rest of a case can be understood.
    rows: Vec<Row>,
    /// d_i of cubic tables.
    slopes: Vec<f64>,
    /// In place of the rows, a function of the program whose name the path is.
    pub(crate) own: Option<OwnFunction>,
}

/// Whether the functions are equal, wherever the files are.
impl PartialEq for Table {
    fn eq(&self, other: &Self) -> bool {
        self.hash == other.hash && self.interpolation == other.interpolation && self.own == other.own
    }
}

impl Table {
    /// The table of `rows`, whose arguments rise.
    pub(super) fn new(file: (PathBuf, bool), hash: String, how: Interpolation, rows: Vec<Row>) -> Table {
        let slopes = if how.cubic && !rows.is_empty() { slopes(&rows, how.periodic) } else { vec![] };
        Table { path: file.0, relative: file.1, hash, interpolation: how, rows, slopes, own: None }
    }

    /// The function `own` of the program, called `name`.
    pub(super) fn of_program(name: &str, own: OwnFunction) -> Table {
        let table = Table::new((PathBuf::from(name), false), OWN.into(), Interpolation::default(), vec![]);
        Table { own: Some(own), ..table }
    }

    /// First and last argument.
    pub(crate) fn range(&self) -> Option<[f64; 2]> {
        Some([self.rows.first()?.argument, self.rows.last()?.argument])
    }

    /// The number i of the interval that `argument` is in, and its place s there from 0 to 1; `None` if it is in none.
    #[inline]
    fn find(&self, argument: f64) -> Option<(usize, f64)> {
        let [first, last] = self.range()?;
        let mut a = argument;
        if self.interpolation.periodic {
            a = first + (argument - first).rem_euclid(last - first);
            // A period may be what is left by rounding.
            a = if a >= last { first } else { a };
        } else {
            let slack = ROUNDING * first.abs().max(last.abs());
            a = if a < first && a >= first - slack { first } else { a };
            a = if a > last && a <= last + slack { last } else { a };
        }
        if !(first..=last).contains(&a) {
            return None;
        }
        let i = self.rows.partition_point(|row| row.argument <= a).min(self.rows.len() - 1) - 1;
        let (left, right) = (self.rows[i].argument, self.rows[i + 1].argument);
        Some((i, (a - left) / (right - left)))
    }

    /// The value at `argument`; NaN beyond the ends of a table that is not periodic.
    #[inline]
    pub(super) fn value(&self, argument: f64) -> f64 {
        let Some((i, s)) = self.find(argument) else { return self.other(argument) };
        let (left, right) = (&self.rows[i], &self.rows[i + 1]);
        if !self.interpolation.cubic {
            return (1.0 - s) * left.value + s * right.value;
        }
        let (h, weight) = (right.argument - left.argument, s * s * (3.0 - 2.0 * s));
        let bend = h * s * (1.0 - s) * ((1.0 - s) * self.slopes[i] - s * self.slopes[i + 1]);
        (1.0 - weight) * left.value + weight * right.value + bend
    }

    /// The derivative at `argument`; of a linear table to the right of a row.
    pub(super) fn slope(&self, argument: f64) -> f64 {
        let Some((i, s)) = self.find(argument) else { return self.other_slope(argument) };
        let line = line(&self.rows[i], &self.rows[i + 1]);
        if !self.interpolation.cubic {
            return line;
        }
        let (left, right) = (self.slopes[i], self.slopes[i + 1]);
        6.0 * s * (1.0 - s) * line + (1.0 - s) * (1.0 - 3.0 * s) * left + s * (3.0 * s - 2.0) * right
    }

    /// The value where no rows have one.
    #[cold]
    fn other(&self, argument: f64) -> f64 {
        self.own.as_ref().map_or(self.nothing(1.0), |own| own.value(argument))
    }

    #[cold]
    fn other_slope(&self, argument: f64) -> f64 {
        self.own.as_ref().map_or(self.nothing(0.0), |own| own.slope(argument))
    }

    /// What stands in place of a value: NaN beyond the ends, `unread` if the file was not read.
    fn nothing(&self, unread: f64) -> f64 {
        if self.rows.is_empty() { unread } else { f64::NAN }
    }
}

/// The slope of the straight line between two rows.
fn line(left: &Row, right: &Row) -> f64 {
    (right.value - left.value) / (right.argument - left.argument)
}

/// d_i of all rows.
fn slopes(rows: &[Row], periodic: bool) -> Vec<f64> {
    let lines: Vec<(f64, f64)> =
        rows.windows(2).map(|w| (w[1].argument - w[0].argument, line(&w[0], &w[1]))).collect();
    let n = lines.len();
    let inner = |left: (f64, f64), right: (f64, f64)| {
        let parabola = (right.0 * left.1 + left.0 * right.1) / (left.0 + right.0);
        if left.1 * right.1 <= 0.0 { 0.0 } else { limited(parabola, left.1.abs().min(right.1.abs())) }
    };
    // At an end, of the parabola through the three rows there.
    let end = |near: (f64, f64), far: Option<&(f64, f64)>| {
        let Some(far) = far else { return near.1 };
        let parabola = near.1 + near.0 * (near.1 - far.1) / (near.0 + far.0);
        if parabola * near.1 <= 0.0 { 0.0 } else { limited(parabola, near.1.abs()) }
    };
    let (first, last) = if periodic {
        let seam = inner(lines[n - 1], lines[0]);
        (seam, seam)
    } else {
        (end(lines[0], lines.get(1)), end(lines[n - 1], n.checked_sub(2).map(|i| &lines[i])))
    };
    let between = lines.windows(2).map(|w| inner(w[0], w[1]));
    std::iter::once(first).chain(between).chain([last]).collect()
}

/// `slope`, at most three times as steep as `line`.
fn limited(slope: f64, line: f64) -> f64 {
    slope.clamp(-3.0 * line, 3.0 * line)
}
