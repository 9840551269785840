//! Conditions on boundaries, with the keys of their data.

use super::choices::{PRESSURE_AT, SPRING_DIRECTIONS};
use super::expression::Expression;
use super::key::Key;
use super::profile::Profile;
use crate::choice::{Choice, choice, row_of};

/// The components along x and y, in space along z, too: expressions of x, y, t, in space of z.
pub type Components = Vec<Expression>;

const ZERO: Expression = Expression::EMPTY;
const EMPTY: Components = vec![];

/// What holds on a boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// Given velocity \[m/s\]; the boundary does not move. It must vanish on the solid.
    Velocity(Components),
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
    Displacement(Vec<Option<Expression>>),
    /// n·v = 0, n·u = 0, and no traction along the boundary.
    Slip,
    /// The same on a plane of symmetry.
    Symmetry,
    /// v, u and a continuous pressure are those of another boundary, of which this one is a translation.
    Periodic(String),
    /// J σ F⁻ᵀ N = g, a force per area of the reference boundary \[N/m²\], fluid and solid.
    Traction(Components),
    /// ρν ∇v n − p n = −P n for the fluid, whose boundary moves as with `DoNothing`; σ n = −P n for the solid.
    Pressure {
        /// P \[Pa\] at the reference position.
        pressure: Expression,
        /// Whether n and the area are those of the boundary in motion.
        follows: bool,
    },
    /// σ n = −(k u + c v) − P n of the solid, or the normal part of the bed.
    Spring {
        /// k \[Pa/m\].
        stiffness: Expression,
        /// c \[Pa s/m\].
        damping: Expression,
        /// P \[Pa\], which follows the boundary.
        pressure: Expression,
        /// Whether only the normal part of u and v acts.
        normal: bool,
    },
    /// The pressure of an outlet is R Q + P.
    Resistance {
        /// R \[Pa s/m²\].
        resistance: Expression,
        /// P \[Pa\].
        pressure: Expression,
    },
    /// The pressure of an outlet is that of an RCR circuit.
    Windkessel {
        /// R_p \[Pa s/m²\].
        proximal: Expression,
        /// C \[m²/Pa\].
        capacitance: Expression,
        /// R_d \[Pa s/m²\].
        distal: Expression,
        /// P_d \[Pa\], behind the circuit.
        pressure: Expression,
        /// P_c at the start \[Pa\].
        initial: Expression,
    },
    /// A given flow leaves: with the pressure that it needs, or with a profile of the velocity.
    Flux {
        /// Q \[m²/s\].
        flow: Expression,
        /// The velocity on the boundary.
        profile: Profile,
        /// a_n and b_n \[m²/s\] of Q of [`Profile::Womersley`].
        fourier: Vec<[f64; 2]>,
        /// Its period \[s\].
        period: f64,
    },
}

/// Their names in a case.
pub static CONDITIONS: [Choice<Condition>; 15] = [
    choice("velocity", Condition::Velocity(EMPTY), "prescribed velocity; the boundary does not move"),
    choice("no-slip", Condition::NoSlip, "v = 0, u = 0: a wall"),
    choice("do-nothing", Condition::DoNothing, "ρν ∂v/∂n − p n = 0: outflow; of the solid a free surface"),
    choice("traction-free", Condition::TractionFree, "σ n = 0: no traction"),
    choice("clamped", Condition::Clamped, "v = 0, u = 0: a clamped solid"),
    choice(
        "displacement",
        Condition::Displacement(vec![]),
        "prescribed displacement u of a solid or of a wall of the fluid, v = ∂u/∂t",
    ),
    choice(
        "slip",
        Condition::Slip,
        "n·v = 0, n·u = 0, no traction along the boundary: a wall without friction",
    ),
    choice("symmetry", Condition::Symmetry, "the same as `slip`, on a plane of symmetry"),
    choice(
        "periodic",
        Condition::Periodic(String::new()),
        "one with another boundary, of which this one is a translation: the domain repeats",
    ),
    choice("traction", Condition::Traction(EMPTY), "prescribed force per area of the reference boundary"),
    choice(
        "pressure",
        Condition::Pressure { pressure: Expression::EMPTY, follows: true },
        "prescribed pressure P: ρν ∂v/∂n − p n = −P n of the fluid, σ n = −P n of the solid",
    ),
    choice(
        "spring",
        Condition::Spring { stiffness: ZERO, damping: ZERO, pressure: ZERO, normal: false },
        "elastic bed of the solid: σ n = −(k u + c v) − P n",
    ),
    choice(
        "resistance",
        Condition::Resistance { resistance: ZERO, pressure: ZERO },
        "outlet whose pressure is R Q + P, Q the flow out of it",
    ),
    choice(
        "windkessel",
        Condition::Windkessel {
            proximal: ZERO,
            capacitance: ZERO,
            distal: ZERO,
            pressure: ZERO,
            initial: ZERO,
        },
        "outlet with an RCR circuit: p = R_p Q + P_c, C dP_c/dt = Q − (P_c − P)/R_d",
    ),
    choice(
        "flux",
        Condition::Flux { flow: ZERO, profile: Profile::Free, fourier: vec![], period: 0.0 },
        "inlet or outlet with a given flow, and one pressure on all of it or a profile of the velocity",
    ),
];

/// Keys of their data.
pub static DATA: [Key; 15] = [
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
        "boundary.NAME.with",
        "",
        "periodic: required",
        "the boundary that is one with this one; its own table may be left out",
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
        "pressure: required, else 0",
        "expression of x, y, t at the reference position; behind a resistance or a windkessel of t alone",
    ),
    Key::data("boundary.NAME.stiffness", "Pa/m", "0", "k of a spring, per area; expression of x, y, t"),
    Key::data("boundary.NAME.damping", "Pa s/m", "0", "c of a spring, per area; expression of x, y, t"),
    Key {
        key: "boundary.NAME.direction",
        unit: "",
        default: "all",
        about: "in which direction a spring acts",
        choices: Some(&SPRING_DIRECTIONS),
    },
    Key::data(
        "boundary.NAME.resistance",
        "Pa s/m²",
        "resistance: required",
        "R of an outlet; expression of t",
    ),
    Key::data("boundary.NAME.proximal", "Pa s/m²", "windkessel: required", "R_p; expression of t"),
    Key::data("boundary.NAME.capacitance", "m²/Pa", "windkessel: required", "C; expression of t"),
    Key::data("boundary.NAME.distal", "Pa s/m²", "windkessel: required", "R_d; expression of t"),
    Key::data(
        "boundary.NAME.initial",
        "Pa",
        "0",
        "P_c of a windkessel at the start; 0: with initial.static or prestress that of the equilibrium",
    ),
    Key::data(
        "boundary.NAME.flow-rate",
        "m²/s",
        "flux: required",
        "flow out of the fluid, negative into it; expression of t; of a profile `womersley` in `fourier`",
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
    /// A vector.
    Vector(&'a mut Components),
    /// A vector, `None` for components that are free.
    Partial(&'a mut Vec<Option<Expression>>),
    /// One expression.
    Scalar(&'a mut Expression),
    /// The name of a boundary.
    Name(&'a mut String),
    /// A number above 0.
    Number(&'a mut f64),
    /// Pairs of numbers.
    Series(&'a mut Vec<[f64; 2]>),
    /// A profile.
    Profile(&'a mut Profile),
    /// A word.
    Word(&'static [Choice<bool>], &'a mut bool),
}

impl<'a> Datum<'a> {
    /// Its expressions.
    pub(super) fn expressions(self) -> Vec<&'a mut Expression> {
        match self {
            Datum::Vector(vector) => vector.iter_mut().collect(),
            Datum::Partial(vector) => vector.iter_mut().flatten().collect(),
            Datum::Scalar(one) => vec![one],
            _ => vec![],
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
            Condition::Velocity(data) => vec![("velocity", Datum::Vector(data))],
            Condition::Displacement(data) => vec![("displacement", Datum::Partial(data))],
            Condition::Traction(data) => vec![("traction", Datum::Vector(data))],
            Condition::Pressure { pressure, follows } => {
                vec![("pressure", Datum::Scalar(pressure)), ("at", Datum::Word(&PRESSURE_AT, follows))]
            }
            Condition::Spring { stiffness, damping, pressure, normal } => vec![
                ("stiffness", Datum::Scalar(stiffness)),
                ("damping", Datum::Scalar(damping)),
                ("pressure", Datum::Scalar(pressure)),
                ("direction", Datum::Word(&SPRING_DIRECTIONS, normal)),
            ],
            Condition::Resistance { resistance, pressure } => {
                vec![("resistance", Datum::Scalar(resistance)), ("pressure", Datum::Scalar(pressure))]
            }
            Condition::Windkessel { proximal, capacitance, distal, pressure, initial } => vec![
                ("proximal", Datum::Scalar(proximal)),
                ("capacitance", Datum::Scalar(capacitance)),
                ("distal", Datum::Scalar(distal)),
                ("pressure", Datum::Scalar(pressure)),
                ("initial", Datum::Scalar(initial)),
            ],
            Condition::Flux { flow, profile, fourier, period } => vec![
                ("flow-rate", Datum::Scalar(flow)),
                ("profile", Datum::Profile(profile)),
                ("fourier", Datum::Series(fourier)),
                ("period", Datum::Number(period)),
            ],
            Condition::Periodic(with) => vec![("with", Datum::Name(with))],
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
            Condition::Spring { stiffness, damping, pressure, normal: _ } => {
                vec![("stiffness", vec![stiffness]), ("damping", vec![damping]), ("pressure", vec![pressure])]
            }
            Condition::Resistance { resistance, pressure } => {
                vec![("resistance", vec![resistance]), ("pressure", vec![pressure])]
            }
            Condition::Windkessel { proximal, capacitance, distal, pressure, initial } => vec![
                ("proximal", vec![proximal]),
                ("capacitance", vec![capacitance]),
                ("distal", vec![distal]),
                ("pressure", vec![pressure]),
                ("initial", vec![initial]),
            ],
            Condition::Flux { flow, .. } if self.has_effect("flow-rate") => vec![("flow-rate", vec![flow])],
            Condition::Flux { .. } => vec![],
            Condition::NoSlip
            | Condition::DoNothing
            | Condition::TractionFree
            | Condition::Clamped
            | Condition::Slip
            | Condition::Symmetry
            | Condition::Periodic(_) => vec![],
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
            Condition::Velocity(_)
            | Condition::DoNothing
            | Condition::Resistance { .. }
            | Condition::Windkessel { .. }
            | Condition::Flux { .. } => fluid,
            Condition::Clamped => solid,
            Condition::Spring { .. } => solid && !fluid,
            _ => true,
        }
    }

    /// Whether velocity and displacement are given, or some of their components.
    pub fn is_given(&self) -> bool {
        !self.is_natural() && !self.is_periodic()
    }

    /// Whether the traction is what is given: velocity and displacement are free there, and an outlet may be there.
    pub fn is_natural(&self) -> bool {
        use Condition::{DoNothing, Pressure, Spring, Traction, TractionFree};
        self.is_lumped()
            || matches!(self, DoNothing | TractionFree | Traction(_) | Pressure { .. } | Spring { .. })
    }

    /// Whether it makes one of two boundaries.
    pub fn is_periodic(&self) -> bool {
        matches!(self, Condition::Periodic(_))
    }

    /// Whether a spring may hold the solid.
    pub fn is_elastic(&self) -> bool {
        matches!(self, Condition::Spring { stiffness, .. } if stiffness.constant_value() != Some(0.0))
    }

    /// Whether it determines the pressure: a given flow alone leaves it open by a constant.
    pub fn gives_pressure(&self) -> bool {
        self.is_natural() && !matches!(self, Condition::Flux { .. })
    }

    /// Whether one pressure acts on all of an outlet, which depends on the flow.
    pub fn is_lumped(&self) -> bool {
        use Condition::{Flux, Resistance, Windkessel};
        matches!(self, Resistance { .. } | Windkessel { .. } | Flux { profile: Profile::Free, .. })
    }

    /// Whether it is a given flow whose velocity is given, too.
    pub fn has_profile(&self) -> bool {
        matches!(self, Condition::Flux { .. }) && !self.is_lumped()
    }

    /// Whether a datum of it has an effect: that of another profile has none.
    pub(super) fn has_effect(&self, name: &str) -> bool {
        let Condition::Flux { profile, .. } = self else { return true };
        match name {
            "flow-rate" => *profile != Profile::Womersley,
            "fourier" | "period" => *profile == Profile::Womersley,
            _ => true,
        }
    }
}
