//! What every factorisation of a pattern has in common: fronts, their rows, where entries go.

use super::super::{Kind, Pattern, SolverError, Unknown};
use super::graph::{Graph, Members, lump};
use super::ordering::fronts;
use super::sizes::{Sizes, stored};
use super::tree::{Group, NONE, Price, flops};

/// Time of a front against its operations; see [`Price`].
const PRICE: Price = Price { front: 8000.0, entry: 12.0 };

/// Share of all operations below which a subtree is one task. A constant: the partition must not
/// depend on the number of threads.
const TASK: f64 = 1.0 / 64.0;

/// Entries of the factors below which a subtree is substituted by one thread: enough for a tenth of a
/// millisecond.
const SOLVE_TASK: usize = 1 << 18;

/// Consecutive rows of a child that are consecutive in its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    /// First of the child's rows below the pivots.
    pub from: u32,
    /// Its place among pivots and rows of the parent.
    pub to: u32,
    /// Number of rows.
    pub len: u32,
}

/// Entries of a row of the matrix that follow each other, and their places in a front, where they do so, too: those of
/// the components of a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entries {
    /// Position of the first in the values of the matrix.
    pub source: u32,
    /// Place of the row among pivots and rows of the front.
    pub row: u16,
    /// Place of the first column.
    pub col: u16,
    /// How many they are.
    pub len: u16,
}

impl Entries {
    /// Add a single entry to a list, or to the last of it.
    fn push(self, list: &mut Vec<Entries>) {
        match list.last_mut() {
            Some(last)
                if last.row == self.row
                    && usize::from(last.col) + usize::from(last.len) == usize::from(self.col)
                    && last.source + u32::from(last.len) == self.source =>
            {
                last.len += 1;
            }
            _ => list.push(self),
        }
    }
}

/// A front as known before any numbers.
#[derive(Debug, Default)]
pub(super) struct Shape {
    /// New number of the first pivot; the others follow.
    pub first: usize,
    /// Number of pivots.
    pub k: usize,
    /// New numbers of the rows (and columns) behind the pivots, increasing.
    pub rows: Vec<u32>,
    /// Fronts that contribute.
    pub children: Vec<u32>,
    /// Where the rows are in the parent.
    pub runs: Vec<Run>,
    /// Entries of the matrix in the columns of pivots.
    pub left: Vec<Entries>,
    /// Entries of the matrix right of the pivots.
    pub right: Vec<Entries>,
    /// Where its factors begin, L and U; that of the next front in one piece of memory for L, of the one before for U.
    pub lower: usize,
    /// The same for U.
    pub upper: usize,
    /// First front and first pivot of the subtree that ends here.
    pub subtree: (usize, usize),
    /// Front that this one contributes to; [`NONE`] for a root.
    pub parent: u32,
    /// Whether the subtree is factored by one thread.
    pub is_task: bool,
    /// Whether it is substituted by one thread.
    pub is_solve_task: bool,
}

/// Result of the analysis.
#[derive(Debug, Default)]
pub(super) struct Symbolic {
    /// Fronts, children before parents, each subtree in one piece.
    pub fronts: Vec<Shape>,
    /// Fronts without a parent.
    pub roots: Vec<u32>,
    /// Old number of each new unknown.
    pub old: Vec<u32>,
    /// Numbers to store L and U, if no pivot is delayed.
    pub stored: (usize, usize),
    /// Entries of the factors, if no pivot is delayed.
    pub fill: usize,
    /// Operations of a factorisation, if no pivot is delayed.
    pub flops: f64,
    /// Whether the matrices are symmetric positive definite: then no pivot is delayed, and U not stored.
    pub definite: bool,
}

impl Symbolic {
    /// Analyses a pattern.
    pub fn new(pattern: &Pattern, unknowns: &[Unknown], definite: bool) -> Result<Self, SolverError> {
        if u32::try_from(pattern.nnz()).is_err() {
            let message =
                format!("a matrix of {} entries, at most {} can be numbered", pattern.nnz(), u32::MAX);
            return Err(SolverError::TooLarge(message));
        }
        let (graph, members) = lump(pattern, unknowns);
        let groups = fronts(&graph, PRICE);
        let mut symbolic = Self { definite, ..Self::number(&groups, &members, unknowns) };
        symbolic.find_rows(&groups, &graph, &members);
        symbolic.find_runs();
        symbolic.find_entries(pattern)?;
        symbolic.find_tasks();
        symbolic.place_factors();
        Ok(symbolic)
    }

    /// Numbers the unknowns front by front; within a front pressures come last.
    fn number(groups: &[Group], members: &Members, unknowns: &[Unknown]) -> Self {
        let mut symbolic = Self::default();
        for (f, group) in groups.iter().enumerate() {
            let first = symbolic.old.len();
            for pressure in [false, true] {
                let all = group.vertices.iter().flat_map(|&v| members.of(v as usize));
                let is = |i: u32| unknowns[i as usize].kind == Kind::Pressure;
                symbolic.old.extend(all.filter(|&&i| is(i) == pressure));
            }
            let start = group.children.iter().map(|&c| symbolic.fronts[c as usize].subtree).min();
            symbolic.fronts.push(Shape {
                first,
                k: group.k,
                children: group.children.clone(),
                subtree: start.unwrap_or((f, first)),
                parent: NONE,
                ..Shape::default()
            });
        }
        for (f, group) in groups.iter().enumerate() {
            group.children.iter().for_each(|&c| symbolic.fronts[c as usize].parent = f as u32);
        }
        let is_root = |f: &u32| symbolic.fronts[*f as usize].parent == NONE;
        symbolic.roots = (0..groups.len() as u32).filter(is_root).collect();
        symbolic
    }

    /// New number of each old unknown.
    fn new_numbers(&self) -> Vec<u32> {
        let mut new = vec![0; self.old.len()];
        for (i, &old) in self.old.iter().enumerate() {
            new[old as usize] = i as u32;
        }
        new
    }

    /// Rows of each front: neighbours eliminated later, and what the children leave behind.
    fn find_rows(&mut self, groups: &[Group], graph: &Graph, members: &Members) {
        let new = self.new_numbers();
        let mut seen = vec![usize::MAX; self.old.len()];
        for (f, group) in groups.iter().enumerate() {
            let end = self.fronts[f].first + self.fronts[f].k;
            let mut rows = Vec::with_capacity(group.r);
            let mut put = |i: u32| {
                if i as usize >= end && seen[i as usize] != f {
                    seen[i as usize] = f;
                    rows.push(i);
                }
            };
            for &v in &group.vertices {
                for &w in graph.neighbours(v as usize) {
                    members.of(w as usize).iter().for_each(|&old| put(new[old as usize]));
                }
            }
            for &c in &group.children {
                self.fronts[c as usize].rows.iter().for_each(|&i| put(i));
            }
            rows.sort_unstable();
            debug_assert_eq!(rows.len(), group.r);
            self.fill += entries(group.k, rows.len(), self.definite);
            self.flops += flops(group.k, rows.len());
            self.fronts[f].rows = rows;
        }
    }

    /// Where the rows of each front are in its parent.
    fn find_runs(&mut self) {
        for f in 0..self.fronts.len() {
            for c in self.fronts[f].children.clone() {
                let (parent, child) = (&self.fronts[f], &self.fronts[c as usize]);
                let mut runs: Vec<Run> = Vec::new();
                let mut place = Places::of(parent);
                for (from, &i) in child.rows.iter().enumerate() {
                    let to = place.next(i) as u32;
                    match runs.last_mut() {
                        // Runs end at the parent's last pivot.
                        Some(run) if run.to + run.len == to && to as usize != parent.k => run.len += 1,
                        _ => runs.push(Run { from: from as u32, to, len: 1 }),
                    }
                }
                self.fronts[c as usize].runs = runs;
            }
        }
    }

    /// Sends every entry of the matrix to the front of its first-eliminated index.
    fn find_entries(&mut self, pattern: &Pattern) -> Result<(), SolverError> {
        let new = self.new_numbers();
        let mut front_of = vec![0_u32; self.old.len()];
        for (f, shape) in self.fronts.iter().enumerate() {
            front_of[shape.first..shape.first + shape.k].fill(f as u32);
            let m = shape.k + shape.rows.len();
            if m > usize::from(u16::MAX) {
                let message = format!("a front of {m} rows of the factorisation, at most {} fit", u16::MAX);
                return Err(SolverError::TooLarge(message));
            }
        }
        // Entries by fronts, in one block of memory that is given back: (entry, row).
        let mut ends = vec![0; self.fronts.len()];
        let front =
            |i: usize, source: usize| front_of[new[i].min(new[pattern.column(i, source) as usize]) as usize];
        let each = |visit: &mut dyn FnMut(usize, usize)| {
            (0..pattern.n).for_each(|i| pattern.row(i).for_each(|source| visit(i, source)));
        };
        each(&mut |i, source| ends[front(i, source) as usize] += 1);
        let mut start = 0;
        for end in &mut ends {
            (*end, start) = (start, start + *end);
        }
        let mut all = vec![(0_u32, 0_u32); pattern.nnz()];
        each(&mut |i, source| {
            let at = &mut ends[front(i, source) as usize];
            all[*at] = (source as u32, i as u32);
            *at += 1;
        });
        let mut local = vec![0_u16; self.old.len()];
        let (mut left, mut right) = (vec![], vec![]);
        let mut start = 0;
        for (shape, end) in self.fronts.iter_mut().zip(ends) {
            let pivots = shape.first as u32..(shape.first + shape.k) as u32;
            for (at, i) in pivots.chain(shape.rows.iter().copied()).enumerate() {
                local[i as usize] = at as u16;
            }
            left.clear();
            right.clear();
            for &(source, row) in &all[start..end] {
                let column = pattern.column(row as usize, source as usize);
                let row = local[new[row as usize] as usize];
                let col = local[new[column as usize] as usize];
                let list = if usize::from(col) < shape.k { &mut left } else { &mut right };
                Entries { source, row, col, len: 1 }.push(list);
            }
            (shape.left, shape.right) = (left.as_slice().to_vec(), right.as_slice().to_vec());
            start = end;
        }
        Ok(())
    }

    /// Marks subtrees that are small enough for one thread.
    fn find_tasks(&mut self) {
        let mut work: Vec<f64> = Vec::with_capacity(self.fronts.len());
        let mut fill: Vec<usize> = Vec::with_capacity(self.fronts.len());
        for f in 0..self.fronts.len() {
            let Shape { k, rows, children, .. } = &self.fronts[f];
            let below: f64 = children.iter().map(|&c| work[c as usize]).sum();
            work.push(below + flops(*k, rows.len()));
            let below: usize = children.iter().map(|&c| fill[c as usize]).sum();
            fill.push(below + k * (k + 2 * rows.len()));
            self.fronts[f].is_task = work[f] <= TASK * self.flops;
            self.fronts[f].is_solve_task = fill[f] <= SOLVE_TASK;
        }
    }

    /// L from the first front to the last, U from the last to the first: as they are read.
    fn place_factors(&mut self) {
        let (mut lower, mut upper) = (0, 0);
        for shape in &mut self.fronts {
            let sizes = Sizes::whole(shape.k, shape.rows.len());
            let (n_lower, n_upper) = stored(sizes, self.definite);
            shape.lower = lower;
            lower += n_lower;
            upper += n_upper;
            shape.upper = upper;
        }
        self.fronts.iter_mut().for_each(|shape| shape.upper = upper - shape.upper);
        self.stored = (lower, upper);
    }
}

/// Entries of the factors of a front with `k` pivots and `r` rows behind.
pub(super) fn entries(k: usize, r: usize, definite: bool) -> usize {
    if definite { k * (k + 1) / 2 + k * r } else { k * (k + 2 * r) }
}

/// Places of increasing numbers in a front.
struct Places<'a> {
    shape: &'a Shape,
    at: usize,
}

impl<'a> Places<'a> {
    fn of(shape: &'a Shape) -> Self {
        Self { shape, at: 0 }
    }

    fn next(&mut self, i: u32) -> usize {
        let Shape { first, k, rows, .. } = self.shape;
        if (i as usize) < first + k {
            return i as usize - first;
        }
        while rows[self.at] != i {
            self.at += 1;
        }
        k + self.at
    }
}
