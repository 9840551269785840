//! The outflow terms on boundary facets. There are few, so they are done one by one in `f64`.

use super::columns::Columns;
use super::{Entries, How, Matrix, Operator, StepView};
use crate::algebra::SolverError;
use crate::loops::slots::{Numbering, Pair, Slots, vectors};
use crate::loops::test_functions::{Test, Trial};
use crate::math::{Lanes, Vector};
use crate::mesh::Side;
use crate::physics::{Backflow, FacetForm, Fields, Fluid, Outflow};
use crate::sampling::{FacetPoint, facet_points, fields_at};
use crate::space::{BoundaryCondition, FsiSpace, Region, State};
use crate::tangent::{self, Linearization, Tangent};

/// Fields v and u at (1 − τ) U⁻ + τ U.
fn fields_between<const D: usize>(
    nodes: &[u32],
    point: &FacetPoint<D>,
    step: &StepView<'_>,
    tau: f64,
) -> Fields<f64, D> {
    let of = |state: &State| fields_at(nodes, &point.value, &point.grad, state);
    if tau == 1.0 { of(step.new) } else { of(step.old).lerp(&of(step.new), tau) }
}

/// A facet of the fluid through which it flows out, with the terms there.
struct OutflowFacet<const D: usize> {
    side: Side,
    nodes: Vec<u32>,
    points: Vec<FacetPoint<D>>,
    /// The do-nothing correction.
    correction: Option<Outflow>,
    /// The directional term.
    backflow: Option<Backflow>,
}

/// Facets with the do-nothing correction or the directional term.
pub struct OutflowFacets<const D: usize> {
    facets: Vec<OutflowFacet<D>>,
    /// Where the entries go in the whole matrix, a facet in a batch.
    slots: Slots<D, 1>,
    deforms: bool,
    n_v: usize,
}

impl<const D: usize> OutflowFacets<D> {
    /// On the facets of the `fluid` whose condition has one of the terms, `n` Gauss points per direction.
    pub fn new(
        space: &FsiSpace<D>,
        fluid: Option<Fluid>,
        conditions: &[BoundaryCondition<D>],
        n: usize,
    ) -> OutflowFacets<D> {
        let mut facets = vec![];
        for facet in &space.mesh.facets {
            let BoundaryCondition::Outflow { do_nothing, directional } = conditions[facet.boundary as usize]
            else {
                continue;
            };
            let Some(fluid) = fluid.filter(|_| space.regions[facet.cell as usize] == Region::Fluid) else {
                continue;
            };
            let correction = do_nothing.then_some(Outflow { viscosity: fluid.rho * fluid.nu });
            let backflow = directional.then_some(Backflow { density: fluid.rho });
            if correction.is_some() || backflow.is_some() {
                let nodes = space.nodes.cell(facet.cell as usize).to_vec();
                let points = facet_points(space, facet, n);
                facets.push(OutflowFacet { side: facet.side(), nodes, points, correction, backflow });
            }
        }
        OutflowFacets { facets, slots: Slots::default(), deforms: space.deforms, n_v: space.n_v() }
    }

    /// Whether no facet has such a term.
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty()
    }

    /// Fields that the terms depend on: v, and u where there is one.
    fn fields(&self) -> usize {
        if self.deforms { 2 } else { 1 }
    }

    /// What is coupled: φ with v, and with u where there is one.
    fn pairs(&self) -> &'static [Pair] {
        const PAIRS: [Pair; 2] =
            [Pair::full(Test::Phi(0), Trial::V(0)), Pair::full(Test::Phi(0), Trial::U(0))];
        &PAIRS[..self.fields()]
    }

    /// Rows and columns of a facet in the numbers that `number` gives to places in `[v, u, p]`.
    fn numbering(&self, facet: usize, number: &[u32]) -> Numbering<D, 1> {
        let nodes = &self.facets[facet].nodes;
        let of = |first: usize| vectors(nodes.iter().map(|&a| [(first + a as usize * D) as u32]), 1, number);
        let u = if self.deforms { of(self.n_v) } else { vec![] };
        Numbering { rows: [of(0), vec![], vec![]], columns: [of(0), u, vec![]] }
    }

    fn add<'a, F: FacetForm<D> + 'a>(
        &'a self,
        weight: f64,
        form: impl Fn(&'a OutflowFacet<D>) -> Option<&'a F>,
        fields: impl Fn(&[u32], &FacetPoint<D>) -> Fields<f64, D>,
        out: &mut [f64],
    ) {
        for facet in &self.facets {
            let Some(form) = form(facet) else { continue };
            for point in &facet.points {
                let at = fields(&facet.nodes, point);
                let t = form.traction(&at, &point.normal, weight * point.weight);
                for (a, &node) in facet.nodes.iter().enumerate() {
                    for i in 0..D {
                        out[node as usize * D + i] += point.value[a] * t.0[i];
                    }
                }
            }
        }
    }
}

impl<const D: usize> Operator<D> for OutflowFacets<D> {
    fn body(&self) -> Region {
        Region::Fluid
    }

    /// The explicit part (1 − θ) A(U⁻) of the do-nothing correction.
    ///
    /// The directional term at the old time depends on ∂_t u of the step, so it belongs to the residual.
    fn explicit(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        let old =
            |nodes: &[u32], point: &FacetPoint<D>| fields_at(nodes, &point.value, &point.grad, step.old);
        self.add(1.0 - step.rule.theta, |facet| facet.correction.as_ref(), old, out);
    }

    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        for (weight, tau) in step.rule.transport_points() {
            let fields = |nodes: &[u32], point: &FacetPoint<D>| fields_between(nodes, point, step, tau);
            self.add(weight, |facet| facet.correction.as_ref(), fields, out);
        }
        for (weight, tau) in backflow_points(step) {
            let fields = |nodes: &[u32], point: &FacetPoint<D>| fields_with_motion(nodes, point, step, tau);
            self.add(weight, |facet| facet.backflow.as_ref(), fields, out);
        }
        f64::INFINITY
    }

    /// In the condensed matrix they are [`Operator::blocks`].
    fn entries(&self, matrix: Matrix, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        for facet in (0..self.facets.len()).filter(|_| matrix == Matrix::Whole) {
            self.numbering(facet, number).visit(self.pairs(), visit);
        }
    }

    fn place(&mut self, matrix: Matrix, number: &[u32], entries: &Entries<'_>) -> Result<(), SolverError> {
        if matrix == Matrix::Whole {
            let (n, all) = (self.facets.len(), [0..self.facets.len()]);
            self.slots = Slots::new(n, &all, entries, self.pairs(), |facet| self.numbering(facet, number))?;
        }
        Ok(())
    }

    /// Derivatives with respect to u are those of Newton's method alone.
    fn linearise(&mut self, matrix: Matrix, step: &StepView<'_>, how: How, out: &mut [f64]) {
        let (with_u, lagged) =
            (how.linearization == Linearization::Newton, how.linearization == Linearization::FixedPoint);
        if matrix != Matrix::Whole {
            return;
        }
        let (fields, mut slots) = (self.fields(), std::mem::take(&mut self.slots));
        slots.fill(out, |slots, out| {
            for (n, facet) in self.facets.iter().enumerate() {
                let trials = [Trial::V(0), Trial::U(0)];
                let places = [0, fields - 1].map(|field| slots.of(Test::Phi(0), trials[field], n));
                facet.derivatives(step, (how.tangent, lagged), fields, |p, column, field, derivative| {
                    let (b, j) = (column / (D * fields), column / fields % D);
                    for (a, value) in p.value.iter().enumerate().filter(|_| with_u || field == 0) {
                        for i in 0..D {
                            places[field].add(out, (a, b), (i, j), &Lanes([value * derivative.0[i]]));
                        }
                    }
                });
            }
        });
        self.slots = slots;
    }

    fn apply(&mut self, matrix: Matrix, step: &StepView<'_>, x: &[f64], y: &mut [f64]) {
        let fields = if matrix == Matrix::Whole { self.fields() } else { 1 };
        for facet in &self.facets {
            facet.derivatives(step, (Tangent::Automatic, false), fields, |p, column, field, derivative| {
                let (b, j) = (column / (D * fields), column / fields % D);
                let value = x[field * self.n_v + facet.nodes[b] as usize * D + j];
                for (a, &node) in facet.nodes.iter().enumerate() {
                    for i in 0..D {
                        y[node as usize * D + i] += p.value[a] * derivative.0[i] * value;
                    }
                }
            });
        }
    }

    fn blocks(&self) -> Vec<(u32, usize)> {
        self.facets.iter().map(|facet| (facet.side.cell, facet.nodes.len() * D)).collect()
    }

    fn fill_blocks(&mut self, step: &StepView<'_>, how: How, blocks: &mut [f64]) {
        let mut rest = blocks;
        for facet in &self.facets {
            let rows = facet.nodes.len() * D;
            let (block, behind) = rest.split_at_mut(rows * rows);
            rest = behind;
            facet.derivatives(step, (how.tangent, false), 1, |p, column, _, derivative| {
                for row in 0..rows {
                    block[row * rows + column] += p.value[row / D] * derivative.0[row % D];
                }
            });
        }
    }

    fn force_through(&self, step: &StepView<'_>, sides: &[Side]) -> Vector<f64, D> {
        let explicit = step.rule.has_explicit().then_some((1.0 - step.rule.theta, 0.0));
        let times: Vec<(f64, f64)> = step.rule.transport_points().chain(explicit).collect();
        let mut sum = Vector::zero();
        for facet in self.facets.iter().filter(|facet| sides.contains(&facet.side)) {
            for point in &facet.points {
                for &(weight, tau) in &times {
                    if let Some(form) = &facet.correction {
                        let at = fields_between(&facet.nodes, point, step, tau);
                        sum += form.traction(&at, &point.normal, weight * point.weight);
                    }
                    if let Some(form) = &facet.backflow {
                        let at = fields_with_motion(&facet.nodes, point, step, tau);
                        sum += form.traction(&at, &point.normal, weight * point.weight);
                    }
                }
            }
        }
        sum
    }
}
impl<const D: usize> OutflowFacet<D> {
    /// Call `visit` at every point with each column `[b][j][field]` of the first `fields` fields, its field and the
    /// derivative of the traction.
    fn derivatives(
        &self,
        step: &StepView<'_>,
        how: (Tangent, bool),
        fields: usize,
        mut visit: impl FnMut(&FacetPoint<D>, usize, usize, Vector<f64, D>),
    ) {
        for p in &self.points {
            let tangent = self.tangent(step, how, p);
            for column in 0..self.nodes.len() * D * fields {
                let (b, j, field) = (column / (D * fields), column / fields % D, column % fields);
                visit(p, column, field, tangent.of(p, field, b, j));
            }
        }
    }

    /// The tangent at a point of the facet, `how` as in [`tangent::backflow`].
    fn tangent<'a>(
        &'a self,
        step: &'a StepView<'a>,
        how: (Tangent, bool),
        p: &FacetPoint<D>,
    ) -> FacetTangent<'a, D> {
        match how.0.nodal() {
            Some(by) => {
                let [v, u, _] = by.steps(self.points.iter().flat_map(|p| p.grad.iter().map(|g| Vector(*g))));
                FacetTangent::Nodal { facet: self, step, lagged: how.1, steps: [v, u] }
            }
            None => FacetTangent::Columns(self.columns(step, how, p)),
        }
    }

    /// (t(U + h W) − t(U)) / h of the terms t at a point, W having component `j` of basis function `b` in field 0 (v)
    /// or 1 (u).
    fn difference(
        &self,
        (step, lagged): (&StepView<'_>, bool),
        p: &FacetPoint<D>,
        (field, b, j): (usize, usize, usize),
        h: f64,
    ) -> Vector<f64, D> {
        let moved = |at: &Fields<f64, D>, value: f64, grad: f64| {
            let mut moved = *at;
            let (to, to_grad) = if field == 0 {
                (&mut moved.v, &mut moved.grad_v)
            } else {
                (&mut moved.u, &mut moved.grad_u)
            };
            to.0[j] += value * h * p.value[b];
            for d in 0..D {
                to_grad.0[j][d] += grad * h * p.grad[b][d];
            }
            moved
        };
        let mut sum = Vector::zero();
        if let Some(form) = &self.correction {
            for (weight, tau) in step.rule.transport_points() {
                let at = fields_between(&self.nodes, p, step, tau);
                let traction = |at: &Fields<f64, D>| form.traction(at, &p.normal, weight * p.weight);
                sum += (traction(&moved(&at, tau, tau)) - traction(&at)) * (1.0 / h);
            }
        }
        if let Some(form) = &self.backflow {
            for (weight, tau) in backflow_points(step) {
                let at = fields_with_motion(&self.nodes, p, step, tau);
                // ∂_t u moves by 1/k where u moves by 1.
                let moved = moved(&at, if field == 0 { tau } else { step.rule.per_k }, tau);
                let lag = if lagged { at } else { moved };
                let term = |at, lag| form.term(at, lag, &p.normal, weight * p.weight);
                sum += (term(&moved, &lag) - term(&at, &at)) * (1.0 / h);
            }
        }
        sum
    }

    /// The point tangent of both terms; `lagged` as in [`tangent::backflow`].
    fn columns(&self, step: &StepView<'_>, how: (Tangent, bool), p: &FacetPoint<D>) -> Columns<D> {
        let zero = Vector::zero();
        let mut columns = Columns { value: [[zero; D]; 2], grad: [[[zero; D]; D]; 2] };
        if let Some(form) = &self.correction {
            for (weight, tau) in step.rule.transport_points() {
                let at = fields_between(&self.nodes, p, step, tau);
                columns.add(|w, _| tangent::outflow(how.0, form, weight * tau * p.weight, &at, &p.normal, w));
            }
        }
        if let Some(form) = &self.backflow {
            for (weight, tau) in backflow_points(step) {
                let at = fields_with_motion(&self.nodes, p, step, tau);
                columns.add(|w, of_u| {
                    // ∂_t u moves by 1/k where u moves by 1.
                    let share = if of_u { step.rule.per_k } else { tau };
                    tangent::backflow(how, form, weight * p.weight, &at, &p.normal, w) * share
                });
            }
        }
        columns
    }
}

/// (weight, τ) of the directional term: transport with its explicit part.
fn backflow_points(step: &StepView<'_>) -> impl Iterator<Item = (f64, f64)> {
    let explicit = step.rule.has_explicit().then_some((1.0 - step.rule.theta, 0.0));
    step.rule.transport_points().chain(explicit)
}

/// Fields at (1 − τ) U⁻ + τ U, with ∂_t u = (u − u⁻)/k of the step in place of u.
fn fields_with_motion<const D: usize>(
    nodes: &[u32],
    point: &FacetPoint<D>,
    step: &StepView<'_>,
    tau: f64,
) -> Fields<f64, D> {
    let of = |state: &State| fields_at(nodes, &point.value, &point.grad, state);
    let (old, new) = (of(step.old), of(step.new));
    Fields { u: step.rule.per_k * (new.u - old.u), ..old.lerp(&new, tau) }
}

/// The tangent of the terms at a point of a facet.
enum FacetTangent<'a, const D: usize> {
    /// In directions at the point.
    Columns(Columns<D>),
    /// By differences in nodal values, which v and u move by `steps`.
    Nodal { facet: &'a OutflowFacet<D>, step: &'a StepView<'a>, lagged: bool, steps: [f64; 2] },
}

impl<const D: usize> FacetTangent<'_, D> {
    /// d(traction) for basis function `b` in component `j` of field 0 (v) or 1 (u).
    fn of(&self, p: &FacetPoint<D>, field: usize, b: usize, j: usize) -> Vector<f64, D> {
        match self {
            FacetTangent::Columns(columns) => columns.of(p, field, b, j),
            FacetTangent::Nodal { facet, step, lagged, steps } => {
                facet.difference((step, *lagged), p, (field, b, j), steps[field])
            }
        }
    }
}
