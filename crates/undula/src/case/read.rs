//! Reading of a table: the keys that it has and those that it was asked for, and what is wrong with them.

mod values;
mod vectors;

pub(super) use vectors::Vectors;

use super::error::{CaseError, did_you_mean, quoted};
use super::expression::{Files, Functions};
use super::raw::{Document, Item, Origin, Table, Value};
use super::schema::OwnMesh;
use super::{keys, synonyms};
use crate::space::Coordinates;
use crate::space::coordinates::unit_of_space;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::path::Path;

/// The document under check, and what was found so far.
pub(super) struct Checker<'d> {
    pub document: &'d Document,
    /// The mesh, if the program gives it.
    pub mesh: Option<&'d OwnMesh>,
    /// Functions that the program gives.
    pub functions: &'d Functions,
    /// Whether tables of values are read; else their values are 1.
    pub reads_tables: bool,
    /// Each with the byte it belongs to, to be sorted at the end.
    errors: RefCell<Vec<(usize, CaseError)>>,
    /// Settings without effect and parts left out.
    pub notes: RefCell<Vec<String>>,
    /// What the coordinates of the mesh mean, once that is read: integrals have other units around an axis.
    pub coordinates: Cell<Coordinates>,
    /// How many components vectors have, once the mesh is read.
    pub vectors: Cell<Vectors>,
    /// Whether the mesh is known to be one of the plane, once it is read.
    pub is_plane: Cell<bool>,
    /// Origin of each dotted key that was read.
    pub origins: RefCell<BTreeMap<String, Origin>>,
}

impl<'d> Checker<'d> {
    pub fn new(document: &'d Document, mesh: Option<&'d OwnMesh>, functions: &'d Functions) -> Self {
        let (errors, notes, origins, coordinates, vectors, is_plane) = Default::default();
        Self {
            document,
            mesh,
            functions,
            reads_tables: true,
            errors,
            notes,
            coordinates,
            vectors,
            is_plane,
            origins,
        }
    }

    /// Where tables are that a value from `origin` names: beside the case file, or in the working directory if it comes
    /// from `--set`.
    pub fn files(&self, origin: &Origin) -> Files<'_> {
        let folder = Path::new(&self.document.file_name).parent();
        match origin {
            _ if !self.reads_tables => Files::Unread,
            Origin::File(_) => Files::In(folder.unwrap_or(Path::new("")), self.functions),
            Origin::Set(_) => Files::In(Path::new(""), self.functions),
        }
    }

    /// The unit of an integral, or of what stands beside one, that has the unit `of_plane` per depth.
    pub fn unit(&self, of_plane: &'static str) -> &'static str {
        let in_plane = self.vectors.get() == Vectors::Plane && !self.coordinates.get().is_axisymmetric();
        if in_plane { of_plane } else { unit_of_space(of_plane) }
    }

    /// What should be known, though nothing is wrong.
    pub fn note(&self, note: impl Into<String>) {
        self.notes.borrow_mut().push(note.into());
    }

    pub fn error(&self, origin: &Origin, key: &str, value: Option<String>, message: String) {
        let place = self.document.place(origin);
        let order = match origin {
            Origin::File(span) => span.start,
            Origin::Set(index) => usize::MAX / 2 + index,
        };
        self.errors.borrow_mut().push((order, CaseError { place, key: key.into(), value, message }));
    }

    /// All mistakes in the order of the file, then of the overrides.
    pub fn into_errors(self) -> Vec<CaseError> {
        let mut errors = self.errors.into_inner();
        errors.sort_by_key(|(order, _)| *order);
        errors.into_iter().map(|(_, error)| error).collect()
    }

    pub fn root(&self) -> Section<'_, 'd> {
        Section {
            checker: self,
            path: String::new(),
            table: Some(&self.document.root),
            origin: Origin::File(0..0),
            known: Vec::new(),
            explained: Vec::new(),
        }
    }
}

/// What a number must be.
#[derive(Copy, Clone)]
pub(super) struct Range {
    pub holds: fn(f64) -> bool,
    pub text: &'static str,
}

pub(super) const ANY: Range = Range { holds: f64::is_finite, text: "a finite number" };
pub(super) const POSITIVE: Range = Range { holds: |x| x > 0.0 && x.is_finite(), text: "a number above 0" };
pub(super) const NOT_NEGATIVE: Range =
    Range { holds: |x| x >= 0.0 && x.is_finite(), text: "a number, 0 or above" };

/// One table of the case; collects the keys it was asked for.
pub(super) struct Section<'c, 'd> {
    pub checker: &'c Checker<'d>,
    pub path: String,
    table: Option<&'c Table>,
    pub origin: Origin,
    known: Vec<String>,
    /// Unknown keys with what is to be said of them.
    explained: Vec<(String, String)>,
}

impl<'c, 'd> Section<'c, 'd> {
    pub fn is_present(&self) -> bool {
        self.table.is_some()
    }

    pub fn has(&self, key: &str) -> bool {
        self.table.is_some_and(|t| t.get(key).is_some())
    }

    /// Number of values, if that of `key` is an array.
    pub fn length(&self, key: &str) -> Option<usize> {
        self.table.and_then(|t| t.get(key)).and_then(|item| match &item.value {
            Value::Array(items) => Some(items.len()),
            _ => None,
        })
    }

    /// Whether the value of `key` is a table.
    pub fn is_table(&self, key: &str) -> bool {
        self.table.and_then(|t| t.get(key)).is_some_and(|item| matches!(item.value, Value::Table(_)))
    }

    /// Whether the value of `key` is an array of tables.
    pub fn is_array_of_tables(&self, key: &str) -> bool {
        let tables = |items: &[Item]| items.iter().all(|item| matches!(item.value, Value::Table(_)));
        self.table.and_then(|t| t.get(key)).is_some_and(|item| match &item.value {
            Value::Array(items) => !items.is_empty() && tables(items),
            _ => false,
        })
    }

    /// Whether there is another key that can only mean `key`, about which [`Section::finish`] will tell.
    pub fn means(&self, key: &str) -> bool {
        self.keys().iter().any(|k| synonyms::meant(&self.path, k) == Some(key))
    }

    /// The number under `key` if there is one, which does not make it a known key.
    pub fn look_at_number(&self, key: &str) -> Option<f64> {
        self.value_of(key, &self.table?.get(key)?.value)?.ok()
    }

    /// Says `message` of `key` if it turns out to be unknown.
    pub fn explain(&mut self, key: &str, message: String) {
        self.explained.push((key.into(), message));
    }

    pub fn dotted(&self, key: &str) -> String {
        // An index such as `velocity[0]` is no part of its own.
        let index = key.rfind('[').filter(|_| key.ends_with(']') && !self.has(key));
        let (name, index) = key.split_at(index.unwrap_or(key.len()));
        format!("{}{index}", super::key::join(&self.path, name))
    }

    /// What should be known, though nothing is wrong.
    pub fn note(&self, note: impl Into<String>) {
        self.checker.note(note);
    }

    /// Tells that the value of `key` is wrong.
    pub fn wrong(&self, key: &str, message: impl Into<String>) {
        let item = self.table.and_then(|t| t.get(key));
        let (origin, value) = match item {
            None => (&self.origin, None),
            Some(Item { key, value: Value::Table(_), .. }) => (key, None),
            Some(item) => (&item.origin, Some(self.checker.document.shown(item))),
        };
        self.checker.error(origin, &self.dotted(key), value, message.into());
    }

    fn wrong_item(&self, key: &str, item: &Item, message: String) {
        self.checker.error(&item.origin, &self.dotted(key), Some(self.checker.document.shown(item)), message);
    }

    fn wrong_type(&self, key: &str, item: &Item, expected: &str) {
        let message = match &item.value {
            Value::String(_) | Value::Float(_) | Value::Integer(_) => format!("expected {expected}"),
            other => format!("expected {expected}, not {}", other.kind()),
        };
        self.wrong_item(key, item, message);
    }

    /// Tells that a required `key` is not there.
    pub fn missing(&self, key: &str, meaning: &str) {
        if self.is_present() && !self.means(key) {
            self.checker.error(&self.origin, &self.dotted(key), None, format!("missing: {meaning}"));
        }
    }

    /// The item of `key`, which becomes a known key.
    pub fn item(&mut self, key: &str) -> Option<&'c Item> {
        debug_assert!(keys::is_known(&self.dotted(key)), "{} is not in the table of keys", self.dotted(key));
        if !self.known.iter().any(|k| k == key) {
            self.known.push(key.to_string());
        }
        let item = self.table?.get(key)?;
        self.checker.origins.borrow_mut().insert(self.dotted(key), item.origin.clone());
        Some(item)
    }

    /// The table under `key`, possibly absent.
    pub fn section(&mut self, key: &str) -> Section<'c, 'd> {
        let item = self.item(key);
        if let Some(item) = item {
            self.checker.origins.borrow_mut().insert(self.dotted(key), item.key.clone());
        }
        let table = item.and_then(|i| match &i.value {
            Value::Table(table) => Some(table),
            _ => {
                self.wrong_type(key, i, &format!("a table [{}]", self.dotted(key)));
                None
            }
        });
        let origin = item.map_or(Origin::File(0..0), |i| i.key.clone());
        let (known, explained) = Default::default();
        Section { checker: self.checker, path: self.dotted(key), table, origin, known, explained }
    }

    /// Names of the keys in the order of the file.
    pub fn keys(&self) -> Vec<String> {
        self.table.map_or(Vec::new(), |t| t.0.iter().map(|(k, _)| k.clone()).collect())
    }

    /// Tells every key that nobody asked for.
    pub fn finish(self) {
        let all = keys::names_in(&self.path);
        let known: Vec<&str> =
            all.iter().copied().filter(|name| self.known.iter().any(|k| k == name)).collect();
        for (key, item) in self.table.map_or(&[][..], |t| &t.0) {
            if self.known.contains(key) {
                continue;
            }
            if let Some((_, message)) = self.explained.iter().find(|(k, _)| k == key) {
                self.checker.error(&item.key, &self.dotted(key), None, format!("unknown key; {message}"));
                continue;
            }
            let hint = match synonyms::meant(&self.path, key)
                .filter(|meant| self.known.iter().any(|k| k == meant))
            {
                Some(meant) => format!("; did you mean `{meant}`?"),
                None => match did_you_mean(key, known.iter().copied()) {
                    // A key of another kind is no misspelt one.
                    none if none.is_empty() && !all.contains(&key.as_str()) => {
                        did_you_mean(key, all.iter().copied())
                    }
                    hint => hint,
                },
            };
            let hint = if hint.is_empty() { ";".into() } else { hint };
            let table = if self.path.is_empty() { "a case".into() } else { format!("[{}]", self.path) };
            let message = format!("unknown key{hint} {table} takes {}", quoted(known.iter().copied()));
            self.checker.error(&item.key, &self.dotted(key), None, message);
        }
    }
}
