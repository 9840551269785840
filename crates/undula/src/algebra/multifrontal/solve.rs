//! Forward and backward substitution over the tree of fronts.
//!
//! Vectors follow the fronts: each front has a piece of its own, children hand their sums to the
//! parent and read from it. So subtrees are independent, and sums are always taken in one order.

use super::front::{Front, padded};
use super::kernels::{gemv_sub, gemv_transposed_sub};
use super::real::Real;
use super::symbolic::{Run, Symbolic};
use pulp::{Arch, Simd, WithSimd};

/// Pivots applied at a time: as many columns of the factors are read side by side.
const BLOCK: usize = 8;

/// One pass over the tree.
pub(super) struct Solve<'a> {
    pub symbolic: &'a Symbolic,
    pub arch: Arch,
}

impl Solve<'_> {
    /// Forward substitution in the subtrees that end with the given fronts; `b` belongs to them, as do
    /// `fronts`. The result stays in the fronts.
    pub fn forward<T: Real>(&self, ends: &[u32], fronts: &mut [Front<T>], b: &[T]) {
        match ends {
            [] => {}
            [f] => {
                let shape = &self.symbolic.fronts[*f as usize];
                if shape.is_task {
                    self.arch.dispatch(ForwardTask { solve: self, f: *f as usize, fronts, b });
                } else {
                    let below = fronts.len() - 1;
                    self.forward(&shape.children, &mut fronts[..below], &b[..b.len() - shape.k]);
                    self.arch.dispatch(ForwardStep { solve: self, f: *f as usize, fronts, b });
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
    pub fn backward<T: Real>(&self, ends: &[u32], fronts: &mut [Front<T>], x: &mut [T], parent: Parent<T>) {
        match ends {
            [] => {}
            [f] => {
                let shape = &self.symbolic.fronts[*f as usize];
                if shape.is_task {
                    self.arch.dispatch(BackwardTask { solve: self, f: *f as usize, fronts, x, parent });
                } else {
                    self.arch.dispatch(BackwardStep { solve: self, f: *f as usize, fronts, x, parent });
                    let Some((front, below)) = fronts.split_last_mut() else { return };
                    let n = x.len() - shape.k;
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
    solve: &'a Solve<'b>,
    f: usize,
    fronts: &'a mut [Front<T>],
    b: &'a [T],
}

impl<T: Real> WithSimd for ForwardTask<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let shape = &self.solve.symbolic.fronts[self.f];
        let (start, first) = shape.subtree;
        for g in start..=self.f {
            let end = self.solve.symbolic.fronts[g].first + self.solve.symbolic.fronts[g].k;
            forward(simd, self.solve.symbolic, g, &mut self.fronts[..=g - start], &self.b[..end - first]);
        }
    }
}

struct ForwardStep<'a, 'b, T> {
    solve: &'a Solve<'b>,
    f: usize,
    fronts: &'a mut [Front<T>],
    b: &'a [T],
}

impl<T: Real> WithSimd for ForwardStep<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        forward(simd, self.solve.symbolic, self.f, self.fronts, self.b);
    }
}

struct BackwardTask<'a, 'b, T> {
    solve: &'a Solve<'b>,
    f: usize,
    fronts: &'a mut [Front<T>],
    x: &'a mut [T],
    parent: Parent<'a, T>,
}

impl<T: Real> WithSimd for BackwardTask<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let symbolic = self.solve.symbolic;
        let (start, first) = symbolic.fronts[self.f].subtree;
        let last = self.f - start;
        for g in (0..=last).rev() {
            let shape = &symbolic.fronts[start + g];
            let (now, later) = self.fronts.split_at_mut(g + 1);
            let x = &mut self.x[..shape.first + shape.k - first];
            if g == last {
                backward(simd, symbolic, start + g, &mut now[g], x, self.parent);
            } else {
                let p = shape.parent as usize;
                let (front, k) = (&later[p - start - g - 1], symbolic.fronts[p].k);
                let parent = Parent { known: &front.work, k, shift: front.k - k };
                backward(simd, symbolic, start + g, &mut now[g], x, parent);
            }
        }
    }
}

struct BackwardStep<'a, 'b, T> {
    solve: &'a Solve<'b>,
    f: usize,
    fronts: &'a mut [Front<T>],
    x: &'a mut [T],
    parent: Parent<'a, T>,
}

impl<T: Real> WithSimd for BackwardStep<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if let Some(front) = self.fronts.last_mut() {
            backward(simd, self.solve.symbolic, self.f, front, self.x, self.parent);
        }
    }
}

/// Front `f`, the last of `fronts`, whose right-hand side is the end of `b`.
#[inline(always)]
fn forward<T: Real, S: Simd>(simd: S, symbolic: &Symbolic, f: usize, fronts: &mut [Front<T>], b: &[T]) {
    let shape = &symbolic.fronts[f];
    let Some((front, below)) = fronts.split_last_mut() else { return };
    let offset = f - below.len();
    let (k, r, e, ld) = (front.k, front.r, front.e, front.ld());
    let mut x = std::mem::take(&mut front.work);
    x.clear();
    x.resize(k + padded(r), T::ZERO);
    x[..shape.k].copy_from_slice(&b[b.len() - shape.k..]);
    for &c in &shape.children {
        let child = &below[c as usize - offset];
        let (delayed, rows) = child.work[child.e..].split_at(child.delayed());
        x[child.delayed_to..][..delayed.len()].copy_from_slice(delayed);
        for run in &symbolic.fronts[c as usize].runs {
            let to = place(run, shape.k, k - shape.k);
            let from = &rows[run.from as usize..][..run.len as usize];
            x[to..][..from.len()].iter_mut().zip(from).for_each(|(x, v)| *x += *v);
        }
    }
    gather(&front.row_from, &mut x, &mut front.spare);
    let mut j = 0;
    while j < e {
        let width = (e - j).min(BLOCK);
        let (now, later) = x[j..].split_at_mut(width);
        for p in 0..width {
            let factor = now[p];
            let lower = &front.panel[(j + p) * ld + j + p + 1..][..width - p - 1];
            now[p + 1..].iter_mut().zip(lower).for_each(|(x, l)| *x -= *l * factor);
        }
        gemv_sub(simd, (&front.panel[j * ld + j + width..], ld), now, later);
        j += width;
    }
    front.work = x;
}

/// Front `f`; its solution goes to the end of `x`.
#[inline(always)]
fn backward<T: Real, S: Simd>(
    simd: S,
    symbolic: &Symbolic,
    f: usize,
    front: &mut Front<T>,
    x: &mut [T],
    parent: Parent<T>,
) {
    let shape = &symbolic.fronts[f];
    let (k, r, e, ld) = (front.k, front.r, front.e, front.ld());
    let mut y = std::mem::take(&mut front.work);
    let (pivots, rest) = y.split_at_mut(e);
    let (delayed, rows) = rest.split_at_mut(k - e);
    delayed.copy_from_slice(&parent.known[front.delayed_to..][..k - e]);
    for run in &shape.runs {
        let from = place(run, parent.k, parent.shift);
        let len = run.len as usize;
        rows[run.from as usize..][..len].copy_from_slice(&parent.known[from..][..len]);
    }
    gemv_transposed_sub(simd, (&front.upper, padded(r)), &rows[..r], pivots);
    gemv_sub(simd, (&front.panel[e * ld..], ld), delayed, pivots);
    let mut end = e;
    while end > 0 {
        let j = (end - 1) / BLOCK * BLOCK;
        let (before, now) = pivots[..end].split_at_mut(j);
        for p in (0..end - j).rev() {
            let column = &front.panel[(j + p) * ld + j..][..p + 1];
            now[p] /= column[p];
            let factor = now[p];
            now[..p].iter_mut().zip(column).for_each(|(x, u)| *x -= *u * factor);
        }
        gemv_sub(simd, (&front.panel[j * ld..], ld), now, before);
        end = j;
    }
    scatter(&front.col_from, &mut y, &mut front.spare);
    let n = x.len();
    x[n - shape.k..].copy_from_slice(&y[..shape.k]);
    front.work = y;
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
    spare.extend(from.iter().map(|&i| x[i as usize]));
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
