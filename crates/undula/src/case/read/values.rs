//! Values by their type: each method takes a key, tells what is wrong with its value, and goes on.

use super::{ANY, Range, Section};
use crate::case::error::{did_you_mean, quoted};
use crate::case::expression::{self, Expression};
use crate::case::fibres::FibreDirection;
use crate::case::raw::{Item, Origin, Value};
use crate::case::{keys, unit};
use crate::choice::{self, Choice};
use crate::space::Coordinates;

impl Section<'_, '_> {
    pub fn optional_number(&mut self, key: &str, range: Range) -> Option<f64> {
        let item = self.item(key)?;
        self.number_of(key, item, range)
    }

    /// The number of an item, in SI units, if it is one in `range`; else what is wrong is told.
    pub(super) fn number_of(&self, key: &str, item: &Item, range: Range) -> Option<f64> {
        match self.value_of(key, &item.value) {
            Some(Ok(value)) if (range.holds)(value) => return Some(value),
            Some(Ok(_)) => self.wrong_item(key, item, format!("expected {}", range.text)),
            Some(Err(message)) => self.wrong_item(key, item, message),
            None => self.wrong_type(key, item, range.text),
        }
        None
    }

    /// The number that a value of `key` is, with or without a unit, in SI units; what is wrong with the unit.
    pub(super) fn value_of(&self, key: &str, value: &Value) -> Option<Result<f64, String>> {
        match value {
            Value::Float(x) => Some(Ok(*x)),
            Value::Integer(i) => Some(Ok(*i as f64)),
            Value::String(text) => {
                let found = unit::quantity(text)?;
                Some(found.and_then(|(value, dimension)| {
                    unit::mismatch(dimension, &self.unit_of(key)).map_or(Ok(value), Err)
                }))
            }
            _ => None,
        }
    }

    /// The unit of `key`, which may have an index such as `velocity[0]`.
    fn unit_of(&self, key: &str) -> String {
        let (name, index) = key.strip_suffix(']').and_then(|key| key.rsplit_once('[')).unwrap_or((key, ""));
        let units = keys::find(&self.dotted(name)).map_or("", |key| key.unit);
        let mut each = units.split(", ");
        let unit = each.nth(index.parse().unwrap_or(0)).or(units.split(", ").next()).unwrap_or("");
        // Around an axis what belongs to a whole boundary is that of space.
        let whole = self.dotted(name).starts_with("boundary.");
        if whole { self.checker.unit(unit).into() } else { unit.into() }
    }

    pub fn number(&mut self, key: &str, default: f64, range: Range) -> f64 {
        self.optional_number(key, range).unwrap_or(default)
    }

    /// A number that has no default; after a mistake 1, which is never used.
    pub fn required_number(&mut self, key: &str, range: Range, meaning: &str) -> f64 {
        if !self.has(key) {
            self.missing(key, meaning);
        }
        self.number(key, 1.0, range)
    }

    pub fn integer(&mut self, key: &str, default: usize, range: std::ops::RangeInclusive<usize>) -> usize {
        let Some(item) = self.item(key) else { return default };
        let value = match item.value {
            Value::Integer(i) => usize::try_from(i).ok(),
            _ => None,
        };
        match value {
            Some(value) if range.contains(&value) => value,
            _ => {
                let expected = match *range.end() {
                    usize::MAX => format!("an integer, {} or above", range.start()),
                    end => format!("an integer from {} to {end}", range.start()),
                };
                self.wrong_type(key, item, &expected);
                default
            }
        }
    }

    pub fn boolean(&mut self, key: &str, default: bool) -> bool {
        let Some(item) = self.item(key) else { return default };
        match &item.value {
            Value::Other("true or false", text) => text == "true",
            _ => {
                self.wrong_type(key, item, "true or false");
                default
            }
        }
    }

    pub fn string(&mut self, key: &str) -> Option<String> {
        let item = self.item(key)?;
        match &item.value {
            Value::String(s) => Some(s.clone()),
            _ => {
                self.wrong_type(key, item, "a string");
                None
            }
        }
    }

    /// Whether the value of `key` is this word.
    pub fn is_word(&mut self, key: &str, word: &str) -> bool {
        matches!(self.item(key).map(|item| &item.value), Some(Value::String(s)) if s == word)
    }

    /// One of `available`; `later` are names that are known but have nothing behind them yet.
    pub fn choice<T: Clone>(
        &mut self,
        key: &str,
        available: &[Choice<T>],
        later: &[&'static str],
    ) -> Option<T> {
        let item = self.item(key)?;
        let names = || choice::names(available);
        let Value::String(word) = &item.value else {
            self.wrong_type(key, item, &format!("one of {}", quoted(names())));
            return None;
        };
        if let Some(value) = choice::parse(available, word) {
            return Some(value.clone());
        }
        let message = if later.contains(&word.as_str()) {
            format!("not yet available; expected one of {}", quoted(names()))
        } else {
            let hint = did_you_mean(word, names().chain(later.iter().copied()));
            format!("expected one of {}{hint}", quoted(names()))
        };
        self.wrong_item(key, item, message);
        None
    }

    /// Tells that a choice is not there which has no default.
    pub fn require_choice<T>(&self, key: &str, available: &[Choice<T>]) {
        if !self.has(key) {
            self.missing(key, &format!("one of {}", quoted(choice::names(available))));
        }
    }

    pub(super) fn expression_of(&self, key: &str, item: &Item) -> Option<Expression> {
        let expression = match &item.value {
            Value::Float(x) => Expression::constant(*x),
            Value::Integer(i) => Expression::constant(*i as f64),
            Value::String(source) => match Expression::parse_in(source, self.checker.files(&item.origin)) {
                Ok(expression) => expression,
                Err(e) => {
                    // `2x` is a formula without its `*`, not a unit.
                    if !unit::begins_with(source, expression::is_name) {
                        match self.value_of(key, &item.value) {
                            Some(Ok(value)) => return Some(Expression::constant(value)),
                            Some(Err(message)) => {
                                self.wrong_item(key, item, message);
                                return None;
                            }
                            None => {}
                        }
                    }
                    let origin = self.inside(&item.origin, source, e.position);
                    self.checker.error(
                        &origin,
                        &self.dotted(key),
                        Some(self.checker.document.shown(item)),
                        e.to_string(),
                    );
                    return None;
                }
            },
            _ => {
                self.wrong_type(key, item, "a number or an expression in quotes");
                return None;
            }
        };
        if expression.constant_value().is_some_and(|x| !x.is_finite()) {
            self.wrong_item(key, item, "expected a finite value".into());
            return None;
        }
        if self.checker.is_plane.get() && expression.depends_on_depth() {
            let names = match self.checker.coordinates.get() {
                Coordinates::Cartesian => "x and y",
                Coordinates::Axisymmetric => "x, the radius, and y, the place along the axis",
            };
            let message =
                format!("the mesh is one of the plane and has no `z`: expected an expression of {names}");
            self.wrong_item(key, item, message);
            return None;
        }
        Some(expression)
    }

    /// The origin of byte `position` of a string, if the file shows the string as it is.
    fn inside(&self, origin: &Origin, source: &str, position: usize) -> Origin {
        let Origin::File(span) = origin else { return origin.clone() };
        let raw = self.checker.document.text.get(span.clone()).unwrap_or("");
        match raw.find(source) {
            Some(start) if raw.len() <= source.len() + 6 => {
                Origin::File(span.start + start + position..span.end)
            }
            _ => origin.clone(),
        }
    }

    pub fn expression(&mut self, key: &str) -> Option<Expression> {
        let item = self.item(key)?;
        self.expression_of(key, item)
    }

    fn pair_of<T>(
        &mut self,
        key: &str,
        expected: &str,
        read: impl Fn(&Self, &str, &Item) -> Option<T>,
    ) -> Option<[T; 2]> {
        let item = self.item(key)?;
        let Value::Array(items) = &item.value else {
            self.wrong_type(key, item, expected);
            return None;
        };
        let [a, b] = items.as_slice() else {
            self.wrong_item(key, item, format!("expected {expected}, not {} values", items.len()));
            return None;
        };
        let (a, b) = (read(self, &format!("{key}[0]"), a), read(self, &format!("{key}[1]"), b));
        Some([a?, b?])
    }

    /// An angle to the x axis, or expressions of x, y and, in space, z.
    pub fn direction(&mut self, key: &str) -> Option<FibreDirection> {
        let item = self.item(key)?;
        if !matches!(item.value, Value::Array(_)) {
            let angle = Range { text: "an angle, or two expressions as [\"-y\", \"x\"]", ..ANY };
            return self.number_of(key, item, angle).map(FibreDirection::Angle);
        }
        let field = self.vector_of(
            key,
            "expressions, as [\"-y\", \"x\"]",
            Expression::default(),
            |section, key, item| {
                let unit = matches!(&item.value, Value::String(text) if unit::quantity(text).is_some());
                if unit {
                    section.wrong_item(
                        key,
                        item,
                        "expected a component without unit: only the ratio counts".into(),
                    );
                    return None;
                }
                section.expression_of(key, item)
            },
        )?;
        if field.iter().any(Expression::depends_on_time) {
            self.wrong(key, "a direction of fibres cannot depend on t");
        }
        Some(FibreDirection::Field(field))
    }

    /// Two numbers in `range`.
    pub fn pair(&mut self, key: &str, range: Range) -> Option<[f64; 2]> {
        self.pair_of(key, "two numbers", |section, key, item| section.number_of(key, item, range))
    }

    /// A non-empty array of pairs of numbers.
    pub fn series(&mut self, key: &str) -> Option<Vec<[f64; 2]>> {
        let item = self.item(key)?;
        let number = |item: &Item| match item.value {
            Value::Float(x) if x.is_finite() => Some(x),
            Value::Integer(i) => Some(i as f64),
            _ => None,
        };
        let pair = |item: &Item| match &item.value {
            Value::Array(items) => match items.as_slice() {
                [a, b] => Some([number(a)?, number(b)?]),
                _ => None,
            },
            _ => None,
        };
        let pairs: Option<Vec<[f64; 2]>> = match &item.value {
            Value::Array(items) if !items.is_empty() => items.iter().map(pair).collect(),
            _ => None,
        };
        if pairs.is_none() {
            let expected = "expected an array of pairs of finite numbers, such as [[0.5, 0], [0.1, -0.2]]";
            self.wrong_item(key, item, expected.into());
        }
        pairs
    }

    /// An array of numbers in `range`; a single number counts as one.
    pub fn numbers(&mut self, key: &str, range: Range) -> Option<Vec<f64>> {
        let item = self.item(key)?;
        let value = |item: &Item| match item.value {
            Value::Float(x) => Some(x),
            Value::Integer(i) => Some(i as f64),
            _ => None,
        };
        let numbers: Option<Vec<f64>> = match &item.value {
            Value::Array(items) => items.iter().map(value).collect(),
            _ => value(item).map(|x| vec![x]),
        };
        let numbers = numbers.filter(|numbers| numbers.iter().all(|x| (range.holds)(*x)));
        if numbers.is_none() {
            self.wrong_item(key, item, "expected an array of numbers, such as [0.1, 0.25]".into());
        }
        numbers
    }

    /// An array of names in `available`, each once; a single name counts as one.
    pub fn choices<T: Clone + PartialEq>(&mut self, key: &str, available: &[Choice<T>]) -> Option<Vec<T>> {
        let item = self.item(key)?;
        let word = |item: &Item| match &item.value {
            Value::String(word) => Some(word.clone()),
            _ => None,
        };
        let words: Option<Vec<String>> = match &item.value {
            Value::Array(items) => items.iter().map(word).collect(),
            _ => word(item).map(|word| vec![word]),
        };
        let known = quoted(choice::names(available));
        let Some(words) = words else {
            self.wrong_item(key, item, format!("expected an array of names, each one of {known}"));
            return None;
        };
        let mut values: Vec<T> = vec![];
        for word in &words {
            let Some(value) = choice::parse(available, word) else {
                let hint = did_you_mean(word, choice::names(available));
                self.wrong_item(key, item, format!("`{word}`: expected one of {known}{hint}"));
                return None;
            };
            if !values.contains(value) {
                values.push(value.clone());
            }
        }
        Some(values)
    }

    /// A non-empty array of strings; a single string counts as one.
    pub fn strings(&mut self, key: &str) -> Option<Vec<String>> {
        self.names(key, "[\"cylinder\", \"interface\"]", 1)
    }

    /// An array of at least so many strings, such as `example`; a single string counts as one.
    pub fn names(&mut self, key: &str, example: &str, at_least: usize) -> Option<Vec<String>> {
        let item = self.item(key)?;
        let words: Option<Vec<String>> = match &item.value {
            Value::String(s) => Some(vec![s.clone()]),
            Value::Array(items) if items.len() >= at_least => items
                .iter()
                .map(|i| match &i.value {
                    Value::String(s) => Some(s.clone()),
                    _ => None,
                })
                .collect(),
            _ => None,
        };
        if words.is_none() {
            self.wrong_item(key, item, format!("expected an array of names, such as {example}"));
        }
        words
    }
}
