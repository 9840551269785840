//! Conditions on boundaries, with the keys of their data.

use super::expression::Expression;
use super::key::Key;
use crate::choice::{Choice, choice, row_of};

/// Two components, expressions of x, y, t.
pub type Pair = [Expression; 2];

const EMPTY: Pair = [Expression::EMPTY, Expression::EMPTY];

/// What holds on a boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// Given velocity \[m/s\]; the boundary does not move. It must vanish on the solid.
    Velocity(Pair),
    /// v = 0, u = 0.
    NoSlip,
    /// ρν ∇v n − p n = 0 for the fluid; its boundary moves where a free end of the solid meets it, else it does not. For the
    /// solid σ n = 0.
    DoNothing,
    /// σ n = 0. The boundary of the fluid moves as with `DoNothing`; that of the solid is free.
    TractionFree,
    /// A clamped solid: v = 0, u = 0.
    Clamped,
    /// J σ F⁻ᵀ N = g, a force per area of the reference boundary \[N/m²\], fluid and solid.
    Traction(Pair),
}

/// Their names in a case.
pub static CONDITIONS: [Choice<Condition>; 6] = [
    choice("velocity", Condition::Velocity(EMPTY), "prescribed velocity; the boundary does not move"),
    choice("no-slip", Condition::NoSlip, "v = 0, u = 0: a wall"),
    choice("do-nothing", Condition::DoNothing, "ρν ∂v/∂n − p n = 0: outflow; of the solid a free surface"),
    choice("traction-free", Condition::TractionFree, "σ n = 0: no traction"),
    choice("clamped", Condition::Clamped, "v = 0, u = 0: a clamped solid"),
    choice("traction", Condition::Traction(EMPTY), "prescribed force per area of the reference boundary"),
];

/// Keys of data, two expressions each: the name of a key in the table of a boundary is that of its condition.
pub static DATA: [Key; 2] = [
    Key::data(
        "boundary.NAME.velocity",
        "m/s",
        "velocity: required",
        "two expressions of x, y, t, as [\"1.5*y\", 0]",
    ),
    Key::data(
        "boundary.NAME.traction",
        "N/m²",
        "traction: required",
        "two expressions of x, y, t at the reference position, as [\"3.2\", 0]",
    ),
];

impl Condition {
    /// The name in a case.
    pub fn name(&self) -> &'static str {
        row_of(&CONDITIONS, self).map_or("", |row| row.name)
    }

    /// Its data, for the key with the name of the condition.
    pub fn data(&self) -> Option<&Pair> {
        match self {
            Condition::Velocity(data) | Condition::Traction(data) => Some(data),
            Condition::NoSlip | Condition::DoNothing | Condition::TractionFree | Condition::Clamped => None,
        }
    }

    pub(super) fn data_mut(&mut self) -> Option<&mut Pair> {
        match self {
            Condition::Velocity(data) | Condition::Traction(data) => Some(data),
            Condition::NoSlip | Condition::DoNothing | Condition::TractionFree | Condition::Clamped => None,
        }
    }

    /// Whether velocity and displacement are given.
    pub fn is_given(&self) -> bool {
        matches!(self, Condition::Velocity(_) | Condition::NoSlip | Condition::Clamped)
    }

    /// Whether the traction is what is given: velocity and displacement are free there, and an outlet may be there.
    pub fn is_natural(&self) -> bool {
        !self.is_given()
    }
}
