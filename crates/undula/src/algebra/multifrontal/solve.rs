//! Forward and backward substitution over the tree of fronts.
//!
//! Vectors follow the fronts: each front has a piece of its own, children hand their sums to the
//! parent and read from it. So subtrees are independent, and sums are always taken in one order.
//! Where a right-hand side is zero in a whole subtree, there is nothing to do on the way up.

use super::definite;
use super::dense;
use super::factors::Factors;
use super::front::Front;
use super::kernels::flush;
use super::prefetch::prefetch;
use super::real::Real;
use super::sizes::{SLACK, padded};
use super::symbolic::{Run, Shape, Symbolic};
use crate::algebra::vectors::dispatch;
use pulp::{Arch, Simd, WithSimd};

/// One pass over the tree.
pub(super) struct Solve<'a, T> {
    pub symbolic: &'a Symbolic,
    pub factors: &'a Factors<T>,
    pub arch: Arch,
}

impl<T: Real> Solve<'_, T> {
    /// Forward substitution in the subtrees that end with the given fronts; `b` belongs to them, as do
    /// `fronts`. The result stays in the fronts.
    pub fn forward(&self, ends: &[u32], fronts: &mut [Front<T>], b: &[T]) {
        match ends {
            [] => {}
            [f] => {
                let shape = &self.symbolic.fronts[*f as usize];
                if shape.is_solve_task {
                    dispatch(self.arch, ForwardTask { solve: self, f: *f as usize, fronts, b });
                } else {
                    let below = fronts.len() - 1;
                    self.forward(&shape.children, &mut fronts[..below], &b[..b.len() - shape.k]);
                    if let Some(front) = collect(self.symbolic, *f as usize, fronts, b) {
                        let mut work = std::mem::take(&mut front.work);
                        dense::forward_large(self.arch, self.factors.lower(shape, front), &mut work);
                        front.work = work;
                    }
                }
            }
            _ => {
                let (left, right) = ends.split_at(ends.len() / 2);
                let (n_fronts, n_pivots) = self.size(left);
                let (fronts_left, fronts_right) = fronts.split_at_mut(n_fronts);
                let (b_left, b_right) = b.split_at(n_pivots);
                rayon::join(
                    || self.forward(left, fronts_left, b_left),
                    || self.forward(right, fronts_right, b_right),
                );
            }
        }
    }

    /// Backward substitution, from the fronts to `x`; `parent` is what the parent of the subtrees knows,
    /// by its assembled columns.
    pub fn backward(&self, ends: &[u32], fronts: &mut [Front<T>], x: &mut [T], parent: Parent<T>) {
        match ends {
            [] => {}
            [f] => {
                let shape = &self.symbolic.fronts[*f as usize];
                if shape.is_solve_task {
                    let f = *f as usize;
                    if self.symbolic.definite {
                        dispatch(self.arch, BackwardTask::<T, true> { solve: self, f, fronts, x, parent });
                    } else {
                        dispatch(self.arch, BackwardTask::<T, false> { solve: self, f, fronts, x, parent });
                    }
                } else {
                    let Some((front, below)) = fronts.split_last_mut() else { return };
                    look_up(shape, front, parent);
                    let mut work = std::mem::take(&mut front.work);
                    if self.symbolic.definite {
                        definite::backward_large(self.arch, self.factors.lower(shape, front), &mut work);
                    } else {
                        dense::backward_large(self.arch, self.factors.upper(shape, front), &mut work);
                    }
                    front.work = work;
                    let n = x.len() - shape.k;
                    hand_out(shape, front, x);
                    let parent = Parent { known: &front.work, k: shape.k, shift: front.k - shape.k };
                    self.backward(&shape.children, below, &mut x[..n], parent);
                }
            }
            _ => {
                let (left, right) = ends.split_at(ends.len() / 2);
                let (n_fronts, n_pivots) = self.size(left);
                let (fronts_left, fronts_right) = fronts.split_at_mut(n_fronts);
                let (x_left, x_right) = x.split_at_mut(n_pivots);
                rayon::join(
                    || self.backward(left, fronts_left, x_left, parent),
                    || self.backward(right, fronts_right, x_right, parent),
                );
            }
        }
    }

    /// Fronts and pivots of neighbouring subtrees.
    fn size(&self, ends: &[u32]) -> (usize, usize) {
        let of = |f: &u32| {
            let shape = &self.symbolic.fronts[*f as usize];
            (*f as usize + 1 - shape.subtree.0, shape.first + shape.k - shape.subtree.1)
        };
        ends.iter().map(of).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
    }
}

/// Solution on the columns of a front, in the order in which they were assembled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parent<'a, T> {
    pub known: &'a [T],
    /// Pivots of its own; delayed ones follow and shift the rest.
    pub k: usize,
    pub shift: usize,
}

struct ForwardTask<'a, 'b, T> {
    solve: &'a Solve<'b, T>,
    f: usize,
    fronts: &'a mut [Front<T>],
    b: &'a [T],
}

impl<T: Real> WithSimd for ForwardTask<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Solve { symbolic, factors, .. } = *self.solve;
        let (start, first) = symbolic.fronts[self.f].subtree;
        for g in start..=self.f {
            let shape = &symbolic.fronts[g];
            let end = shape.first + shape.k;
            if let Some(next) = self.fronts[..=self.f - start].get(g - start + 1) {
                let shape = &symbolic.fronts[g + 1];
                prefetch(factors.lower(shape, next).all());
                prefetch(&next.work);
                prefetch(&shape.runs);
            }
            let fronts = &mut self.fronts[..=g - start];
            if let Some(front) = collect(symbolic, g, fronts, &self.b[..end - first]) {
                let mut work = std::mem::take(&mut front.work);
                dense::forward(simd, factors.lower(shape, front), &mut work);
                front.work = work;
            }
        }
    }
}

/// With U, or with L twice. Two programs: the compiler makes a slower one of both.
struct BackwardTask<'a, 'b, T, const DEFINITE: bool> {
    solve: &'a Solve<'b, T>,
    f: usize,
    fronts: &'a mut [Front<T>],
    x: &'a mut [T],
    parent: Parent<'a, T>,
}

impl<T: Real, const DEFINITE: bool> WithSimd for BackwardTask<'_, '_, T, DEFINITE> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Solve { symbolic, factors, .. } = *self.solve;
        let (start, first) = symbolic.fronts[self.f].subtree;
        let last = self.f - start;
        for g in (0..=last).rev() {
            let shape = &symbolic.fronts[start + g];
            if g > 0 {
                let (shape, front) = (&symbolic.fronts[start + g - 1], &self.fronts[g - 1]);
                prefetch(&front.work);
                prefetch(&shape.runs);
                if DEFINITE {
                    prefetch(factors.lower(shape, front).all());
                } else {
                    prefetch(factors.upper(shape, front).all());
                }
            }
            let (now, later) = self.fronts.split_at_mut(g + 1);
            if g == last {
                look_up(shape, &mut now[g], self.parent);
            } else {
                let p = shape.parent as usize;
                let (front, k) = (&later[p - start - g - 1], symbolic.fronts[p].k);
                look_up(shape, &mut now[g], Parent { known: &front.work, k, shift: front.k - k });
            }
            let mut work = std::mem::take(&mut now[g].work);
            if DEFINITE {
                definite::backward(simd, factors.lower(shape, &now[g]), &mut work);
            } else {
                dense::backward(simd, factors.upper(shape, &now[g]), &mut work);
            }
            now[g].work = work;
            hand_out(shape, &mut now[g], &mut self.x[..shape.first + shape.k - first]);
        }
    }
}

/// Right-hand side of front `f`, the last of `fronts`: the end of `b`, and what its children leave.
/// Returns the front, or nothing if that is zero and substituted already.
#[inline(always)]
fn collect<'a, T: Real>(
    symbolic: &Symbolic,
    f: usize,
    fronts: &'a mut [Front<T>],
    b: &[T],
) -> Option<&'a mut Front<T>> {
    let shape = &symbolic.fronts[f];
    let (front, below) = fronts.split_last_mut()?;
    let offset = f - below.len();
    let own = &b[b.len() - shape.k..];
    let x = &mut front.work;
    x.clear();
    x.resize(front.k + padded(front.r) + SLACK, T::ZERO);
    front.is_zero = own.iter().all(|v| *v == T::ZERO);
    x[..shape.k].copy_from_slice(own);
    for &c in &shape.children {
        let child = &below[c as usize - offset];
        if child.is_zero {
            continue;
        }
        front.is_zero = false;
        let (delayed, rows) = child.work[child.e..].split_at(child.delayed());
        x[child.delayed_to..][..delayed.len()].copy_from_slice(delayed);
        for run in &symbolic.fronts[c as usize].runs {
            let to = place(run, shape.k, front.k - shape.k);
            let from = &rows[run.from as usize..][..run.len as usize];
            for (x, v) in x[to..][..from.len()].iter_mut().zip(from) {
                *x += *v;
            }
        }
    }
    if front.is_zero {
        return None;
    }
    flush(x);
    if front.moved.0 {
        gather(&front.row_from, x, &mut front.spare);
    }
    Some(front)
}

/// What the parent knows of the solution behind the pivots.
#[inline(always)]
fn look_up<T: Real>(shape: &Shape, front: &mut Front<T>, parent: Parent<T>) {
    let (delayed, rows) = front.work[front.e..].split_at_mut(front.k - front.e);
    delayed.copy_from_slice(&parent.known[front.delayed_to..][..delayed.len()]);
    for run in &shape.runs {
        let from = place(run, parent.k, parent.shift);
        let len = run.len as usize;
        rows[run.from as usize..][..len].copy_from_slice(&parent.known[from..][..len]);
    }
    // To the end of the last vector.
    rows[front.r..].fill(T::ZERO);
}

/// The solution of a front, to the end of `x`.
#[inline(always)]
fn hand_out<T: Real>(shape: &Shape, front: &mut Front<T>, x: &mut [T]) {
    if front.moved.1 {
        scatter(&front.col_from, &mut front.work, &mut front.spare);
    }
    let n = x.len();
    x[n - shape.k..].copy_from_slice(&front.work[..shape.k]);
}

/// Place of a run in the parent, behind its delayed pivots if it is not among its own.
#[inline(always)]
fn place(run: &Run, k: usize, shift: usize) -> usize {
    let to = run.to as usize;
    if to < k { to } else { to + shift }
}

/// x[i] ← x[from[i]] for the pivots.
#[inline(always)]
fn gather<T: Real>(from: &[u32], x: &mut [T], spare: &mut Vec<T>) {
    spare.clear();
    spare.resize(from.len(), T::ZERO);
    for (v, &i) in spare.iter_mut().zip(from) {
        *v = x[i as usize];
    }
    x[..from.len()].copy_from_slice(spare);
}

/// x[from[i]] ← x[i] for the pivots.
#[inline(always)]
fn scatter<T: Real>(from: &[u32], x: &mut [T], spare: &mut Vec<T>) {
    spare.clear();
    spare.extend_from_slice(&x[..from.len()]);
    for (&i, v) in from.iter().zip(spare) {
        x[i as usize] = *v;
    }
}
