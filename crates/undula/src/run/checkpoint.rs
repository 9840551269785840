//! The state of a run in a checkpoint, and back.

use super::identity::identity;
use crate::error::Error;
use crate::functional::balance::Largest;
use crate::nonlinear::{self, Age, Counters, Seconds};
use crate::output::{Array, Checkpoint, RunDirectory};
use crate::simulation::{Memory, Simulation};
use crate::space::State;
use crate::time::{self, Clock, Damping, JacobianPoint, Stepper, adaptive};
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
    /// Of step-size control.
    #[serde(default)]
    adaptive: Option<OfAdaptive>,
    /// Largest flows so far, see [`crate::functional::balance`].
    #[serde(default)]
    balance: Option<Largest>,
    /// Times of the stages of a Runge-Kutta method.
    #[serde(default)]
    stages: Vec<f64>,
    counters: [u64; 3],
    #[serde(default)]
    linear_iterations: u64,
    #[serde(default)]
    fallbacks: u64,
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

/// Next step, largest v and u, rejected steps and times of the past of step-size control.
type OfAdaptive = (f64, [f64; 2], u64, Vec<f64>);

/// What a checkpoint has from the run, not from its simulation.
pub(super) struct OfRun<'a> {
    pub(super) output_seconds: f64,
    pub(super) wall_seconds: f64,
    pub(super) mesh: &'a Option<String>,
    pub(super) row: Option<String>,
    pub(super) cut: Option<f64>,
}

/// A checkpoint of `simulation` as it is, with its `memory`.
pub(super) fn of<const D: usize>(
    simulation: &Simulation<D>,
    memory: Memory,
    run: &OfRun<'_>,
) -> Result<Checkpoint, Error> {
    let Memory { steps, stepper, adaptive, balance, unloading } = memory;
    let time::Memory { clock, new, old, point, newton, detour, stages } = stepper;
    let nonlinear::Memory { worsening, counters, seconds } = newton;
    let metadata = Metadata {
        step: steps,
        clock: [clock.time, clock.last_step],
        damping: (clock.damping.interval, clock.damping.left),
        jacobian: point.as_ref().map(|p| [p.rule.per_k, p.rule.theta, p.time]),
        age: point.as_ref().map_or([0; 3], |p| [p.age.solves, p.age.iterations, p.age.last]),
        worsening: worsening.to_bits(),
        detour,
        adaptive: adaptive.as_ref().map(|adaptive::Memory { next, scales, rejected, past }| {
            (*next, *scales, *rejected, past.iter().map(|(t, _)| *t).collect())
        }),
        balance,
        stages: stages.iter().map(|(t, _)| *t).collect(),
        counters: [counters.newton_steps, counters.jacobians, counters.factorizations].map(|n| n as u64),
        linear_iterations: counters.linear_iterations as u64,
        fallbacks: counters.fallbacks as u64,
        seconds: [seconds.assembly, seconds.factorization, seconds.solve, run.output_seconds],
        wall_seconds: run.wall_seconds,
        case: identity(&simulation.case),
        mesh: run.mesh.clone(),
        row: run.row.clone(),
        cut: run.cut,
    };
    let text = serde_json::to_string(&metadata).map_err(|e| Error::Resume(e.to_string()))?;
    let mut checkpoint = Checkpoint { metadata: text, ..Checkpoint::default() };
    let mut put = |name: String, values| checkpoint.arrays.insert(name, Array::F64(values));
    let mut states = vec![("new".into(), new), ("old".into(), old)];
    if let Some(point) = point {
        states.extend([("jacobian_new".into(), point.new), ("jacobian_old".into(), point.old)]);
    }
    states.extend(stages.into_iter().enumerate().map(|(n, (_, stage))| (format!("stage{n}"), stage)));
    for (name, State { v, u, p, s }) in states {
        for (field, values) in [("v", v), ("u", u), ("p", p)] {
            put(format!("{name}_{field}"), values);
        }
        if !s.is_empty() {
            put(format!("{name}_s"), s);
        }
    }
    for (n, (_, [v, u])) in adaptive.into_iter().flat_map(|memory| memory.past).enumerate() {
        put(format!("past{n}_v"), v);
        put(format!("past{n}_u"), u);
    }
    if !unloading.is_empty() {
        put("unloading".into(), unloading);
    }
    Ok(checkpoint)
}

/// Take `simulation` to the newest checkpoint of the run in `directory`; its case may differ from that of the
/// run in all but its unknowns. Returns why newer ones were passed over.
///
/// # Errors
/// If there is no run or no checkpoint, or if it has other unknowns.
pub fn restore_latest<const D: usize>(
    simulation: &mut Simulation<D>,
    directory: impl AsRef<Path>,
) -> Result<Vec<String>, Error> {
    let directory = RunDirectory::open(directory).map_err(Error::Directory)?;
    let (found, notes) = newest(&directory, "expected a run that has written one", |_| Ok(()))?;
    restore(simulation, &found.checkpoint, &found.metadata)?;
    Ok(notes)
}

/// Set `simulation` to the checkpoint after so many steps of the run in `directory`.
pub(super) fn restore_step<const D: usize>(
    simulation: &mut Simulation<D>,
    directory: impl AsRef<Path>,
    step: u64,
) -> Result<(), Error> {
    let directory = RunDirectory::open(directory).map_err(Error::Directory)?;
    let (found, _) = newest(&directory, "expected that of the first process", |metadata| {
        let other = || Unfit::Unsound(format!("it is not that of step {step}"));
        if metadata.step == step { Ok(()) } else { Err(other()) }
    })?;
    restore(simulation, &found.checkpoint, &found.metadata)
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
pub(super) fn restore<const D: usize>(
    simulation: &mut Simulation<D>,
    checkpoint: &Checkpoint,
    metadata: &Metadata,
) -> Result<(), Error> {
    let memory = memory(simulation, checkpoint, metadata)?;
    simulation.restore(memory)
}

/// What a checkpoint says, for `simulation`.
fn memory<const D: usize>(
    simulation: &Simulation<D>,
    checkpoint: &Checkpoint,
    metadata: &Metadata,
) -> Result<Memory, Error> {
    let Stepper { assembler, settings, .. } = &simulation.stepper;
    let (space, s) = (&assembler.space, simulation.stepper.new.s.len());
    let [v, u, p] = space.n_all();
    let sizes = Sizes { v, u, p, s };
    let state = |name: &str| sizes.state(checkpoint, name).map(|state| space.part_of(state));
    let (interval, left) = metadata.damping;
    let [time, last_step] = metadata.clock;
    let [solves, iterations, last] = metadata.age;
    let point = match metadata.jacobian {
        Some([per_k, theta, time]) => Some(JacobianPoint {
            rule: settings.rule_of(per_k, theta),
            time,
            new: state("jacobian_new")?,
            old: state("jacobian_old")?,
            age: Age { solves, iterations, last },
        }),
        None => None,
    };
    let [newton_steps, jacobians, factorizations] = metadata.counters.map(|n| n as usize);
    let (linear_iterations, fallbacks) = (metadata.linear_iterations as usize, metadata.fallbacks as usize);
    let [assembly, factorization, solve, _] = metadata.seconds;
    let newton = nonlinear::Memory {
        worsening: f32::from_bits(metadata.worsening),
        counters: Counters { newton_steps, jacobians, factorizations, linear_iterations, fallbacks },
        seconds: Seconds { assembly, factorization, solve },
    };
    let clock = Clock { time, last_step, damping: Damping { interval, left } };
    let (new, old, detour) = (state("new")?, state("old")?, metadata.detour);
    let stage = |(n, t): (usize, &f64)| Ok((*t, state(&format!("stage{n}"))?));
    let stages = metadata.stages.iter().enumerate().map(stage).collect::<Result<_, Error>>()?;
    Ok(Memory {
        steps: metadata.step,
        stepper: time::Memory { clock, new, old, point, newton, detour, stages },
        adaptive: match &metadata.adaptive {
            Some(adaptive) if simulation.adaptive.is_some() => {
                let mut memory = sizes.adaptive(checkpoint, adaptive)?;
                let fields = memory.past.iter_mut().flat_map(|(_, fields)| fields);
                fields.for_each(|field| *field = space.nodal_part(field));
                Some(memory)
            }
            _ => None,
        },
        balance: metadata.balance,
        unloading: match simulation.case.is_prestressed() {
            true => array(checkpoint, "unloading".into(), space.n_u())?,
            false => vec![],
        },
    })
}

/// How many numbers the fields have.
struct Sizes {
    v: usize,
    u: usize,
    p: usize,
    s: usize,
}

impl Sizes {
    fn state(&self, checkpoint: &Checkpoint, name: &str) -> Result<State, Error> {
        let field = |field: &str, size| array(checkpoint, format!("{name}_{field}"), size);
        let s = if self.s == 0 { vec![] } else { field("s", self.s)? };
        Ok(State { v: field("v", self.v)?, u: field("u", self.u)?, p: field("p", self.p)?, s })
    }

    fn adaptive(&self, from: &Checkpoint, metadata: &OfAdaptive) -> Result<adaptive::Memory, Error> {
        let (next, scales, rejected, times) = metadata;
        let mut past = vec![];
        for (n, t) in times.iter().enumerate() {
            let field = |field: &str, size| array(from, format!("past{n}_{field}"), size);
            past.push((*t, [field("v", self.v)?, field("u", self.u)?]));
        }
        Ok(adaptive::Memory { next: *next, scales: *scales, rejected: *rejected, past })
    }
}

/// The array `key`, of `size` numbers.
fn array(checkpoint: &Checkpoint, key: String, size: usize) -> Result<Vec<f64>, Error> {
    let found = checkpoint.f64s(&key).filter(|values| values.len() == size);
    let message = || Error::Resume(format!("array {key} should have {size} numbers"));
    found.map(<[f64]>::to_vec).ok_or_else(message)
}
