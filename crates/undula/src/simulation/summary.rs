//! What a simulation has computed so far, in numbers.

use super::Simulation;
use crate::functional::statistics::{self, Series, Statistics};
use crate::output::{FunctionalSummary, Unknowns};
use std::collections::BTreeMap;

/// A history by columns.
#[derive(Default)]
pub(crate) struct Columns {
    times: Vec<f64>,
    force_times: Vec<f64>,
    /// One for each functional.
    values: Vec<Vec<f64>>,
}

impl Columns {
    /// Adds a row.
    pub(crate) fn push(&mut self, time: f64, force_time: f64, values: &[f64]) {
        self.times.push(time);
        self.force_times.push(force_time);
        self.values.resize(values.len(), vec![]);
        self.values.iter_mut().zip(values).for_each(|(column, &value)| column.push(value));
    }
}

impl<const D: usize> Simulation<D> {
    /// Number of the functional that is asked for a period first, see [`statistics::ranking`].
    pub fn leading(&self) -> Option<usize> {
        let names: Vec<&str> = self.functionals.iter().map(|(name, _)| name.as_str()).collect();
        statistics::ranking(&names, self.case.output.leading.as_deref()).first().copied()
    }

    /// Last values, means, amplitudes and frequencies of the rows in memory.
    pub fn statistics(&self) -> BTreeMap<String, FunctionalSummary> {
        let mut columns = Columns::default();
        self.history.iter().for_each(|row| columns.push(row.time, row.force_time, &row.values));
        self.statistics_of(&columns)
    }

    /// Last values, means, amplitudes and frequencies of `columns`, which has all functionals.
    pub(crate) fn statistics_of(&self, columns: &Columns) -> BTreeMap<String, FunctionalSummary> {
        let mut series = vec![];
        let none = vec![];
        for (n, (name, f)) in self.functionals.iter().enumerate() {
            let values = columns.values.get(n).unwrap_or(&none);
            let times = if f.at_force_time() { &columns.force_times } else { &columns.times };
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
        let [velocity, deformation, pressure] = space.n_all();
        Unknowns { velocity, deformation, pressure, total: velocity + deformation + pressure }
    }

    /// Number of cells, those of all processes.
    pub fn cells(&self) -> usize {
        let space = &self.stepper.assembler.space;
        space.part.as_ref().map_or(space.mesh.n_cells(), |part| part.all_cells())
    }
}
