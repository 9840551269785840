//! Integrals over regions: energies, dissipation, rotation.
#![allow(non_snake_case)]

use super::{Functional, Snapshot};
use crate::choice::{Choice, choice};
use crate::element::Quadrature;
use crate::parallel::Reduce;
use crate::physics::{Fabric, Fields, Fluid, Kinematics, axisymmetric};
use crate::sampling::{PointValues, for_each_point_of};
use crate::space::Region;
use crate::system::Physics;

/// Which integral.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Integral {
    /// ½ (ρ_f J v, v)_F \[J/m\].
    FluidKinetic,
    /// ½ (ρ_s v, v)_S \[J/m\].
    SolidKinetic,
    /// Stored energy of the solid \[J/m\].
    Elastic,
    /// ∫_F 2 ρ ν J |sym(∇v F⁻¹)|² \[W/m\].
    Dissipation,
    /// The component of (1/|S|) ∫_S x × u dx \[m²\] around an axis, 2: z as in the plane, (5.36).
    Rotation(usize),
}

/// Terms of the energy balance by their names in a case.
pub static ENERGIES: [Choice<Integral>; 4] = [
    choice("fluid-kinetic", Integral::FluidKinetic, "kinetic energy of the fluid [J/m]"),
    choice("solid-kinetic", Integral::SolidKinetic, "kinetic energy of the solid [J/m]"),
    choice("elastic", Integral::Elastic, "stored energy of the solid [J/m]"),
    choice("dissipation", Integral::Dissipation, "power that viscosity dissipates [W/m]"),
];

/// An integral with its quadrature.
pub struct Energy {
    /// Which.
    pub integral: Integral,
    /// Gauss points per direction.
    pub quadrature: usize,
}

impl Integral {
    /// Whether it is an integral over the fluid; else it is one over the solid.
    pub fn is_of_fluid(self) -> bool {
        matches!(self, Integral::FluidKinetic | Integral::Dissipation)
    }
}

impl<const D: usize> Functional<D> for Energy {
    fn unit(&self) -> &'static str {
        match self.integral {
            Integral::Dissipation => "W/m",
            Integral::Rotation(_) => "m²",
            _ => "J/m",
        }
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let (mut sum, mut volume) = (0.0, 0.0);
        let rule = Quadrature::cell(at.space.mesh.shape, self.quadrature);
        for_each_point_of(
            at.space,
            at.new,
            &rule,
            |cell| at.space.owns_cell(cell),
            |point| {
                if let Some(value) = self.value(at, point) {
                    sum += point.weight * value;
                    volume += point.weight;
                }
            },
        );
        let mut sums = [sum, volume];
        at.space.reduce(Reduce::Sum, &mut sums);
        let [sum, volume] = sums;
        let is_mean = matches!(self.integral, Integral::Rotation(_)) && volume > 0.0;
        if is_mean { sum / volume } else { sum }
    }
}

impl Energy {
    /// Integrand at a point; `None` in the region that does not count.
    fn value<const D: usize>(&self, at: &Snapshot<'_, D>, point: &PointValues<'_, D>) -> Option<f64> {
        let physics = at.physics.of(at.space.material[point.cell]);
        if let Integral::Rotation(axis) = self.integral {
            let (x, u) = (point.x, point.fields.u.0);
            let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
            return (point.region == Region::Solid).then(|| x[i] * u[j] - x[j] * u[i]);
        }
        match at.space.coordinates.radius(&point.x) {
            None => self.density(&physics, point.region, (&point.fabric, &point.fields)),
            Some(r) => {
                let at = (&axisymmetric::fabric(&point.fabric), &axisymmetric::fields_at(&point.fields, r));
                self.density(&physics, point.region, at)
            }
        }
    }

    fn density<const D: usize>(
        &self,
        physics: &Physics,
        region: Region,
        (fabric, f): (&Fabric<f64, D>, &Fields<f64, D>),
    ) -> Option<f64> {
        match (self.integral, region) {
            (Integral::FluidKinetic, Region::Fluid) => {
                Some(0.5 * physics.fluid?.rho * Kinematics::of(&f.grad_u).J * f.v.dot(f.v))
            }
            (Integral::Dissipation, Region::Fluid) => Some(dissipated(&physics.fluid?, f)),
            (Integral::SolidKinetic, Region::Solid) => Some(0.5 * physics.solid?.rho * f.v.dot(f.v)),
            (Integral::Elastic, Region::Solid) => Some(physics.solid?.stored(fabric, f)),
            _ => None,
        }
    }
}

/// 2 ρ ν J |sym(∇v F⁻¹)|² \[W/m³\].
pub(super) fn dissipated<const D: usize>(fluid: &Fluid, at: &Fields<f64, D>) -> f64 {
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let grad_v = at.grad_v * F_inv;
    let strain = 0.5 * (grad_v + grad_v.t());
    let factor = fluid.thinning.map_or(1.0, |law| law.factor(&(2.0 * strain)));
    2.0 * fluid.rho * fluid.nu * J * strain.ddot(strain) * factor
}
