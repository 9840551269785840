//! Element matrices by differences of element residuals, as section 5.2.3 of the book makes them.
//!
//! Every unknown of a cell is raised by h, the residual of the cell is evaluated anew, and the quotient
//! (A(U + h W)(Φ) − A(U)(Φ)) / h is a column of the element matrix. For comparison with the other tangents: a residual
//! for each column costs more than a direction at a point does, and differences of sums cancel more. One cell at a
//! time, like the other tangents that are rarely taken.
#![allow(non_snake_case)]

use crate::math::{Lanes, Tensor, Vector};
use crate::physics::{Fields, Place, StepRule, Tested};
use crate::tangent::{Difference, StepForm, Tangent};

/// Work space of one thread; empty until it is needed.
#[derive(Default)]
pub(super) struct Nodal<const D: usize, const L: usize> {
    /// Element matrices, `[column][row]` in the order v, u, p; zero in padded lanes.
    pub(super) matrix: Vec<Lanes<L>>,
    pub(super) cell: Cell<D>,
}

impl<const D: usize, const L: usize> Nodal<D, L> {
    /// The element matrices of the last batch, if `tangent` asks for those.
    pub(super) fn asked(&self, tangent: Tangent) -> Option<&[Lanes<L>]> {
        tangent.nodal().map(|_| &self.matrix[..])
    }
}

/// One cell at both ends of the step.
#[derive(Default)]
pub(super) struct Cell<const D: usize> {
    pub(super) v: Vec<Vector<f64, D>>,
    /// Empty without deformation.
    pub(super) u: Vec<Vector<f64, D>>,
    pub(super) p: Vec<f64>,
    /// v and u of the old time.
    pub(super) old: [Vec<Vector<f64, D>>; 2],
    pub(super) points: Vec<CellPoint<D>>,
    /// Pressure basis, `[point][basis]`.
    pub(super) pressure: Vec<f64>,
    /// Residual `[v, u, p]`.
    pub(super) rows: Vec<f64>,
    /// That of the iterate itself.
    pub(super) base: Vec<f64>,
}

/// One quadrature point of a cell.
pub(super) struct CellPoint<const D: usize> {
    pub(super) inverse: Tensor<f64, D>,
    pub(super) weight: f64,
    pub(super) place: Place<f64, D>,
    pub(super) new: Fields<f64, D>,
    pub(super) old: Fields<f64, D>,
}

/// What every residual of a region needs: its equations, the step, the basis `[point][basis][1 + D]`, and whether what
/// a fixed-point iteration keeps stays that of the iterate.
pub(super) struct Equations<'a, F> {
    pub(super) form: &'a F,
    pub(super) rule: &'a StepRule,
    pub(super) basis: &'a [f64],
    pub(super) lagged: bool,
}

/// Σ c_a φ_a and its gradient with respect to x; `basis` is `[a][1 + D]` at the point.
#[inline(never)]
pub(super) fn interpolate<const D: usize>(
    basis: &[f64],
    c: &[Vector<f64, D>],
    inverse: &Tensor<f64, D>,
) -> (Vector<f64, D>, Tensor<f64, D>) {
    let (mut value, mut reference) = (Vector::zero(), Tensor::zero());
    for (c, b) in c.iter().zip(basis.chunks_exact(1 + D)) {
        for i in 0..D {
            value.0[i] += b[0] * c.0[i];
            for d in 0..D {
                reference.0[i][d] += b[1 + d] * c.0[i];
            }
        }
    }
    (value, reference * *inverse)
}

impl<const D: usize> Cell<D> {
    /// Gradients of the basis functions at all points \[1/m\].
    pub(super) fn gradients<'a>(&'a self, basis: &'a [f64]) -> impl Iterator<Item = Vector<f64, D>> + 'a {
        let of_points = self.points.iter().zip(basis.chunks_exact(self.v.len() * (1 + D)));
        of_points.flat_map(|(point, basis)| {
            let reference = |b: &[f64]| Vector(std::array::from_fn(|d| b[1 + d]));
            basis.chunks_exact(1 + D).map(move |b| point.inverse.t() * reference(b))
        })
    }

    /// The fields of the present unknowns at point `q`.
    #[inline(never)]
    pub(super) fn fields(&self, basis: &[f64], q: usize) -> Fields<f64, D> {
        let (inverse, m) = (&self.points[q].inverse, self.p.len());
        let (v, grad_v) = interpolate(basis, &self.v, inverse);
        let (u, grad_u) = interpolate(basis, &self.u, inverse);
        let p = self.pressure[q * m..(q + 1) * m].iter().zip(&self.p).map(|(b, c)| b * c).sum();
        Fields { v, grad_v, u, grad_u, p }
    }

    /// A(U)(Φ) of the present unknowns for all test functions of the cell.
    #[inline(never)]
    pub(super) fn residual<F: StepForm<D>>(&mut self, of: &Equations<'_, F>) {
        let (n, m) = (self.v.len(), self.p.len());
        let mut rows = std::mem::take(&mut self.rows);
        rows.fill(0.0);
        for (q, (point, basis)) in self.points.iter().zip(of.basis.chunks_exact(n * (1 + D))).enumerate() {
            let new = self.fields(basis, q);
            let lag = if of.lagged { point.new } else { new };
            let mut place = point.place;
            place.force += place.force_slope * (lag.u - point.new.u);
            let mut r = Tested::zero();
            of.form.residual(of.rule, &place, &new, &lag, &point.old, &mut r);
            let (inverse_t, w) = (point.inverse.t(), point.weight);
            let (phi, psi) = (r.grad_phi * inverse_t, r.grad_psi * inverse_t);
            for (a, b) in basis.chunks_exact(1 + D).enumerate() {
                for i in 0..D {
                    let along = |value: f64, grad: &[f64; D]| {
                        w * (0..D).fold(b[0] * value, |sum, d| sum + b[1 + d] * grad[d])
                    };
                    rows[a * D + i] += along(r.phi.0[i], &phi.0[i]);
                    rows[(n + a) * D + i] += along(r.psi.0[i], &psi.0[i]);
                }
            }
            for (row, b) in rows[2 * n * D..].iter_mut().zip(&self.pressure[q * m..(q + 1) * m]) {
                *row += w * b * r.xi;
            }
        }
        self.rows = rows;
    }

    /// Call `put` with every column of the element matrix, \[v, u, p\]. With `with_u` u has columns of its own; else it
    /// moves by `coupling` times v.
    #[inline(never)]
    pub(super) fn columns<F: StepForm<D>>(
        &mut self,
        of: &Equations<'_, F>,
        by: &Difference,
        (with_u, coupling): (bool, f64),
        put: &mut dyn FnMut(usize, &[f64]),
    ) {
        let n = self.v.len() * D;
        let steps = by.steps(self.gradients(of.basis));
        self.residual(of);
        std::mem::swap(&mut self.rows, &mut self.base);
        for column in 0..2 * n + self.p.len() {
            let field = (column / n).min(2);
            if field == 1 && !with_u {
                continue;
            }
            let h = steps[field];
            let before = self.raise(column, h);
            // In the condensed system u follows v.
            let follows = (field == 0 && coupling != 0.0).then(|| self.raise(n + column, coupling * h));
            self.residual(of);
            *self.unknown(column) = before;
            if let Some(before) = follows {
                *self.unknown(n + column) = before;
            }
            for (moved, base) in self.rows.iter_mut().zip(&self.base) {
                *moved = (*moved - base) / h;
            }
            put(column, &self.rows);
        }
    }

    /// The number of the unknown `column` in the order v, u, p.
    pub(super) fn unknown(&mut self, column: usize) -> &mut f64 {
        let n = self.v.len();
        match column / (n * D) {
            0 => &mut self.v[column / D].0[column % D],
            1 => &mut self.u[column / D - n].0[column % D],
            _ => &mut self.p[column - 2 * n * D],
        }
    }

    /// Raise an unknown by `h`; returns what it was.
    pub(super) fn raise(&mut self, column: usize, h: f64) -> f64 {
        let unknown = self.unknown(column);
        let before = *unknown;
        *unknown += h;
        before
    }
}
