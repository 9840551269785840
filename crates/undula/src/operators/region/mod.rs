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
pub(super) mod kernel;
mod min_jacobian;
mod moved_force;
mod nodal;
mod residual;
mod tangents;
#[cfg(test)]
mod tests;

use super::{
    Blocks, DataTime, End, Entries, ForceAt, How, Matrix, NotFinite, Operator, RegionOperator, StepView,
};
use crate::algebra::{Sink, SolverError};
use crate::loops::slots::{Numbering, Pair, Slots, pairs};
use crate::loops::width::Width;
use crate::math::Lanes;
use crate::space::{FsiSpace, Region};
use crate::tangent::{StepForm, Tangent};
use body_force::BodyForce;
use condensed::CONDENSED;
use current_force::CurrentForce;
use kernel::Kernel;

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
    fn linearise(&mut self, matrix: Matrix, step: &StepView<'_>, how: How, out: Sink<'_>) {
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

    fn condense(&mut self, step: &StepView<'_>, tangent: Tangent, blocks: &Blocks, out: Sink<'_>) {
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
