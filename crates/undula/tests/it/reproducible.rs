//! The number of threads changes no bit of the result.

use crate::common::builtin;
use undula::simulation::{Row, Simulation};
use undula::space::State;

/// A few steps in which the beam already moves, and Jacobians are both kept and made.
fn steps(threads: usize, more: &[&str]) -> (Vec<Row>, State) {
    let common =
        ["mesh.refine=0", "time.step=0.02", "time.end=0.1", "solid.body-force=[0,-2]", "newton.rate-max=0.1"];
    let case = builtin("fsi3", &[&common[..], more].concat());
    let mut simulation = Simulation::new(case, threads).unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    (simulation.history, simulation.stepper.new)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn threads_change_no_bit() {
    let rows = check(&[]);
    assert!(rows.iter().any(|row| row.jacobians == 0));
}

/// Where GMRES adds up the products of vectors.
#[test]
fn threads_change_no_bit_of_gmres() {
    check(&["linear.krylov=gmres"]);
    check(&["linear.krylov=gmres", "newton.linearization=newton"]);
}

fn check(more: &[&str]) -> Vec<Row> {
    let (rows, state) = steps(1, more);
    assert_eq!(rows.len(), 5);
    assert!(rows[4].values.iter().all(|x| x.is_finite() && *x != 0.0));
    for threads in [2, 4] {
        let (other, other_state) = steps(threads, more);
        for (a, b) in rows.iter().zip(&other) {
            assert_eq!(bits(&a.values), bits(&b.values), "step {} on {threads} threads", a.step);
        }
        assert_eq!(rows, other);
        for (a, b) in [(&state.v, &other_state.v), (&state.u, &other_state.u), (&state.p, &other_state.p)] {
            assert_eq!(bits(a), bits(b), "on {threads} threads");
        }
    }
    rows
}
