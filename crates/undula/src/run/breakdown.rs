//! A breakdown in words: its cause in one sentence, what to try in another, and the residuals for a file.

use super::inflow;
use crate::case::key;
use crate::case::{Case, Condition, Linearization, MotionModel};
use crate::math::{rounded, shortest};
use crate::output::Breakdown;
use crate::simulation::Simulation;
use crate::space::Region;
use crate::time::{Attempt, Cause, StepFailure};
use std::fmt::Write;

/// Cells that are named, of those that fold.
const CELLS: usize = 8;

/// A cause that the whole case shows, where the step alone shows a consequence.
struct Special {
    /// One word for programs.
    cause: &'static str,
    /// The cause, to follow `no solution for the step …: `.
    sentence: String,
    /// What to try.
    remedy: String,
    /// Where it is.
    place: String,
}

/// The first cause that the whole case shows.
///
/// Functions that look for one belong here, each `fn(&Simulation, &StepFailure) -> Option<Special>`.
fn special<const D: usize>(simulation: &Simulation<D>, failure: &StepFailure) -> Option<Special> {
    let finders: [fn(&Simulation<D>, &StepFailure) -> Option<Special>; 2] = [overfilled, backflow];
    finders.iter().find_map(|find| find(simulation, failure))
}

/// A closed part of the fluid that data fill or drain.
fn overfilled<const D: usize>(simulation: &Simulation<D>, failure: &StepFailure) -> Option<Special> {
    let assembler = &simulation.stepper.assembler;
    let sentence = simulation.case.overfilled(&assembler.space, &assembler.constraints, failure.time)?;
    Some(Special { cause: "closed", sentence, remedy: String::new(), place: place(simulation, failure) })
}

/// Flow that comes back in through an outlet.
fn backflow<const D: usize>(simulation: &Simulation<D>, failure: &StepFailure) -> Option<Special> {
    let space = &simulation.stepper.assembler.space;
    let found = inflow::explains(&simulation.case, space, &simulation.stepper.new, failure)?;
    let (speed, point) = (
        shortest(rounded(found.speed, found.speed, 3)),
        space.mesh.shown(&std::array::from_fn(|d| found.point[d])),
    );
    let key = key::join("boundary", &found.boundary);
    // With the other one a given pressure would be another, the total one.
    let inlet = matches!(simulation.case.boundary.get(&found.boundary), Some(Condition::Pressure { .. }));
    let term = if inlet { "tangential" } else { "directional" };
    Some(Special {
        cause: "backflow",
        sentence: format!(
            "the flow comes back in through the outlet `{}`, with {speed} m/s at {point}",
            found.boundary
        ),
        remedy: format!("{key}.backflow = \"{term}\" computes through it"),
        place: format!("boundary `{}` at {point}", found.boundary),
    })
}

/// What the summary says of a failure.
pub fn describe<const D: usize>(simulation: &Simulation<D>, failure: &StepFailure) -> Breakdown {
    let cause = &failure.details.cause;
    let Special { cause, sentence, remedy, place } =
        special(simulation, failure).unwrap_or_else(|| Special {
            cause: cause.name(),
            sentence: cause.to_string(),
            remedy: remedy(&simulation.case, failure),
            place: place(simulation, failure),
        });
    Breakdown {
        time: failure.time,
        min_j: failure.worst.min_j,
        r#where: place,
        reason: format!("{}: {sentence}", failure.headline()),
        cause: cause.into(),
        remedy,
    }
}

/// Where it is: the cells that fold, or the place of the cause.
fn place<const D: usize>(simulation: &Simulation<D>, failure: &StepFailure) -> String {
    let mesh = &simulation.stepper.assembler.space.mesh;
    match &failure.details.cause {
        Cause::Folding { .. } => {
            let cells = &failure.worst.cells;
            let cell = |&c: &u32| format!("cell {c} at {}", mesh.shown(&mesh.centre(c as usize)));
            let mut list: Vec<String> = cells.iter().take(CELLS).map(cell).collect();
            if cells.len() > CELLS {
                list.push(format!("and {} more", cells.len() - CELLS));
            }
            list.join(", ")
        }
        cause => cause.spot().map(|spot| spot.text.clone()).unwrap_or_default(),
    }
}

/// What to try, a short sentence that begins with `try`; empty where nothing is known.
fn remedy(case: &Case, failure: &StepFailure) -> String {
    let smaller = if case.time.is_some() { "shorter steps (time.step)" } else { "a smaller load" };
    let linearization = case.newton.linearization;
    match &failure.details.cause {
        Cause::Folding { region: Region::Solid, .. } => {
            format!("try {smaller}, smaller cells, or a solid.law that resists compression (`neo-hookean`)")
        }
        Cause::Folding { .. } => {
            let model = match case.motion.model {
                MotionModel::Biharmonic => "another motion.model",
                _ => "motion.model = \"biharmonic\"",
            };
            format!("try {model}, another motion.offset, or {smaller}")
        }
        Cause::Slow { .. } => "try newton.linearization = \"newton\"".into(),
        Cause::Divergence { .. } if linearization == Linearization::Newton => {
            format!("try {smaller}, or more of newton.max-steps and newton.line-search")
        }
        Cause::Divergence { .. } => format!("try {smaller}, or newton.linearization = \"newton\""),
        Cause::Singular { .. } => "try a condition on a boundary that determines it".into(),
        Cause::NotFinite { .. } => format!("try {smaller}"),
        Cause::Data(_) | Cause::Solver(_) => String::new(),
    }
}

/// The text of `breakdown.txt`: the words of `breakdown` and the residuals of all that was tried.
pub(super) fn table(breakdown: &Breakdown, failure: &StepFailure) -> String {
    let mut text = format!("{}\n", breakdown.reason);
    for line in [&breakdown.remedy, &breakdown.r#where] {
        if !line.is_empty() {
            text += &format!("{line}\n");
        }
    }
    text += "\nIterations that failed, with the scaled residual [m/s] at the start and after each.\n";
    for attempt in &failure.details.attempts {
        // Writing to a string does not fail.
        let _ = writeln!(text, "\n{}: {}", tried(attempt), attempt.reason);
        for (n, norm) in attempt.reason.norms().iter().enumerate() {
            let _ = writeln!(text, "{n:4}  {norm:.6e}");
        }
    }
    text
}

fn tried(attempt: &Attempt) -> String {
    if attempt.step == 0.0 {
        return format!("load {}", shortest(rounded(attempt.load, attempt.load, 6)));
    }
    let of_step = |x: f64| shortest(rounded(x, attempt.step, 6));
    format!("step to t = {} s, k = {} s", of_step(attempt.time), of_step(attempt.step))
}
