//! Condition numbers of the coupled matrix (5.35) and of its diagonal blocks.

use super::lanczos::largest;
use crate::algebra::{Csr, LinearSolver, MultifrontalLu, Options, Pattern, Scaling, SolverError, Unknown};
use std::sync::Arc;

/// Condition numbers ‖A‖₂ ‖A⁻¹‖₂, estimated from below by Lanczos' method for AᵀA and its inverse.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Condition {
    /// Number of unknowns.
    pub n: usize,
    /// Of the matrix with its units.
    pub plain: f64,
    /// After its rows and columns have been brought to one size, as the direct solver does.
    pub scaled: f64,
}

/// The condition numbers of the rows and columns `keep` of `a`; infinite if they are singular.
///
/// # Errors
/// If memory is short.
pub fn condition(a: &Csr, unknowns: &[Unknown], keep: &[u32]) -> Result<Condition, SolverError> {
    let unknowns: Vec<Unknown> = keep.iter().map(|&k| unknowns[k as usize]).collect();
    let mut block = part(a, keep);
    let plain = number(&block, &unknowns)?;
    let mut scaling = Scaling::default();
    let scaled = match scaling.update(&block, &unknowns) {
        Ok(()) => {
            let Csr { pattern, values } = &mut block;
            for row in 0..pattern.n {
                for at in pattern.row(row) {
                    values[at] *= scaling.row[row] * scaling.col[pattern.column(row, at) as usize];
                }
            }
            number(&block, &unknowns)?
        }
        Err(_) => f64::INFINITY,
    };
    Ok(Condition { n: keep.len(), plain, scaled })
}

/// Rows and columns `keep` of `a`.
fn part(a: &Csr, keep: &[u32]) -> Csr {
    let mut number = vec![u32::MAX; a.pattern.n];
    keep.iter().enumerate().for_each(|(n, &k)| number[k as usize] = n as u32);
    let entries = |row: u32| {
        let row = row as usize;
        let stored = a.pattern.columns(row).iter().zip(&a.values[a.pattern.row(row)]);
        stored.map(|(&col, &value)| (number[col as usize], value)).filter(|(col, _)| *col != u32::MAX)
    };
    let rows: Vec<Vec<u32>> = keep.iter().map(|&row| entries(row).map(|(col, _)| col).collect()).collect();
    let mut out = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
    for (row, &from) in keep.iter().enumerate() {
        for (col, value) in entries(from) {
            set(&mut out, row, col as usize, value);
        }
    }
    out
}

fn set(a: &mut Csr, row: usize, col: usize, value: f64) {
    if let Some(at) = a.pattern.find(row, col) {
        a.values[at] = value;
    }
}

fn transposed(a: &Csr) -> Csr {
    let mut rows = vec![vec![]; a.pattern.n];
    for row in 0..a.pattern.n {
        a.pattern.row(row).for_each(|at| rows[a.pattern.column(row, at) as usize].push(row as u32));
    }
    let mut out = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
    for row in 0..a.pattern.n {
        for at in a.pattern.row(row) {
            set(&mut out, a.pattern.column(row, at) as usize, row, a.values[at]);
        }
    }
    out
}

/// ‖A‖₂ ‖A⁻¹‖₂.
fn number(a: &Csr, unknowns: &[Unknown]) -> Result<f64, SolverError> {
    let t = transposed(a);
    let mut solvers = [a, &t].map(|_| MultifrontalLu::multifrontal(Options::unprobed()));
    for (solver, matrix) in solvers.iter_mut().zip([a, &t]) {
        let factored = solver.analyse(&matrix.pattern, unknowns).and_then(|()| solver.factor(matrix));
        match factored {
            Ok(_) => {}
            Err(error @ SolverError::Memory(_)) => return Err(error),
            Err(_) => return Ok(f64::INFINITY),
        }
    }
    let [of_a, of_t] = &mut solvers;
    let (n, mut work) = (a.pattern.n, vec![0.0; a.pattern.n]);
    let plain = |x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
    let square = largest(
        n,
        |x, y| {
            a.mul(x, &mut work);
            t.mul(&work, y);
        },
        plain,
        |_| {},
    );
    let inverse = largest(
        n,
        |x, y| {
            of_t.apply(x, &mut work);
            of_a.apply(&work, y);
        },
        plain,
        |_| {},
    );
    Ok((square * inverse).sqrt())
}
