//! Conditions on boundaries, with the keys of their data.

use super::choices::PRESSURE_AT;
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
    /// Given displacement u \[m\] and v = ∂_t u, of the solid or of a wall of the fluid; components may be free.
    Displacement([Option<Expression>; 2]),
    /// n·v = 0, n·u = 0, and no traction along the boundary.
    Slip,
    /// The same on a plane of symmetry.
    Symmetry,
    /// J σ F⁻ᵀ N = g, a force per area of the reference boundary \[N/m²\], fluid and solid.
    Traction(Pair),
    /// ρν ∇v n − p n = −P n for the fluid, whose boundary moves as with `DoNothing`; σ n = −P n for the solid.
    Pressure {
        /// P \[Pa\] at the reference position.
        pressure: Expression,
        /// Whether n and the area are those of the boundary in motion.
        follows: bool,
    },
}

/// Their names in a case.
pub static CONDITIONS: [Choice<Condition>; 10] = [
    choice("velocity", Condition::Velocity(EMPTY), "prescribed velocity; the boundary does not move"),
    choice("no-slip", Condition::NoSlip, "v = 0, u = 0: a wall"),
    choice("do-nothing", Condition::DoNothing, "ρν ∂v/∂n − p n = 0: outflow; of the solid a free surface"),
    choice("traction-free", Condition::TractionFree, "σ n = 0: no traction"),
    choice("clamped", Condition::Clamped, "v = 0, u = 0: a clamped solid"),
    choice(
        "displacement",
        Condition::Displacement([None, None]),
        "prescribed displacement u of a solid or of a wall of the fluid, v = ∂u/∂t",
    ),
    choice(
        "slip",
        Condition::Slip,
        "n·v = 0, n·u = 0, no traction along the boundary: a wall without friction",
    ),
    choice("symmetry", Condition::Symmetry, "the same as `slip`, on a plane of symmetry"),
    choice("traction", Condition::Traction(EMPTY), "prescribed force per area of the reference boundary"),
    choice(
        "pressure",
        Condition::Pressure { pressure: Expression::EMPTY, follows: true },
        "prescribed pressure P: ρν ∂v/∂n − p n = −P n of the fluid, σ n = −P n of the solid",
    ),
];

/// Keys of their data.
pub static DATA: [Key; 5] = [
    Key::data(
        "boundary.NAME.velocity",
        "m/s",
        "velocity: required",
        "two expressions of x, y, t, as [\"1.5*y\", 0]",
    ),
    Key::data(
        "boundary.NAME.displacement",
        "m",
        "displacement: required",
        "two expressions of x, y, t at the reference position, or \"free\", as [\"0.1*sin(t)\", \"free\"]",
    ),
    Key::data(
        "boundary.NAME.traction",
        "N/m²",
        "traction: required",
        "two expressions of x, y, t at the reference position, as [\"3.2\", 0]",
    ),
    Key::data(
        "boundary.NAME.pressure",
        "Pa",
        "pressure: required",
        "expression of x, y, t at the reference position",
    ),
    Key {
        key: "boundary.NAME.at",
        unit: "",
        default: "current",
        about: "where the pressure of a condition `pressure` acts",
        choices: Some(&PRESSURE_AT),
    },
];

/// One datum of a condition.
pub enum Datum<'a> {
    /// Two components.
    Pair(&'a mut Pair),
    /// Two components, `None` where they are free.
    Components(&'a mut [Option<Expression>; 2]),
    /// One expression.
    Scalar(&'a mut Expression),
    /// A word.
    Word(&'static [Choice<bool>], &'a mut bool),
}

impl<'a> Datum<'a> {
    /// Its expressions.
    pub(super) fn expressions(self) -> Vec<&'a mut Expression> {
        match self {
            Datum::Pair(pair) => pair.iter_mut().collect(),
            Datum::Components(pair) => pair.iter_mut().flatten().collect(),
            Datum::Scalar(one) => vec![one],
            Datum::Word(..) => vec![],
        }
    }
}

impl Condition {
    /// The name in a case.
    pub fn name(&self) -> &'static str {
        row_of(&CONDITIONS, self).map_or("", |row| row.name)
    }

    /// Its data by the last part of their keys.
    pub(super) fn data_mut(&mut self) -> Vec<(&'static str, Datum<'_>)> {
        match self {
            Condition::Velocity(data) => vec![("velocity", Datum::Pair(data))],
            Condition::Displacement(data) => vec![("displacement", Datum::Components(data))],
            Condition::Traction(data) => vec![("traction", Datum::Pair(data))],
            Condition::Pressure { pressure, follows } => {
                vec![("pressure", Datum::Scalar(pressure)), ("at", Datum::Word(&PRESSURE_AT, follows))]
            }
            Condition::NoSlip
            | Condition::DoNothing
            | Condition::TractionFree
            | Condition::Clamped
            | Condition::Slip
            | Condition::Symmetry => vec![],
        }
    }

    /// Its expressions by the last part of their keys.
    pub fn data(&self) -> Vec<(&'static str, Vec<&Expression>)> {
        match self {
            Condition::Velocity(data) => vec![("velocity", data.iter().collect())],
            Condition::Traction(data) => vec![("traction", data.iter().collect())],
            Condition::Displacement(data) => vec![("displacement", data.iter().flatten().collect())],
            Condition::Pressure { pressure, .. } => vec![("pressure", vec![pressure])],
            Condition::NoSlip
            | Condition::DoNothing
            | Condition::TractionFree
            | Condition::Clamped
            | Condition::Slip
            | Condition::Symmetry => vec![],
        }
    }

    /// The same, copied.
    pub fn expressions(&self) -> Vec<(&'static str, Vec<Expression>)> {
        self.data().into_iter().map(|(name, data)| (name, data.into_iter().cloned().collect())).collect()
    }

    /// Whether its data depend on time.
    pub fn depends_on_time(&self) -> bool {
        self.data().into_iter().any(|(_, data)| data.into_iter().any(Expression::depends_on_time))
    }

    /// Whether it has a meaning on a boundary of the fluid, of the solid, or of both.
    pub fn suits(&self, fluid: bool, solid: bool) -> bool {
        match self {
            Condition::Velocity(_) | Condition::DoNothing => fluid,
            Condition::Clamped => solid,
            _ => true,
        }
    }

    /// Whether velocity and displacement are given, or some of their components.
    pub fn is_given(&self) -> bool {
        !self.is_natural()
    }

    /// Whether the traction is what is given: velocity and displacement are free there, and an outlet may be there.
    pub fn is_natural(&self) -> bool {
        use Condition::{DoNothing, Pressure, Traction, TractionFree};
        matches!(self, DoNothing | TractionFree | Traction(_) | Pressure { .. })
    }
}
