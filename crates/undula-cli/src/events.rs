//! `undula run --log json`: start, steps and end of a run as JSON objects, one a line.

use crate::args::event;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;
use undula::case::Case;
use undula::nonlinear::Counters;
use undula::output::Summary;
use undula::simulation::{Row, Simulation};
use undula::time::StepReport;

/// What is told of a run, and what the numbers of a step are counted from.
pub struct Events {
    clock: Instant,
    counters: Counters,
}

impl Events {
    /// Of a run that has not begun.
    pub fn new() -> Events {
        Events { clock: Instant::now(), counters: Counters::default() }
    }

    /// The run in `directory` begins, at `step` above 0 if it goes on.
    pub fn start<const D: usize>(&mut self, simulation: &Simulation<D>, directory: &Path) {
        let unknowns = simulation.unknowns();
        let Case { name, title, time, .. } = &simulation.case;
        event(
            "start",
            json!({
                "case": name,
                "title": title,
                "directory": directory.display().to_string(),
                "version": env!("CARGO_PKG_VERSION"),
                "dimension": D,
                "cells": simulation.cells(),
                "unknowns": {
                    "total": unknowns.total,
                    "velocity": unknowns.velocity,
                    "deformation": unknowns.deformation,
                    "pressure": unknowns.pressure,
                },
                "threads": simulation.threads(),
                "step": simulation.steps,
                "time": simulation.time(),
                "end": time.as_ref().map(|time| time.end),
                "functionals": simulation.names(),
                "units": simulation.units(),
            }),
        );
        (self.clock, self.counters) = (Instant::now(), simulation.stepper.newton.counters);
    }

    /// A step is done.
    pub fn step<const D: usize>(&mut self, simulation: &Simulation<D>, row: &Row) {
        let now = simulation.stepper.newton.counters;
        let values: serde_json::Map<String, Value> =
            row.names().iter().cloned().zip(row.values.iter().map(|&x| json!(x))).collect();
        event(
            "step",
            json!({
                "step": row.step,
                "time": row.time,
                "force_time": row.force_time,
                "newton_steps": row.newton_steps,
                "rate": rate(&simulation.report),
                "jacobians": row.jacobians,
                "factorizations": now.factorizations - self.counters.factorizations,
                "linear_iterations": now.linear_iterations - self.counters.linear_iterations,
                "seconds": self.clock.elapsed().as_secs_f64(),
                "min_J": row.min_j,
                "values": values,
            }),
        );
        (self.clock, self.counters) = (Instant::now(), now);
    }
}

/// The run has ended; `Err` says why it has no summary.
pub fn end(result: Result<&Summary, String>) {
    let values = match result {
        Err(error) => json!({ "status": "failed", "text": error }),
        Ok(summary) => json!({
            "status": summary.status.to_string(),
            "steps": summary.steps,
            "newton_steps": summary.newton_steps,
            "jacobians": summary.jacobians,
            "linear_iterations": summary.linear_iterations,
            "wall_seconds": summary.wall_seconds,
            "cpu_seconds": summary.cpu_seconds,
        }),
    };
    event("end", values);
}

/// By what factor an iteration of a step has reduced the residual in the mean over its iterations, (rₙ/r₀)^(1/n).
fn rate(report: &StepReport) -> Option<f64> {
    let (mut logarithm, mut count) = (0.0, 0);
    for part in report.residuals_of_parts() {
        if let [first, .., last] = part
            && *first > 0.0
        {
            logarithm += (last / first).ln();
            count += part.len() - 1;
        }
    }
    (count > 0).then(|| (logarithm / count as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::rate;
    use undula::time::StepReport;

    #[test]
    fn the_rate_is_a_geometric_mean_over_all_iterations() {
        let residuals = vec![1.0, 0.1, 1e-4, 8.0, 1e-3];
        let report = StepReport { residuals, ends: vec![3, 5], ..StepReport::default() };
        let expected = (1e-4 * (1e-3 / 8.0_f64)).powf(1.0 / 3.0);
        assert!((rate(&report).unwrap() / expected - 1.0).abs() < 1e-12);
        assert_eq!(rate(&StepReport { residuals: vec![0.0], ends: vec![1], ..StepReport::default() }), None);
    }
}
