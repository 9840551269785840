//! Steps from one state, again and again.

use super::{median, quantile};
use crate::algebra::Spent;
use crate::error::Error;
use crate::nonlinear::{self, Counters};
use crate::simulation::{Memory, Simulation};
use crate::time::Linearization;
use serde::Serialize;
use std::time::Instant;

/// Seconds of whole steps.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// A tenth is faster.
    pub fast: f64,
    /// A tenth is slower.
    pub slow: f64,
}

/// Where the time of a step goes \[s\]: medians over repetitions of the mean over steps.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
pub struct Parts {
    /// The whole step.
    pub wall: f64,
    /// Residuals and matrices.
    pub assembly: f64,
    /// Factorisations.
    pub factorization: f64,
    /// Corrections: elimination, substitution, extension, secants.
    pub solve: f64,
    /// Functionals, and whatever is in none of the others.
    pub functionals: f64,
}

impl Parts {
    const FIELDS: usize = 5;

    fn from_array([wall, assembly, factorization, solve, functionals]: [f64; Parts::FIELDS]) -> Parts {
        Parts { wall, assembly, factorization, solve, functionals }
    }

    fn to_array(self) -> [f64; Parts::FIELDS] {
        [self.wall, self.assembly, self.factorization, self.solve, self.functionals]
    }

    /// Names and values, in the order of the fields.
    pub fn named(self) -> [(&'static str, f64); Parts::FIELDS] {
        let names = ["wall", "assembly", "factorization", "solve", "functionals"];
        std::array::from_fn(|i| (names[i], self.to_array()[i]))
    }
}

/// What steps cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Steps {
    /// Steps of a repetition.
    pub steps: usize,
    /// Repetitions.
    pub repeat: usize,
    /// Number of steps before the first.
    pub after: u64,
    /// Time at the start \[s\].
    pub from: f64,
    /// Time at the end \[s\].
    pub to: f64,
    /// Seconds per step, over all steps of all repetitions.
    pub seconds: Spread,
    /// Seconds per step by phase.
    pub phases: Parts,
    /// The same divided by the number of unknowns.
    pub per_unknown: Parts,
    /// Newton iterations per step.
    pub newton_steps: f64,
    /// Jacobians per step.
    pub jacobians: f64,
    /// Factorisations per step.
    pub factorizations: f64,
    /// Residuals per step to which factors were applied.
    pub linear_iterations: f64,
    /// Parts of the cycles of multigrid in a step, first of the flow, then of the extension.
    pub cycles: Vec<CyclePart>,
}

/// A part of the cycles in a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CyclePart {
    /// What it does.
    pub part: &'static str,
    /// Mean seconds of a step.
    pub seconds: f64,
    /// Bytes per second that it reads, about.
    pub rate: f64,
}

/// Where every repetition starts.
pub struct Start {
    memory: Memory,
    linearization: Linearization,
}

impl Start {
    /// The present state of `simulation`.
    pub fn of<const D: usize>(simulation: &Simulation<D>) -> Start {
        let mut memory = simulation.save();
        (memory.stepper.newton, memory.stepper.detour) = (nonlinear::Memory::default(), 0);
        Start { memory, linearization: simulation.stepper.linear.active }
    }

    /// Take `simulation` back; what Newton's method has learnt since is forgotten.
    ///
    /// # Errors
    /// As [`Simulation::restore`].
    pub fn restore<const D: usize>(&self, simulation: &mut Simulation<D>) -> Result<(), Error> {
        simulation.history.clear();
        let newton = simulation.case.build_newton(&simulation.stepper.assembler);
        simulation.stepper.newton = newton;
        (simulation.stepper.linear.active, simulation.stepper.linear.detour) = (self.linearization, 0);
        simulation.restore(self.memory.clone())
    }

    /// Length of the next step \[s\]; 0 if stationary.
    pub(super) fn step_length<const D: usize>(&self, simulation: &Simulation<D>) -> f64 {
        simulation
            .case
            .time
            .as_ref()
            .map_or(0.0, |time| time.step.eval(&[0.0; 3], self.memory.stepper.clock.time))
    }
}

/// Do `steps` steps from `start` `repeat` times.
pub(super) fn measure<const D: usize>(
    simulation: &mut Simulation<D>,
    start: &Start,
    steps: usize,
    repeat: usize,
) -> Result<Steps, Error> {
    // What is made when first needed is made before the clock starts.
    start.restore(simulation)?;
    simulation.step()?;
    let before = simulation.stepper.linear.spent();
    let (mut walls, mut means) = (Vec::with_capacity(steps * repeat), vec![]);
    let mut all = Counters::default();
    for _ in 0..repeat {
        start.restore(simulation)?;
        let done = walls.len();
        for _ in 0..steps {
            let begun = Instant::now();
            simulation.step()?;
            walls.push(begun.elapsed().as_secs_f64());
        }
        let newton = &simulation.stepper.newton;
        all.newton_steps += newton.counters.newton_steps;
        all.jacobians += newton.counters.jacobians;
        all.factorizations += newton.counters.factorizations;
        all.linear_iterations += newton.counters.linear_iterations;
        let wall: f64 = walls[done..].iter().sum();
        let s = newton.seconds;
        let rest = wall - s.assembly - s.factorization - s.solve;
        means.push([wall, s.assembly, s.factorization, s.solve, rest].map(|x| x / steps as f64));
    }
    let phases = Parts::from_array(std::array::from_fn(|i| {
        median(&means.iter().map(|mean| mean[i]).collect::<Vec<_>>())
    }));
    let cycles = cycles(&before, &simulation.stepper.linear.spent(), (steps * repeat) as f64);
    let n = simulation.unknowns().total as f64;
    let per_step = |count: usize| count as f64 / (steps * repeat) as f64;
    Ok(Steps {
        steps,
        repeat,
        after: start.memory.steps,
        from: start.memory.stepper.clock.time,
        to: simulation.stepper.time,
        seconds: Spread { median: median(&walls), fast: quantile(&walls, 0.1), slow: quantile(&walls, 0.9) },
        phases,
        per_unknown: Parts::from_array(phases.to_array().map(|x| x / n)),
        newton_steps: per_step(all.newton_steps),
        jacobians: per_step(all.jacobians),
        factorizations: per_step(all.factorizations),
        linear_iterations: per_step(all.linear_iterations),
        cycles,
    })
}

/// Parts of the cycles of `steps` steps.
fn cycles(before: &[Spent], after: &[Spent], steps: f64) -> Vec<CyclePart> {
    let part = |(before, after): (&Spent, &Spent)| {
        let seconds = after.seconds - before.seconds;
        let rate = if seconds > 0.0 { (after.bytes - before.bytes) / seconds } else { 0.0 };
        CyclePart { part: after.part, seconds: seconds / steps, rate }
    };
    before.iter().zip(after).map(part).collect()
}
