//! The state of a run in a checkpoint, and back.

use super::identity::identity;
use crate::error::Error;
use crate::functional::balance::Largest;
use crate::nonlinear::{Age, Counters, Seconds};
use crate::output::{Array, Checkpoint, RunDirectory};
use crate::simulation::Simulation;
use crate::space::State;
use crate::time::adaptive::Memory;
use crate::time::{Clock, Damping, JacobianPoint};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What a checkpoint says besides its arrays.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Metadata {
    pub(super) step: u64,
    pub(super) clock: [f64; 2],
    /// Intervals begun and damping steps to come in Rannacher's scheme.
    #[serde(default)]
    damping: (u64, u32),
    /// 1/k, θ and time of the kept Jacobian.
    jacobian: Option<[f64; 3]>,
    /// Its age.
    #[serde(default)]
    age: [u32; 3],
    /// Bits of what Newton's method has learnt about kept Jacobians; 0: nothing.
    #[serde(default)]
    worsening: u32,
    /// Steps to go with the whole Jacobian.
    #[serde(default)]
    detour: u32,
    /// Next step, largest v and u, rejected steps and times of the past of step-size control.
    #[serde(default)]
    adaptive: Option<(f64, [f64; 2], u64, Vec<f64>)>,
    /// Largest flows so far, see [`crate::functional::balance`].
    #[serde(default)]
    balance: Option<Largest>,
    counters: [u64; 3],
    #[serde(default)]
    linear_iterations: u64,
    pub(super) seconds: [f64; 4],
    pub(super) wall_seconds: f64,
    pub(super) case: String,
    /// Number for the content of its mesh file.
    #[serde(default)]
    pub(super) mesh: Option<String>,
    /// The row of the step in `history.csv`.
    #[serde(default)]
    pub(super) row: Option<String>,
    /// The end \[s\] that a step was shortened for: a run to a later one does not pass here.
    #[serde(default)]
    pub(super) cut: Option<f64>,
}

/// What a checkpoint has from the run, not from its simulation.
pub(super) struct OfRun<'a> {
    pub(super) output_seconds: f64,
    pub(super) wall_seconds: f64,
    pub(super) mesh: &'a Option<String>,
    pub(super) row: Option<String>,
    pub(super) cut: Option<f64>,
}

/// A checkpoint of `simulation` as it is.
pub(super) fn of(simulation: &Simulation, run: &OfRun<'_>) -> Result<Checkpoint, Error> {
    let stepper = &simulation.stepper;
    let (clock, point) = (stepper.clock(), stepper.jacobian_point());
    let (counters, seconds) = (stepper.newton.counters, stepper.newton.seconds);
    let metadata = Metadata {
        step: simulation.steps,
        clock: [clock.time, clock.last_step],
        damping: (clock.damping.interval, clock.damping.left),
        jacobian: point.map(|p| [p.rule.per_k, p.rule.theta, p.time]),
        age: point.map_or([0; 3], |p| [p.age.solves, p.age.iterations, p.age.last]),
        worsening: stepper.newton.worsening.to_bits(),
        detour: stepper.linear.detour,
        adaptive: simulation.adaptive.as_ref().map(|a| {
            let memory = &a.memory;
            let times = memory.past.iter().map(|(t, _)| *t).collect();
            (memory.next, memory.scales, memory.rejected, times)
        }),
        balance: simulation.balance.as_ref().map(|b| b.largest),
        counters: [counters.newton_steps, counters.jacobians, counters.factorizations].map(|n| n as u64),
        linear_iterations: counters.linear_iterations as u64,
        seconds: [seconds.assembly, seconds.factorization, seconds.solve, run.output_seconds],
        wall_seconds: run.wall_seconds,
        case: identity(&simulation.case),
        mesh: run.mesh.clone(),
        row: run.row.clone(),
        cut: run.cut,
    };
    let text = serde_json::to_string(&metadata).map_err(|e| Error::Resume(e.to_string()))?;
    let mut checkpoint = Checkpoint { metadata: text, ..Checkpoint::default() };
    let mut states = vec![("new", &stepper.new), ("old", &stepper.old)];
    if let Some(point) = point {
        states.extend([("jacobian_new", &point.new), ("jacobian_old", &point.old)]);
    }
    for (name, state) in states {
        for (field, values) in [("v", &state.v), ("u", &state.u), ("p", &state.p)] {
            checkpoint.arrays.insert(format!("{name}_{field}"), Array::F64(values.clone()));
        }
    }
    for (n, (_, fields)) in simulation.adaptive.iter().flat_map(|a| &a.memory.past).enumerate() {
        for (name, values) in ["v", "u"].into_iter().zip(fields) {
            checkpoint.arrays.insert(format!("past{n}_{name}"), Array::F64(values.clone()));
        }
    }
    Ok(checkpoint)
}

/// Take `simulation` to the newest checkpoint of the run in `directory`; its case may differ from that of the
/// run in all but its unknowns. Returns why newer ones were passed over.
///
/// # Errors
/// If there is no run or no checkpoint, or if it has other unknowns.
pub fn restore_latest(
    simulation: &mut Simulation,
    directory: impl AsRef<Path>,
) -> Result<Vec<String>, Error> {
    let directory = RunDirectory::open(directory).map_err(Error::Directory)?;
    let (found, notes) = newest(&directory, "expected a run that has written one", |_| Ok(()))?;
    restore(simulation, &found.checkpoint, &found.metadata)?;
    Ok(notes)
}

/// A checkpoint that was read.
pub(super) struct Found {
    pub(super) checkpoint: Checkpoint,
    pub(super) metadata: Metadata,
}

/// Why a checkpoint is not the one to go on from.
pub(super) enum Unfit {
    /// It is no good; the sentence says why.
    Unsound(String),
    /// It can be taken where there is no other; the sentence says what to expect then.
    SecondChoice(String),
    /// None of the run is.
    Refused(Error),
}

/// The newest sound checkpoint of a run that `fits`, and why newer ones were passed over; `advice` is for where there is none.
pub(super) fn newest(
    directory: &RunDirectory,
    advice: &str,
    mut fits: impl FnMut(&Metadata) -> Result<(), Unfit>,
) -> Result<(Found, Vec<String>), Error> {
    let (mut notes, mut second) = (vec![], None);
    for (_, path) in Checkpoint::list(directory.checkpoints())?.into_iter().rev() {
        let found = match load(&path) {
            Ok(found) => found,
            Err(message) => {
                notes.push(message);
                continue;
            }
        };
        match fits(&found.metadata) {
            Ok(()) => return Ok((found, passed_over(notes))),
            Err(Unfit::Refused(error)) => return Err(error),
            Err(Unfit::Unsound(message)) => notes.push(message),
            Err(Unfit::SecondChoice(message)) => {
                second.get_or_insert((found, message));
            }
        }
    }
    if let Some((found, message)) = second {
        return Ok((found, vec![message]));
    }
    let shown = directory.path().display();
    Err(Error::Resume(match notes.is_empty() {
        true => format!("{shown} holds none; {advice}"),
        false => format!("{shown} holds no sound one; {advice}: {}", notes.join("; ")),
    }))
}

fn passed_over(notes: Vec<String>) -> Vec<String> {
    notes.into_iter().map(|note| format!("{note}; an older checkpoint is taken")).collect()
}

fn load(path: &Path) -> Result<Found, String> {
    let checkpoint = Checkpoint::load(path).map_err(|e| e.to_string())?;
    let metadata = serde_json::from_str(&checkpoint.metadata)
        .map_err(|e| format!("{}: not a checkpoint of this program ({e})", path.display()))?;
    Ok(Found { checkpoint, metadata })
}

/// Take `simulation` to a checkpoint.
pub(super) fn restore(
    simulation: &mut Simulation,
    checkpoint: &Checkpoint,
    metadata: &Metadata,
) -> Result<(), Error> {
    let space = &simulation.stepper.assembler.space;
    let sizes = [("v", space.n_v()), ("u", space.n_u()), ("p", space.n_p())];
    let state = |name: &str| -> Result<State, Error> {
        let mut parts = vec![];
        for (field, n) in sizes {
            let key = format!("{name}_{field}");
            let array = checkpoint.f64s(&key).filter(|a| a.len() == n);
            parts.push(
                array.ok_or_else(|| Error::Resume(format!("array {key} should have {n} numbers")))?.to_vec(),
            );
        }
        let p = parts.pop().unwrap_or_default();
        let u = parts.pop().unwrap_or_default();
        Ok(State { v: parts.pop().unwrap_or_default(), u, p })
    };
    let (interval, left) = metadata.damping;
    let damping = Damping { interval, left };
    let clock = Clock { time: metadata.clock[0], last_step: metadata.clock[1], damping };
    let [solves, iterations, last] = metadata.age;
    let point = match metadata.jacobian {
        Some([per_k, theta, time]) => Some(JacobianPoint {
            rule: simulation.stepper.settings.rule_of(per_k, theta),
            time,
            new: state("jacobian_new")?,
            old: state("jacobian_old")?,
            age: Age { solves, iterations, last },
        }),
        None => None,
    };
    let (new, old) = (state("new")?, state("old")?);
    simulation.stepper.linear.set_detour(metadata.detour);
    let worsening = f32::from_bits(metadata.worsening);
    simulation.stepper.newton.worsening = if worsening.is_finite() { worsening.max(1.0) } else { 1.0 };
    let sizes = [new.v.len(), new.u.len()];
    simulation.restore(clock, new, old, point, metadata.step)?;
    if let (Some(adaptive), Some((next, scales, rejected, times))) =
        (&mut simulation.adaptive, &metadata.adaptive)
    {
        let mut past = vec![];
        for (n, t) in times.iter().enumerate() {
            let field = |name: &str, size: usize| {
                let key = format!("past{n}_{name}");
                let values = checkpoint.f64s(&key).filter(|a| a.len() == size);
                let values = values.map(|a| a.to_vec());
                values.ok_or_else(|| Error::Resume(format!("array {key} should have {size} numbers")))
            };
            past.push((*t, [field("v", sizes[0])?, field("u", sizes[1])?]));
        }
        adaptive.memory = Memory { next: *next, scales: *scales, rejected: *rejected, past };
    }
    if let (Some(balance), Some(largest)) = (&mut simulation.balance, metadata.balance) {
        balance.largest = largest;
    }
    let newton = &mut simulation.stepper.newton;
    let [newton_steps, jacobians, factorizations] = metadata.counters.map(|n| n as usize);
    let linear_iterations = metadata.linear_iterations as usize;
    newton.counters = Counters { newton_steps, jacobians, factorizations, linear_iterations };
    let [assembly, factorization, solve, _] = metadata.seconds;
    newton.seconds = Seconds { assembly, factorization, solve };
    Ok(())
}
