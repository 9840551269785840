//! What a simulation has computed so far, in numbers.

use super::Simulation;
use crate::functional::statistics::{self, Series, Statistics};
use crate::output::{FunctionalSummary, Unknowns};
use std::collections::BTreeMap;

impl<const D: usize> Simulation<D> {
    /// Number of the functional that is asked for a period first, see [`statistics::ranking`].
    pub fn leading(&self) -> Option<usize> {
        let names: Vec<&str> = self.functionals.iter().map(|(name, _)| name.as_str()).collect();
        statistics::ranking(&names, self.case.output.leading.as_deref()).first().copied()
    }

    /// Last values, means, amplitudes and frequencies so far.
    pub fn statistics(&self) -> BTreeMap<String, FunctionalSummary> {
        let times: Vec<f64> = self.history.iter().map(|r| r.time).collect();
        let force_times: Vec<f64> = self.history.iter().map(|r| r.force_time).collect();
        let column = |i: usize| -> Vec<f64> { self.history.iter().map(|r| r.values[i]).collect() };
        let columns: Vec<Vec<f64>> = (0..self.functionals.len()).map(column).collect();
        let mut series = vec![];
        for ((name, f), values) in self.functionals.iter().zip(&columns) {
            let times = if f.at_force_time() { &force_times } else { &times };
            series.push(Series { name, times, values });
        }
        let (_, found) = statistics::summarize(&series, self.case.output.leading.as_deref());
        let units = self.functionals.iter().map(|(_, f)| f.unit());
        let summary = |s: Statistics, unit: &str| {
            let Statistics { last, mean, amplitude, frequency } = s;
            FunctionalSummary { last, mean, amplitude, frequency, unit: unit.to_string() }
        };
        let summaries = found.into_iter().zip(units).map(|(s, unit)| summary(s, unit));
        self.names().into_iter().zip(summaries).collect()
    }

    /// Numbers of unknowns, given ones counted.
    pub fn unknowns(&self) -> Unknowns {
        let space = &self.stepper.assembler.space;
        Unknowns {
            velocity: space.n_v(),
            deformation: space.n_u(),
            pressure: space.n_p(),
            total: space.n_field_unknowns(),
        }
    }
}
