//! Stabilisation of equal-order pairs and of transport, section 5.3.3: derivatives, the map, consistency.
#![allow(non_snake_case)]

use crate::manufactured::*;
use std::sync::Arc;
use undula::algebra::Csr;
use undula::element::Shape;
use undula::math::{Tensor, Vector};
use undula::mesh::Mesh;
use undula::mesh::generate::rectangle;
use undula::physics::stabilization::CellState;
use undula::physics::{Mapping, PressureTerm, Projection, Stabilization, StepRule, TransportTerm};
use undula::space::PressureKind::Continuous;
use undula::space::{Against, BoundaryCondition, FsiSpace, PsiOwner, Region, State};
use undula::system::{Assembler, End, Options, StepView};
use undula::tangent::{Difference, Linearization, Stencil, Tangent};

use PressureTerm::{BrezziPitkaranta, LocalProjection, Pspg};

/// All pressure terms with all transport terms that differ, on cells and patches, axes together and apart.
fn methods() -> Vec<Stabilization> {
    let mut list = vec![];
    for (pressure, transport) in [
        (BrezziPitkaranta, TransportTerm::None),
        (LocalProjection, TransportTerm::LocalProjection),
        (Pspg, TransportTerm::Supg),
        (LocalProjection, TransportTerm::Supg),
        (PressureTerm::None, TransportTerm::LocalProjection),
    ] {
        for projection in [Projection::Cell, Projection::Patch] {
            for directional in [false, true] {
                let how =
                    Stabilization { pressure, transport, projection, directional, ..Stabilization::NONE };
                if how.projects() || projection == Projection::Cell {
                    list.push(how);
                }
            }
        }
    }
    list
}

/// The same left out of the map, altogether or but for the sizes of the cells.
fn unmapped() -> Vec<Stabilization> {
    let with = |map| methods().into_iter().map(move |how| Stabilization { map, ..how });
    with(Mapping::None).chain(with(Mapping::Size)).collect()
}

/// Equal order on both kinds of cells, and a stable pair with bubbles.
const PAIRS: [Pair; 5] = [
    quadrilaterals(1, Continuous(1)),
    Q2,
    triangles(1, Continuous(1)),
    triangles(2, Continuous(2)),
    Pair { pressure: Continuous(1), ..BUBBLE },
];
const Q2: Pair = quadrilaterals(2, Continuous(2));

/// The unit square with a solid lower half, bent, refined so that there are patches.
fn halves(n: usize, pair: Pair) -> Arc<FsiSpace<2>> {
    pair.space(&in_cells(square(n, Cells::Trapezia, Body::Half), pair).refined(1, &[]), &FSI)
}

fn in_cells(mesh: Mesh<2>, pair: Pair) -> Mesh<2> {
    if pair.cells == Shape::Triangle { mesh.triangulated() } else { mesh }
}

/// `f` at the nodes; bubbles stand beside them.
fn nodal(space: &FsiSpace<2>, f: impl Fn(&[f64; 2]) -> [f64; 2]) -> Vec<f64> {
    let of = |(node, x): (usize, &[f64; 2])| if node < space.nodes.n_lagrange { f(x) } else { [0.0; 2] };
    space.nodes.points.iter().enumerate().flat_map(of).collect()
}

fn assembler(space: &Arc<FsiSpace<2>>, how: &Stabilization, lanes: usize, threads: usize) -> Assembler<2> {
    let coupled = space.regions.contains(&Region::Solid);
    let condition = |name: &String| match name.as_str() {
        "right" => BoundaryCondition::Outflow { do_nothing: true, backflow: Against::None },
        "interface" => BoundaryCondition::Free,
        _ => BoundaryCondition::Fixed,
    };
    let conditions: Vec<_> = space.mesh.boundaries.iter().map(condition).collect();
    let bubbles = space.nodes.n_lagrange < space.nodes.len();
    let options = Options { lanes, threads, quadrature: space.nodes.degree + 1 + usize::from(bubbles) };
    let physics = if coupled { FSI } else { FLOW };
    let mut assembler = Assembler::new(space.clone(), physics, &conditions, &|_| 1.0, &options);
    assembler.stabilize(how, &options).unwrap();
    assembler.set_force(Region::Fluid, End::New, Some(&|x| [x[0] - 0.3, 2.0 * x[1]]));
    assembler.set_force(Region::Fluid, End::Old, Some(&|x| [x[1], 0.7 - x[0]]));
    assembler
}

fn random_state(space: &FsiSpace<2>, random: &mut Random, u: f64) -> State {
    let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
    state.v.iter_mut().chain(&mut state.p).for_each(|x| *x = random.next());
    // The deformation has no bubbles.
    state.u.iter_mut().take(2 * space.nodes.n_lagrange).for_each(|x| *x = u * random.next());
    state
}

fn residual(assembler: &mut Assembler<2>, step: &StepView<'_>) -> Vec<f64> {
    let mut r = vec![0.0; assembler.space.n_field_unknowns()];
    assembler.residual(step, &mut r);
    r
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Rows that the stabilisation adds to the residual.
fn added(space: &Arc<FsiSpace<2>>, how: &Stabilization, step: &StepView<'_>, force: [f64; 2]) -> Vec<f64> {
    let rows = |how: &Stabilization| {
        let mut assembler = assembler(space, how, 1, 1);
        assembler.set_force(Region::Fluid, End::New, Some(&|_| force));
        assembler.set_force(Region::Fluid, End::Old, Some(&|_| force));
        let mut rows = vec![0.0; space.n_field_unknowns()];
        assembler.region_residual(step, Region::Fluid, &mut rows);
        rows
    };
    rows(how).iter().zip(rows(&Stabilization::NONE)).map(|(a, b)| a - b).collect()
}

/// The Jacobian is the limit of differences, for both degrees and all methods, and the condensed matrix of a flow
/// on its own is the Jacobian.
#[test]
#[ignore = "long"]
fn derivatives_are_limits_of_differences() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for pair in PAIRS {
        let space = halves(4, pair);
        let h = 1.0 / (8 * pair.degree) as f64;
        let others = if pair == Q2 { unmapped() } else { vec![] };
        for how in methods().into_iter().chain(others) {
            let mut assembler = assembler(&space, &how, 1, 1);
            let (new, old) =
                (random_state(&space, &mut random, 0.2 * h), random_state(&space, &mut random, 0.2 * h));
            let mut w = vec![0.0; space.n_field_unknowns()];
            w.iter_mut().for_each(|x| *x = random.next());
            w[space.n_v()..space.n_v() + space.n_u()].iter_mut().for_each(|x| *x *= h);
            assembler.zero_given(&mut w);
            for rule in [StepRule::theta(0.1, 0.6), StepRule::STATIONARY] {
                let mut at = |eps: f64| {
                    let mut moved = new.clone();
                    moved.add_scaled(eps, &w);
                    residual(&mut assembler, &StepView { rule, new: &moved, old: &old })
                };
                let (plus, minus) = (at(1e-5), at(-1e-5));
                let mut matrix = Csr::zeros(&assembler.pattern());
                let step = StepView { rule, new: &new, old: &old };
                assembler.jacobian(&step, Tangent::Automatic, &mut matrix);
                let mut product = vec![0.0; w.len()];
                matrix.mul(&w, &mut product);
                let mut other = Csr::zeros(&matrix.pattern);
                let nodal = Tangent::Difference(Difference::new(Stencil::Nodal, 1e-6));
                assembler.jacobian(&step, nodal, &mut other);
                for row in 0..w.len() {
                    let size = largest(&matrix.values[matrix.pattern.row(row)]);
                    for at in matrix.pattern.row(row) {
                        let gap = (matrix.values[at] - other.values[at]).abs();
                        assert!(gap < 1e-4 * size, "nodal: {how:?} {rule:?} row {row}: {gap:e} of {size:e}");
                    }
                }
                let n_v = space.n_v();
                for rows in [0..n_v, n_v + space.n_u()..w.len()] {
                    let size = largest(&product[rows.clone()]);
                    for i in rows {
                        let difference = (plus[i] - minus[i]) / 2e-5;
                        let gap = (product[i] - difference).abs();
                        assert!(gap < 1e-7 * size, "{how:?} {rule:?} row {i}: {gap:e} of {size:e}");
                    }
                }
            }
        }
    }
}

/// Momentum and divergence of the reduced matrix have nothing of u in the fluid, that of the stabilisation included; all
/// other entries are those of the Jacobian.
#[test]
fn the_reduced_matrix_leaves_out_u_in_the_fluid() {
    let mut random = Random(7);
    let space = halves(2, Q2);
    let (n_v, n_u) = (space.n_v(), space.n_u());
    let is_flow = |i: usize| i < n_v || i >= n_v + n_u;
    let in_fluid = |i: usize| !is_flow(i) && space.owner[(i - n_v) / 2] == PsiOwner::Extension;
    for how in methods() {
        let mut assembler = assembler(&space, &how, 1, 1);
        let (new, old) = (random_state(&space, &mut random, 0.01), random_state(&space, &mut random, 0.01));
        let step = StepView { rule: StepRule::theta(0.1, 0.6), new: &new, old: &old };
        let [full, reduced] = [Linearization::Newton, Linearization::Reduced].map(|kind| {
            let mut matrix = Csr::zeros(&assembler.pattern());
            assembler.matrix(&step, kind, Tangent::Analytic, &mut matrix);
            matrix
        });
        let mut left_out = 0.0f64;
        for i in 0..space.n_field_unknowns() {
            for at in full.pattern.row(i) {
                let j = full.pattern.column(i, at) as usize;
                if is_flow(i) && in_fluid(j) {
                    left_out = left_out.max(full.values[at].abs());
                    assert_eq!(reduced.values[at], 0.0, "{how:?} ({i}, {j})");
                } else if !is_flow(i) || is_flow(j) {
                    assert_eq!(reduced.values[at], full.values[at], "{how:?} ({i}, {j})");
                }
            }
        }
        assert!(left_out > 0.0, "{how:?}");
    }
}

#[test]
fn condensed_matrix_of_a_flow_is_its_jacobian() {
    let mut random = Random(3);
    for pair in PAIRS {
        let mesh = in_cells(rectangle([0.0; 2], [1.0; 2], [3, 2], 0).unwrap(), pair).refined(1, &[]);
        let space = pair.space(&mesh, &FLOW);
        for how in methods() {
            let mut assembler = assembler(&space, &how, 1, 1);
            let (new, old) = (random_state(&space, &mut random, 0.0), random_state(&space, &mut random, 0.0));
            let step = StepView { rule: StepRule::theta(0.1, 0.6), new: &new, old: &old };
            let mut full = Csr::zeros(&assembler.pattern());
            assembler.jacobian(&step, Tangent::Automatic, &mut full);
            let system = assembler.condensed();
            let mut flow = Csr::zeros(&system.pattern);
            assembler.condensed_matrix(&step, Tangent::Automatic, &mut flow);
            let mut other = Csr::zeros(&system.pattern);
            let nodal = Tangent::Difference(Difference::new(Stencil::Nodal, 1e-6));
            assembler.condensed_matrix(&step, nodal, &mut other);
            let size = largest(&flow.values);
            for (row, &place) in system.places.iter().enumerate() {
                for at in system.pattern.row(row) {
                    let column = system.places[system.pattern.column(row, at) as usize] as usize;
                    let same = full.pattern.find(place as usize, column).map_or(0.0, |at| full.values[at]);
                    assert!((flow.values[at] - same).abs() < 1e-13 * size, "{how:?} {row}");
                    assert!((other.values[at] - same).abs() < 1e-5 * size, "nodal: {how:?} {row}");
                }
            }
        }
    }
}

/// On a domain that has moved the terms are those of a mesh that is where the domain has moved to: the errata of
/// section 5.3.3 in J and F, the axes of Remark 5.13 included.
#[test]
fn terms_are_those_of_the_moved_mesh() {
    let A = Tensor([[0.5, 0.3], [-0.2, 0.1]]);
    let mut random = Random(17);
    for pair in PAIRS {
        let space = halves(4, pair);
        let mut moved_mesh = space.mesh.clone();
        for x in &mut moved_mesh.nodes {
            *x = (Vector(*x) + A * Vector(*x)).0;
        }
        let moved_space = pair.space(&moved_mesh, &FSI);
        let mut state = random_state(&space, &mut random, 0.0);
        state.u = nodal(&space, |x| (A * Vector(*x)).0);
        let mut there = state.clone();
        there.u.fill(0.0);
        for how in methods() {
            let rule = StepRule::theta(0.1, 0.6);
            let here = added(&space, &how, &StepView { rule, new: &state, old: &state }, [1.0, 2.0]);
            let moved = added(&moved_space, &how, &StepView { rule, new: &there, old: &there }, [1.0, 2.0]);
            let size = largest(&moved);
            assert!(size > 1e-6);
            for (a, b) in here.iter().zip(&moved) {
                assert!((a - b).abs() < 1e-11 * size, "{how:?}: {a} {b} of {size}");
            }
        }
    }
}

/// Remark 5.13: on a domain that has not moved all maps are one; where it has moved alike in all directions, F = s I,
/// the size of the cells is all that the pressure terms and the projections need, since J F⁻¹F⁻ᵀ = s^(D−2) I is I in
/// two dimensions. Residuals need the map, and so do other motions.
#[test]
fn sizes_are_enough_where_the_motion_is_isotropic() {
    let mut random = Random(29);
    for pair in PAIRS {
        let space = halves(4, pair);
        let mut state = random_state(&space, &mut random, 0.0);
        let mut rows = |A: Tensor<f64, 2>, how: Stabilization| {
            state.u = nodal(&space, |x| (A * Vector(*x)).0);
            let step = StepView { rule: StepRule::theta(0.1, 0.6), new: &state, old: &state };
            [Mapping::None, Mapping::Size, Mapping::Full]
                .map(|map| added(&space, &Stabilization { map, ..how }, &step, [1.0, 2.0]))
        };
        for how in methods() {
            let [off, size, full] = rows(Tensor::zero(), how);
            assert!(off == full && size == full, "{how:?} at rest");
            let [off, size, full] = rows(Tensor([[0.5, 0.0], [0.0, 0.5]]), how);
            let scale = largest(&full);
            let gap = |a: &[f64]| a.iter().zip(&full).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / scale;
            assert!(gap(&off) > 1e-4, "{how:?}: {:e}", gap(&off));
            assert!((gap(&size) < 1e-11) != how.has_residual(), "{how:?}: {:e}", gap(&size));
            // Stretched in one direction.
            let [_, size, full] = rows(Tensor([[0.5, 0.0], [0.0, 0.0]]), how);
            let gap = size.iter().zip(&full).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / largest(&full);
            assert!(gap > 1e-4, "{how:?}: {gap:e}");
        }
    }
}

/// α and δ against their formulas at given numbers.
#[test]
fn parameters_are_those_of_the_moved_cell() {
    let how = Stabilization { alpha: 0.2, delta: 0.3, ..Stabilization::NONE };
    let fluid = FLUID;
    let cell = CellState { size: 0.1, j: 4.0, speed: 3.0 };
    // h = 2 · 0.1, 6 ν = 2.4: 2.4/0.04 + 3/0.2 = 75.
    assert!((how.alpha::<2>(&fluid, &cell) - 0.2 / 1.3 / 75.0).abs() < 1e-15);
    assert!((how.delta::<2>(&fluid, 25.0, &cell) - 0.3 / 100.0).abs() < 1e-15);
    // An axis as long as the cell: α_i h² = α.
    assert!((how.axis_alpha(&fluid, 3.0, 0.2) * 0.04 - how.alpha::<2>(&fluid, &cell)).abs() < 1e-15);
    // A solid body of water at rest, h = 1 cm: α_0 h²/(6 ρ ν).
    let water = undula::physics::Fluid { rho: 1000.0, nu: 1e-6, ..fluid };
    let rest = CellState { size: 0.01, j: 1.0, speed: 0.0 };
    assert!((how.alpha::<2>(&water, &rest) - 0.2 * 1e-4 / 6e-3).abs() < 1e-15);
}

/// Weak consistency of local projections: nothing is added for fields of the smaller space. With the gradient
/// itself (5.28) something is.
#[test]
fn projections_leave_the_smaller_space_alone() {
    let mut random = Random(5);
    for (pair, projection) in
        PAIRS.into_iter().flat_map(|pair| [(pair, Projection::Cell), (pair, Projection::Patch)])
    {
        // Projected to constants degree 1 leaves linear fields.
        if pair.pressure == Continuous(1) && projection == Projection::Cell {
            continue;
        }
        let space = halves(4, pair);
        let mut state = random_state(&space, &mut random, 0.01);
        let linear = |x: &[f64; 2]| [1.0 + x[0] - 2.0 * x[1], 0.5 * x[0] + x[1]];
        state.v = nodal(&space, linear);
        for (p, x) in state.p.iter_mut().zip(&space.pressure.points) {
            *p = linear(x)[0];
        }
        let step = StepView { rule: StepRule::theta(0.1, 0.6), new: &state, old: &state };
        let how = Stabilization {
            pressure: LocalProjection,
            transport: TransportTerm::LocalProjection,
            projection,
            ..Stabilization::NONE
        };
        let size = largest(&added(
            &space,
            &how,
            &StepView { new: &random_state(&space, &mut random, 0.01), ..step },
            [0.0; 2],
        ));
        let left = largest(&added(&space, &how, &step, [0.0; 2]));
        let plain = Stabilization { pressure: BrezziPitkaranta, ..Stabilization::NONE };
        let plain = largest(&added(&space, &plain, &step, [0.0; 2]));
        println!(
            "{projection:?} {pair:?}: {left:e}, of a random state {size:e}; Brezzi-Pitkäranta {plain:e}"
        );
        assert!(left < 1e-12 * size && plain > 1e-3 * size);
    }
}

/// Residual methods add nothing for solutions in the space: a flow v = A x with A² = s I and p = −½ ρ s |x|² solves
/// the equations in the current domain, which moves with u; the force is that of an added linear pressure.
#[test]
fn residual_methods_vanish_for_exact_solutions() {
    let (a, b) = (0.7, -0.4);
    let A = Tensor([[a, b], [b, -a]]);
    let s = a * a + b * b;
    let force = [0.8, -1.1];
    for (bent, cells, pair) in [
        (false, Cells::Square, Q2),
        (true, Cells::Trapezia, Q2),
        (true, Cells::Trapezia, triangles(2, Continuous(2))),
    ] {
        let space = pair.space(&square(4, cells, Body::Half), &FSI);
        // On bent cells and triangles only an affine motion keeps p in the space.
        let u = |x: &[f64; 2], t: f64| {
            let c = if bent { 0.0 } else { 0.2 * t };
            Vector([
                0.1 * t * x[0] - 0.2 * t * x[1] + c * x[0] * x[1],
                0.15 * t * x[0] - 0.5 * c * x[0] * x[1] + 0.05 * t,
            ])
        };
        let theta = 0.6;
        let state = |t: f64, t_p: f64| {
            let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
            for (node, x) in space.nodes.points.iter().enumerate() {
                let u = u(x, t);
                state.u[2 * node..2 * node + 2].copy_from_slice(&u.0);
                state.v[2 * node..2 * node + 2].copy_from_slice(&(A * (Vector(*x) + u)).0);
            }
            for (p, x) in state.p.iter_mut().zip(&space.pressure.points) {
                let x = Vector(*x) + u(x, t_p);
                *p = FLUID.rho * (Vector(force).dot(x) - 0.5 * s * x.dot(x));
            }
            state
        };
        let (new, old) = (state(1.2, 1.0 + 0.2 * theta), state(1.0, 1.0));
        let step = StepView { rule: StepRule::theta(0.2, theta), new: &new, old: &old };
        let how = Stabilization { pressure: Pspg, transport: TransportTerm::Supg, ..Stabilization::NONE };
        for directional in [false, true] {
            let how = Stabilization { directional, ..how };
            let left = largest(&added(&space, &how, &step, force));
            let wrong = largest(&added(&space, &how, &step, [0.8, -1.0]));
            println!("bent {bent}: {left:e}, with another force {wrong:e}");
            assert!(left < 1e-12 * wrong.max(1e-3) / 1e-2 && wrong > 1e-5, "{left:e} {wrong:e}");
        }
    }
}

/// Wide lanes give the same to rounding, and threads the same bits.
#[test]
fn lanes_and_threads_change_nothing() {
    let mut random = Random(23);
    let space = halves(8, Q2);
    let (new, old) = (random_state(&space, &mut random, 0.005), random_state(&space, &mut random, 0.005));
    let step = StepView { rule: StepRule::theta(0.1, 0.6), new: &new, old: &old };
    for how in methods().into_iter().filter(|how| how.directional) {
        let all = |lanes: usize, threads: usize| {
            let mut assembler = assembler(&space, &how, lanes, threads);
            let mut matrix = Csr::zeros(&assembler.pattern());
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut r = residual(&mut assembler, &step);
                assembler.jacobian(&step, Tangent::Automatic, &mut matrix);
                r.extend(&matrix.values);
                r
            })
        };
        let (one, wide, three) = (all(1, 1), all(8, 1), all(8, 3));
        let size = largest(&one);
        assert!(wide == three, "threads change bits: {how:?}");
        assert!(one.iter().zip(&wide).all(|(a, b)| (a - b).abs() < 1e-12 * size), "{how:?}");
    }
}
