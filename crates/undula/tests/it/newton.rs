//! Newton's method on one equation: when a Jacobian is kept, when it ends, and what the line search is for.

use crate::common::builtin;
use undula::algebra::SolverError;
use undula::nonlinear::{Newton, NewtonError, NewtonReport, NewtonSettings, NonlinearSystem, Seconds};
use undula::simulation::Simulation;

/// f(x) = exp(x) − 1, with a derivative too large by a factor.
struct Exponential {
    x: f64,
    slope: f64,
    factor: f64,
}

impl NonlinearSystem for Exponential {
    fn residual(&mut self, r: &mut [f64]) -> Option<f64> {
        r[0] = self.x.exp() - 1.0;
        r[0].is_finite().then_some(r[0].abs())
    }

    fn renew(&mut self, _: &mut Seconds) -> Result<usize, SolverError> {
        self.slope = self.factor * self.x.exp();
        Ok(0)
    }

    fn correct(&mut self, r: &[f64], delta: &mut [f64]) -> Result<usize, SolverError> {
        delta[0] = r[0] / self.slope;
        Ok(1)
    }

    fn is_exact(&self) -> bool {
        self.factor == 1.0
    }

    fn price(&self) -> f64 {
        5.0
    }

    fn update(&mut self, omega: f64, delta: &[f64]) {
        self.x += omega * delta[0];
    }
}

const EXACT: NewtonSettings = NewtonSettings {
    tolerance: 1e-12,
    floor: Some(0.0),
    rate_max: Some(0.0),
    secants: 0,
    max_steps: 50,
    line_search: 0,
};

fn solve(settings: NewtonSettings, x: f64) -> (Result<NewtonReport, NewtonError>, f64) {
    let (mut newton, mut system) = (Newton::new(settings, 1, 1), Exponential { x, slope: 1.0, factor: 1.0 });
    let start = newton.norm(&mut system).unwrap();
    (newton.solve(&mut system, start, start), system.x)
}

#[test]
fn exact_newton_is_quadratic_with_a_jacobian_per_iteration() {
    let report = solve(EXACT, 1.0).0.unwrap();
    assert_eq!(report.jacobians, report.steps);
    // Near the root r_(n+1) = ½ r_n².
    for pair in report.norms.windows(2).filter(|pair| pair[0] < 0.1 && pair[1] > 1e-13) {
        assert!((pair[1] / (0.5 * pair[0] * pair[0]) - 1.0).abs() < 0.1, "{:?}", report.norms);
    }
}

/// (5.20): a Jacobian is renewed after an iteration whose rate is above γ_nt, and only then.
#[test]
fn a_jacobian_is_kept_while_the_rate_is_good() {
    for rate_max in [0.05, 0.2, 0.5] {
        let report = solve(NewtonSettings { rate_max: Some(rate_max), ..EXACT }, 1.0).0.unwrap();
        let rates: Vec<f64> = report.norms.windows(2).map(|pair| pair[1] / pair[0]).collect();
        let bad = rates[..rates.len() - 1].iter().filter(|rate| **rate > rate_max).count();
        assert_eq!(report.jacobians, 1 + bad, "{rate_max}: {rates:?}");
        assert!(report.jacobians < report.steps, "{rate_max}: {rates:?}");
    }
}

#[test]
fn a_jacobian_is_kept_across_solves() {
    let settings = NewtonSettings { rate_max: Some(0.5), ..EXACT };
    let (mut newton, mut system) =
        (Newton::new(settings, 1, 1), Exponential { x: 0.1, slope: 1.0, factor: 1.0 });
    for (solve, jacobians) in [(0, 1), (1, 0), (2, 0)] {
        system.x = 0.1;
        let start = newton.norm(&mut system).unwrap();
        let report = newton.solve(&mut system, start, start).unwrap();
        assert_eq!(report.jacobians, jacobians, "solve {solve}");
    }
    newton.forget();
    system.x = 0.1;
    let start = newton.norm(&mut system).unwrap();
    assert_eq!(newton.solve(&mut system, start, start).unwrap().jacobians, 1);
}

#[test]
fn it_ends_at_the_relative_or_the_absolute_tolerance() {
    let last = |settings| {
        let norms = solve(settings, 1.0).0.unwrap().norms;
        (norms[norms.len() - 2], norms[norms.len() - 1], norms[0])
    };
    let (before, end, start) = last(NewtonSettings { tolerance: 1e-3, ..EXACT });
    assert!(before > 1e-3 * start && end <= 1e-3 * start);
    let (before, end, _) = last(NewtonSettings { floor: Some(1e-2), ..EXACT });
    assert!(before > 1e-2 && end <= 1e-2);
    // The reference is that of the old solution, whatever the start value.
    let (mut newton, mut system) =
        (Newton::new(EXACT, 1, 1), Exponential { x: 0.5, slope: 1.0, factor: 1.0 });
    let start = newton.norm(&mut system).unwrap();
    assert_eq!(newton.solve(&mut system, start, 1e12 * start).unwrap().steps, 0);
}

/// Three unknowns, of which an old Jacobian leaves more and more from one to the next, a new one little of each.
struct Ageing {
    x: [f64; 3],
    left: [f64; 3],
}

impl NonlinearSystem for Ageing {
    fn residual(&mut self, r: &mut [f64]) -> Option<f64> {
        r.copy_from_slice(&self.x);
        Some(self.x.iter().fold(0.0, |max: f64, x| max.max(x.abs())))
    }

    fn renew(&mut self, _: &mut Seconds) -> Result<usize, SolverError> {
        self.left = [0.03; 3];
        Ok(0)
    }

    fn correct(&mut self, r: &[f64], delta: &mut [f64]) -> Result<usize, SolverError> {
        (0..3).for_each(|i| delta[i] = (1.0 - self.left[i]) * r[i]);
        Ok(1)
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn price(&self) -> f64 {
        5.0
    }

    fn update(&mut self, omega: f64, delta: &[f64]) {
        (0..3).for_each(|i| self.x[i] += omega * delta[i]);
    }
}

/// Two iterations of a step say that its Jacobian may be kept, the rest say no: the next step knows.
#[test]
fn a_step_that_kept_a_bad_jacobian_is_the_last() {
    let settings = NewtonSettings { tolerance: 1e-8, rate_max: None, ..EXACT };
    let (mut newton, mut system) = (Newton::new(settings, 3, 3), Ageing { x: [0.0; 3], left: [0.03; 3] });
    let work = [0, 1, 2].map(|_| {
        (system.x, system.left) = ([1.0, 0.01, 1e-5], [0.001, 0.05, 0.5]);
        let start = newton.norm(&mut system).unwrap();
        let report = newton.solve(&mut system, start, start).unwrap();
        (report.jacobians, report.steps)
    });
    assert_eq!(work, [(1, 6), (0, 10), (1, 5)]);
}

/// What converges slowly, because its Jacobian leaves something out, has not met rounding: with rates of 0.6 to 0.85,
/// steps ended at 1e-5 of the reference where 1e-10 was asked for.
#[test]
fn slow_convergence_is_not_taken_for_rounding() {
    for rate in [0.6, 0.85] {
        let settings = NewtonSettings { tolerance: 1e-10, rate_max: None, max_steps: 200, ..EXACT };
        let mut system = Exponential { x: 0.5, slope: 1.0, factor: 1.0 / (1.0 - rate) };
        let mut newton = Newton::new(settings, 1, 1);
        for settings in [settings, NewtonSettings { rate_max: Some(0.0), ..settings }] {
            (newton.settings, system.x) = (settings, 0.5);
            let start = newton.norm(&mut system).unwrap();
            let norms = newton.solve(&mut system, start, start).unwrap().norms;
            assert!(norms[norms.len() - 1] <= 1e-10 * start, "{rate}: {norms:?}");
        }
    }
}

/// A residual of 1e-9 that no correction changes is.
#[test]
fn what_cannot_be_reduced_is_rounding() {
    struct Rough(Exponential);
    impl NonlinearSystem for Rough {
        fn residual(&mut self, r: &mut [f64]) -> Option<f64> {
            let norm = self.0.residual(r)?;
            r[0] = r[0].signum() * norm.max(1e-10);
            Some(r[0].abs())
        }
        fn renew(&mut self, seconds: &mut Seconds) -> Result<usize, SolverError> {
            self.0.renew(seconds)
        }
        fn correct(&mut self, r: &[f64], delta: &mut [f64]) -> Result<usize, SolverError> {
            self.0.correct(r, delta)
        }
        fn is_exact(&self) -> bool {
            self.0.is_exact()
        }
        fn price(&self) -> f64 {
            self.0.price()
        }
        fn update(&mut self, omega: f64, delta: &[f64]) {
            self.0.update(omega, delta);
        }
    }
    for factor in [1.0, 1.5] {
        let mut system = Rough(Exponential { x: 0.5, slope: 1.0, factor });
        let mut newton = Newton::new(EXACT, 1, 1);
        let start = newton.norm(&mut system).unwrap();
        let norms = newton.solve(&mut system, start, start).unwrap().norms;
        assert_eq!(norms[norms.len() - 1], 1e-10, "{factor}: {norms:?}");
    }
}

/// From x = −3 the full step leads to x = 16, where f is ten millions.
#[test]
fn the_line_search_shortens_steps_that_go_astray() {
    assert!(matches!(solve(EXACT, -3.0).0, Err(NewtonError::Stalled { .. })));
    let (report, x) = solve(NewtonSettings { line_search: 5, ..EXACT }, -3.0);
    assert!(report.is_ok() && x.abs() < 1e-12, "{x}");
}

#[test]
fn too_many_iterations_are_an_error() {
    let (report, _) = solve(NewtonSettings { max_steps: 2, ..EXACT }, 1.0);
    assert!(matches!(report, Err(NewtonError::Stalled { norms }) if norms.len() == 3));
}

/// Remark 5.1: the extrapolated start value is the better one where the motion is smooth, and the solution and the
/// criterion are the same.
#[test]
fn extrapolation_starts_nearer() {
    let run = |start: &str| {
        let settings = ["mesh.refine=0", "time.step=0.01", "time.end=0.2", "newton.rate-max=0", start];
        let mut simulation = Simulation::new(builtin("fsi3", &settings), 1).unwrap();
        while !simulation.finished() {
            simulation.step().unwrap();
        }
        simulation
    };
    let (old, extrapolated) = (run("newton.start=old"), run("newton.start=extrapolated"));
    let (a, b) = (&old.report.residuals, &extrapolated.report.residuals);
    assert!(b[0] < 0.2 * a[0], "{a:?} {b:?}");
    assert!(b[b.len() - 1] <= 1e-8 * a[0], "{a:?} {b:?}");
    let (a, b) = (&old.stepper.new.v, &extrapolated.stepper.new.v);
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6));
}

/// A beam that comes to rest: the residual that is asked for falls below the rounding of its stresses, and an update that
/// moves it by no more than that ends the step. It ended the run, as a breakdown at 5.6 s.
#[test]
fn a_body_comes_to_rest() {
    let settings = ["mesh.refine=0", "time.scheme=backward-euler", "time.step=0.1", "time.end=12"];
    for way in ["newton.linearization=condensed", "newton.linearization=newton"] {
        let mut simulation = Simulation::new(builtin("csm3", &[&settings[..], &[way]].concat()), 1).unwrap();
        let mut last = 0.0f64;
        while !simulation.finished() {
            last = simulation.step().unwrap().values[1];
        }
        assert!((last / -0.065_639_76 - 1.0).abs() < 1e-4, "{way}: {last}");
        assert_eq!(simulation.stepper.linear.detour, 0, "{way}");
    }
}
