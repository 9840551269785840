//! Terms against flow that comes in through a boundary, against closed forms.

use crate::axisymmetric::walled;
use crate::common::{SCHEMES, channel_between};
use crate::manufactured::*;
use std::f64::consts::PI;
use std::sync::Arc;
use undula::case::Case;
use undula::math::{Tensor, Vector};
use undula::mesh::Side;
use undula::operators::Operator;
use undula::operators::backflow::backflow;
use undula::physics::StepRule;
use undula::physics::kinematics::cofactor;
use undula::simulation::Simulation;
use undula::space::PressureKind::Pdc;
use undula::space::{Against, BoundaryCondition, Coordinates, State};
use undula::system::StepView;
use undula::verification::jacobians::{At, compare};

const K: f64 = 0.05;

/// The force of the term on the side `name` of the unit square, which has the velocity `v` and goes from the displacement
/// 0 to `strain` x in one step.
fn force(name: &str, around: bool, against: Against, v: [f64; 2], strain: Tensor<f64, 2>) -> Vector<f64, 2> {
    let mut space = quadrilaterals(2, Pdc(1)).space(&square(2, Cells::Square, Body::Half), &FSI);
    let all = Arc::get_mut(&mut space).unwrap();
    if around {
        all.coordinates = Coordinates::Axisymmetric;
    }
    let condition = |n: &String| match n == name {
        true => BoundaryCondition::Outflow { do_nothing: true, backflow: against },
        false => BoundaryCondition::Fixed,
    };
    let conditions: Vec<_> = space.mesh.boundaries.iter().map(condition).collect();
    let mut old =
        State { v: vec![0.0; space.n_v()], u: vec![0.0; space.n_u()], p: vec![0.0; space.n_p()], s: vec![] };
    let mut new = old.clone();
    for (node, x) in space.nodes.points.iter().enumerate() {
        let u = strain * Vector(*x);
        for i in 0..2 {
            (old.v[2 * node + i], new.v[2 * node + i]) = (v[i], v[i]);
            new.u[2 * node + i] = u.0[i];
        }
    }
    let term = backflow(&space, (0, FSI.fluid.unwrap()), &conditions, against, 3);
    let sides: Vec<Side> = space.mesh.facets.iter().map(|facet| facet.side()).collect();
    let step = StepView { rule: StepRule::theta(K, 1.0), new: &new, old: &old };
    term.force_through(&step, &sides)
}

/// ½ ρ |flow| v or its part along the boundary, for a homogeneous strain.
#[test]
fn oblique_flow_in_meets_the_part_along_the_boundary() {
    let rho = FSI.fluid.unwrap().rho;
    // A rotation by 30° after a stretch.
    let (c, s) = (0.75f64.sqrt(), 0.5);
    let strain = Tensor([[1.2 * c - 1.0, -0.9 * s], [1.2 * s, 0.9 * c - 1.0]]);
    let still = Tensor::zero();
    for (strain, v) in
        [(still, [-2.0, 0.5]), (still, [2.0, 0.5]), (still, [-2.0, 0.0]), (strain, [-60.0, 7.0])]
    {
        let area = cofactor(&strain) * Vector([1.0, 0.0]);
        let normal = area * (1.0 / area.dot(area).sqrt());
        // On x = 1 from y = ½ to 1, above the solid: linear in y, so that its mean is the value in the middle.
        let rate = strain * Vector([1.0, 0.75]) * (1.0 / K);
        let flow = (Vector(v) - rate).dot(area);
        for against in [Against::Directional, Against::Tangential] {
            let along = Vector(v) - normal * normal.dot(Vector(v));
            let carried = if against == Against::Tangential { along } else { Vector(v) };
            let exact = carried * (0.5 * rho * (-flow).max(0.0) * 0.5);
            let found = force("right", false, against, v, strain);
            let gap = found - exact;
            assert!(gap.dot(gap).sqrt() < 1e-11 * (1.0 + exact.dot(exact).sqrt()), "{found:?} {exact:?}");
        }
    }
}

/// Around an axis, on z = 1, which grows by 1.3² while nothing moves along the axis: the area in motion is π 1.3².
#[test]
fn around_an_axis_the_area_in_motion_counts() {
    let rho = FSI.fluid.unwrap().rho;
    let strain = Tensor([[0.3, 0.0], [0.0, 0.0]]);
    let flux = 0.5 * rho * 2.0 * PI * 1.3 * 1.3;
    for (against, z) in [(Against::Directional, -2.0), (Against::Tangential, 0.0)] {
        let found = force("top", true, against, [0.7, -2.0], strain);
        let gap = found - Vector([0.7, z]) * flux;
        assert!(gap.dot(gap).sqrt() < 1e-11 * flux, "{against:?}: {found:?}");
    }
}

fn channel(more: &[&str]) -> Case {
    let ends = ["condition = \"pressure\"\npressure = 10.2", "condition = \"do-nothing\""];
    channel_between([4, 2], ends, "", more)
}

/// A given pressure has the tangential term, unless the case says otherwise; other outlets have none. All that is written
/// and read again.
#[test]
fn a_given_pressure_has_the_tangential_term() {
    let set = |left: &str| format!("boundary.left.backflow={left}");
    let cases = [
        (channel(&[]), [Against::Tangential, Against::None]),
        (channel(&[&set("tangential")]), [Against::Tangential, Against::None]),
        (channel(&[&set("none")]), [Against::None; 2]),
        (channel(&[&set("directional")]), [Against::Directional, Against::None]),
        (channel(&["boundary.right.backflow=tangential"]), [Against::Tangential; 2]),
        (channel(&["boundary.right.backflow=none"]), [Against::Tangential, Against::None]),
    ];
    for (case, expected) in &cases {
        assert_eq!(["left", "right"].map(|name| case.against(name)), *expected);
        let text = case.to_toml();
        let again = Case::from_toml(&text, "again.toml", &[]).unwrap();
        assert!(again == *case && again.to_toml() == text, "{text}");
        assert!(case.notes().is_empty(), "{:?}", case.notes());
    }
    assert!(cases[0].0 == cases[1].0 && cases[0].0 == cases[5].0 && cases[0].0 != cases[2].0);
    assert!(cases[0].0.to_toml().contains("backflow = \"tangential\""));
    assert!(cases[2].0.to_toml().contains("backflow = \"none\""));
    // Without a fluid nothing is said of it, and a wall has no flow through it.
    let solid = ["fluid=none", "solid.density=1", "solid.mu=1", "solid.lambda=1", "solid.region=fluid"];
    let solid = [&solid[..], &["boundary.right.condition=traction-free"]].concat();
    assert!(!channel(&solid).to_toml().contains("backflow"));
    let wall = channel(&["boundary.top.backflow=tangential"]);
    assert!(wall.notes()[0].contains("boundary.top.backflow has no effect"), "{:?}", wall.notes());
}

/// On a boundary that moves with an elastic wall, in the plane and around an axis.
#[test]
fn all_jacobians_have_the_tangential_term() {
    for (around, scheme) in
        [(false, SCHEMES[2]), (false, SCHEMES[5]), (false, SCHEMES[6]), (true, SCHEMES[2])]
    {
        let more = [scheme, "boundary.top.backflow=tangential", "mesh.cells=[3,2]"];
        let case = walled(0.0, around, &more);
        assert_eq!(["top", "bottom"].map(|name| case.against(name)), [Against::Tangential; 2]);
        let mut simulation = Simulation::new(case, 1).unwrap();
        let report = compare(&mut simulation, At::Random { seed: 3 }).unwrap();
        assert!(report.agrees(), "{around} {scheme}\n{report}");
    }
}
