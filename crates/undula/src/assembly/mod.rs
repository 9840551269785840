//! E B D Bᵀ over all cells: residual and Jacobian of one step.
//!
//! Cells are processed `L` at a time, one per vector lane, in chunks that threads share out; every sum has
//! one order, so that the result does not depend on the number of threads.
//! After the first call nothing is allocated.
//!
//! The loops are of this crate alone: vectors of several lanes are for processors that have the instructions, which
//! [`Assembler::new`] looks after.
// Unit tests have no kernels, see `kernels` below.
#![cfg_attr(test, allow(dead_code))]

pub(crate) mod batch;
pub(crate) mod biharmonic;
pub(crate) mod chunks;
mod condense;
mod differences;
pub(crate) mod evaluate;
pub mod extension;
pub mod facets;
mod fields;
pub mod force;
pub(crate) mod interior;
pub(crate) mod kernel;
mod min_jacobian;
mod nodal;
mod pair;
pub mod sampling;
pub(crate) mod scatter;
pub(crate) mod simd;
pub(crate) mod stabilize;
mod tangents;
mod tasks;
pub(crate) mod tensor;
pub(crate) mod test_functions;

use crate::algebra::{Csr, Kind, Pattern, SolverError, Unknown};
use crate::physics::{Extension, Fluid, Solid, Stabilization};
use crate::space::{BoundaryCondition, ClosedPressure, Constraints, FsiSpace, PressureKind, Region, State};
use crate::tangent::{Difference, Linearization, Sizes, Tangent};
use biharmonic::Biharmonic;
use extension::ExtensionSystem;
use facets::OutflowFacets;
use force::CurrentForce;
use interior::FacetBlocks;
pub use kernel::StepView;
use pair::Kernels;
#[cfg(not(test))]
use pair::Pair;
use scatter::DROP;
pub use simd::{available, best_lanes};
use stabilize::Columns;
use std::sync::Arc;

/// The equations of the regions; an absent one is `None`.
#[derive(Copy, Clone, Debug)]
pub struct Physics {
    /// Flow and extension.
    pub fluid: Option<Fluid>,
    /// Elastic body.
    pub solid: Option<Solid>,
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
        Options { lanes: simd::best_lanes(), threads: 1, quadrature }
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

/// Where J is smallest.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// Smallest J at a quadrature point or node, fluid and solid.
    pub min_j: f64,
    /// The cell in which it lies, then all others with J ≤ 0.
    pub cells: Vec<u32>,
}

/// Residual and Jacobian of the coupled problem.
pub struct Assembler<const D: usize> {
    /// Spaces.
    pub space: Arc<FsiSpace<D>>,
    /// Given unknowns.
    pub constraints: Constraints<D>,
    /// The equations.
    pub physics: Physics,
    /// The body force of the fluid, where it is taken at the current position.
    pub current_force: Option<CurrentForce<D>>,
    kernels: Box<dyn Kernels<D>>,
    outflow: OutflowFacets<D>,
    /// The extension where it is of fourth order.
    biharmonic: Option<Biharmonic>,
    /// Rows that read δ = 0.
    given: Vec<u32>,
    /// Parts of the fluid whose pressure is determined up to a constant; their rows that read δ = 0 are the last.
    closed: Vec<ClosedPressure>,
    /// Sparsity of the Jacobian and the places of the diagonal entries of the given rows, once asked for.
    full: Option<(Arc<Pattern>, Vec<u32>)>,
    condensed: Option<Arc<CondensedSystem>>,
    blocks: FacetBlocks,
    stabilized: bool,
}

/// The (v, p) system of condensed Newton: given unknowns and those inside of cells are left out.
#[derive(Debug)]
pub struct CondensedSystem {
    /// Sparsity of its matrix.
    pub pattern: Arc<Pattern>,
    /// Place in `[v, u, p]` of each of its unknowns.
    pub places: Vec<u32>,
    /// What the linear solver may know of them.
    pub unknowns: Vec<Unknown>,
}

impl Assembler<2> {
    /// Prepare everything that stays for the run.
    ///
    /// `conditions` has one entry per boundary of the mesh; `stiffness` is E_e(x) of the extension. Not generic in
    /// the dimension: whoever called it would compile all kernels once more.
    ///
    /// # Panics
    /// Where [`Assembler::try_new`] fails.
    pub fn new(
        space: Arc<FsiSpace<2>>,
        physics: Physics,
        conditions: &[BoundaryCondition<2>],
        stiffness: &dyn Fn(&[f64; 2]) -> f64,
        options: &Options,
    ) -> Assembler<2> {
        granted(Self::try_new(space, physics, conditions, stiffness, options))
    }

    /// [`Assembler::new`] of a problem that may be too large.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if there are too many unknowns to be numbered.
    pub fn try_new(
        space: Arc<FsiSpace<2>>,
        physics: Physics,
        conditions: &[BoundaryCondition<2>],
        stiffness: &dyn Fn(&[f64; 2]) -> f64,
        options: &Options,
    ) -> Result<Assembler<2>, SolverError> {
        let kernels = kernels(&space, &physics, stiffness, options)?;
        Ok(Assembler::with(kernels, space, physics, conditions, options))
    }
}

/// The kernels with the lanes that are asked for or, if this build or this processor has none, with the most it has.
#[cfg(not(test))]
fn kernels(
    space: &FsiSpace<2>,
    physics: &Physics,
    stiffness: &dyn Fn(&[f64; 2]) -> f64,
    options: &Options,
) -> Result<Box<dyn Kernels<2>>, SolverError> {
    let there = simd::compiled(options.lanes) && simd::available(options.lanes);
    Ok(match if there { options.lanes } else { simd::best_lanes() } {
        #[cfg(lanes_8)]
        8 => Box::new(Pair::<2, 8>::new(space, physics, stiffness, options)?),
        #[cfg(lanes_4)]
        4 => Box::new(Pair::<2, 4>::new(space, physics, stiffness, options)?),
        _ => Box::new(Pair::<2, 1>::new(space, physics, stiffness, options)?),
    })
}

/// None: they are not compiled twice for `cargo test`. What assembles is tested in `tests/it`.
#[cfg(test)]
fn kernels(
    _: &FsiSpace<2>,
    _: &Physics,
    _: &dyn Fn(&[f64; 2]) -> f64,
    _: &Options,
) -> Result<Box<dyn Kernels<2>>, SolverError> {
    unimplemented!("unit tests have no kernels")
}

impl<const D: usize> Assembler<D> {
    fn with(
        kernels: Box<dyn Kernels<D>>,
        space: Arc<FsiSpace<D>>,
        physics: Physics,
        conditions: &[BoundaryCondition<D>],
        options: &Options,
    ) -> Assembler<D> {
        let constraints = Constraints::new(&space, conditions);
        let outflow = OutflowFacets::new(&space, physics.fluid, conditions, options.quadrature);
        let given = given_rows(&space, &constraints);
        let blocks = FacetBlocks::default();
        let biharmonic = match physics.fluid.map(|f| f.extension) {
            Some(Extension::Biharmonic { hinged }) if space.deforms => {
                Some(Biharmonic::new(&space, &constraints, hinged, options.quadrature))
            }
            _ => None,
        };
        Assembler {
            space,
            constraints,
            physics,
            current_force: None,
            kernels,
            outflow,
            biharmonic,
            given,
            closed: vec![],
            full: None,
            condensed: None,
            blocks,
            stabilized: false,
        }
    }

    /// Add stabilisation to the equations of the fluid, section 5.3.3; before any matrix is asked for.
    ///
    /// # Panics
    /// If π projects on patches that the mesh does not have: cells that come from refining one in four.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if there are too many unknowns to be numbered.
    pub fn stabilize(&mut self, how: &Stabilization, options: &Options) -> Result<(), SolverError> {
        if let (Some(fluid), true) = (self.physics.fluid, how.acts()) {
            self.kernels.stabilize(how, fluid, &self.space, options)?;
            self.stabilized = true;
        }
        Ok(())
    }

    /// Determine the pressures of `closed`, which the equations leave open by a constant; before any matrix is asked
    /// for. Corrections leave one unknown of each alone, but the residual keeps its row, which is that of the data
    /// being in balance.
    pub fn close(&mut self, closed: Vec<ClosedPressure>) {
        let first = self.space.n_v() + self.space.n_u();
        self.constraints.p = vec![false; if closed.is_empty() { 0 } else { self.space.n_p() }];
        for part in &closed {
            self.constraints.p[part.fixed as usize] = true;
            self.given.push(first as u32 + part.fixed);
        }
        self.closed = closed;
    }

    /// Make the mean of each pressure of [`Assembler::close`] 0.
    pub fn level(&self, p: &mut [f64]) {
        self.closed.iter().for_each(|part| part.level(p));
    }

    /// Whether there is stabilisation, with parameters from the old state.
    pub fn is_stabilized(&self) -> bool {
        self.stabilized
    }

    /// Sparsity of the Jacobian, all unknowns in the order v, u, p; found when first asked for.
    ///
    /// # Panics
    /// Where [`Assembler::try_pattern`] fails.
    pub fn pattern(&mut self) -> Arc<Pattern> {
        granted(self.try_pattern())
    }

    /// [`Assembler::pattern`] of a problem that may be too large.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if it has too many entries to be numbered.
    pub fn try_pattern(&mut self) -> Result<Arc<Pattern>, SolverError> {
        let Self { space, constraints, kernels, outflow, biharmonic, given, full, .. } = self;
        if let Some((pattern, _)) = full {
            return Ok(Arc::clone(pattern));
        }
        let mut rows: Vec<Vec<u32>> = vec![vec![]; space.n_unknowns()];
        given.iter().for_each(|&row| rows[row as usize].push(row));
        kernels.entries(constraints, &mut |row, col| rows[row as usize].push(col));
        outflow.entries(constraints, |row, col| {
            if col != DROP {
                rows[row as usize].push(col);
            }
        });
        let mut free: Vec<u32> = (0..space.n_unknowns() as u32).collect();
        given.iter().for_each(|&row| free[row as usize] = DROP);
        kernels.stabilization_entries(Columns::All, &free, &mut |row, col| rows[row as usize].push(col));
        if let Some(b) = biharmonic {
            b.visit(&mut |row, col, _| {
                if free[col as usize] != DROP {
                    rows[row as usize].push(col);
                }
            });
        }
        let pattern = Arc::new(Pattern::from_rows(&rows));
        drop(rows);
        let find = |row: u32, col: u32| pattern.find(row as usize, col as usize).map_or(DROP, |at| at as u32);
        if let Some(b) = biharmonic {
            b.set_slots(find);
        }
        kernels.set_slots(constraints, pattern.nnz(), &find)?;
        kernels.set_stabilization_slots(Columns::All, &free, pattern.nnz(), &find)?;
        outflow.set_slots(constraints, find);
        let diagonals = given.iter().map(|&row| find(row, row)).collect();
        *full = Some((Arc::clone(&pattern), diagonals));
        Ok(pattern)
    }

    /// The (v, p) system of condensed Newton, found when first asked for.
    ///
    /// # Panics
    /// Where [`Assembler::try_condensed`] fails.
    pub fn condensed(&mut self) -> Arc<CondensedSystem> {
        granted(self.try_condensed())
    }

    /// [`Assembler::condensed`] of a problem that may be too large.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if it has too many entries to be numbered.
    pub fn try_condensed(&mut self) -> Result<Arc<CondensedSystem>, SolverError> {
        if let Some(system) = &self.condensed {
            return Ok(Arc::clone(system));
        }
        self.kernels.prepare_condensed(&self.space, &self.outflow.cells);
        let n = self.space.n_unknowns();
        let mut number = vec![0; n];
        number[self.space.n_v()..self.space.n_v() + self.space.n_u()].fill(DROP);
        self.given.iter().for_each(|&place| number[place as usize] = DROP);
        self.kernels.inner(&mut |place| number[place as usize] = DROP);
        let all = self.unknowns();
        let (mut places, mut unknowns) = (vec![], vec![]);
        for place in 0..n {
            if number[place] != DROP {
                number[place] = places.len() as u32;
                places.push(place as u32);
                unknowns.push(all[place]);
            }
        }
        let mut rows: Vec<Vec<u32>> = vec![vec![]; places.len()];
        self.kernels.condensed_entries(&number, &mut |row, col| rows[row as usize].push(col));
        let visit = &mut |row: u32, col: u32| rows[row as usize].push(col);
        self.kernels.stabilization_entries(Columns::Flow, &number, visit);
        let pattern = Arc::new(Pattern::from_rows(&rows));
        drop(rows);
        let find = |row: u32, col: u32| pattern.find(row as usize, col as usize).map_or(DROP, |at| at as u32);
        self.kernels.set_condensed_slots(&number, pattern.nnz(), &find)?;
        self.kernels.set_stabilization_slots(Columns::Flow, &number, pattern.nnz(), &find)?;
        let system = Arc::new(CondensedSystem { pattern, places, unknowns });
        self.condensed = Some(Arc::clone(&system));
        Ok(system)
    }

    /// The matrix of [`Assembler::condensed`], which must have been asked for; the factors of the inner
    /// blocks are kept.
    pub fn condensed_matrix(&mut self, step: &StepView<'_>, tangent: Tangent, out: &mut Csr) {
        out.values.fill(0.0);
        let tangent = sized(tangent, step);
        self.move_force(step, End::New, tangent);
        self.outflow.blocks(step, tangent, &mut self.blocks);
        self.kernels.condense(step, tangent, &self.blocks, &mut out.values);
    }

    /// Forward elimination of the unknowns inside of cells from a right-hand side `[v, u, p]`.
    pub fn eliminate_inner(&mut self, b: &mut [f64]) {
        self.kernels.eliminate(b);
    }

    /// The unknowns inside of cells of a solution `[v, u, p]` whose others are known.
    pub fn recover_inner(&self, x: &mut [f64]) {
        self.kernels.recover(x);
    }

    /// The extension as a system of its own; `None` without fluid or deformation.
    pub fn extension(&self, step: &StepView<'_>) -> Option<ExtensionSystem> {
        if !self.space.deforms || self.physics.fluid.is_none() {
            return None;
        }
        let visit = |put: &mut dyn FnMut(u32, u32, f64)| match &self.biharmonic {
            Some(b) => b.visit(put),
            None => self.kernels.extension(step, put),
        };
        Some(ExtensionSystem::new(&self.space, &self.constraints, visit))
    }

    /// Whether the extension is of fourth order.
    pub fn is_biharmonic(&self) -> bool {
        self.biharmonic.is_some()
    }

    /// Take the derivative at the iterate of `step` into a `system` of [`Assembler::extension`]; whether there is
    /// anything to take, the operator not being constant.
    pub fn renew_extension(&self, step: &StepView<'_>, system: &mut ExtensionSystem) -> bool {
        let changes = !self.extension_is_constant();
        if changes {
            system.fill(|put: &mut dyn FnMut(u32, u32, f64)| self.kernels.extension(step, put));
        }
        changes
    }

    /// Whether the operator of the extension is the same at all states.
    pub fn extension_is_constant(&self) -> bool {
        self.physics.fluid.is_none_or(|f| f.extension.is_constant())
    }

    /// What the linear solver may know of each unknown.
    pub fn unknowns(&self) -> Vec<Unknown> {
        let space = &self.space;
        let position = |x: &[f64; D]| std::array::from_fn(|d| if d < D { x[d] } else { 0.0 });
        let mut list = vec![];
        for kind in [Kind::Velocity, Kind::Deformation] {
            if kind == Kind::Velocity || space.deforms {
                for (node, x) in space.nodes.points.iter().enumerate() {
                    list.extend([Unknown { node: node as u32, kind, at: position(x) }; D]);
                }
            }
        }
        let first = space.nodes.len() as u32;
        for (dof, x) in space.pressure.points.iter().enumerate() {
            // Continuous pressures sit on vertices, which are nodes of the velocity, too.
            let node = match space.pressure.kind {
                PressureKind::Pdc(_) => first + dof as u32 / space.pressure.per_cell as u32,
                PressureKind::Continuous(_) => space.pressure_node(dof),
            };
            list.push(Unknown { node, kind: Kind::Pressure, at: position(x) });
        }
        list
    }

    /// Set the body force of a region at one end of the step; `None`: no force.
    pub fn set_force(&mut self, region: Region, end: End, force: Option<ForceAt<D>>) {
        self.kernels.set_force(region, end, force);
    }

    /// The time of the body force at the current position, and the part of it that acts.
    pub fn set_current_force(&mut self, end: End, time: f64, factor: f64) {
        if let Some(force) = &mut self.current_force {
            force.set(end, time, factor);
        }
    }

    fn move_force(&mut self, step: &StepView<'_>, end: End, tangent: Tangent) {
        if let Some(force) = &self.current_force {
            self.kernels.move_force(step, end, force, tangent);
        }
    }

    /// The explicit part (1 − θ) A(U⁻) of all rows, `[v, u, p]`, given rows included.
    pub fn explicit(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        out.fill(0.0);
        if step.rule.has_explicit() {
            self.move_force(step, End::Old, Tangent::Automatic);
            self.kernels.explicit(step, None, out);
            self.outflow.explicit(step, out);
        }
    }

    /// The residual `[v, u, p]` of the step; `out` holds the explicit part on entry. Given rows are 0, but for those of
    /// [`Assembler::close`].
    ///
    /// Returns the smallest J at the quadrature points of both regions.
    pub fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        self.move_force(step, End::New, Tangent::Automatic);
        let min_j = self.kernels.residual(step, None, out);
        self.outflow.residual(step, out);
        if let Some(b) = &self.biharmonic {
            b.residual(&step.new.u, out);
        }
        for &row in &self.given[..self.given.len() - self.closed.len()] {
            out[row as usize] = 0.0;
        }
        min_j
    }

    /// Choose the nodes at which [`Assembler::watched_residual`] is complete.
    pub fn watch(&mut self, nodes: &[u32]) {
        let mut watched = vec![false; self.space.nodes.len()];
        nodes.iter().for_each(|&node| watched[node as usize] = true);
        self.kernels.watch(&watched);
    }

    /// [`Assembler::region_residual`] of the fluid, from the cells at the nodes of [`Assembler::watch`] and their
    /// neighbours only.
    pub fn watched_residual(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        self.kernels.only_watched(true);
        self.region_residual(step, Region::Fluid, out);
        self.kernels.only_watched(false);
    }

    /// The residual of one region alone with its explicit part, given rows not zeroed: its φ rows are the
    /// forces that the region exerts on the nodes, per unit time of the step.
    pub fn region_residual(&mut self, step: &StepView<'_>, region: Region, out: &mut [f64]) {
        out.fill(0.0);
        if step.rule.has_explicit() {
            self.move_force(step, End::Old, Tangent::Automatic);
            self.kernels.explicit(step, Some(region), out);
        }
        self.move_force(step, End::New, Tangent::Automatic);
        self.kernels.residual(step, Some(region), out);
        if region == Region::Fluid {
            if let Some(b) = &self.biharmonic {
                b.residual(&step.new.u, out);
            }
            self.outflow.residual(step, out);
            self.outflow.explicit(step, out);
        }
    }

    /// What the outflow conditions add to the residual.
    pub fn outflow(&self) -> &OutflowFacets<D> {
        &self.outflow
    }

    /// The Jacobian of [`Assembler::residual`] with respect to the new state, on [`Assembler::pattern`].
    pub fn jacobian(&mut self, step: &StepView<'_>, tangent: Tangent, out: &mut Csr) {
        self.matrix(step, Linearization::Newton, tangent, out);
    }

    /// The matrix of an iteration on [`Assembler::pattern`], in which derivatives that are left out are 0; that
    /// of `Condensed` is the reduced one here, before u is eliminated.
    pub fn matrix(
        &mut self,
        step: &StepView<'_>,
        linearization: Linearization,
        tangent: Tangent,
        out: &mut Csr,
    ) {
        let linearization = match linearization {
            Linearization::Condensed => Linearization::Reduced,
            other => other,
        };
        let tangent = sized(tangent, step);
        self.move_force(step, End::New, tangent);
        self.pattern();
        out.values.fill(0.0);
        self.kernels.jacobian(step, linearization, tangent, &mut out.values);
        self.outflow.jacobian(step, linearization, tangent, &mut out.values);
        if let Some(b) = &self.biharmonic {
            b.jacobian(&mut out.values);
        }
        for &diagonal in self.full.iter().flat_map(|(_, diagonals)| diagonals) {
            out.values[diagonal as usize] = 1.0;
        }
    }

    /// The smallest J of the last residual and at the nodes of `state`: quadrature points alone do not see cells
    /// that fold at a corner.
    pub fn nodal_min_j(&mut self, state: &State) -> f64 {
        if self.space.deforms { self.kernels.nodal_min_j(&self.space, &state.u) } else { 1.0 }
    }

    /// Where J was smallest in the last residual, and at the nodes if that was asked for since.
    pub fn worst(&self) -> Worst {
        self.kernels.worst()
    }

    /// Zero the rows of given unknowns of a vector `[v, u, p]`.
    pub fn zero_given(&self, out: &mut [f64]) {
        for &row in &self.given {
            out[row as usize] = 0.0;
        }
    }
}

/// What a problem that is not too large has.
#[track_caller]
fn granted<T>(result: Result<T, SolverError>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// The same with the sizes of the fields of the iterate, which differences need.
fn sized(tangent: Tangent, step: &StepView<'_>) -> Tangent {
    match tangent {
        Tangent::Difference(by) => {
            let sizes = Sizes::of([&step.new.v, &step.new.u, &step.new.p]);
            Tangent::Difference(Difference { sizes, ..by })
        }
        other => other,
    }
}

fn given_rows<const D: usize>(space: &FsiSpace<D>, constraints: &Constraints<D>) -> Vec<u32> {
    let velocity = constraints.v.iter().flat_map(|&given| [given; D]);
    let deformation = constraints.u.iter().flatten().copied();
    let all = velocity.chain(deformation.filter(|_| space.deforms));
    all.zip(0..).filter(|(given, _)| *given).map(|(_, row)| row).collect()
}
