//! The part of a space that one of several processes has, on threads in their place: its rows are those of the whole.

use crate::manufactured::*;
use std::sync::Arc;
use undula::algebra::Csr;
use undula::parallel::threads::together;
use undula::parallel::{Crew, Reduce};
use undula::physics::StepRule;
use undula::physics::rule::SECANT;
use undula::space::PressureKind::{Continuous, Pdc};
use undula::space::{Constraints, FsiSpace, Rim, State};
use undula::system::{Assembler, Dim, Kernels, Options, Physics, StepView};
use undula::tangent::Tangent;
use undula::verification::manufactured::{InTime, Manufactured};

const RULE: StepRule = StepRule { per_k: 20.0, theta: 0.6, inertia: SECANT, quadrature: &[] };

/// Numbers for each place \[v, u, p\] that look random.
fn state<const D: usize>(space: &FsiSpace<D>, seed: f64, sizes: [f64; 3]) -> State {
    let list = |n: usize, size: f64, from: f64| {
        (0..n).map(|i| size * (12.9898 * (i as f64 + from) + seed).sin()).collect()
    };
    let [v, u, p] = [space.n_v(), space.n_u(), space.n_p()];
    State { v: list(v, sizes[0], 0.0), u: list(u, sizes[1], 0.3), p: list(p, sizes[2], 0.7), s: vec![] }
}

/// What an assembler makes of the states `new` and `old`, and of a vector `x`: smallest J, residual, A x, and S x of the
/// condensed matrix at the places that it has.
fn made<const D: usize>(
    assembler: &mut Assembler<D>,
    (new, old, x): (&State, &State, &State),
) -> (f64, [Vec<f64>; 3]) {
    let step = StepView { rule: RULE, new, old };
    let n = assembler.n_unknowns();
    let (mut r, mut product, mut condensed) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let min_j = assembler.residual(&step, &mut r);
    let x = [&x.v[..], &x.u, &x.p].concat();
    let mut matrix = Csr::zeros(&assembler.pattern());
    assembler.jacobian(&step, Tangent::Automatic, &mut matrix);
    matrix.mul(&x, &mut product);
    let system = assembler.condensed();
    let mut matrix = Csr::zeros(&system.pattern);
    assembler.condensed_matrix(&step, Tangent::Automatic, &mut matrix);
    let outer: Vec<f64> = system.places.iter().map(|&place| x[place as usize]).collect();
    let mut of_system = vec![0.0; outer.len()];
    matrix.mul(&outer, &mut of_system);
    system.places.iter().zip(of_system).for_each(|(&place, y)| condensed[place as usize] = y);
    (min_j, [r, product, condensed])
}

/// A vector \[v, u, p\] as a state.
fn as_state<const D: usize>(space: &FsiSpace<D>, x: &[f64]) -> State {
    let (v, rest) = x.split_at(space.n_v());
    let (u, p) = rest.split_at(space.n_u());
    State { v: v.to_vec(), u: u.to_vec(), p: p.to_vec(), s: vec![] }
}

fn assembler<const D: usize>(problem: &Manufactured<D>, space: Arc<FsiSpace<D>>, n: usize) -> Assembler<D>
where
    Dim<D>: Kernels<D>,
{
    let options = Options::serial(n);
    Assembler::new(space, problem.physics, &problem.conditions, &|x| 1.0 + x[0], &options)
}

fn check<const D: usize>(problem: &Manufactured<D>, quadrature: usize)
where
    Dim<D>: Kernels<D>,
{
    let whole = &problem.space;
    let states = [(1.0, [2.0, 0.01, 4.0]), (2.0, [2.0, 0.01, 4.0]), (3.0, [1.0; 3])];
    let states = states.map(|(seed, sizes)| state(whole, seed, sizes));
    let [new, old, x] = &states;
    let (min_j, expected) = made(&mut assembler(problem, whole.clone(), quadrature), (new, old, x));
    let constraints = Constraints::new(whole, &problem.conditions);
    let sizes: Vec<f64> = expected.iter().map(|list| largest(list.iter().copied())).collect();
    for n in [2, 3, 4] {
        let found = together(n, |comm| {
            let crew = Crew::new(comm);
            let rim = Rim { layers: 1, families: false, memory_before: 0 };
            let part = Arc::new(whole.parted(&crew, &constraints, rim).unwrap());
            let of = |state: &State| part.part_of(state.clone());
            let (here, lists) =
                made(&mut assembler(problem, part.clone(), quadrature), (&of(new), &of(old), &of(x)));
            assert_eq!(crew.one(Reduce::Min, here), min_j);
            for ((list, expected), size) in lists.iter().zip(&expected).zip(&sizes) {
                let State { v, u, p, .. } = part.part_of(as_state(whole, expected));
                let expected = part.own_rows(&[v, u, p].concat());
                let own = part.own_rows(list);
                let gap = own.iter().zip(&expected).map(|(a, b)| (a - b).abs());
                assert!(gap.fold(0.0, f64::max) < 1e-13 * size, "process {} of {n}", crew.rank());
            }
            // Every cell, node and pressure is counted once.
            let own = [
                (0..part.mesh.n_cells()).filter(|&cell| part.owns_cell(cell)).count(),
                (0..part.nodes.len()).filter(|&node| part.owns_node(node)).count(),
                (0..part.n_p()).filter(|&dof| part.owns_pressure(dof)).count(),
            ];
            let halo = part.halo(0..part.n_field_unknowns() as u32).unwrap().unwrap();
            // What neighbours have copies of is what they say it is.
            let State { v, u, p, .. } = of(x);
            let right = [v, u, p].concat();
            let mut copies = part.own_rows(&right);
            halo.update(&mut copies);
            assert_eq!(copies, right);
            (own, halo.total())
        });
        let all = found.iter().fold([0; 3], |sum, (own, _)| std::array::from_fn(|i| sum[i] + own[i]));
        assert_eq!(all, [whole.mesh.n_cells(), whole.nodes.len(), whole.n_p()]);
        assert!(found.iter().all(|(_, total)| *total == whole.n_field_unknowns()));
    }
}

fn problem<const D: usize>(space: Arc<FsiSpace<D>>, pair: Pair) -> Manufactured<D> {
    problem_in(space, FSI, nothing(), InTime::Difference, pair.quadrature())
}

#[test]
fn rows_of_a_part_are_those_of_the_whole() {
    for pair in [quadrilaterals(2, Pdc(1)), quadrilaterals(2, Continuous(1)), quadrilaterals(3, Pdc(2))] {
        let space = pair.space(&square(8, Cells::Curved, Body::Block), &FSI);
        check(&problem(space, pair), pair.quadrature());
    }
    let pair = quadrilaterals(2, Pdc(1));
    check(&problem(pair.in_space(&cube(4, Cells::Curved, Body::Block), &FSI), pair), pair.quadrature());
}

#[test]
fn a_process_may_have_no_solid() {
    let pair = quadrilaterals(2, Pdc(1));
    let physics = Physics { ..FSI };
    let space = pair.space(&square(8, Cells::Curved, Body::Half), &physics);
    check(&problem(space, pair), pair.quadrature());
}
