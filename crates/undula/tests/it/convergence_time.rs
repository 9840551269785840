//! Orders of convergence in time on a moving domain.
//!
//! At every time the solution lies in the spaces (biquadratic v and u on squares, linear p) and the
//! right-hand side is integrated by the rule of the solver, so that all of the error is that of time.

use crate::manufactured::*;
use std::sync::Arc;
use undula::functional::energy::{Energy, Integral};
use undula::functional::{Functional, Snapshot};
use undula::physics::StepRule;
use undula::space::{PressureKind, Region, State};
use undula::time::{Adaptive, AdaptiveSettings, DomainMotion, Scheme};
use undula::verification::manufactured::{Exact, InTime, Manufactured, Values, number, sin};
use undula::verification::unit_square::{in_the_spaces, of_two_profiles};

const SHIFTED: Scheme = Scheme::ShiftedCrankNicolson { shift: 1.0 };

/// Largest errors over all steps: v, u, p at t⁻ + θ k, force at t⁻ + θ k, p at t, force at t.
pub const NAMES: [&str; 6] = ["v", "u", "p", "force", "p read at t", "force read at t"];

/// The residual of the fluid tested with e_x on the nodes `on`.
fn drag_of(on: &[u32], fluid_residual: &[f64]) -> f64 {
    -on.iter().map(|&node| fluid_residual[2 * node as usize]).sum::<f64>()
}

/// From 0 to 1.2 s with `steps` steps, alternating between k and k/2 if `uneven`.
pub fn errors(
    problem: &Manufactured,
    scheme: Scheme,
    motion: DomainMotion,
    steps: usize,
    uneven: bool,
) -> [f64; 6] {
    let mut stepper = problem.stepper(scheme, 0.0, false, &options());
    stepper.settings.domain_motion = motion;
    let drag = problem.space.boundary_nodes("interface");
    let n = problem.space.n_field_unknowns();
    let (mut residual, mut worst) = (vec![0.0; n], [0.0f64; 6]);
    for step in 0..steps {
        let k = match (uneven, step % 2) {
            (false, _) => 1.2 / steps as f64,
            (true, 0) => 1.6 / steps as f64,
            (true, _) => 0.8 / steps as f64,
        };
        stepper.step(k).unwrap();
        let (t, t_force) = (stepper.time, stepper.force_time());
        let mut force = 0.0;
        for part in 0..stepper.n_parts() {
            let (weight, view, assembler) = stepper.part(part);
            assembler.region_residual(&view, Region::Fluid, &mut residual);
            force += weight * drag_of(&drag, &residual);
        }
        let mut exact = |t: f64| {
            problem.weak_form(&problem.outflow(), t - 1.0, t, 1.0, Some(Region::Fluid), &mut residual);
            drag_of(&drag, &residual)
        };
        let new = &stepper.new;
        let (now, at_end) = (problem.errors(new, t, t_force, QUADRATURE), exact(t));
        let late = problem.errors(new, t, t, QUADRATURE).p;
        let all = [now.v, now.u, now.p, (force - exact(t_force)).abs(), late, (force - at_end).abs()];
        // Damping steps excite the fastest modes; in the second half of each interval that is over for p.
        let settled = match scheme {
            Scheme::Rannacher { interval, .. } => (t / interval).fract() > 0.5,
            _ => true,
        };
        for (worst, e) in worst.iter_mut().zip(all).take(if settled { 6 } else { 2 }) {
            *worst = worst.max(e);
        }
    }
    worst
}

/// Orders between 64 and 128 steps of `order` for v, u and, at t⁻ + θ k, p and force; of 1 where these are
/// read at t. Errors of 128 steps as stored.
fn check(name: &str, scheme: Scheme, uneven: bool, order: f64, stored: [f64; 4]) {
    let study = Study { exact: in_the_spaces(), motion: DomainMotion::Secant, uneven, steps: [32, 64, 128] };
    study.check(name, scheme, order, stored);
}

struct Study {
    exact: Exact,
    motion: DomainMotion,
    uneven: bool,
    steps: [usize; 3],
}

impl Study {
    /// With deformations that tell the domain-motion terms apart.
    fn new() -> Study {
        Study { exact: of_two_profiles(), motion: DomainMotion::Secant, uneven: false, steps: [32, 64, 128] }
    }

    fn check(&self, name: &str, scheme: Scheme, order: f64, stored: [f64; 4]) {
        let Study { exact, motion, uneven, steps } = self;
        let mesh = square(4, Cells::Square, Body::Block);
        let problem =
            problem(&mesh, FSI, PressureKind::Pdc(1), exact.clone(), InTime::Derivative, QUADRATURE);
        let e = steps.map(|steps| errors(&problem, scheme, *motion, steps, *uneven));
        let mut failures = vec![];
        for i in 0..6 {
            let found = (e[1][i] / e[2][i]).log2();
            let line = format!(
                "{name}, {}: {:.4e} {:.4e} {:.4e} order {found:.3}",
                NAMES[i], e[0][i], e[1][i], e[2][i]
            );
            println!("{line}");
            let expected = if i < 4 { order } else { 1.0 };
            let other = stored.get(i).is_some_and(|stored| (e[2][i] / stored - 1.0).abs() > 0.02);
            if (found - expected).abs() > 0.15 || other {
                failures.push(line);
            }
        }
        assert!(failures.is_empty(), "expected {stored:?}: {failures:#?}");
    }
}

#[test]
fn backward_euler_is_first_order() {
    check("backward Euler", Scheme::BackwardEuler, false, 1.0, [2.5715e-3, 1.0576e-3, 1.6815e-2, 2.9559e-3]);
}

/// Pressure and force belong to t⁻ + θ k: read at the new time they are of first order.
#[test]
fn crank_nicolson_is_second_order() {
    check("Crank-Nicolson", Scheme::CrankNicolson, false, 2.0, [1.1074e-5, 2.4516e-6, 9.0686e-5, 4.3800e-5]);
}

#[test]
fn shifted_crank_nicolson_is_second_order() {
    check("shifted Crank-Nicolson", SHIFTED, false, 2.0, [5.2853e-5, 2.0637e-5, 3.1789e-4, 5.2462e-5]);
}

#[test]
fn uneven_steps_keep_second_order() {
    check(
        "uneven Crank-Nicolson",
        Scheme::CrankNicolson,
        true,
        2.0,
        [1.5090e-5, 3.2894e-6, 1.4072e-4, 7.0821e-5],
    );
    check("uneven shifted Crank-Nicolson", SHIFTED, true, 2.0, [7.1146e-5, 2.7569e-5, 4.6826e-4, 7.8832e-5]);
}

#[test]
fn theta_above_one_half_is_first_order() {
    Study::new().check(
        "theta = 0.6",
        Scheme::Theta { theta: 0.6 },
        1.0,
        [5.1064e-4, 2.1107e-4, 3.3165e-3, 5.5753e-4],
    );
}

/// Orders alone are asserted.
const NONE: [f64; 4] = [f64::NAN; 4];

/// Pressure and force in the second half of each interval: damping steps themselves are of first order.
#[test]
fn rannacher_is_second_order() {
    let study = Study { steps: [128, 256, 512], ..Study::new() };
    study.check(
        "Rannacher",
        Scheme::Rannacher { steps: 2, interval: 0.6 },
        2.0,
        [3.7071e-5, 2.9780e-6, 6.1953e-5, 7.4562e-5],
    );
}

/// With the means of pressures and forces over the parts, in the middle of the step.
#[test]
fn fractional_step_theta_is_second_order() {
    Study::new().check(
        "fractional-step theta",
        Scheme::FractionalStepTheta,
        2.0,
        [1.7268e-6, 3.1581e-7, 1.4358e-5, 1.3721e-5],
    );
}

#[test]
fn cg1_is_second_order() {
    Study::new().check("cG(1)", Scheme::Galerkin, 2.0, [1.3696e-5, 2.5519e-6, 8.2228e-5, 3.0829e-5]);
}

/// Along linear u the stress of St. Venant and Kirchhoff is cubic, which two Gauss points integrate: cG(1) keeps the
/// energy of a vibrating body, which Crank-Nicolson does not where strains are large.
#[test]
fn cg1_conserves_energy() {
    let nothing: Exact = Arc::new(|_, _| {
        let zero = number(0.0);
        Values { v: [zero; 2], u: [zero; 2], p: zero }
    });
    let mesh = square(4, Cells::Square, Body::Block);
    let problem = problem(&mesh, BODY, PressureKind::Pdc(1), nothing, InTime::Derivative, QUADRATURE);
    let drift = |scheme: Scheme| {
        let mut stepper = problem.stepper(scheme, 0.0, true, &options());
        stepper.source = None;
        for (node, x) in problem.space.nodes.points.iter().enumerate() {
            stepper.new.v[2 * node] = 0.8 * x[1];
        }
        let energy = |state: &State| {
            let of = |integral| {
                let (space, physics) = (&*problem.space, &problem.physics);
                let (rule, new, old, fluid_residual) = (StepRule::STATIONARY, state, state, &[][..]);
                Energy { integral, quadrature: QUADRATURE }.evaluate(&Snapshot {
                    space,
                    physics,
                    rule,
                    new,
                    old,
                    fluid_residual,
                    system: None,
                    volume: &[],
                })
            };
            of(Integral::SolidKinetic) + of(Integral::Elastic)
        };
        let before = energy(&stepper.new);
        let mut worst = 0.0f64;
        for _ in 0..20 {
            stepper.step(0.05).unwrap();
            worst = worst.max((energy(&stepper.new) / before - 1.0).abs());
        }
        worst
    };
    let (galerkin, trapezoid) = (drift(Scheme::Galerkin), drift(Scheme::CrankNicolson));
    println!("energy: {galerkin:.1e} with cG(1), {trapezoid:.1e} with Crank-Nicolson");
    assert!(galerkin < 1e-8 && trapezoid > 1e-4, "{galerkin:e} {trapezoid:e}");
}

#[test]
fn bdf2_is_second_order() {
    Study::new().check("BDF2", Scheme::Bdf2, 2.0, [4.6516e-5, 1.0288e-5, 3.3241e-4, 1.2434e-4]);
    let study = Study { uneven: true, ..Study::new() };
    study.check("uneven BDF2", Scheme::Bdf2, 2.0, [4.6814e-5, 1.0286e-5, 3.8075e-4, 1.2430e-4]);
}

/// The three side by side; the last with all schemes of several θ, where the book has ½.
#[test]
#[ignore = "long"]
fn every_domain_motion_term_is_second_order() {
    for (name, motion, stored) in [
        ("secant", DomainMotion::Secant, [1.0863e-5, 2.3608e-6, 9.0852e-5, 4.1967e-5]),
        ("midpoint", DomainMotion::Midpoint, [1.0859e-5, 2.3611e-6, 9.0870e-5, 4.1948e-5]),
        ("galerkin", DomainMotion::Galerkin, [1.0860e-5, 2.3610e-6, 9.0864e-5, 4.1954e-5]),
    ] {
        Study { motion, ..Study::new() }.check(name, Scheme::CrankNicolson, 2.0, stored);
    }
    let study = Study { motion: DomainMotion::Galerkin, ..Study::new() };
    study.check("galerkin, shifted", SHIFTED, 2.0, NONE);
    study.check("galerkin, fractional-step theta", Scheme::FractionalStepTheta, 2.0, NONE);
    let study = Study { motion: DomainMotion::Midpoint, ..Study::new() };
    study.check("midpoint, fractional-step theta", Scheme::FractionalStepTheta, 2.0, NONE);
}

/// Step-size control on a flow that changes ever faster: steps grow, then shrink, some are rejected, the error
/// follows the tolerance, and the wanted times are hit.
#[test]
fn tolerance_controls_the_error() {
    let chirp: Exact = Arc::new(|[x, y], t| {
        let (one, a) = (number(1.0), sin(t * t * t * 9.0 + number(0.4)));
        let w = bubble([x, y]);
        Values {
            v: [(one + x + y * y) * a, (x * x - y) * a + x * y * y * 0.5],
            u: [w * a * 0.02, w * a * -0.03],
            p: x * a - y,
        }
    });
    let mesh = square(4, Cells::Square, Body::Block);
    let problem = problem(&mesh, FSI, PressureKind::Pdc(1), chirp, InTime::Derivative, QUADRATURE);
    for scheme in [SHIFTED, Scheme::Bdf2, Scheme::Esdirk3, Scheme::Esdirk4] {
        let of = |tolerance: f64| {
            let settings = AdaptiveSettings { tolerance, min_step: 1e-5, max_step: 0.2, safety: 0.9 };
            let mut control = Adaptive::new(settings, 5e-3);
            let mut stepper = problem.stepper(scheme, 0.0, false, &options());
            let (mut steps, mut worst) = (vec![], 0.0f64);
            for target in [0.5, 0.9, 1.2] {
                while stepper.time < target {
                    let before = stepper.time;
                    control.step(&mut stepper, target).unwrap();
                    steps.push(stepper.time - before);
                    worst = worst.max(problem.errors(&stepper.new, stepper.time, stepper.time, QUADRATURE).v);
                }
                assert_eq!(stepper.time, target);
            }
            (steps, control.memory.rejected, worst)
        };
        let [coarse, fine] = [1e-2, 1.25e-3].map(of);
        for (steps, rejected, worst) in [&coarse, &fine] {
            let late = steps.iter().rev().take(3).sum::<f64>() / 3.0;
            println!(
                "{scheme:?}: {} steps, {rejected} rejected, the last {late:.2e} s, error {worst:.3e}",
                steps.len()
            );
            assert!(
                *rejected > 0 && late < if scheme.order() > 2 { 0.15 } else { 0.05 },
                "{rejected} rejected, last steps {late}"
            );
        }
        // A local error of third order: half the step for an eighth of it, a quarter of the error in all. Methods of
        // order 3 and 4 with an embedded one: a half and 0.6 of the step, an eighth of the error.
        let (work, gain) = (fine.0.len() as f64 / coarse.0.len() as f64, coarse.2 / fine.2);
        assert!(
            (1.4..2.6).contains(&work) && (2.5..if scheme.order() > 2 { 16.0 } else { 8.0 }).contains(&gain),
            "{work} times the steps, {gain} times better"
        );
    }
}
