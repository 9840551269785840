//! The functionals of a case and their names.

use crate::choice::{Choice, choice};
use crate::functional::energy::Integral;
use crate::physics::SolidLaw;

/// One number of interest.
#[derive(Clone, Debug, PartialEq)]
pub enum FunctionalSpec {
    /// Force of the fluid on boundaries \[N/m\], or its coefficient.
    Force {
        /// Boundary names; `interface` is allowed.
        on: Vec<String>,
        /// 0: x, 1: y.
        component: usize,
        /// By the fluid residual (default) or by the surface integral.
        surface_integral: bool,
        /// Multiply by 2/(ρ_f v̄² L) with v̄ \[m/s\], L \[m\] if given.
        coefficient: Option<[f64; 2]>,
    },
    /// Deformation of a material point \[m\].
    Displacement {
        /// Reference coordinates \[m\].
        point: [f64; 2],
        /// 0: x, 1: y.
        component: usize,
    },
    /// p(a) − p(b) \[Pa\].
    PressureDifference {
        /// First point.
        a: [f64; 2],
        /// Second point.
        b: [f64; 2],
    },
    /// An energy or power per unit depth.
    Energy(Integral),
    /// Average rotation (1/|S|) ∫_S x × u dx \[m²\].
    Rotation,
}

/// Their names in a case, in the order of the messages.
pub static FUNCTIONALS: [Choice<FunctionalSpec>; 5] = [
    choice(
        "force",
        FunctionalSpec::Force { on: Vec::new(), component: 0, surface_integral: false, coefficient: None },
        "force of the fluid on boundaries [N/m], or its coefficient",
    ),
    choice(
        "displacement",
        FunctionalSpec::Displacement { point: [0.0; 2], component: 0 },
        "displacement of a material point [m]",
    ),
    choice(
        "pressure-difference",
        FunctionalSpec::PressureDifference { a: [0.0; 2], b: [0.0; 2] },
        "p(a) − p(b) [Pa]",
    ),
    choice("energy", FunctionalSpec::Energy(Integral::FluidKinetic), "energy or power per unit depth"),
    choice("rotation", FunctionalSpec::Rotation, "average rotation of the solid [m²]"),
];

impl FunctionalSpec {
    /// Whether it belongs to the time t⁻ + θ k of the pressure instead of the new time.
    pub fn at_force_time(&self) -> bool {
        matches!(self, FunctionalSpec::Force { .. } | FunctionalSpec::PressureDifference { .. })
    }

    /// Whether it has no meaning without the fluid; others have none without the solid.
    pub(super) fn needs_fluid(&self, solid: Option<SolidLaw>) -> bool {
        match self {
            FunctionalSpec::Force { .. } => true,
            FunctionalSpec::PressureDifference { .. } => !solid.is_some_and(SolidLaw::is_incompressible),
            FunctionalSpec::Energy(integral) => integral.is_of_fluid(),
            FunctionalSpec::Displacement { .. } | FunctionalSpec::Rotation => false,
        }
    }
}
