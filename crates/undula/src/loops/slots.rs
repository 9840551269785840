//! Where the entries of element matrices go in a sparse matrix.

use super::chunks::{Copies, Writes};
use super::scatter::{DROP, Shared};
use crate::algebra::SolverError;
use std::ops::Range;

/// Entries of a sparse matrix with `n` of them; `find(row, column)` is the place of one.
#[derive(Copy, Clone)]
pub struct Entries<'a> {
    /// Their number.
    pub n: usize,
    /// The place of an entry, [`DROP`] if the matrix does not have it.
    pub find: &'a dyn Fn(u32, u32) -> u32,
}

/// The places of the entries of all element matrices, with the copies of those at which chunks meet.
///
/// Entries may come in runs: the columns of the D components of a node follow each other, so that one place stands for D
/// entries. In three dimensions the places of single entries would need more memory than the matrix.
#[derive(Debug, Default)]
pub struct Slots<const L: usize> {
    lists: Vec<List<L>>,
    copies: Copies,
}

/// Places of runs of one length.
#[derive(Debug)]
struct List<const L: usize> {
    places: Vec<[u32; L]>,
    per_batch: usize,
}

impl<const L: usize> Slots<L> {
    /// For `batches` batches in `chunks`, with one list of runs for each of the `lengths`; `visit` calls back with (list,
    /// lane, row, first column) for each run of each batch, all lanes of a run one after the other, [`DROP`] as row where a
    /// lane has none.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if they are too many to be numbered.
    pub fn new(
        batches: usize,
        chunks: &[Range<usize>],
        entries: &Entries<'_>,
        lengths: &[usize],
        visit: impl FnOnce(&mut dyn FnMut(usize, usize, u32, u32)),
    ) -> Result<Slots<L>, SolverError> {
        let mut lists: Vec<Vec<[u32; L]>> = vec![vec![]; lengths.len()];
        visit(&mut |list, lane, row, column| {
            let places = &mut lists[list];
            if lane == 0 {
                places.push([DROP; L]);
            }
            if let (Some(last), true) = (places.last_mut(), row != DROP) {
                let place = (entries.find)(row, column);
                let follows = |j: u32| (entries.find)(row, column + j) == place + j;
                assert!((1..lengths[list] as u32).all(follows), "row {row}, run from column {column}");
                last[lane] = place;
            }
        });
        let of_batch = |places: &Vec<[u32; L]>| places.len() / batches.max(1);
        let per_batch: Vec<usize> = lists.iter().map(of_batch).collect();
        let mut writes: Vec<Writes<'_>> = vec![];
        for ((places, per_batch), &width) in lists.iter_mut().zip(&per_batch).zip(lengths) {
            writes.push(Writes { indices: places.as_flattened_mut(), per_batch: per_batch * L, width });
        }
        let copies = Copies::new(entries.n, chunks, &mut writes)?;
        let list = |(places, per_batch)| List { places, per_batch };
        Ok(Slots { lists: lists.into_iter().zip(per_batch).map(list).collect(), copies })
    }

    /// Those of a list in one batch, in the order in which they were visited.
    #[inline(always)]
    pub fn of(&self, list: usize, batch: usize) -> &[[u32; L]] {
        let List { places, per_batch } = &self.lists[list];
        &places[batch * per_batch..(batch + 1) * per_batch]
    }

    /// Let `add` add to the entries `out` of the matrix from several threads.
    pub fn fill(&mut self, out: &mut [f64], add: impl FnOnce(&Self, &Shared<'_>)) {
        let mut copies = std::mem::take(&mut self.copies);
        add(self, &copies.share(out));
        copies.gather(out);
        self.copies = copies;
    }
}
