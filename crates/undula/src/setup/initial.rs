//! What a case in time begins with: fields, or the stationary solution for the loads of the start.

use super::data::{STARTS, values};
use super::dimension::Dimension;
use crate::case::error::{CaseError, CaseErrors};
use crate::case::{Case, Condition, Initial};
use crate::error::Error;
use crate::linear::Closed;
use crate::math::{rounded, shortest};
use crate::nonlinear::NewtonError;
use crate::space::{Constraints, FsiSpace, PsiOwner, State, enclosed};
use crate::system::{Assembler, Dim};
use crate::time::{Scheme, Stepper};
use std::sync::Arc;

/// Part of the first step in which nothing moves.
const SHORT: f64 = 1e-6;

#[doc(hidden)]
impl Case {
    /// The stationary case with the loads of the start.
    pub(crate) fn at_start(&self) -> Case {
        let mut case = self.clone();
        case.at_time = self.time.as_ref().map_or(self.at_time, |time| time.start);
        (case.time, case.initial) = (None, None);
        // What a step takes from its beginning is at rest that of the solution itself.
        case.motion.lagged = false;
        // A circuit whose pressure is given is a resistance.
        for condition in case.boundary.values_mut() {
            if let Condition::Windkessel { proximal, initial, .. } = condition
                && initial.constant_value() != Some(0.0)
            {
                let (resistance, pressure) = (proximal.clone(), initial.clone());
                *condition = Condition::Resistance { resistance, pressure };
            }
        }
        case
    }

    /// Whether the case begins with its stationary solution.
    pub(crate) fn starts_static(&self) -> bool {
        self.initial == Some(Initial::Static)
    }

    /// The mistakes of initial fields that are not finite, or that boundaries do not let be.
    pub(super) fn check_fields<const D: usize>(&self, space: &FsiSpace<D>) -> Vec<CaseError> {
        let (Some(initial), Some(time)) = (&self.initial, &self.time) else { return vec![] };
        let mut errors = vec![];
        for (key, data) in initial.fields() {
            let wrong = |x: &&[f64; D]| values(data, x, time.start).iter().any(|value| !value.is_finite());
            let places = space.places();
            let at = places.points[..places.n_lagrange].iter().find(wrong);
            errors.extend(at.map(|at| {
                let message =
                    format!("expected finite values; they are {}", shown(&values(data, at, time.start), at));
                self.mistake(key, message)
            }));
            if errors.is_empty() && key == "initial.displacement" {
                errors.extend(self.held_elsewhere(space, time.start));
            }
        }
        errors
    }

    fn mistake(&self, key: &str, message: String) -> CaseError {
        CaseError { place: self.place_of(key), key: key.into(), value: None, message }
    }

    /// The mistake that boundaries hold nodes of the solid, or walls that move, elsewhere than the initial displacement.
    fn held_elsewhere<const D: usize>(&self, space: &FsiSpace<D>, t: f64) -> Option<CaseError> {
        let key = "initial.displacement";
        let constraints = Constraints::new(space, &self.conditions(&space.mesh));
        let mut state = self.given_fields(space, &constraints, t);
        if state.u.is_empty() {
            let message = "there is no solid and no boundary that moves; remove it";
            return Some(self.mistake(key, message.into()));
        }
        let given = state.u.clone();
        constraints.apply(space, t, &mut state.v, &mut state.u);
        let extent = space
            .mesh
            .nodes
            .iter()
            .flatten()
            .fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(*x), high.max(*x)]);
        let tolerance = STARTS * (extent[1] - extent[0]);
        let differs =
            |node: &usize| (0..D).any(|i| (given[D * node + i] - state.u[D * node + i]).abs() > tolerance);
        let node = (0..space.nodes.n_lagrange).find(differs)?;
        let at = &space.nodes.points[node];
        let holds = |(name, condition): &(&String, &Condition)| {
            condition.is_given() && space.boundary_nodes(name).contains(&(node as u32))
        };
        let name = self.boundary.iter().find(holds).map_or("its boundary", |(name, _)| name.as_str());
        let message = format!(
            "it is {}, where `{name}` gives {} m: expected the displacement that the boundary has at the start t = {} s",
            shown(&given[D * node..D * (node + 1)], at),
            vector(&state.u[D * node..D * (node + 1)]),
            shortest(t)
        );
        Some(self.mistake(key, message))
    }

    /// The initial fields at the nodes: v everywhere, u in the solid and on boundaries whose displacement is given.
    fn given_fields<const D: usize>(
        &self,
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        t: f64,
    ) -> State {
        let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
        let mut moves: Vec<bool> = space.owner.iter().map(|owner| *owner == PsiOwner::Relation).collect();
        constraints.motion.iter().for_each(|(node, _)| moves[*node as usize] = true);
        for (key, data) in self.initial.iter().flat_map(Initial::fields) {
            for (node, x) in space.nodes.points[..space.nodes.n_lagrange].iter().enumerate() {
                let place = D * node..D * (node + 1);
                let value = || values(data, x, t);
                if key == "initial.velocity" {
                    state.v[place].copy_from_slice(&value());
                } else if moves[node] && !state.u.is_empty() {
                    state.u[place].copy_from_slice(&value());
                }
            }
        }
        state
    }

    /// The state of the initial fields: u extended into the fluid, v there made discretely free of divergence, both with
    /// the boundary values of the start, and p as [`Case::start_pressure`] finds it; else it is 0, and a note says so.
    ///
    /// # Errors
    /// [`Error::Case`] if a closed part of the fluid would change its volume or a cell is folded, [`Error::Solver`].
    pub(crate) fn initial_fields<const D: usize>(
        &self,
        space: &Arc<FsiSpace<D>>,
        threads: usize,
    ) -> Result<(State, Option<String>), Error>
    where
        Dim<D>: Dimension<D>,
    {
        let mut stepper = self.stepper_on(space.clone(), threads)?;
        let Stepper { assembler, linear, time, .. } = &mut stepper;
        let time = *time;
        let mut state = self.given_fields(space, &assembler.constraints, time);
        state.s = assembler.zero().s;
        assembler.constraints.apply(space, time, &mut state.v, &mut state.u);
        if space.deforms {
            linear.extend(assembler, &mut state)?;
            let min_j = assembler.nodal_min_j(&state);
            if min_j.is_nan() || min_j <= 0.0 {
                let message =
                    format!("cells fold: the smallest J is {min_j:.3}; expected a smaller displacement");
                return Err(self.refuse("initial.displacement", message));
            }
        }
        if !self.fluids.is_empty() {
            let parts = enclosed(space, &self.conditions(&space.mesh));
            let with_solid = parts.iter().filter(|part| part.touches_solid);
            let closed = with_solid.map(|part| Closed {
                pressure: part.pressure(space),
                through: part.flux(&state.v, |_| [true; D]).1,
            });
            let closed: Vec<Closed> = closed.collect();
            let k = self.time.as_ref().map_or(1.0, |t| t.step.eval(&[0.0; 3], time));
            if !linear.project(assembler, k, &closed, &mut state)? {
                let message = "the velocity of the solid changes the volume of a fluid that is closed in on all sides; \
                               expected one that keeps it";
                return Err(self.refuse("initial.velocity", message.into()));
            }
        }
        let note = self.start_pressure(&mut stepper, &mut state).err();
        Ok((state, note))
    }

    /// Sets p, and scalar unknowns without a rate, to what belongs to v and u of `state` at the start:
    ///
    /// (ρ J a, φ) + A(v, u)(φ) − (p J F⁻ᵀ, ∇φ) = (f, φ), where a keeps the divergence and the given velocities.
    ///
    /// They are those of a step of the backward Euler scheme in which nothing moves: of 1e-6 of the first step, so that
    /// the error is as small; of the whole one with stabilisation, whose parameters depend on it.
    ///
    /// # Errors
    /// What should be known if there is no such step; `state` is then as before.
    fn start_pressure<const D: usize>(
        &self,
        stepper: &mut Stepper<D>,
        state: &mut State,
    ) -> Result<(), String> {
        let Some(time) = self.time.as_ref().filter(|_| !state.p.is_empty()) else { return Ok(()) };
        let k = time.step.eval(&[0.0; 3], time.start);
        let short = if self.stabilization.acts() { k } else { SHORT * k };
        stepper.settings.scheme = Scheme::BackwardEuler;
        stepper.settings.max_halvings = 0;
        (stepper.new, stepper.old) = (state.clone(), state.clone());
        if stepper.step_to(short, time.start + short).is_err() {
            return Err("initial: no pressure was found that belongs to the start; it is 0 there".into());
        }
        state.p.clone_from(&stepper.new.p);
        for (n, _) in
            stepper.assembler.algebraic_scalars().iter().enumerate().filter(|(_, no_rate)| **no_rate)
        {
            state.s[n] = stepper.new.s[n];
        }
        Ok(())
    }

    /// The stationary solution for the loads of the start, with the parts of the load that it took.
    ///
    /// # Errors
    /// [`Error::Breakdown`] if there is none, [`Error::Case`] if the stationary case is not well posed.
    pub(crate) fn initial_equilibrium<const D: usize>(&self, threads: usize) -> Result<(State, usize), Error>
    where
        Dim<D>: Dimension<D>,
    {
        let mut stepper = self.at_start().build_with_notes::<D>(threads, None)?.0;
        let report = stepper.stationary().map_err(|failure| match &failure.reason {
            NewtonError::Linear(error) if failure.is_too_large() => Error::Solver(error.clone()),
            _ => Error::Breakdown(failure),
        })?;
        let first = stepper.new.clone();
        // What the tolerance has left would set the run in motion.
        let second = stepper.stationary().is_ok_and(|report| report.parts == 1);
        Ok((if second { stepper.new } else { first }, report.parts))
    }

    /// What a stationary start asks for besides.
    ///
    /// # Errors
    /// As [`Case::build_space`] of the stationary case.
    pub(super) fn check_equilibrium<const D: usize>(&self) -> Result<(), Error>
    where
        Dim<D>: Dimension<D>,
    {
        self.check_prestress::<D>()?;
        if !self.starts_static() {
            return Ok(());
        }
        self.at_start().space_in::<D>().map(|_| ()).map_err(|error| match error {
            Error::Case(CaseErrors(mut all)) => {
                let about =
                    |e: &mut CaseError| e.message = format!("for initial.static = true: {}", e.message);
                all.iter_mut().for_each(about);
                Error::Case(CaseErrors(all))
            }
            other => other,
        })
    }
}

/// The scalar unknowns of a case at its start from those of [`Case::at_start`], which has none for circuits whose pressure is
/// given.
pub(crate) fn scalars<const D: usize>(assembler: &Assembler<D>, found: &[f64]) -> Vec<f64> {
    let (mut all, mut found) = (assembler.zero().s, found.iter());
    for (value, no_rate) in all.iter_mut().zip(assembler.algebraic_scalars()) {
        if no_rate || *value == 0.0 {
            *value = found.next().copied().unwrap_or(0.0);
        }
    }
    all
}

fn vector(value: &[f64]) -> String {
    let value: Vec<String> = value.iter().map(|&x| shortest(rounded(x, x, 4))).collect();
    format!("({})", value.join(", "))
}

fn shown<const D: usize>(value: &[f64], at: &[f64; D]) -> String {
    format!("{} at {}", vector(value), vector(at))
}
