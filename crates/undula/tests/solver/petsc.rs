//! PETSc as a solver, where it is installed; the tests say so and end where it is not.

use super::matrices::{Pressure, Setup, System};
use super::{known_solution, solve_known};
use undula::algebra::petsc::{PetscSolver, USUAL_OPTIONS, engine, mistake_in_options};
use undula::algebra::{Kind, LinearSolver, SolverError};

const FIELDS: [Kind; 2] = [Kind::Velocity, Kind::Pressure];

/// Whether PETSc is there, with MUMPS inside.
fn is_there() -> bool {
    match engine() {
        Ok(engine) if engine.packages[0] == ("MUMPS", true) => true,
        Ok(_) => {
            println!("skipped: PETSc without MUMPS");
            false
        }
        Err(missing) => {
            println!("skipped: {missing}");
            false
        }
    }
}

fn solver(options: &str, system: &System) -> PetscSolver {
    let mut solver = PetscSolver::new(options, 3);
    solver.analyse(&system.a.pattern, &system.unknowns).unwrap();
    solver
}

#[test]
fn factors_of_petsc_find_known_solutions() {
    if !is_there() {
        return;
    }
    for system in super::systems() {
        let error = solve_known(&mut solver(USUAL_OPTIONS, &system), &system);
        assert!(error < 1e-9, "n = {}: error {error:e}", system.a.pattern.n);
    }
}

/// The values of the second matrix take the place of those of the first, and the factors are new.
#[test]
fn another_matrix_of_the_pattern_is_another_system() {
    if !is_there() {
        return;
    }
    let setup = Setup::fsi(16, 9, Pressure::P1dc);
    let (first, second) = (setup.system(), Setup { wind: -3.0, ..setup }.system());
    let mut solver = solver(USUAL_OPTIONS, &first);
    for system in [&first, &second, &first] {
        let error = solve_known(&mut solver, system);
        assert!(error < 1e-9, "error {error:e}");
        let (known, n) = (known_solution(&system.unknowns), system.a.pattern.n);
        let (mut b, mut x) = (vec![0.0; n], vec![f64::NAN; n]);
        system.a.mul(&known, &mut b);
        solver.apply(&b, &mut x);
        assert!(super::error(&system.unknowns, &x, &known) < 1e-6);
    }
}

/// Fields have names, v and p; the iteration measures the residual of the scaled system.
#[test]
fn an_iteration_reaches_the_tolerance_it_is_asked_for() {
    if !is_there() {
        return;
    }
    let system = Setup::flow(20, 10, Pressure::Q1).system();
    let options = "-ksp_type fgmres -ksp_rtol 1e-10 -ksp_max_it 200 -pc_type fieldsplit -pc_fieldsplit_type schur \
                   -pc_fieldsplit_schur_fact_type full -pc_fieldsplit_schur_precondition selfp \
                   -fieldsplit_v_ksp_type preonly -fieldsplit_v_pc_type lu \
                   -fieldsplit_p_ksp_type gmres -fieldsplit_p_ksp_rtol 1e-3 -fieldsplit_p_pc_type jacobi";
    let found = solve_known(&mut solver(options, &system), &system);
    assert!(found < 1e-6, "error {found:e}");
    let loose = solve_known(&mut solver(&options.replace("1e-10", "1e-2"), &system), &system);
    assert!(loose > found, "{loose:e} {found:e}");
}

/// What PETSc calls converged is judged by a residual of our own.
#[test]
fn a_solution_that_is_none_is_an_error() {
    if !is_there() {
        return;
    }
    let system = Setup::flow(8, 6, Pressure::P1dc).system();
    let n = system.a.pattern.n;
    let message = |options: &str| {
        let (mut solver, mut x) = (solver(options, &system), vec![0.0; n]);
        let result = solver.factor(&system.a).and_then(|_| solver.solve(&system.a, &vec![1.0; n], &mut x));
        match result {
            Err(SolverError::Engine(message)) => message,
            other => panic!("{options}: {other:?}"),
        }
    };
    let skipped = message("-ksp_type richardson -ksp_max_it 2 -ksp_convergence_test skip -pc_type none");
    assert!(skipped.contains("PETSc calls the system solved, but the residual is"), "{skipped}");
    let once = message("-ksp_type preonly -pc_type none");
    assert!(once.contains("PETSc calls the system solved, but the residual is"), "{once}");
    let stopped = message("-ksp_type gmres -ksp_max_it 2 -ksp_rtol 1e-12 -pc_type none");
    assert!(stopped.contains("DIVERGED_ITS") && stopped.contains("after 2 iterations"), "{stopped}");
}

#[test]
fn a_singular_matrix_is_an_error() {
    if !is_there() {
        return;
    }
    let mut system = Setup::flow(8, 6, Pressure::P1dc).system();
    let n = system.a.pattern.n;
    // Two rows of one node have the same columns.
    let twins = (0..n - 1).find(|&i| {
        let [a, b] = [i, i + 1].map(|row| system.a.pattern.columns(row));
        a == b
    });
    let first = twins.unwrap();
    let (from, to) = (system.a.pattern.row(first), system.a.pattern.row(first + 1));
    system.a.values.copy_within(from, to.start);
    let (mut solver, mut x) = (solver(USUAL_OPTIONS, &system), vec![0.0; n]);
    let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
    let result = solver.factor(&system.a).and_then(|_| solver.solve(&system.a, &b, &mut x));
    assert!(matches!(result, Err(SolverError::Engine(_))), "{result:?}");
    let nan = vec![f64::NAN; n];
    let wrong = Setup::flow(8, 6, Pressure::P1dc).system();
    solver.factor(&wrong.a).unwrap();
    assert!(matches!(solver.solve(&wrong.a, &nan, &mut x), Err(SolverError::RightHandSide { row: 0, .. })));
}

#[test]
fn mistakes_in_options_are_told() {
    if !is_there() {
        return;
    }
    let told = |options: &str| mistake_in_options(options, &FIELDS).unwrap();
    for (options, word) in [
        ("-ksp_tpye gmres", "`-ksp_tpye`"),
        ("-ksp_type nosuch", "nosuch"),
        ("-pc_type nosuch", "nosuch"),
        ("-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type nosuch", "nosuch"),
        ("-ksp_type gmres -ksp_rtol small", "small"),
        ("-ksp_type fgmres -pc_type jacobi -fieldsplit_v_pc_type lu", "`-fieldsplit_v_pc_type`"),
    ] {
        let mistake = told(options).unwrap_or_else(|| panic!("{options}: nothing was told"));
        assert!(mistake.contains(word) && !mistake.contains('\n'), "{options}: {mistake}");
    }
    for options in [
        USUAL_OPTIONS,
        "-ksp_type fgmres -pc_type gamg -mg_levels_ksp_type richardson -mg_levels_3_pc_type sor",
        "-ksp_type fgmres -ksp_rtol 1e-3 -pc_type fieldsplit -pc_fieldsplit_type schur -fieldsplit_v_pc_type gamg \
         -fieldsplit_p_pc_type jacobi",
        "-ksp_type fgmres -pc_type bjacobi -sub_pc_type ilu -sub_pc_factor_levels 1",
        "-ksp_type fgmres -pc_type fieldsplit -fieldsplit_v_pc_type bjacobi -fieldsplit_v_sub_pc_type sor \
         -fieldsplit_p_ksp_type preonly",
    ] {
        assert_eq!(told(options), None, "{options}");
    }
}

/// PETSc is not made for threads: they take turns.
#[test]
fn solvers_of_several_threads_do_not_meet() {
    if !is_there() {
        return;
    }
    let work = |nx: usize| {
        let system = Setup::fsi(nx, 8, Pressure::P1dc).system();
        let mut solver = solver(USUAL_OPTIONS, &system);
        (0..5).map(|_| solve_known(&mut solver, &system)).fold(0.0, f64::max)
    };
    let errors: Vec<f64> = std::thread::scope(|scope| {
        let threads: Vec<_> = (6..10).map(|nx| scope.spawn(move || work(nx))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(errors.iter().all(|error| *error < 1e-9), "{errors:?}");
}
