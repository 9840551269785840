//! The TOML of a case with overrides applied and the origin of every value; nothing is decided here.

use super::error::{CaseError, Place};
use super::key;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where a value comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// Bytes of the file.
    File(Range<usize>),
    /// Index of the override.
    Set(usize),
}

/// A value as written.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    String(String),
    Integer(i64),
    Float(f64),
    Array(Vec<Item>),
    Table(Table),
    /// A value of a type no key takes: its type, and the text.
    Other(&'static str, String),
}

/// A value, its origin and that of its key.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub key: Origin,
    pub origin: Origin,
    pub value: Value,
}

/// Keys in the order of the file, then of the overrides.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table(pub Vec<(String, Item)>);

impl Table {
    pub fn get(&self, key: &str) -> Option<&Item> {
        self.0.iter().find(|(k, _)| k == key).map(|(_, item)| item)
    }

    /// Whether one of these `keys`, here or in a table below, has an array of `length` values.
    pub fn has_array(&self, keys: &[&str], length: usize) -> bool {
        self.0.iter().any(|(key, item)| match &item.value {
            Value::Array(items) => items.len() == length && keys.contains(&key.as_str()),
            Value::Table(table) => table.has_array(keys, length),
            _ => false,
        })
    }
}

impl Value {
    /// The type in words.
    pub fn kind(&self) -> &'static str {
        match self {
            Value::String(_) => "a string",
            Value::Integer(_) => "an integer",
            Value::Float(_) => "a number",
            Value::Array(_) => "an array",
            Value::Table(_) => "a table",
            Value::Other(kind, _) => kind,
        }
    }

    /// The value in TOML.
    fn text(&self) -> String {
        match self {
            Value::String(s) => format!("{s:?}"),
            Value::Integer(i) => i.to_string(),
            Value::Float(x) => super::literal::number(*x),
            Value::Array(items) => {
                format!("[{}]", items.iter().map(|i| i.value.text()).collect::<Vec<_>>().join(", "))
            }
            Value::Table(_) => "{…}".into(),
            Value::Other(_, text) => text.clone(),
        }
    }
}

/// A case file with its overrides.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    pub file_name: String,
    pub text: String,
    pub overrides: Vec<String>,
    pub root: Table,
}

/// So many mistakes in the syntax of a file are told.
const TOLD: usize = 10;

impl Document {
    /// Parses `text` and applies `overrides` (`key=value` each, later ones win).
    pub fn parse(text: &str, file_name: &str, overrides: &[String]) -> Result<Self, Vec<CaseError>> {
        let mut document = Self {
            file_name: file_name.into(),
            text: text.into(),
            overrides: overrides.to_vec(),
            root: Table::default(),
        };
        let (table, mistakes) = DeTable::parse_recoverable(text);
        let mut errors: Vec<CaseError> = mistakes
            .iter()
            .map(|e| CaseError {
                place: document.place(&Origin::File(e.span().unwrap_or(0..0))),
                key: String::new(),
                value: None,
                message: format!("not TOML: {}", e.message().replace('\n', ", ")),
            })
            .collect();
        let left = errors.len().saturating_sub(TOLD);
        if left > 1 {
            errors.truncate(TOLD);
            let message = format!("not TOML, like this, in {left} more places; is this a case file?");
            errors.push(CaseError { message, ..errors[TOLD - 1].clone() });
        }
        document.root = convert_table(table.get_ref(), &Origin::File);
        for (index, text) in overrides.iter().enumerate() {
            if let Err(message) = set(&mut document.root, text, index) {
                errors.push(CaseError {
                    place: Place::Set(text.clone()),
                    key: String::new(),
                    value: None,
                    message,
                });
            }
        }
        if errors.is_empty() { Ok(document) } else { Err(errors) }
    }

    /// The value as written, shortened for messages.
    pub fn shown(&self, item: &Item) -> String {
        let written = match &item.origin {
            Origin::File(span) => self.text.get(span.clone()).filter(|t| !t.contains('\n')),
            Origin::Set(_) => None,
        };
        let text = written.map_or_else(|| item.value.text(), str::to_string);
        if text.chars().count() > 60 { text.chars().take(59).chain(['…']).collect() } else { text }
    }

    /// The place for people.
    pub fn place(&self, origin: &Origin) -> Place {
        match origin {
            Origin::Set(index) => Place::Set(self.overrides.get(*index).cloned().unwrap_or_default()),
            Origin::File(span) => {
                let before = self.text.get(..span.start.min(self.text.len())).unwrap_or(&self.text);
                let line_start = before.rfind('\n').map_or(0, |i| i + 1);
                Place::File {
                    name: self.file_name.clone(),
                    line: before.matches('\n').count() + 1,
                    column: before[line_start..].chars().count() + 1,
                }
            }
        }
    }
}

fn convert_table(table: &DeTable<'_>, origin: &dyn Fn(Range<usize>) -> Origin) -> Table {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    Table(entries.into_iter().map(|(k, v)| (k.get_ref().to_string(), convert(k.span(), v, origin))).collect())
}

fn convert(key: Range<usize>, value: &Spanned<DeValue<'_>>, origin: &dyn Fn(Range<usize>) -> Origin) -> Item {
    let other = |kind, text: String| Value::Other(kind, text);
    let converted = match value.get_ref() {
        DeValue::String(s) => Value::String(s.to_string()),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(n) => Value::Integer(n),
            Err(_) => other("an integer out of range", i.to_string()),
        },
        DeValue::Float(x) => match x.as_str().parse::<f64>() {
            Ok(x) => Value::Float(x),
            Err(_) => other("not a number", x.to_string()),
        },
        DeValue::Boolean(b) => other("true or false", b.to_string()),
        DeValue::Datetime(d) => other("a date", d.to_string()),
        DeValue::Array(items) => Value::Array(items.iter().map(|v| convert(v.span(), v, origin)).collect()),
        DeValue::Table(table) => Value::Table(convert_table(table, origin)),
    };
    Item { key: origin(key), origin: origin(value.span()), value: converted }
}

/// Applies one override: `a.b.c=value`, the value in TOML or else a bare string; `none` removes the key.
fn set(root: &mut Table, text: &str, index: usize) -> Result<(), String> {
    let (path, value) = key::split_override(text)?;
    let Some((last, tables)) = path.split_last() else { return Ok(()) };
    let value = value.trim();
    if value.is_empty() {
        return Err("expected a value after `=` (`none` removes the key)".into());
    }
    let removes = value == "none" && !key::takes_none(&path);
    let mut table = root;
    for (depth, part) in tables.iter().enumerate() {
        let found = table.0.iter().position(|(k, _)| k == part);
        let position = match found {
            Some(position) => position,
            None if removes => return Ok(()),
            None => {
                let value = Value::Table(Table::default());
                table.0.push((
                    part.to_string(),
                    Item { key: Origin::Set(index), origin: Origin::Set(index), value },
                ));
                table.0.len() - 1
            }
        };
        match &mut table.0[position].1.value {
            Value::Table(inner) => table = inner,
            other => {
                let whole = path[..=depth].iter().fold(String::new(), |path, part| key::join(&path, part));
                return Err(format!("`{whole}` is {}, it has no keys", other.kind()));
            }
        }
    }
    if removes {
        table.0.retain(|(k, _)| k != last);
        return Ok(());
    }
    let origin = |_| Origin::Set(index);
    let item = match DeValue::parse(value) {
        Ok(parsed) => convert(0..0, &parsed, &origin),
        Err(_) if value.starts_with(['[', '{', '"', '\'']) => {
            return Err(format!("`{value}` is not a TOML value"));
        }
        Err(_) => Item { key: origin(0..0), origin: origin(0..0), value: bare(value) },
    };
    match table.0.iter_mut().find(|(k, _)| k == last) {
        Some((_, old)) => *old = item,
        None => table.0.push((last.to_string(), item)),
    }
    Ok(())
}

/// What TOML does not take: numbers such as `.3` and `1.`, else a string without its quotes.
fn bare(text: &str) -> Value {
    let like_number = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-'));
    match text.parse() {
        Ok(x) if like_number => Value::Float(x),
        _ => Value::String(text.into()),
    }
}
