//! Chunks of batches for the threads, and sums where chunks meet.
//!
//! Every chunk is worked on by one thread from its first batch to its last. What only one chunk adds to,
//! it adds to directly; where several meet, each has a copy of its own, and copies are added up afterwards
//! in the order of the chunks. Chunks depend on the mesh alone, and so do all sums, whatever the threads.

use super::scatter::Shared;
use crate::algebra::{Sink, SolverError};
use rayon::prelude::*;
use std::ops::Range;

/// Batches of a chunk at least: where chunks meet there is work twice.
const BATCHES: usize = 8;

/// Chunks at most: enough for any number of threads to share evenly.
const CHUNKS: usize = 64;

/// Sums per task.
const TARGETS: usize = 4096;

/// Consecutive batches, about equally many in each chunk.
pub fn chunks(batches: usize) -> Vec<Range<usize>> {
    let n = (batches / BATCHES).clamp(1, CHUNKS);
    (0..n).map(|c| c * batches / n..(c + 1) * batches / n).collect()
}

/// Run `work` on every batch of the `chunks`, which follow each other from 0 on, with its piece of `size` entries of
/// `array`; the batches of a chunk in their order on one thread.
pub fn for_each_piece<T: Send>(
    chunks: &[Range<usize>],
    array: &mut [T],
    size: usize,
    parallel: bool,
    work: &(impl Fn(usize, &mut [T]) + Sync),
) {
    match chunks {
        [] => {}
        [chunk] => {
            let mut rest = array;
            for batch in chunk.clone() {
                let (piece, behind) = rest.split_at_mut(size);
                work(batch, piece);
                rest = behind;
            }
        }
        _ => {
            let (left, right) = chunks.split_at(chunks.len() / 2);
            let (first, second) = array.split_at_mut((right[0].start - left[0].start) * size);
            let mut left = || for_each_piece(left, first, size, parallel, work);
            let mut right = || for_each_piece(right, second, size, parallel, work);
            if parallel {
                rayon::join(left, right);
            } else {
                left();
                right();
            }
        }
    }
}

/// Run `work` on every chunk, on all threads of the pool if there are several. Not generic: for each loop over chunks, what
/// rayon makes of it would be compiled once more.
pub fn for_each(chunks: &[Range<usize>], threads: usize, work: &(dyn Fn(&Range<usize>) + Sync)) {
    if threads == 1 {
        chunks.iter().for_each(work);
    } else {
        chunks.par_iter().with_max_len(1).for_each(work);
    }
}

/// Where the batches write: indices, each standing for a block of entries from it on.
pub struct Writes<'a> {
    /// First entries; not below [`ODD`], such as [`super::scatter::DROP`], is what stands for none.
    pub indices: &'a mut [u32],
    /// Those of each chunk.
    pub ranges: Vec<Range<usize>>,
    /// Rows of a block, and entries of a row.
    pub block: [usize; 2],
    /// How far apart the rows of the block at an index are in the array, by its number; those of a copy follow each
    /// other.
    pub stride: Box<dyn Fn(usize) -> u32 + 'a>,
}

impl<'a> Writes<'a> {
    /// Runs of `width` entries, `per_batch` of them for each batch.
    pub fn runs(
        indices: &'a mut [u32],
        chunks: &[Range<usize>],
        per_batch: usize,
        width: usize,
    ) -> Writes<'a> {
        Writes { indices, ranges: ranges(chunks, per_batch), block: [1, width], stride: Box::new(|_| 0) }
    }
}

/// What belongs to each chunk of a list with `per_batch` entries of each batch.
pub fn ranges(chunks: &[Range<usize>], per_batch: usize) -> Vec<Range<usize>> {
    chunks.iter().map(|chunk| chunk.start * per_batch..chunk.end * per_batch).collect()
}

/// Indices from here on have a meaning of their own.
pub const ODD: u32 = COPY;

/// Copies of the entries at which chunks meet.
#[derive(Debug, Default)]
pub struct Copies {
    /// Entries of the array that has copies; others behind them are not touched.
    n: usize,
    values: Vec<f64>,
    /// Entries with copies, ascending.
    targets: Vec<u32>,
    /// End of the copies of each target in `places`.
    ends: Vec<u32>,
    /// Places of the copies, those of a target in the order of the chunks.
    places: Vec<u32>,
}

/// Marks an entry that no chunk has met, one of several chunks, and a copy for the present chunk.
const FREE: u32 = u32::MAX;
const SHARED: u32 = COPY - 1;
const COPY: u32 = 1 << 31;

/// The chunk that writes each of `n` entries, [`FREE`] or [`SHARED`].
fn owners(n: usize, chunks: usize, writes: &[Writes<'_>]) -> Vec<u32> {
    let mut owner = vec![FREE; n];
    for c in 0..chunks {
        for w in writes.iter() {
            for &at in &w.indices[w.ranges[c].clone()] {
                if at < ODD {
                    let owner = &mut owner[at as usize];
                    *owner = if *owner == FREE || *owner == c as u32 { c as u32 } else { SHARED };
                }
            }
        }
    }
    owner
}

impl Copies {
    /// Redirect `writes` of `chunks` chunks into an array of `n` entries: an index beyond n is a copy.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if entries and copies together are too many for 31 bits.
    pub fn new(n: usize, chunks: usize, writes: &mut [Writes<'_>]) -> Result<Copies, SolverError> {
        Self::within(COPY, n, chunks, writes)
    }

    /// The same with fewer than `limit` entries and copies.
    fn within(limit: u32, n: usize, chunks: usize, writes: &mut [Writes<'_>]) -> Result<Copies, SolverError> {
        let too_many = |n: u64| {
            let message = format!("{n} entries of a matrix or vector, fewer than {limit} can be numbered");
            Err(SolverError::TooLarge(message))
        };
        if n >= limit as usize {
            return too_many(n as u64);
        }
        let mut owner = owners(n, chunks, writes);
        // From now on `owner` of a shared entry is where its copy for the present chunk is.
        let mut found: Vec<(u32, u32)> = vec![];
        let mut next: u32 = 0;
        for chunk in 0..chunks {
            let first = next;
            let mut of_chunk: Vec<(u32, u32)> = vec![];
            for w in writes.iter_mut() {
                let [rows, width] = w.block.map(|size| size as u32);
                for index in w.ranges[chunk].clone() {
                    let at = w.indices[index];
                    // Chunks have small numbers: the entry is this one's alone.
                    if at >= ODD || owner[at as usize] < SHARED {
                        continue;
                    }
                    let place = &mut owner[at as usize];
                    if *place == SHARED {
                        let all = n as u64 + u64::from(next) + u64::from(rows * width);
                        if all >= u64::from(limit) {
                            return too_many(all);
                        }
                        *place = COPY | (next - first);
                        let stride = (w.stride)(index);
                        for (i, j) in (0..rows).flat_map(|i| (0..width).map(move |j| (i, j))) {
                            of_chunk.push((at + i * stride + j, next + i * width + j));
                        }
                        next += rows * width;
                    }
                    w.indices[index] = n as u32 + first + (*place & !COPY);
                }
            }
            for &(target, _) in &of_chunk {
                owner[target as usize] = SHARED;
            }
            found.extend(of_chunk);
        }
        Ok(Copies::of(n, next as usize, found))
    }

    /// `copies` copies of the entries `found`, each with its target and its place.
    fn of(n: usize, copies: usize, mut found: Vec<(u32, u32)>) -> Copies {
        found.sort_by_key(|&(target, _)| target);
        let places = Vec::with_capacity(found.len());
        let mut all = Copies { n, values: vec![0.0; copies], places, ..Copies::default() };
        for (target, place) in found {
            if all.targets.last() != Some(&target) {
                all.targets.push(target);
                all.ends.push(all.places.len() as u32);
            }
            all.places.push(place);
            if let Some(end) = all.ends.last_mut() {
                *end += 1;
            }
        }
        all.targets.shrink_to_fit();
        all.ends.shrink_to_fit();
        all
    }

    /// Share `out` and the copies among the chunks.
    pub fn share<'a>(&'a mut self, out: &'a mut [f64]) -> Shared<'a> {
        Shared::with_copies(&mut out[..self.n], &mut self.values)
    }

    /// Share the entries of a matrix and the copies among the chunks.
    pub fn share_entries<'a>(&'a mut self, sink: Sink<'a>) -> Shared<'a> {
        Shared::entries(sink, self.n, &mut self.values)
    }

    /// Add all copies to `out`, and make them zero again.
    pub fn gather(&mut self, out: &mut [f64]) {
        self.gather_entries(Sink::Double(out));
    }

    /// The same to the entries of a matrix.
    pub fn gather_entries(&mut self, sink: Sink<'_>) {
        let Copies { n, values, targets, ends, places } = self;
        let (out, values) = (Shared::entries(sink, *n, &mut []), Shared::new(values));
        let sum = |(task, targets): (usize, &[u32])| {
            let first = task * TARGETS;
            let mut start = if first == 0 { 0 } else { ends[first - 1] };
            for (&target, &end) in targets.iter().zip(&ends[first..]) {
                let mut sum = 0.0;
                for &place in &places[start as usize..end as usize] {
                    sum += values.get(place);
                    values.set(place as usize, 0.0);
                }
                out.add(target, sum);
                start = end;
            }
        };
        if targets.len() <= TARGETS {
            targets.chunks(TARGETS).enumerate().for_each(sum);
        } else {
            targets.par_chunks(TARGETS).enumerate().for_each(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::scatter::DROP;
    use super::*;

    #[test]
    fn chunks_cover_all_batches() {
        for n in [0, 1, 7, 16, 100, 5000] {
            let list = chunks(n);
            assert_eq!((list[0].start, list[list.len() - 1].end), (0, n));
            assert!(list.windows(2).all(|w| w[0].end == w[1].start && !w[0].is_empty()));
            assert!(list.len() <= CHUNKS);
        }
    }

    #[test]
    fn copies_add_up_to_direct_sums() {
        // Two arrays of indices: pairs and single entries; batch b writes 4 and 1 of them.
        let batches = 40;
        let pairs: Vec<u32> =
            (0..4 * batches).map(|i| if i % 11 == 0 { DROP } else { 2 * (i * 7 % 23) }).collect();
        let single: Vec<u32> = (0..batches).map(|i| 46 + i * 5 % 13).collect();
        let list = chunks(batches as usize);
        assert!(list.len() > 2);
        let n = 60;
        let mut expected = vec![0.0; n];
        for (i, &at) in pairs.iter().enumerate().filter(|(_, at)| **at != DROP) {
            expected[at as usize] += i as f64;
            expected[at as usize + 1] -= i as f64;
        }
        single.iter().for_each(|&at| expected[at as usize] += 1.0);
        let (mut to_pairs, mut to_single) = (pairs, single);
        let mut writes =
            [Writes::runs(&mut to_pairs, &list, 4, 2), Writes::runs(&mut to_single, &list, 1, 1)];
        let mut copies = Copies::new(n, list.len(), &mut writes).unwrap();
        drop(writes);
        for _ in 0..2 {
            let mut out = vec![0.0; n];
            let shared = copies.share(&mut out);
            for (i, &at) in to_pairs.iter().enumerate().filter(|(_, at)| **at != DROP) {
                shared.add(at, i as f64);
                shared.add(at + 1, -(i as f64));
            }
            to_single.iter().for_each(|&at| shared.add(at, 1.0));
            copies.gather(&mut out);
            assert_eq!(out, expected);
        }
    }

    #[test]
    fn too_many_entries_are_an_error() {
        let list = chunks(40);
        let mut indices: Vec<u32> = (0..40).map(|batch| batch % 7).collect();
        let mut within = |limit| {
            let mut writes = [Writes::runs(&mut indices, &list, 1, 1)];
            Copies::within(limit, 7, list.len(), &mut writes).map(|copies| copies.places.len())
        };
        for limit in [7, 8, 20] {
            let message = within(limit).unwrap_err().to_string();
            assert!(message.contains("too large") && message.contains(&limit.to_string()), "{message}");
        }
    }

    #[test]
    fn every_batch_gets_its_piece() {
        for (batches, parallel) in [(0, true), (1, false), (5, true), (100, false), (100, true)] {
            let mut array = vec![0; 3 * batches];
            let list = chunks(batches);
            for_each_piece(&list, &mut array, 3, parallel, &|batch, piece| piece.fill(batch + 1));
            assert!(array.iter().enumerate().all(|(i, &x)| x == i / 3 + 1));
        }
    }
}
