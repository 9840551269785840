//! Orders of convergence in time on a moving domain.
//!
//! At every time the solution lies in the spaces (biquadratic v and u on squares, linear p) and the
//! right-hand side is integrated by the rule of the solver, so that all of the error is that of time.

#[path = "common/manufactured.rs"]
mod manufactured;

use manufactured::*;
use std::sync::Arc;
use undula::assembly::StepView;
use undula::functional::{Functional, Snapshot, force::ForceByResidual};
use undula::problem::manufactured::{Exact, InTime, Manufactured, Values, cos, number, sin};
use undula::space::{PressureKind, Region};
use undula::time::Scheme;

const SHIFTED: Scheme = Scheme::ShiftedCrankNicolson { shift: 1.0 };

fn in_the_spaces() -> Exact {
    Arc::new(|[x, y], t| {
        let w = bubble([x, y]);
        let (one, a, b) = (number(1.0), sin(t * 2.0 + number(0.4)), cos(t * 1.5));
        Values {
            v: [(one + x + y * y) * cos(t) + x * y * a, (x * x - y) * b + x * y * y * 0.5 + sin(t * 3.0)],
            u: [w * a * 0.09, w * b * -0.07],
            p: x * cos(t * 2.0) - y * a + sin(t) * 2.0,
        }
    })
}

/// Largest errors over all steps: v, u, p at t⁻ + θ k, force at t⁻ + θ k, p at t, force at t.
const NAMES: [&str; 6] = ["v", "u", "p", "force", "p read at t", "force read at t"];

/// From 0 to 1.2 s with `steps` steps, alternating between k and k/2 if `uneven`.
fn errors(problem: &Manufactured, scheme: Scheme, steps: usize, uneven: bool) -> [f64; 6] {
    let mut stepper = problem.stepper(scheme, 0.0, false, &options());
    let drag = ForceByResidual::new(&problem.space, &["interface".into()], 0, 1.0, "N/m");
    let n = problem.space.n_unknowns();
    let (mut residual, mut worst) = (vec![0.0; n], [0.0f64; 6]);
    for step in 0..steps {
        let k = match (uneven, step % 2) {
            (false, _) => 1.2 / steps as f64,
            (true, 0) => 1.6 / steps as f64,
            (true, _) => 0.8 / steps as f64,
        };
        stepper.step(k).unwrap();
        let (t, t_force) = (stepper.time, stepper.force_time());
        let (rule, new, old, assembler) = stepper.last_step();
        assembler.region_residual(&StepView { rule, new, old }, Region::Fluid, &mut residual);
        let value = |fluid_residual: &[f64]| {
            let (space, physics) = (&*problem.space, &problem.physics);
            drag.evaluate(&Snapshot { space, physics, rule, new, old, fluid_residual })
        };
        let force = value(&residual);
        let mut exact = |t: f64| {
            problem.weak_form(&problem.outflow(), t - 1.0, t, 1.0, Some(Region::Fluid), &mut residual);
            value(&residual)
        };
        let (now, at_end) = (problem.errors(new, t, t_force, QUADRATURE), exact(t));
        let late = problem.errors(new, t, t, QUADRATURE).p;
        let all = [now.v, now.u, now.p, (force - exact(t_force)).abs(), late, (force - at_end).abs()];
        for (worst, e) in worst.iter_mut().zip(all) {
            *worst = worst.max(e);
        }
    }
    worst
}

/// Orders between 64 and 128 steps of `order` for v, u and, at t⁻ + θ k, p and force; of 1 where these are
/// read at t. Errors of 128 steps as stored.
fn check(name: &str, scheme: Scheme, uneven: bool, order: f64, stored: [f64; 4]) {
    let mesh = square(4, Cells::Square, Body::Block);
    let problem = problem(&mesh, FSI, PressureKind::Pdc(1), in_the_spaces(), InTime::Derivative, QUADRATURE);
    let e = [32, 64, 128].map(|steps| errors(&problem, scheme, steps, uneven));
    let mut failures = vec![];
    for i in 0..6 {
        let found = (e[1][i] / e[2][i]).log2();
        let line =
            format!("{name}, {}: {:.4e} {:.4e} {:.4e} order {found:.3}", NAMES[i], e[0][i], e[1][i], e[2][i]);
        println!("{line}");
        let expected = if i < 4 { order } else { 1.0 };
        let other = stored.get(i).is_some_and(|stored| (e[2][i] / stored - 1.0).abs() > 0.02);
        if (found - expected).abs() > 0.15 || other {
            failures.push(line);
        }
    }
    assert!(failures.is_empty(), "expected {stored:?}: {failures:#?}");
}

#[test]
fn backward_euler_is_first_order() {
    check("backward Euler", Scheme::BACKWARD_EULER, false, 1.0, [2.5715e-3, 1.0576e-3, 1.6815e-2, 2.9559e-3]);
}

/// Pressure and force belong to t⁻ + θ k: read at the new time they are of first order.
#[test]
fn crank_nicolson_is_second_order() {
    check("Crank-Nicolson", Scheme::CRANK_NICOLSON, false, 2.0, [1.1074e-5, 2.4516e-6, 9.0686e-5, 4.3800e-5]);
}

#[test]
fn shifted_crank_nicolson_is_second_order() {
    check("shifted Crank-Nicolson", SHIFTED, false, 2.0, [5.2853e-5, 2.0637e-5, 3.1789e-4, 5.2462e-5]);
}

#[test]
fn uneven_steps_keep_second_order() {
    check(
        "uneven Crank-Nicolson",
        Scheme::CRANK_NICOLSON,
        true,
        2.0,
        [1.5090e-5, 3.2894e-6, 1.4072e-4, 7.0821e-5],
    );
    check("uneven shifted Crank-Nicolson", SHIFTED, true, 2.0, [7.1146e-5, 2.7569e-5, 4.6826e-4, 7.8832e-5]);
}
