//! Values and gradients at all points of a batch, and testing with all basis functions.

use super::super::evaluate::AtPoint;
use super::super::width::Task;
use crate::element::LineTable;
use crate::math::{Lanes, Vector};

/// Vectors of work space in `dim` dimensions: two halves of `dim` arrays each.
pub fn work(line: &LineTable, dim: usize) -> usize {
    2 * dim * line.n_basis.max(line.n_points).pow(dim as u32)
}

/// `Σ_a c_a φ_a` and its reference gradient at all points.
pub struct InterpolateTask<'a, const D: usize, const L: usize> {
    /// Basis in one coordinate.
    pub line: &'a LineTable,
    /// Coefficients.
    pub c: &'a [Vector<Lanes<L>, D>],
    /// What comes out, `[point]`.
    pub at: &'a mut [AtPoint<D, L>],
    /// Work space of [`work`] vectors.
    pub work: &'a mut [Vector<Lanes<L>, D>],
}

impl<const D: usize, const L: usize> Task for InterpolateTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        match self.line.n_basis {
            3 if const { D == 3 } => interpolate::<3, D, L>(self),
            4 => interpolate::<4, D, L>(self),
            5 if const { D < 3 } => interpolate::<5, D, L>(self),
            n => unreachable!("{n} basis functions"),
        }
    }
}

/// `r_a = Σ_q (value, φ_a) + (grad, ∇φ_a)` for all basis functions.
pub struct TestTask<'a, const D: usize, const L: usize> {
    /// Basis in one coordinate.
    pub line: &'a LineTable,
    /// What stands before the test functions, weighted, `[point]`.
    pub at: &'a [AtPoint<D, L>],
    /// What comes out.
    pub r: &'a mut [Vector<Lanes<L>, D>],
    /// Work space of [`work`] vectors.
    pub work: &'a mut [Vector<Lanes<L>, D>],
}

impl<const D: usize, const L: usize> Task for TestTask<'_, D, L> {
    #[inline(always)]
    fn run(self) {
        match self.line.n_basis {
            3 if const { D == 3 } => test::<3, D, L>(self),
            4 => test::<4, D, L>(self),
            5 if const { D < 3 } => test::<5, D, L>(self),
            n => unreachable!("{n} basis functions"),
        }
    }
}

/// Rows of the tables of one coordinate, `[point][basis]`.
#[inline(always)]
pub(super) fn rows<const N: usize>(line: &LineTable) -> (&[[f64; N]], &[[f64; N]]) {
    (line.value.as_chunks().0, line.slope.as_chunks().0)
}

/// `Σ_a b_a x_a` with the `N` of `x` that are `step` apart, for the rows b of `table`: `put(q, sum)`.
#[inline(always)]
fn along<const N: usize, const D: usize, const L: usize>(
    table: &[[f64; N]],
    x: &[Vector<Lanes<L>, D>],
    step: usize,
    mut put: impl FnMut(usize, Vector<Lanes<L>, D>),
) {
    let mut line = [Vector::zero(); N];
    for a in 0..N {
        line[a] = x[a * step];
    }
    for (q, b) in table.iter().enumerate() {
        let mut sum = Vector::<Lanes<L>, D>::zero();
        for a in 0..N {
            for i in 0..D {
                sum.0[i].add_product(b[a], line[a].0[i]);
            }
        }
        put(q, sum);
    }
}

/// First coordinate first. Before coordinate d, array 0 has values and array k = 1, …, d − 1 derivatives with respect
/// to ξ_k, each of them `[a_D]…[a_d][q_{d-1}]…[q_1]`.
#[inline(always)]
fn interpolate<const N: usize, const D: usize, const L: usize>(task: InterpolateTask<'_, D, L>) {
    let InterpolateTask { line, c, at, work } = task;
    let (tables, m) = (rows::<N>(line), line.n_points);
    let size = work.len() / (2 * D);
    let (mut from, mut to) = work.split_at_mut(size * D);
    let mut inner = 1;
    for d in 0..D - 1 {
        let outer = N.pow((D - 1 - d) as u32);
        for kind in 0..d + 2 {
            let (table, k) = if kind == d + 1 { (tables.1, 0) } else { (tables.0, kind) };
            let from = if d == 0 { c } else { &from[k * size..] };
            let to = &mut to[kind * size..];
            for o in 0..outer {
                for s in 0..inner {
                    along(table, &from[o * N * inner + s..], inner, |q, x| to[(o * m + q) * inner + s] = x);
                }
            }
        }
        (from, to) = (to, from);
        inner *= m;
    }
    for kind in 0..D + 1 {
        let (table, k) = if kind == D { (tables.1, 0) } else { (tables.0, kind) };
        for s in 0..inner {
            along(table, &from[k * size + s..], inner, |q, x| at[q * inner + s].set(kind, x));
        }
    }
}

/// `sums[a] += b_a x`.
#[inline(always)]
fn add<const N: usize, const D: usize, const L: usize>(
    sums: &mut [Vector<Lanes<L>, D>; N],
    b: &[f64; N],
    x: &Vector<Lanes<L>, D>,
) {
    for a in 0..N {
        for i in 0..D {
            sums[a].0[i].add_product(b[a], x.0[i]);
        }
    }
}

/// The transpose of [`interpolate`], last coordinate first.
#[inline(always)]
fn test<const N: usize, const D: usize, const L: usize>(task: TestTask<'_, D, L>) {
    let TestTask { line, at, r, work } = task;
    let ((value, slope), m) = (rows::<N>(line), line.n_points);
    let size = work.len() / (2 * D);
    let (mut from, mut to) = work.split_at_mut(size * D);
    let mut inner = m.pow((D - 1) as u32);
    for k in 0..D {
        for s in 0..inner {
            let mut sums = [Vector::zero(); N];
            for q in 0..m {
                let at = &at[q * inner + s];
                add(&mut sums, &value[q], &at.part(k));
                if k == 0 {
                    add(&mut sums, &slope[q], &at.part(D));
                }
            }
            for a in 0..N {
                from[k * size + a * inner + s] = sums[a];
            }
        }
    }
    for d in (0..D - 1).rev() {
        inner /= m;
        for k in 0..d + 1 {
            for line in 0..N.pow((D - 1 - d) as u32) * inner {
                let (o, s) = (line / inner, line % inner);
                let mut sums = [Vector::zero(); N];
                for q in 0..m {
                    let place = (o * m + q) * inner + s;
                    add(&mut sums, &value[q], &from[k * size + place]);
                    if k == 0 {
                        add(&mut sums, &slope[q], &from[(d + 1) * size + place]);
                    }
                }
                for a in 0..N {
                    to[k * size + (o * N + a) * inner + s] = sums[a];
                }
            }
        }
        (from, to) = (to, from);
    }
    let n = r.len();
    r.copy_from_slice(&from[..n]);
}
