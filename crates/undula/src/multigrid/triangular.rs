//! A stationary coupled system as systems one behind the other: the flow on the domain as it is, the solid that feels
//! it, the extension that follows the solid. What an earlier one sees of a later one is left to GMRES outside.

use crate::algebra::{
    Cost, Csr, FactorReport, LinearSolver, Pattern, Sizes, SolveReport, SolverError, Spent, Unknown,
};
use std::sync::Arc;

/// No unknown of a part.
const NONE: u32 = u32::MAX;

/// Rows of the matrix, the unknowns that they are solved for, and what solves them.
pub struct Part {
    /// Increasing or not, as many as `columns`.
    pub rows: Vec<u32>,
    /// Unknowns, in the order of the rows.
    pub columns: Vec<u32>,
    /// For the matrix of these rows and columns; `None`: its diagonal will do.
    pub solver: Option<Box<dyn LinearSolver>>,
}

/// A part with its matrices.
struct Made {
    part: Part,
    /// Of the rows and columns of the part; of its diagonal, where that will do.
    matrix: Csr,
    /// Where its entries are in the whole matrix.
    entries: Vec<u32>,
    before: Coupling,
    /// Right-hand side and solution.
    b: Vec<f64>,
    x: Vec<f64>,
}

/// Entries of the rows of a part in columns of the parts before it.
#[derive(Default)]
struct Coupling {
    /// Row of the part, column of the whole matrix, entry there.
    places: Vec<[u32; 3]>,
    values: Vec<f64>,
}

/// The parts, one after the other.
pub struct Triangular {
    parts: Vec<Part>,
    made: Vec<Made>,
    /// Rows of no part: those of unknowns that are given, with nothing but 1 on the diagonal.
    rest: Vec<u32>,
}

impl Triangular {
    /// From parts without a row or a column in common.
    pub fn new(parts: Vec<Part>) -> Triangular {
        Triangular { parts, made: vec![], rest: vec![] }
    }
}

impl Made {
    /// On `pattern`, where columns with a number in `known` belong to parts before.
    fn new(
        mut part: Part,
        pattern: &Pattern,
        unknowns: &[Unknown],
        known: &[bool],
    ) -> Result<Made, SolverError> {
        let mut number = vec![NONE; pattern.n];
        part.columns.iter().zip(0..).for_each(|(&column, at)| number[column as usize] = at);
        let (mut lists, mut before) = (vec![], Coupling::default());
        let is_diagonal = part.solver.is_none();
        for (row, at) in part.rows.iter().zip(0_u32..) {
            let mut list = vec![];
            for entry in pattern.row(*row as usize) {
                let column = pattern.column(*row as usize, entry);
                match number[column as usize] {
                    NONE if known[column as usize] => before.places.push([at, column, entry as u32]),
                    NONE => {}
                    other if is_diagonal && other != at => {}
                    other => list.push((other, entry as u32)),
                }
            }
            list.sort_unstable();
            lists.push(list);
        }
        let columns = lists.iter().map(|list| list.iter().map(|entry| entry.0).collect::<Vec<u32>>());
        let own = Arc::new(Pattern::from_rows(&columns.collect::<Vec<_>>()));
        let entries: Vec<u32> = lists.into_iter().flatten().map(|entry| entry.1).collect();
        let of: Vec<Unknown> = part.columns.iter().map(|&column| unknowns[column as usize]).collect();
        if let Some(solver) = &mut part.solver {
            solver.analyse(&own, &of)?;
        }
        before.values = vec![0.0; before.places.len()];
        let n = own.n;
        Ok(Made { part, matrix: Csr::zeros(&own), entries, before, b: vec![0.0; n], x: vec![0.0; n] })
    }

    fn factor(&mut self, a: &Csr) -> Result<(), SolverError> {
        let entries = self.matrix.values.iter_mut().zip(&self.entries);
        entries.for_each(|(to, &entry)| *to = a.values[entry as usize]);
        let places = self.before.values.iter_mut().zip(&self.before.places);
        places.for_each(|(to, &[_, _, entry])| *to = a.values[entry as usize]);
        match &mut self.part.solver {
            Some(solver) => solver.factor(&self.matrix).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Its unknowns in `x` for the right-hand side `b`, those of parts before being in `x`.
    fn apply(&mut self, b: &[f64], x: &mut [f64]) {
        self.b.iter_mut().zip(&self.part.rows).for_each(|(to, &row)| *to = b[row as usize]);
        for (&[row, column, _], value) in self.before.places.iter().zip(&self.before.values) {
            self.b[row as usize] -= value * x[column as usize];
        }
        match &mut self.part.solver {
            Some(solver) => solver.apply(&self.b, &mut self.x),
            None => {
                let pairs = self.x.iter_mut().zip(&self.b).zip(&self.matrix.values);
                pairs.for_each(|((x, b), diagonal)| *x = b / diagonal);
            }
        }
        self.part.columns.iter().zip(&self.x).for_each(|(&column, value)| x[column as usize] = *value);
    }
}

impl LinearSolver for Triangular {
    fn name(&self) -> &'static str {
        "multigrid"
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError> {
        let mut known = vec![false; pattern.n];
        let mut is_there = vec![false; pattern.n];
        for part in std::mem::take(&mut self.parts).into_iter().filter(|part| !part.rows.is_empty()) {
            let made = Made::new(part, pattern, unknowns, &known)?;
            made.part.columns.iter().for_each(|&column| known[column as usize] = true);
            made.part.rows.iter().for_each(|&row| is_there[row as usize] = true);
            self.made.push(made);
        }
        self.rest = (0..pattern.n as u32).filter(|&row| !is_there[row as usize]).collect();
        Ok(())
    }

    fn factor(&mut self, a: &Csr) -> Result<FactorReport, SolverError> {
        self.made.iter_mut().try_for_each(|made| made.factor(a))?;
        let cost = self.predicted().unwrap_or_default();
        Ok(FactorReport { cost, probe_error: f64::NAN, condition: None })
    }

    fn solve(&mut self, _a: &Csr, b: &[f64], x: &mut [f64]) -> Result<SolveReport, SolverError> {
        self.apply(b, x);
        Ok(SolveReport { refinements: 0, backward_error: f64::NAN })
    }

    fn apply(&mut self, b: &[f64], x: &mut [f64]) {
        x.fill(0.0);
        self.rest.iter().for_each(|&row| x[row as usize] = b[row as usize]);
        self.made.iter_mut().for_each(|made| made.apply(b, x));
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn predicted(&self) -> Option<Cost> {
        let costs = self.made.iter().filter_map(|made| made.part.solver.as_ref()?.predicted());
        let sum = costs.fold(Cost::default(), |sum, cost| Cost {
            read: Some(sum.read.unwrap_or(0) + cost.read.unwrap_or(0)),
            flops: Some(sum.flops.unwrap_or(0.0) + cost.flops.unwrap_or(0.0)),
            ..sum
        });
        Some(sum)
    }

    fn largest_factor(&self) -> usize {
        let solvers = self.made.iter().filter_map(|made| made.part.solver.as_ref());
        solvers.map(|solver| solver.largest_factor()).max().unwrap_or(0)
    }

    fn spent(&self) -> Vec<Spent> {
        let solvers = self.made.iter().filter_map(|made| made.part.solver.as_ref());
        solvers.flat_map(|solver| solver.spent()).collect()
    }

    fn set_sizes(&mut self, sizes: Sizes) {
        self.made.iter_mut().filter_map(|made| made.part.solver.as_mut()).for_each(|s| s.set_sizes(sizes));
    }
}
