//! Linear solvers: known solutions, both backends, what must be refused.

mod matrices;

use matrices::{Pressure, Setup, System};
use std::sync::Arc;
use undula::algebra::{
    Csr, FaerLu, Kind, LinearSolver, MultifrontalLu, Options, Pattern, SolverError, Unknown, norm_inf,
};

fn solvers() -> Vec<Box<dyn LinearSolver>> {
    vec![
        Box::new(FaerLu::faer(Options::default())),
        Box::new(MultifrontalLu::multifrontal(Options::default())),
    ]
}

fn systems() -> Vec<System> {
    use Pressure::{P1dc, Q1};
    let three_d = |pressure, solid| Setup { cells: [5, 4, 3], solid, ..Setup::flow(0, 0, pressure) };
    [P1dc, Q1]
        .into_iter()
        .flat_map(|p| {
            [Setup::flow(1, 1, p), Setup::flow(20, 10, p), Setup::fsi(20, 12, p), Setup::fsi(37, 21, p)]
        })
        .chain([three_d(P1dc, false), three_d(P1dc, true), three_d(Q1, true)])
        .map(|setup| setup.system())
        .collect()
}

/// Entries of a few orders of magnitude, as large in each field as the fields of a real solution.
fn known_solution(unknowns: &[Unknown]) -> Vec<f64> {
    let size = |kind| match kind {
        Kind::Velocity => 1.0,
        Kind::Deformation => 0.1,
        Kind::Pressure => 1e3,
    };
    unknowns.iter().enumerate().map(|(i, u)| size(u.kind) * (1.0 + (i as f64 * 1.7).sin())).collect()
}

/// Largest error of a field relative to its largest value.
fn error(unknowns: &[Unknown], x: &[f64], known: &[f64]) -> f64 {
    let of_kind = |kind| {
        let this = |x: &[f64]| -> Vec<f64> {
            x.iter().zip(unknowns).filter(|(_, u)| u.kind == kind).map(|(x, _)| *x).collect()
        };
        let (x, known) = (this(x), this(known));
        let difference: Vec<f64> = x.iter().zip(&known).map(|(a, b)| a - b).collect();
        norm_inf(&difference) / norm_inf(&known).max(f64::MIN_POSITIVE)
    };
    [Kind::Velocity, Kind::Deformation, Kind::Pressure].map(of_kind).into_iter().fold(0.0, f64::max)
}

fn solve_known(solver: &mut dyn LinearSolver, System { a, unknowns }: &System) -> f64 {
    let known = known_solution(unknowns);
    let (mut b, mut x) = (vec![0.0; a.pattern.n], vec![0.0; a.pattern.n]);
    a.mul(&known, &mut b);
    solver.factor(a).unwrap();
    solver.solve(a, &b, &mut x).unwrap();
    error(unknowns, &x, &known)
}

#[test]
fn known_solutions_come_back() {
    for system in systems() {
        for mut solver in solvers() {
            solver.analyse(&system.a.pattern, &system.unknowns).unwrap();
            let error = solve_known(&mut *solver, &system);
            assert!(error < 1e-10, "{} n = {}: error {error:e}", solver.name(), system.a.pattern.n);
        }
    }
}

#[test]
fn second_factorisation_with_other_values() {
    let setup = Setup::fsi(16, 9, Pressure::P1dc);
    let first = setup.system();
    let second = Setup { wind: -3.0, ..setup }.system();
    for mut solver in solvers() {
        solver.analyse(&first.a.pattern, &first.unknowns).unwrap();
        for system in [&first, &second, &first] {
            let error = solve_known(&mut *solver, system);
            assert!(error < 1e-10, "{}: error {error:e}", solver.name());
        }
    }
}

/// The result of analyse and factor.
fn factor(solver: &mut dyn LinearSolver, System { a, unknowns }: &System) -> Result<(), SolverError> {
    solver.analyse(&a.pattern, unknowns)?;
    solver.factor(a).map(|_| ())
}

#[test]
fn zero_rows_and_columns_are_named() {
    for mut solver in solvers() {
        let mut system = Setup::flow(6, 4, Pressure::P1dc).system();
        let at = system.a.pattern.row(37);
        system.a.values[at].fill(0.0);
        let found = factor(&mut *solver, &system);
        assert!(matches!(found, Err(SolverError::ZeroRow { row: 37, .. })), "{found:?}");

        let mut system = Setup::flow(6, 4, Pressure::P1dc).system();
        for (v, j) in system.a.values.iter_mut().zip(&system.a.pattern.col) {
            if *j == 41 {
                *v = 0.0;
            }
        }
        let found = factor(&mut *solver, &system);
        assert!(matches!(found, Err(SolverError::ZeroColumn { col: 41, .. })), "{found:?}");
    }
}

#[test]
fn duplicate_rows_are_singular() {
    for mut solver in solvers() {
        // The two components at an interior node share their pattern.
        let mut system = Setup::flow(6, 4, Pressure::P1dc).system();
        let inside = |u: &Unknown| u.kind == Kind::Velocity && u.at[0] == 1.0 && u.at[1] == 0.5;
        let row = system.unknowns.iter().position(inside).unwrap();
        let (from, to) = (system.a.pattern.row(row), system.a.pattern.row(row + 1));
        system.a.values.copy_within(from, to.start);
        let found = factor(&mut *solver, &system);
        assert!(matches!(found, Err(SolverError::Singular { .. })), "{}: {found:?}", solver.name());
    }
}

#[test]
fn pressure_without_outflow_is_singular() {
    for pressure in [Pressure::P1dc, Pressure::Q1] {
        for (nx, ny) in [(4, 2), (12, 8), (48, 24)] {
            let setup = Setup { outflow: false, ..Setup::flow(nx, ny, pressure) };
            for mut solver in solvers() {
                match factor(&mut *solver, &setup.system()) {
                    Err(SolverError::Singular { unknown, .. }) => assert_eq!(unknown.kind, Kind::Pressure),
                    other => panic!("{} {nx} x {ny}: {other:?}", solver.name()),
                }
            }
        }
    }
}

#[test]
fn nothing_but_finite_numbers_is_accepted() {
    for mut solver in solvers() {
        let mut system = Setup::flow(4, 4, Pressure::Q1).system();
        factor(&mut *solver, &system).unwrap();
        let n = system.a.pattern.n;
        let (mut b, mut x) = (vec![1.0; n], vec![0.0; n]);
        b[7] = f64::NAN;
        let found = solver.solve(&system.a, &b, &mut x);
        assert!(matches!(found, Err(SolverError::RightHandSide { row: 7, .. })), "{found:?}");
        system.a.values[11] = f64::INFINITY;
        let found = solver.factor(&system.a);
        assert!(matches!(found, Err(SolverError::NotFinite { .. })), "{found:?}");
        // A failed factorisation leaves nothing to solve with.
        b[7] = 1.0;
        assert_eq!(solver.solve(&system.a, &b, &mut x), Err(SolverError::NotFactored));
    }
}

#[test]
fn other_patterns_are_refused() {
    for mut solver in solvers() {
        let system = Setup::flow(4, 4, Pressure::Q1).system();
        assert_eq!(solver.factor(&system.a), Err(SolverError::NotAnalysed));
        factor(&mut *solver, &system).unwrap();
        let other = Csr::zeros(&Arc::new(Pattern::from_rows(&[[0]])));
        assert_eq!(solver.factor(&other), Err(SolverError::NotAnalysed));
        let few = &system.unknowns[1..];
        assert!(matches!(solver.analyse(&system.a.pattern, few), Err(SolverError::Size { .. })));
    }
}

#[test]
fn scales_do_not_matter() {
    // Rows and columns in units that differ by 18 orders of magnitude.
    let mut system = Setup::fsi(12, 8, Pressure::P1dc).system();
    let exponents = |i: usize| 10_f64.powi(((i * 7919) % 19) as i32 - 8);
    let pattern = Arc::clone(&system.a.pattern);
    for i in 0..pattern.n {
        for k in pattern.row(i) {
            system.a.values[k] *= exponents(i);
        }
    }
    for mut solver in solvers() {
        solver.analyse(&pattern, &system.unknowns).unwrap();
        let error = solve_known(&mut *solver, &system);
        assert!(error < 1e-10, "{}: error {error:e}", solver.name());
    }
}
