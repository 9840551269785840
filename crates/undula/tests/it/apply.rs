//! The product of the Jacobian with a vector without a matrix, against the matrices.

use crate::manufactured::*;
use std::sync::Arc;
use undula::algebra::Csr;
use undula::math::Vector;
use undula::mesh::Side;
use undula::operators::backflow::backflow;
use undula::operators::outflow::correction;
use undula::operators::pressure::{PressureData, pressure as pressure_on};
use undula::operators::{DataTime, End, Operator};
use undula::physics::rule::SECANT;
use undula::physics::{Extension, Fluid, PressureTerm, Stabilization, StepRule, TransportTerm};
use undula::space::PressureKind::{Continuous, Pdc};
use undula::space::{Against, BoundaryCondition, FsiSpace, Region, State};
use undula::system::{Assembler, CurrentForce, Options, Physics, StepView};
use undula::tangent::Tangent;
use undula::verification::manufactured::{InTime, Manufactured};

const RULES: [StepRule; 2] =
    [StepRule { per_k: 20.0, theta: 0.6, inertia: SECANT, quadrature: &[] }, StepRule::STATIONARY];

/// Bent cells, an outflow with both of its terms.
fn coupled(pair: Pair, fluid: Fluid) -> Manufactured {
    let physics = Physics { fluid: Some(fluid), ..FSI };
    let space = pair.space(&square(4, Cells::Curved, Body::Block), &physics);
    coupled_in(space, pair, physics)
}

fn coupled_in<const D: usize>(space: Arc<FsiSpace<D>>, pair: Pair, physics: Physics) -> Manufactured<D> {
    let mut problem = problem_in(space, physics, nothing(), InTime::Difference, pair.quadrature());
    for condition in &mut problem.conditions {
        if let BoundaryCondition::Outflow { backflow, .. } = condition {
            *backflow = Against::Directional;
        }
    }
    problem
}

fn random<const D: usize>(problem: &Manufactured<D>, seed: u64, sizes: [f64; 3]) -> State {
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

fn gap(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest(b.iter().copied())
}

/// A x by the whole matrix and without one; S x of the condensed matrix by elimination and without one.
fn check<const D: usize>(problem: &Manufactured<D>, assembler: &mut Assembler<D>, rule: StepRule) {
    let (new, old) = (random(problem, 77, [2.0, 0.02, 4.0]), random(problem, 78, [2.0, 0.02, 4.0]));
    let step = StepView { rule, new: &new, old: &old };
    let State { v, u, p, .. } = random(problem, 5, [1.0; 3]);
    let (x, mut work) = ([v, u, p].concat(), vec![]);
    let n = x.len();
    let (mut by_matrix, mut product) = (vec![0.0; n], vec![0.0; n]);
    let mut matrix = Csr::zeros(&assembler.pattern());
    assembler.jacobian(&step, Tangent::Automatic, &mut matrix);
    matrix.mul(&x, &mut by_matrix);
    assembler.apply(&step, &x, &mut product, &mut work);
    let whole = gap(&product, &by_matrix);
    assert!(whole < 1e-13, "whole matrix: {whole:e}, {rule:?}");

    if rule == StepRule::STATIONARY {
        // In the condensed matrix u moves by kθ v.
        return;
    }
    let system = assembler.condensed();
    let mut condensed = Csr::zeros(&system.pattern);
    assembler.condensed_matrix(&step, Tangent::Automatic, &mut condensed);
    let outer: Vec<f64> = system.places.iter().map(|&place| x[place as usize]).collect();
    let mut expected = vec![0.0; outer.len()];
    condensed.mul(&outer, &mut expected);
    let mut single = Csr::<f32>::blank(&system.pattern);
    assembler.condensed_matrix(&step, Tangent::Automatic, &mut single);
    let mut rounded = vec![0.0; outer.len()];
    single.mul(&outer, &mut rounded);
    let rounding = gap(&rounded, &expected);
    assert!(0.0 < rounding && rounding < 1e-5, "in single precision: {rounding:e}");
    // With x_i = −A_ii⁻¹ A_io x_o inside, the inner rows vanish and the outer ones are S x_o.
    let (mut inner, mut filled) = (vec![0.0; n], vec![0.0; n]);
    assembler.eliminate_inner(&mut inner);
    system.places.iter().zip(&outer).for_each(|(&place, x)| filled[place as usize] = *x);
    assembler.recover_inner(&mut filled);
    assembler.apply_condensed(&step, &filled, &mut product, &mut work);
    let found: Vec<f64> = system.places.iter().map(|&place| product[place as usize]).collect();
    let outside = gap(&found, &expected);
    assert!(outside < 1e-12, "condensed matrix: {outside:e}");
    system.places.iter().for_each(|&place| product[place as usize] = 0.0);
    let inside = largest(product) / largest(expected);
    assert!(inside < 1e-12, "inner rows: {inside:e}");
}

#[test]
fn products_are_those_of_the_matrices() {
    let quick = Options { lanes: 1, ..options() };
    for (degree, pressure) in [(2, Pdc(1)), (2, Continuous(1)), (3, Pdc(2)), (4, Pdc(3))] {
        let pair = quadrilaterals(degree, pressure);
        let problem = coupled(pair, AUXETIC);
        for rule in RULES {
            for lanes in [1, 8] {
                let options = Options { lanes, quadrature: pair.quadrature(), ..quick };
                check(&problem, &mut problem.assembler(&options), rule);
            }
        }
    }
    for extension in EXTENSIONS {
        let problem = coupled(quadrilaterals(2, Pdc(1)), Fluid { extension, ..FLUID });
        check(&problem, &mut problem.assembler(&options()), RULES[0]);
    }
}

/// The same in space, with a pressure that follows the boundary and a force at the current position.
#[test]
fn products_in_space_are_those_of_the_matrices() {
    for (degree, pressure, n) in
        [(2, Pdc(1), 4), (2, Continuous(1), 4), (3, Pdc(2), 2), (1, Continuous(1), 4)]
    {
        let pair = quadrilaterals(degree, pressure);
        let body = if n == 4 { Body::Block } else { Body::Half };
        let space = pair.in_space(&cube(n, Cells::Curved, body), &FSI);
        let problem = coupled_in(space, pair, FSI);
        let options = Options::serial(pair.quadrature());
        let mut assembler = problem.assembler(&options);
        if degree == 1 {
            assembler.stabilize(&STABILIZED, &options).unwrap();
        }
        let force = |x: &[f64; 3], _: f64| {
            let slope = [[x[1], x[0], 0.0], [0.0, x[1].cos(), 0.0], [0.0, 0.0, x[2].cos()]];
            ([x[0] * x[1], x[1].sin(), x[2].sin()], slope)
        };
        assembler.follow(0, CurrentForce::new(Box::new(force)));
        let boundary = problem.space.mesh.boundary("top").unwrap();
        let load: PressureData<3> = Box::new(|x, t| 1.0 + x[0] - t * x[2]);
        let (space, n) = (&problem.space, pair.quadrature());
        let term = pressure_on(space, Region::Fluid, boundary, (load, true), n);
        assembler.add(Box::new(term));
        for (end, time) in [(End::Old, 0.1), (End::New, 0.3)] {
            assembler.set_data(&DataTime { end, time, load: 1.0 }).unwrap();
        }
        for rule in RULES {
            check(&problem, &mut assembler, rule);
        }
    }
}

const STABILIZED: Stabilization =
    Stabilization { transport: TransportTerm::Supg, pressure: PressureTerm::Pspg, ..Stabilization::NONE };

/// Terms that few problems have: stabilisation, and a force at the current position.
#[test]
fn products_have_all_terms() {
    let pair = quadrilaterals(1, Continuous(1));
    let problem = coupled(pair, Fluid { extension: Extension::Harmonic, ..FLUID });
    let options = Options { quadrature: pair.quadrature(), ..options() };
    let mut assembler = problem.assembler(&options);
    assembler.stabilize(&STABILIZED, &options).unwrap();
    assembler.follow(
        0,
        CurrentForce::new(Box::new(|x, _| ([x[0] * x[1], x[1].sin()], [[x[1], x[0]], [0.0, x[1].cos()]]))),
    );
    for rule in RULES {
        check(&problem, &mut assembler, rule);
    }
}

/// A pressure that follows the boundary, of the fluid and of a solid whose surface is free.
#[test]
fn products_have_the_stiffness_of_a_pressure() {
    let pair = quadrilaterals(2, Pdc(1));
    let problem = coupled(pair, FLUID);
    for rule in RULES {
        let options = Options { quadrature: pair.quadrature(), ..options() };
        let mut assembler = problem.assembler(&options);
        for boundary in 0..problem.space.mesh.boundaries.len() as u16 {
            for body in [Region::Fluid, Region::Solid] {
                let load: PressureData<2> = Box::new(|x, t| 1.0 + x[0] - t * x[1]);
                let term = pressure_on(&problem.space, body, boundary, (load, true), pair.quadrature());
                assembler.add(Box::new(term));
            }
        }
        for (end, time) in [(End::Old, 0.1), (End::New, 0.3)] {
            assembler.set_data(&DataTime { end, time, load: 1.0 }).unwrap();
        }
        check(&problem, &mut assembler, rule);
    }
}

/// What an outlet adds to all test functions is what its facets add: φ sum up to 1. With both terms, in motion.
#[test]
fn the_force_through_an_outlet_is_the_sum_of_its_rows() {
    let problem = coupled(quadrilaterals(2, Pdc(1)), AUXETIC);
    let (space, conditions, n) = (&problem.space, &problem.conditions, problem.quadrature);
    let outflow = correction(space, (0, AUXETIC), conditions, n);
    let backflow = backflow(space, (0, AUXETIC), conditions, Against::Directional, n);
    assert!(!outflow.is_empty() && !backflow.is_empty());
    let mut terms: [Box<dyn Operator<2>>; 2] = [Box::new(outflow), Box::new(backflow)];
    let (new, old) = (random(&problem, 77, [2.0, 0.02, 4.0]), random(&problem, 78, [2.0, 0.02, 4.0]));
    let sides: Vec<Side> = problem.space.mesh.facets.iter().map(|facet| facet.side()).collect();
    for rule in [RULES[0], StepRule::galerkin(0.05), StepRule::theta(0.05, 1.0)] {
        let step = StepView { rule, new: &new, old: &old };
        let mut rows = vec![0.0; problem.space.n_field_unknowns()];
        let mut sum = Vector::zero();
        for term in &mut terms {
            term.residual(&step, &mut rows);
            if rule.has_explicit() {
                term.explicit(&step, &mut rows);
            }
            sum += term.force_through(&step, &sides);
        }
        for i in 0..2 {
            let expected: f64 = rows[..problem.space.n_v()].iter().skip(i).step_by(2).sum();
            assert!(
                (sum.0[i] - expected).abs() < 1e-12 * largest(rows.iter().copied()),
                "{}, {expected}: {rule:?}",
                sum.0[i]
            );
        }
    }
}
