//! What the discrete equations reproduce exactly in three dimensions, on bent and on moved hexahedra and tetrahedra.
#![allow(non_snake_case)]

use crate::manufactured::*;
use undula::element::Shape;
use undula::math::{Tensor, Vector};
use undula::physics::{Fluid, Material, Solid, StepRule};
use undula::sampling::for_each_point;
use undula::space::PressureKind::{Continuous, Pdc};
use undula::space::{BoundaryCondition, PsiOwner, Region, State};
use undula::system::{Options, Physics};
use undula::verification::manufactured::{InTime, Manufactured};

/// The cofactor of ∇(x + u) with x and u of degree 2 in each coordinate has degree 4, a test function's gradient 2.
const EXACT: usize = 4;

const PAIRS: [Pair; 5] = [
    quadrilaterals(2, Pdc(1)),
    quadrilaterals(2, Continuous(1)),
    tetrahedra(2, Continuous(1)),
    tetrahedra(3, Continuous(2)),
    Pair { bubble: true, ..tetrahedra(2, Pdc(1)) },
];

/// Neither symmetric nor of one plane; det F = 1.08.
const F: Tensor<f64, 3> = Tensor([[1.1, 0.2, -0.1], [-0.15, 0.95, 0.05], [0.3, -0.1, 1.05]]);

/// A body in the flow on bent cells; outflows without the do-nothing correction.
fn bent(physics: Physics, body: Body, pair: Pair) -> Manufactured<3> {
    let space = pair.in_space(&cube(4, Cells::Curved, body), &physics);
    let mut problem = problem_in(space, physics, nothing(), InTime::Difference, EXACT);
    for condition in &mut problem.conditions {
        if let BoundaryCondition::Outflow { do_nothing, .. } = condition {
            *do_nothing = false;
        }
    }
    problem
}

fn options() -> Options {
    Options::serial(EXACT)
}

/// u = (F − I) x.
fn homogeneous(problem: &Manufactured<3>) -> State {
    let mut at = state(&problem.space, 1, [0.0; 3], 0.0);
    at.u = nodal(&problem.space, |x| ((F - Tensor::identity()) * Vector(x)).0);
    at
}

/// Rows of v and p of nodes inside.
fn inner_rows<'a>(
    problem: &Manufactured<3>,
    rows: &'a [f64],
    of: impl Fn(usize) -> bool + 'a,
) -> impl Iterator<Item = f64> + 'a {
    let boundary = on_boundaries(&problem.space);
    let n_v = problem.space.n_v();
    (0..n_v).filter(move |i| !boundary[i / 3] && of(i / 3)).map(|i| rows[i])
}

/// Piola's identity holds exactly: a constant pressure does no work on inner nodes, whatever the deformation at both ends of
/// the step.
#[test]
fn constant_pressure_does_no_work_inside() {
    for pair in PAIRS {
        let problem = bent(FSI, Body::Inclusion, pair);
        let space = &problem.space;
        let (new, old) = (state(space, 5, [0.0; 3], 3.0), state(space, 6, [0.0; 3], 0.0));
        let mut assembler = problem.assembler(&options());
        let r = region(&mut assembler, Region::Fluid, StepRule::theta(0.1, 0.51), &new, &old);
        let inner = largest(inner_rows(&problem, &r, |_| true));
        assert!(inner < 1e-14, "inner rows with {:?}: {inner:e}", pair.pressure);
        let interface = space.boundary_nodes("interface");
        assert!(largest(interface.iter().map(|&n| r[3 * n as usize])) > 0.02, "forces there are");
    }
}

/// P(F) of each law by its formula, and the law; of those with a pressure of their own at p = 0.
fn laws() -> [(&'static str, Material, Tensor<f64, 3>); 5] {
    let (mu, lambda, c1, c2) = (3.0, 4.0, 1.2, 0.4);
    let (I, J) = (Tensor::identity(), F.det());
    let (C, F_inv_t) = (F.t() * F, F.cofactor() * (1.0 / F.det()));
    let E = (C - I) * 0.5;
    let epsilon = (F + F.t()) * 0.5 - I;
    let venant = F * (E * (2.0 * mu) + I * (lambda * E.trace()));
    let neo = (F - F_inv_t) * mu + F_inv_t * (lambda * (J - 1.0) * J);
    let trace = C.trace();
    // ∂I₁/∂F = 2 F, ∂I₂/∂F = 2 (I₁ F − F C).
    let two = F * (2.0 * c1) + (F * trace - F * C) * (2.0 * c2) - F_inv_t * (2.0 * (c1 + 2.0 * c2));
    let mooney = two + F_inv_t * ((lambda - 4.0 * c2) * (J - 1.0) * J);
    [
        ("linear", Material::Linear { mu, lambda }, epsilon * (2.0 * mu) + I * (lambda * epsilon.trace())),
        ("st-venant-kirchhoff", Material::StVenantKirchhoff { mu, lambda }, venant),
        ("neo-hookean", Material::NeoHookean { mu, lambda }, neo),
        ("mooney-rivlin", Material::MooneyRivlin { c1, c2, lambda }, mooney),
        ("incompressible", Material::incompressible(c1, c2, f64::INFINITY), two),
    ]
}

/// The stress of a homogeneous deformation is constant: no force on nodes inside, and on each side of the body P N times its
/// area.
#[test]
fn homogeneous_deformations_are_met_exactly() {
    for ((name, material, P), pair) in laws().into_iter().zip([0, 2, 0, 3, 0].map(|i| PAIRS[i])) {
        let physics = Physics::new(None, Some(Solid::elastic(2.1, material)));
        let problem = bent(physics, Body::Half, pair);
        let at = homogeneous(&problem);
        let mut assembler = problem.assembler(&options());
        let r = region(&mut assembler, Region::Solid, StepRule::STATIONARY, &at, &at);
        let inner = largest(inner_rows(&problem, &r, |_| true));
        assert!(inner < 2e-14, "{name}: {inner:e}");
        // Tested with the function x e_i, whose gradient is constant, the stress gives the volume times P_ix.
        let (zero, mut volume) = (State::zero(r.len(), r.len(), r.len()), 0.0);
        for_each_point(&problem.space, &zero, EXACT, |point| volume += point.weight);
        for axis in 0..3 {
            let places = &problem.space.nodes.points;
            for i in 0..3 {
                let work: f64 = (0..places.len()).map(|n| r[3 * n + i] * places[n][axis]).sum();
                let expected = volume * P.0[i][axis];
                assert!((work - expected).abs() < 1e-12, "{name} {i}{axis}: {work} and {expected}");
            }
        }
    }
}

#[test]
fn rotations_in_space_have_no_stress() {
    for pair in [PAIRS[0], PAIRS[2]] {
        rotations_have_no_stress(pair);
    }
}

fn rotations_have_no_stress(pair: Pair) {
    let problem = bent(BODY, Body::Block, pair);
    let mut assembler = problem.assembler(&options());
    // About (1, 2, 2)/3 by Rodrigues' formula.
    let axis = Vector([1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]);
    for angle in [0.4f64, 1.6, 3.0] {
        let mut at = state(&problem.space, 1, [0.0; 3], 0.0);
        at.u = nodal(&problem.space, |x| {
            let (a, x) = (axis.0, Vector(x));
            let across = Vector([
                a[1] * x.0[2] - a[2] * x.0[1],
                a[2] * x.0[0] - a[0] * x.0[2],
                a[0] * x.0[1] - a[1] * x.0[0],
            ]);
            let along = axis * axis.dot(x);
            (along + (x - along) * angle.cos() + across * angle.sin() - x + axis * 0.3).0
        });
        let r = region(&mut assembler, Region::Solid, StepRule::STATIONARY, &at, &at);
        let size = largest(r[..problem.space.n_v()].iter().copied());
        // Rounding: derivatives along three edges at once.
        let rounding = if pair.cells == Shape::Tetrahedron { 1e-13 } else { 2e-14 };
        assert!(size < rounding, "rotation by {angle}: {size:e}");
    }
}

/// A homogeneous deformation is its own extension.
#[test]
fn extensions_in_space_reproduce_homogeneous_deformations() {
    // The biharmonic ones are terms of their own.
    for &extension in &EXTENSIONS[..4] {
        let physics = Physics { fluid: Some(Fluid { extension, ..FLUID }), ..FSI };
        let problem = bent(physics, Body::Inclusion, quadrilaterals(2, Pdc(1)));
        let at = homogeneous(&problem);
        let mut assembler = problem.assembler(&options());
        let r = region(&mut assembler, Region::Fluid, StepRule::STATIONARY, &at, &at);
        let space = &problem.space;
        let owned = |node: usize| space.owner[node] == PsiOwner::Extension;
        let size = largest(inner_rows(&problem, &r[space.n_v()..], owned));
        assert!(size < 2e-14, "{extension:?}: {size:e}");
        let fluid = largest((0..space.n_v()).filter(|n| !owned(n / 3)).map(|i| r[space.n_v() + i]));
        assert_eq!(fluid, 0.0, "the rows of the interface do not exist for the fluid");
    }
}

/// v = a (b·(x + u)) with a·b = 0 is a shear flow of the moved domain whose streamlines are straight: with a constant
/// pressure it solves the equations on any mesh, and div v = 0.
#[test]
fn linear_flow_with_constant_pressure_is_a_solution_on_a_moved_mesh() {
    let (a, b) = (Vector([1.0, 2.0, -1.0]), Vector([1.0, 0.0, 1.0]));
    for pair in PAIRS {
        let problem = bent(FSI, Body::Inclusion, pair);
        let space = &problem.space;
        let mut at = state(space, 9, [0.0; 3], 2.0);
        let x = nodal(space, |x| x);
        for n in 0..space.nodes.len() {
            let y: [f64; 3] = std::array::from_fn(|d| x[3 * n + d] + at.u[3 * n + d]);
            at.v[3 * n..3 * n + 3].copy_from_slice(&(a * b.dot(Vector(y))).0);
        }
        let mut assembler = problem.assembler(&options());
        let r = region(&mut assembler, Region::Fluid, StepRule::STATIONARY, &at, &at);
        let momentum = largest(inner_rows(&problem, &r, |_| true));
        let divergence = largest(r[space.n_v() + space.n_u()..].iter().copied());
        let rounding = if pair.degree == 3 { 2e-13 } else { 3e-14 };
        assert!(momentum < rounding && divergence < 1e-14, "{pair:?}: {momentum:e}, {divergence:e}");
        // The same flow of the domain that has not moved is none.
        at.u.fill(0.0);
        let r = region(&mut assembler, Region::Fluid, StepRule::STATIONARY, &at, &at);
        assert!(largest(inner_rows(&problem, &r, |_| true)) > 1e-4);
    }
}

/// The residual of a uniform flow vanishes on a mesh that moves at will.
#[test]
fn uniform_flow_on_a_moving_mesh_of_space_is_a_solution() {
    for pair in PAIRS {
        let problem = bent(FSI, Body::Inclusion, pair);
        let (space, v) = (&problem.space, [0.8, -0.3, 0.5]);
        let (new, old) = (state(space, 3, v, 0.0), state(space, 4, v, 0.0));
        let mut assembler = problem.assembler(&options());
        for theta in [1.0, 0.5, 0.51] {
            let r = region(&mut assembler, Region::Fluid, StepRule::theta(0.1, theta), &new, &old);
            let (n_v, n_u) = (space.n_v(), space.n_u());
            let size = largest(r[..n_v].iter().chain(&r[n_v + n_u..]).copied());
            assert!(size < 1e-13, "{pair:?}, theta = {theta}: {size:e}");
        }
    }
}
