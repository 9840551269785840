//! Runge-Kutta methods: orders, embedded errors, what they do at the start and where data jump.

use crate::common::builtin;
use crate::convergence_time::{NAMES, errors};
use crate::manufactured::*;
use undula::simulation::Simulation;
use undula::space::PressureKind;
use undula::time::{DomainMotion, Scheme};
use undula::verification::manufactured::InTime;
use undula::verification::unit_square::of_two_profiles;

const METHODS: [Scheme; 2] = [Scheme::Esdirk3, Scheme::Esdirk4];

/// Largest errors of all steps, the first included.
#[test]
fn orders_on_a_moving_domain() {
    let mesh = square(4, Cells::Square, Body::Block);
    let problem =
        problem(&mesh, FSI, PressureKind::Pdc(1), of_two_profiles(), InTime::Derivative, QUADRATURE);
    for (scheme, orders, stored) in [
        (Scheme::Esdirk3, [2.8, 2.8, 1.9, 1.9], [6.0401e-7, 2.6840e-8, 1.5696e-4, 2.1823e-6]),
        (Scheme::Esdirk4, [3.3, 3.5, 1.9, 1.9], [4.3343e-7, 1.7498e-8, 2.4424e-4, 1.5251e-6]),
    ] {
        let e = [8, 16, 32].map(|steps| errors(&problem, scheme, DomainMotion::Secant, steps, false));
        for i in 0..4 {
            let found = (e[1][i] / e[2][i]).log2();
            println!(
                "{scheme:?} {}: {:.4e} {:.4e} {:.4e} order {found:.2}",
                NAMES[i], e[0][i], e[1][i], e[2][i]
            );
            let gap = (e[2][i] / stored[i] - 1.0).abs();
            assert!(found > orders[i] && gap < 0.02, "{scheme:?} {}: {found}, {}", NAMES[i], e[2][i]);
        }
    }
}

/// Data that jump at the start leave the derivative there unknown: the first step does without it.
#[test]
fn a_jump_at_the_start_is_no_fault() {
    let end = |scheme: Scheme, step: f64| {
        let sets = [
            "mesh.refine=0".to_string(),
            "boundary.inflow.velocity=[\"30*y*(0.41-y)\", 0]".into(),
            format!("time.scheme={}", scheme.name()),
            format!("time.step={step}"),
            "time.end=0.1".into(),
        ];
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let mut simulation = Simulation::new(builtin("fsi3", &sets), 1).unwrap();
        let mut largest = 0.0f64;
        while !simulation.finished() {
            simulation.step().unwrap();
            largest = simulation.stepper.new.v.iter().fold(largest, |most, v| most.max(v.abs()));
        }
        assert!(largest < 6.0, "{scheme:?}: {largest}");
        simulation.history.last().unwrap().values[3]
    };
    let expected = end(Scheme::BackwardEuler, 0.002);
    for scheme in METHODS {
        let found = end(scheme, 0.02);
        println!("{scheme:?}: {found:.4e}, {expected:.4e}");
        assert!((found - expected).abs() < 0.5 * expected.abs(), "{scheme:?}: {found:e} {expected:e}");
    }
}

/// Functionals at the end, and u, of a beam that a force moves in a flow from rest.
fn end_of_beam(scheme: Scheme, steps: usize) -> (Vec<f64>, Vec<f64>) {
    let end = 0.4;
    let sets = [
        "mesh.refine=0".to_string(),
        format!("time.scheme={}", scheme.name()),
        format!("time.step={}", end / steps as f64),
        format!("time.end={end}"),
        "solid.body-force=[0, \"-4*sin(pi*t/0.4)^4\"]".into(),
        "newton.tolerance=1e-10".into(),
    ];
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let mut simulation = Simulation::new(builtin("fsi3", &sets), 1).unwrap();
    for _ in 0..steps {
        simulation.step().unwrap();
    }
    (simulation.history.last().unwrap().values.clone(), simulation.stepper.new.u.clone())
}

/// Differences of runs with k and k/2. Those of forces end at 0.1 % of the force: at the axial vibration of the beam,
/// which a step shorter than its period of 18 ms does not damp.
#[test]
fn a_beam_in_a_flow_has_the_order_of_the_scheme() {
    for (scheme, order) in [(Scheme::Esdirk3, 2.7), (Scheme::Esdirk4, 3.4)] {
        let runs = [8, 16, 32].map(|steps| end_of_beam(scheme, steps));
        let gap = |run: usize| {
            let largest = |a: &[f64], b: &[f64]| -> f64 {
                a.iter().zip(b).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
            };
            let of = |i: usize| (runs[run].0[i] - runs[run + 1].0[i]).abs();
            [of(0), of(1), of(3), largest(&runs[run].1, &runs[run + 1].1)]
        };
        let (coarse, fine) = (gap(0), gap(1));
        for (i, name) in ["drag", "lift", "u_y of A", "u"].iter().enumerate() {
            let found = (coarse[i] / fine[i]).log2();
            println!("{scheme:?} {name}: {:.2e} {:.2e} order {found:.2}", coarse[i], fine[i]);
            assert!(i < 2 || found > order, "{scheme:?} {name}: {found}");
        }
        assert!(fine[0] < 5e-2 && fine[1] < 5e-3, "{scheme:?}: {fine:?}");
    }
}
