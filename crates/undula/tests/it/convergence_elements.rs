//! Orders of convergence in space of every pair of elements, on the coupled problem of `convergence_space.rs`.
//!
//! Interpolation: v and u of degree k have order k + 1 in L², a pressure of degree m has order m + 1. A stable
//! pair keeps both while m = k − 1; with m < k − 1 the pressure decides, and v and u are of order m + 2.

use crate::manufactured::*;
use undula::space::PressureKind::{Continuous, Pdc};
use undula::system::Options;
use undula::time::Scheme;
use undula::verification::manufactured::InTime;

/// L² errors of v, u and p with `n` cells per direction.
fn errors(pair: Pair, n: usize) -> [f64; 3] {
    let space = pair.space(&square(n, Cells::Curved, Body::Half), &FSI);
    let accurate = pair.degree + 3;
    let problem = problem_in(space, FSI, smooth(true), InTime::Difference, accurate);
    let mut stepper = problem.stepper(Scheme::BackwardEuler, 0.0, false, &Options::serial(pair.quadrature()));
    stepper.newton.settings.floor = Some(1e-10);
    stepper.stationary().unwrap();
    let e = problem.errors(&stepper.new, 0.0, 0.0, accurate);
    [e.v, e.u, e.p]
}

/// Orders between `levels` (cells per direction) at least `orders` less 0.2.
fn check(pair: Pair, levels: [usize; 2], orders: [f64; 3]) {
    let [coarse, fine] = levels.map(|n| errors(pair, n));
    let finer = levels[1] as f64 / levels[0] as f64;
    let name =
        format!("{:?} {}{} {:?}", pair.cells, pair.degree, if pair.bubble { "b" } else { "" }, pair.pressure);
    let mut failures = vec![];
    for (i, field) in ["v", "u", "p"].into_iter().enumerate() {
        let order = (coarse[i] / fine[i]).log(finer);
        let line = format!("{name} {field}: {:.3e} {:.3e} order {order:.2}", coarse[i], fine[i]);
        println!("{line}");
        if order < orders[i] - 0.2 {
            failures.push(line);
        }
    }
    assert!(failures.is_empty(), "expected {orders:?}: {failures:#?}");
}

#[test]
fn q3_has_order_4_and_its_pressures_3() {
    for pressure in [Pdc(2), Continuous(2)] {
        check(quadrilaterals(3, pressure), [8, 16], [4.0, 4.0, 3.0]);
    }
}

#[test]
fn q4_has_order_5_and_its_pressures_4() {
    for pressure in [Pdc(3), Continuous(3)] {
        check(quadrilaterals(4, pressure), [6, 12], [5.0, 5.0, 4.0]);
    }
}

/// The pressure decides: P0 is of order 1, and v of order 2; the traction carries that into u.
#[test]
fn a_pressure_of_low_degree_takes_the_velocity_along() {
    check(quadrilaterals(2, Pdc(0)), [8, 16], [2.0, 2.0, 1.0]);
    check(quadrilaterals(3, Pdc(1)), [8, 16], [3.0, 3.0, 2.0]);
}

#[test]
fn p2_has_order_3_and_p1_order_2() {
    check(triangles(2, Continuous(1)), [8, 16], [3.0, 3.0, 2.0]);
}

#[test]
fn p3_has_order_4_and_p2_order_3() {
    check(triangles(3, Continuous(2)), [8, 16], [4.0, 4.0, 3.0]);
}

/// The chapter lists the pair as P^k-P^{k-2}: the pressure is of order k − 1, v and u of order k, one less than P3 can.
#[test]
fn p3_with_p1dc_has_order_3_and_2() {
    check(triangles(3, Pdc(1)), [8, 16], [3.0, 3.0, 2.0]);
}

#[test]
fn p2_bubble_has_order_3_and_p1dc_order_2() {
    check(BUBBLE, [8, 16], [3.0, 3.0, 2.0]);
}

/// Bubbles are of the velocity in the fluid alone.
#[test]
fn bubbles_stay_out_of_the_deformation_and_of_the_solid() {
    let space = BUBBLE.space(&square(4, Cells::Curved, Body::Half), &FSI);
    let problem = problem_in(space.clone(), FSI, smooth(true), InTime::Difference, 4);
    let mut stepper = problem.stepper(Scheme::CrankNicolson, 0.0, false, &Options::serial(4));
    stepper.step(0.1).unwrap();
    let first = 2 * space.nodes.n_lagrange;
    let cells = space.regions.iter().filter(|r| **r == undula::space::Region::Fluid).count();
    assert_eq!(space.n_v() - first, 2 * cells);
    assert!(stepper.new.v[first..].iter().all(|v| *v != 0.0));
    assert!(stepper.new.u[first..].iter().all(|u| *u == 0.0));
}
