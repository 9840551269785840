//! Solids whose measured shape is the loaded one, `solid.prestress`: the flow in that shape, and the shape without stress.
//!
//! The case begins with u = 0 and the stationary flow between solids that do not move. What all terms but the stress of
//! the solids leave at their nodes is the load. The solids alone, with U in the place of u, balance it: the inverse problem
//! of Govindjee and Mihalic (1996), see [`Reference`]. Both have the cells and the nodes of the whole case, so that at u = 0
//! nothing is left of its equations but the tolerance of both.

use super::dimension::Dimension;
use super::initial::scalars;
use crate::case::error::CaseErrors;
use crate::case::{Case, Condition, Initial, Profile};
use crate::error::Error;
use crate::nonlinear::NewtonError;
use crate::operators::nodal_load::NodalLoad;
use crate::physics::Reference;
use crate::space::{FsiSpace, Region, State};
use crate::system::Dim;
use crate::tangent::{Linearization, Tangent};
use crate::time::{StepFailure, Stepper};
use std::sync::Arc;

/// How a case with prestress begins.
pub(crate) struct Prestress {
    /// The first state: u is 0.
    pub(crate) state: State,
    /// U at the nodes \[m\].
    pub(crate) unloading: Vec<f64>,
    /// The largest of its components \[m\].
    pub(crate) largest: f64,
    /// Parts of the load that it took.
    pub(crate) parts: usize,
}

#[doc(hidden)]
impl Case {
    /// Whether the reference domain of the solids is loaded.
    pub(crate) fn is_prestressed(&self) -> bool {
        self.solids.iter().any(|solid| solid.reference != Reference::Free)
    }

    /// The stationary flow between solids that do not move; `None` without fluid.
    fn flow_alone(&self) -> Option<Case> {
        let mut flow = Case { solids: vec![], functional: vec![], ..self.at_start() };
        flow.mesh.absent = self.solid_regions().into_iter().map(String::from).collect();
        for condition in flow.boundary.values_mut().filter(|c| **c == Condition::Clamped) {
            *condition = Condition::NoSlip;
        }
        (!self.fluids.is_empty()).then_some(flow)
    }

    /// The inverse problem of the solids, without loads.
    fn solids_alone(&self) -> Case {
        let mut case = Case { fluids: vec![], functional: vec![], ..self.at_start() };
        case.mesh.absent = self.fluid_regions().into_iter().map(String::from).collect();
        for solid in &mut case.solids {
            (solid.reference, solid.body_force) = (Reference::Sought, Default::default());
        }
        case.backflow.clear();
        for condition in case.boundary.values_mut() {
            match condition {
                Condition::NoSlip | Condition::Clamped | Condition::Displacement(_) => {}
                Condition::Slip | Condition::Symmetry | Condition::Periodic(_) => {}
                Condition::Velocity(_) => *condition = Condition::Clamped,
                Condition::Flux { profile, .. } if *profile != Profile::Free => {
                    *condition = Condition::Clamped
                }
                _ => *condition = Condition::TractionFree,
            }
        }
        case.newton.linearization = Linearization::Newton;
        case.newton.jacobian = Tangent::Automatic;
        case
    }

    /// The state without displacement and the displacement that takes the stress away, on `space`.
    ///
    /// # Errors
    /// [`Error::Breakdown`] if there is no such state, [`Error::Case`] if a part of the problem is not well posed.
    pub(crate) fn prestress<const D: usize>(
        &self,
        space: &Arc<FsiSpace<D>>,
        threads: usize,
    ) -> Result<Prestress, Error>
    where
        Dim<D>: Dimension<D>,
    {
        let mut whole = self.stepper_on(space.clone(), threads)?;
        let mut state = whole.assembler.zero();
        if let Some(flow) = self.flow_alone() {
            let mut stepper = flow.build_with_notes::<D>(threads, None).map_err(about)?.0;
            let (found, _) = settled(&mut stepper)?;
            let cells = Shared::new(space, &stepper.assembler.space, Region::Fluid);
            cells.copy(&found.v, &mut state.v);
            cells.copy_pressure(&found.p, &mut state.p);
            state.s = scalars(&whole.assembler, &found.s);
        }
        let mut stepper = self.solids_alone().build_with_notes::<D>(threads, None).map_err(about)?.0;
        let part = stepper.assembler.space.clone();
        let cells = Shared::new(space, &part, Region::Solid);
        let mut load = vec![0.0; part.n_v()];
        cells.copy_back(&whole.load_of(&state), &mut load);
        stepper.add_term(Box::new(NodalLoad::new(load)));
        let (found, parts) = settled(&mut stepper)?;
        let mut unloading = vec![0.0; space.n_u()];
        cells.copy(&found.u, &mut unloading);
        cells.copy_pressure(&found.p, &mut state.p);
        let largest = unloading.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        Ok(Prestress { state, unloading, largest, parts })
    }

    /// What a start with prestress asks for besides.
    ///
    /// # Errors
    /// As [`Case::build_space`] of the flow and the solids alone.
    pub(super) fn check_prestress<const D: usize>(&self) -> Result<(), Error>
    where
        Dim<D>: Dimension<D>,
    {
        if self.is_prestressed() {
            for case in self.flow_alone().into_iter().chain([self.solids_alone()]) {
                case.space_in::<D>().map_err(about)?;
            }
        }
        Ok(())
    }

    /// Whether the case begins with another state than rest, where u is 0.
    pub(super) fn starts_undeformed(&self) -> bool {
        match &self.initial {
            None | Some(Initial::Fields { displacement: None, .. }) => true,
            // A displacement that is given is compared with `initial.displacement`.
            Some(Initial::Fields { .. } | Initial::From(_)) => false,
            Some(Initial::Static) => self.is_prestressed(),
        }
    }
}

/// The stationary solution, once more from itself, so that less of the tolerance is left; and the parts of the load.
fn settled<const D: usize>(stepper: &mut Stepper<D>) -> Result<(State, usize), Error> {
    let failed = |failure: StepFailure| match &failure.reason {
        NewtonError::Linear(error) if failure.is_too_large() => Error::Solver(error.clone()),
        _ => Error::Breakdown(failure),
    };
    let parts = stepper.stationary().map_err(failed)?.parts;
    let first = stepper.new.clone();
    let second = stepper.stationary().is_ok_and(|report| report.parts == 1);
    Ok((if second { stepper.new.clone() } else { first }, parts))
}

fn about(error: Error) -> Error {
    match error {
        Error::Case(CaseErrors(mut all)) => {
            all.iter_mut().for_each(|e| e.message = format!("for solid.prestress = true: {}", e.message));
            Error::Case(CaseErrors(all))
        }
        other => other,
    }
}

/// The cells of one body in the whole space, in the order that they have in the space of the body alone.
struct Shared<'a, const D: usize> {
    whole: &'a FsiSpace<D>,
    part: &'a FsiSpace<D>,
    cells: Vec<usize>,
}

impl<'a, const D: usize> Shared<'a, D> {
    fn new(whole: &'a FsiSpace<D>, part: &'a FsiSpace<D>, body: Region) -> Shared<'a, D> {
        let cells: Vec<usize> = (0..whole.mesh.n_cells()).filter(|&c| whole.regions[c] == body).collect();
        assert_eq!(cells.len(), part.mesh.n_cells(), "restricting a mesh keeps its cells");
        Shared { whole, part, cells }
    }

    /// Call `visit` with the places of a node in both.
    fn nodes(&self, mut visit: impl FnMut(usize, usize)) {
        for (part, &whole) in self.cells.iter().enumerate() {
            for (&a, &b) in self.part.nodes.cell(part).iter().zip(self.whole.nodes.cell(whole)) {
                visit(a as usize, b as usize);
            }
        }
    }

    /// Values at the nodes of the part to the whole.
    fn copy(&self, part: &[f64], whole: &mut [f64]) {
        self.nodes(|a, b| whole[D * b..D * (b + 1)].copy_from_slice(&part[D * a..D * (a + 1)]));
    }

    /// Values at the nodes of the whole to the part.
    fn copy_back(&self, whole: &[f64], part: &mut [f64]) {
        self.nodes(|a, b| part[D * a..D * (a + 1)].copy_from_slice(&whole[D * b..D * (b + 1)]));
    }

    fn copy_pressure(&self, part: &[f64], whole: &mut [f64]) {
        for (n, &cell) in self.cells.iter().enumerate() {
            for (&a, &b) in self.part.pressure.cell(n).iter().zip(self.whole.pressure.cell(cell)) {
                whole[b as usize] = part[a as usize];
            }
        }
    }
}
