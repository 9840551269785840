//! Values with a component along each coordinate.

use super::{ANY, Section};
use crate::case::conditions::Components;
use crate::case::expression::Expression;
use crate::case::raw::{Item, Value};

/// How many components vectors and points have.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub enum Vectors {
    /// x, y.
    #[default]
    Plane,
    /// x, y, z, or x, y of the plane that is extruded: then z of points lies in the middle \[m\], and z of vectors is 0.
    Extruded {
        /// z of points \[m\].
        middle: f64,
    },
    /// x, y, z.
    Space,
}

impl Vectors {
    /// Number of components.
    pub fn len(self) -> usize {
        if self == Vectors::Plane { 2 } else { 3 }
    }

    /// Whether so many may be given.
    fn takes(self, given: usize) -> bool {
        given == self.len() || (given == 2 && matches!(self, Vectors::Extruded { .. }))
    }
}

impl Section<'_, '_> {
    /// One value for each component; of an extruded plane that of z, `along_z`, may be left out.
    pub(super) fn vector_of<T: Clone>(
        &mut self,
        key: &str,
        expected: &str,
        along_z: T,
        read: impl Fn(&Self, &str, &Item) -> Option<T>,
    ) -> Option<Vec<T>> {
        let item = self.item(key)?;
        let vectors = self.checker.vectors.get();
        let (number, third) = match vectors {
            Vectors::Plane => ("two", ""),
            Vectors::Extruded { .. } => ("two or three", ""),
            Vectors::Space => ("three", ", \"z component\"]"),
        };
        let expected = format!("{number} {expected}");
        let expected = match expected.strip_suffix(']').filter(|_| !third.is_empty()) {
            Some(start) => format!("{start}{third}"),
            None => expected,
        };
        let Value::Array(items) = &item.value else {
            self.wrong_type(key, item, &expected);
            return None;
        };
        if !vectors.takes(items.len()) {
            self.wrong_item(key, item, format!("expected {expected}, not {} values", items.len()));
            return None;
        }
        let values: Vec<_> =
            (0..).zip(items).map(|(i, item)| read(self, &format!("{key}[{i}]"), item)).collect();
        let mut values = values.into_iter().collect::<Option<Vec<T>>>()?;
        values.resize(vectors.len(), along_z);
        Some(values)
    }

    /// One expression for each component.
    pub fn expressions(&mut self, key: &str) -> Option<Components> {
        self.vector_of(
            key,
            "expressions, as [\"x component\", \"y component\"]",
            Expression::default(),
            Self::expression_of,
        )
    }

    /// The same, zero if it is not there.
    pub fn expressions_or_zero(&mut self, key: &str) -> Components {
        self.expressions(key).unwrap_or_else(|| vec![Expression::default(); self.checker.vectors.get().len()])
    }

    /// One expression for each component, or `None` for the word `free`.
    pub fn components(&mut self, key: &str) -> Option<Vec<Option<Expression>>> {
        let expected = "expressions or \"free\", as [\"x component\", \"free\"]";
        let found = self.vector_of(key, expected, Some(Expression::default()), |section, key, item| {
            match &item.value {
                Value::String(word) if word == "free" => Some(None),
                _ => section.expression_of(key, item).map(Some),
            }
        });
        if found.as_ref().is_some_and(|all| all.iter().all(Option::is_none)) {
            self.wrong(key, "expected one component at least that is not free; else use `traction-free`");
        }
        found
    }

    /// A position \[m\].
    pub fn point(&mut self, key: &str) -> Option<Vec<f64>> {
        let middle = match self.checker.vectors.get() {
            Vectors::Extruded { middle } => middle,
            _ => 0.0,
        };
        self.vector_of(key, "numbers", middle, |section, key, item| section.number_of(key, item, ANY))
    }

    /// Two counts, 1 or above, or in space three.
    pub fn counts(&mut self, key: &str) -> Option<Vec<usize>> {
        self.vector_of(key, "integers", 1, |section, key, item| match item.value {
            Value::Integer(i) if (1..=100_000).contains(&i) => usize::try_from(i).ok(),
            _ => {
                section.wrong_type(key, item, "an integer from 1 to 100000");
                None
            }
        })
    }
}
