//! Laws with fibres: their constants, and the direction of the fibres.

use super::conditions::Components;
use crate::physics::fibres::{at_angle, unit};
use crate::physics::{Artery, Muscle};
use crate::space::FibreField;
use std::sync::Arc;

/// Constants of the laws with fibres; of each law those that it has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FibreSpec {
    /// Direction of the fibres, or of the middle between two families.
    pub direction: FibreDirection,
    /// Angle of each of two families to the middle \[rad\].
    pub angle: f64,
    /// k₁ \[Pa\] of Holzapfel, Gasser and Ogden.
    pub k1: f64,
    /// k₂.
    pub k2: f64,
    /// Dispersion κ.
    pub dispersion: f64,
    /// C \[Pa\] of Guccione.
    pub stiffness: f64,
    /// b_f, b_t and b_fs of Guccione.
    pub exponents: [f64; 3],
}

/// The direction of fibres in the reference domain.
#[derive(Clone, Debug, PartialEq)]
// A case has few.
#[allow(clippy::large_enum_variant)]
pub enum FibreDirection {
    /// The same everywhere, by the angle to the x axis \[rad\].
    Angle(f64),
    /// Two expressions of x and y, a vector of any length.
    Field(Components),
}

impl Default for FibreDirection {
    fn default() -> Self {
        FibreDirection::Angle(0.0)
    }
}

impl FibreDirection {
    /// The unit vector where there is no field.
    fn fixed(&self) -> [f64; 2] {
        match self {
            FibreDirection::Angle(angle) => at_angle(*angle),
            FibreDirection::Field(_) => [1.0, 0.0],
        }
    }

    /// The expressions, if it is a field.
    pub(crate) fn field(&self) -> Option<&Components> {
        match self {
            FibreDirection::Angle(_) => None,
            FibreDirection::Field(field) => Some(field),
        }
    }

    /// The direction at a position, a unit vector, if it is a field; where there is none it is 0.
    pub(crate) fn directions<const D: usize>(&self) -> Option<FibreField<D>> {
        let field = self.field()?.clone();
        let at = move |x: &[f64; D]| {
            let x = std::array::from_fn(|d| x.get(d).copied().unwrap_or(0.0));
            unit(std::array::from_fn::<_, D, _>(|i| field[i].eval(&x, 0.0))).unwrap_or([0.0; D])
        };
        Some(Arc::new(at))
    }
}

impl FibreSpec {
    /// `matrix` with the fibres.
    pub(super) fn artery(&self, matrix: Artery) -> Artery {
        let FibreSpec { direction, angle, k1, k2, dispersion, .. } = self;
        let (k1, k2, dispersion) = (*k1, *k2, *dispersion);
        Artery { k1, k2, dispersion, angles: [*angle, -angle], direction: direction.fixed(), ..matrix }
    }

    /// Guccione's law with 1/κ = `compliance`.
    pub(super) fn muscle(&self, compliance: f64) -> Muscle {
        let FibreSpec { direction, stiffness, exponents, .. } = self;
        Muscle { stiffness: *stiffness, exponents: *exponents, compliance, direction: direction.fixed() }
    }
}
