//! The solution at one time, and all that carries it on: steps in `retry.rs` and `single_step.rs`, stationary
//! solutions in `stationary.rs`, what a checkpoint keeps in `memory.rs`.

use super::cause::{DataFault, DataKind};
use super::kept::{Before, JacobianPoint, Parts};
use super::report::Attempt;
use super::schedule::decimal;
use super::scheme::{Damping, DomainMotion, Formula, Origin, Scheme};
use super::stages::Stages;
use crate::linear::{Linear, Scales};
use crate::nonlinear::Newton;
use crate::physics::StepRule;
use crate::space::{Region, State};
use crate::system::{Assembler, DataTime, End, NotFinite, Operator};
use crate::tangent::Tangent;
use std::cell::Cell;

/// Body force per mass as a function of position and time \[m/s²\].
pub type Force<const D: usize> = Box<dyn Fn(&[f64; D], f64) -> [f64; D] + Send + Sync>;

/// The body force of one material.
pub struct MaterialForce<const D: usize> {
    /// The kind of its body.
    pub body: Region,
    /// Its number, see [`crate::space::FsiSpace::material`].
    pub material: u16,
    /// The force per mass \[m/s²\].
    pub force: Force<D>,
}

/// A right-hand side `[v, u, p]` added to the residual: called with (t⁻, t, θ).
pub type Source = Box<dyn FnMut(f64, f64, f64, &mut [f64]) + Send>;

/// What a stepper needs besides assembly and Newton.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StepperSettings {
    /// Time scheme.
    pub scheme: Scheme,
    /// Where the factors of ∂_t are taken.
    pub domain_motion: DomainMotion,
    /// How derivatives are computed.
    pub tangent: Tangent,
    /// Start from the linear extrapolation of the last two solutions, Remark 5.1.
    pub extrapolate: bool,
    /// How often a failed step is halved.
    pub max_halvings: u32,
    /// Units of the residuals.
    pub scales: Scales,
}

impl StepperSettings {
    /// The rule of the scheme that has this 1/k and θ.
    pub fn rule_of(&self, per_k: f64, theta: f64) -> StepRule {
        let rule = StepRule { per_k, theta, ..self.scheme.rule(1.0) };
        self.domain_motion.apply(rule)
    }
}

/// The solution at one time and what is needed to carry it on.
pub struct Stepper<const D: usize> {
    /// Assembly.
    pub assembler: Assembler<D>,
    /// Nonlinear solver.
    pub newton: Newton,
    /// Matrices and their factors.
    pub linear: Linear<D>,
    /// Settings.
    pub settings: StepperSettings,
    /// Time of `new` \[s\].
    pub time: f64,
    /// The last solution.
    pub new: State,
    /// The solution before.
    pub old: State,
    /// The solution before that, for extrapolation and BDF2.
    pub(super) older: State,
    /// What BDF2 and the stages of Runge-Kutta methods take the difference from.
    pub(super) base: State,
    /// Length of the last step, or of its last part \[s\]; 0 where there was none.
    pub(super) last_step: f64,
    /// What the last step, or its last part, was made of.
    pub(super) last: Formula,
    /// First time \[s\].
    pub(super) start: f64,
    pub(super) damping: Damping,
    /// The parts of the last step of fractional-step θ.
    pub(super) parts: Option<Parts>,
    /// The stages of the last step of a Runge-Kutta method.
    pub(super) stages: Option<Stages>,
    pub(super) explicit: Vec<f64>,
    /// What the criterion of the last stationary solution referred to.
    pub(super) reference: f64,
    /// Whether stationary solutions take the whole Jacobian where the condensed one is asked for: u does not follow from v
    /// at rest, or the condensed system has failed.
    pub(super) whole_at_rest: bool,
    /// Where the kept Jacobian was taken.
    pub(super) point: Option<JacobianPoint>,
    pub(super) before: Before,
    pub(super) forces: Vec<MaterialForce<D>>,
    /// Data set last that are not finite.
    pub(super) fault: Option<DataFault>,
    /// Iterations of the present step that failed.
    pub(super) attempts: Vec<Attempt>,
    /// Manufactured right-hand side.
    pub source: Option<Source>,
}

impl<const D: usize> Stepper<D> {
    /// Start from `initial` at `time` under `forces`.
    pub fn new(
        assembler: Assembler<D>,
        newton: Newton,
        linear: Linear<D>,
        settings: StepperSettings,
        time: f64,
        initial: State,
        forces: Vec<MaterialForce<D>>,
    ) -> Stepper<D> {
        let n = assembler.n_unknowns();
        let has_base = settings.scheme == Scheme::Bdf2 || settings.scheme.tableau().is_some();
        let mut stepper = Stepper {
            assembler,
            newton,
            linear,
            settings,
            time,
            new: initial.clone(),
            old: initial.clone(),
            older: initial.clone(),
            base: if has_base { initial } else { State::default() },
            last_step: 0.0,
            last: Formula { rule: StepRule::STATIONARY, origin: Origin::Old },
            start: time,
            damping: Damping::default(),
            parts: None,
            stages: None,
            reference: 0.0,
            whole_at_rest: false,
            point: None,
            before: Before::default(),
            explicit: vec![0.0; n],
            forces,
            fault: None,
            attempts: vec![],
            source: None,
        };
        stepper.set_forces(End::New, time, 1.0);
        stepper.set_forces(End::Old, time, 1.0);
        stepper
    }

    /// Add a term to the equations, before the first step.
    pub(crate) fn add_term(&mut self, term: Box<dyn Operator<D>>) {
        self.assembler.add(term);
        let like = self.assembler.zero();
        for state in [&mut self.new, &mut self.old, &mut self.older, &mut self.base] {
            state.s.clone_from(&like.s);
        }
        self.explicit.resize(self.assembler.n_unknowns(), 0.0);
        self.newton.resize(self.assembler.n_unknowns());
        self.set_forces(End::New, self.time, 1.0);
        self.set_forces(End::Old, self.time, 1.0);
    }

    /// Set the body forces of `end` to those at `t` \[s\], times `load`, and note where they are not finite.
    pub(super) fn set_forces(&mut self, end: End, t: f64, load: f64) {
        if let Err(NotFinite { boundary, at, value }) =
            self.assembler.set_data(&DataTime { end, time: t, load })
        {
            let kind = DataKind::Condition { boundary };
            self.fault = Some(DataFault { kind, at: at.to_vec(), time: t, value: value.to_vec() });
        }
        for MaterialForce { body, material, force } in &self.forces {
            let wrong = Cell::new(None);
            let at = |x: &[f64; D]| {
                let f = force(x, t);
                if !f.iter().all(|f| f.is_finite()) {
                    wrong.set(wrong.get().or(Some((*x, f))));
                }
                f.map(|f| f * load)
            };
            self.assembler.set_force_of((*body, *material), end, Some(&at));
            if let Some((x, f)) = wrong.get() {
                let kind = DataKind::Force { body: *body, material: *material };
                self.fault = Some(DataFault { kind, at: x.to_vec(), time: t, value: f.to_vec() });
            }
        }
    }

    /// Data set last that are not finite, on one of the processes that share the space.
    pub(super) fn fault_of_all(&mut self) -> Option<DataFault> {
        let fault = self.fault.take();
        let elsewhere =
            || DataFault { kind: DataKind::Elsewhere, at: vec![], time: self.time, value: vec![] };
        self.assembler.space.any(fault.is_some()).then(|| fault.unwrap_or_else(elsewhere))
    }

    /// Set the boundary data of `t` \[s\], times `load`, in the new solution, and note where they are not finite.
    pub(super) fn apply_boundary(&mut self, t: f64, load: f64) {
        let State { v, u, .. } = &mut self.new;
        self.assembler.constraints.load = load;
        let Assembler { constraints, space, .. } = &self.assembler;
        constraints.apply(space, t, v, u);
        let given =
            v.chunks_exact(D).zip(&constraints.v).enumerate().filter(|(_, (_, given))| given.contains(&true));
        let wrong = |(_, (v, _)): &(usize, (&[f64], _))| !v.iter().all(|v| v.is_finite());
        if let Some((node, (value, _))) = given.into_iter().find(wrong) {
            let kind = DataKind::Velocity { node: node as u32 };
            let at = space.nodes.points[node].to_vec();
            self.fault = Some(DataFault { kind, at, time: t, value: value.to_vec() });
        }
    }

    /// The last step, or its last part: its rule, the solutions that it relates, and the assembly to evaluate
    /// it with.
    pub fn last_step(&mut self) -> (StepRule, &State, &State, &mut Assembler<D>) {
        let old = if self.last.origin == Origin::Old { &self.old } else { &self.base };
        (self.last.rule, &self.new, old, &mut self.assembler)
    }

    /// Time to which pressure and forces of the last step belong: t⁻ + θ k, for fractional-step θ the middle.
    pub fn force_time(&self) -> f64 {
        match &self.parts {
            Some(parts) => decimal(self.time, -0.5 * parts.length),
            None => decimal(self.time, (self.last.rule.theta - 1.0) * self.last_step),
        }
    }

    /// Whether the last step was one of the damping steps of Rannacher's scheme.
    pub(super) fn was_damped(&self) -> bool {
        matches!(self.settings.scheme, Scheme::Rannacher { .. }) && self.last.rule.theta == 1.0
    }
}
