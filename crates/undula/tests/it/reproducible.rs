//! The number of threads changes no bit of the result.

use crate::common::builtin;
use undula::simulation::{Row, Simulation};
use undula::space::State;
use undula::system::StepView;

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

/// Threads that are not those of the simulation: a task in the pool of the user, which has more of them, plain threads, and
/// two simulations at the same time.
#[test]
fn threads_of_the_user_change_no_bit() {
    let (rows, state) = steps(1, &[]);
    let equal = |(other, other_state): (Vec<Row>, State)| {
        assert_eq!(rows, other);
        assert_eq!(bits(&state.v), bits(&other_state.v));
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for threads in [1, 2] {
        equal(pool.install(|| rayon::join(|| steps(threads, &[]), || steps(threads, &[])).1));
    }
    std::thread::scope(|scope| {
        let both = [1, 2].map(|threads| scope.spawn(move || steps(threads, &[])));
        both.into_iter().for_each(|thread| equal(thread.join().unwrap()));
    });
}

/// The stepper itself is public: its loops then run in whatever pool it is called from.
#[test]
fn a_stepper_may_be_called_from_any_pool() {
    let step = |threads: usize, pool: Option<usize>| {
        let case = builtin("fsi3", &["mesh.refine=0", "time.step=0.02", "solid.body-force=[0,-2]"]);
        let mut simulation = Simulation::new(case, threads).unwrap();
        let stepper = &mut simulation.stepper;
        let mut all = || (0..3).for_each(|_| assert!(stepper.step(0.02).is_ok()));
        match pool {
            None => all(),
            Some(n) => rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(all),
        }
        bits(&simulation.stepper.new.v)
    };
    let expected = step(1, None);
    for (threads, pool) in [(1, Some(4)), (2, Some(4)), (2, None), (4, Some(2))] {
        assert_eq!(step(threads, pool), expected, "{threads} threads in a pool of {pool:?}");
    }
}

/// What reads an assembler may do so from several threads at once, which all have the number 0.
#[test]
fn two_threads_read_one_assembler() {
    let case = builtin("fsi3", &["mesh.refine=0", "time.step=0.02", "motion.model=jacobian-stiffened"]);
    let mut simulation = Simulation::new(case, 1).unwrap();
    simulation.step().unwrap();
    let (rule, new, old, assembler) = simulation.stepper.last_step();
    let view = StepView { rule, new, old };
    let assembler = &*assembler;
    let values = || {
        let system = assembler.extension(&view).unwrap();
        bits(&system.matrix.values)
    };
    let expected = values();
    std::thread::scope(|scope| {
        let all: Vec<_> =
            (0..4).map(|_| scope.spawn(|| (0..5).map(|_| values()).collect::<Vec<_>>())).collect();
        all.into_iter().flat_map(|t| t.join().unwrap()).for_each(|found| assert!(found == expected));
    });
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
