//! What the discrete equations reproduce exactly.
#![allow(non_snake_case)]

use crate::manufactured::*;
use std::sync::Arc;
use undula::algebra::SolverError;
use undula::element::Shape;
use undula::functional::force::{ForceByResidual, ForceBySurface, Surfaces};
use undula::functional::{Functional, Snapshot};
use undula::mesh::Mesh;
use undula::mesh::generate::rectangle;
use undula::nonlinear::NewtonError;
use undula::physics::{Fluid, StepRule};
use undula::space::PressureKind::{Continuous, Pdc};
use undula::space::{BoundaryCondition, PsiOwner, Region};
use undula::system::{End, Options, Physics};
use undula::time::{Scheme, Stepper};
use undula::verification::manufactured::{Exact, InTime, Manufactured, Values, cos, number, sin};

const K: f64 = 0.1;

/// Stable pairs on quadrilaterals and triangles whose patch tests are exact with the rule [`QUADRATURE`].
const PAIRS: [Pair; 5] = [
    quadrilaterals(2, Pdc(1)),
    quadrilaterals(2, Continuous(1)),
    triangles(2, Continuous(1)),
    triangles(3, Pdc(1)),
    BUBBLE,
];

/// A body in the flow on bent cells.
fn bent(physics: Physics, body: Body, pair: Pair) -> Manufactured {
    let space = pair.space(&square(4, Cells::Curved, body), &physics);
    problem_in(space, physics, nothing(), InTime::Difference, pair.quadrature())
}

fn options_of(pair: Pair) -> Options {
    Options::serial(pair.quadrature())
}

/// Piola's identity holds exactly: a constant pressure does no work on inner nodes and its forces on a
/// closed surface add up to zero, whatever the deformation at both ends of the step.
#[test]
fn constant_pressure_does_no_net_work() {
    for pair in PAIRS {
        let (pressure, problem) = (pair.pressure, bent(FSI, Body::Inclusion, pair));
        let (new, old) = (state(&problem.space, 5, [0.0; 2], 3.0), state(&problem.space, 6, [0.0; 2], 0.0));
        let mut assembler = problem.assembler(&options_of(pair));
        let r = region(&mut assembler, Region::Fluid, StepRule::theta(K, 0.51), &new, &old);
        let boundary = on_boundaries(&problem.space);
        let inner = (0..problem.space.n_v()).filter(|i| !boundary[i / 2]).map(|i| r[i]);
        assert!(largest(inner) < 1e-14, "inner rows with {pressure:?}");
        let interface = problem.space.boundary_nodes("interface");
        assert!(largest(interface.iter().map(|&n| r[2 * n as usize])) > 0.1, "forces there are");
        for i in 0..2 {
            let sum: f64 = interface.iter().map(|&n| r[2 * n as usize + i]).sum();
            assert!(sum.abs() < 1e-13, "net force {sum:e} with {pressure:?}");
        }
    }
}

#[test]
fn rigid_motion_of_the_solid_has_no_stress() {
    for pair in PAIRS {
        rigid_motion_has_no_stress(pair);
    }
}

fn rigid_motion_has_no_stress(pair: Pair) {
    let problem = bent(BODY, Body::Block, pair);
    let mut assembler = problem.assembler(&options_of(pair));
    for angle in [0.0f64, 0.4, 1.6, 3.0] {
        let (c, s) = (angle.cos(), angle.sin());
        let mut at = state(&problem.space, 1, [0.0; 2], 0.0);
        at.u = nodal(&problem.space, |[x, y]| [c * x - s * y - x + 0.3, s * x + c * y - y - 0.2]);
        let r = region(&mut assembler, Region::Solid, StepRule::STATIONARY, &at, &at);
        let size = largest(r[..problem.space.n_v()].iter().copied());
        // Rounding: more points, and derivatives along two sides at once.
        let rounding = if pair.cells == Shape::Triangle { 4e-14 } else { 1e-14 };
        assert!(size < rounding, "{pair:?}, rotation by {angle}: {size:e}");
    }
    // The linear strain of the same motion is not zero, so that a missing term would show.
    let mut at = state(&problem.space, 1, [0.0; 2], 0.0);
    at.u = nodal(&problem.space, |[x, y]| [-0.4 * y, 0.4 * x]);
    let r = region(&mut assembler, Region::Solid, StepRule::STATIONARY, &at, &at);
    assert!(largest(r[..problem.space.n_v()].iter().copied()) > 0.01);
}

/// v = W (x + u) with a skew W is a rotation of the current domain: no viscous stress.
#[test]
fn rotating_flow_has_no_viscous_stress() {
    let forces = |nu: f64| {
        let physics = Physics { fluid: Some(Fluid { nu, ..AUXETIC }), ..FSI };
        let mut problem = bent(physics, Body::Inclusion, PAIRS[0]);
        for condition in &mut problem.conditions {
            if let BoundaryCondition::Outflow { do_nothing, .. } = condition {
                *do_nothing = false;
            }
        }
        let mut at = state(&problem.space, 9, [0.0; 2], 0.0);
        let x = nodal(&problem.space, |x| x);
        for n in 0..problem.space.nodes.len() {
            let y = [x[2 * n] + at.u[2 * n], x[2 * n + 1] + at.u[2 * n + 1]];
            (at.v[2 * n], at.v[2 * n + 1]) = (-0.7 * y[1], 0.7 * y[0]);
        }
        region(&mut problem.assembler(&options()), Region::Fluid, StepRule::STATIONARY, &at, &at)
    };
    let (thin, thick) = (forces(0.1), forces(10.0));
    let gap = largest(thin.iter().zip(&thick).map(|(a, b)| a - b));
    assert!(gap < 1e-13, "{gap:e}");
}

/// The residual of a uniform flow vanishes on a mesh that moves at will, with do-nothing outflow.
#[test]
fn uniform_flow_on_a_moving_mesh_is_a_solution() {
    for pair in PAIRS {
        let problem = bent(FSI, Body::Inclusion, pair);
        let v = [0.8, -0.3];
        let (new, old) = (state(&problem.space, 3, v, 0.0), state(&problem.space, 4, v, 0.0));
        let mut assembler = problem.assembler(&options_of(pair));
        for theta in [1.0, 0.5, 0.51] {
            let r = region(&mut assembler, Region::Fluid, StepRule::theta(K, theta), &new, &old);
            let (n_v, n_u) = (problem.space.n_v(), problem.space.n_u());
            let size = largest(r[..n_v].iter().chain(&r[n_v + n_u..]).copied());
            assert!(size < 1e-13, "{pair:?}, theta = {theta}: {size:e}");
        }
    }
}

/// A uniform flow stays uniform where body and mesh are moved by right-hand sides of their own equations.
#[test]
fn uniform_flow_on_a_moving_mesh_stays_uniform() {
    let exact: Exact = Arc::new(|x, t| Values {
        v: [number(0.8), number(-0.3)],
        u: [bubble(x) * sin(t * 2.0) * 0.1, bubble(x) * cos(t * 3.0) * -0.08],
        p: number(0.0),
    });
    let mesh = square(4, Cells::Square, Body::Inclusion);
    let mut problem = problem(&mesh, FSI, Pdc(1), exact, InTime::Difference, QUADRATURE);
    problem.fluid = false;
    for scheme in [Scheme::BackwardEuler, Scheme::CrankNicolson] {
        let mut stepper = problem.stepper(scheme, 0.0, false, &options());
        for _ in 0..5 {
            stepper.step(K).unwrap();
        }
        let e = problem.errors(&stepper.new, stepper.time, stepper.time, QUADRATURE);
        println!("uniform flow {scheme:?}: {e:?}");
        assert!(e.v < 1e-11 && e.u < 1e-11 && e.p < 1e-9, "{scheme:?}: {e:?}");
    }
}

/// An affine deformation is its own extension.
#[test]
fn extension_reproduces_affine_deformations() {
    for (fluid, pair) in [FLUID, AUXETIC].into_iter().flat_map(|fluid| PAIRS.map(|pair| (fluid, pair))) {
        let problem = bent(Physics { fluid: Some(fluid), ..FSI }, Body::Inclusion, pair);
        let mut at = state(&problem.space, 1, [0.0; 2], 0.0);
        at.u = nodal(&problem.space, |[x, y]| [0.1 + 0.2 * x - 0.1 * y, 0.15 * x + 0.05 * y - 0.3]);
        let mut assembler = problem.assembler(&options_of(pair));
        let r = region(&mut assembler, Region::Fluid, StepRule::STATIONARY, &at, &at);
        let (n_v, boundary) = (problem.space.n_v(), on_boundaries(&problem.space));
        let owned = |n: &usize| problem.space.owner[n / 2] == PsiOwner::Extension;
        let inner = (0..n_v).filter(owned).filter(|n| !boundary[n / 2]).map(|i| r[n_v + i]);
        let size = largest(inner);
        assert!(size < 1e-14, "{:?}: {size:e}", fluid.extension);
        // The rows of the interface do not exist for the fluid.
        let interface = (0..n_v).filter(|n| !owned(n)).map(|i| r[n_v + i]);
        assert_eq!(largest(interface), 0.0);
    }
}

/// Speed in the middle of the channel.
const SPEED: f64 = 0.7;

/// Poiseuille's flow through the unit square under a body force f along it; `p = 0` at the outflow.
fn poiseuille(f: f64) -> Exact {
    let slope = FLUID.rho * f - 8.0 * FLUID.rho * FLUID.nu * SPEED;
    Arc::new(move |[x, y], _| Values {
        v: [(y - y * y) * (4.0 * SPEED), number(0.0)],
        u: [number(0.0); 2],
        p: (x - number(1.0)) * slope,
    })
}

/// The stationary flow from rest with the data of `exact` and body force `f` along x.
fn flow(problem: &Manufactured, f: f64) -> Stepper<2> {
    let options = Options::serial(problem.quadrature);
    let mut stepper = problem.stepper(Scheme::BackwardEuler, 0.0, true, &options);
    stepper.source = None;
    stepper.assembler.set_force(Region::Fluid, End::New, Some(&|_| [f, 0.0]));
    stepper.stationary().unwrap();
    stepper
}

fn channel(cells: Cells) -> Mesh<2> {
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], 0).unwrap();
    bend(&mut mesh, 4, cells);
    mesh
}

#[test]
fn poiseuille_is_exact_with_do_nothing_outflow() {
    for pair in PAIRS {
        let (pressure, quadrature) = (pair.pressure, pair.quadrature());
        for cells in [Cells::Square, Cells::Trapezia] {
            let space = pair.space(&channel(cells), &FLOW);
            let mut problem = problem_in(space, FLOW, poiseuille(0.0), InTime::Difference, quadrature);
            let e = problem.errors(&flow(&problem, 0.0).new, 0.0, 0.0, QUADRATURE);
            println!("Poiseuille with {pressure:?}: {e:?}");
            assert!(e.v < 1e-11 && e.p < 1e-10, "{pressure:?}: {e:?}");
            let free = |b: &mut BoundaryCondition<2>| {
                if let BoundaryCondition::Outflow { do_nothing, .. } = b {
                    *do_nothing = false;
                }
            };
            problem.conditions.iter_mut().for_each(free);
            let e = problem.errors(&flow(&problem, 0.0).new, 0.0, 0.0, QUADRATURE);
            assert!(e.v > 1e-3, "a traction-free outflow is another problem: {e:?}");
        }
    }
}

/// Both forces on `name` after `stepper`: by the residual and by the integral over the surface.
fn forces(problem: &Manufactured, stepper: &mut Stepper<2>, name: &str, component: usize) -> [f64; 2] {
    let (names, space) = ([name.to_string()], &*problem.space);
    let surfaces = Surfaces::new(space, &problem.conditions, QUADRATURE);
    let by_residual = ForceByResidual::new(&surfaces, &names, component, 1.0, "N/m");
    let by_surface = ForceBySurface::new(&surfaces, &names, component, 1.0, "N/m");
    let (rule, new, old, assembler) = stepper.last_step();
    let fluid_residual = &region(assembler, Region::Fluid, rule, new, old);
    let (physics, system) = (&problem.physics, None);
    let at = Snapshot { space, physics, rule, new, old, fluid_residual, system, volume: &[] };
    [by_residual.evaluate(&at), by_surface.evaluate(&at)]
}

/// The force on a hole is that of the weight of the fluid displaced, by the residual and by the surface.
#[test]
fn force_on_a_hole_is_the_weight_displaced() {
    for pair in PAIRS {
        let (f, mesh, pressure) = (2.5, square(4, Cells::Trapezia, Body::Inclusion), pair.pressure);
        let space = pair.space(&mesh, &FLOW);
        let problem = problem_in(space, FLOW, poiseuille(f), InTime::Difference, pair.quadrature());
        let mut stepper = flow(&problem, f);
        let e = problem.errors(&stepper.new, 0.0, 0.0, QUADRATURE);
        assert!(e.v < 1e-11 && e.p < 1e-10, "{e:?}");
        let mut area = 1.0;
        undula::sampling::for_each_point(&problem.space, &stepper.new, 2, |p| area -= p.weight);
        let expected = [-FLUID.rho * f * area, 0.0];
        for component in 0..2 {
            for force in forces(&problem, &mut stepper, "interface", component) {
                let gap = (force - expected[component]).abs();
                assert!(gap < 1e-10, "{pressure:?}: {force} instead of {}", expected[component]);
            }
        }
    }
}

/// Shear on a part of the wall: exact by the surface, and by the residual, of which the part and its neighbours
/// share the nodes at its ends.
#[test]
fn force_on_a_wall_is_its_shear() {
    let mut mesh = channel(Cells::Square);
    let bottom = mesh.boundary("bottom").unwrap();
    mesh.boundaries.push("plate".into());
    for i in 0..mesh.facets.len() {
        let f = mesh.facets[i];
        if f.boundary == bottom && (mesh.centre(f.cell as usize)[0] - 0.5).abs() < 0.25 {
            mesh.facets[i].boundary = mesh.boundaries.len() as u16 - 1;
        }
    }
    let problem = problem(&mesh, FLOW, Pdc(1), poiseuille(0.0), InTime::Difference, QUADRATURE);
    let mut stepper = flow(&problem, 0.0);
    let [by_residual, by_surface] = forces(&problem, &mut stepper, "plate", 0);
    let shear = FLUID.rho * FLUID.nu * 4.0 * SPEED;
    assert!((by_surface - shear * 0.5).abs() < 1e-11, "{by_surface}");
    assert!((by_residual - shear * 0.5).abs() < 1e-11, "{by_residual}");
}

/// Without an outflow the pressure of a flow is known up to a constant only: reported, not solved.
#[test]
fn closed_box_is_singular() {
    let lid: Exact = Arc::new(|[x, y], _| Values {
        v: [y * (x - x * x), number(0.0)],
        u: [number(0.0); 2],
        p: number(0.0),
    });
    for pressure in [Pdc(1), Continuous(1)] {
        for cells in [Cells::Square, Cells::Curved] {
            let mut problem =
                problem(&channel(cells), FLOW, pressure, lid.clone(), InTime::Difference, QUADRATURE);
            problem.conditions = vec![BoundaryCondition::Velocity(velocity(&lid)); 4];
            for stationary in [true, false] {
                let mut stepper = problem.stepper(Scheme::CrankNicolson, 0.0, true, &options());
                stepper.source = None;
                let result = if stationary { stepper.stationary() } else { stepper.step(K) };
                let reason = result.expect_err("the pressure is not determined").reason;
                println!("closed box: {reason}");
                assert!(
                    matches!(reason, NewtonError::Linear(SolverError::Singular { .. })),
                    "{pressure:?}: {reason}"
                );
            }
        }
    }
}

/// With an elastic body in it the closed box has a solution: its volume follows the flux over the walls.
#[test]
fn closed_box_with_a_body_is_regular() {
    let mut problem = bent(FSI, Body::Inclusion, PAIRS[0]);
    for condition in &mut problem.conditions {
        if matches!(condition, BoundaryCondition::Outflow { .. }) {
            *condition = BoundaryCondition::Fixed;
        }
    }
    let mut stepper = problem.stepper(Scheme::CrankNicolson, 0.0, true, &options());
    stepper.source = None;
    stepper.assembler.set_force(Region::Solid, End::New, Some(&|_| [0.5, 0.0]));
    stepper.step(K).unwrap();
    assert!(largest(stepper.new.u.iter().copied()) > 1e-6);
}
