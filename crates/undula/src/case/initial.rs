//! How a case in time begins.

use super::conditions::Components;
use super::expression::Expression;
use super::key::Key;
use std::fmt;
use std::path::PathBuf;

/// What a case in time begins with, if not at rest.
// A case has one.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Initial {
    /// The last checkpoint of the run in this output directory.
    From(PathBuf),
    /// Fields; one that is not given is zero.
    Fields {
        /// v \[m/s\] at the reference position.
        velocity: Option<Components>,
        /// u \[m\] at the reference position.
        displacement: Option<Components>,
    },
    /// The stationary solution with the loads of the start.
    Static,
}

/// The keys of `[initial]`.
pub(super) static INITIAL: [Key; 4] = [
    Key::data(
        "initial.from",
        "",
        "none",
        "other run from whose last checkpoint this one starts, relative to the case file",
    ),
    Key::data(
        "initial.velocity",
        "m/s",
        "0",
        "two expressions of x, y, t at the reference position; in the fluid made free of divergence",
    ),
    Key::data(
        "initial.displacement",
        "m",
        "0",
        "of the solid, two expressions of x, y, t at the reference position; extended into the fluid",
    ),
    Key::data(
        "initial.static",
        "",
        "false",
        "true: begin with the stationary solution for the loads at the start",
    ),
];

impl fmt::Display for Initial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Initial::From(directory) = self else {
            let keys: Vec<&str> = self.fields().map(|(key, _)| key).collect();
            let text = if keys.is_empty() {
                "stationary solution for the loads at the start".into()
            } else {
                keys.join(", ")
            };
            return f.write_str(&text);
        };
        write!(f, "last state of the run in {}", directory.display())
    }
}

impl Initial {
    /// The fields with their keys.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (&'static str, &Components)> {
        let (velocity, displacement) = match self {
            Initial::Fields { velocity, displacement } => (velocity.as_ref(), displacement.as_ref()),
            Initial::From(_) | Initial::Static => (None, None),
        };
        let velocity = velocity.map(|v| ("initial.velocity", v));
        velocity.into_iter().chain(displacement.map(|u| ("initial.displacement", u)))
    }

    /// The expressions, to be changed.
    pub(super) fn expressions_mut(&mut self) -> impl Iterator<Item = &mut Expression> {
        let (velocity, displacement) = match self {
            Initial::Fields { velocity, displacement } => (velocity.as_mut(), displacement.as_mut()),
            Initial::From(_) | Initial::Static => (None, None),
        };
        velocity.into_iter().chain(displacement).flatten()
    }
}
