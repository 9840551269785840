//! Factors of small sparse matrices within their envelopes, without pivoting.

use super::number::Number;
use crate::algebra::{Csr, Value, Vectors};

/// A pivot below this part of what it is a sum of is rounding: the unknown is left out.
const NO_PIVOT: f64 = 1e-11;

/// Where the factors of one matrix have entries.
#[derive(Clone, Debug)]
pub struct Envelope {
    /// First and last entry of each row.
    pub spans: Vec<[u32; 2]>,
    /// Number of entries.
    pub size: usize,
}

/// Space for a factorisation.
#[derive(Default)]
pub struct Work {
    local: Vec<u32>,
    matrix: Vec<f64>,
    starts: Vec<isize>,
    scales: Vec<f64>,
}

/// What the entries of a row are multiples of.
#[derive(Copy, Clone, Debug, Default)]
pub struct Row<T> {
    /// S.
    scale: T,
    /// The pivot of the scaled matrix, or 0 for an unknown that is left out.
    sign: T,
    /// Units of L and of U.
    units: [T; 2],
}

impl Work {
    /// For matrices of `n` rows.
    pub fn new(n: usize) -> Work {
        Work { local: vec![u32::MAX; n], ..Work::default() }
    }

    /// Call `visit(row, column, entry)` for the entries of a pattern between the unknowns of `list`.
    fn entries(
        local: &mut [u32],
        a: &crate::algebra::Pattern,
        list: &[u32],
        mut visit: impl FnMut(usize, usize, usize),
    ) {
        list.iter().zip(0..).for_each(|(&unknown, at)| local[unknown as usize] = at);
        for (row, &unknown) in list.iter().enumerate() {
            for at in a.row(unknown as usize) {
                let column = local[a.column(unknown as usize, at) as usize];
                if column != u32::MAX {
                    visit(row, column as usize, at);
                }
            }
        }
        list.iter().for_each(|&unknown| local[unknown as usize] = u32::MAX);
    }
}

impl Envelope {
    /// Of the matrices of `pattern` between the unknowns of `list`, in their order.
    pub fn new(pattern: &crate::algebra::Pattern, list: &[u32], work: &mut Work) -> Envelope {
        let n = list.len();
        let mut first: Vec<u32> = (0..n as u32).collect();
        Work::entries(&mut work.local, pattern, list, |row, column, _| {
            let (low, high) = (row.min(column), row.max(column));
            first[high] = first[high].min(low as u32);
        });
        let mut last: Vec<u32> = (0..n as u32).collect();
        for (row, &first) in first.iter().enumerate() {
            last[first as usize] = row as u32;
        }
        for row in 1..n {
            last[row] = last[row].max(last[row - 1]).max(row as u32);
        }
        let spans: Vec<[u32; 2]> =
            first.into_iter().zip(last).map(|(first, last)| [first, last + 1]).collect();
        let size = spans.iter().map(|[first, end]| (end - first) as usize).sum();
        Envelope { spans, size }
    }

    /// The factors of S A S between the unknowns of `list`, where S makes their pivots 1 or −1: row by row, L in front
    /// of its diagonal of 1, U behind it.
    pub fn factor<T: Number, S: Value>(
        spans: &[[u32; 2]],
        a: &Csr<S>,
        list: &[u32],
        work: &mut Work,
        vectors: Vectors,
        (rows, out): (&mut [Row<T>], &mut [T::Entry]),
    ) {
        let Work { local, matrix, starts, scales } = work;
        matrix.clear();
        matrix.resize(out.len(), 0.0);
        starts.clear();
        let mut start = 0;
        for &[first, end] in spans {
            // Column j of the row is at its start plus j.
            starts.push(start as isize - first as isize);
            start += (end - first) as usize;
        }
        let at = |row: usize, column: usize| (starts[row] + column as isize) as usize;
        Work::entries(local, &a.pattern, list, |row, column, entry| {
            matrix[at(row, column)] = a.values[entry].double()
        });
        vectors.run(
            #[inline(always)]
            || decompose(spans, starts, matrix),
        );
        let scale = |row: usize| match matrix[at(row, row)].abs() {
            0.0 => 1.0,
            inverse => inverse.sqrt(),
        };
        scales.clear();
        scales.extend((0..spans.len()).map(scale));
        let mut start = 0;
        for (row, &[first, end]) in spans.iter().enumerate() {
            let [first, end] = [first as usize, end as usize];
            let here = &mut matrix[start..start + end - first];
            let out = &mut out[start..start + end - first];
            start += end - first;
            let (scale, inverse) = (scales[row], here[row - first]);
            let (lower, upper) = here.split_at_mut(row - first);
            lower.iter_mut().zip(&scales[first..]).for_each(|(x, other)| *x *= scale / other);
            let upper = &mut upper[1..];
            upper.iter_mut().zip(&scales[row + 1..]).for_each(|(x, other)| *x *= inverse * other / scale);
            let (below, behind) = out.split_at_mut(row - first);
            rows[row] = Row {
                scale: T::of(scale),
                sign: T::of(if inverse == 0.0 { 0.0 } else { inverse.signum() }),
                units: [keep::<T>(lower, below), keep::<T>(upper, &mut behind[1..])],
            };
        }
    }

    /// `x ← A⁻¹ x` by the factors.
    #[inline(always)]
    pub fn solve<T: Number>(spans: &[[u32; 2]], rows: &[Row<T>], factors: &[T::Entry], x: &mut [T]) {
        let mut start = 0;
        for (row, (&[first, end], by)) in spans.iter().zip(rows).enumerate() {
            let first = first as usize;
            let lower = &factors[start..start + row - first];
            x[row] = x[row] * by.scale - by.units[0] * dot(lower, &x[first..row]);
            start += end as usize - first;
        }
        for (row, (&[first, end], by)) in spans.iter().zip(rows).enumerate().rev() {
            start -= (end - first) as usize;
            let at = start + row - first as usize;
            let upper = &factors[at + 1..start + (end - first) as usize];
            x[row] = x[row] * by.sign - by.units[1] * dot(upper, &x[row + 1..end as usize]);
        }
        x.iter_mut().zip(rows).for_each(|(x, by)| *x = *x * by.scale);
    }
}

/// Keep `list` in `out`; returns the unit of its entries.
fn keep<T: Number>(list: &[f64], out: &mut [T::Entry]) -> T {
    let largest = list.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let unit = T::unit(largest);
    if unit > 0.0 {
        out.iter_mut().zip(list).for_each(|(out, x)| *out = T::entry(x / unit));
    } else {
        out.fill(T::Entry::default());
    }
    T::of(unit)
}

/// Rows of U that are subtracted from a row together.
const TOGETHER: usize = 4;

/// L and U in place of a matrix whose row `i` has its column `j` at `starts[i]` + j: row after row, each less those above.
#[inline(always)]
fn decompose(spans: &[[u32; 2]], starts: &[isize], matrix: &mut [f64]) {
    let at = |row: usize, column: usize| (starts[row] + column as isize) as usize;
    for row in 0..spans.len() {
        let [first, end] = spans[row].map(|column| column as usize);
        let (above, rest) = matrix.split_at_mut(at(row, first));
        let here = &mut rest[..end - first];
        // What the pivot is a sum of, without signs.
        let mut size = here[row - first].abs();
        let mut k = first;
        while k < row {
            let count = if k + TOGETHER <= row { TOGETHER } else { 1 };
            // Later rows of U end later: these columns are in all of them.
            let behind = spans[k][1] as usize;
            let mut factors = [0.0; TOGETHER];
            for i in 0..count {
                let (pivot, last) = (k + i, spans[k + i][1] as usize);
                let upper = &above[at(pivot, pivot)..at(pivot, pivot) + last - pivot];
                let factor = here[pivot - first] * upper[0];
                here[pivot - first] = factor;
                size += (factor * upper[row - pivot]).abs();
                factors[i] = factor;
                subtract(factor, &upper[1..k + count - pivot], &mut here[pivot + 1 - first..]);
                subtract(factor, &upper[behind - pivot..], &mut here[behind - first..]);
            }
            let upper = |i: usize| &above[at(k + i, k + count)..at(k + i, behind)];
            let part = &mut here[k + count - first..behind - first];
            if count == 1 {
                subtract(factors[0], upper(0), part);
            } else {
                let rows: [&[f64]; TOGETHER] = std::array::from_fn(upper);
                let rows = rows.map(|row| &row[..part.len()]);
                for (i, x) in part.iter_mut().enumerate() {
                    let sum = factors[0] * rows[0][i] + factors[1] * rows[1][i];
                    *x -= sum + (factors[2] * rows[2][i] + factors[3] * rows[3][i]);
                }
            }
            k += count;
        }
        let pivot = &mut here[row - first];
        *pivot = if pivot.abs() > NO_PIVOT * size { 1.0 / *pivot } else { 0.0 };
    }
}

/// `x ← x − factor y` as far as `y` goes.
#[inline(always)]
fn subtract(factor: f64, y: &[f64], x: &mut [f64]) {
    if factor != 0.0 {
        x.iter_mut().zip(y).for_each(|(x, y)| *x -= factor * y);
    }
}

/// Products that are summed side by side, in so many vectors as long as rows last.
const WIDTH: usize = 8;
const VECTORS: usize = 4;

/// The sum of products, in parts.
#[inline(always)]
fn dot<T: Number>(entries: &[T::Entry], x: &[T]) -> T {
    let mut parts = [[T::default(); WIDTH]; VECTORS];
    let (ones, twos) = (entries.chunks_exact(WIDTH * VECTORS), x.chunks_exact(WIDTH * VECTORS));
    let (rest, others) = (ones.remainder(), twos.remainder());
    for (a, b) in ones.zip(twos) {
        for (v, part) in parts.iter_mut().enumerate() {
            for i in 0..WIDTH {
                part[i] += T::units(a[v * WIDTH + i]) * b[v * WIDTH + i];
            }
        }
    }
    let [mut sums, ..] = parts;
    for i in 0..WIDTH {
        sums[i] += parts[1][i];
        sums[i] += parts[2][i];
        sums[i] += parts[3][i];
    }
    let (ones, twos) = (rest.chunks_exact(WIDTH), others.chunks_exact(WIDTH));
    let last = ones.remainder().iter().zip(twos.remainder()).map(|(a, b)| T::units(*a) * *b);
    let mut sum: T = last.sum();
    for (a, b) in ones.zip(twos) {
        for i in 0..WIDTH {
            sums[i] += T::units(a[i]) * b[i];
        }
    }
    sums.iter().for_each(|part| sum += *part);
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::Pattern;
    use std::sync::Arc;

    fn solved<T: Number>(envelope: &Envelope, a: &Csr, list: &[u32], product: &[f64]) -> Vec<f64> {
        let mut rows = vec![Row::default(); list.len()];
        let mut factors = vec![T::Entry::default(); envelope.size];
        let mut work = Work::new(a.pattern.n);
        Envelope::factor::<T, f64>(
            &envelope.spans,
            a,
            list,
            &mut work,
            Vectors::new(),
            (&mut rows, &mut factors),
        );
        let mut x: Vec<T> = list.iter().map(|&row| T::of(product[row as usize])).collect();
        Envelope::solve(&envelope.spans, &rows, &factors, &mut x);
        x.into_iter().map(Value::double).collect()
    }

    /// A tridiagonal matrix with a far entry and a zero on its diagonal, behind the unknown that it depends on.
    #[test]
    fn factors_solve_their_system() {
        let n = 9;
        let rows: Vec<Vec<u32>> = (0..n as u32)
            .map(|i| (i.saturating_sub(1)..(i + 2).min(n as u32)).chain((i == 7).then_some(2)).collect())
            .collect();
        let pattern = Arc::new(Pattern::from_rows(&rows));
        let mut a = Csr::zeros(&pattern);
        for i in 0..n {
            for at in pattern.row(i) {
                let j = pattern.column(i, at) as usize;
                a.values[at] =
                    if i == j { if i == 4 { 0.0 } else { 3.0 } } else { 1.0 / (1 + i + 2 * j) as f64 };
            }
        }
        // Rows 1 to 8 in another order.
        let list = [3, 1, 2, 5, 4, 6, 8, 7];
        let mut work = Work::new(n);
        let envelope = Envelope::new(&pattern, &list, &mut work);
        let solution: Vec<f64> = (0..n).map(|i| if i == 0 { 0.0 } else { (i as f64).sin() }).collect();
        let mut product = vec![0.0; n];
        a.mul(&solution, &mut product);
        // Entries in 16 and in 64 bits.
        let found: [Vec<f64>; 2] =
            [solved::<f32>(&envelope, &a, &list, &product), solved::<f64>(&envelope, &a, &list, &product)];
        for (x, tolerance) in found.iter().zip([1e-4, 1e-14]) {
            for (x, &row) in x.iter().zip(&list) {
                let exact = solution[row as usize];
                assert!((x - exact).abs() < tolerance, "{row}: {x} for {exact}");
            }
        }
        assert!(envelope.size < list.len() * list.len());
    }
}
