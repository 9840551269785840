//! The smoother: the systems of groups of cells, solved one colour after the other (Vanka, J. Comput. Phys. 65, 1986).

use super::clusters::colours;
use super::envelope::{Envelope, Row, Work};
use super::lists::Lists;
use super::matrix::Matrix;
use super::number::Number;
use crate::algebra::{Csr, Pattern, Value, Vectors};
use rayon::prelude::*;

/// Blocks of unknowns with the factors of their systems.
#[derive(Clone, Debug)]
pub struct Smoother<T: Number> {
    /// Unknowns of each block, in the order of elimination.
    unknowns: Lists<u32>,
    /// Rows of each block in its factors.
    spans: Vec<[u32; 2]>,
    /// Where the factors of each block begin.
    starts: Vec<usize>,
    factors: Vec<T::Entry>,
    /// Of each row in its factors.
    rows: Vec<Row<T>>,
    /// Blocks of each colour: they have no unknown in common.
    colours: Vec<Vec<u32>>,
    /// Corrections of all blocks.
    work: Vec<T>,
    vectors: Vectors,
}

impl<T: Number> Smoother<T> {
    /// Blocks with these unknowns, for matrices of `pattern`.
    pub fn new(unknowns: Lists<u32>, pattern: &Pattern) -> Smoother<T> {
        let envelopes: Vec<Envelope> = (0..unknowns.len())
            .into_par_iter()
            .map_init(
                || Work::new(pattern.n),
                |work, block| Envelope::new(pattern, unknowns.get(block), work),
            )
            .collect();
        let mut starts = vec![0];
        let mut spans = Vec::with_capacity(unknowns.items().len());
        for Envelope { spans: rows, size } in envelopes {
            starts.push(starts[starts.len() - 1] + size);
            spans.extend(rows);
        }
        let colours = colours(&unknowns, pattern.n);
        let work = vec![T::default(); unknowns.items().len()];
        let factors = vec![T::Entry::default(); starts[starts.len() - 1]];
        let rows = vec![Row::default(); unknowns.items().len()];
        Smoother { factors, rows, unknowns, spans, starts, colours, work, vectors: Vectors::new() }
    }

    /// Unknowns of the largest block.
    pub fn largest(&self) -> usize {
        self.unknowns.iter().map(<[u32]>::len).max().unwrap_or(0)
    }

    /// Bytes of the factors.
    pub fn bytes(&self) -> usize {
        size_of::<T::Entry>() * self.factors.len() + size_of::<Row<T>>() * self.rows.len()
    }

    /// Floating point operations of a factorisation, about.
    pub fn flops(&self) -> f64 {
        self.spans.iter().map(|[first, end]| f64::from(end - first).powi(2) / 2.0).sum()
    }

    /// Factorise the blocks of `a`.
    pub fn factor<S: Value>(&mut self, a: &Csr<S>) {
        let Smoother { unknowns, spans, starts, factors, rows, vectors, .. } = self;
        let mut parts = vec![];
        let (mut rest, mut others) = (&mut factors[..], &mut rows[..]);
        for block in 0..unknowns.len() {
            let (part, behind) = rest.split_at_mut(starts[block + 1] - starts[block]);
            let (rows, below) = others.split_at_mut(unknowns.get(block).len());
            parts.push((block, (rows, part)));
            (rest, others) = (behind, below);
        }
        parts.into_par_iter().for_each_init(
            || Work::new(a.pattern.n),
            |work, (block, out)| {
                let (list, first) = (unknowns.get(block), unknowns.start(block));
                Envelope::factor(&spans[first..first + list.len()], a, list, work, *vectors, out);
            },
        );
    }

    /// Solve the blocks of `matrix` x = `b`, each with the others as they are.
    pub fn sweep(&mut self, matrix: &Matrix<T>, b: &[T], x: &mut [T]) {
        let Smoother { unknowns, spans, starts, factors, rows, colours, work, vectors } = self;
        for colour in &*colours {
            let mut parts = Vec::with_capacity(colour.len());
            let (mut rest, mut behind) = (&mut work[..], 0);
            for &block in colour {
                let block = block as usize;
                let (first, len) = (unknowns.start(block), unknowns.get(block).len());
                let (part, others) = rest.split_at_mut(first - behind).1.split_at_mut(len);
                parts.push((block, part));
                (rest, behind) = (others, first + len);
            }
            let seen = &*x;
            parts.par_iter_mut().with_min_len(4).for_each(|(block, correction)| {
                let first = unknowns.start(*block);
                let (spans, rows) =
                    (&spans[first..first + correction.len()], &rows[first..first + correction.len()]);
                let factors = &factors[starts[*block]..starts[*block + 1]];
                vectors.run(
                    #[inline(always)]
                    || {
                        matrix.residual_of(unknowns.get(*block), b, seen, correction);
                        Envelope::solve(spans, rows, factors, correction);
                    },
                );
            });
            for (block, correction) in parts {
                unknowns.get(block).iter().zip(&*correction).for_each(|(&row, c)| x[row as usize] += *c);
            }
        }
    }
}
