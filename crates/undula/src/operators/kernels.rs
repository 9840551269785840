//! The operators that are compiled for both dimensions: whoever called something generic would compile them once more.

use super::region::kernel::Kernel;
#[cfg(not(test))]
use super::stabilization::Stabilizer;
use super::{Operator, Options, Physics, RegionOperator};
use crate::algebra::SolverError;
use crate::loops::batch::Batches;
use crate::loops::width::Width;
#[cfg(not(test))]
use crate::loops::width::{in_plane, in_space, needed_in_space};
use crate::math::Lanes;
#[cfg(not(test))]
use crate::physics::{Axisymmetric, Solid};
use crate::physics::{Fluid, Stabilization};
use crate::space::{FsiSpace, Region};
#[cfg(not(test))]
use crate::tangent::InSpace;
use crate::tangent::StepForm;

/// The operators of all regions, fluid first.
pub type Regions<const D: usize> = Vec<Box<dyn RegionOperator<D>>>;

/// Dimensions whose kernels are compiled: the plane and space.
pub struct Dim<const D: usize>;

/// Makes the operators of all regions.
///
/// Implemented for the two dimensions, and not generic: whoever called something generic would compile all kernels once
/// more.
pub trait Kernels<const D: usize> {
    /// The volume terms of the regions that `physics` has, with the lanes that are asked for or, if this build or this
    /// processor has none, with the most it has. `stiffness` is E_e(x) of the extension.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if there are too many unknowns to be numbered; [`SolverError::Processor`] if this build
    /// has kernels for other processors only.
    fn regions(
        space: &FsiSpace<D>,
        physics: &Physics,
        stiffness: &dyn Fn(&[f64; D]) -> f64,
        options: &Options,
    ) -> Result<Regions<D>, SolverError>;

    /// The terms that stabilise a fluid: one cell at a time, for every vector width it would take minutes to compile.
    ///
    /// # Errors
    /// As [`Kernels::regions`].
    fn stabilizer(
        how: &Stabilization,
        fluid: Fluid,
        space: &FsiSpace<D>,
        options: &Options,
    ) -> Result<Box<dyn Operator<D>>, SolverError>;
}

#[cfg(not(test))]
impl Kernels<2> for Dim<2> {
    fn regions(
        space: &FsiSpace<2>,
        physics: &Physics,
        stiffness: &dyn Fn(&[f64; 2]) -> f64,
        options: &Options,
    ) -> Result<Regions<2>, SolverError> {
        match in_plane(options.lanes) {
            #[cfg(lanes_8)]
            8 => Making::<2, 8> { space, stiffness, options }.in_plane(physics),
            #[cfg(lanes_4)]
            4 => Making::<2, 4> { space, stiffness, options }.in_plane(physics),
            _ => Making::<2, 1> { space, stiffness, options }.in_plane(physics),
        }
    }

    fn stabilizer(
        how: &Stabilization,
        fluid: Fluid,
        space: &FsiSpace<2>,
        options: &Options,
    ) -> Result<Box<dyn Operator<2>>, SolverError> {
        Ok(Box::new(Stabilizer::<2, 1>::new(how, fluid, space, options)?))
    }
}

#[cfg(not(test))]
impl Kernels<3> for Dim<3> {
    fn regions(
        space: &FsiSpace<3>,
        physics: &Physics,
        stiffness: &dyn Fn(&[f64; 3]) -> f64,
        options: &Options,
    ) -> Result<Regions<3>, SolverError> {
        match in_space(options.lanes) {
            #[cfg(space_8)]
            Some(8) => Making::<3, 8> { space, stiffness, options }.in_space(physics),
            #[cfg(space_4)]
            Some(4) => Making::<3, 4> { space, stiffness, options }.in_space(physics),
            #[cfg(space_1)]
            Some(1) => Making::<3, 1> { space, stiffness, options }.in_space(physics),
            _ => Err(SolverError::Processor(needed_in_space())),
        }
    }

    fn stabilizer(
        how: &Stabilization,
        fluid: Fluid,
        space: &FsiSpace<3>,
        options: &Options,
    ) -> Result<Box<dyn Operator<3>>, SolverError> {
        Ok(Box::new(Stabilizer::<3, 1>::new(how, fluid, space, options)?))
    }
}

/// None: they are not compiled twice for `cargo test`. What assembles is tested in `tests/it`.
#[cfg(test)]
impl<const D: usize> Kernels<D> for Dim<D> {
    fn regions(
        _: &FsiSpace<D>,
        _: &Physics,
        _: &dyn Fn(&[f64; D]) -> f64,
        _: &Options,
    ) -> Result<Regions<D>, SolverError> {
        unimplemented!("unit tests have no kernels")
    }

    fn stabilizer(
        _: &Stabilization,
        _: Fluid,
        _: &FsiSpace<D>,
        _: &Options,
    ) -> Result<Box<dyn Operator<D>>, SolverError> {
        unimplemented!("unit tests have no kernels")
    }
}

/// What the operators of all regions are made with.
struct Making<'a, const D: usize, const L: usize> {
    space: &'a FsiSpace<D>,
    stiffness: &'a dyn Fn(&[f64; D]) -> f64,
    options: &'a Options,
}

impl<const D: usize, const L: usize> Making<'_, D, L>
where
    Lanes<L>: Width,
{
    /// The operator of the cells of one material.
    fn region<F: StepForm<D> + Send + 'static>(
        &self,
        body: (Region, u16),
        form: F,
        guards: bool,
    ) -> Result<Box<dyn RegionOperator<D>>, SolverError> {
        let Making { space, stiffness, options } = *self;
        let here = |&c: &usize| (space.regions[c], space.material[c]) == body;
        let list: Vec<usize> = (0..space.mesh.n_cells()).filter(here).collect();
        let with_pressure = list.first().is_some_and(|&c| !space.pressure.cell(c).is_empty());
        let batches = Batches::<D, L>::new(space, &list, with_pressure, options.quadrature, stiffness);
        Ok(Box::new(Kernel::new(form, space, body, guards, batches, options.threads)?))
    }
}

#[cfg(not(test))]
impl<const D: usize, const L: usize> Making<'_, D, L>
where
    Lanes<L>: Width,
{
    /// The operators of all materials, with the equations as `fluid` and `solid` make them of those of a material.
    fn all<A, B>(
        &self,
        physics: &Physics,
        fluid: impl Fn(Fluid) -> A,
        solid: impl Fn(Solid) -> B,
    ) -> Result<Regions<D>, SolverError>
    where
        A: StepForm<D> + Send + 'static,
        B: StepForm<D> + Send + 'static,
    {
        let fluids = physics.fluids().map(|(n, form)| self.region((Region::Fluid, n), fluid(form), true));
        let solids = physics
            .solids()
            .map(|(n, form)| self.region((Region::Solid, n), solid(form), guards(physics, &form)));
        fluids.chain(solids).collect()
    }
}

#[cfg(not(test))]
impl<const L: usize> Making<'_, 2, L>
where
    Lanes<L>: Width,
{
    /// The operators of all materials, in (x, y) or in (r, z).
    fn in_plane(&self, physics: &Physics) -> Result<Regions<2>, SolverError> {
        match self.space.coordinates.is_axisymmetric() {
            true => self.all(physics, Axisymmetric, Axisymmetric),
            false => self.all(physics, |fluid| fluid, |solid| solid),
        }
    }
}

#[cfg(not(test))]
impl<const L: usize> Making<'_, 3, L>
where
    Lanes<L>: Width,
{
    /// The operators of all materials in space.
    fn in_space(&self, physics: &Physics) -> Result<Regions<3>, SolverError> {
        self.all(physics, InSpace, InSpace)
    }
}

/// While it iterates a solid may fold where its law does not mind; not at the end of a step.
#[cfg(not(test))]
fn guards(physics: &Physics, solid: &Solid) -> bool {
    physics.fluid.is_none() || solid.material.needs_positive_volume()
}
