//! Orders of convergence in space of every pair of elements, on the coupled problem of `convergence_space.rs`.
//!
//! Interpolation: v and u of degree k have order k + 1 in L², a pressure of degree m has order m + 1. A stable
//! pair keeps both while m = k − 1; with m < k − 1 the pressure decides, and v and u are of order m + 2.

#[path = "common/manufactured.rs"]
mod manufactured;

use manufactured::*;
use undula::assembly::Options;
use undula::problem::manufactured::InTime;
use undula::space::PressureKind::{self, Continuous, Pdc};
use undula::time::Scheme;

/// L² errors of v, u and p with `n` cells per direction.
fn errors(degree: usize, pressure: PressureKind, n: usize) -> [f64; 3] {
    let mesh = square(n, Cells::Curved, Body::Half);
    let space = space(&mesh, &FSI, degree, pressure);
    let problem = problem_in(space, FSI, smooth(true), InTime::Difference, degree + 3);
    let mut stepper = problem.stepper(Scheme::BACKWARD_EULER, 0.0, false, &Options::serial(degree + 1));
    stepper.newton.settings.floor = 1e-10;
    stepper.stationary().unwrap();
    let e = problem.errors(&stepper.new, 0.0, 0.0, degree + 3);
    [e.v, e.u, e.p]
}

/// Orders between `levels` (cells per direction) at least `orders` less 0.2.
fn check(degree: usize, pressure: PressureKind, levels: [usize; 2], orders: [f64; 3]) {
    let [coarse, fine] = levels.map(|n| errors(degree, pressure, n));
    let finer = levels[1] as f64 / levels[0] as f64;
    let mut failures = vec![];
    for (i, field) in ["v", "u", "p"].into_iter().enumerate() {
        let order = (coarse[i] / fine[i]).log(finer);
        let line =
            format!("{degree} {pressure:?} {field}: {:.3e} {:.3e} order {order:.2}", coarse[i], fine[i]);
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
        check(3, pressure, [8, 16], [4.0, 4.0, 3.0]);
    }
}

#[test]
fn q4_has_order_5_and_its_pressures_4() {
    for pressure in [Pdc(3), Continuous(3)] {
        check(4, pressure, [6, 12], [5.0, 5.0, 4.0]);
    }
}

/// The pressure decides: P0 is of order 1, and v of order 2; the traction carries that into u.
#[test]
fn a_pressure_of_low_degree_takes_the_velocity_along() {
    check(2, Pdc(0), [8, 16], [2.0, 2.0, 1.0]);
    check(3, Pdc(1), [8, 16], [3.0, 3.0, 2.0]);
}
