//! The ALE map of section 5.3.5: what each extension reproduces, and that all of them solve the same problem.

use crate::manufactured::*;
use std::sync::Arc;
use undula::algebra::{FaerLu, LinearSolver};
use undula::case::Case;
use undula::element::Shape;
use undula::physics::{Extension, Fluid, StepRule};
use undula::simulation::Simulation;
use undula::space::PressureKind::{Continuous, Pdc};
use undula::space::{PsiOwner, State, Walls};
use undula::system::{Assembler, Options, Physics, StepView};
use undula::verification::manufactured::{Exact, InTime, Manufactured, Values, number};

const Q2: Pair = quadrilaterals(2, Pdc(1));
const P2: Pair = triangles(2, Continuous(1));
const P3: Pair = triangles(3, Continuous(2));
const PAIRS: [Pair; 5] = [Q2, triangles(1, Continuous(1)), P2, P3, BUBBLE];

/// Every extension with every pair; the biharmonic one needs degree 2.
fn all() -> impl Iterator<Item = (Extension, Pair)> {
    let with = |extension| PAIRS.into_iter().map(move |pair| (extension, pair));
    EXTENSIONS.into_iter().flat_map(with).filter(|(e, pair)| !is_biharmonic(e) || pair.degree > 1)
}

/// Bent cells; straight ones for degree 1, in which affine functions of x are none of ξ otherwise.
fn cells(pair: Pair) -> Cells {
    if pair.degree == 1 { Cells::Trapezia } else { Cells::Curved }
}

fn is_biharmonic(extension: &Extension) -> bool {
    matches!(extension, Extension::Biharmonic { .. })
}

fn coupled(extension: Extension, pair: Pair, cells: Cells, body: Body, walls: Walls) -> Manufactured {
    on_square(8, extension, pair, cells, body, walls)
}

fn on_square(
    n: usize,
    extension: Extension,
    pair: Pair,
    cells: Cells,
    body: Body,
    walls: Walls,
) -> Manufactured {
    let zero = number(0.0);
    let nothing: Exact = Arc::new(move |_, _| Values { v: [zero; 2], u: [zero; 2], p: zero });
    let physics = Physics { fluid: Some(Fluid { extension, ..FLUID }), ..FSI };
    let space = pair.space(&square(n, cells, body), &physics);
    let mut problem = problem_in(space, physics, nothing, InTime::Difference, pair.quadrature());
    Arc::make_mut(&mut problem.space).walls = walls;
    problem
}

fn options_of(problem: &Manufactured) -> Options {
    Options::serial(problem.quadrature)
}

/// Largest entry of the ψ rows that the extension owns, off the outer boundary unless `boundary`, at u = `f`(x).
fn residual(
    problem: &Manufactured,
    stiffness: &dyn Fn(&[f64; 2]) -> f64,
    boundary: bool,
    f: impl Fn([f64; 2]) -> [f64; 2],
) -> f64 {
    let space = &problem.space;
    let mut at = State::zero(space.n_v(), space.n_u(), space.n_p());
    let nodes = space.nodes.n_lagrange;
    at.u.iter_mut().zip(space.nodes.points[..nodes].iter().flat_map(|x| f(*x))).for_each(|(u, f)| *u = f);
    let options = options_of(problem);
    let mut assembler =
        Assembler::new(space.clone(), problem.physics, &problem.conditions, stiffness, &options);
    let mut r = vec![0.0; space.n_field_unknowns()];
    assembler.residual(&StepView { rule: StepRule::STATIONARY, new: &at, old: &at }, &mut r);
    let mut outer = vec![false; space.nodes.len()];
    for facet in space.mesh.facets.iter().filter(|_| !boundary) {
        space.facet_nodes(facet).iter().for_each(|&n| outer[n as usize] = true);
    }
    let owned = |n: &usize| space.owner[n / 2] == PsiOwner::Extension && !outer[n / 2];
    (0..2 * nodes).filter(owned).map(|i| r[space.n_v() + i].abs()).fold(0.0, f64::max)
}

fn affine([x, y]: [f64; 2]) -> [f64; 2] {
    [0.1 + 0.2 * x - 0.1 * y, 0.15 * x + 0.05 * y - 0.3]
}

fn uneven(x: &[f64; 2]) -> f64 {
    1.0 / (0.1 + x[0] * x[0] + 0.3 * x[1])
}

/// With constant coefficients an affine motion of the boundary is extended by itself. A clamped outer boundary
/// allows none, so the fluid is enclosed in the solid there.
#[test]
fn affine_motions_are_reproduced() {
    for (extension, pair) in all() {
        let clamped = extension == Extension::Biharmonic { hinged: false };
        let body = if clamped { Body::Frame } else { Body::Inclusion };
        let problem = coupled(extension, pair, cells(pair), body, Walls::Fixed);
        let r = residual(&problem, &|_| 1.0, false, affine);
        // Of fourth order: each of two Laplacians is of the size of the inverse square of the distance of nodes.
        let rounding =
            if is_biharmonic(&extension) { 1e-11 * (pair.degree as f64 / 2.0).powi(4) } else { 1e-14 };
        assert!(r < rounding, "{extension:?} {pair:?}: {r:e}");
        let other = residual(&problem, &|_| 1.0, false, |[x, y]| [x * x * y, 0.0]);
        assert!(other > 1e-4, "{extension:?} {pair:?}: {other:e}");
    }
}

/// With variable coefficients translations are, and infinitesimal rotations where the stress is symmetric.
#[test]
fn translations_and_rotations_are_reproduced() {
    for (extension, pair) in all().filter(|(e, _)| !is_biharmonic(e)) {
        let problem = coupled(extension, pair, cells(pair), Body::Inclusion, Walls::Fixed);
        let shift = residual(&problem, &uneven, false, |_| [0.2, -0.1]);
        let turn = residual(&problem, &uneven, false, |[x, y]| [-0.2 * y, 0.2 * x]);
        assert!(shift < 1e-13, "{extension:?} {pair:?}: {shift:e}");
        match extension {
            Extension::Harmonic => assert!(turn > 1e-3, "{turn:e}"),
            _ => assert!(turn < 1e-13, "{extension:?} {pair:?}: {turn:e}"),
        }
        assert!(residual(&problem, &uneven, false, affine) > 1e-3, "{extension:?} {pair:?}");
    }
}

/// The biharmonic extension on squares and affine triangles reproduces all quadratic polynomials: −Δu is a constant that
/// the nodal rule integrates, and the slope at the interface is that of the solid. A harmonic one does not.
#[test]
fn biharmonic_extension_reproduces_quadratic_polynomials() {
    let quadratic = |[x, y]: [f64; 2]| [0.3 * x * x - 0.2 * x * y, 0.1 * y * y + 0.4 * x * y - x];
    for (extension, pair) in all().filter(|(e, _)| is_biharmonic(e)) {
        let cells = if pair.cells == Shape::Triangle { Cells::Trapezia } else { Cells::Square };
        let problem = coupled(extension, pair, cells, Body::Frame, Walls::Fixed);
        let r = residual(&problem, &|_| 1.0, false, quadratic);
        assert!(r < 1e-10, "{extension:?} {pair:?}: {r:e}");
        let problem = coupled(Extension::Harmonic, pair, cells, Body::Frame, Walls::Fixed);
        assert!(residual(&problem, &|_| 1.0, false, quadratic) > 1e-3, "{pair:?}");
    }
}

/// The deformation in a hole full of fluid of a frame that is bent like `exact`: largest error at the nodes.
fn extension_error(extension: Extension, pair: Pair, n: usize, exact: impl Fn([f64; 2]) -> [f64; 2]) -> f64 {
    let problem = on_square(n, extension, pair, Cells::Square, Body::Frame, Walls::Fixed);
    let space = &problem.space;
    let mut at = State::zero(space.n_v(), space.n_u(), space.n_p());
    for (node, x) in space.nodes.points[..space.nodes.n_lagrange].iter().enumerate() {
        if space.owner[node] == PsiOwner::Relation {
            at.u[2 * node..2 * node + 2].copy_from_slice(&exact(*x));
        }
    }
    let mut assembler = problem.assembler(&options_of(&problem));
    let view = StepView { rule: StepRule::STATIONARY, new: &at, old: &at };
    let mut r = vec![0.0; space.n_field_unknowns()];
    assembler.residual(&view, &mut r);
    let system = assembler.extension(&view).unwrap();
    let mut solver = FaerLu::faer(undula::algebra::Options::default());
    let all = assembler.unknowns();
    let unknowns: Vec<_> = system.places.iter().map(|&place| all[place as usize]).collect();
    solver.analyse(&system.matrix.pattern, &unknowns).unwrap();
    solver.factor(&system.matrix).unwrap();
    let (mut b, mut x) = (vec![0.0; unknowns.len()], vec![0.0; unknowns.len()]);
    system.right_hand_side(Some(&r), &vec![0.0; space.n_field_unknowns()], &mut b);
    solver.solve(&system.matrix, &b, &mut x).unwrap();
    let error = |(&place, x): (&u32, &f64)| {
        let at = place as usize - space.n_v();
        (-x - exact(space.nodes.points[at / 2])[at % 2]).abs()
    };
    system.places.iter().zip(&x).map(error).fold(0.0, f64::max)
}

/// Of a biharmonic polynomial that is not harmonic.
#[test]
fn biharmonic_extension_converges() {
    let exact = |[x, y]: [f64; 2]| [x * x * x - 0.5 * x * y * y, y * y * (x - 0.3 * y)];
    for pair in [Q2, P2, P3, BUBBLE] {
        let error = |n| extension_error(Extension::Biharmonic { hinged: false }, pair, n, exact);
        let e: Vec<f64> = [8, 16, 32].map(error).to_vec();
        println!("biharmonic {pair:?}: {e:?}");
        assert!(e.windows(2).all(|e| e[1] < e[0] / 3.5), "second order: {pair:?} {e:?}");
        assert!(extension_error(Extension::Harmonic, pair, 16, exact) > 20.0 * e[1]);
    }
}

/// Above a body that is lifted by s a mesh that slides along the side walls is compressed evenly,
/// u = (0, 2 s (1 − y)): tangential unknowns of the walls are free, normal ones and corners are 0.
#[test]
fn sliding_mesh_is_compressed_evenly() {
    let lifted = |[_, y]: [f64; 2]| [0.0, 0.2 * if y > 0.5 { 1.0 - y } else { 0.5 }];
    for extension in [Extension::Harmonic, Extension::PseudoElastic { poisson: 0.0 }] {
        for pair in PAIRS {
            let slide = coupled(extension, pair, Cells::Square, Body::Half, Walls::Sliding);
            let constraints = slide.assembler(&options_of(&slide)).constraints;
            let slides = |n: usize| constraints.u[n] == [true, false] || constraints.u[n] == [false, true];
            let n_sliding = (0..constraints.u.len()).filter(|&n| slides(n)).count();
            // Two sides of 4 cells and a top of 8 without their ends.
            let expected = 2 * (4 * pair.degree - 1) + 8 * pair.degree - 1;
            assert_eq!(n_sliding, expected, "{extension:?} {pair:?}");
            let nodes = slide.space.nodes.n_lagrange;
            for (x, given) in slide.space.nodes.points[..nodes].iter().zip(&constraints.u) {
                if x[1] == 1.0 {
                    let corner = x[0] == 0.0 || x[0] == 1.0;
                    assert_eq!(*given, [corner, true], "{x:?}");
                }
            }
            let r = residual(&slide, &|_| 1.0, true, lifted);
            assert!(r < 1e-14, "{extension:?} {pair:?}: {r:e}");
            let squeezed = |[x, y]: [f64; 2]| [x * (1.0 - x) * (1.0 - y) * y, 0.0];
            assert!(residual(&slide, &|_| 1.0, true, squeezed) > 1e-3, "{pair:?}");
        }
    }
}

/// The error function in the stiffness, and its default length: half the height of the channel.
fn simulation(name: &str, overrides: &[&str]) -> Simulation {
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    Simulation::new(Case::load(name, &overrides).unwrap(), 1).unwrap()
}

const MODELS: [&[&str]; 7] = [
    &["motion.model=harmonic"],
    &["motion.model=stiffened-harmonic"],
    &["motion.model=pseudo-elastic", "motion.poisson=-0.2"],
    &["motion.model=jacobian-stiffened", "motion.jacobian=lagged"],
    &["motion.model=jacobian-stiffened", "motion.jacobian=implicit"],
    &["motion.model=biharmonic"],
    &["motion.model=biharmonic", "motion.outer=hinged"],
];

/// Condensed or whole Jacobian, fixed or sliding: the same solution of each model.
#[test]
#[ignore = "long"]
fn linearizations_agree_for_every_model() {
    for walls in ["motion.walls=fixed", "motion.walls=sliding"] {
        let soft = ["time.shift=1", "solid.mu=1e5", "solid.lambda=4e5", walls];
        MODELS.into_iter().for_each(|model| linearizations_agree(model, &soft));
    }
}

#[test]
#[ignore = "long"]
fn linearizations_agree_on_triangles() {
    for settings in
        [["space.velocity=P2", "motion.walls=sliding"], ["space.velocity=P2-bubble", "motion.walls=fixed"]]
    {
        MODELS.into_iter().for_each(|model| linearizations_agree(model, &settings));
    }
}

fn linearizations_agree(model: &[&str], settings: &[&str]) {
    let end = |linearization: &str| {
        // What remains of the residual weighs a hundred times as much in u.
        let mut list = vec!["mesh.refine=0", "time.step=0.1", "newton.tolerance=1e-10", linearization];
        list.extend(model);
        list.extend(settings);
        let mut s = simulation("fsi3", &list);
        let rows: Vec<_> = (0..4).map(|_| s.step().unwrap()).collect();
        let reports: Vec<_> = rows.iter().map(|r| (r.newton_steps, r.jacobians)).collect();
        println!("{list:?} {reports:?} {:?} {}", rows[3].values, rows[3].min_j);
        s.stepper.new.clone()
    };
    let (a, b) = (end("newton.linearization=condensed"), end("newton.linearization=newton"));
    for (a, b) in [(&a.v, &b.v), (&a.u, &b.u), (&a.p, &b.p)] {
        let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let gap = a.iter().zip(b).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(gap < 2e-8 * size, "{model:?} {settings:?}: {:e}", gap / size);
    }
}

/// fsi1 does not depend on the extension, but for the error of the discretisation: 7 % in u_y on this mesh.
#[test]
#[ignore = "long"]
fn fsi1_is_the_same_with_every_model() {
    for walls in ["motion.walls=fixed", "motion.walls=sliding"] {
        fsi1_is_the_same("space.velocity=Q2", walls, 0.02);
    }
}

#[test]
#[ignore = "long"]
fn fsi1_is_the_same_on_triangles() {
    fsi1_is_the_same("space.velocity=P2", "motion.walls=fixed", 0.02);
    fsi1_is_the_same("space.velocity=P3", "motion.walls=sliding", 0.02);
}

fn fsi1_is_the_same(velocity: &str, walls: &str, by: f64) {
    let reference = simulation("fsi1", &["mesh.refine=0", velocity]).step().unwrap();
    for model in MODELS.into_iter().filter(|m| !m.contains(&"motion.jacobian=lagged")) {
        let mut list = vec!["mesh.refine=0", walls, velocity];
        list.extend(model);
        let row = simulation("fsi1", &list).step().unwrap();
        println!("{model:?} {walls} {velocity}: {:?}", row.values);
        for (a, b) in row.values.iter().zip(&reference.values) {
            assert!((a / b - 1.0).abs() < by, "{model:?} {walls} {velocity}: {a} instead of {b}");
        }
    }
}
