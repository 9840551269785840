//! The loops of both regions, with their number of lanes hidden.

use super::batch::Batches;
use super::force::CurrentForce;
use super::interior::FacetBlocks;
use super::kernel::{Kernel, StepView};
use super::scatter::DROP;
use super::simd::Width;
use super::stabilize::{Columns, Stabilizer};
use super::{End, ForceAt, Options, Physics, Worst};
use crate::algebra::SolverError;
use crate::math::{Lanes, Vector};
use crate::physics::{Fluid, Solid, Stabilization};
use crate::space::{Constraints, FsiSpace, Region};
use crate::tangent::{Linearization, Tangent};

/// The kernels of both regions with their number of lanes hidden.
pub(super) trait Kernels<const D: usize>: Send + Sync {
    fn entries(&self, constraints: &Constraints<D>, visit: &mut dyn FnMut(u32, u32));
    fn set_slots(
        &mut self,
        constraints: &Constraints<D>,
        n_entries: usize,
        find: &dyn Fn(u32, u32) -> u32,
    ) -> Result<(), SolverError>;
    fn set_force(&mut self, region: Region, end: End, force: Option<ForceAt<D>>);
    fn move_force(&mut self, step: &StepView<'_>, end: End, force: &CurrentForce<D>, tangent: Tangent);
    fn explicit(&mut self, step: &StepView<'_>, only: Option<Region>, out: &mut [f64]);
    fn residual(&mut self, step: &StepView<'_>, only: Option<Region>, out: &mut [f64]) -> f64;
    fn jacobian(
        &mut self,
        step: &StepView<'_>,
        linearization: Linearization,
        tangent: Tangent,
        out: &mut [f64],
    );
    fn watch(&mut self, nodes: &[bool]);
    fn only_watched(&mut self, only: bool);
    fn nodal_min_j(&mut self, space: &FsiSpace<D>, u: &[f64]) -> f64;
    fn worst(&self) -> Worst;
    fn prepare_condensed(&mut self, space: &FsiSpace<D>, facets: &[u32]);
    fn inner(&self, visit: &mut dyn FnMut(u32));
    fn condensed_entries(&self, number: &[u32], visit: &mut dyn FnMut(u32, u32));
    fn set_condensed_slots(
        &mut self,
        number: &[u32],
        n_entries: usize,
        find: &dyn Fn(u32, u32) -> u32,
    ) -> Result<(), SolverError>;
    fn condense(&mut self, step: &StepView<'_>, tangent: Tangent, blocks: &FacetBlocks, out: &mut [f64]);
    fn eliminate(&mut self, b: &mut [f64]);
    fn recover(&self, x: &mut [f64]);
    fn extension(&self, step: &StepView<'_>, visit: &mut dyn FnMut(u32, u32, f64));
    fn stabilize(
        &mut self,
        how: &Stabilization,
        fluid: Fluid,
        space: &FsiSpace<D>,
        options: &Options,
    ) -> Result<(), SolverError>;
    fn stabilization_entries(&self, columns: Columns, number: &[u32], visit: &mut dyn FnMut(u32, u32));
    fn set_stabilization_slots(
        &mut self,
        columns: Columns,
        number: &[u32],
        n_entries: usize,
        find: &dyn Fn(u32, u32) -> u32,
    ) -> Result<(), SolverError>;
}

/// The same with the kernels of both regions, fluid first.
macro_rules! both {
    (mut $pair:ident, $kernel:ident, $work:expr) => {
        if let Some($kernel) = &mut $pair.fluid {
            $work;
        }
        if let Some($kernel) = &mut $pair.solid {
            $work;
        }
    };
    ($pair:ident, $kernel:ident, $work:expr) => {
        if let Some($kernel) = &$pair.fluid {
            $work;
        }
        if let Some($kernel) = &$pair.solid {
            $work;
        }
    };
}

/// The kernels of both regions with one number of lanes.
pub(super) struct Pair<const D: usize, const L: usize> {
    fluid: Option<Kernel<Fluid, D, L>>,
    solid: Option<Kernel<Solid, D, L>>,
    /// One cell at a time: for every vector width it would take minutes to compile.
    stabilizer: Option<Stabilizer<D, 1>>,
}

impl<const D: usize, const L: usize> Pair<D, L>
where
    Lanes<L>: Width,
{
    /// Kernels of the regions that `physics` has.
    ///
    /// # Errors
    /// If there are too many unknowns to be numbered.
    pub(super) fn new(
        space: &FsiSpace<D>,
        physics: &Physics,
        stiffness: &dyn Fn(&[f64; D]) -> f64,
        options: &Options,
    ) -> Result<Self, SolverError> {
        let cells = |region| -> Vec<usize> {
            (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == region).collect()
        };
        let batches = |region| {
            let cells = cells(region);
            let with_pressure = cells.first().is_some_and(|&c| !space.pressure.cell(c).is_empty());
            Batches::new(space, &cells, with_pressure, options.quadrature, stiffness)
        };
        let fluid = physics
            .fluid
            .map(|form| Kernel::new(form, space, Region::Fluid, batches(Region::Fluid), options.threads))
            .transpose()?;
        let solid = physics
            .solid
            .map(|form| Kernel::new(form, space, Region::Solid, batches(Region::Solid), options.threads))
            .transpose()?;
        Ok(Pair { fluid, solid, stabilizer: None })
    }
}

impl<const D: usize, const L: usize> Kernels<D> for Pair<D, L>
where
    Lanes<L>: Width,
{
    fn entries(&self, constraints: &Constraints<D>, visit: &mut dyn FnMut(u32, u32)) {
        let mut visit = |_: usize, _: usize, row: u32, col: u32| {
            if row != DROP {
                visit(row, col);
            }
        };
        if let Some(k) = &self.fluid {
            k.entries(constraints, &mut visit);
        }
        if let Some(k) = &self.solid {
            k.entries(constraints, &mut visit);
        }
    }

    fn set_slots(
        &mut self,
        constraints: &Constraints<D>,
        n_entries: usize,
        find: &dyn Fn(u32, u32) -> u32,
    ) -> Result<(), SolverError> {
        both!(mut self, k, k.set_slots(constraints, n_entries, find)?);
        Ok(())
    }

    fn set_force(&mut self, region: Region, end: End, force: Option<ForceAt<D>>) {
        if let (Some(s), Region::Fluid) = (&mut self.stabilizer, region) {
            s.set_force(usize::from(end == End::Old), force);
        }
        match region {
            Region::Fluid => self.fluid.as_mut().map(|k| fill_force(k, end, force)),
            Region::Solid => self.solid.as_mut().map(|k| fill_force(k, end, force)),
        };
    }

    fn move_force(&mut self, step: &StepView<'_>, end: End, force: &CurrentForce<D>, tangent: Tangent) {
        if let Some(k) = &mut self.fluid {
            k.move_force(step, end, force, tangent);
        }
    }

    fn explicit(&mut self, step: &StepView<'_>, only: Option<Region>, out: &mut [f64]) {
        if let (Some(k), true) = (&mut self.fluid, only != Some(Region::Solid)) {
            k.explicit(step, out);
        }
        if let (Some(k), true) = (&mut self.solid, only != Some(Region::Fluid)) {
            k.explicit(step, out);
        }
    }

    fn residual(&mut self, step: &StepView<'_>, only: Option<Region>, out: &mut [f64]) -> f64 {
        let mut min_j = f64::INFINITY;
        if let (Some(k), true) = (&mut self.fluid, only != Some(Region::Solid)) {
            min_j = min_j.min(k.residual(step, out));
        }
        if let (Some(s), true) = (&mut self.stabilizer, only != Some(Region::Solid)) {
            s.residual(step, out);
        }
        if let (Some(k), true) = (&mut self.solid, only != Some(Region::Fluid)) {
            // While it iterates a solid may fold where its law does not mind; not at the end of a step.
            let of_solid = k.residual(step, out);
            if min_j == f64::INFINITY || k.form.material.needs_positive_volume() {
                min_j = min_j.min(of_solid);
            }
        }
        if min_j == f64::INFINITY { 1.0 } else { min_j }
    }

    fn watch(&mut self, nodes: &[bool]) {
        if let Some(k) = &mut self.fluid {
            k.watch(nodes);
        }
    }

    fn only_watched(&mut self, only: bool) {
        if let Some(k) = &mut self.fluid {
            k.only_watched = only;
        }
    }

    fn jacobian(
        &mut self,
        step: &StepView<'_>,
        linearization: Linearization,
        tangent: Tangent,
        out: &mut [f64],
    ) {
        both!(mut self, k, k.jacobian(step, linearization, tangent, out));
        if let Some(s) = &mut self.stabilizer {
            s.matrix(Columns::All, step, tangent, out);
        }
    }

    fn nodal_min_j(&mut self, space: &FsiSpace<D>, u: &[f64]) -> f64 {
        let mut min_j = f64::INFINITY;
        both!(mut self, k, min_j = min_j.min(k.nodal_min_j(space, u)));
        min_j
    }

    fn worst(&self) -> Worst {
        let mut list = vec![];
        both!(self, k, list.extend(k.worst()));
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let min_j = list.first().map_or(1.0, |worst| worst.0);
        // Of the other region those cells that are folded, too.
        let cells = |(j, cells): (f64, Vec<u32>)| if j <= 0.0 || j == min_j { cells } else { vec![] };
        Worst { min_j, cells: list.into_iter().flat_map(cells).collect() }
    }

    fn prepare_condensed(&mut self, space: &FsiSpace<D>, facets: &[u32]) {
        // Stabilisation couples the inner unknowns of the fluid to others: nothing is eliminated there.
        let eliminate = self.stabilizer.is_none();
        if let Some(k) = &mut self.fluid {
            k.prepare_condensed(space, facets, eliminate);
        }
        if let Some(k) = &mut self.solid {
            k.prepare_condensed(space, facets, true);
        }
    }

    fn inner(&self, visit: &mut dyn FnMut(u32)) {
        both!(self, k, k.inner(&mut *visit));
    }

    fn condensed_entries(&self, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        let mut visit = |_: usize, row: u32, col: u32| {
            if row != DROP {
                visit(row, col);
            }
        };
        both!(self, k, k.condensed_entries(number, &mut visit));
    }

    fn set_condensed_slots(
        &mut self,
        number: &[u32],
        n_entries: usize,
        find: &dyn Fn(u32, u32) -> u32,
    ) -> Result<(), SolverError> {
        both!(mut self, k, k.set_condensed_slots(number, n_entries, find)?);
        Ok(())
    }

    fn condense(&mut self, step: &StepView<'_>, tangent: Tangent, blocks: &FacetBlocks, out: &mut [f64]) {
        both!(mut self, k, k.condense(step, tangent, blocks, out));
        if let Some(s) = &mut self.stabilizer {
            s.matrix(Columns::Flow, step, tangent, out);
        }
    }

    fn eliminate(&mut self, b: &mut [f64]) {
        both!(mut self, k, k.eliminate(b));
    }

    fn recover(&self, x: &mut [f64]) {
        both!(self, k, k.recover(x));
    }

    fn extension(&self, step: &StepView<'_>, visit: &mut dyn FnMut(u32, u32, f64)) {
        if let Some(k) = &self.fluid {
            k.extension(step, visit);
        }
    }

    fn stabilize(
        &mut self,
        how: &Stabilization,
        fluid: Fluid,
        space: &FsiSpace<D>,
        options: &Options,
    ) -> Result<(), SolverError> {
        let stabilizer = Stabilizer::<D, 1>::new(how, fluid, space, options.quadrature, options.threads)?;
        self.stabilizer = Some(stabilizer);
        Ok(())
    }

    fn stabilization_entries(&self, columns: Columns, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        if let Some(s) = &self.stabilizer {
            s.entries(columns, number, |_, row, col| {
                if row != DROP {
                    visit(row, col);
                }
            });
        }
    }

    fn set_stabilization_slots(
        &mut self,
        columns: Columns,
        number: &[u32],
        n_entries: usize,
        find: &dyn Fn(u32, u32) -> u32,
    ) -> Result<(), SolverError> {
        match &mut self.stabilizer {
            Some(s) => s.set_slots(columns, number, n_entries, find),
            None => Ok(()),
        }
    }
}

fn fill_force<F: crate::tangent::ByHand<D>, const D: usize, const L: usize>(
    kernel: &mut Kernel<F, D, L>,
    end: End,
    force: Option<ForceAt<D>>,
) where
    Lanes<L>: Width,
{
    let field = match end {
        End::Old => &mut kernel.force_old,
        End::New => &mut kernel.force,
    };
    field.clear();
    let Some(force) = force else { return };
    for position in &kernel.batches.positions {
        let mut values = Vector::<Lanes<L>, D>::zero();
        for l in 0..L {
            let f = force(&std::array::from_fn(|d| position.0[d].0[l]));
            for d in 0..D {
                values.0[d].0[l] = f[d];
            }
        }
        field.push(values);
    }
}
