//! Dense kernels for large fronts: faer's, on tiles that run in parallel.
//!
//! Tiles depend on sizes only, and faer works on each alone; so threads change nothing in the result.

use super::real::Real;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::{Accum, MatMut, MatRef, Par};

/// Smallest depth and size for which faer's product is faster than our own.
pub(super) const PRODUCT: (usize, usize) = (16, 96);

/// Smallest number of pivots and of rows for which its triangular solve is.
pub(super) const SOLVE: (usize, usize) = (128, 256);

/// Columns of a tile.
const TILE: usize = 256;

/// `C ← −A B`.
pub(super) fn product<T: Real>(c: MatMut<T>, a: MatRef<T>, b: MatRef<T>) {
    multiply(c, Accum::Replace, a, b);
}

/// `C ← C − A B`.
pub(super) fn subtract<T: Real>(c: MatMut<T>, a: MatRef<T>, b: MatRef<T>) {
    multiply(c, Accum::Add, a, b);
}

fn multiply<T: Real>(c: MatMut<T>, accum: Accum, a: MatRef<T>, b: MatRef<T>) {
    if let Some(at) = split(c.ncols()) {
        let (c_left, c_right) = c.split_at_col_mut(at);
        let (b_left, b_right) = b.split_at_col(at);
        rayon::join(|| multiply(c_left, accum, a, b_left), || multiply(c_right, accum, a, b_right));
    } else {
        matmul(c, accum, a, b, -T::ONE, Par::Seq);
    }
}

/// Eliminates the rows of `X`: its first ones by the square on top of `lower`, the others by what is
/// below it.
pub(super) fn solve_upper<T: Real>(lower: MatRef<T>, x: MatMut<T>) {
    if let Some(at) = split(x.ncols()) {
        let (left, right) = x.split_at_col_mut(at);
        rayon::join(|| solve_upper(lower, left), || solve_upper(lower, right));
        return;
    }
    let (pivots, delayed) = (lower.ncols(), x.nrows() - lower.ncols());
    let (mut done, rest) = x.split_at_row_mut(pivots);
    solve_unit_lower_triangular_in_place(lower.subrows(0, pivots), done.as_mut(), Par::Seq);
    if delayed > 0 {
        matmul(rest, Accum::Add, lower.subrows(pivots, delayed), done.as_ref(), -T::ONE, Par::Seq);
    }
}

/// Where to cut columns into tiles.
fn split(columns: usize) -> Option<usize> {
    (columns >= 2 * TILE).then(|| (columns / TILE).div_ceil(2) * TILE)
}
