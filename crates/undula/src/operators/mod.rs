//! What is summed: one file is one term of the residual, discretised, and implements [`Operator`]. (`border` and `columns`
//! are what several of them need.)
//!
//! The volume terms of a region are a [`RegionOperator`]: its cells are where J is seen and where unknowns are
//! eliminated. Several fluids or solids are several values of it, each with its own equations. All others only add.
//! `system` sums them.
// Unit tests have no kernels, see `region`.
#![cfg_attr(test, allow(dead_code))]

pub mod backflow;
pub mod biharmonic;
pub mod border;
mod columns;
pub mod facets;
mod instant;
pub mod kernels;
pub mod nodal_load;
pub mod outflow;
pub mod outlet;
pub mod pressure;
pub mod region;
pub mod spring;
pub mod stabilization;
pub mod traction;

use crate::algebra::{Sink, SolverError};
pub use crate::loops::scatter::DROP;
pub use crate::loops::slots::Entries;
use crate::math::Vector;
use crate::mesh::Side;
use crate::physics::{Fluid, Solid, StepRule};
use crate::space::{FsiSpace, Region, State};
use crate::tangent::{Linearization, Tangent};
use border::Borders;
use region::current_force::CurrentForce;

/// The equations of the regions; an absent one is `None`.
#[derive(Copy, Clone, Debug)]
pub struct Physics {
    /// Flow and extension; of several fluids that of material 0. All have the same extension.
    pub fluid: Option<Fluid>,
    /// Elastic body; of several that of material 0.
    pub solid: Option<Solid>,
    /// Fluids and solids of the materials 1, 2, …, kept until the program ends: every copy of the equations refers to
    /// them.
    pub further: &'static [(Option<Fluid>, Option<Solid>)],
}

impl Physics {
    /// One body of each kind at most.
    pub const fn new(fluid: Option<Fluid>, solid: Option<Solid>) -> Physics {
        Physics { fluid, solid, further: &[] }
    }

    /// Several bodies of each kind; their numbers are their materials, see [`FsiSpace::material`].
    pub fn of_several(fluids: &[Fluid], solids: &[Solid]) -> Physics {
        let number = fluids.len().max(solids.len());
        let further: Vec<_> = (1..number).map(|n| (fluids.get(n).copied(), solids.get(n).copied())).collect();
        let further = if further.is_empty() { &[][..] } else { further.leak() };
        Physics { fluid: fluids.first().copied(), solid: solids.first().copied(), further }
    }

    /// The equations of one material alone.
    pub fn of(&self, material: u16) -> Physics {
        let (fluid, solid) = match usize::from(material) {
            0 => (self.fluid, self.solid),
            n => self.further[n - 1],
        };
        Physics::new(fluid, solid)
    }

    /// The fluids with their materials.
    pub fn fluids(&self) -> impl Iterator<Item = (u16, Fluid)> {
        let further = self.further.iter().map(|(fluid, _)| *fluid);
        (0..).zip(std::iter::once(self.fluid).chain(further)).filter_map(|(n, fluid)| Some((n, fluid?)))
    }

    /// The solids with their materials.
    pub fn solids(&self) -> impl Iterator<Item = (u16, Solid)> {
        let further = self.further.iter().map(|(_, solid)| *solid);
        (0..).zip(std::iter::once(self.solid).chain(further)).filter_map(|(n, solid)| Some((n, solid?)))
    }
}

/// Body force per mass at a position \[m/s²\].
pub type ForceAt<'a, const D: usize> = &'a dyn Fn(&[f64; D]) -> [f64; D];

/// How the loops run; none of it changes the problem solved.
#[derive(Copy, Clone, Debug)]
pub struct Options {
    /// Cells per batch: 1, 4 or 8; what this processor or this build does not have is replaced by the best there is.
    pub lanes: usize,
    /// Threads at work at the same time. Loops run on the rayon pool from which they are called; more threads than these
    /// wait for each other, and none work side by side if this is 1. The results are the same.
    pub threads: usize,
    /// Gauss points per direction.
    pub quadrature: usize,
}

impl Options {
    /// The widest lanes there are, one thread, `quadrature` Gauss points per direction.
    pub fn serial(quadrature: usize) -> Options {
        Options { lanes: crate::loops::width::best_lanes(), threads: 1, quadrature }
    }
}

/// Which end of the step.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// The old time.
    Old,
    /// The new time.
    New,
}

/// One step as the operators see it.
#[derive(Copy, Clone)]
pub struct StepView<'a> {
    /// Weights of the scheme.
    pub rule: StepRule,
    /// The iterate.
    pub new: &'a State,
    /// What the difference is taken from: the solution at the old time, or that of a multistep formula.
    pub old: &'a State,
}

/// A matrix to which operators add the derivatives of their terms.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Matrix {
    /// Of all unknowns v, u, p.
    Whole,
    /// Of v and p alone, the condensed system. In the solid u = kθ v is eliminated, so that a column of v has
    /// ∂R/∂v + kθ ∂R/∂u. In the fluid ∂R/∂u is left out.
    Condensed,
}

/// Which derivatives, and how they are computed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct How {
    /// All of them, or without those that an iteration leaves out: momentum and divergence with respect to u. The whole
    /// matrix is never asked for as `Condensed`.
    pub linearization: Linearization,
    /// How they are computed.
    pub tangent: Tangent,
}

/// Prescribed data at one end of a step.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct DataTime {
    /// Which end.
    pub end: End,
    /// Their time \[s\].
    pub time: f64,
    /// The part of the load that acts.
    pub load: f64,
}

/// Data that are not finite numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct NotFinite<const D: usize> {
    /// Of which boundary of the mesh they are data.
    pub boundary: u16,
    /// Where \[m\].
    pub at: [f64; D],
    /// What they are.
    pub value: [f64; D],
}

/// One term of the residual, discretised.
///
/// The residual is A(U) − F, so that a load has a minus sign. A step by a θ-scheme has θ times the term at the new time
/// in [`Operator::residual`] and (1 − θ) times that at the old time in [`Operator::explicit`]. A step that integrates in
/// time has the points of [`StepRule::transport_points`] in `residual`, and no explicit part.
///
/// - A load that does not depend on the solution has [`Operator::body`], [`Operator::residual`] and, on a boundary,
///   [`Operator::force_through`], without which the functional `force` is wrong there: `traction.rs`.
/// - A term that depends on the solution has its derivative besides: [`Operator::entries`], [`Operator::place`],
///   [`Operator::linearise`] and [`Operator::apply`]. Unknowns inside of a cell are eliminated from the condensed matrix.
///   A term of single cells that sees them therefore gives [`Operator::blocks`] in place of entries there. A traction that
///   depends on v and u at its place has all this as a [`facets::FacetTerm`]: `pressure.rs`.
///   One that couples them to other cells says so in [`Operator::spans_cells`]: `stabilization`.
/// - A scalar unknown, or a far coupling, is in [`Operator::borders`]: the resistance in `tests/it/borders.rs`.
pub trait Operator<const D: usize>: Send + Sync {
    /// Whose balance of momentum the term belongs to: the force of a body is the sum of its terms.
    fn body(&self) -> Region;

    /// The material of that body whose cells the term is about; `None`: all.
    fn material(&self) -> Option<u16> {
        None
    }

    /// Take prescribed data of the time `at`.
    ///
    /// # Errors
    /// If they are not finite.
    fn set_data(&mut self, _at: &DataTime) -> Result<(), NotFinite<D>> {
        Ok(())
    }

    /// Take a body force of the body at one end of the step; `None`: no force.
    fn set_force(&mut self, _end: End, _force: Option<ForceAt<'_, D>>) {}

    /// Add the part (1 − θ) A(U⁻) to `out` \[v, u, p, s\]; not called where a step has none.
    fn explicit(&mut self, _step: &StepView<'_>, _out: &mut [f64]) {}

    /// Add the other terms of the step to `out` \[v, u, p, s\]; returns the smallest J of a map that must not fold,
    /// infinity where none is seen.
    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64;

    /// Call `visit(row, column)` for all entries of the derivative, in the numbers that `number` gives to places in
    /// `[v, u, p]`. A row or column whose number is [`DROP`] has no entry.
    fn entries(&self, _matrix: Matrix, _number: &[u32], _visit: &mut dyn FnMut(u32, u32)) {}

    /// Remember where the entries are.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if they are too many to be numbered.
    fn place(&mut self, _matrix: Matrix, _number: &[u32], _entries: &Entries<'_>) -> Result<(), SolverError> {
        Ok(())
    }

    /// Add the derivative at the iterate to the entries `out` of `matrix`.
    fn linearise(&mut self, _matrix: Matrix, _step: &StepView<'_>, _how: How, _out: Sink<'_>) {}

    /// Add the product of the derivative with `x` to `y`, both `[v, u, p]`, without a matrix.
    fn apply(&mut self, _matrix: Matrix, _step: &StepView<'_>, _x: &[f64], _y: &mut [f64]) {}

    /// How many scalar unknowns the term has. Their equations are scaled like a rate of volume \[m^D/s\].
    fn scalars(&self) -> usize {
        0
    }

    /// Whether they have no rate, like a pressure: fractional-step θ gives the means of its parts.
    fn scalars_are_algebraic(&self) -> bool {
        true
    }

    /// Their value at the start of a run.
    fn scalar_start(&self) -> f64 {
        0.0
    }

    /// Told once, where there are some: the number of the first one in `s` of a state, and its row in `[v, u, p, s]`.
    fn number_scalars(&mut self, _first: usize, _row: usize) {}

    /// What the derivative has besides its entries: couplings that would fill the matrix, equations of scalar unknowns.
    /// With the condensed matrix their columns a have entries in rows of v and p alone; their rows b may have u.
    fn borders(&mut self, _matrix: Matrix, _step: &StepView<'_>, _borders: &mut Borders) {}

    /// Cells to whose condensed matrix the term adds before unknowns inside of them are eliminated, each with D times the
    /// number of its nodes.
    fn blocks(&self) -> Vec<(u32, usize)> {
        vec![]
    }

    /// Add the derivatives with respect to v, as [`Matrix::Condensed`] has them, to dense blocks `[a, i][b, j]` of those
    /// cells.
    fn fill_blocks(&mut self, _step: &StepView<'_>, _how: How, _blocks: &mut [f64]) {}

    /// Whether the term couples unknowns inside of a cell to other cells, so that none can be eliminated.
    fn spans_cells(&self) -> bool {
        false
    }

    /// Call `visit(row, column, value)` for the entries of ψ in the fluid against u, by places in `[v, u, p]`; `true`
    /// if the term is the extension.
    fn extension(&self, _step: &StepView<'_>, _visit: &mut dyn FnMut(u32, u32, f64)) -> bool {
        false
    }

    /// What the term adds on the facets `sides`, summed over all test functions φ, the explicit part included \[N/m\].
    fn force_through(&self, _step: &StepView<'_>, _sides: &[Side]) -> Vector<f64, D> {
        Vector::zero()
    }
}

/// The volume terms of a region.
pub trait RegionOperator<const D: usize>: Operator<D> {
    /// Take the body force at the current position x + u from now on.
    fn follow(&mut self, force: CurrentForce<D>);

    /// Take what solids have at their points from the start anew.
    fn take_fabric(&mut self, space: &FsiSpace<D>);

    /// Add all terms of a step, the explicit part included, with or without the body force.
    fn whole_residual(&mut self, step: &StepView<'_>, with_force: bool, out: &mut [f64]);

    /// Note which cells have one of the watched `nodes`.
    fn watch(&mut self, nodes: &[bool]);

    /// Leave out all other cells.
    fn only_watched(&mut self, only: bool);

    /// The smallest J of the last residual and at the nodes, whose deformation is `u`.
    fn nodal_min_j(&mut self, space: &FsiSpace<D>, u: &[f64]) -> f64;

    /// Smallest J of the last residual with its cell, and all cells where J is not positive.
    fn worst(&self) -> Option<(f64, Vec<u32>)>;

    /// Make room for the condensed system; `blocks` are the cells of [`Blocks`]. Unknowns inside of cells are eliminated
    /// if asked to.
    fn prepare_condensed(&mut self, space: &FsiSpace<D>, blocks: &Blocks, eliminate: bool);

    /// Call `visit` with the places in `[v, u, p]` of the unknowns that are eliminated.
    fn inner(&self, visit: &mut dyn FnMut(u32));

    /// Add the condensed matrix to its entries `out`, with `blocks` added to the cells; the factors of the inner unknowns
    /// are kept.
    fn condense(&mut self, step: &StepView<'_>, tangent: Tangent, blocks: &Blocks, out: Sink<'_>);

    /// `b_o ← b_o − A_oi A_ii⁻¹ b_i` in `[v, u, p]`; the inner ones are kept for [`RegionOperator::recover`].
    fn eliminate(&mut self, b: &mut [f64]);

    /// `x_i = A_ii⁻¹ (b_i − A_io x_o)` in `[v, u, p]`, b being that of the last [`RegionOperator::eliminate`].
    fn recover(&self, x: &mut [f64]);
}

/// Dense blocks that terms add to cells before the unknowns inside are eliminated.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    /// Cell of each.
    pub cells: Vec<u32>,
    /// End of each in `values`.
    ends: Vec<usize>,
    /// Entries, `[block][a, i][b, j]`.
    values: Vec<f64>,
    /// Entries of each term.
    of_terms: Vec<usize>,
}

impl Blocks {
    /// Room for the blocks of `terms`, one after the other.
    pub fn of<const D: usize>(terms: &[Box<dyn Operator<D>>]) -> Blocks {
        let mut blocks = Blocks::default();
        let mut end = 0;
        for term in terms {
            let start = end;
            for (cell, rows) in term.blocks() {
                end += rows * rows;
                blocks.cells.push(cell);
                blocks.ends.push(end);
            }
            blocks.of_terms.push(end - start);
        }
        blocks.values.resize(end, 0.0);
        blocks
    }

    /// Fill them.
    pub fn fill<const D: usize>(
        &mut self,
        terms: &mut [Box<dyn Operator<D>>],
        step: &StepView<'_>,
        how: How,
    ) {
        self.values.fill(0.0);
        let mut rest = &mut self.values[..];
        for (term, &size) in terms.iter_mut().zip(&self.of_terms) {
            let (here, behind) = rest.split_at_mut(size);
            term.fill_blocks(step, how, here);
            rest = behind;
        }
    }

    /// The entries of one.
    #[inline(always)]
    pub fn entries(&self, block: usize) -> &[f64] {
        let start = if block == 0 { 0 } else { self.ends[block - 1] };
        &self.values[start..self.ends[block]]
    }
}
