//! The tangents at the points of a batch, each way of computing them compiled on its own.

use super::kernel::{Kernel, Scratch};
use crate::loops::evaluate::pull_back;
use crate::loops::width::{Task, Width};
use crate::math::{Lanes, Scalar, Tensor};
use crate::operators::{End, StepView};
use crate::physics::{Fields, Place, StepRule, Tested};
use crate::tangent::{Difference, Linearization, StepForm, Tangent, automatic, seeded};

/// In which directions tangents are computed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Directions {
    /// v, u and p.
    All,
    /// v and p; u moves by `coupling` times v.
    Condensed {
        /// kθ in the solid, else 0 \[s\].
        coupling: f64,
    },
    /// v and p; u in the extension alone: the fluid of the reduced Jacobian.
    Flow,
}

/// The tangents at all points of a batch, or its element matrix where that comes from differences in nodal values.
pub(super) struct TangentTasks<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) linearization: Linearization,
    pub(super) tangent: Tangent,
    pub(super) directions: Directions,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
}

impl<F: StepForm<D>, const D: usize, const L: usize> TangentTasks<'_, F, D, L>
where
    Lanes<L>: Width,
{
    pub(super) fn run(self) {
        let lagged = self.linearization == Linearization::FixedPoint;
        if let Some(by) = self.tangent.nodal() {
            let Self { kernel, step, linearization, directions, batch, scratch, .. } = self;
            return kernel.differences(step, linearization, by, directions, batch, scratch);
        }
        match self.tangent {
            Tangent::Difference(by) => self.dispatch(ByLane::Difference { by, lagged }),
            _ if lagged => self.dispatch(ByLane::Duals { lagged }),
            Tangent::Automatic => self.dispatch(Automatic),
            Tangent::Analytic => self.dispatch(ByLane::Analytic),
        }
    }

    #[inline(always)]
    fn dispatch<H: How<F, D, L>>(self, how: H) {
        let TangentTasks { kernel, step, directions, batch, scratch, .. } = self;
        if directions == Directions::Flow {
            let scratch = &mut *scratch;
            Lanes::<L>::dispatch(ExtensionTask { kernel, step, batch, scratch });
        }
        Lanes::<L>::dispatch(TangentTask { kernel, step, directions, batch, scratch, how });
    }
}

/// What a tangent is taken of: the equations and the fields at a point.
pub(super) struct Point<'a, F, const D: usize, const L: usize> {
    pub(super) form: &'a F,
    pub(super) rule: &'a StepRule,
    pub(super) place: &'a Place<Lanes<L>, D>,
    pub(super) new: &'a Fields<Lanes<L>, D>,
    pub(super) old: &'a Fields<Lanes<L>, D>,
}

/// How a tangent is computed, as a type: each way is compiled on its own.
trait How<F, const D: usize, const L: usize> {
    fn tangent(&self, at: &Point<'_, F, D, L>, direction: &Fields<Lanes<L>, D>) -> Tested<Lanes<L>, D>;
}

/// Dual numbers, in all lanes at a time.
struct Automatic;

impl<F: StepForm<D>, const D: usize, const L: usize> How<F, D, L> for Automatic {
    #[inline(always)]
    fn tangent(&self, at: &Point<'_, F, D, L>, direction: &Fields<Lanes<L>, D>) -> Tested<Lanes<L>, D> {
        automatic(at.form, at.rule, at.place, at.new, at.old, direction)
    }
}

/// What is computed lane by lane: rarely taken, it would take minutes to compile for every vector width.
#[derive(Copy, Clone)]
pub(super) enum ByLane {
    Analytic,
    /// Dual numbers.
    Duals {
        /// Of the fixed-point iteration.
        lagged: bool,
    },
    Difference {
        by: Difference,
        /// Of the fixed-point iteration.
        lagged: bool,
    },
}

/// A point in one lane.
struct Single<'a, F, const D: usize> {
    form: &'a F,
    rule: &'a StepRule,
    place: Place<f64, D>,
    new: Fields<f64, D>,
    old: Fields<f64, D>,
}

impl<F: StepForm<D>, const D: usize> Single<'_, F, D> {
    #[inline(never)]
    fn tangent(&self, how: ByLane, direction: &Fields<f64, D>) -> Tested<f64, D> {
        match how {
            ByLane::Analytic => self.analytic(direction),
            ByLane::Duals { lagged } => self.duals(lagged, direction),
            ByLane::Difference { by, lagged } => self.difference(&by, lagged, direction),
        }
    }

    #[inline(never)]
    fn analytic(&self, direction: &Fields<f64, D>) -> Tested<f64, D> {
        self.form.analytic(self.rule, &self.place, &self.new, &self.old, direction)
    }

    #[inline(never)]
    fn duals(&self, lagged: bool, direction: &Fields<f64, D>) -> Tested<f64, D> {
        let new = seeded(&self.new, direction);
        let lag = if lagged { new.frozen() } else { new };
        let mut r = Tested::zero();
        self.form.residual(self.rule, &self.place, &new, &lag, &self.old, &mut r);
        r.map(|x| x.eps)
    }

    #[inline(never)]
    fn difference(&self, by: &Difference, lagged: bool, direction: &Fields<f64, D>) -> Tested<f64, D> {
        let mut base = Tested::zero();
        self.form.residual(self.rule, &self.place, &self.new, &self.new, &self.old, &mut base);
        let h = perturbation(by, direction);
        let ends = (&self.new, &self.old);
        by.derivative(lagged, self.form, self.rule, &self.place, ends, &base, (direction, h))
    }
}

impl ByLane {
    /// The tangent in all lanes, into `all`. It moves numbers and computes with none, so that it needs no instructions of
    /// the width.
    #[inline(never)]
    pub(super) fn put<F: StepForm<D>, const D: usize, const L: usize>(
        self,
        at: &Point<'_, F, D, L>,
        direction: &Fields<Lanes<L>, D>,
        all: &mut Tested<Lanes<L>, D>,
    ) {
        for l in 0..L {
            let single = Single {
                form: at.form,
                rule: at.rule,
                place: at.place.map(|x| x.0[l]),
                new: at.new.map(|x| x.0[l]),
                old: at.old.map(|x| x.0[l]),
            };
            put(all, &single.tangent(self, &direction.map(|x| x.0[l])), l);
        }
    }
}

impl<F: StepForm<D>, const D: usize, const L: usize> How<F, D, L> for ByLane {
    #[inline(always)]
    fn tangent(&self, at: &Point<'_, F, D, L>, direction: &Fields<Lanes<L>, D>) -> Tested<Lanes<L>, D> {
        let mut all = Tested::zero();
        self.put(at, direction, &mut all);
        all
    }
}

/// Lane `l` of `all`.
#[inline(always)]
fn put<const D: usize, const L: usize>(all: &mut Tested<Lanes<L>, D>, one: &Tested<f64, D>, l: usize) {
    for i in 0..D {
        all.phi.0[i].0[l] = one.phi.0[i];
        all.psi.0[i].0[l] = one.psi.0[i];
        for d in 0..D {
            all.grad_phi.0[i][d].0[l] = one.grad_phi.0[i][d];
            all.grad_psi.0[i][d].0[l] = one.grad_psi.0[i][d];
        }
    }
    all.xi.0[l] = one.xi;
}

/// h for a direction in which one component moves: ∇u by `epsilon`, else `epsilon` times the size of the field.
///
/// Directions are with respect to reference coordinates, so that v and ∇v move as if a nodal value did.
fn perturbation<const D: usize>(by: &Difference, direction: &Fields<f64, D>) -> f64 {
    let grad_u = direction.grad_u.ddot(direction.grad_u);
    let u = direction.u.dot(direction.u);
    by.epsilon
        * if grad_u > 0.0 {
            1.0 / grad_u.sqrt()
        } else if direction.p != 0.0 {
            by.sizes.p
        } else if u > 0.0 {
            by.sizes.u / u.sqrt()
        } else {
            by.sizes.v
        }
}

/// The tangent at all points of a batch.
struct TangentTask<'a, F, H, const D: usize, const L: usize> {
    kernel: &'a Kernel<F, D, L>,
    step: &'a StepView<'a>,
    directions: Directions,
    batch: usize,
    scratch: &'a mut Scratch<D, L>,
    how: H,
}

impl<F: StepForm<D>, H: How<F, D, L>, const D: usize, const L: usize> Task for TangentTask<'_, F, H, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        let b = &k.batches;
        let components = Fields::<f64, D>::COMPONENTS;
        let (with_u, coupling) = match self.directions {
            Directions::All => (k.deforms, 0.0),
            Directions::Condensed { coupling } => (false, coupling),
            Directions::Flow => (false, 0.0),
        };
        k.load(self.step, batch, s, true);
        for q in 0..b.n_points {
            let index = batch * b.n_points + q;
            let (new, old) = k.fields(batch, q, s);
            let (point, place) = (&b.points[index], k.place(End::New, index));
            let at = Point { form: &k.form, rule: &self.step.rule, place: &place, new: &new, old: &old };
            let columns = &mut s.tangent[q * components * components..(q + 1) * components * components];
            for (n, column) in columns.chunks_exact_mut(components).enumerate() {
                if !with_u && of_deformation::<D>().contains(&n) {
                    continue;
                }
                let mut direction = reference_direction::<D, L>(n, &point.inverse);
                if coupling != 0.0 {
                    direction.u = direction.v * Lanes::constant(coupling);
                    direction.grad_u = direction.grad_v * Lanes::constant(coupling);
                }
                let t = self.how.tangent(&at, &direction);
                store(&pull_back(&t, point), column);
            }
        }
    }
}

/// The tangent of the extension at all points of a batch: all that the reduced Jacobian has of u in the fluid.
pub(super) struct ExtensionTask<'a, F, const D: usize, const L: usize> {
    pub(super) kernel: &'a Kernel<F, D, L>,
    pub(super) step: &'a StepView<'a>,
    pub(super) batch: usize,
    pub(super) scratch: &'a mut Scratch<D, L>,
}

impl<F: StepForm<D>, const D: usize, const L: usize> Task for ExtensionTask<'_, F, D, L>
where
    Lanes<L>: Width,
{
    #[inline(always)]
    fn run(self) {
        let (k, batch, s) = (self.kernel, self.batch, self.scratch);
        let components = Fields::<f64, D>::COMPONENTS;
        k.load(self.step, batch, s, true);
        for q in 0..k.batches.n_points {
            let index = batch * k.batches.n_points + q;
            let (new, old) = k.fields(batch, q, s);
            let (point, place) = (&k.batches.points[index], k.place(End::New, index));
            let columns = &mut s.tangent[q * components * components..(q + 1) * components * components];
            for n in of_deformation::<D>() {
                let direction = reference_direction::<D, L>(n, &point.inverse);
                let t = k.form.extension(&place, &new, &old, &direction);
                store(&pull_back(&t, point), &mut columns[n * components..(n + 1) * components]);
            }
        }
    }
}

/// Numbers of the components of u and ∇u among the fields.
fn of_deformation<const D: usize>() -> std::ops::Range<usize> {
    D + D * D..2 * (D + D * D)
}

/// The direction in which only component `n` of the fields moves, gradients taken with respect to ξ:
/// ∂v_i/∂x_j = (∂v_i/∂ξ_d) (∂ξ_d/∂x_j).
#[inline(always)]
fn reference_direction<const D: usize, const L: usize>(
    n: usize,
    inverse: &Tensor<Lanes<L>, D>,
) -> Fields<Lanes<L>, D> {
    let mut w = Fields::zero();
    let (d, half) = (D, D + D * D);
    if n == 2 * half {
        w.p = Lanes::constant(1.0);
    } else {
        let (field, m) = (n / half, n % half);
        let (value, grad) = if field == 0 { (&mut w.v, &mut w.grad_v) } else { (&mut w.u, &mut w.grad_u) };
        if m < d {
            value.0[m] = Lanes::constant(1.0);
        } else {
            grad.0[(m - d) / d] = inverse.0[(m - d) % d];
        }
    }
    w
}

/// Write the components of `t` in the order of `Tested`.
#[inline(always)]
fn store<const D: usize, const L: usize>(t: &Tested<Lanes<L>, D>, out: &mut [Lanes<L>]) {
    let half = D + D * D;
    for i in 0..D {
        out[i] = t.phi.0[i];
        out[half + i] = t.psi.0[i];
        for d in 0..D {
            out[D + i * D + d] = t.grad_phi.0[i][d];
            out[half + D + i * D + d] = t.grad_psi.0[i][d];
        }
    }
    out[2 * half] = t.xi;
}
