//! GMRES with kept factors: the same solutions, with fewer factorisations.

use crate::common::builtin;
use undula::nonlinear::Counters;
use undula::simulation::Simulation;

/// fsi3 with an early inflow and a body force that bends the beam.
const MOVING: [&str; 6] = [
    "mesh.refine=0",
    "time.step=0.005",
    "time.end=0.1",
    "solid.body-force=[0, -8]",
    "boundary.inflow.velocity=[\"1.5*2*y*(0.41-y)/0.205^2 * ramp(t, 0.2)\", 0]",
    "newton.tolerance=1e-10",
];

const GMRES: &str = "linear.krylov=gmres";

fn run(case: &str, settings: &[&str], more: &[&str]) -> Simulation {
    let mut simulation = Simulation::new(builtin(case, &[settings, more].concat()), 1).unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    assert_eq!(simulation.stepper.linear.detour, 0, "{more:?} took the whole Jacobian");
    simulation
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Work without and with GMRES, which arrive at the same solution.
fn compare(case: &str, settings: &[&str], more: &[&str]) -> [Counters; 2] {
    let (without, with) = (run(case, settings, more), run(case, settings, &[more, &[GMRES]].concat()));
    let (a, b) = (&without.stepper.new, &with.stepper.new);
    for (field, a, b) in [("v", &a.v, &b.v), ("u", &a.u, &b.u), ("p", &a.p, &b.p)] {
        let gap = a.iter().zip(b).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs()));
        assert!(gap < 1e-7 * largest(a), "{case} {more:?} {field}: {gap:e}");
    }
    let work = [&without, &with].map(|simulation| simulation.stepper.newton.counters);
    println!("{case} {more:?}: {work:?}");
    work
}

/// Factors of the whole matrix and the condensed one; with all that is left out, and of another k.
#[test]
#[ignore = "long"]
fn factors_outlive_matrices_and_the_solution_is_the_same() {
    let factored = |more: &[&str]| {
        let [without, with] = compare("fsi3", &MOVING, more);
        assert_eq!(without.jacobians, without.factorizations, "{more:?}");
        // One matrix in each of twenty steps, each of three parts in one of the schemes.
        assert!(with.jacobians >= 20 && with.factorizations < with.jacobians, "{more:?}: {with:?}");
        // Directions of a matrix may serve several corrections, but none those of another matrix.
        assert!(with.linear_iterations >= with.jacobians, "{more:?}: {with:?}");
        with.factorizations
    };
    for linearization in ["condensed", "newton", "reduced", "fixed-point"] {
        let linearization = format!("newton.linearization={linearization}");
        let factorizations = factored(&[&linearization]);
        // Where the matrix leaves out more, it is made several times in a step.
        let often = ["reduced", "fixed-point"].iter().any(|l| linearization.ends_with(l));
        assert!(often || factorizations <= 10, "{linearization}: {factorizations}");
    }
    factored(&["time.scheme=fractional-step-theta"]);
    factored(&["time.scheme=fractional-step-theta", "newton.linearization=newton"]);
    factored(&["linear.precision=double", "linear.krylov-tolerance=1e-4"]);
}

/// Where u does not follow from v, and the load is raised at once.
#[test]
fn a_stationary_solution_is_the_same() {
    let at_rest = ["mesh.refine=0", "newton.tolerance=1e-10"];
    for more in [&[][..], &["newton.rate-max=0"]] {
        let [without, with] = compare("fsi1", &at_rest, more);
        assert!(with.factorizations < without.factorizations, "{more:?}: {with:?}");
    }
}

/// Few iterations are not enough: then the factors are renewed, and nothing else goes wrong.
#[test]
fn factors_are_renewed_where_gmres_fails() {
    let strict = ["linear.krylov-size=2", "linear.krylov-tolerance=1e-4"];
    let [_, loose] = compare("fsi3", &MOVING, &[]);
    let [_, strict] = compare("fsi3", &MOVING, &strict);
    assert!(strict.factorizations > loose.factorizations, "{strict:?} {loose:?}");
}
