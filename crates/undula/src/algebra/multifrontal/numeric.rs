//! Assembly and elimination over the tree of fronts.

use super::super::{Csr, Scaling};
use super::buffer::Buffer;
use super::front::{Front, Scratch};
use super::kernels::flushed;
use super::real::Real;
use super::sizes::{SLACK, Sizes, padded, stored};
use super::symbolic::{Run, Shape, Symbolic};
use crate::algebra::vectors::dispatch;
use pulp::{Arch, Simd, WithSimd};
use std::sync::{Mutex, PoisonError};

/// Memory for contributions and scratch, returned after use.
#[derive(Debug)]
pub(super) struct Pool<T> {
    /// By size: class `c` holds vectors of capacity `class_size(c)` at least.
    rest: Vec<Mutex<Vec<Buffer<T>>>>,
    scratch: Mutex<Vec<Scratch<T>>>,
}

/// Sizes grow by quarters of powers of two.
fn class_of(n: usize) -> usize {
    let n = n.max(8);
    let power = n.ilog2() as usize;
    4 * power + ((n - (1 << power)) * 4).div_ceil(1 << power)
}

fn class_size(class: usize) -> usize {
    (1 << (class / 4)) + (class % 4) * (1 << (class / 4)) / 4
}

fn pop<T>(stack: &Mutex<Vec<T>>) -> Option<T> {
    stack.lock().unwrap_or_else(PoisonError::into_inner).pop()
}

fn push<T>(stack: &Mutex<Vec<T>>, value: T) {
    stack.lock().unwrap_or_else(PoisonError::into_inner).push(value);
}

impl<T: Real> Pool<T> {
    pub fn new() -> Self {
        Self { rest: (0..256).map(|_| Mutex::default()).collect(), scratch: Mutex::default() }
    }

    fn lend(&self, n: usize) -> Buffer<T> {
        if n == 0 {
            return Buffer::default();
        }
        let class = class_of(n);
        pop(&self.rest[class]).unwrap_or_else(|| Buffer::with_capacity(class_size(class)))
    }

    /// `mine` if it has memory for `n` numbers, else another buffer for it.
    fn exchange(&self, mine: &mut Buffer<T>, n: usize) -> Buffer<T> {
        let mine = std::mem::take(mine);
        if mine.capacity() >= n {
            return mine;
        }
        self.give_back(mine);
        self.lend(n)
    }

    fn give_back(&self, v: Buffer<T>) {
        if v.capacity() > 0 {
            // Rounded down: the capacity may be larger than asked for.
            let mut class = class_of(v.capacity());
            if class_size(class) > v.capacity() {
                class -= 1;
            }
            push(&self.rest[class], v);
        }
    }
}

/// One factorisation.
pub(super) struct Numeric<'a, T> {
    pub symbolic: &'a Symbolic,
    pub a: &'a Csr,
    /// Scales of rows and columns.
    pub scaling: &'a Scaling,
    pub pool: &'a Pool<T>,
    pub arch: Arch,
}

impl<T: Real> Numeric<'_, T> {
    /// Factors the subtree that ends with front `f`.
    ///
    /// Subtrees run in any order on any thread; but every front adds its children in their order, so
    /// that all numbers are the same.
    pub fn subtree(&self, f: usize, mut part: Part<T>) {
        let shape = &self.symbolic.fronts[f];
        let start = shape.subtree.0;
        if shape.is_task {
            let mut scratch = pop(&self.pool.scratch).unwrap_or_default();
            for g in start..=f {
                self.front(g, part.up_to(self.symbolic, start, g), &mut scratch);
            }
            push(&self.pool.scratch, scratch);
        } else {
            if start < f {
                self.subtrees(&shape.children, part.up_to(self.symbolic, start, f - 1));
            }
            let mut scratch = pop(&self.pool.scratch).unwrap_or_default();
            self.front(f, part, &mut scratch);
            push(&self.pool.scratch, scratch);
        }
    }

    /// Factors neighbouring subtrees, given by their last fronts.
    pub fn subtrees(&self, ends: &[u32], part: Part<T>) {
        match ends {
            [] => {}
            [f] => self.subtree(*f as usize, part),
            _ => {
                let (left, right) = ends.split_at(ends.len() / 2);
                let first = self.symbolic.fronts[left[0] as usize].subtree.0;
                let middle = self.symbolic.fronts[right[0] as usize].subtree.0;
                let (part_left, part_right) = part.split(self.symbolic, first, middle);
                rayon::join(|| self.subtrees(left, part_left), || self.subtrees(right, part_right));
            }
        }
    }

    /// Assembles and eliminates front `f`, the last of `part`; the others include its children.
    fn front(&self, f: usize, part: Part<T>, scratch: &mut Scratch<T>) {
        let shape = &self.symbolic.fronts[f];
        let (n_lower, n_upper) = stored(Sizes::whole(shape.k, shape.rows.len()), self.symbolic.definite);
        let lower = part.lower.len() - n_lower;
        if let Some((front, below)) = part.fronts.split_last_mut() {
            let lower = &mut part.lower[lower..];
            let upper = &mut part.upper[..n_upper];
            dispatch(self.arch, FrontStep { numeric: self, f, front, below, lower, upper, scratch });
        }
    }
}

/// Neighbouring fronts and the memory of their factors.
pub(super) struct Part<'a, T> {
    pub fronts: &'a mut [Front<T>],
    pub lower: &'a mut [T],
    pub upper: &'a mut [T],
}

impl<T> Part<'_, T> {
    /// The fronts from `first`, the first of all, to `last`.
    fn up_to(&mut self, symbolic: &Symbolic, first: usize, last: usize) -> Part<'_, T> {
        let end = |f: usize| symbolic.fronts.get(f).map_or(symbolic.stored.0, |shape| shape.lower);
        let top = first + self.fronts.len() - 1;
        Part {
            fronts: &mut self.fronts[..=last - first],
            lower: &mut self.lower[..end(last + 1) - end(first)],
            upper: &mut self.upper[symbolic.fronts[last].upper - symbolic.fronts[top].upper..],
        }
    }
}

impl<'a, T> Part<'a, T> {
    /// The fronts from `first`, the first of all, and those from `middle`.
    fn split(self, symbolic: &Symbolic, first: usize, middle: usize) -> (Self, Self) {
        let last = first + self.fronts.len() - 1;
        let at = |f: usize| (symbolic.fronts[f].lower, symbolic.fronts[f].upper);
        let (fronts, right_fronts) = self.fronts.split_at_mut(middle - first);
        let (lower, right_lower) = self.lower.split_at_mut(at(middle).0 - at(first).0);
        let (right_upper, upper) = self.upper.split_at_mut(at(middle - 1).1 - at(last).1);
        let right = Part { fronts: right_fronts, lower: right_lower, upper: right_upper };
        (Part { fronts, lower, upper }, right)
    }
}

struct FrontStep<'a, 'b, T> {
    numeric: &'a Numeric<'b, T>,
    f: usize,
    front: &'a mut Front<T>,
    below: &'a mut [Front<T>],
    lower: &'a mut [T],
    upper: &'a mut [T],
    scratch: &'a mut Scratch<T>,
}

impl<T: Real> WithSimd for FrontStep<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { numeric, f, front, below, lower, upper, scratch } = self;
        let Numeric { symbolic, a, scaling, pool, .. } = *numeric;
        let shape = &symbolic.fronts[f];
        let offset = f - below.len();
        let mut delayed = 0;
        for &c in &shape.children {
            let child = &mut below[c as usize - offset];
            child.delayed_to = shape.k + delayed;
            delayed += child.delayed();
        }
        let (k, r) = (shape.k + delayed, shape.rows.len());
        let panel = pool.exchange(&mut scratch.panel, k * (k + padded(r)) + SLACK);
        let right = pool.exchange(&mut scratch.upper, k * padded(r) + SLACK);
        front.reset(k, r, panel, right, pool.lend(r * padded(r)));
        add_entries(shape, front, delayed, symbolic, a, scaling, scratch);
        for &c in &shape.children {
            let child = &below[c as usize - offset];
            add_to_pivots(shape, front, delayed, &symbolic.fronts[c as usize].runs, child);
        }
        front.eliminate(simd, symbolic.definite, scratch);
        front.put_away(Sizes::whole(shape.k, r), symbolic.definite, lower, upper);
        if front.delayed() == 0 {
            scratch.panel = std::mem::take(&mut front.panel);
            scratch.upper = std::mem::take(&mut front.upper);
        }
        // The rest starts as the product of the factors; so it need not be zero before.
        for &c in &shape.children {
            let child = &mut below[c as usize - offset];
            add_to_rest(shape, front, &symbolic.fronts[c as usize].runs, child);
            for buffer in [&mut child.rest, &mut child.panel, &mut child.upper] {
                pool.give_back(std::mem::take(buffer));
            }
        }
    }
}

/// Adds the scaled entries of the matrix that belong to a front.
#[inline(always)]
fn add_entries<T: Real>(
    shape: &Shape,
    front: &mut Front<T>,
    delayed: usize,
    symbolic: &Symbolic,
    a: &Csr,
    scaling: &Scaling,
    scratch: &mut Scratch<T>,
) {
    let (k, ld, ldu) = (shape.k, front.ld(), padded(front.r));
    let Scratch { row_scale, col_scale, .. } = scratch;
    row_scale.clear();
    col_scale.clear();
    for i in (shape.first..shape.first + k).chain(shape.rows.iter().map(|&i| i as usize)) {
        let old = symbolic.old[i] as usize;
        row_scale.push(scaling.row[old]);
        col_scale.push(scaling.col[old]);
    }
    let value =
        |source: usize, i: usize, j: usize| flushed(T::of(a.values[source] * row_scale[i] * col_scale[j]));
    // Loops, not adapters: those are not always inlined where vectors are wide.
    let panel = &mut front.panel[..];
    for of in &shape.left {
        let (source, i, j) = (of.source as usize, usize::from(of.row), usize::from(of.col));
        let row = i + if i < k { 0 } else { delayed };
        for n in 0..usize::from(of.len) {
            panel[(j + n) * ld + row] += value(source + n, i, j + n);
        }
    }
    let upper = &mut front.upper[..];
    for of in &shape.right {
        let (source, i, j) = (of.source as usize, usize::from(of.row), usize::from(of.col));
        for n in 0..usize::from(of.len) {
            upper[i * ldu + j + n - k] += value(source + n, i, j + n);
        }
    }
}

/// Adds the contribution of a child to rows and columns of pivots.
#[inline(always)]
fn add_to_pivots<T: Real>(
    shape: &Shape,
    front: &mut Front<T>,
    delayed: usize,
    runs: &[Run],
    child: &Front<T>,
) {
    let (k, ld, ldu, ldc) = (shape.k, front.ld(), padded(front.r), padded(child.r));
    let (pivot_runs, rest_runs) = split_runs(runs, k);
    for columns in pivot_runs {
        for j in 0..columns.len as usize {
            let from = &child.rest[(columns.from as usize + j) * ldc..][..ldc];
            let to = &mut front.panel[(columns.to as usize + j) * ld..][..ld];
            add_runs(pivot_runs, 0, from, to);
            add_runs(rest_runs, delayed, from, to);
        }
    }
    for rows in pivot_runs {
        for i in 0..rows.len as usize {
            let to = &mut front.upper[(rows.to as usize + i) * ldu..][..ldu];
            let from = &child.rest[rows.from as usize + i..];
            for columns in rest_runs {
                let to = &mut to[columns.to as usize - k..][..columns.len as usize];
                let from = from[columns.from as usize * ldc..].iter().step_by(ldc);
                for (t, f) in to.iter_mut().zip(from) {
                    *t += flushed(*f);
                }
            }
        }
    }
    if child.delayed() > 0 {
        add_delayed(shape, front, delayed, runs, child);
    }
}

/// Adds the contribution of a child to what is left behind the pivots.
#[inline(always)]
fn add_to_rest<T: Real>(shape: &Shape, front: &mut Front<T>, runs: &[Run], child: &Front<T>) {
    let (k, ldu, ldc) = (shape.k, padded(front.r), padded(child.r));
    let (_, rest_runs) = split_runs(runs, k);
    for columns in rest_runs {
        for j in 0..columns.len as usize {
            let from = &child.rest[(columns.from as usize + j) * ldc..][..ldc];
            let to = &mut front.rest[(columns.to as usize + j - k) * ldu..][..ldu];
            for run in rest_runs {
                let len = run.len as usize;
                add(&from[run.from as usize..][..len], &mut to[run.to as usize - k..][..len]);
            }
        }
    }
}

/// Runs among the pivots of the parent, and behind them.
#[inline(always)]
fn split_runs(runs: &[Run], k: usize) -> (&[Run], &[Run]) {
    runs.split_at(runs.partition_point(|run| (run.to as usize) < k))
}

#[inline(always)]
fn add_runs<T: Real>(runs: &[Run], shift: usize, from: &[T], to: &mut [T]) {
    for run in runs {
        let len = run.len as usize;
        add(&from[run.from as usize..][..len], &mut to[run.to as usize + shift..][..len]);
    }
}

#[inline(always)]
fn add<T: Real>(from: &[T], to: &mut [T]) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += flushed(*f);
    }
}

/// Adds the rows and columns of the pivots that a child has delayed.
#[cold]
fn add_delayed<T: Real>(shape: &Shape, front: &mut Front<T>, delayed: usize, runs: &[Run], child: &Front<T>) {
    let (k, ld, ldu) = (shape.k, front.ld(), padded(front.r));
    let (ld_child, ldu_child) = (child.ld(), padded(child.r));
    for d in 0..child.delayed() {
        let place = child.delayed_to + d;
        let from = &child.panel[(child.e + d) * ld_child..][..ld_child];
        let to = &mut front.panel[place * ld..][..ld];
        add(&from[child.e..child.k], &mut to[child.delayed_to..][..child.delayed()]);
        let row = &child.upper[(child.e + d) * ldu_child..][..ldu_child];
        for run in runs {
            let shift = if (run.to as usize) < k { 0 } else { delayed };
            let len = run.len as usize;
            add(&from[child.k + run.from as usize..][..len], &mut to[run.to as usize + shift..][..len]);
        }
        for run in runs {
            for (i, value) in row[run.from as usize..][..run.len as usize].iter().enumerate() {
                let j = run.to as usize + i;
                if j < k {
                    front.panel[j * ld + place] += *value;
                } else {
                    front.upper[place * ldu + j - k] += *value;
                }
            }
        }
    }
}
