//! Manufactured solutions: right-hand sides that make given fields the solution.
//!
//! The right-hand side is the weak form at the exact fields at quadrature points. It needs no second
//! derivatives and contains the jump of the traction at the interface and the traction at the outflow.

use crate::algebra::{FaerLu, MultifrontalLu};
use crate::linear::{Linear, MakeSolver, Scales};
use crate::math::{Dual, Scalar, Tensor, Vector};
use crate::nonlinear::{Newton, NewtonSettings};
use crate::physics::kinematics::cofactor;
use crate::physics::{Dots, FacetForm, Fields, Fluid, Outflow, Place, StepRule, Tested, WeakForm};
use crate::sampling::for_each_point;
use crate::sampling::{FacetPoint, facet_points};
use crate::space::{BoundaryCondition, FsiSpace, PressureKind, PsiOwner, Region, State};
use crate::system::{Assembler, Dim, Kernels, Options, Physics};
use crate::tangent::Tangent;
use crate::time::stepper::Source;
use crate::time::{DomainMotion, Linearization, Scheme, Stepper, StepperSettings};
use std::sync::Arc;

/// A number with its derivative in one direction of space or time.
pub type Number = Dual<f64>;

/// Exact fields at one point and time.
#[derive(Copy, Clone, Debug)]
pub struct Values<const D: usize = 2> {
    /// Velocity \[m/s\].
    pub v: [Number; D],
    /// Deformation \[m\]; it vanishes where the spaces do.
    pub u: [Number; D],
    /// Pressure \[Pa\].
    pub p: Number,
}

/// Exact fields as functions of position and time.
pub type Exact<const D: usize = 2> = Arc<dyn Fn([Number; D], Number) -> Values<D> + Send + Sync>;

/// Sine.
pub fn sin(x: Number) -> Number {
    Dual { re: x.re.sin(), eps: x.re.cos() * x.eps }
}

/// Cosine.
pub fn cos(x: Number) -> Number {
    Dual { re: x.re.cos(), eps: -x.re.sin() * x.eps }
}

/// Exact fields with their derivatives.
#[derive(Copy, Clone, Debug)]
pub struct Sample<const D: usize = 2> {
    /// Values and gradients.
    pub fields: Fields<f64, D>,
    /// ∂_t v and ∂_t u.
    pub dots: Dots<f64, D>,
    /// ∇p \[Pa/m\].
    pub grad_p: [f64; D],
}

/// `exact` at `x` and `t` with all first derivatives.
pub fn sample<const D: usize>(exact: &Exact<D>, x: [f64; D], t: f64) -> Sample<D> {
    let seed = |value: f64, is_seed: bool| Dual { re: value, eps: f64::from(is_seed) };
    // Along axis n of space, or along time, the last one.
    let along = |n: usize| exact(std::array::from_fn(|d| seed(x[d], d == n)), seed(t, n == D));
    let (slopes, in_time): ([Values<D>; D], _) = (std::array::from_fn(along), along(D));
    let value = |a: [Number; D]| Vector(a.map(|a| a.re));
    let slope = |a: [Number; D]| Vector(a.map(|a| a.eps));
    let grad = |field: &dyn Fn(&Values<D>) -> [Number; D]| {
        Tensor(std::array::from_fn(|i| std::array::from_fn(|j| field(&slopes[j])[i].eps)))
    };
    Sample {
        fields: Fields {
            v: value(in_time.v),
            grad_v: grad(&|at| at.v),
            u: value(in_time.u),
            grad_u: grad(&|at| at.u),
            p: in_time.p.re,
        },
        dots: Dots { v: slope(in_time.v), u: slope(in_time.u), domain: slope(in_time.u) },
        grad_p: slopes.map(|at| at.p.eps),
    }
}

/// What the right-hand side of a step does about time.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum InTime {
    /// Exact ∂_t: θ F(t) + (1 − θ) F(t⁻) for momentum and relation, the constraints at the new time.
    Derivative,
    /// The formula of the step at the exact fields, p at t⁻ + θ k: no error in time is left.
    Difference,
}

/// A problem whose solution is known.
#[derive(Clone)]
pub struct Manufactured<const D: usize = 2> {
    /// Spaces.
    pub space: Arc<FsiSpace<D>>,
    /// Equations.
    pub physics: Physics,
    /// One condition per boundary of the mesh.
    pub conditions: Vec<BoundaryCondition<D>>,
    /// Solution.
    pub exact: Exact<D>,
    /// How time derivatives enter.
    pub in_time: InTime,
    /// Whether momentum and divergence in the fluid have a right-hand side.
    pub fluid: bool,
    /// Gauss points per direction of the right-hand side.
    pub quadrature: usize,
}

/// L² norms of errors.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// On all of Ω \[m²/s\].
    pub v: f64,
    /// On all of Ω \[m²\].
    pub u: f64,
    /// Where there is a pressure \[Pa m\].
    pub p: f64,
}

impl<const D: usize> Manufactured<D>
where
    Dim<D>: Kernels<D>,
{
    /// Assembly of the problem, E_e = 1.
    pub fn assembler(&self, options: &Options) -> Assembler<D> {
        Assembler::new(self.space.clone(), self.physics, &self.conditions, &|_| 1.0, options)
    }

    /// The problem ready to be solved from the interpolated solution at `time`; with `zero` from rest.
    pub fn stepper(&self, scheme: Scheme, time: f64, zero: bool, options: &Options) -> Stepper<D> {
        let assembler = self.assembler(options);
        let make: MakeSolver = Box::new(|_| match D {
            // Fronts are large in space.
            3 => Box::new(MultifrontalLu::multifrontal(crate::algebra::Options::default())),
            _ => Box::new(FaerLu::faer(crate::algebra::Options::default())),
        });
        let linear = Linear::new(Linearization::Newton, make);
        let settings = NewtonSettings {
            tolerance: 1e-11,
            floor: Some(1e-12),
            rate_max: Some(0.1),
            secants: 0,
            max_steps: 30,
            line_search: 8,
        };
        let newton = Newton::new(settings, assembler.n_unknowns(), self.space.n_v());
        let settings = StepperSettings {
            scheme,
            domain_motion: DomainMotion::Secant,
            tangent: Tangent::Automatic,
            extrapolate: true,
            max_halvings: 0,
            scales: self.scales(),
        };
        let space = &self.space;
        let initial = match zero {
            true => State::zero(space.n_v(), space.n_u(), space.n_p()),
            false => self.interpolate(time),
        };
        let mut stepper = Stepper::new(assembler, newton, linear, settings, time, initial, vec![]);
        stepper.source = Some(self.source());
        stepper
    }

    fn scales(&self) -> Scales {
        let density = self.physics.fluid.map(|f| f.rho).or(self.physics.solid.map(|s| s.rho));
        let (density, viscosity) = (density.unwrap_or(1.0), self.physics.fluid.map_or(0.0, |f| f.nu));
        let modulus = if self.physics.solid.is_some() { 1.0 } else { 0.0 };
        Scales::new(&self.space, density, viscosity, modulus, 1.0)
    }

    /// The right-hand side as a stepper takes it.
    pub fn source(&self) -> Source {
        let (problem, facets) = (self.clone(), self.outflow());
        let mut rows = vec![0.0; self.space.n_field_unknowns()];
        Box::new(move |t_old, t, theta, out| {
            problem.weak_form(&facets, t_old, t, theta, None, &mut rows);
            for (out, row) in out.iter_mut().zip(&rows) {
                *out -= row;
            }
        })
    }

    /// Quadrature points of the facets with the do-nothing correction, with the nodes of their cells.
    pub fn outflow(&self) -> Vec<(Vec<u32>, Vec<FacetPoint<D>>)> {
        let do_nothing = |b: u16| {
            matches!(self.conditions[b as usize], BoundaryCondition::Outflow { do_nothing: true, .. })
        };
        let of_fluid = |cell: u32| self.space.regions[cell as usize] == Region::Fluid;
        let facets = self.space.mesh.facets.iter().filter(|f| do_nothing(f.boundary) && of_fluid(f.cell));
        let nodes = |cell: u32| self.space.nodes.cell(cell as usize).to_vec();
        facets.map(|f| (nodes(f.cell), facet_points(&self.space, f, self.quadrature))).collect()
    }

    /// The weak form at the exact fields `[v, u, p]`, all regions or `only` one; `t_old = t` is stationary.
    pub fn weak_form(
        &self,
        outflow: &[(Vec<u32>, Vec<FacetPoint<D>>)],
        t_old: f64,
        t: f64,
        theta: f64,
        only: Option<Region>,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        let space = &*self.space;
        let (n_v, n_u) = (space.n_v(), space.n_u());
        let zero = State::zero(n_v, n_u, space.n_p());
        for_each_point(space, &zero, self.quadrature, |point| {
            let region = point.region;
            if only.is_some_and(|only| only != region) {
                return;
            }
            let (tested, owner) = match region {
                Region::Fluid => (
                    self.physics.fluid.map(|f| self.tested(&f, point.x, t_old, t, theta)),
                    PsiOwner::Extension,
                ),
                Region::Solid => (
                    self.physics.solid.map(|f| self.tested(&f, point.x, t_old, t, theta)),
                    PsiOwner::Relation,
                ),
            };
            let Some(r) = tested else { return };
            let momentum = region == Region::Solid || self.fluid;
            for (a, &node) in space.nodes.cell(point.cell).iter().enumerate() {
                let (value, grad) = (point.value[a] * point.weight, Vector(point.grad[a]) * point.weight);
                let [phi, psi] = [r.phi * value + r.grad_phi * grad, r.psi * value + r.grad_psi * grad];
                for i in 0..D {
                    let row = node as usize * D + i;
                    if momentum {
                        out[row] += phi.0[i];
                    }
                    if space.deforms && space.owner[node as usize] == owner {
                        out[n_v + row] += psi.0[i];
                    }
                }
            }
            for (&dof, basis) in space.pressure.cell(point.cell).iter().zip(point.pressure) {
                if momentum {
                    out[n_v + n_u + dof as usize] += r.xi * basis * point.weight;
                }
            }
        });
        if let (Some(fluid), true) = (self.physics.fluid, self.fluid && only != Some(Region::Solid)) {
            self.add_outflow(&fluid, outflow, [t_old, t], theta, out);
        }
    }

    /// Adds the do-nothing correction at the exact fields, from t⁻ to t.
    fn add_outflow(
        &self,
        fluid: &Fluid,
        outflow: &[(Vec<u32>, Vec<FacetPoint<D>>)],
        [t_old, t]: [f64; 2],
        theta: f64,
        out: &mut [f64],
    ) {
        let form = Outflow { viscosity: fluid.rho * fluid.nu, thinning: fluid.thinning };
        for (nodes, points) in outflow {
            for p in points {
                let at = |t: f64| sample(&self.exact, p.x, t).fields;
                let traction =
                    |at: Fields<f64, D>, weight: f64| form.traction(&at, &at, &p.normal, weight * p.weight);
                let force = traction(at(t), theta) + traction(at(t_old), 1.0 - theta);
                for (value, &node) in p.value.iter().zip(nodes) {
                    for i in 0..D {
                        out[node as usize * D + i] += value * force.0[i];
                    }
                }
            }
        }
    }

    /// What stands before the test functions at one point.
    fn tested<F: WeakForm<D>>(
        &self,
        form: &F,
        x: [f64; D],
        t_old: f64,
        t: f64,
        theta: f64,
    ) -> Tested<f64, D> {
        let place = Place::plain();
        let (new, old) = (sample(&self.exact, x, t), sample(&self.exact, x, t_old));
        let mut r = Tested::zero();
        if self.in_time == InTime::Difference || t == t_old {
            let rule = if t == t_old { StepRule::STATIONARY } else { StepRule::theta(t - t_old, theta) };
            let mut at = new.fields;
            at.p = sample(&self.exact, x, t_old + theta * (t - t_old)).fields.p;
            rule.residual(form, &place, &at, &at, &old.fields, &mut r);
            rule.explicit(form, &place, &old.fields, &mut r);
            return r;
        }
        for (weight, Sample { fields, dots, .. }) in [(theta, new), (1.0 - theta, old)] {
            let mut part = Tested::zero();
            form.rate(&dots, &form.inertia(&fields, &fields), &mut part);
            form.transport(&place, &fields, &fields, 1.0, &mut part);
            form.pressure(fields.p, &cofactor(&fields.grad_u), &mut part);
            r.phi += weight * part.phi;
            r.grad_phi += weight * part.grad_phi;
            r.psi += weight * part.psi;
        }
        form.constraint(&place, &new.fields, &new.fields, &mut r);
        let mut at = new.fields;
        at.p = theta * new.fields.p + (1.0 - theta) * old.fields.p;
        form.volume(&StepRule::theta(t - t_old, theta), &place, &at, &at, &old.fields, &mut r);
        r
    }

    /// The exact solution at the nodes; a discontinuous pressure is its tangent at the centre of the cell.
    pub fn interpolate(&self, t: f64) -> State {
        let space = &self.space;
        let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
        for (node, x) in space.nodes.points.iter().enumerate() {
            let f = sample(&self.exact, *x, t).fields;
            state.v[D * node..D * (node + 1)].copy_from_slice(&f.v.0);
            if space.deforms {
                state.u[D * node..D * (node + 1)].copy_from_slice(&f.u.0);
            }
        }
        // Bubbles stand beside the interpolation.
        let bubbles = D * space.nodes.n_lagrange;
        state.v[bubbles..].fill(0.0);
        if space.deforms {
            state.u[bubbles..].fill(0.0);
        }
        for cell in 0..space.mesh.n_cells() {
            for (a, &dof) in space.pressure.cell(cell).iter().enumerate() {
                let s = sample(&self.exact, space.pressure.points[dof as usize], t);
                state.p[dof as usize] = match (space.pressure.kind, a) {
                    (PressureKind::Continuous(_), _) | (_, 0) => s.fields.p,
                    (PressureKind::Pdc(_), a) if a <= D => s.grad_p[a - 1] * space.pressure.frames[cell].1,
                    (PressureKind::Pdc(_), _) => 0.0,
                };
            }
        }
        state
    }

    /// Errors of `state`: v and u against time `t`, p against time `t_p`; `n` Gauss points per direction.
    pub fn errors(&self, state: &State, t: f64, t_p: f64, n: usize) -> Errors {
        let (mut e, deforms) = (Errors::default(), self.space.deforms);
        let square = |a: Vector<f64, D>| a.dot(a);
        for_each_point(&self.space, state, n, |point| {
            let exact = sample(&self.exact, point.x, t).fields;
            e.v += point.weight * square(point.fields.v - exact.v);
            if deforms {
                e.u += point.weight * square(point.fields.u - exact.u);
            }
            if !point.pressure.is_empty() {
                let p = sample(&self.exact, point.x, t_p).fields.p;
                e.p += point.weight * (point.fields.p - p).powi(2);
            }
        });
        Errors { v: e.v.sqrt(), u: e.u.sqrt(), p: e.p.sqrt() }
    }
}

/// A constant.
pub fn number(x: f64) -> Number {
    Number::constant(x)
}
