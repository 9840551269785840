//! Where the entries of element matrices go in a sparse matrix.
//!
//! One place stands for all entries of a test function and a basis function: for D × D of two nodes, for D of a node and
//! a pressure. Rows of the components of a node have the same columns, so that entry (i, j) of a block at place p is at
//! ```text
//!     p + i s + j,
//! ```
//! s being the number of entries in a row of the node. In three dimensions places of single entries would need more memory
//! than the matrix. Where one component of a node is given and another is not, blocks are *odd*: each of their entries has
//! a place of its own.

use super::chunks::{Copies, ODD, Writes, ranges};
use super::scatter::{DROP, Shared};
use super::test_functions::{Piece, Test, Trial};
use crate::algebra::{Sink, SolverError};
use crate::math::Lanes;
use std::ops::Range;

/// Entries of a sparse matrix with `n` of them; `find(row, column)` is the place of one.
#[derive(Copy, Clone)]
pub struct Entries<'a> {
    /// Their number.
    pub n: usize,
    /// The place of an entry, [`DROP`] if the matrix does not have it.
    pub find: &'a dyn Fn(u32, u32) -> u32,
}

/// A test function and an unknown that are coupled; component 0 stands for all.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Rows.
    pub test: Test,
    /// Columns.
    pub trial: Trial,
    /// Whether components are coupled with their like alone.
    pub diagonal: bool,
}

impl Pair {
    /// All components with all.
    pub const fn full(test: Test, trial: Trial) -> Pair {
        Pair { test, trial, diagonal: false }
    }
}

/// What the `pieces` of an element matrix couple.
pub fn pairs(pieces: &[Piece]) -> Vec<Pair> {
    let mut list: Vec<Pair> = vec![];
    for piece in pieces {
        let ((test, i), (trial, j)) = (piece.test.split(), piece.trial.split());
        let is_alike = |pair: &&mut Pair| pair.test.split().0 == test && pair.trial.split().0 == trial;
        let of_nodes = test < 2 && trial < 2;
        match list.iter_mut().find(is_alike) {
            Some(pair) => pair.diagonal &= i == j,
            None => list.push(Pair { test: piece.test, trial: piece.trial, diagonal: of_nodes && i == j }),
        }
    }
    list
}

/// Numbers of the rows or columns of one kind in a batch, `[basis function][lane][component]`; [`DROP`] where there is
/// none.
pub type Numbers<const D: usize, const L: usize> = Vec<[[u32; D]; L]>;

/// Numbers of the rows φ, ψ, ξ and of the columns v, u, p of a batch.
#[derive(Debug, Default)]
pub struct Numbering<const D: usize, const L: usize> {
    /// φ, ψ and ξ.
    pub rows: [Numbers<D, L>; 3],
    /// v, u and p.
    pub columns: [Numbers<D, L>; 3],
}

/// The numbers of vector unknowns whose first components have the places `first` in `[v, u, p]` or [`DROP`], in the
/// first `active` lanes.
pub fn vectors<const D: usize, const L: usize>(
    first: impl Iterator<Item = [u32; L]>,
    active: usize,
    number: &[u32],
) -> Numbers<D, L> {
    components(first, active, |at, i| number[at as usize + i])
}

/// The same for scalar unknowns.
pub fn scalars<const D: usize, const L: usize>(
    places: impl Iterator<Item = [u32; L]>,
    active: usize,
    number: &[u32],
) -> Numbers<D, L> {
    components(places, active, |at, i| if i == 0 { number[at as usize] } else { DROP })
}

fn components<const D: usize, const L: usize>(
    first: impl Iterator<Item = [u32; L]>,
    active: usize,
    number: impl Fn(u32, usize) -> u32,
) -> Numbers<D, L> {
    let of = |l: usize, at: u32| {
        let there = l < active && at != DROP;
        std::array::from_fn(|i| if there { number(at, i) } else { DROP })
    };
    first.map(|lanes| std::array::from_fn(|l| of(l, lanes[l]))).collect()
}

impl<const D: usize, const L: usize> Numbering<D, L> {
    /// Call `visit(row, column)` for all entries of the `pairs`.
    pub fn visit(&self, pairs: &[Pair], visit: &mut dyn FnMut(u32, u32)) {
        for pair in pairs {
            let (rows, columns) = (&self.rows[pair.test.split().0], &self.columns[pair.trial.split().0]);
            for (row, column) in rows.iter().flat_map(|row| columns.iter().map(move |column| (row, column))) {
                for l in 0..L {
                    block(&row[l], &column[l], pair.diagonal, |row, column| {
                        visit(row, column);
                        0
                    });
                }
            }
        }
    }
}

/// `of(row, column)` for each entry of a block, [`DROP`] where there is none; the diagonal stands in column 0.
fn block<const D: usize>(
    rows: &[u32; D],
    columns: &[u32; D],
    diagonal: bool,
    mut of: impl FnMut(u32, u32) -> u32,
) -> [[u32; D]; D] {
    let mut table = [[DROP; D]; D];
    for i in (0..D).filter(|&i| rows[i] != DROP) {
        for j in 0..if diagonal { 1 } else { D } {
            let column = columns[if diagonal { i } else { j }];
            if column != DROP {
                table[i][j] = of(rows[i], column);
            }
        }
    }
    table
}

/// The places of the blocks of all element matrices, with the copies of those at which chunks meet.
#[derive(Debug, Default)]
pub struct Slots<const D: usize, const L: usize> {
    /// By test function φ, ψ, ξ and unknown v, u, p.
    lists: [[List<L>; 3]; 3],
    /// Entries in a row of each node, `[batch][row]`, for φ and ψ.
    strides: [Vec<[u32; L]>; 2],
    /// Places of the entries of odd blocks.
    odd: Vec<[[u32; D]; D]>,
    copies: Copies,
}

/// Places of the blocks of one pair, `[batch][row][column]`: that of the first entry, [`ODD`] with the number of an odd
/// block, or [`DROP`].
#[derive(Debug, Default)]
struct List<const L: usize> {
    places: Vec<[u32; L]>,
    /// In a batch.
    rows: usize,
    columns: usize,
    /// Rows of a block, and entries of a row.
    block: [usize; 2],
}

impl<const D: usize, const L: usize> Slots<D, L> {
    /// For the `pairs` in `batches` batches in `chunks`, whose rows and columns are numbered by `numbering`.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if they are too many to be numbered.
    pub fn new(
        batches: usize,
        chunks: &[Range<usize>],
        entries: &Entries<'_>,
        pairs: &[Pair],
        numbering: impl Fn(usize) -> Numbering<D, L>,
    ) -> Result<Slots<D, L>, SolverError> {
        let mut slots = Slots::default();
        let mut ends = vec![0];
        for batch in 0..batches {
            slots.push(entries, pairs, &numbering(batch));
            ends.push(slots.odd.len());
        }
        let Slots { lists, strides, odd, .. } = &mut slots;
        let mut writes: Vec<Writes<'_>> = vec![];
        for (lists, strides) in lists.iter_mut().zip([Some(&strides[0]), Some(&strides[1]), None]) {
            for List { places, rows, columns, block } in lists {
                let (columns, per_batch) = (*columns, *rows * *columns * L);
                writes.push(Writes {
                    indices: places.as_flattened_mut(),
                    ranges: ranges(chunks, per_batch),
                    block: *block,
                    stride: Box::new(move |n| strides.map_or(0, |list| list[n / L / columns][n % L])),
                });
            }
        }
        let of_chunk = |chunk: &Range<usize>| ends[chunk.start] * D * D..ends[chunk.end] * D * D;
        writes.push(Writes {
            indices: odd.as_flattened_mut().as_flattened_mut(),
            ranges: chunks.iter().map(of_chunk).collect(),
            block: [1, 1],
            stride: Box::new(|_| 0),
        });
        let copies = Copies::new(entries.n, chunks.len(), &mut writes)?;
        drop(writes);
        slots.copies = copies;
        Ok(slots)
    }

    /// The next batch.
    fn push(&mut self, entries: &Entries<'_>, pairs: &[Pair], numbering: &Numbering<D, L>) {
        let first = [0, 1].map(|test| self.strides[test].len());
        for (strides, rows) in self.strides.iter_mut().zip(&numbering.rows) {
            strides.resize(strides.len() + rows.len(), [0; L]);
        }
        for pair in pairs {
            let (test, trial) = (pair.test.split().0, pair.trial.split().0);
            let (rows, columns) = (&numbering.rows[test], &numbering.columns[trial]);
            let list = &mut self.lists[test][trial];
            let block_rows = if test < 2 { D } else { 1 };
            list.block = [block_rows, if trial < 2 && !pair.diagonal { D } else { 1 }];
            (list.rows, list.columns) = (rows.len(), columns.len());
            for (a, row) in rows.iter().enumerate() {
                for column in columns {
                    list.places.push(std::array::from_fn(|l| {
                        let table = block(&row[l], &column[l], pair.diagonal, |i, j| (entries.find)(i, j));
                        let mut unused = 0;
                        let stride =
                            first.get(test).map_or(&mut unused, |at| &mut self.strides[test][at + a][l]);
                        place(&table, list.block, stride).unwrap_or_else(|| {
                            self.odd.push(table);
                            ODD | (self.odd.len() - 1) as u32
                        })
                    }));
                }
            }
        }
    }

    /// Those of a test function and an unknown in one batch.
    #[inline(always)]
    pub fn of(&self, test: Test, trial: Trial, batch: usize) -> Places<'_, D, L> {
        let (test, trial) = (test.split().0, trial.split().0);
        let List { places, rows, columns, block } = &self.lists[test][trial];
        let size = rows * columns;
        let strides = self.strides.get(test).map_or(&[][..], |list| &list[batch * rows..(batch + 1) * rows]);
        Places {
            places: &places[batch * size..(batch + 1) * size],
            strides,
            odd: &self.odd,
            columns: *columns,
            width: block[1] as u32,
        }
    }

    /// Let `add` add to the entries `out` of the matrix from several threads.
    pub fn fill(&mut self, mut out: Sink<'_>, add: impl FnOnce(&Self, &Shared<'_>)) {
        let mut copies = std::mem::take(&mut self.copies);
        add(self, &copies.share_entries(out.again()));
        copies.gather_entries(out);
        self.copies = copies;
    }

    /// Bytes of the places of all batches.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        let places: usize = self.lists.as_flattened().iter().map(|list| list.places.len()).sum();
        let strides: usize = self.strides.iter().map(Vec::len).sum();
        (places + strides) * size_of::<[u32; L]>() + self.odd.len() * size_of::<[[u32; D]; D]>()
    }
}

/// The place of a block whose entries stand in `table`, by the stride of its row or, if that is 0, setting it; `None` if
/// the block is odd.
fn place<const D: usize>(
    table: &[[u32; D]; D],
    [rows, columns]: [usize; 2],
    stride: &mut u32,
) -> Option<u32> {
    let first = table[0][0];
    if table.as_flattened().iter().all(|&at| at == DROP) {
        return Some(DROP);
    }
    if rows > 1 && *stride == 0 && first != DROP && table[1][0] != DROP {
        *stride = table[1][0] - first;
    }
    let step = *stride;
    let follows = |i: usize, j: usize| table[i][j] == first.wrapping_add(i as u32 * step + j as u32);
    let regular = first != DROP && (0..rows).all(|i| (0..columns).all(|j| follows(i, j)));
    regular.then_some(first)
}

/// The places of the blocks of a test function and an unknown in one batch.
#[derive(Copy, Clone, Debug)]
pub struct Places<'a, const D: usize, const L: usize> {
    places: &'a [[u32; L]],
    strides: &'a [[u32; L]],
    odd: &'a [[[u32; D]; D]],
    columns: usize,
    width: u32,
}

impl<const D: usize, const L: usize> Places<'_, D, L> {
    /// Add to the entry of components `i` and `j` of basis functions `a` and `b`.
    #[inline(always)]
    pub fn add(&self, out: &Shared<'_>, (a, b): (usize, usize), (i, j): (usize, usize), value: &Lanes<L>) {
        let places = &self.places[a * self.columns + b];
        let j = if self.width == 1 { 0 } else { j };
        for l in 0..L {
            let at = match places[l] {
                DROP => continue,
                place @ ODD.. => self.odd[(place & !ODD) as usize][i][j],
                place if i == 0 => place + j as u32,
                place => place + i as u32 * self.stride(out, place, a, l) + j as u32,
            };
            out.add(at, value.0[l]);
        }
    }

    /// Add to the block of basis functions `a` and `b` with `R` rows and `C` columns, whose entries are `value(i, j)`.
    #[inline(always)]
    pub fn add_block<'v, const R: usize, const C: usize>(
        &self,
        out: &Shared<'_>,
        (a, b): (usize, usize),
        value: impl Fn(usize, usize) -> &'v Lanes<L>,
    ) {
        debug_assert!(C == self.width as usize);
        let places = &self.places[a * self.columns + b];
        for l in 0..L {
            let place = places[l];
            if place < ODD {
                let stride = if R > 1 { self.stride(out, place, a, l) } else { 0 };
                for i in 0..R {
                    for j in 0..C {
                        out.add(place + i as u32 * stride + j as u32, value(i, j).0[l]);
                    }
                }
            } else if place != DROP {
                let table = &self.odd[(place & !ODD) as usize];
                for (i, j) in (0..R).flat_map(|i| (0..C).map(move |j| (i, j))) {
                    out.add(table[i][j], value(i, j).0[l]);
                }
            }
        }
    }

    /// How far apart the rows of a block are.
    #[inline(always)]
    fn stride(&self, out: &Shared<'_>, place: u32, a: usize, l: usize) -> u32 {
        if out.is_copy(place) { self.width } else { self.strides[a][l] }
    }
}
