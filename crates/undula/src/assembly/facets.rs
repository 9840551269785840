//! The outflow terms on boundary facets. There are few, so they are done one by one in `f64`.

use super::interior::FacetBlocks;
use super::kernel::StepView;
use super::scatter::DROP;
use crate::element::Quadrature;
use crate::math::{Tensor, Vector};
use crate::mesh::{Facet, Side};
use crate::physics::{Backflow, FacetForm, Fields, Fluid, Outflow};
use crate::space::{BoundaryCondition, Constraints, FsiSpace, Region, State};
use crate::tangent::{self, Linearization, Tangent};

/// One quadrature point on a facet.
#[derive(Clone, Debug)]
pub struct FacetPoint<const D: usize> {
    /// Reference coordinates in the cell.
    pub xi: [f64; D],
    /// Position \[m\].
    pub x: [f64; D],
    /// Outer unit normal of the cell.
    pub normal: Vector<f64, D>,
    /// Quadrature weight times surface element \[m^(D−1)\].
    pub weight: f64,
    /// Basis of v and u, `[basis]`.
    pub value: Vec<f64>,
    /// Its gradient with respect to x, `[basis][d]`.
    pub grad: Vec<[f64; D]>,
}

/// Quadrature points of `facet` with `n` Gauss points per direction.
pub fn facet_points<const D: usize>(space: &FsiSpace<D>, facet: &Facet, n: usize) -> Vec<FacetPoint<D>> {
    let mesh = &space.mesh;
    let (cell, local) = (facet.cell as usize, facet.local as usize);
    let rule = Quadrature::facet(mesh.shape, local, n);
    let table = space.nodes.table(mesh.shape, &rule);
    let mut points = vec![];
    for (q, xi) in rule.points.iter().enumerate() {
        let xi: [f64; D] = std::array::from_fn(|d| xi[d]);
        let jacobian = Tensor(mesh.map_gradient(cell, xi));
        let cofactor = jacobian.cofactor();
        let inverse_t = cofactor * (1.0 / jacobian.det());
        // Nanson: n dS = cof(DX) N dS for the reference normal N of the facet.
        let normal = mesh.shape.facet_normal(local);
        let area = cofactor * Vector(std::array::from_fn(|d| normal[d]));
        let size = area.dot(area).sqrt();
        let grad = |a: usize| {
            let reference = Vector(std::array::from_fn(|d| table.grad(q)[a * D + d]));
            (inverse_t * reference).0
        };
        points.push(FacetPoint {
            xi,
            x: mesh.map(cell, xi),
            normal: area * (1.0 / size),
            weight: rule.weights[q] * size,
            value: table.value(q).to_vec(),
            grad: (0..table.n_basis).map(grad).collect(),
        });
    }
    points
}

/// Fields v and u of `state` at a point of a cell with the given nodes; p stays zero.
pub fn fields_at<const D: usize>(
    nodes: &[u32],
    value: &[f64],
    grad: &[[f64; D]],
    state: &State,
) -> Fields<f64, D> {
    let mut f = Fields::zero();
    for (a, &node) in nodes.iter().enumerate() {
        let at = node as usize * D;
        for i in 0..D {
            let v = state.v[at + i];
            let u = if state.u.is_empty() { 0.0 } else { state.u[at + i] };
            f.v.0[i] += value[a] * v;
            f.u.0[i] += value[a] * u;
            for d in 0..D {
                f.grad_v.0[i][d] += grad[a][d] * v;
                f.grad_u.0[i][d] += grad[a][d] * u;
            }
        }
    }
    f
}

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
    /// Cell of each facet.
    pub cells: Vec<u32>,
    sides: Vec<Side>,
    /// `[facet][row a, i][column b, field, j]`.
    slots: Vec<u32>,
    deforms: bool,
}

impl<const D: usize> OutflowFacets<D> {
    /// On the facets of the `fluid` whose condition has one of the terms, `n` Gauss points per direction.
    pub fn new(
        space: &FsiSpace<D>,
        fluid: Option<Fluid>,
        conditions: &[BoundaryCondition<D>],
        n: usize,
    ) -> OutflowFacets<D> {
        let (mut facets, mut cells, mut sides) = (vec![], vec![], vec![]);
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
                facets.push(OutflowFacet { nodes, points, correction, backflow });
                cells.push(facet.cell);
                sides.push(facet.side());
            }
        }
        OutflowFacets { facets, cells, sides, slots: vec![], deforms: space.deforms }
    }

    /// Call `visit(row, column)` for every entry of the Jacobian in a fixed order.
    pub fn entries(&self, constraints: &Constraints<D>, mut visit: impl FnMut(u32, u32)) {
        let n_v = constraints.v.len() * D;
        for OutflowFacet { nodes, .. } in &self.facets {
            for &a in nodes {
                for i in 0..D {
                    let given = constraints.v[a as usize];
                    let row = if given { DROP } else { a * D as u32 + i as u32 };
                    for &b in nodes {
                        for j in 0..D {
                            let v = b as usize * D + j;
                            let given_v = constraints.v[b as usize];
                            visit(row, if given_v || row == DROP { DROP } else { v as u32 });
                            if self.deforms {
                                let given_u = constraints.u[b as usize][j];
                                visit(row, if given_u || row == DROP { DROP } else { (n_v + v) as u32 });
                            }
                        }
                    }
                }
            }
        }
    }

    /// Remember where every entry goes.
    pub fn set_slots(&mut self, constraints: &Constraints<D>, find: impl Fn(u32, u32) -> u32) {
        let mut slots = vec![];
        self.entries(constraints, |row, col| slots.push(if col == DROP { DROP } else { find(row, col) }));
        self.slots = slots;
    }

    /// Add the terms of the step to `out`, but the explicit part of the do-nothing correction.
    pub fn residual(&self, step: &StepView<'_>, out: &mut [f64]) {
        for (weight, tau) in step.rule.transport_points() {
            let fields = |nodes: &[u32], point: &FacetPoint<D>| fields_between(nodes, point, step, tau);
            self.add(weight, |facet| facet.correction.as_ref(), fields, out);
        }
        for (weight, tau) in backflow_points(step) {
            let fields = |nodes: &[u32], point: &FacetPoint<D>| fields_with_motion(nodes, point, step, tau);
            self.add(weight, |facet| facet.backflow.as_ref(), fields, out);
        }
    }

    /// Add the explicit part (1 − θ) A(U⁻) to `out`.
    ///
    /// The directional term at the old time depends on ∂_t u of the step, so it belongs to [`OutflowFacets::residual`].
    pub fn explicit(&self, step: &StepView<'_>, out: &mut [f64]) {
        let old =
            |nodes: &[u32], point: &FacetPoint<D>| fields_at(nodes, &point.value, &point.grad, step.old);
        if step.rule.has_explicit() {
            self.add(1.0 - step.rule.theta, |facet| facet.correction.as_ref(), old, out);
        }
    }

    /// The sum of the terms of the step, their explicit part included, over all test functions and those facets that
    /// are among `sides` \[N/m\].
    pub fn sum(&self, step: &StepView<'_>, sides: &[Side]) -> Vector<f64, D> {
        let explicit = step.rule.has_explicit().then_some((1.0 - step.rule.theta, 0.0));
        let times: Vec<(f64, f64)> = step.rule.transport_points().chain(explicit).collect();
        let mut sum = Vector::zero();
        for (facet, _) in self.facets.iter().zip(&self.sides).filter(|(_, side)| sides.contains(side)) {
            for point in &facet.points {
                for &(weight, tau) in &times {
                    let at = fields_between(&facet.nodes, point, step, tau);
                    if let Some(form) = &facet.correction {
                        sum += form.traction(&at, &point.normal, weight * point.weight);
                    }
                    if let Some(form) = &facet.backflow {
                        sum += form.traction(&at, &point.normal, weight * point.weight);
                    }
                }
            }
        }
        sum
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

    /// Add the matrix of an iteration at the new state to the entries `out`; derivatives with respect to u are those of
    /// Newton's method alone.
    pub fn jacobian(&self, step: &StepView<'_>, which: Linearization, how: Tangent, out: &mut [f64]) {
        let with_u = which == Linearization::Newton;
        let lagged = which == Linearization::FixedPoint;
        let mut first = 0;
        for facet in &self.facets {
            let nodes = &facet.nodes;
            let n_fields = if self.deforms { 2 } else { 1 };
            let columns = nodes.len() * D * n_fields;
            let size = nodes.len() * D * columns;
            let Some(slots) = self.slots.get(first..first + size) else { return };
            first += size;
            for p in &facet.points {
                let tangent = facet.tangent(step, (how, lagged), p);
                for column in 0..columns {
                    // Columns are numbered `[b][j][field]`.
                    let (b, j, field) = (column / (D * n_fields), column / n_fields % D, column % n_fields);
                    if !with_u && field == 1 {
                        continue;
                    }
                    let derivative = tangent.of(p, field, b, j);
                    for row in 0..nodes.len() * D {
                        let slot = slots[row * columns + column];
                        if slot != DROP {
                            out[slot as usize] += p.value[row / D] * derivative.0[row % D];
                        }
                    }
                }
            }
        }
    }

    /// The derivatives with respect to v as one dense block per facet, `[facet][a, i][b, j]`.
    pub fn blocks(&self, step: &StepView<'_>, how: Tangent, out: &mut FacetBlocks) {
        out.size = self.facets.first().map_or(0, |facet| (facet.nodes.len() * D).pow(2));
        out.values.clear();
        out.values.resize(out.size * self.facets.len(), 0.0);
        for (f, facet) in self.facets.iter().enumerate() {
            let block = &mut out.values[f * out.size..(f + 1) * out.size];
            for p in &facet.points {
                let tangent = facet.tangent(step, (how, false), p);
                let columns = facet.nodes.len() * D;
                for column in 0..columns {
                    let derivative = tangent.of(p, 0, column / D, column % D);
                    for row in 0..columns {
                        block[row * columns + column] += p.value[row / D] * derivative.0[row % D];
                    }
                }
            }
        }
    }
}

impl<const D: usize> OutflowFacet<D> {
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

/// Derivatives of the traction in the directions of value and gradient of v and u: `[field][j]`,
/// `[field][j][d]`.
struct Columns<const D: usize> {
    value: [[Vector<f64, D>; D]; 2],
    grad: [[[Vector<f64, D>; D]; D]; 2],
}

impl<const D: usize> Columns<D> {
    /// Add the derivative in every direction; it is told whether the direction is that of the value of u.
    fn add(&mut self, derivative: impl Fn(&Fields<f64, D>, bool) -> Vector<f64, D>) {
        let column = |n: usize, of_u: bool| {
            let mut w = Fields::zero();
            *w.component(n) = 1.0;
            derivative(&w, of_u)
        };
        for field in 0..2 {
            let first = field * (D + D * D);
            for j in 0..D {
                self.value[field][j] += column(first + j, field == 1);
                for d in 0..D {
                    self.grad[field][j][d] += column(first + D + j * D + d, false);
                }
            }
        }
    }

    /// d(traction) for basis function `b` in component `j` of field 0 (v) or 1 (u).
    fn of(&self, p: &FacetPoint<D>, field: usize, b: usize, j: usize) -> Vector<f64, D> {
        let value = self.value[field][j] * p.value[b];
        (0..D).fold(value, |sum, d| sum + self.grad[field][j][d] * p.grad[b][d])
    }
}
