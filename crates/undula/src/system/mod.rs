//! The sum of all operators: residual and Jacobian of one step of the coupled problem.

mod bodies;
mod directions;
pub mod extension;
mod matrices;
mod unknowns;
mod worst;

use crate::algebra::SolverError;
pub use crate::loops::width::{available, best_lanes};
use crate::math::Vector;
use crate::mesh::Side;
use crate::operators::backflow::backflow;
use crate::operators::biharmonic::Biharmonic;
pub use crate::operators::border::{Border, Borders};
pub use crate::operators::kernels::{Dim, Kernels};
use crate::operators::outflow::correction;
pub use crate::operators::region::current_force::CurrentForce;
pub use crate::operators::stabilization::patches;
use crate::operators::{Blocks, RegionOperator};
pub use crate::operators::{DataTime, End, ForceAt, Matrix, NotFinite, Operator, Options, Physics, StepView};
use crate::physics::{Extension, Stabilization};
use crate::space::{Against, BoundaryCondition, ClosedPressure, Constraints, FsiSpace, Region, State};
use directions::DirectedBlocks;
use extension::ExtensionSystem;
pub use matrices::CondensedSystem;
use matrices::Whole;
use std::sync::Arc;
use unknowns::given_rows;
pub(crate) use unknowns::homes;
pub use worst::Worst;

/// Residual and Jacobian of the coupled problem: a sum of operators.
pub struct Assembler<const D: usize> {
    /// Spaces.
    pub space: Arc<FsiSpace<D>>,
    /// Given unknowns.
    pub constraints: Constraints<D>,
    /// The equations.
    pub physics: Physics,
    /// Volume terms of the regions, fluid first.
    regions: Vec<Box<dyn RegionOperator<D>>>,
    /// All other terms, the stabilisation first.
    terms: Vec<Box<dyn Operator<D>>>,
    /// Rows that read δ = 0.
    given: Vec<u32>,
    /// Parts of the fluid whose pressure is determined up to a constant; their rows that read δ = 0 are the last.
    closed: Vec<ClosedPressure>,
    /// The whole matrix and the condensed one, once asked for.
    whole: Option<Whole>,
    condensed: Option<Arc<CondensedSystem>>,
    /// Whether unknowns inside of long cells are eliminated from it, too.
    eliminates_in_long: bool,
    /// Directions in the whole matrix and in the condensed one.
    directions: [DirectedBlocks<D>; 2],
    blocks: Blocks,
    stabilized: bool,
    /// Number of scalar unknowns.
    scalars: usize,
    /// Borders of a product without a matrix.
    borders: Borders,
}

impl<const D: usize> Assembler<D>
where
    Dim<D>: Kernels<D>,
{
    /// Prepare everything that stays for the run.
    ///
    /// `conditions` has one entry per boundary of the mesh; `stiffness` is E_e(x) of the extension.
    ///
    /// # Panics
    /// Where [`Assembler::try_new`] fails.
    pub fn new(
        space: Arc<FsiSpace<D>>,
        physics: Physics,
        conditions: &[BoundaryCondition<D>],
        stiffness: &dyn Fn(&[f64; D]) -> f64,
        options: &Options,
    ) -> Assembler<D> {
        granted(Self::try_new(space, physics, conditions, stiffness, options))
    }

    /// [`Assembler::new`] of a problem that may be too large.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if there are too many unknowns to be numbered.
    pub fn try_new(
        space: Arc<FsiSpace<D>>,
        physics: Physics,
        conditions: &[BoundaryCondition<D>],
        stiffness: &dyn Fn(&[f64; D]) -> f64,
        options: &Options,
    ) -> Result<Assembler<D>, SolverError> {
        let regions = Dim::<D>::regions(&space, &physics, stiffness, options)?;
        // At the rim of a part the facets do not tell all.
        let constraints = match &space.part {
            Some(part) => part.constraints.clone(),
            None => Constraints::new(&space, conditions),
        };
        let mut terms: Vec<Box<dyn Operator<D>>> = vec![];
        for fluid in physics.fluids() {
            let n = options.quadrature;
            let outflow = correction(&space, fluid, conditions, n);
            terms.extend((!outflow.is_empty()).then(|| Box::new(outflow) as Box<dyn Operator<D>>));
            for against in [Against::Directional, Against::Tangential] {
                let backflow = backflow(&space, fluid, conditions, against, n);
                terms.extend((!backflow.is_empty()).then(|| Box::new(backflow) as Box<dyn Operator<D>>));
            }
        }
        if let (Some(Extension::Biharmonic { hinged }), true) =
            (physics.fluid.map(|fluid| fluid.extension), space.deforms)
        {
            terms.push(Box::new(Biharmonic::new(&space, &constraints, hinged, options.quadrature)));
        }
        let given = given_rows(&space, &constraints);
        Ok(Assembler {
            space,
            constraints,
            physics,
            regions,
            terms,
            given,
            closed: vec![],
            whole: None,
            condensed: None,
            eliminates_in_long: false,
            directions: Default::default(),
            blocks: Blocks::default(),
            stabilized: false,
            scalars: 0,
            borders: Borders::default(),
        })
    }

    /// Add stabilisation to the equations of the fluid, section 5.3.3.
    ///
    /// # Panics
    /// If a matrix was asked for already, or if π projects on patches that the mesh does not have: cells that come from refining one in four.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if there are too many unknowns to be numbered.
    pub fn stabilize(&mut self, how: &Stabilization, options: &Options) -> Result<(), SolverError> {
        self.assert_open();
        if let (Some(fluid), true) = (self.physics.fluid, how.acts()) {
            self.terms.insert(0, Dim::<D>::stabilizer(how, fluid, &self.space, options)?);
            self.stabilized = true;
        }
        Ok(())
    }
}

impl<const D: usize> Assembler<D> {
    /// Add a term to the equations; before any state is made.
    ///
    /// # Panics
    /// If a matrix was asked for already.
    pub fn add(&mut self, mut term: Box<dyn Operator<D>>) {
        self.assert_open();
        if term.scalars() > 0 {
            term.number_scalars(self.scalars, self.n_unknowns());
            self.scalars += term.scalars();
        }
        self.terms.push(term);
    }

    /// Number of all unknowns `[v, u, p, s]`, those of the fields and scalar ones.
    pub fn n_unknowns(&self) -> usize {
        self.space.n_field_unknowns() + self.scalars
    }

    /// Which scalar unknowns have no rate.
    pub fn algebraic_scalars(&self) -> Vec<bool> {
        self.terms.iter().flat_map(|term| vec![term.scalars_are_algebraic(); term.scalars()]).collect()
    }

    /// Rest, with scalar unknowns as at the start of a run.
    pub fn zero(&self) -> State {
        let space = &self.space;
        let start = |term: &dyn Operator<D>| vec![term.scalar_start(); term.scalars()];
        let s = self.terms.iter().flat_map(|term| start(&**term)).collect();
        State { s, ..State::zero(space.n_v(), space.n_u(), space.n_p()) }
    }

    /// Take what the Jacobian at the iterate of `step` has besides `matrix`.
    pub fn borders(&mut self, matrix: Matrix, step: &StepView<'_>, borders: &mut Borders) {
        borders.clear();
        self.operators_mut().for_each(|operator| operator.borders(matrix, step, borders));
    }

    /// Take the body force of the fluid `material` at the current position x + u.
    pub fn follow(&mut self, material: u16, force: CurrentForce<D>) {
        if let Some(fluid) = self.fluids().find(|fluid| fluid.material() == Some(material)) {
            fluid.follow(force);
        }
    }

    /// Determine the pressures of `closed`, which the equations leave open by a constant; once. Corrections leave one
    /// unknown of each alone, but the residual keeps its row, which is that of the data being in balance.
    ///
    /// # Panics
    /// If a matrix was asked for already, or there are closed parts already.
    pub fn close(&mut self, closed: Vec<ClosedPressure>) {
        self.assert_open();
        assert!(self.closed.is_empty(), "closed parts are told once");
        let first = self.space.n_v() + self.space.n_u();
        self.constraints.p = vec![false; if closed.is_empty() { 0 } else { self.space.n_p() }];
        for part in closed.iter().filter(|part| part.fixed != u32::MAX) {
            self.constraints.p[part.fixed as usize] = true;
            self.given.push(first as u32 + part.fixed);
        }
        self.closed = closed;
    }

    /// Make the mean of each pressure of [`Assembler::close`] 0.
    pub fn level(&self, p: &mut [f64]) {
        self.closed.iter().for_each(|part| part.level(&self.space, p));
    }

    /// Whether there is stabilisation, with parameters from the old state.
    pub fn is_stabilized(&self) -> bool {
        self.stabilized
    }

    /// Patterns have all terms.
    fn assert_open(&self) {
        assert!(
            self.whole.is_none() && self.condensed.is_none(),
            "terms are added before matrices are asked for"
        );
    }

    /// All operators, the regions first.
    fn operators(&self) -> impl Iterator<Item = &dyn Operator<D>> {
        let regions = self.regions.iter().map(|region| &**region as &dyn Operator<D>);
        regions.chain(self.terms.iter().map(|term| &**term))
    }

    fn operators_mut(&mut self) -> impl Iterator<Item = &mut dyn Operator<D>> {
        let regions = self.regions.iter_mut().map(|region| &mut **region as &mut dyn Operator<D>);
        regions.chain(self.terms.iter_mut().map(|term| &mut **term as &mut dyn Operator<D>))
    }

    /// Take prescribed data of the time `at`, but for the body forces of [`Assembler::set_force`].
    ///
    /// # Errors
    /// If they are not finite.
    pub fn set_data(&mut self, at: &DataTime) -> Result<(), NotFinite<D>> {
        // All of them take their data, whatever is wrong with one.
        self.operators_mut().map(|operator| operator.set_data(at)).fold(Ok(()), Result::and)
    }

    /// Set the body force of a region at one end of the step, in all of its materials; `None`: no force.
    pub fn set_force(&mut self, region: Region, end: End, force: Option<ForceAt<'_, D>>) {
        let of_region = self.operators_mut().filter(|operator| operator.body() == region);
        of_region.for_each(|operator| operator.set_force(end, force));
    }

    /// The same in one material of a region.
    pub fn set_force_of(&mut self, body: (Region, u16), end: End, force: Option<ForceAt<'_, D>>) {
        let is_its = |material: Option<u16>| material.is_none_or(|other| other == body.1);
        let of_body = self.operators_mut().filter(|o| o.body() == body.0 && is_its(o.material()));
        of_body.for_each(|operator| operator.set_force(end, force));
    }

    /// The explicit part (1 − θ) A(U⁻) of all rows, `[v, u, p, s]`, given rows included.
    pub fn explicit(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        out.fill(0.0);
        if step.rule.has_explicit() {
            self.operators_mut().for_each(|operator| operator.explicit(step, out));
        }
    }

    /// The residual `[v, u, p, s]` of the step; `out` holds the explicit part on entry. Given rows are 0, but for those of
    /// [`Assembler::close`].
    ///
    /// Returns the smallest J at the quadrature points of the regions whose map must not fold.
    pub fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        let min_j = self.operators_mut().map(|o| o.residual(step, out)).fold(f64::INFINITY, f64::min);
        let open = self.closed.iter().filter(|part| part.fixed != u32::MAX).count();
        for &row in &self.given[..self.given.len() - open] {
            out[row as usize] = 0.0;
        }
        directions::project(&self.space, &self.constraints, out);
        if min_j == f64::INFINITY { 1.0 } else { min_j }
    }

    /// Choose the nodes at which [`Assembler::watched_residual`] is complete.
    pub fn watch(&mut self, nodes: &[u32]) {
        let mut watched = vec![false; self.space.nodes.len()];
        nodes.iter().for_each(|&node| watched[node as usize] = true);
        self.fluids().for_each(|region| region.watch(&watched));
    }

    fn fluids(&mut self) -> impl Iterator<Item = &mut Box<dyn RegionOperator<D>>> {
        self.regions.iter_mut().filter(|region| region.body() == Region::Fluid)
    }

    /// [`Assembler::region_residual`] of the fluid, from the cells at the nodes of [`Assembler::watch`] and their
    /// neighbours only.
    pub fn watched_residual(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        self.fluids().for_each(|region| region.only_watched(true));
        self.region_residual(step, Region::Fluid, out);
        self.fluids().for_each(|region| region.only_watched(false));
    }

    /// The residual of one region alone with its explicit part, given rows not zeroed: its φ rows are the
    /// forces that the region exerts on the nodes, in the mean over the step \[N/m\].
    pub fn region_residual(&mut self, step: &StepView<'_>, region: Region, out: &mut [f64]) {
        out.fill(0.0);
        let explicit = step.rule.has_explicit();
        for operator in self.operators_mut().filter(|operator| operator.body() == region) {
            if explicit {
                operator.explicit(step, out);
            }
            operator.residual(step, out);
        }
    }

    /// What the conditions on the facets `sides` of the fluid add to the residual, summed over all test functions φ
    /// \[N/m\].
    pub fn force_through(&self, step: &StepView<'_>, sides: &[Side]) -> Vector<f64, D> {
        let of_fluid = self.terms.iter().filter(|term| term.body() == Region::Fluid);
        of_fluid.fold(Vector::zero(), |sum, term| sum + term.force_through(step, sides))
    }

    /// Whether the displacement is given somewhere, so that u has places whose values follow from it.
    pub fn is_moved(&self) -> bool {
        self.constraints.moves && self.space.deforms
    }

    /// The extension as a system of its own; `None` without fluid or deformation.
    pub fn extension(&self, step: &StepView<'_>) -> Option<ExtensionSystem<D>> {
        if !self.space.deforms || self.physics.fluid.is_none() {
            return None;
        }
        let visit = |put: &mut dyn FnMut(u32, u32, f64)| self.visit_extension(step, put);
        Some(ExtensionSystem::new(&self.space, &self.constraints, !self.extension_is_constant(), visit))
    }

    /// The entries of the term that is the extension, else those of all regions.
    fn visit_extension(&self, step: &StepView<'_>, put: &mut dyn FnMut(u32, u32, f64)) {
        if !self.terms.iter().any(|term| term.extension(step, put)) {
            for region in &self.regions {
                region.extension(step, put);
            }
        }
    }

    /// Whether the extension is of fourth order.
    pub fn is_biharmonic(&self) -> bool {
        let extension = self.physics.fluid.map(|fluid| fluid.extension);
        self.space.deforms && matches!(extension, Some(Extension::Biharmonic { .. }))
    }

    /// Take the derivative at the iterate of `step` into a `system` of [`Assembler::extension`]; whether there is
    /// anything to take, the operator not being constant.
    pub fn renew_extension(&self, step: &StepView<'_>, system: &mut ExtensionSystem<D>) -> bool {
        let changes = !self.extension_is_constant();
        if changes {
            system.fill(|put: &mut dyn FnMut(u32, u32, f64)| self.visit_extension(step, put));
        }
        changes
    }

    /// Whether the operator of the extension is the same at all states.
    pub fn extension_is_constant(&self) -> bool {
        self.physics.fluid.is_none_or(|f| f.extension.is_constant())
    }

    /// Whether each unknown `[v, u, p]` is given.
    pub fn is_given(&self) -> Vec<bool> {
        let mut given = vec![false; self.space.n_field_unknowns()];
        self.given.iter().for_each(|&row| given[row as usize] = true);
        given
    }

    /// Take the directions that boundaries do not let pass out of a vector `[v, u, p]`.
    pub fn project(&self, out: &mut [f64]) {
        directions::project(&self.space, &self.constraints, out);
    }

    /// Zero the rows of given unknowns of a vector `[v, u, p]`, and the directions that boundaries do not let pass.
    pub fn zero_given(&self, out: &mut [f64]) {
        for &row in &self.given {
            out[row as usize] = 0.0;
        }
        directions::project(&self.space, &self.constraints, out);
    }
}

/// What a problem that is not too large has.
#[track_caller]
fn granted<T>(result: Result<T, SolverError>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}
