//! Condensed Newton: the system it solves, and that it arrives where the whole Jacobian does.

use crate::common::{SCHEMES, builtin};
use crate::manufactured::*;
use std::sync::Arc;
use undula::algebra::{Csr, LinearSolver, MultifrontalLu, Options as LinearOptions};
use undula::linear::{Linear, Purpose};
use undula::nonlinear::Seconds;
use undula::physics::StepRule;
use undula::physics::rule::{MIDPOINT, SECANT};
use undula::simulation::Simulation;
use undula::space::PressureKind::{self, Continuous, Pdc};
use undula::space::{PsiOwner, Region, State};
use undula::system::{Assembler, Options, Physics, StepView};
use undula::tangent::Tangent;
use undula::time::Linearization;
use undula::time::scheme::FRACTIONAL;
use undula::verification::manufactured::{Exact, InTime, Manufactured, Values, number};

const RULE: StepRule = StepRule { per_k: 20.0, theta: 0.6, inertia: SECANT, quadrature: &[] };

fn coupled(physics: Physics, pressure: PressureKind) -> Manufactured {
    coupled_in(quadrilaterals(2, pressure), physics)
}

fn coupled_in(pair: Pair, physics: Physics) -> Manufactured {
    let zero = number(0.0);
    let nothing: Exact = Arc::new(move |_, _| Values { v: [zero; 2], u: [zero; 2], p: zero });
    let space = pair.space(&square(4, Cells::Curved, Body::Block), &physics);
    problem_in(space, physics, nothing, InTime::Difference, pair.quadrature())
}

/// The more nodes, the closer, and the smaller the values, so that gradients are alike.
fn random(problem: &Manufactured, seed: u64, sizes: [f64; 3]) -> State {
    let (space, mut random) = (&problem.space, Random(seed));
    let closer = 2.0 / space.nodes.degree as f64;
    let mut list = |n: usize, size: f64| (0..n).map(|_| closer * size * random.next()).collect();
    State {
        v: list(space.n_v(), sizes[0]),
        u: list(space.n_u(), sizes[1]),
        p: list(space.n_p(), sizes[2]),
        s: vec![],
    }
}

fn linear(kind: Linearization) -> Linear<2> {
    linear_with(kind, |_| {})
}

fn linear_with(kind: Linearization, told: impl Fn(Purpose) + Send + 'static) -> Linear<2> {
    let options = LinearOptions::default();
    let make = move |purpose| {
        told(purpose);
        Box::new(match purpose {
            Purpose::Definite => MultifrontalLu::definite(options),
            _ => MultifrontalLu::multifrontal(options),
        }) as Box<dyn LinearSolver>
    };
    Linear::new(kind, Box::new(make))
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// A right-hand side `[v, u, p]` without given rows and without the velocity-deformation relation.
fn right_hand_side(problem: &Manufactured, assembler: &Assembler<2>) -> Vec<f64> {
    let space = &problem.space;
    let State { v, u, p, .. } = random(problem, 5, [1.0, 1.0, 1.0]);
    let mut r = [v, u, p].concat();
    assembler.zero_given(&mut r);
    for node in (0..space.nodes.len()).filter(|&n| space.deforms && space.owner[n] == PsiOwner::Relation) {
        r[space.n_v() + 2 * node..][..2].fill(0.0);
    }
    r
}

fn correction(assembler: &mut Assembler<2>, kind: Linearization, view: &StepView<'_>, r: &[f64]) -> Vec<f64> {
    let (mut linear, mut delta) = (linear(kind), vec![0.0; r.len()]);
    linear.renew(assembler, view, Tangent::Analytic, &mut Seconds::default()).unwrap();
    linear.correct(assembler, view, false, r, &mut delta).unwrap();
    delta
}

/// The condensed correction δ solves J δ = r without the derivatives of the flow with respect to u, and
/// δu = kθ δv at the nodes of the solid.
fn check(physics: Physics, pressure: PressureKind, rule: StepRule, options: &Options) {
    check_problem(coupled(physics, pressure), rule, options);
}

fn check_problem(problem: Manufactured, rule: StepRule, options: &Options) {
    let physics = problem.physics;
    let space = problem.space.clone();
    let mut assembler = problem.assembler(options);
    let (new, old) = (random(&problem, 77, [2.0, 0.02, 4.0]), random(&problem, 78, [2.0, 0.02, 4.0]));
    let view = StepView { rule, new: &new, old: &old };
    let r = right_hand_side(&problem, &assembler);
    let delta = correction(&mut assembler, Linearization::Condensed, &view, &r);

    let mut matrix = Csr::zeros(&assembler.pattern());
    assembler.jacobian(&view, Tangent::Analytic, &mut matrix);
    let mut product = vec![0.0; r.len()];
    matrix.mul(&delta, &mut product);
    let (n_v, n_u, size) = (space.n_v(), space.n_u(), largest(&product));
    if physics.fluid.is_some() && space.deforms {
        let mut moved = |by: f64| {
            let mut new = new.clone();
            new.u.iter_mut().zip(&delta[n_v..]).for_each(|(u, d)| *u += by * d);
            let mut out = vec![0.0; r.len()];
            assembler.region_residual(&StepView { rule, new: &new, old: &old }, Region::Fluid, &mut out);
            assembler.zero_given(&mut out);
            out
        };
        // The error of the difference is h²: 1e-5 leaves 2e-8 with the many nodes of Q4.
        let h = 1e-6 / largest(&delta[n_v..n_v + n_u]);
        let (plus, minus) = (moved(h), moved(-h));
        for i in (0..n_v).chain(n_v + n_u..r.len()) {
            product[i] -= (plus[i] - minus[i]) / (2.0 * h);
        }
    }
    let given = {
        let mut m = vec![1.0; r.len()];
        assembler.zero_given(&mut m);
        m
    };
    for node in (0..space.nodes.len()).filter(|&n| space.deforms && space.owner[n] == PsiOwner::Relation) {
        for i in 2 * node..2 * node + 2 {
            product[n_v + i] = 0.0;
            let expected = if given[n_v + i] == 0.0 { 0.0 } else { rule.theta / rule.per_k * delta[i] };
            assert!((delta[n_v + i] - expected).abs() < 1e-12 * largest(&delta), "δu = kθ δv at node {node}");
        }
    }
    let gap = product.iter().zip(&r).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs()));
    let pressure = space.pressure.kind;
    assert!(gap < 1e-8 * size, "{physics:?} {pressure:?} {rule:?}: {gap:e} of {size:e}");
}

#[test]
fn the_correction_solves_the_condensed_system() {
    for pressure in [Pdc(1), Continuous(1)] {
        for physics in [FSI, FLOW, BODY] {
            check(physics, pressure, RULE, &options());
        }
        check(FLOW, pressure, StepRule::STATIONARY, &options());
    }
    let bdf2 = StepRule { per_k: 27.0, ..StepRule::theta(1.0, 1.0) };
    for rule in [bdf2, StepRule::galerkin(0.05), StepRule { inertia: MIDPOINT, ..RULE }] {
        check(FSI, Pdc(1), rule, &options());
    }
}

/// A constant extension is factorised as the symmetric operator that it is.
#[test]
fn constant_extensions_are_definite() {
    use undula::physics::{Extension::*, Fluid};
    for (model, expected) in [
        (Harmonic, Purpose::Definite),
        (PseudoElastic { poisson: 0.3 }, Purpose::Definite),
        (PseudoElastic { poisson: -0.4 }, Purpose::Definite),
        (JacobianStiffened { poisson: 0.1, lagged: true }, Purpose::Correction),
    ] {
        let problem = coupled(Physics { fluid: Some(Fluid { extension: model, ..FLUID }), ..FSI }, Pdc(1));
        let mut assembler = problem.assembler(&options());
        let state = random(&problem, 91, [1.0, 0.01, 1.0]);
        let view = StepView { rule: RULE, new: &state, old: &state };
        let (sender, receiver) = std::sync::mpsc::channel();
        let mut linear = linear_with(Linearization::Condensed, move |purpose| sender.send(purpose).unwrap());
        linear.renew(&mut assembler, &view, Tangent::Analytic, &mut Seconds::default()).unwrap();
        let purposes: Vec<Purpose> = receiver.try_iter().collect();
        assert_eq!(purposes, [Purpose::Condensed, expected], "{model:?}");
    }
}

/// What is left out where the extension has settled is its residual, and nothing else.
#[test]
fn a_settled_extension_follows_the_interface() {
    let problem = coupled(FSI, Pdc(1));
    let mut assembler = problem.assembler(&options());
    let (new, old) = (random(&problem, 81, [0.0; 3]), random(&problem, 82, [0.0; 3]));
    let view = StepView { rule: RULE, new: &new, old: &old };
    let mut linear = linear(Linearization::Condensed);
    linear.renew(&mut assembler, &view, Tangent::Analytic, &mut Seconds::default()).unwrap();
    let r = right_hand_side(&problem, &assembler);
    let mut without = r.clone();
    let n_v = assembler.space.n_v();
    for (node, owner) in assembler.space.owner.iter().enumerate() {
        if *owner == PsiOwner::Extension {
            without[n_v + 2 * node..][..2].fill(0.0);
        }
    }
    let mut correct = |settled, r: &[f64]| {
        let mut delta = vec![0.0; r.len()];
        linear.correct(&mut assembler, &view, settled, r, &mut delta).unwrap();
        delta
    };
    let settled = correct(true, &r);
    assert_eq!(settled, correct(false, &without));
    assert_ne!(settled, correct(false, &r));
}

/// δu follows δv with the coefficient of each scheme; corrections of parts with other lengths are scaled.
#[test]
fn every_scheme_has_the_same_solution_condensed() {
    for scheme in SCHEMES {
        let common = ["mesh.refine=0", "time.end=0.06", "time.step=0.01", "newton.tolerance=1e-10", scheme];
        let with = |more| run(&[&common[..], &[more]].concat());
        let (a, b) = (with("newton.linearization=newton"), with("newton.linearization=condensed"));
        assert_eq!(b.stepper.linear.detour, 0, "{scheme}: the whole Jacobian was taken");
        let (x, y) = (&a.stepper.new, &b.stepper.new);
        for (field, x, y) in [("v", &x.v, &y.v), ("u", &x.u, &y.u), ("p", &x.p, &y.p)] {
            let gap = x.iter().zip(y).fold(0.0f64, |gap, (x, y)| gap.max((x - y).abs())) / largest(x);
            println!("{scheme} {field}: {gap:.1e}");
            assert!(gap < 1e-6, "{scheme} {field}: {gap:e}");
        }
    }
}

/// All parts of fractional-step θ have one matrix: a kept Jacobian serves all three as if it were their own.
#[test]
fn fractional_steps_share_one_jacobian() {
    let iterations = |problem: &Manufactured, theta: [f64; 2], k: [f64; 2]| {
        let mut assembler = problem.assembler(&options());
        let (new, old) = (random(problem, 77, [0.0, 0.0, 0.0]), random(problem, 78, [0.0, 0.0, 0.0]));
        let [first, second] = [0, 1].map(|i| StepRule::theta(k[i], theta[i]));
        let mut linear = linear(Linearization::Condensed);
        let view = |rule| StepView { rule, new: &new, old: &old };
        linear.renew(&mut assembler, &view(first), Tangent::Analytic, &mut Seconds::default()).unwrap();
        let r = right_hand_side(problem, &assembler);
        let mut delta = vec![0.0; r.len()];
        linear.correct(&mut assembler, &view(second), false, &r, &mut delta).unwrap();
        let own = correction(&mut assembler, Linearization::Condensed, &view(second), &r);
        delta.iter().zip(&own).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs())) / largest(&own)
    };
    let [a, b, _] = FRACTIONAL;
    let problem = coupled(FSI, Pdc(1));
    let same = iterations(&problem, [a.theta, b.theta], [0.1 * a.length, 0.1 * b.length]);
    let other = iterations(&problem, [a.theta, a.theta], [0.1 * a.length, 0.1 * b.length]);
    println!("{same:e} {other:e}");
    assert!(same < 1e-10 && other > 1e-3, "{same:e} {other:e}");
}

/// More unknowns inside of a cell, none in P0 or Q1 cells, in a fluid with convection and in a solid.
#[test]
fn elements_of_any_degree_are_condensed() {
    let pairs = [(2, Pdc(0)), (3, Pdc(2)), (3, Pdc(1)), (3, Continuous(2)), (4, Pdc(3)), (4, Continuous(3))];
    for (degree, pressure) in pairs {
        check_pair(quadrilaterals(degree, pressure));
    }
    for pair in [triangles(2, Continuous(1)), triangles(3, Continuous(2)), triangles(3, Pdc(1)), BUBBLE] {
        check_pair(pair);
    }
    for pair in [quadrilaterals(1, Continuous(1)), triangles(1, Continuous(1))] {
        check_problem(coupled_in(pair, BODY), RULE, &options());
    }
}

fn check_pair(pair: Pair) {
    let options = Options::serial(pair.quadrature());
    check_problem(coupled_in(pair, FSI), RULE, &options);
    check_problem(coupled_in(pair, FLOW), StepRule::STATIONARY, &options);
}

#[test]
fn any_lanes_solve_it() {
    for lanes in [1, 4, 8] {
        check(FSI, Pdc(1), RULE, &Options { lanes, threads: 1, quadrature: QUADRATURE });
    }
}

/// Without deformation, and in a solid alone, nothing is left out.
#[test]
fn without_coupling_it_is_newton() {
    for (physics, rule) in [(FLOW, RULE), (FLOW, StepRule::STATIONARY), (BODY, RULE)] {
        let problem = coupled(physics, Pdc(1));
        let mut assembler = problem.assembler(&options());
        let (new, old) = (random(&problem, 7, [2.0, 0.02, 4.0]), random(&problem, 8, [2.0, 0.02, 4.0]));
        let view = StepView { rule, new: &new, old: &old };
        let r = right_hand_side(&problem, &assembler);
        let [condensed, full] = [Linearization::Condensed, Linearization::Newton]
            .map(|kind| correction(&mut assembler, kind, &view, &r));
        let gap = condensed.iter().zip(&full).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs()));
        assert!(gap < 1e-9 * largest(&full), "{gap:e} of {:e}", largest(&full));
    }
}

fn run(overrides: &[&str]) -> Simulation {
    let mut simulation = Simulation::new(builtin("fsi3", overrides), 1).unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    simulation
}

#[test]
fn every_linearization_and_precision_has_the_same_solution() {
    let common = ["mesh.refine=0", "time.end=0.1", "time.step=0.01", "newton.tolerance=1e-10"];
    let with = |more: &[&'static str]| run(&[&common[..], more].concat());
    let reference = with(&["newton.linearization=newton"]);
    for more in [&["newton.linearization=condensed"][..], &["linear.precision=double"], &["newton.secants=8"]]
    {
        let other = with(more);
        let (a, b) = (&reference.stepper.new, &other.stepper.new);
        for (field, a, b) in [("v", &a.v, &b.v), ("u", &a.u, &b.u), ("p", &a.p, &b.p)] {
            let gap = a.iter().zip(b).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs())) / largest(a);
            println!("{more:?} {field}: {gap:.1e}");
            assert!(gap < 1e-7, "{more:?} {field}: {gap:e}");
        }
    }
}

/// Where few iterations do not suffice for the condensed system, those of Newton's method do, and the
/// condensed one gets another try later.
#[test]
fn a_step_it_cannot_do_takes_the_whole_jacobian() {
    let common = ["mesh.refine=0", "time.end=0.6", "time.step=0.05", "newton.rate-max=0"];
    let reference = run(&[&common[..], &["newton.linearization=newton"]].concat());
    let case = builtin("fsi3", &[&common[..], &["newton.max-steps=3"]].concat());
    let mut simulation = Simulation::new(case, 1).unwrap();
    let mut detours = vec![];
    while !simulation.finished() {
        simulation.step().unwrap();
        detours.push(simulation.stepper.linear.detour);
    }
    println!("{detours:?}");
    assert!(detours.contains(&9) && detours.contains(&0), "{detours:?}");
    for (a, b) in reference.stepper.new.v.iter().zip(&simulation.stepper.new.v) {
        assert!((a - b).abs() < 1e-6 * largest(&reference.stepper.new.v), "{a} {b}");
    }
}

/// A run that is left in the middle of a detour goes on with the same bits.
#[test]
fn a_detour_outlives_a_restart() {
    let new = || {
        let settings =
            ["mesh.refine=0", "time.end=0.6", "time.step=0.05", "newton.rate-max=0", "newton.max-steps=3"];
        Simulation::new(builtin("fsi3", &settings), 1).unwrap()
    };
    let mut first = new();
    while first.stepper.linear.detour != 8 {
        assert!(!first.finished(), "no detour");
        first.step().unwrap();
    }
    let mut second = new();
    second.restore(first.save()).unwrap();
    for _ in 0..2 {
        first.step().unwrap();
        second.step().unwrap();
        assert_eq!(first.stepper.linear.detour, second.stepper.linear.detour);
        assert!(first.stepper.new == second.stepper.new, "other bits");
    }
}

#[test]
fn the_extension_follows_a_start_value_that_moves_by_more_than_a_cell() {
    let sets =
        ["mesh.refine=0", "mesh.grading=4", "time.step=0.02", "solid.body-force=[0,-20]", "newton.start=old"];

    let mut stepper = builtin("fsi3", &sets).build_stepper(1).unwrap();
    for step in 0..6 {
        let report = stepper.step(0.02).unwrap();
        assert_eq!(report.parts, 1, "step {step}");
    }
}
