//! The volume terms of a region: E B D Bᵀ over its cells, `L` at a time.

mod apply;
mod body_force;
mod condensed;
pub mod current_force;
mod differences;
mod extension;
mod fabric;
mod fields;
mod interior;
mod kernel;
mod min_jacobian;
mod moved_force;
mod nodal;
mod residual;
mod tangents;
#[cfg(test)]
mod tests;

use super::{
    Blocks, DataTime, End, Entries, ForceAt, How, Matrix, NotFinite, Operator, Options, Physics,
    RegionOperator, StepView,
};
use crate::algebra::SolverError;
use crate::loops::batch::Batches;
use crate::loops::slots::{Numbering, Pair, Slots, pairs};
use crate::loops::width::Width;
#[cfg(not(test))]
use crate::loops::width::{available, best_lanes, compiled};
use crate::math::Lanes;
#[cfg(not(test))]
use crate::physics::{Axisymmetric, Fluid, Solid};
use crate::space::{FsiSpace, Region};
use crate::tangent::{StepForm, Tangent};
use body_force::BodyForce;
use condensed::CONDENSED;
use current_force::CurrentForce;
use kernel::Kernel;

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
    /// [`SolverError::TooLarge`] if there are too many unknowns to be numbered.
    fn regions(
        space: &FsiSpace<D>,
        physics: &Physics,
        stiffness: &dyn Fn(&[f64; D]) -> f64,
        options: &Options,
    ) -> Result<Regions<D>, SolverError>;
}

/// Lanes of this build and this processor nearest to those that are asked for.
#[cfg(not(test))]
fn lanes(options: &Options) -> usize {
    let there = compiled(options.lanes) && available(options.lanes);
    if there { options.lanes } else { best_lanes() }
}

#[cfg(not(test))]
impl Kernels<2> for Dim<2> {
    fn regions(
        space: &FsiSpace<2>,
        physics: &Physics,
        stiffness: &dyn Fn(&[f64; 2]) -> f64,
        options: &Options,
    ) -> Result<Regions<2>, SolverError> {
        match lanes(options) {
            #[cfg(lanes_8)]
            8 => Making::<2, 8> { space, stiffness, options }.in_plane(physics),
            #[cfg(lanes_4)]
            4 => Making::<2, 4> { space, stiffness, options }.in_plane(physics),
            _ => Making::<2, 1> { space, stiffness, options }.in_plane(physics),
        }
    }
}

/// Four lanes at most: the matrices of a hexahedron in eight lanes do not fit into the cache.
#[cfg(not(test))]
impl Kernels<3> for Dim<3> {
    fn regions(
        space: &FsiSpace<3>,
        physics: &Physics,
        stiffness: &dyn Fn(&[f64; 3]) -> f64,
        options: &Options,
    ) -> Result<Regions<3>, SolverError> {
        match lanes(options) {
            #[cfg(lanes_4)]
            4.. => Making::<3, 4> { space, stiffness, options }.all(physics),
            _ => Making::<3, 1> { space, stiffness, options }.all(physics),
        }
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
    Fluid: StepForm<D>,
    Solid: StepForm<D>,
{
    /// The operators of all materials.
    fn all(&self, physics: &Physics) -> Result<Regions<D>, SolverError> {
        let fluids = physics.fluids().map(|(n, form)| self.region((Region::Fluid, n), form, true));
        let solids = physics.solids().map(|(n, form)| {
            self.region((Region::Solid, n), form, guards(physics, &form))
        });
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
        if !self.space.coordinates.is_axisymmetric() {
            return self.all(physics);
        }
        let fluids =
            physics.fluids().map(|(n, form)| self.region((Region::Fluid, n), Axisymmetric(form), true));
        let solids = physics.solids().map(|(n, form)| {
            self.region((Region::Solid, n), Axisymmetric(form), guards(physics, &form))
        });
        fluids.chain(solids).collect()
    }
}

/// While it iterates a solid may fold where its law does not mind; not at the end of a step.
#[cfg(not(test))]
fn guards(physics: &Physics, solid: &Solid) -> bool {
    physics.fluid.is_none() || solid.material.needs_positive_volume()
}

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// What is coupled in a matrix.
    fn pairs(&self, matrix: Matrix) -> Vec<Pair> {
        match matrix {
            Matrix::Whole => pairs(&self.pieces),
            Matrix::Condensed => CONDENSED.to_vec(),
        }
    }

    /// The rows and columns of a matrix in a batch.
    fn numbering_of(&self, matrix: Matrix, batch: usize, number: &[u32]) -> Numbering<D, L> {
        match matrix {
            Matrix::Whole => self.numbering(batch, number),
            Matrix::Condensed => self.outer_numbering(batch, number),
        }
    }
}

impl<F: StepForm<D> + Send, const D: usize, const L: usize> Operator<D> for Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    fn body(&self) -> Region {
        self.region
    }

    fn material(&self) -> Option<u16> {
        Some(self.material)
    }

    fn set_data(&mut self, at: &DataTime) -> Result<(), NotFinite<D>> {
        self.body_force.set(at);
        Ok(())
    }

    fn set_force(&mut self, end: End, force: Option<ForceAt<'_, D>>) {
        self.body_force.fill(end, force, &self.batches.positions);
    }

    fn explicit(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        self.move_force(step, End::Old, Tangent::Automatic);
        self.add_explicit(step, out);
    }

    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        self.move_force(step, End::New, Tangent::Automatic);
        let min_j = self.add_residual(step, out);
        if self.guards { min_j } else { f64::INFINITY }
    }

    fn entries(&self, matrix: Matrix, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        let pairs = self.pairs(matrix);
        for batch in 0..self.batches.len() {
            self.numbering_of(matrix, batch, number).visit(&pairs, visit);
        }
    }

    fn place(&mut self, matrix: Matrix, number: &[u32], entries: &Entries<'_>) -> Result<(), SolverError> {
        let numbering = |batch| self.numbering_of(matrix, batch, number);
        let slots =
            Slots::new(self.batches.len(), &self.batches.chunks, entries, &self.pairs(matrix), numbering)?;
        match (matrix, &mut self.interior) {
            (Matrix::Whole, _) => self.slots = slots,
            (Matrix::Condensed, Some(interior)) => interior.slots = slots,
            (Matrix::Condensed, None) => {}
        }
        Ok(())
    }

    /// The condensed matrix is that of [`RegionOperator::condense`].
    fn linearise(&mut self, matrix: Matrix, step: &StepView<'_>, how: How, out: &mut [f64]) {
        if matrix == Matrix::Whole {
            self.move_force(step, End::New, how.tangent);
            self.add_jacobian(step, how.linearization, how.tangent, out);
        }
    }

    fn apply(&mut self, matrix: Matrix, step: &StepView<'_>, x: &[f64], y: &mut [f64]) {
        self.move_force(step, End::New, Tangent::Automatic);
        self.add_product(matrix, step, x, y);
    }

    fn extension(&self, step: &StepView<'_>, visit: &mut dyn FnMut(u32, u32, f64)) -> bool {
        let here = self.region == Region::Fluid;
        if here {
            self.visit_extension(step, visit);
        }
        here
    }
}

impl<F: StepForm<D> + Send, const D: usize, const L: usize> RegionOperator<D> for Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    fn follow(&mut self, force: CurrentForce<D>) {
        self.body_force.follow(force);
    }

    fn take_fabric(&mut self, space: &FsiSpace<D>) {
        self.fabric = fabric::fabric(space, (self.region, self.material), &self.batches);
    }

    fn whole_residual(&mut self, step: &StepView<'_>, with_force: bool, out: &mut [f64]) {
        let kept = (!with_force).then(|| std::mem::replace(&mut self.body_force, BodyForce::none()));
        if step.rule.has_explicit() {
            self.explicit(step, out);
        }
        self.residual(step, out);
        self.body_force = kept.unwrap_or_else(|| std::mem::replace(&mut self.body_force, BodyForce::none()));
    }

    fn watch(&mut self, nodes: &[bool]) {
        self.watch_batches(nodes);
    }

    fn only_watched(&mut self, only: bool) {
        self.only_watched = only;
    }

    fn nodal_min_j(&mut self, space: &FsiSpace<D>, u: &[f64]) -> f64 {
        self.min_j_at_nodes(space, u)
    }

    fn worst(&self) -> Option<(f64, Vec<u32>)> {
        self.worst_cells()
    }

    fn prepare_condensed(&mut self, space: &FsiSpace<D>, blocks: &Blocks, eliminate: bool) {
        self.prepare_interior(space, &blocks.cells, eliminate);
    }

    fn inner(&self, visit: &mut dyn FnMut(u32)) {
        self.visit_inner(visit);
    }

    fn condense(&mut self, step: &StepView<'_>, tangent: Tangent, blocks: &Blocks, out: &mut [f64]) {
        self.move_force(step, End::New, tangent);
        self.add_condensed(step, tangent, blocks, out);
    }

    fn eliminate(&mut self, b: &mut [f64]) {
        self.forward(b);
    }

    fn recover(&self, x: &mut [f64]) {
        self.backward(x);
    }
}
