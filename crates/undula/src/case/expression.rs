//! Expressions of x, y, z, t in a case file.
//!
//! A source text becomes a short program for a stack machine: `parse` turns text into a tree and
//! reports mistakes with their byte position, `program` folds constants and flattens the tree. An
//! evaluation allocates nothing.
//!
//! | | |
//! | --- | --- |
//! | variables | `x`, `y`, `z` \[m\], `t` \[s\] |
//! | constant | `pi` |
//! | operators | `^` (from the right), unary `-` and `+`, `*` `/`, `+` `-`, `<` `<=` `>` `>=` (0 or 1) |
//! | functions | `sin cos tan asin acos atan atan2 sinh cosh tanh exp ln log10 sqrt abs sign floor ceil min max pow hypot` |
//! | cases | `step(a)`: 0 for a < 0, else 1; `if(condition, a, b)`; `clamp(a, low, high)` |
//! | start-up | `ramp(t, T)`: 0 for t < 0, ½(1 − cos(πt/T)) up to T, then 1 |
//! | tables | `table("file.csv", t)`, `table("file.csv", t, "cubic periodic")`: values of a file, see [`Table`] |
//! | units | `80 [mmHg]`: a number in SI units, see [`crate::case::unit`] |
//!
//! All numbers are real numbers: `1/2` is 0.5.

mod derivative;
mod functions;
mod own;
mod parse;
mod program;
mod rows;
mod table;
mod tree;

pub(crate) use functions::is_name;
pub(crate) use own::Functions;
pub use own::OwnFunction;
use parse::Parsed;
use program::Program;
pub(crate) use rows::Files;
use std::fmt;
use std::path::Path;
pub use table::Table;

/// A compiled expression of x, y, z and t.
///
/// Two expressions are equal if they compile to the same program, so `0.50 * x` equals `x/2`
/// only if it is written in the same way, but `1/2` equals `0.5`.
///
/// ```
/// use undula::case::expression::Expression;
/// let parabola = Expression::parse("4*y*(0.41-y)/0.41^2 * ramp(t, 2)")?;
/// assert!((parabola.eval(&[0.0, 0.205, 0.0], 1.0) - 0.5).abs() < 1e-15);
/// # Ok::<(), undula::case::expression::ExpressionError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Expression {
    source: String,
    program: Program,
}

/// Why a text is not an expression.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message} (at byte {position})")]
pub struct ExpressionError {
    /// Byte of the source where the mistake is, counted from 0.
    pub position: usize,
    /// What is wrong, and what would be right if that can be guessed.
    pub message: String,
}

fn error<T>(position: usize, message: String) -> Result<T, ExpressionError> {
    Err(ExpressionError { position, message })
}

/// Names that an expression may use besides its own, each a number: results of runs.
pub trait Names {
    /// The number that `name` stands for, or why there is none; `None` if it is no name of these.
    fn value(&self, name: &str) -> Option<Result<f64, String>>;
    /// Whether `name` may be an argument of a function of these.
    fn is_signal(&self, name: &str) -> bool;
    /// Whether there is a function of this name, which takes names, then numbers.
    fn has_function(&self, name: &str) -> bool;
    /// Its value.
    ///
    /// # Errors
    /// What is wrong with the arguments.
    fn call(&self, function: &str, of: &[&str], numbers: &[f64]) -> Result<f64, String>;
}

/// The value of an expression of `names`; `and` and `or` combine comparisons.
///
/// # Errors
/// As [`Expression::parse`]; x, y, z and t are no names here.
pub fn evaluate(source: &str, names: &dyn Names) -> Result<f64, ExpressionError> {
    let program = Program::compile(&parse::parse(source, Some(names), Files::Unread)?.tree, vec![])?;
    let variable = ExpressionError { position: 0, message: "x, y, z and t are no names of results".into() };
    program.as_constant().ok_or(variable)
}

impl Expression {
    /// No expression yet, in tables of values that have one; its value is 0.
    pub(crate) const EMPTY: Expression = Expression { source: String::new(), program: Program::EMPTY };

    /// Compiles `source`. Tables are read from the working directory, where their paths are relative.
    ///
    /// # Errors
    /// Says what is wrong and at which byte; of a table, in which line of its file.
    ///
    /// ```
    /// # use undula::case::expression::Expression;
    /// let error = Expression::parse("1.5*sinn(y)").unwrap_err();
    /// assert_eq!(error.to_string(), "unknown function `sinn`; did you mean `sin`? (at byte 4)");
    /// ```
    pub fn parse(source: &str) -> Result<Self, ExpressionError> {
        Self::parse_in(source, Files::In(Path::new(""), Functions::NONE))
    }

    /// The same with tables from `files`.
    pub(crate) fn parse_in(source: &str, files: Files<'_>) -> Result<Self, ExpressionError> {
        let Parsed { tree, calls, written } = parse::parse(source, None, files)?;
        let program = Program::compile(&tree, calls)?;
        Ok(Self { source: written, program })
    }

    /// The same value everywhere and always.
    pub fn constant(value: f64) -> Self {
        Self { source: value.to_string(), program: Program::constant(value) }
    }

    /// Value at the point `x` \[m\] and time `t` \[s\].
    #[inline]
    pub fn eval(&self, x: &[f64; 3], t: f64) -> f64 {
        self.program.run(x, t)
    }

    /// Value and partial derivatives with respect to x, y, z at the point `x` \[m\] and time `t` \[s\]. Where the
    /// expression has a kink or a jump the derivative is that of one side.
    pub fn eval_with_gradient(&self, x: &[f64; 3], t: f64) -> (f64, [f64; 3]) {
        let slope = self.program.run_with_slope(x, t);
        (slope.value, slope.partial)
    }

    /// Value and derivative with respect to t at the point `x` \[m\] and time `t` \[s\]. Where the expression has a kink
    /// or a jump the derivative is that of one side.
    pub fn eval_with_rate(&self, x: &[f64; 3], t: f64) -> (f64, f64) {
        let slope = self.program.run_with_rate(x, t);
        (slope.value, slope.partial[0])
    }

    /// Whether the value is the same everywhere and always.
    pub fn is_constant(&self) -> bool {
        self.constant_value().is_some()
    }

    /// Whether the value is 0 everywhere and always.
    pub fn is_zero(&self) -> bool {
        self.constant_value() == Some(0.0)
    }

    /// The value, if it is the same everywhere and always.
    pub fn constant_value(&self) -> Option<f64> {
        self.program.as_constant()
    }

    /// Whether `t` occurs.
    pub fn depends_on_time(&self) -> bool {
        self.program.depends_on_time()
    }

    /// Whether `x`, `y` or `z` occurs.
    pub fn depends_on_space(&self) -> bool {
        self.program.depends_on_space()
    }

    /// Whether `x` or `y` occurs.
    pub(crate) fn depends_across(&self) -> bool {
        self.program.depends_across()
    }

    /// Whether `z` occurs.
    pub(crate) fn depends_on_depth(&self) -> bool {
        self.program.depends_on_depth()
    }

    /// The text it was made from, in SI units.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The tables in it, inner ones first.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.program.calls.iter().map(|call| &*call.table)
    }

    /// Names the files of its tables anew.
    pub(crate) fn name_tables(&mut self, name: impl Fn(&Table) -> String) {
        // By how many bytes what follows has moved.
        let mut moved = 0;
        let mut calls: Vec<_> = self.program.calls.iter_mut().collect();
        calls.sort_by_key(|call| call.name.start);
        for call in calls {
            let name = name(&call.table);
            let quote = if name.contains('"') { '\'' } else { '"' };
            let text = format!("{quote}{name}{quote}");
            let old = call.name.start.wrapping_add_signed(moved)..call.name.end.wrapping_add_signed(moved);
            moved += text.len() as isize - old.len() as isize;
            call.name = old.start..old.start + text.len();
            self.source.replace_range(old, &text);
        }
    }

    /// Which table has no value at the point `x` \[m\] and time `t` \[s\], in words; empty if all have one.
    pub fn gap(&self, x: &[f64; 3], t: f64) -> String {
        let Some((call, argument)) = self.program.gap(x, t) else { return String::new() };
        if call.table.own.is_some() {
            let name = call.table.path.display();
            return format!("; the function `{name}` of the program has no value at {argument}");
        }
        let [first, last] = call.table.range().unwrap_or_default();
        let (file, text) = (call.table.path.display(), &call.argument);
        format!(
            "; the table {file} has arguments from {first} to {last}, `{text}` is {argument}: take more rows, \
             `clamp({text}, {first}, {last})` as the argument, which keeps the values of the ends, or `\"periodic\"`"
        )
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.program == other.program
    }
}

impl Default for Expression {
    /// The constant 0.
    fn default() -> Self {
        Self::constant(0.0)
    }
}

impl From<f64> for Expression {
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.source)
    }
}

impl serde::Serialize for Expression {
    /// A plain number as a number, all else as its source.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.source.parse::<f64>() {
            Ok(value) => serializer.serialize_f64(value),
            Err(_) => serializer.serialize_str(&self.source),
        }
    }
}

#[cfg(test)]
mod tests;
