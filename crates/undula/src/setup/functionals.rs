//! The functionals of a case on its spaces.

use crate::case::{Case, FluidSpec, FunctionalSpec, Site};
use crate::functional::Functional;
use crate::functional::body_energy::BodyEnergy;
use crate::functional::energy::{Energy, Integral};
use crate::functional::force::{ForceByResidual, ForceBySurface, Surfaces};
use crate::functional::moment::Moment;
use crate::functional::point::{Displacement, Pressure, PressureDifference};
use crate::functional::power::Power;
use crate::functional::quantity::{Quantity, Take};
use crate::functional::sampled::{AtPoint, InRegion, OnBoundary};
use crate::functional::site::Place;
use crate::mesh::MeshError;
use crate::space::{FluidBoundary, FsiSpace, Region};

impl Case {
    /// The fluid at the first of the boundaries `names` that it touches; without one the first fluid.
    pub(super) fn fluid_at<const D: usize>(
        &self,
        space: &FsiSpace<D>,
        names: &[impl AsRef<str>],
    ) -> Option<&FluidSpec> {
        let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
        let surface = FluidBoundary::new(space);
        let facets = surface.numbers(&space.mesh.facets_on(&names));
        let at = facets.first().map(|&n| surface.facets[n].side.cell);
        let material = at.map_or(0, |cell| space.material[cell as usize]);
        self.fluids.get(usize::from(material))
    }

    /// 2/(ρ V² L) of a speed and a length, in space 2/(ρ V² A); the area of an extruded plane is L times its depth.
    fn of_force<const D: usize>(&self, space: &FsiSpace<D>, on: &[String], [speed, size]: [f64; 2]) -> f64 {
        let density = self.fluid_at(space, on).map_or(1.0, |f| f.density);
        let depth = self.mesh.extrude.map_or(1.0, |extrude| extrude.depth);
        2.0 / (density * speed * speed * size * depth)
    }

    /// Whether the bodies are there that `functional` is about.
    pub(super) fn has_body_of(&self, functional: &FunctionalSpec) -> bool {
        functional.region().is_none_or(|region| self.body_in(region).is_some())
    }

    /// Which functionals are left out, and why.
    pub(super) fn notes_on_functionals(&self) -> impl Iterator<Item = String> {
        let absent = self.functional.iter().filter(|(_, spec)| !self.has_body_of(spec));
        absent.map(|(name, spec)| {
            let region = spec.region().unwrap_or_default();
            format!("functional.{name} is left out: no body fills the region `{region}`")
        })
    }
}

impl FunctionalSpec {
    /// The functional on `space`.
    pub(super) fn build<const D: usize>(
        &self,
        case: &Case,
        space: &FsiSpace<D>,
        surfaces: &Surfaces<'_, D>,
    ) -> Result<Box<dyn Functional<D>>, MeshError> {
        let quadrature = case.space.quadrature;
        // An extruded plane has the lengths of the plane.
        let along = if case.mesh.extrude.is_some() { 2 } else { D };
        Ok(match self {
            FunctionalSpec::Force { on, component, surface_integral, coefficient } => {
                let of_force = |c| space.with_whole(|whole| case.of_force(whole, on, c));
                let (factor, unit) = coefficient.map_or((1.0, "N/m"), |c| (of_force(c), ""));
                // An interface that is not there, as in a flow without body, carries no force.
                if *surface_integral {
                    Box::new(ForceBySurface::new(surfaces, on, *component, factor, unit))
                } else {
                    Box::new(ForceByResidual::new(surfaces, on, *component, factor, unit))
                }
            }
            FunctionalSpec::Moment { on, about, axis } => {
                Box::new(Moment::new(surfaces, on, point_of(about), axis.unwrap_or(2)))
            }
            FunctionalSpec::Displacement { point, component } => {
                Box::new(Displacement::new(space, point_of(point), *component)?)
            }
            FunctionalSpec::PressureDifference { a, b } => {
                Box::new(PressureDifference::new(space, point_of(a), point_of(b), along)?)
            }
            FunctionalSpec::Energy(integral) => Box::new(Energy { integral: *integral, quadrature }),
            FunctionalSpec::Rotation { axis } => {
                Box::new(Energy { integral: Integral::Rotation(axis.unwrap_or(2)), quadrature })
            }
            FunctionalSpec::Flux { on } => {
                Box::new(OnBoundary::new(surfaces, on, Quantity::NormalVelocity, Take::Integral))
            }
            FunctionalSpec::Power { on } => Box::new(Power::new(surfaces, on)),
            FunctionalSpec::Pressure(Site::Point { point, region }) => {
                Box::new(Pressure::new(space, point_of(point), place(case, space, region.as_deref()), along)?)
            }
            FunctionalSpec::Pressure(at) => at.build(case, space, surfaces, Quantity::Pressure)?,
            FunctionalSpec::Velocity { component, at } => {
                at.build(case, space, surfaces, Quantity::Velocity(*component))?
            }
            FunctionalSpec::Stress { component, at } => {
                at.build(case, space, surfaces, Quantity::Stress(*component))?
            }
            FunctionalSpec::WallShearStress { component, on, take } => {
                Box::new(OnBoundary::new(surfaces, on, Quantity::WallShear(*component), *take))
            }
            FunctionalSpec::Balance { region, part } => {
                let body = case.body_in(region).unwrap_or((Region::Fluid, 0));
                Box::new(BodyEnergy::new(space, body, *part, quadrature))
            }
            FunctionalSpec::Volume { region } => {
                let at = Site::Region(region.clone(), Take::Integral);
                at.build(case, space, surfaces, Quantity::One)?
            }
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
            (_, MeshError::OtherRegion { .. }) => "region",
            (_, MeshError::Outside { .. } | MeshError::NoPressure { .. }) => "point",
            _ => "on",
        }
    }
}

impl Site {
    /// `quantity` there.
    fn build<const D: usize>(
        &self,
        case: &Case,
        space: &FsiSpace<D>,
        surfaces: &Surfaces<'_, D>,
        quantity: Quantity,
    ) -> Result<Box<dyn Functional<D>>, MeshError> {
        Ok(match self {
            Site::Point { point, region } => {
                let place = place(case, space, region.as_deref());
                Box::new(AtPoint::new(space, point_of(point), place, quantity)?)
            }
            Site::Boundaries(on, take) => Box::new(OnBoundary::new(surfaces, on, quantity, *take)),
            Site::Region(region, take) => {
                let place = place(case, space, Some(region)).unwrap_or(Place::from(Region::Fluid));
                Box::new(InRegion::new(place, quantity, *take, case.space.quadrature))
            }
        })
    }
}

/// A position that a case gives.
fn point_of<const D: usize>(x: &[f64]) -> [f64; D] {
    std::array::from_fn(|d| x[d])
}

/// A region of the mesh with the body that fills it.
fn place<const D: usize>(case: &Case, space: &FsiSpace<D>, region: Option<&str>) -> Option<Place> {
    let (body, _) = case.body_in(region?)?;
    Some(Place { body, region: space.mesh.region(region?) })
}
