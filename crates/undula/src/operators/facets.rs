//! Terms on facets whose traction depends on v and u: ⟨t(v, u), φ⟩_Γ, weighed over the step, with its derivatives. There
//! are few facets, so they are done one by one in `f64`.
//!
//! A term of this kind is a [`FacetTerm`]: `outflow.rs`, `backflow.rs`, `pressure.rs`.

use super::columns::Columns;
use super::instant::{fields, stretch};
use super::{DataTime, End, Entries, How, Matrix, NotFinite, Operator, StepView};
use crate::algebra::{Sink, SolverError};
use crate::loops::scatter::DROP;
use crate::math::Vector;
use crate::mesh::{Facet, Side};
use crate::physics::FacetForm;
use crate::physics::axisymmetric::Seen;
use crate::sampling::{FacetPoint, facet_points};
use crate::space::{FsiSpace, Region};
use crate::tangent::{self, FacetByHand, Linearization, Tangent};

/// What acts at the points of facets.
pub trait FacetTerm<const D: usize>: Send + Sync {
    /// The weak form at a point.
    type Form: FacetByHand<D> + FacetByHand<3>;

    /// Whether the form takes ∂_t u of the step in place of u. Its term at the old time then depends on the new state, so
    /// that it belongs to the residual. Around an axis it knows nothing of u_r/r then: its traction must be one per area of
    /// the boundary in motion, and is taken (r + u_r)/r times.
    const RATE: bool = false;

    /// Whether the form depends on v, and on u or ∂_t u.
    const DEPENDS: [bool; 2];

    /// The form at a point, which has a number among all points, with the data of one end of the step.
    fn form(&self, point: usize, end: End) -> Self::Form;

    /// Take prescribed data of the time `at` for `points`, in the order of their numbers.
    ///
    /// # Errors
    /// If they are not finite: where, and what they are.
    fn set_data<'a>(
        &mut self,
        _at: &DataTime,
        _points: impl Iterator<Item = &'a FacetPoint<D>>,
    ) -> Result<(), ([f64; D], [f64; D])> {
        Ok(())
    }
}

/// A facet as the body sees it.
pub(super) struct SeenFacet<const D: usize> {
    pub(super) side: Side,
    /// Its boundary of the mesh.
    boundary: u16,
    /// Nodes of the cell.
    pub(super) nodes: Vec<u32>,
    pub(super) points: Vec<FacetPoint<D>>,
    /// Number of the first point.
    first: usize,
}

/// A term on the facets of a body.
pub struct FacetOperator<T, const D: usize> {
    pub(super) term: T,
    body: Region,
    pub(super) facets: Vec<SeenFacet<D>>,
    /// Which of v and u the whole matrix has columns of.
    fields: Vec<usize>,
    /// `[facet][row a, i][column b, j][field]`.
    slots: Vec<u32>,
    n_v: usize,
}

/// Weight, τ and the end whose data hold: the term at (1 − τ) U⁻ + τ U.
type Moment = (f64, f64, End);

/// The term in the residual.
fn moments<const D: usize, T: FacetTerm<D>>(step: &StepView<'_>) -> impl Iterator<Item = Moment> {
    let of_rate = old(step).filter(|_| T::RATE);
    step.rule.transport_points::<D>().map(|(weight, tau)| (weight, tau, End::New)).chain(of_rate)
}

/// The term at the old time.
fn old(step: &StepView<'_>) -> Option<Moment> {
    step.rule.has_explicit().then_some((1.0 - step.rule.theta, 0.0, End::Old))
}

impl<T: FacetTerm<D>, const D: usize> FacetOperator<T, D> {
    /// On the facets of `body` for which `here` holds, `n` Gauss points per direction; `term` is told how many points
    /// there are in all.
    pub fn new(
        space: &FsiSpace<D>,
        body: Region,
        here: impl Fn(&Facet) -> bool,
        n: usize,
        term: impl FnOnce(usize) -> T,
    ) -> FacetOperator<T, D> {
        let mut facets = vec![];
        let mut first = 0;
        for facet in space.mesh.facets.iter().filter(|f| space.regions[f.cell as usize] == body && here(f)) {
            let nodes = space.nodes.cell(facet.cell as usize).to_vec();
            let points = facet_points(space, facet, n);
            first += points.len();
            let (side, boundary) = (facet.side(), facet.boundary);
            facets.push(SeenFacet { side, boundary, first: first - points.len(), nodes, points });
        }
        let fields = (0..2).filter(|&field| T::DEPENDS[field] && (field == 0 || space.deforms)).collect();
        FacetOperator { term: term(first), body, facets, fields, slots: vec![], n_v: space.n_v() }
    }

    /// Whether it acts on no facet.
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// What the column of a direction of v has of the derivatives with respect to v and u: kθ ∂_u where u moves with v.
    fn shares(&self, matrix: Matrix, step: &StepView<'_>) -> [f64; 2] {
        let follows = matrix == Matrix::Condensed && self.body == Region::Solid && self.fields.contains(&1);
        [1.0, if follows { step.rule.theta / step.rule.per_k } else { 0.0 }]
    }

    /// Call `visit(row, column)` for every entry in the numbers that `number` gives to places in `[v, u, p]`, in a fixed
    /// order, [`DROP`]ped ones included.
    fn all_entries(&self, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        for SeenFacet { nodes, .. } in &self.facets {
            for row in nodes.iter().flat_map(|&a| (0..D).map(move |i| number[a as usize * D + i])) {
                for column in nodes.iter().flat_map(|&b| (0..D).map(move |j| b as usize * D + j)) {
                    for first in self.fields.iter().map(|field| field * self.n_v) {
                        let column = number[first + column];
                        let there = row != DROP && column != DROP;
                        visit(if there { row } else { DROP }, if there { column } else { DROP });
                    }
                }
            }
        }
    }

    /// The form at a point of a facet.
    fn form(&self, facet: &SeenFacet<D>, q: usize, end: End) -> Seen<T::Form> {
        let radius = facet.points[q].radius.filter(|_| !T::RATE);
        Seen { form: self.term.form(facet.first + q, end), radius }
    }

    /// The weight of a point in that of a moment, and its derivative by u_r there.
    fn weight(
        &self,
        (nodes, point): (&[u32], &FacetPoint<D>),
        (weight, tau, _): Moment,
        step: &StepView<'_>,
    ) -> [f64; 2] {
        let weight = weight * point.weight;
        match point.radius.filter(|_| T::RATE) {
            Some(r) => [weight * stretch((nodes, point), step, tau), weight * tau / r],
            None => [weight, 0.0],
        }
    }

    /// What stands before φ at a point of a facet, weighed.
    fn traction(
        &self,
        facet: &SeenFacet<D>,
        (q, moment): (usize, Moment),
        step: &StepView<'_>,
    ) -> Vector<f64, D> {
        let here = (&facet.nodes[..], &facet.points[q]);
        let (at, [weight, _]) = (fields(T::RATE, here, step, moment.1), self.weight(here, moment, step));
        self.form(facet, q, moment.2).traction(&at, &at, &here.1.normal, weight)
    }

    fn add(&self, moment: Moment, step: &StepView<'_>, out: &mut [f64]) {
        for facet in &self.facets {
            for (q, point) in facet.points.iter().enumerate() {
                let t = self.traction(facet, (q, moment), step);
                for (a, &node) in facet.nodes.iter().enumerate() {
                    for i in 0..D {
                        out[node as usize * D + i] += point.value[a] * t.0[i];
                    }
                }
            }
        }
    }

    /// Call `visit(point, column, field, derivative)` for the columns `[b][j]` of the fields that the term depends on.
    fn derivatives(
        &self,
        facet: &SeenFacet<D>,
        step: &StepView<'_>,
        how: (Tangent, bool),
        mut visit: impl FnMut(&FacetPoint<D>, usize, usize, Vector<f64, D>),
    ) {
        let steps = how.0.nodal().map(|by| {
            let [v, u, _] = by.steps(facet.points.iter().flat_map(|p| p.grad.iter().map(|g| Vector(*g))));
            [v, u]
        });
        for (q, point) in facet.points.iter().enumerate() {
            let columns = steps.is_none().then(|| self.columns(facet, q, step, how));
            for column in 0..facet.nodes.len() * D {
                let (b, j) = (column / D, column % D);
                for &field in &self.fields {
                    let derivative = match (&columns, steps) {
                        (Some(columns), _) => columns.of(point, field, b, j),
                        (None, h) => {
                            let h = h.unwrap_or_default()[field];
                            self.difference(facet, q, (step, how.1), (field, b, j), h)
                        }
                    };
                    visit(point, column, field, derivative);
                }
            }
        }
    }

    /// Derivatives at a point; `how` as in [`tangent::facet`].
    fn columns(
        &self,
        facet: &SeenFacet<D>,
        q: usize,
        step: &StepView<'_>,
        how: (Tangent, bool),
    ) -> Columns<D> {
        let zero = Vector::zero();
        let mut columns = Columns { value: [[zero; D]; 2], grad: [[[zero; D]; D]; 2] };
        let point = &facet.points[q];
        for moment @ (_, tau, end) in moments::<D, T>(step) {
            let here = (&facet.nodes[..], point);
            let (at, form) = (fields(T::RATE, here, step, tau), self.form(facet, q, end));
            let [weight, by_radius] = self.weight(here, moment, step);
            columns.add(&self.fields, |w, of_u| {
                // ∂_t u moves by 1/k where u moves by 1.
                let share = if of_u && T::RATE { step.rule.per_k } else { tau };
                tangent::facet(how, &form, weight, &at, &point.normal, w) * share
            });
            if by_radius != 0.0 && !how.1 {
                columns.value[1][0] += form.traction(&at, &at, &point.normal, by_radius);
            }
        }
        columns
    }

    /// (t(U + h W) − t(U)) / h at a point, W having component `j` of basis function `b` in field 0 (v) or 1 (u).
    fn difference(
        &self,
        facet: &SeenFacet<D>,
        q: usize,
        (step, lagged): (&StepView<'_>, bool),
        (field, b, j): (usize, usize, usize),
        h: f64,
    ) -> Vector<f64, D> {
        let point = &facet.points[q];
        let mut sum = Vector::zero();
        for moment @ (_, tau, end) in moments::<D, T>(step) {
            let here = (&facet.nodes[..], point);
            let (at, form) = (fields(T::RATE, here, step, tau), self.form(facet, q, end));
            let [weight, by_radius] = self.weight(here, moment, step);
            let by_radius = if field == 1 && j == 0 && !lagged { by_radius } else { 0.0 };
            let mut moved = at;
            let (value, grad) = match field {
                0 => (&mut moved.v, &mut moved.grad_v),
                _ => (&mut moved.u, &mut moved.grad_u),
            };
            let share = if field == 1 && T::RATE { step.rule.per_k } else { tau };
            value.0[j] += share * h * point.value[b];
            for d in 0..D {
                grad.0[j][d] += tau * h * point.grad[b][d];
            }
            let lag = if lagged { at } else { moved };
            let longer = weight + by_radius * h * point.value[b];
            let term = |at, lag, weight| form.traction(at, lag, &point.normal, weight);
            sum += (term(&moved, &lag, longer) - term(&at, &at, weight)) * (1.0 / h);
        }
        sum
    }
}

impl<T: FacetTerm<D>, const D: usize> Operator<D> for FacetOperator<T, D> {
    fn body(&self) -> Region {
        self.body
    }

    fn set_data(&mut self, at: &DataTime) -> Result<(), NotFinite<D>> {
        let points = self.facets.iter().flat_map(|facet| &facet.points);
        let boundary = |x: [f64; D]| {
            let here = |facet: &&SeenFacet<D>| facet.points.iter().any(|point| point.x == x);
            self.facets.iter().find(here).map_or(u16::MAX, |facet| facet.boundary)
        };
        self.term.set_data(at, points).map_err(|(x, value)| NotFinite { boundary: boundary(x), at: x, value })
    }

    fn explicit(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        if let Some(moment) = old(step).filter(|_| !T::RATE) {
            self.add(moment, step, out);
        }
    }

    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        moments::<D, T>(step).for_each(|moment| self.add(moment, step, out));
        f64::INFINITY
    }

    /// In the condensed matrix they are [`Operator::blocks`].
    fn entries(&self, matrix: Matrix, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        if matrix == Matrix::Whole {
            self.all_entries(number, &mut |row, column| {
                if row != DROP {
                    visit(row, column);
                }
            });
        }
    }

    fn place(&mut self, matrix: Matrix, number: &[u32], entries: &Entries<'_>) -> Result<(), SolverError> {
        if matrix == Matrix::Whole {
            let mut slots = vec![];
            self.all_entries(number, &mut |row, column| {
                slots.push(if row == DROP { DROP } else { (entries.find)(row, column) });
            });
            self.slots = slots;
        }
        Ok(())
    }

    /// In the fluid, derivatives with respect to u are those of Newton's method alone.
    fn linearise(&mut self, matrix: Matrix, step: &StepView<'_>, how: How, mut out: Sink<'_>) {
        if matrix == Matrix::Condensed {
            return;
        }
        let with_u = self.body == Region::Solid || how.linearization == Linearization::Newton;
        let lagged = how.linearization == Linearization::FixedPoint;
        let (fields, mut first) = (self.fields.len(), 0);
        for facet in &self.facets {
            let nodes = facet.nodes.len() * D;
            let slots = &self.slots[first..first + nodes * nodes * fields];
            first += slots.len();
            self.derivatives(facet, step, (how.tangent, lagged), |p, column, field, derivative| {
                let place = self.fields.iter().position(|f| *f == field).unwrap_or_default();
                for row in (0..nodes).filter(|_| with_u || field == 0) {
                    let slot = slots[(row * nodes + column) * fields + place];
                    if slot != DROP {
                        out.add(slot as usize, p.value[row / D] * derivative.0[row % D]);
                    }
                }
            });
        }
    }

    fn apply(&mut self, matrix: Matrix, step: &StepView<'_>, x: &[f64], y: &mut [f64]) {
        let shares = self.shares(matrix, step);
        for facet in &self.facets {
            self.derivatives(facet, step, (Tangent::Automatic, false), |p, column, field, derivative| {
                let place = facet.nodes[column / D] as usize * D + column % D;
                let value = match matrix {
                    Matrix::Whole => x[field * self.n_v + place],
                    Matrix::Condensed => shares[field] * x[place],
                };
                for (a, &node) in facet.nodes.iter().enumerate() {
                    for i in 0..D {
                        y[node as usize * D + i] += p.value[a] * derivative.0[i] * value;
                    }
                }
            });
        }
    }

    fn blocks(&self) -> Vec<(u32, usize)> {
        let seen = self.fields.contains(&0) || (self.body == Region::Solid && !self.fields.is_empty());
        let facets = self.facets.iter().filter(|_| seen);
        facets.map(|facet| (facet.side.cell, facet.nodes.len() * D)).collect()
    }

    fn fill_blocks(&mut self, step: &StepView<'_>, how: How, blocks: &mut [f64]) {
        if blocks.is_empty() {
            return;
        }
        let (shares, mut rest) = (self.shares(Matrix::Condensed, step), blocks);
        for facet in &self.facets {
            let rows = facet.nodes.len() * D;
            let (block, behind) = rest.split_at_mut(rows * rows);
            rest = behind;
            self.derivatives(facet, step, (how.tangent, false), |p, column, field, derivative| {
                if shares[field] != 0.0 {
                    for row in 0..rows {
                        block[row * rows + column] +=
                            shares[field] * p.value[row / D] * derivative.0[row % D];
                    }
                }
            });
        }
    }

    fn force_through(&self, step: &StepView<'_>, sides: &[Side]) -> Vector<f64, D> {
        let of_old = old(step).filter(|_| !T::RATE);
        let mut sum = Vector::zero();
        for facet in self.facets.iter().filter(|facet| sides.contains(&facet.side)) {
            for q in 0..facet.points.len() {
                for moment in moments::<D, T>(step).chain(of_old) {
                    sum += self.traction(facet, (q, moment), step);
                }
            }
        }
        sum
    }
}
