//! Residual and Jacobian of the whole problem.

use crate::manufactured::*;
use std::sync::Arc;
use undula::algebra::Csr;
use undula::physics::{Extension, Fluid, Material, Solid, StepRule};
use undula::space::PressureKind::{self, Continuous, Pdc};
use undula::space::{PsiOwner, Region, State, Walls};
use undula::system::{Assembler, Options, Physics, StepView};
use undula::tangent::Stencil::{Central, Nodal, OneSided};
use undula::tangent::{Difference, Linearization, Tangent};
use undula::verification::manufactured::{Exact, InTime, Manufactured, Values, number};

const RULES: [StepRule; 2] = [
    StepRule { per_k: 20.0, theta: 0.51, inertia: undula::physics::rule::SECANT, quadrature: &[] },
    StepRule::STATIONARY,
];

fn nothing() -> Exact {
    let zero = number(0.0);
    Arc::new(move |_, _| Values { v: [zero; 2], u: [zero; 2], p: zero })
}

/// A solid body in the flow, bent cells, do-nothing outflow.
fn coupled(physics: Physics, pressure: PressureKind) -> Manufactured {
    coupled_in(quadrilaterals(2, pressure), physics)
}

fn coupled_in(pair: Pair, physics: Physics) -> Manufactured {
    let space = pair.space(&square(4, Cells::Curved, Body::Block), &physics);
    problem_in(space, physics, nothing(), InTime::Difference, pair.quadrature())
}

/// A random state; J stays positive.
fn random(problem: &Manufactured, seed: u64) -> State {
    let (space, mut random) = (&problem.space, Random(seed));
    let mut list = |n: usize, size: f64| (0..n).map(|_| size * random.next()).collect();
    // Gradients grow with the square of the degree.
    let small = 0.02f64.min(0.06 / (space.nodes.degree as f64).powi(2));
    State { v: list(space.n_v(), 2.0), u: list(space.n_u(), small), p: list(space.n_p(), 4.0), s: vec![] }
}

fn assembled(
    problem: &Manufactured,
    options: &Options,
    rule: StepRule,
    tangent: Tangent,
) -> (Vec<f64>, Csr, Assembler<2>) {
    let mut assembler = problem.assembler(options);
    let (new, old) = (random(problem, 77), random(problem, 78));
    let view = StepView { rule, new: &new, old: &old };
    let mut residual = vec![0.0; problem.space.n_field_unknowns()];
    assembler.explicit(&view, &mut residual);
    let min_j = assembler.residual(&view, &mut residual);
    assert!(min_j > 0.1, "not admissible: J = {min_j}");
    let mut matrix = Csr::zeros(&assembler.pattern());
    assembler.jacobian(&view, tangent, &mut matrix);
    (residual, matrix, assembler)
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Each column of the Jacobian is the central difference of the residual, entries that the pattern does
/// not have included; given unknowns have unit rows and no column.
fn check_jacobian(problem: &Manufactured, rule: StepRule, tangent: Tangent) {
    let pressure = problem.space.pressure.kind;
    let (_, matrix, mut assembler) = assembled(problem, &Options::serial(problem.quadrature), rule, tangent);
    let (mut new, old) = (random(problem, 77), random(problem, 78));
    let n = problem.space.n_field_unknowns();
    let given = given(&assembler);
    let row_size: Vec<f64> = (0..n).map(|i| largest(&matrix.values[matrix.pattern.row(i)])).collect();
    let entry = |i, j| matrix.pattern.find(i, j).map_or(0.0, |at| matrix.values[at]);
    let (mut unit, mut worst) = (vec![0.0; n], 0.0f64);
    for j in 0..n {
        let h = if j < problem.space.n_v() { 1e-4 } else { 1e-6 };
        let mut moved = |by: f64| {
            unit[j] = by;
            new.add_scaled(1.0, &unit);
            let mut r = vec![0.0; n];
            assembler.residual(&StepView { rule, new: &new, old: &old }, &mut r);
            new.add_scaled(-1.0, &unit);
            unit[j] = 0.0;
            r
        };
        let (plus, minus) = (moved(h), moved(-h));
        for i in 0..n {
            if given[i] || given[j] {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert_eq!(entry(i, j), expected, "given row {i}, column {j}");
                assert_eq!(matrix.pattern.find(i, j).is_some(), i == j);
            } else {
                let gap = (entry(i, j) - (plus[i] - minus[i]) / (2.0 * h)).abs() / row_size[i];
                assert!(gap < 2e-8, "({i}, {j}) of {n}: {gap:e} with {pressure:?}, {rule:?}, {tangent:?}");
                worst = worst.max(gap);
            }
        }
    }
    println!("{pressure:?} {tangent:?} theta = {}: {worst:.1e}", rule.theta);
}

fn given(assembler: &Assembler<2>) -> Vec<bool> {
    let n = assembler.space.n_field_unknowns();
    let mut marks = vec![1.0; n];
    assembler.zero_given(&mut marks);
    marks.iter().map(|&m| m == 0.0).collect()
}

#[test]
fn jacobian_is_the_derivative_of_the_residual() {
    for pressure in [Pdc(1), Continuous(1)] {
        for rule in RULES {
            for tangent in [Tangent::Automatic, Tangent::Analytic] {
                check_jacobian(&coupled(FSI, pressure), rule, tangent);
            }
        }
    }
    for (degree, pressure) in [(3, Pdc(2)), (4, Pdc(3))] {
        check_jacobian(&coupled_in(quadrilaterals(degree, pressure), FSI), RULES[0], Tangent::Automatic);
    }
}

/// Largest difference of two matrices of one pattern, relative to the largest entry of the row.
fn gap(a: &Csr, b: &Csr) -> f64 {
    (0..a.pattern.n).fold(0.0, |gap: f64, i| {
        let row = a.pattern.row(i);
        let size = largest(&a.values[row.clone()]);
        row.fold(gap, |gap, at| gap.max((a.values[at] - b.values[at]).abs() / size))
    })
}

fn matrix(assembler: &mut Assembler<2>, view: &StepView<'_>, kind: Linearization, tangent: Tangent) -> Csr {
    let mut matrix = Csr::zeros(&assembler.pattern());
    assembler.matrix(view, kind, tangent, &mut matrix);
    matrix
}

/// One-sided differences are off by ε, central ones by its square or by rounding, for every matrix.
#[test]
fn differences_give_the_same_matrices() {
    let problem = coupled(FSI, Pdc(1));
    let mut assembler = problem.assembler(&options());
    let (new, old) = (random(&problem, 77), random(&problem, 78));
    for rule in RULES {
        let view = StepView { rule, new: &new, old: &old };
        for kind in [Linearization::Newton, Linearization::Reduced, Linearization::FixedPoint] {
            let exact = matrix(&mut assembler, &view, kind, Tangent::Automatic);
            let mut with = |stencil, epsilon| {
                let by = Tangent::Difference(Difference::new(stencil, epsilon));
                gap(&exact, &matrix(&mut assembler, &view, kind, by))
            };
            let gaps = [with(OneSided, 1e-6), with(OneSided, 1e-9), with(Central, 1e-4), with(Central, 1e-6)];
            println!("{kind:?}, theta = {}: {gaps:?}", rule.theta);
            assert!(
                gaps[0] < 1e-5 && gaps[1] < 1e-5 && gaps[2] < 1e-6 && gaps[3] < 1e-8,
                "{kind:?} {gaps:?}"
            );
        }
        let mut condensed = |tangent| {
            let mut matrix = Csr::zeros(&assembler.condensed().pattern);
            assembler.condensed_matrix(&view, tangent, &mut matrix);
            matrix
        };
        if rule.per_k > 0.0 {
            let exact = condensed(Tangent::Automatic);
            let found = gap(&exact, &condensed(Tangent::Difference(Difference::new(Central, 1e-5))));
            assert!(found < 1e-7, "condensed: {found:e}");
        }
    }
}

/// Differences of the residuals of cells are of first order, until rounding is left of them; for every matrix, on all
/// cells and with every extension.
#[test]
fn nodal_differences_give_the_same_matrices() {
    let nodal = |epsilon| Tangent::Difference(Difference::new(Nodal, epsilon));
    let extended = |extension| Physics { fluid: Some(Fluid { extension, ..FLUID }), ..FSI };
    let pairs = [
        quadrilaterals(2, Pdc(1)),
        quadrilaterals(2, Continuous(2)),
        quadrilaterals(3, Pdc(2)),
        triangles(2, Continuous(1)),
        BUBBLE,
    ];
    let of_pairs = pairs.into_iter().map(|pair| (pair, FSI));
    let of_extensions = EXTENSIONS.into_iter().map(|extension| (pairs[0], extended(extension)));
    for (pair, physics) in of_pairs.chain(of_extensions) {
        let problem = coupled_in(pair, physics);
        let mut assembler = problem.assembler(&options());
        let (new, old) = (random(&problem, 77), random(&problem, 78));
        for rule in RULES {
            let view = StepView { rule, new: &new, old: &old };
            for kind in [Linearization::Newton, Linearization::Reduced, Linearization::FixedPoint] {
                let exact = matrix(&mut assembler, &view, kind, Tangent::Automatic);
                let gaps = [1e-4, 1e-5, 1e-6, 1e-9, 1e-12]
                    .map(|epsilon| gap(&exact, &matrix(&mut assembler, &view, kind, nodal(epsilon))));
                println!("{pair:?} {physics:?} {kind:?}, theta = {}: {gaps:?}", rule.theta);
                let order = (gaps[0] / gaps[1]).log10();
                assert!(gaps[2] < 1e-4, "{kind:?} {gaps:?}");
                assert!(kind == Linearization::FixedPoint || (order - 1.0).abs() < 0.1, "{order} {gaps:?}");
                assert!(gaps[4] > 10.0 * gaps[3], "cancellation: {kind:?} {gaps:?}");
            }
            let mut condensed = |tangent| {
                let mut matrix = Csr::zeros(&assembler.condensed().pattern);
                assembler.condensed_matrix(&view, tangent, &mut matrix);
                matrix
            };
            if rule.per_k > 0.0 {
                let found = gap(&condensed(Tangent::Automatic), &condensed(nodal(1e-6)));
                println!("condensed: {found:e}");
                assert!(found < 1e-4, "condensed: {found:e}");
            }
        }
    }
}

/// The reduced matrix is the Jacobian, but against u momentum has the derivatives of the solid alone, and
/// divergence none.
#[test]
fn reduced_drops_the_flow_against_deformation() {
    let problem = coupled(FSI, Pdc(1));
    let (space, mut assembler) = (problem.space.clone(), problem.assembler(&options()));
    let (mut new, old) = (random(&problem, 77), random(&problem, 78));
    let rule = RULES[0];
    let view = StepView { rule, new: &new, old: &old };
    let full = matrix(&mut assembler, &view, Linearization::Newton, Tangent::Automatic);
    let reduced = matrix(&mut assembler, &view, Linearization::Reduced, Tangent::Automatic);
    let (n_v, n_u, n) = (space.n_v(), space.n_u(), space.n_field_unknowns());
    let flow = |i: usize| i < n_v || i >= n_v + n_u;
    for i in 0..n {
        for at in full.pattern.row(i) {
            let j = full.pattern.column(i, at) as usize;
            let same = full.values[at] == reduced.values[at];
            assert!(same || flow(i) && !flow(j), "({i}, {j})");
        }
    }
    let mut direction = [vec![0.0; n_v], random(&problem, 79).u, vec![0.0; space.n_p()]].concat();
    assembler.zero_given(&mut direction);
    let mut product = vec![0.0; n];
    reduced.mul(&direction, &mut product);
    let mut moved = |by: f64| {
        new.add_scaled(by, &direction);
        let mut r = vec![0.0; n];
        assembler.region_residual(&StepView { rule, new: &new, old: &old }, Region::Solid, &mut r);
        new.add_scaled(-by, &direction);
        assembler.zero_given(&mut r);
        r
    };
    let (plus, minus) = (moved(1e-4), moved(-1e-4));
    let size = largest(&product[..n_v]);
    for i in (0..n).filter(|&i| flow(i)) {
        let gap = (product[i] - (plus[i] - minus[i]) / 2e-4).abs() / size;
        assert!(gap < 1e-8, "row {i}: {gap:e}");
    }
}

/// Where nothing flows, is deformed or pressed, no term is nonlinear to first order.
#[test]
fn at_rest_all_linearizations_are_one() {
    let problem = coupled(FSI, Pdc(1));
    let mut assembler = problem.assembler(&options());
    let space = problem.space.clone();
    let rest = State::zero(space.n_v(), space.n_u(), space.n_p());
    for rule in RULES {
        let view = StepView { rule, new: &rest, old: &rest };
        let full = matrix(&mut assembler, &view, Linearization::Newton, Tangent::Analytic);
        for kind in [Linearization::Reduced, Linearization::FixedPoint] {
            let other = matrix(&mut assembler, &view, kind, Tangent::Automatic);
            assert!(gap(&full, &other) < 1e-14, "{kind:?} {:e}", gap(&full, &other));
        }
    }
}

/// The same with every extension, the mesh sliding along the outer boundary.
#[test]
fn jacobian_of_every_extension() {
    for extension in EXTENSIONS {
        jacobian_of(extension, quadrilaterals(2, Pdc(1)), &[Tangent::Automatic, Tangent::Analytic]);
    }
}

#[test]
fn jacobian_of_every_extension_on_triangles() {
    for extension in EXTENSIONS {
        for pair in [triangles(1, Continuous(1)), triangles(2, Continuous(1)), BUBBLE] {
            if !matches!(extension, Extension::Biharmonic { .. }) || pair.degree > 1 {
                jacobian_of(extension, pair, &[Tangent::Automatic]);
            }
        }
        jacobian_of(extension, triangles(3, Continuous(2)), &[Tangent::Analytic]);
    }
}

fn jacobian_of(extension: Extension, pair: Pair, tangents: &[Tangent]) {
    let mut problem = coupled_in(pair, Physics { fluid: Some(Fluid { extension, ..FLUID }), ..FSI });
    Arc::make_mut(&mut problem.space).walls = Walls::Sliding;
    tangents.iter().for_each(|&tangent| check_jacobian(&problem, RULES[0], tangent));
}

/// Whole tables, and sums over one coordinate after the other.
const BOTH_WAYS: [Pair; 2] = [quadrilaterals(2, Pdc(1)), quadrilaterals(3, Pdc(2))];

#[test]
fn lanes_agree_to_rounding() {
    let tangents = [Tangent::Automatic, Tangent::Analytic];
    for (pair, tangent) in BOTH_WAYS.into_iter().flat_map(|pair| tangents.map(|tangent| (pair, tangent))) {
        let problem = coupled_in(pair, FSI);
        let with = |lanes| {
            let options = Options { lanes, threads: 1, quadrature: pair.quadrature() };
            let (residual, matrix, _) = assembled(&problem, &options, RULES[0], tangent);
            (residual, matrix)
        };
        let (residual, matrix) = with(1);
        for lanes in [2, 4, 8] {
            let (r, m) = with(lanes);
            assert_eq!(m.pattern, matrix.pattern);
            for (one, many) in [(&residual, &r), (&matrix.values, &m.values)] {
                let gap = one.iter().zip(many).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs()));
                assert!(gap < 1e-13 * largest(one), "{lanes} lanes: {:e}", gap / largest(one));
            }
        }
    }
}

#[test]
fn threads_agree_bit_for_bit() {
    for pair in BOTH_WAYS.into_iter().chain([quadrilaterals(2, Continuous(1))]) {
        let problem = coupled_in(pair, FSI);
        let with = |threads, lanes| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let options = Options { lanes, threads, quadrature: pair.quadrature() };
                let (residual, matrix, _) = assembled(&problem, &options, RULES[0], Tangent::Automatic);
                (residual, matrix.values)
            })
        };
        for lanes in [1, 4] {
            assert!(with(1, lanes) == with(2, lanes), "{lanes} lanes differ");
        }
    }
}

/// Which unknowns a row depends on, as (v, u, p) of fluid alone and of the closure of the solid.
#[derive(Default, Debug, PartialEq)]
struct Reach {
    v: [bool; 2],
    u: [bool; 2],
    p: bool,
}

/// Every row belongs to one equation: relation in the closure of the solid, extension elsewhere, with no
/// share of the fluid's cells in the rows of the interface.
#[test]
fn every_row_has_one_owner() {
    let problem = coupled(FSI, Pdc(1));
    let space = &problem.space;
    let (_, matrix, assembler) = assembled(&problem, &options(), RULES[0], Tangent::Automatic);
    let (n, n_v, n_u) = (space.n_field_unknowns(), space.n_v(), space.n_u());
    assert_eq!((matrix.pattern.n, assembler.unknowns().len()), (n, n));
    let given = given(&assembler);
    let solid = |node: usize| space.owner[node] == PsiOwner::Relation;
    let interface = space.boundary_nodes("interface");
    let mut owned = [0; 2];
    for i in (0..n).filter(|&i| !given[i]) {
        let mut reach = Reach::default();
        for at in matrix.pattern.row(i).filter(|&at| matrix.values[at] != 0.0) {
            match matrix.pattern.column(i, at) as usize {
                j if j < n_v => reach.v[usize::from(solid(j / 2))] = true,
                j if j < n_v + n_u => reach.u[usize::from(solid((j - n_v) / 2))] = true,
                _ => reach.p = true,
            }
        }
        if i >= n_v + n_u {
            assert!(reach.v[0] && reach.u[0] && !reach.p, "divergence row {i}: {reach:?}");
        } else if i >= n_v {
            let node = (i - n_v) / 2;
            owned[usize::from(solid(node))] += 1;
            match space.owner[node] {
                PsiOwner::Relation => {
                    let relation = Reach { v: [false, true], u: [false, true], p: false };
                    assert_eq!(reach, relation, "relation at node {node}");
                }
                PsiOwner::Extension => {
                    assert!(
                        reach.v == [false; 2] && reach.u[0] && !reach.p,
                        "extension at {node}: {reach:?}"
                    );
                    assert!(!interface.contains(&(node as u32)));
                }
            }
        } else if interface.contains(&(i as u32 / 2)) {
            assert_eq!(reach, Reach { v: [true; 2], u: [true; 2], p: true }, "momentum at the interface");
        }
    }
    assert!(owned[0] > 0 && owned[1] > 0);
}

/// Parameters of one equation change its rows and no others.
#[test]
fn rows_change_with_their_own_parameters_only() {
    let softer = Solid::elastic(3.0, Material::StVenantKirchhoff { mu: 1.0, lambda: 9.0 });
    let thicker = Fluid { rho: 2.0, nu: 0.9, ..FLUID };
    let matrix = |physics| {
        let problem = coupled(physics, Pdc(1));
        assembled(&problem, &options(), RULES[0], Tangent::Automatic).1
    };
    let problem = coupled(FSI, Pdc(1));
    let (space, base) = (&problem.space, matrix(FSI));
    let (n_v, n_u) = (space.n_v(), space.n_u());
    let changed =
        |other: &Csr, i: usize| other.values[other.pattern.row(i)] != base.values[base.pattern.row(i)];
    let given = given(&problem.assembler(&options()));
    let solid = matrix(Physics { solid: Some(softer), ..FSI });
    let fluid = matrix(Physics { fluid: Some(thicker), ..FSI });
    let in_cells = |region| {
        let mut touched = vec![false; space.nodes.len()];
        for cell in (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == region) {
            space.nodes.cell(cell).iter().for_each(|&node| touched[node as usize] = true);
        }
        touched
    };
    let [of_fluid, of_solid] = [undula::space::Region::Fluid, undula::space::Region::Solid].map(in_cells);
    for i in (0..space.n_field_unknowns()).filter(|&i| !given[i]) {
        let momentum = i < n_v;
        assert_eq!(changed(&solid, i), momentum && of_solid[i / 2], "row {i} and the solid");
        let psi = (i >= n_v && i < n_v + n_u).then(|| space.owner[(i - n_v) / 2]);
        let extension = psi == Some(PsiOwner::Extension);
        assert_eq!(changed(&fluid, i), (momentum && of_fluid[i / 2]) || extension, "row {i} and the fluid");
    }
}
