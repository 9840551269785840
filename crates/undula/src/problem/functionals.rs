//! The functionals of a case: their names, reading, writing and construction.

use super::case::{Case, SolidLaw};
use super::choices::{COMPONENTS, METHODS};
use super::read::{ANY, POSITIVE, Section};
use super::write::{Lines, pair, string};
use crate::choice::{Choice, choice};
use crate::functional::Functional;
use crate::functional::energy::{ENERGIES, Energy, Integral};
use crate::functional::force::{ForceByResidual, ForceBySurface, Surfaces};
use crate::functional::point::{Displacement, PressureDifference};
use crate::mesh::MeshError;
use crate::space::FsiSpace;

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

    /// The functional of this kind that the table `s` means.
    pub(super) fn read(self, s: &mut Section<'_, '_>) -> FunctionalSpec {
        match self {
            FunctionalSpec::Force { .. } => force(s),
            FunctionalSpec::Displacement { .. } => {
                FunctionalSpec::Displacement { point: required_point(s, "point"), component: component(s) }
            }
            FunctionalSpec::PressureDifference { .. } => {
                FunctionalSpec::PressureDifference { a: required_point(s, "a"), b: required_point(s, "b") }
            }
            FunctionalSpec::Energy(default) => {
                let term = s.choice("term", &ENERGIES, &[]);
                s.require_choice("term", &ENERGIES);
                FunctionalSpec::Energy(term.unwrap_or(default))
            }
            FunctionalSpec::Rotation => FunctionalSpec::Rotation,
        }
    }

    /// The lines of its table.
    pub(super) fn write(&self, out: &mut Lines) {
        out.variant("kind", &FUNCTIONALS, self);
        match self {
            FunctionalSpec::Force { on, component, surface_integral, coefficient } => {
                out.key("on", format!("[{}]", on.iter().map(|n| string(n)).collect::<Vec<_>>().join(", ")));
                out.choice("component", &COMPONENTS, component);
                out.choice("method", &METHODS, surface_integral);
                if let Some(scales) = coefficient {
                    out.key("coefficient", pair(scales));
                }
            }
            FunctionalSpec::Displacement { point, component } => {
                out.key("point", pair(point));
                out.choice("component", &COMPONENTS, component);
            }
            FunctionalSpec::PressureDifference { a, b } => {
                out.key("a", pair(a));
                out.key("b", pair(b));
            }
            FunctionalSpec::Energy(integral) => out.choice("term", &ENERGIES, integral),
            FunctionalSpec::Rotation => {}
        }
    }

    /// The functional on `space`.
    pub(super) fn build(
        &self,
        case: &Case,
        space: &FsiSpace<2>,
        surfaces: &Surfaces<'_, 2>,
    ) -> Result<Box<dyn Functional<2>>, MeshError> {
        let quadrature = case.space.quadrature;
        Ok(match self {
            FunctionalSpec::Force { on, component, surface_integral, coefficient } => {
                let density = case.fluid.as_ref().map_or(1.0, |f| f.density);
                let (factor, unit) = match coefficient {
                    Some([speed, length]) => (2.0 / (density * speed * speed * length), ""),
                    None => (1.0, "N/m"),
                };
                // An interface that is not there, as in a flow without body, carries no force.
                if *surface_integral {
                    Box::new(ForceBySurface::new(surfaces, on, *component, factor, unit))
                } else {
                    Box::new(ForceByResidual::new(surfaces, on, *component, factor, unit))
                }
            }
            FunctionalSpec::Displacement { point, component } => {
                Box::new(Displacement::new(space, *point, *component)?)
            }
            FunctionalSpec::PressureDifference { a, b } => Box::new(PressureDifference::new(space, *a, *b)?),
            FunctionalSpec::Energy(integral) => Box::new(Energy { integral: *integral, quadrature }),
            FunctionalSpec::Rotation => Box::new(Energy { integral: Integral::Rotation, quadrature }),
        })
    }

    /// The key that `error` is about.
    pub(super) fn key_of(&self, error: &MeshError) -> &'static str {
        match (self, error) {
            (
                FunctionalSpec::PressureDifference { a, .. },
                MeshError::Outside { point, .. } | MeshError::NoPressure { point },
            ) => {
                if point.as_slice() == a {
                    "a"
                } else {
                    "b"
                }
            }
            (FunctionalSpec::Displacement { .. }, _) => "point",
            _ => "on",
        }
    }
}

fn force(s: &mut Section<'_, '_>) -> FunctionalSpec {
    let on = s.strings("on");
    if !s.has("on") {
        s.missing("on", "the boundaries, such as on = [\"cylinder\", \"interface\"]");
    }
    let method = s.choice("method", &METHODS, &[]);
    FunctionalSpec::Force {
        on: on.unwrap_or_default(),
        component: component(s),
        surface_integral: method.unwrap_or(false),
        coefficient: s.pair("coefficient", POSITIVE),
    }
}

fn component(s: &mut Section<'_, '_>) -> usize {
    let component = s.choice("component", &COMPONENTS, &[]);
    if !s.has("component") {
        s.missing("component", "\"x\" or \"y\"");
    }
    component.unwrap_or(0)
}

fn required_point(s: &mut Section<'_, '_>, key: &str) -> [f64; 2] {
    let point = s.pair(key, ANY);
    if !s.has(key) {
        s.missing(key, "a point of the reference domain [m], such as [0.6, 0.2]");
    }
    point.unwrap_or_default()
}
