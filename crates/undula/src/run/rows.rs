//! Rows of a simulation as lines of `history.csv`.

use crate::simulation::{Row, Simulation};
use std::sync::Arc;

/// The column that runs with an iterative solver have besides.
pub(super) const ITERATIONS: &str = "linear_iterations";

/// All columns of `history.csv`, with that of the linear iterations or without.
pub(super) fn columns<const D: usize>(simulation: &Simulation<D>, with_iterations: bool) -> Vec<String> {
    let mut columns: Vec<String> = ["step", "time", "force_time"].map(String::from).to_vec();
    columns.extend(simulation.names());
    columns.extend(["min_J", "newton_steps", "jacobians"].map(String::from));
    columns.extend(with_iterations.then(|| ITERATIONS.to_string()));
    columns
}

/// A row in the order of the columns.
pub(super) fn numbers(row: &Row, with_iterations: bool) -> Vec<f64> {
    let mut numbers = vec![row.step as f64, row.time, row.force_time];
    numbers.extend(&row.values);
    numbers.extend([row.min_j, row.newton_steps as f64, row.jacobians as f64]);
    numbers.extend(with_iterations.then_some(row.linear_iterations as f64));
    numbers
}

pub(super) fn read_row(row: &[f64], names: &Arc<[String]>) -> Row {
    let n = names.len();
    Row {
        step: row[0] as u64,
        time: row[1],
        force_time: row[2],
        values: row[3..3 + n].to_vec(),
        min_j: row[3 + n],
        newton_steps: row[4 + n] as usize,
        jacobians: row[5 + n] as usize,
        linear_iterations: row.get(6 + n).map_or(0, |&n| n as usize),
        names: names.clone(),
    }
}
