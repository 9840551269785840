//! The ALE map of section 5.3.5: what each extension reproduces, and that all of them solve the same problem.

#[path = "common/manufactured.rs"]
mod manufactured;

use manufactured::*;
use std::sync::Arc;
use undula::assembly::{Assembler, Physics, StepView};
use undula::physics::{Extension, Fluid, StepRule};
use undula::problem::case::Case;
use undula::problem::manufactured::{Exact, InTime, Manufactured, Values, number};
use undula::simulation::Simulation;
use undula::space::PressureKind::P1dc;
use undula::space::{PsiOwner, State, Walls};

fn coupled(extension: Extension, cells: Cells, body: Body, walls: Walls) -> Manufactured {
    let zero = number(0.0);
    let nothing: Exact = Arc::new(move |_, _| Values { v: [zero; 2], u: [zero; 2], p: zero });
    let physics = Physics { fluid: Some(Fluid { extension, ..FLUID }), ..FSI };
    let mesh = square(8, cells, body);
    let mut problem = problem(&mesh, physics, P1dc, nothing, InTime::Difference, QUADRATURE);
    Arc::make_mut(&mut problem.space).walls = walls;
    problem
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
    at.u = space.nodes.points.iter().flat_map(|x| f(*x)).collect();
    let mut assembler =
        Assembler::new(space.clone(), problem.physics, &problem.conditions, stiffness, &options());
    let mut r = vec![0.0; space.n_unknowns()];
    assembler.residual(&StepView { rule: StepRule::STATIONARY, new: &at, old: &at }, &mut r);
    let mut outer = vec![false; space.nodes.len()];
    for facet in space.mesh.facets.iter().filter(|_| !boundary) {
        space.facet_nodes(facet).iter().for_each(|&n| outer[n as usize] = true);
    }
    let owned = |n: &usize| space.owner[n / 2] == PsiOwner::Extension && !outer[n / 2];
    (0..space.n_v()).filter(owned).map(|i| r[space.n_v() + i].abs()).fold(0.0, f64::max)
}

fn affine([x, y]: [f64; 2]) -> [f64; 2] {
    [0.1 + 0.2 * x - 0.1 * y, 0.15 * x + 0.05 * y - 0.3]
}

fn uneven(x: &[f64; 2]) -> f64 {
    1.0 / (0.1 + x[0] * x[0] + 0.3 * x[1])
}

/// With constant coefficients an affine motion of the boundary is extended by itself.
#[test]
fn affine_motions_are_reproduced() {
    for extension in EXTENSIONS {
        let problem = coupled(extension, Cells::Curved, Body::Inclusion, Walls::Fixed);
        let r = residual(&problem, &|_| 1.0, false, affine);
        assert!(r < 1e-13, "{extension:?}: {r:e}");
        assert!(residual(&problem, &|_| 1.0, false, |[x, _]| [x * x, 0.0]) > 1e-3, "{extension:?}");
    }
}

/// With variable coefficients translations are, and infinitesimal rotations where the stress is symmetric.
#[test]
fn translations_and_rotations_are_reproduced() {
    for extension in EXTENSIONS {
        let problem = coupled(extension, Cells::Curved, Body::Inclusion, Walls::Fixed);
        let shift = residual(&problem, &uneven, false, |_| [0.2, -0.1]);
        let turn = residual(&problem, &uneven, false, |[x, y]| [-0.2 * y, 0.2 * x]);
        assert!(shift < 1e-13, "{extension:?}: {shift:e}");
        match extension {
            Extension::Harmonic => assert!(turn > 1e-3, "{turn:e}"),
            _ => assert!(turn < 1e-13, "{extension:?}: {turn:e}"),
        }
        assert!(residual(&problem, &uneven, false, affine) > 1e-3, "{extension:?}");
    }
}

/// Above a body that is lifted by s a mesh that slides along the side walls is compressed evenly,
/// u = (0, 2 s (1 − y)): tangential unknowns of the walls are free, normal ones and corners are 0.
#[test]
fn sliding_mesh_is_compressed_evenly() {
    let lifted = |[_, y]: [f64; 2]| [0.0, 0.2 * if y > 0.5 { 1.0 - y } else { 0.5 }];
    for extension in [Extension::Harmonic, Extension::PseudoElastic { poisson: 0.0 }] {
        let slide = coupled(extension, Cells::Square, Body::Half, Walls::Sliding);
        let constraints = slide.assembler(&options()).constraints;
        let slides = |n: usize| constraints.u[n] == [true, false] || constraints.u[n] == [false, true];
        let n_sliding = (0..constraints.u.len()).filter(|&n| slides(n)).count();
        // Two sides of 8 cells less two ends, and 16 of 17 nodes on top less a corner.
        assert_eq!(n_sliding, 2 * 7 + 15, "{extension:?}");
        for (x, given) in slide.space.nodes.points.iter().zip(&constraints.u) {
            if x[1] == 1.0 {
                let corner = x[0] == 0.0 || x[0] == 1.0;
                assert_eq!(*given, [corner, true], "{x:?}");
            }
        }
        let r = residual(&slide, &|_| 1.0, true, lifted);
        assert!(r < 1e-14, "{extension:?}: {r:e}");
        let squeezed = |[x, y]: [f64; 2]| [x * (1.0 - x) * (1.0 - y) * y, 0.0];
        assert!(residual(&slide, &|_| 1.0, true, squeezed) > 1e-3);
    }
}

/// The error function in the stiffness, and its default length: half the height of the channel.
fn simulation(name: &str, overrides: &[&str]) -> Simulation {
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    Simulation::new(Case::load(name, &overrides).unwrap(), 1).unwrap()
}

const MODELS: [&[&str]; 5] = [
    &["motion.model=harmonic"],
    &["motion.model=stiffened-harmonic"],
    &["motion.model=pseudo-elastic", "motion.poisson=-0.2"],
    &["motion.model=jacobian-stiffened", "motion.jacobian=lagged"],
    &["motion.model=jacobian-stiffened", "motion.jacobian=implicit"],
];

/// Condensed or whole Jacobian, fixed or sliding: the same solution of each model.
#[test]
fn linearizations_agree_for_every_model() {
    for walls in ["motion.walls=fixed", "motion.walls=sliding"] {
        for model in MODELS {
            let end = |linearization: &str| {
                let mut list = vec!["mesh.refine=0", "time.step=0.1", "solid.mu=1e5", "solid.lambda=4e5", walls];
                list.extend(model);
                list.push(linearization);
                let mut s = simulation("fsi3", &list);
                let rows: Vec<_> = (0..4).map(|_| s.step().unwrap()).collect();
                let reports: Vec<_> = rows.iter().map(|r| (r.newton_steps, r.jacobians)).collect();
                println!("{model:?} {walls} {linearization} {reports:?} {:?} {}", rows[3].values, rows[3].min_j);
                s.stepper.new.clone()
            };
            let (a, b) = (end("newton.linearization=condensed"), end("newton.linearization=newton"));
            for (a, b) in [(&a.v, &b.v), (&a.u, &b.u), (&a.p, &b.p)] {
                let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                let gap = a.iter().zip(b).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                assert!(gap < 1e-6 * size, "{model:?} {walls}: {:e}", gap / size);
            }
        }
    }
}

/// fsi1 does not depend on the extension, but for the error of the discretisation.
#[test]
fn fsi1_is_the_same_with_every_model() {
    for walls in ["motion.walls=fixed", "motion.walls=sliding"] {
        for model in MODELS.into_iter().filter(|m| !m.contains(&"motion.jacobian=lagged")) {
            let mut list = vec!["mesh.refine=0", walls];
            list.extend(model);
            let row = simulation("fsi1", &list).step().unwrap();
            println!("{model:?} {walls}: {:?}", row.values);
            let reference = simulation("fsi1", &["mesh.refine=0"]).step().unwrap();
            for (a, b) in row.values.iter().zip(&reference.values) {
                assert!((a / b - 1.0).abs() < 2e-3, "{model:?} {walls}: {a} instead of {b}");
            }
        }
    }
}
