//! Outlets whose pressure depends on the flow through them: J σ F⁻ᵀ N = −P J F⁻ᵀ N, with one P on the whole boundary.
//!
//! Q = ∫ (v − ∂_t u)·J F⁻ᵀ N flows out. The laws are
//! ```text
//!     resistance   P = R Q + P_d
//!     windkessel   P = R_p Q + P_c,   C dP_c/dt = Q − (P_c − P_d)/R_d
//!     flow         Q = q,   P = λ
//! ```
//! P_c and λ are scalar unknowns; P_c is integrated like the flow, λ belongs to the new time like the pressure. The
//! dependence on Q is a far coupling of rank one, the load itself that of a pressure.

use super::border::{Border, Borders};
use super::facets::{FacetOperator, SeenFacet};
use super::pressure::{PressureLoad, pressure};
use super::{DataTime, End, Entries, How, Matrix, NotFinite, Operator, StepView};
use crate::algebra::{Sink, SolverError};
use crate::math::Vector;
use crate::mesh::Side;
use crate::parallel::{Crew, Reduce};
use crate::physics::kinematics::cofactor;
use crate::sampling::fields_at;
use crate::space::{FsiSpace, Region, State};

/// What holds between pressure and flow. Numbers at a time \[s\]; in D dimensions flows are in m^D/s.
pub enum Law {
    /// P = R Q + P_d: R \[Pa s/m^D\], P_d \[Pa\].
    Resistance(Numbers<2>),
    /// R_p, C, R_d, P_d: \[Pa s/m^D\], \[m^D/Pa\], \[Pa s/m^D\], \[Pa\].
    Windkessel(Numbers<4>),
    /// q \[m^D/s\].
    Flow(Numbers<1>),
}

/// Numbers that depend on time.
pub type Numbers<const N: usize> = Box<dyn Fn(f64) -> [f64; N] + Send + Sync>;

/// R, C, R_d, P_d, q at one time; what a law does not have is 0.
#[derive(Copy, Clone, Debug, Default)]
struct Parameters {
    resistance: f64,
    capacitance: f64,
    distal: f64,
    pressure: f64,
    flow: f64,
}

/// An outlet.
pub struct Outlet<const D: usize> {
    law: Law,
    /// The load of the pressure, with its derivative where P is as it is.
    load: FacetOperator<PressureLoad<D>, D>,
    boundary: u16,
    /// P_c at the start \[Pa\].
    start: f64,
    /// At the old and the new time.
    at: [Parameters; 2],
    /// Number and row of the scalar unknown.
    scalar: (usize, usize),
    deforms: bool,
    n_v: usize,
    /// Facets whose flow this process counts, and the processes that count the others.
    counted: Vec<bool>,
    crew: Option<Crew>,
    /// Nodes that it counts of `nodes`.
    own: Vec<bool>,
    /// Nodes of the cells at the facets, ascending, and their numbers `[facet][a]` among them.
    nodes: Vec<u32>,
    local: Vec<u32>,
    /// ⟨cof(F) N, φ⟩ by node, and ∂Q with respect to v and u, of one moment: `[node, i]`.
    column: Vec<f64>,
    row: [Vec<f64>; 2],
}

/// A moment of the step: weight, τ and whose parameters hold.
type Moment = (f64, f64, End);

impl<const D: usize> Outlet<D> {
    /// On the facets of the fluid at `boundary`, `n` Gauss points per direction; `start` is P_c \[Pa\] at the beginning.
    pub fn new(space: &FsiSpace<D>, boundary: u16, law: Law, start: f64, n: usize) -> Outlet<D> {
        let load = pressure(space, Region::Fluid, boundary, (Box::new(|_, _| 0.0), true), n);
        let (scalar, n_v, deforms) = ((0, 0), space.n_v(), space.deforms);
        let mut nodes: Vec<u32> = load.facets.iter().flat_map(|facet| facet.nodes.clone()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |node: &u32| nodes.partition_point(|other| other < node) as u32;
        let local = load.facets.iter().flat_map(|facet| facet.nodes.iter().map(number)).collect();
        let zero = vec![0.0; nodes.len() * D];
        let (column, row, at) = (zero.clone(), [zero.clone(), zero], Default::default());
        let counted = load.facets.iter().map(|facet| space.owns_cell(facet.side.cell as usize)).collect();
        let own = nodes.iter().map(|&node| space.owns_node(node as usize)).collect();
        let crew = space.part.as_ref().map(|part| part.crew().clone());
        Outlet {
            law,
            load,
            boundary,
            start,
            at,
            scalar,
            deforms,
            n_v,
            counted,
            crew,
            own,
            nodes,
            local,
            column,
            row,
        }
    }

    fn has_scalar(&self) -> bool {
        !matches!(self.law, Law::Resistance(_))
    }

    fn is_flow(&self) -> bool {
        matches!(self.law, Law::Flow(_))
    }

    /// The moments of the load; a given flow has its pressure at the new time.
    fn moments(&self, step: &StepView<'_>) -> impl Iterator<Item = Moment> + use<D> {
        let (rule, is_flow) = (step.rule, self.is_flow());
        let new = is_flow.then_some((1.0, 1.0, End::New));
        let theta = (!is_flow && rule.quadrature.is_empty()).then_some((rule.theta, 1.0, End::New));
        let inside = rule.gauss_points::<D>().iter().filter(move |_| !is_flow);
        let old = (!is_flow && rule.has_explicit()).then_some((1.0 - rule.theta, 0.0, End::Old));
        let inside = inside.map(|&(weight, tau)| (weight, tau, End::New));
        new.into_iter().chain(theta).chain(inside).chain(old)
    }

    /// Call `visit` at all points with the weighted normal cof(F) N and v − ∂_t u at (1 − τ) U⁻ + τ U.
    fn visit(
        &self,
        step: &StepView<'_>,
        tau: f64,
        mut visit: impl FnMut(&SeenFacet<D>, usize, Vector<f64, D>, Vector<f64, D>),
    ) {
        for facet in &self.load.facets {
            for (q, point) in facet.points.iter().enumerate() {
                let of = |state: &State| fields_at(&facet.nodes, &point.value, &point.grad, state);
                let (old, new) = (of(step.old), of(step.new));
                let rate = step.rule.per_k * (new.u - old.u);
                let at = old.lerp(&new, tau);
                let normal = cofactor(&at.grad_u) * point.normal * (point.weight * point.stretch(&at.u));
                visit(facet, q, normal, at.v - rate);
            }
        }
    }

    /// Q at a moment.
    fn flow(&self, step: &StepView<'_>, tau: f64) -> f64 {
        let (mut sum, mut facets) = (0.0, 0);
        self.visit(step, tau, |_, q, normal, relative| {
            facets += usize::from(q == 0);
            if self.counted[facets - 1] {
                sum += normal.dot(relative);
            }
        });
        self.crew.as_ref().map_or(sum, |crew| crew.one(Reduce::Sum, sum))
    }

    fn scalar_at(&self, step: &StepView<'_>, tau: f64) -> f64 {
        if !self.has_scalar() {
            return 0.0;
        }
        let [old, new] = [step.old, step.new].map(|state| state.s[self.scalar.0]);
        old + tau * (new - old)
    }

    /// P at a moment.
    fn pressure(&self, step: &StepView<'_>, (_, tau, end): Moment) -> f64 {
        let at = self.at[end as usize];
        match self.law {
            Law::Resistance(_) => at.resistance * self.flow(step, tau) + at.pressure,
            Law::Windkessel(_) => at.resistance * self.flow(step, tau) + self.scalar_at(step, tau),
            Law::Flow(_) => self.scalar_at(step, tau),
        }
    }

    /// The equation of the scalar unknown.
    fn equation(&self, step: &StepView<'_>) -> f64 {
        match self.law {
            Law::Resistance(_) => 0.0,
            Law::Flow(_) => self.flow(step, given_at(step)) - self.at[End::New as usize].flow,
            Law::Windkessel(_) => {
                let [old, new] = [step.old, step.new].map(|state| state.s[self.scalar.0]);
                let capacitance = self.at[End::New as usize].capacitance;
                let rates = self.moments(step).map(|(weight, tau, end)| {
                    let at = self.at[end as usize];
                    let drained = (self.scalar_at(step, tau) - at.pressure) / at.distal;
                    weight * (self.flow(step, tau) - drained)
                });
                capacitance * step.rule.per_k * (new - old) - rates.sum::<f64>()
            }
        }
    }

    /// Add ⟨cof(F) N, φ⟩ of a moment times `column` to `self.column`, and the derivative of Q times `row` to `self.row`:
    /// with respect to v, and in the whole matrix to u.
    fn add_derivatives(&mut self, matrix: Matrix, step: &StepView<'_>, tau: f64, [column, row]: [f64; 2]) {
        let mut columns = std::mem::take(&mut self.column);
        let [mut of_v, mut of_u] = std::mem::take(&mut self.row);
        let with_u = self.deforms && matrix == Matrix::Whole;
        let (mut at, mut seen) = (0, 0);
        self.visit(step, tau, |facet, q, normal, relative| {
            if q == 0 {
                (at, seen) = (seen, seen + facet.nodes.len());
            }
            let point = &facet.points[q];
            let of = |state: &State| fields_at(&facet.nodes, &point.value, &point.grad, state);
            let moved = with_u.then(|| of(step.old).lerp(&of(step.new), tau));
            for (a, &node) in self.local[at..seen].iter().enumerate() {
                for i in 0..D {
                    let (place, value) = (node as usize * D + i, point.value[a] * normal.0[i]);
                    columns[place] += column * value;
                    of_v[place] += row * tau * value;
                    if let Some(at) = &moved {
                        let weight = point.weight * point.stretch(&at.u);
                        let mut slope = normal_slope(&at.grad_u, &point.normal, i, &point.grad[a]) * weight;
                        if let (Some(r), 0) = (point.radius, i) {
                            slope += normal * (point.value[a] / (r + at.u.0[0]));
                        }
                        of_u[place] += row * (tau * relative.dot(slope) - step.rule.per_k * value);
                    }
                }
            }
        });
        (self.column, self.row) = (columns, [of_v, of_u]);
    }

    fn clear_derivatives(&mut self) {
        self.column.fill(0.0);
        self.row.iter_mut().for_each(|row| row.fill(0.0));
    }

    /// Take the derivatives into a border.
    fn fill(&self, matrix: Matrix, border: &mut Border) {
        let places = || self.nodes.iter().flat_map(|&node| (0..D as u32).map(move |i| node * D as u32 + i));
        // Of a product with a vector each process has the entries of its own nodes.
        let own = |n: usize| {
            let entries = places().zip(self.row[n].iter().copied()).enumerate();
            entries.filter(|(n, _)| self.own[n / D]).map(|(_, entry)| entry)
        };
        border.column.extend(places().zip(self.column.iter().copied()));
        border.row.extend(own(0));
        if self.deforms && matrix == Matrix::Whole {
            border.row.extend(own(1).map(|(at, b)| (at + self.n_v as u32, b)));
        }
    }
}

/// Where in the step a flow is given: where its data are taken.
fn given_at(step: &StepView<'_>) -> f64 {
    if step.rule.quadrature.is_empty() { 1.0 } else { 0.5 }
}

/// The derivative of cof(F) N where ∇w has the row `i` equal to `grad`.
fn normal_slope<const D: usize>(
    grad_u: &crate::math::Tensor<f64, D>,
    normal: &Vector<f64, D>,
    i: usize,
    grad: &[f64; D],
) -> Vector<f64, D> {
    let kinematics = crate::physics::Kinematics::of(grad_u);
    let n = kinematics.F_inv.t() * *normal * kinematics.J;
    let along: f64 = (0..D).map(|d| kinematics.F_inv.0[d][i] * grad[d]).sum();
    // F⁻ᵀ ∇wᵀ n with ∇wᵀ n = grad n_i.
    n * along - kinematics.F_inv.t() * Vector(*grad) * n.0[i]
}

impl<const D: usize> Operator<D> for Outlet<D> {
    fn body(&self) -> Region {
        Region::Fluid
    }

    fn set_data(&mut self, at: &DataTime) -> Result<(), NotFinite<D>> {
        let mut values = Parameters::default();
        match &self.law {
            Law::Resistance(numbers) => [values.resistance, values.pressure] = numbers(at.time),
            Law::Windkessel(numbers) => {
                [values.resistance, values.capacitance, values.distal, values.pressure] = numbers(at.time);
                // Nothing drains through no resistance or a negative one.
                if values.distal <= 0.0 {
                    values.distal = f64::NAN;
                }
            }
            Law::Flow(numbers) => [values.flow] = numbers(at.time),
        }
        values.pressure *= at.load;
        values.flow *= at.load;
        let Parameters { resistance, capacitance, distal, pressure, flow } = values;
        if let Some(&value) =
            [resistance, capacitance, distal, pressure, flow].iter().find(|value| !value.is_finite())
        {
            let x = self.load.facets.first().map_or([0.0; D], |facet| facet.points[0].x);
            return Err(NotFinite { boundary: self.boundary, at: x, value: [value; D] });
        }
        self.at[at.end as usize] = values;
        Ok(())
    }

    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        for moment in self.moments(step) {
            let p = moment.0 * self.pressure(step, moment);
            self.visit(step, moment.1, |facet, q, normal, _| {
                for (value, &node) in facet.points[q].value.iter().zip(&facet.nodes) {
                    for i in 0..D {
                        out[node as usize * D + i] += p * value * normal.0[i];
                    }
                }
            });
        }
        if self.has_scalar() {
            out[self.scalar.1] += self.equation(step);
        }
        f64::INFINITY
    }

    fn entries(&self, matrix: Matrix, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        self.load.entries(matrix, number, visit);
    }

    fn place(&mut self, matrix: Matrix, number: &[u32], entries: &Entries<'_>) -> Result<(), SolverError> {
        self.load.place(matrix, number, entries)
    }

    fn linearise(&mut self, matrix: Matrix, step: &StepView<'_>, how: How, out: Sink<'_>) {
        let p = self.pressure(step, (1.0, 1.0, End::New));
        self.load.term.set(p);
        self.load.linearise(matrix, step, how, out);
    }

    fn apply(&mut self, matrix: Matrix, step: &StepView<'_>, x: &[f64], y: &mut [f64]) {
        let p = self.pressure(step, (1.0, 1.0, End::New));
        self.load.term.set(p);
        self.load.apply(matrix, step, x, y);
    }

    fn scalars(&self) -> usize {
        usize::from(self.has_scalar())
    }

    fn scalars_are_algebraic(&self) -> bool {
        self.is_flow()
    }

    fn scalar_start(&self) -> f64 {
        self.start
    }

    fn number_scalars(&mut self, first: usize, row: usize) {
        self.scalar = (first, row);
    }

    fn borders(&mut self, matrix: Matrix, step: &StepView<'_>, borders: &mut Borders) {
        let is_flow = self.is_flow();
        for (weight, tau, end) in self.moments(step).filter(|_| !is_flow) {
            let factor = weight * self.at[end as usize].resistance;
            if factor != 0.0 && (tau != 0.0 || (self.deforms && matrix == Matrix::Whole)) {
                self.clear_derivatives();
                self.add_derivatives(matrix, step, tau, [factor, 1.0]);
                self.fill(matrix, borders.coupling());
            }
        }
        if !self.has_scalar() {
            return;
        }
        self.clear_derivatives();
        let mut corner = 0.0;
        if is_flow {
            self.add_derivatives(matrix, step, 1.0, [1.0, 0.0]);
            self.add_derivatives(matrix, step, given_at(step), [0.0, 1.0]);
        } else {
            corner = self.at[End::New as usize].capacitance * step.rule.per_k;
            for (weight, tau, end) in self.moments(step) {
                corner += weight * tau / self.at[end as usize].distal;
                self.add_derivatives(matrix, step, tau, [weight * tau, -weight]);
            }
        }
        self.fill(matrix, borders.scalar(self.scalar.0, corner));
    }

    fn force_through(&self, step: &StepView<'_>, sides: &[Side]) -> Vector<f64, D> {
        let mut sum = Vector::zero();
        for moment in self.moments(step) {
            let p = moment.0 * self.pressure(step, moment);
            self.visit(step, moment.1, |facet, _, normal, _| {
                if sides.contains(&facet.side) {
                    sum += normal * p;
                }
            });
        }
        sum
    }
}
