//! One-step schemes as tables.

use crate::physics::StepRule;

/// How a step weighs its two ends, section 5.1.2.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Scheme {
    /// Implicit weight θ; 1 is backward Euler, ½ Crank-Nicolson.
    Theta {
        /// Weight of the new time.
        theta: f64,
    },
    /// θ = ½ + c k: second order, and damps what Crank-Nicolson keeps.
    ShiftedCrankNicolson {
        /// c \[1/s\].
        shift: f64,
    },
}

impl Scheme {
    /// Backward Euler.
    pub const BACKWARD_EULER: Scheme = Scheme::Theta { theta: 1.0 };
    /// Crank-Nicolson.
    pub const CRANK_NICOLSON: Scheme = Scheme::Theta { theta: 0.5 };

    /// The rule of a step of length `k` \[s\].
    pub fn rule(&self, k: f64) -> StepRule {
        match *self {
            Scheme::Theta { theta } => StepRule::theta(k, theta),
            Scheme::ShiftedCrankNicolson { shift } => StepRule::theta(k, (0.5 + shift * k).min(1.0)),
        }
    }
}
