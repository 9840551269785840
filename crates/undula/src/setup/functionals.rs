//! The functionals of a case on its spaces.

use crate::case::{Case, FunctionalSpec};
use crate::functional::Functional;
use crate::functional::energy::{Energy, Integral};
use crate::functional::force::{ForceByResidual, ForceBySurface, Surfaces};
use crate::functional::point::{Displacement, PressureDifference};
use crate::mesh::MeshError;
use crate::space::FsiSpace;

impl FunctionalSpec {
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
