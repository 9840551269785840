//! The coarsest level of processes that share a mesh: each has all of it, and solves it as the others do.

use super::shared::{flat, rows_of};
use crate::algebra::{Csr, Pattern};
use crate::parallel::{Fault, Halo};
use std::sync::Arc;

/// The coarsest level, of which every process has all.
pub struct Gathered {
    pub(super) halo: Arc<Halo>,
    pub(super) matrix: Csr,
    /// Numbers in the whole of the unknowns here.
    numbers: Vec<u32>,
    /// Entries of own rows here.
    own: Vec<u32>,
    /// The unknowns of each process in the whole, and the entries of their rows.
    unknowns: Vec<Vec<u32>>,
    entries: Vec<Vec<u32>>,
}

impl Gathered {
    /// Of `n` unknowns in all.
    pub(super) fn new(
        halo: Arc<Halo>,
        pattern: &Pattern,
        numbers: Vec<u32>,
        n: usize,
    ) -> Result<Gathered, Fault> {
        let row = |&at: &u32| {
            let columns = pattern.columns(at as usize).iter().map(|column| numbers[*column as usize]);
            (numbers[at as usize], columns.collect())
        };
        let lists = halo.crew().lists(&flat(halo.own().iter().map(row)))?;
        let lists: Vec<Vec<(u32, Vec<u32>)>> = lists.iter().map(|list| rows_of(list)).collect();
        let mut rows = vec![vec![]; n];
        lists.iter().flatten().for_each(|(id, columns)| rows[*id as usize].clone_from(columns));
        let whole = Arc::new(Pattern::from_rows(&rows));
        let of_row = |(id, _): &(u32, Vec<u32>)| whole.row(*id as usize).map(|at| at as u32);
        let entries = lists.iter().map(|list| list.iter().flat_map(of_row).collect()).collect();
        let unknowns = lists.iter().map(|list| list.iter().map(|row| row.0).collect()).collect();
        let own = halo.own().iter().flat_map(|&at| pattern.row(at as usize)).map(|at| at as u32).collect();
        Ok(Gathered { halo, matrix: Csr::zeros(&whole), numbers, own, unknowns, entries })
    }

    /// The matrix from the rows of all.
    pub(super) fn take(&mut self, matrix: &Csr) -> Result<(), Fault> {
        let own: Vec<f64> = self.own.iter().map(|&at| matrix.values[at as usize]).collect();
        for (values, entries) in self.halo.crew().lists(&own)?.iter().zip(&self.entries) {
            values.iter().zip(entries).for_each(|(value, &at)| self.matrix.values[at as usize] = *value);
        }
        Ok(())
    }

    /// The sums of the `parts` of all processes; NaN where MPI fails.
    pub(super) fn sum(&self, parts: &mut [f64], whole: &mut [f64]) {
        self.halo.add(parts);
        let own: Vec<f64> = self.halo.own().iter().map(|&at| parts[at as usize]).collect();
        let Ok(lists) = self.halo.crew().lists(&own) else { return whole.fill(f64::NAN) };
        for (values, unknowns) in lists.iter().zip(&self.unknowns) {
            values.iter().zip(unknowns).for_each(|(value, &at)| whole[at as usize] = *value);
        }
    }

    /// What is here of a vector of the whole.
    pub(super) fn part<'a>(&'a self, whole: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.numbers.iter().map(|&at| whole[at as usize])
    }
}
