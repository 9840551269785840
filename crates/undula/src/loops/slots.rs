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
#[derive(Debug, Default)]
pub struct Slots<const L: usize> {
    places: Vec<[u32; L]>,
    per_batch: usize,
    copies: Copies,
}

impl<const L: usize> Slots<L> {
    /// For `batches` batches in `chunks`; `visit` calls back with (lane, row, column) for each entry of each batch, all
    /// lanes of an entry one after the other, [`DROP`] as row where a lane has none.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if they are too many to be numbered.
    pub fn new(
        batches: usize,
        chunks: &[Range<usize>],
        entries: &Entries<'_>,
        visit: impl FnOnce(&mut dyn FnMut(usize, u32, u32)),
    ) -> Result<Slots<L>, SolverError> {
        let mut places: Vec<[u32; L]> = vec![];
        visit(&mut |lane, row, column| {
            if lane == 0 {
                places.push([DROP; L]);
            }
            if let (Some(last), true) = (places.last_mut(), row != DROP) {
                last[lane] = (entries.find)(row, column);
            }
        });
        let per_batch = places.len() / batches.max(1);
        let mut writes = [Writes { indices: places.as_flattened_mut(), per_batch: per_batch * L, width: 1 }];
        let copies = Copies::new(entries.n, chunks, &mut writes)?;
        Ok(Slots { places, per_batch, copies })
    }

    /// Those of one batch, in the order in which they were visited.
    #[inline(always)]
    pub fn of(&self, batch: usize) -> &[[u32; L]] {
        &self.places[batch * self.per_batch..(batch + 1) * self.per_batch]
    }

    /// Let `add` add to the entries `out` of the matrix from several threads.
    pub fn fill(&mut self, out: &mut [f64], add: impl FnOnce(&Self, &Shared<'_>)) {
        let mut copies = std::mem::take(&mut self.copies);
        add(self, &copies.share(out));
        copies.gather(out);
        self.copies = copies;
    }
}
