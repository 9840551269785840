//! Linear solvers: known solutions, both backends, what must be refused.

mod definite;
mod matrices;
mod petsc;

use matrices::{Pressure, Setup, System};
use std::sync::Arc;
use undula::algebra::{
    Csr, Kind, LinearSolver, MultifrontalLu, Options, Pattern, Precision, SOLVERS, SolverError, Unknown,
    norm_inf,
};

/// Refinement as far as it goes: errors are compared with 1e-10.
fn options() -> Options {
    Options { target: 1e-16, ..Options::default() }
}

fn solvers() -> Vec<Box<dyn LinearSolver>> {
    SOLVERS.iter().map(|row| row.value.make(Precision::Double, false, options())).collect()
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
        .chain([Setup::flow(20, 10, P1dc).condensed()])
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
fn names_are_those_of_the_list() {
    // Those that factorise are the first ones.
    for (row, solver) in SOLVERS[..2].iter().zip(solvers()) {
        assert_eq!(row.name, solver.name());
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
        for (v, j) in system.a.values.iter_mut().zip(system.a.pattern.all_columns()) {
            if j == 41 {
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

/// Unknowns that can only be eliminated together with others far away in the tree. Without delayed
/// pivots this matrix cannot be factored in the order of its graph: half of the diagonal is zero.
#[test]
fn pivots_without_a_diagonal_are_delayed() {
    // A saddle point matrix of two chains: x[i] has no diagonal, and the entries that make it regular
    // link it to y[i], which is eliminated elsewhere.
    let n = 400;
    let mut rows = vec![Vec::new(); 2 * n as usize];
    for i in 0..n {
        for j in [i.max(1) - 1, i, (i + 1).min(n - 1)] {
            rows[i as usize].push(j);
            rows[(n + i) as usize].push(n + j);
        }
        let partner = n + (i * 7 + 3) % n;
        rows[i as usize].push(partner);
        rows[partner as usize].push(i);
    }
    let pattern = Arc::new(Pattern::from_rows(&rows));
    let mut a = Csr::zeros(&pattern);
    for i in 0..pattern.n {
        for k in pattern.row(i) {
            let j = pattern.column(i, k) as usize;
            let linked = (i < n as usize) != (j < n as usize);
            a.values[k] = if linked {
                1.0
            } else if i >= n as usize {
                1e-3 * (1.0 + (i + j) as f64).sin()
            } else {
                0.0
            };
        }
    }
    let at = |i: usize| [(i % n as usize) as f64, (i / n as usize) as f64, 0.0];
    let unknown = |i: usize| Unknown { node: i as u32, kind: Kind::Velocity, at: at(i) };
    let system = System { unknowns: (0..pattern.n).map(unknown).collect(), a };
    let mut solver = MultifrontalLu::multifrontal(options());
    solver.analyse(&pattern, &system.unknowns).unwrap();
    let report = solver.factor(&system.a).unwrap();
    assert!(report.cost.delayed > 100, "{report:?}");
    let error = solve_known(&mut solver, &system);
    assert!(error < 1e-10, "error {error:e}");
}

/// Pressures of cells are ordered behind velocities that give them pivots, the constant ones one by one: hardly
/// any is delayed, with and without the unknowns inside of the cells, in two and three dimensions.
#[test]
fn pressures_of_cells_have_pivots() {
    let box_3d = Setup { cells: [5, 4, 3], ..Setup::flow(0, 0, Pressure::P1dc) };
    let flow = Setup::flow(20, 12, Pressure::P1dc);
    // Of the solid, deformations beside velocities are delayed, too.
    let fsi = Setup::fsi(20, 12, Pressure::P1dc);
    let systems = [(flow.system(), 2), (flow.condensed(), 2), (box_3d.system(), 2), (fsi.system(), 80)];
    for (system, most) in systems {
        let mut solver = MultifrontalLu::multifrontal(options());
        solver.analyse(&system.a.pattern, &system.unknowns).unwrap();
        let report = solver.factor(&system.a).unwrap();
        assert!(report.cost.delayed <= most, "{report:?}");
    }
}

/// Bits of the solution and reports, the second time in memory that has been used.
fn bits(
    mut solver: Box<dyn LinearSolver>,
    System { a, unknowns }: &System,
    threads: usize,
) -> (Vec<u64>, String) {
    let known = known_solution(unknowns);
    let (mut b, mut x, mut reports) = (vec![0.0; known.len()], vec![0.0; known.len()], String::new());
    a.mul(&known, &mut b);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        solver.analyse(&a.pattern, unknowns).unwrap();
        for _ in 0..2 {
            let factor = solver.factor(a).unwrap();
            let solve = solver.solve(a, &b, &mut x).unwrap();
            reports += &format!("{factor:?} {solve:?}");
        }
    });
    (x.iter().map(|v| v.to_bits()).collect(), reports)
}

#[test]
fn threads_do_not_change_a_bit() {
    for setup in [Setup::fsi(40, 24, Pressure::P1dc), Setup::flow(50, 30, Pressure::Q1)] {
        let system = setup.system();
        for row in &SOLVERS {
            let solver = || row.value.make(Precision::Double, false, options());
            let one = bits(solver(), &system, 1);
            for threads in [2, 3, 8] {
                assert!(bits(solver(), &system, threads) == one, "{threads} threads");
            }
        }
    }
}

/// Fronts that are worked on in tiles.
#[test]
fn threads_do_not_change_a_bit_of_large_fronts() {
    let system = Setup { cells: [8, 7, 7], ..Setup::flow(0, 0, Pressure::P1dc) }.system();
    let new = || Box::new(MultifrontalLu::multifrontal(options()));
    let one = bits(new(), &system, 1);
    for threads in [2, 5] {
        assert!(bits(new(), &system, threads) == one, "{threads} threads");
    }
}

fn single() -> MultifrontalLu {
    MultifrontalLu::single(Options { target: 1e-15, ..Options::single() })
}

/// Factors in single precision, refined, are as good as those in double precision.
#[test]
fn single_precision_refined_is_double() {
    for System { a, unknowns } in &systems() {
        let known = known_solution(unknowns);
        let (mut b, mut x) = (vec![0.0; known.len()], vec![0.0; known.len()]);
        a.mul(&known, &mut b);
        let mut solver = single();
        solver.analyse(&a.pattern, unknowns).unwrap();
        let factor = solver.factor(a).unwrap();
        let report = solver.solve(a, &b, &mut x).unwrap();
        let error = error(unknowns, &x, &known);
        println!("{} {factor:?} {report:?} {error:e}", a.pattern.n);
        assert!(report.backward_error < 1e-14 && error < 1e-9, "{report:?} {error:e}");
    }
}

#[test]
fn single_precision_sees_singular_matrices() {
    for pressure in [Pressure::P1dc, Pressure::Q1] {
        for (nx, ny) in [(4, 2), (12, 8), (48, 24)] {
            let setup = Setup { outflow: false, ..Setup::flow(nx, ny, pressure) };
            let found = factor(&mut single(), &setup.system());
            let is_pressure = |e: &SolverError| matches!(e, SolverError::Singular { unknown, .. } if unknown.kind == Kind::Pressure);
            assert!(found.as_ref().is_err_and(is_pressure), "{nx} x {ny}: {found:?}");
        }
    }
}

#[test]
fn threads_do_not_change_a_bit_in_single_precision() {
    for setup in
        [Setup::fsi(40, 24, Pressure::P1dc), Setup { cells: [8, 7, 7], ..Setup::flow(0, 0, Pressure::P1dc) }]
    {
        let system = setup.system();
        let one = bits(Box::new(single()), &system, 1);
        for threads in [2, 5] {
            assert!(bits(Box::new(single()), &system, threads) == one, "{threads} threads");
        }
    }
}

/// Any size of the right-hand side; numbers beyond single precision among them.
#[test]
fn single_precision_has_no_smallest_number() {
    let System { a, unknowns } = Setup::fsi(20, 12, Pressure::P1dc).system();
    let mut solver = MultifrontalLu::single(Options::unprobed());
    solver.analyse(&a.pattern, &unknowns).unwrap();
    solver.factor(&a).unwrap();
    let b: Vec<f64> = (0..a.pattern.n).map(|i| (i as f64).sin()).collect();
    let mut x = vec![0.0; b.len()];
    solver.apply(&b, &mut x);
    for power in [-900, -60, 60, 900] {
        let scale = 2.0_f64.powi(power);
        let scaled: Vec<f64> = b.iter().map(|b| b * scale).collect();
        let mut y = vec![0.0; b.len()];
        solver.apply(&scaled, &mut y);
        assert!(x.iter().zip(&y).all(|(x, y)| x * scale == *y), "2^{power}");
    }
}

/// Without a probe what can be factored is factored, and only zeros and infinities are refused.
#[test]
fn factors_without_probe() {
    let System { mut a, unknowns } = Setup::fsi(20, 12, Pressure::P1dc).system();
    let known = known_solution(&unknowns);
    let (mut b, mut x) = (vec![0.0; known.len()], vec![0.0; known.len()]);
    a.mul(&known, &mut b);
    let mut double = MultifrontalLu::multifrontal(Options::unprobed());
    let mut single = MultifrontalLu::single(Options { refinement: 30, ..Options::unprobed() });
    for (solver, allowed) in [(&mut double as &mut dyn LinearSolver, 1e-8), (&mut single, 0.1)] {
        solver.analyse(&a.pattern, &unknowns).unwrap();
        solver.apply(&b, &mut x);
        assert!(x[0].is_nan());
        assert!(solver.factor(&a).unwrap().probe_error.is_nan());
        solver.apply(&b, &mut x);
        let once = error(&unknowns, &x, &known);
        assert!(once < allowed, "{}: error {once:e}", solver.name());
        solver.solve(&a, &b, &mut x).unwrap();
        let refined = error(&unknowns, &x, &known);
        assert!(refined < 1e-7, "{}: error {refined:e}", solver.name());
        let before = std::mem::replace(&mut a.values[11], f64::INFINITY);
        assert!(matches!(solver.factor(&a), Err(SolverError::NotFinite { .. })));
        a.values[11] = before;
    }
    // Two equations for one unknown.
    let pattern = Arc::new(Pattern::from_rows(&[[0, 1], [0, 1]]));
    let a = Csr { pattern, values: vec![1.0; 4] };
    for solver in [&mut double as &mut dyn LinearSolver, &mut single] {
        solver.analyse(&a.pattern, &unknowns[..2]).unwrap();
        assert!(matches!(solver.factor(&a), Err(SolverError::Singular { .. })));
    }
}

/// Where the right-hand side is zero, forward substitution is left out; numbers that are too small to
/// count are not.
#[test]
fn zeros_of_the_right_hand_side_may_be_skipped() {
    let setup = Setup::flow(40, 20, Pressure::P1dc);
    for System { a, unknowns } in [setup.condensed(), setup.velocities()] {
        let near = |u: &Unknown| u.at[0] < 0.3 && u.at[1] < 0.3;
        let of = |far: f64| -> Vec<f64> {
            unknowns.iter().enumerate().map(|(i, u)| if near(u) { (i as f64).sin() } else { far }).collect()
        };
        let mut double = MultifrontalLu::multifrontal(Options::unprobed());
        let mut single = MultifrontalLu::single(Options::unprobed());
        let apply = |solver: &mut dyn LinearSolver, b: &[f64]| {
            let mut x = vec![f64::NAN; b.len()];
            solver.apply(b, &mut x);
            x
        };
        for solver in [&mut double as &mut dyn LinearSolver, &mut single] {
            solver.analyse(&a.pattern, &unknowns).unwrap();
            solver.factor(&a).unwrap();
            // The second time after something else.
            let first = apply(solver, &of(0.0));
            apply(solver, &of(1.0));
            assert!(apply(solver, &of(0.0)) == first);
            assert!(apply(solver, &vec![0.0; first.len()]).iter().all(|x| *x == 0.0));
        }
        let (skipped, whole) = (apply(&mut double, &of(0.0)), apply(&mut double, &of(1e-320)));
        let size = norm_inf(&skipped);
        assert!(skipped.iter().zip(&whole).all(|(x, y)| x == y || (x - y).abs() < 1e-290 * size));
        let rounded = apply(&mut single, &of(0.0));
        let difference: Vec<f64> = skipped.iter().zip(&rounded).map(|(x, y)| x - y).collect();
        assert!(norm_inf(&difference) < 1e-2 * size, "{:e}", norm_inf(&difference) / size);
    }
}

/// What the pattern tells before anything is factored.
#[test]
fn costs_are_predicted() {
    let System { a, unknowns } = Setup::flow(40, 20, Pressure::P1dc).velocities();
    let mut double = MultifrontalLu::multifrontal(options());
    let mut single = single();
    assert!(double.predicted().is_none());
    for (solver, size) in [(&mut double as &mut dyn LinearSolver, 8), (&mut single, 4)] {
        solver.analyse(&a.pattern, &unknowns).unwrap();
        let predicted = solver.predicted().unwrap();
        let cost = solver.factor(&a).unwrap().cost;
        assert_eq!((predicted.fill, predicted.flops), (cost.fill, cost.flops));
        let bytes = size * predicted.fill.unwrap();
        assert_eq!(predicted.bytes, Some(bytes));
        assert!((bytes..4 * bytes).contains(&cost.bytes.unwrap()), "{bytes} {cost:?}");
    }
}

/// Any matrix, not only those of finite elements: no symmetry, several components, no positions.
#[test]
fn unsymmetric_matrices_without_geometry() {
    let n = 700;
    let mut rows = vec![Vec::new(); n];
    for i in 0..n {
        rows[i] = vec![i as u32, ((i * i + 7) % n) as u32, ((3 * i + 1) % n) as u32];
    }
    for i in n - 100..n {
        rows[i] = vec![i as u32];
    }
    let pattern = Arc::new(Pattern::from_rows(&rows));
    let mut a = Csr::zeros(&pattern);
    for i in 0..n {
        for k in pattern.row(i) {
            let diagonal = if pattern.column(i, k) as usize == i { 3.0 } else { 0.0 };
            a.values[k] = diagonal + (k as f64 * 2.3).sin();
        }
    }
    let unknown = |i: usize| Unknown { node: (i / 2) as u32 * 17, kind: Kind::Velocity, at: [0.0; 3] };
    let system = System { unknowns: (0..n).map(unknown).collect(), a };
    for mut solver in solvers() {
        solver.analyse(&pattern, &system.unknowns).unwrap();
        let error = solve_known(&mut *solver, &system);
        assert!(error < 1e-10, "{}: error {error:e}", solver.name());
    }
}
