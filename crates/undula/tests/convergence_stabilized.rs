//! Orders of convergence in space of stabilised pairs of equal order on a moving domain.
//!
//! Local projections are not consistent: what they add is of the order of the error. The residual methods are, so
//! that they see the body force, which is given as such here.
#![allow(non_snake_case)]

#[path = "common/manufactured.rs"]
mod manufactured;

use manufactured::*;
use undula::assembly::points::for_each_point;
use undula::assembly::{End, Options, Physics};
use undula::math::Tensor;
use undula::physics::{Kinematics, PressureTerm, Projection, Stabilization, TransportTerm};
use undula::problem::manufactured::{Errors, Exact, InTime, Manufactured, sample};
use undula::space::PressureKind::Continuous;
use undula::space::{Region, State};
use undula::time::Scheme;

/// J σ F⁻ᵀ of the exact solution.
fn stress(exact: &Exact, x: [f64; 2], t: f64) -> Tensor<f64, 2> {
    let at = sample(exact, x, t).fields;
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let G = at.grad_v * F_inv;
    let sigma = FLUID.rho * FLUID.nu * (G + G.t()) - Tensor::identity() * at.p;
    sigma * F_inv.t() * J
}

/// The force per mass with which the stationary momentum equation holds at a point.
fn force(exact: &Exact, x: [f64; 2], t: f64) -> [f64; 2] {
    let at = sample(exact, x, t).fields;
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let rate = at.grad_v * (F_inv * at.v);
    let h = 1e-4;
    std::array::from_fn(|i| {
        let divergence: f64 = (0..2)
            .map(|j| {
                let moved = |s: f64| {
                    let mut x = x;
                    x[j] += s;
                    stress(exact, x, t).0[i][j]
                };
                (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h)
            })
            .sum();
        rate.0[i] - divergence / (FLUID.rho * J)
    })
}

struct Run {
    physics: Physics,
    how: Stabilization,
    degree: usize,
    cells: Cells,
    /// 0 is stationary, else so many of θ = 0.51 without error in time.
    steps: usize,
}

impl Run {
    fn problem(&self, n: usize, quadrature: usize) -> Manufactured {
        let cells = self.cells;
        // Patches come from a refinement.
        let mesh = match self.how.projection {
            Projection::Cell => square(n, cells, Body::Half),
            Projection::Patch => square(n / 2, cells, Body::Half).refined(1, &[]),
        };
        let (physics, exact) = (self.physics, smooth(self.physics.solid.is_some()));
        let space = space(&mesh, &physics, self.degree, Continuous(self.degree));
        problem_in(space, physics, exact, InTime::Difference, quadrature)
    }

    /// Errors with `n` cells per direction.
    fn errors(&self, n: usize) -> Errors {
        let quadrature = self.degree + 3;
        let problem = self.problem(n, quadrature);
        let scheme = Scheme::Theta { theta: 0.51 };
        let options = Options::serial(self.degree + 1);
        let mut stepper = problem.stepper(scheme, 0.0, false, &options);
        stepper.assembler.stabilize(&self.how, &options);
        stepper.newton.settings.floor = 1e-8;
        if self.how.has_residual() {
            let exact = problem.exact.clone();
            stepper.assembler.set_force(Region::Fluid, End::New, Some(&|x| force(&exact, *x, 0.0)));
            stepper.source = Some(with_force(&problem, quadrature));
        }
        if self.steps == 0 {
            stepper.stationary().unwrap();
        }
        for _ in 0..self.steps {
            stepper.step(0.25).unwrap();
        }
        problem.errors(&stepper.new, stepper.time, stepper.force_time(), quadrature)
    }

    /// Orders between the last two of `levels`, at least `least` for v, u, p.
    fn check(&self, name: &str, levels: [usize; 3], least: [f64; 3]) {
        let list = |e: Errors| [e.v, e.u, e.p];
        let errors = levels.map(|n| list(self.errors(n)));
        let mut failures = vec![];
        for (i, field) in ["v", "u", "p"].into_iter().enumerate().filter(|(i, _)| least[*i] > 0.0) {
            let all: Vec<String> = errors.iter().map(|e| format!("{:.4e}", e[i])).collect();
            let order = (errors[1][i] / errors[2][i]).log2();
            let line = format!("{name} {field}: {} order {order:.3}", all.join(" "));
            println!("{line}");
            if order.is_nan() || order < least[i] {
                failures.push(line);
            }
        }
        assert!(failures.is_empty(), "expected {least:?}: {failures:#?}");
    }
}

/// The source of `problem` with the body force of the fluid taken off: −A(U)(φ) + (ρ J f, φ).
fn with_force(problem: &Manufactured, quadrature: usize) -> undula::time::stepper::Source {
    let (mut source, problem) = (problem.source(), problem.clone());
    Box::new(move |t_old, t, theta, out| {
        source(t_old, t, theta, out);
        let space = &*problem.space;
        let zero = State::zero(space.n_v(), space.n_u(), space.n_p());
        for_each_point(space, &zero, quadrature, |point| {
            if point.region != Region::Fluid {
                return;
            }
            let f = force(&problem.exact, point.x, t);
            let J = Kinematics::of(&sample(&problem.exact, point.x, t).fields.grad_u).J;
            for (&node, value) in space.nodes.cell(point.cell).iter().zip(point.value) {
                for i in 0..2 {
                    out[2 * node as usize + i] += FLUID.rho * J * f[i] * value * point.weight;
                }
            }
        });
    })
}

const LPS: Stabilization = Stabilization {
    pressure: PressureTerm::LocalProjection,
    transport: TransportTerm::LocalProjection,
    ..Stabilization::NONE
};
const RESIDUAL: Stabilization = Stabilization {
    pressure: PressureTerm::Pspg,
    transport: TransportTerm::Supg,
    alpha: 0.1,
    delta: 0.1,
    ..Stabilization::NONE
};

const Q1: [usize; 3] = [8, 16, 32];
const Q2: [usize; 3] = [4, 8, 16];

const Q1_Q1: Run = Run { physics: FSI, how: LPS, degree: 1, cells: Cells::Square, steps: 0 };
const Q2_Q2: Run = Run { degree: 2, cells: Cells::Curved, ..Q1_Q1 };

/// Half an order of the pressure is a gift of equal squares: on trapezia it is 1, as proved.
#[test]
fn q1_q1_with_local_projection() {
    Q1_Q1.check("Q1-Q1 lps", Q1, [1.9, 1.9, 1.4]);
    Run { cells: Cells::Trapezia, ..Q1_Q1 }.check("Q1-Q1 lps on trapezia", Q1, [1.9, 1.9, 1.0]);
    let how = Stabilization { projection: Projection::Patch, ..LPS };
    Run { how, ..Q1_Q1 }.check("Q1-Q1 lps on patches", Q1, [1.9, 1.9, 1.4]);
}

#[test]
fn q1_q1_with_brezzi_pitkaranta() {
    let how = Stabilization { pressure: PressureTerm::BrezziPitkaranta, ..Stabilization::NONE };
    Run { how, ..Q1_Q1 }.check("Q1-Q1 brezzi-pitkaranta", Q1, [1.9, 1.9, 1.4]);
    let how = Stabilization { directional: true, ..how };
    let run = Run { how, cells: Cells::Trapezia, ..Q1_Q1 };
    run.check("Q1-Q1 brezzi-pitkaranta, directional", Q1, [1.9, 1.9, 1.0]);
}

#[test]
fn q2_q2_with_local_projection() {
    Q2_Q2.check("Q2-Q2 lps", Q2, [2.8, 2.8, 1.85]);
    Run { steps: 2, ..Q2_Q2 }.check("Q2-Q2 lps in time", Q2, [2.8, 2.8, 1.85]);
}

#[test]
fn q2_q2_with_local_projection_on_patches() {
    let how = Stabilization { projection: Projection::Patch, ..LPS };
    Run { how, ..Q2_Q2 }.check("Q2-Q2 lps on patches", Q1, [2.8, 2.8, 1.85]);
}

#[test]
fn residual_methods() {
    Run { how: RESIDUAL, ..Q1_Q1 }.check("Q1-Q1 pspg supg", Q1, [1.9, 1.9, 1.4]);
    Run { how: RESIDUAL, ..Q2_Q2 }.check("Q2-Q2 pspg supg", Q2, [2.8, 2.8, 1.85]);
}
