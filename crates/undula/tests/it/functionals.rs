//! Fields at points, on boundaries and in regions, against closed forms.
#![allow(non_snake_case)]

use crate::common::{SCHEMES, sets};
use crate::manufactured::*;
use crate::traction::channel;
use undula::case::Case;
use undula::element::quadrature::gauss;
use undula::functional::force::Surfaces;
use undula::functional::quantity::{Component, Quantity, Take};
use undula::functional::sampled::{AtPoint, InRegion, OnBoundary};
use undula::functional::{Functional, Snapshot};
use undula::math::{Tensor, Vector};
use undula::physics::stress::{principal, von_mises};
use undula::physics::{Fabric, Fields, Material, Solid, StepRule};
use undula::simulation::Simulation;
use undula::space::PressureKind::Continuous;
use undula::space::{BoundaryCondition, FsiSpace, Region, State};
use undula::system::Physics;

/// Name, definition, unit and value in the flow v = 4 y (1 − y), p = 0.8 (4 − x) with ρν = 0.1 through (0, 4) × (0, 1).
const POISEUILLE: [(&str, &str, &str, f64); 29] = [
    ("out", r#"{kind="flux", on="right"}"#, "m²/s", 2.0 / 3.0),
    ("in", r#"{kind="flux", on="left"}"#, "m²/s", -2.0 / 3.0),
    ("all", r#"{kind="flux", on=["left", "right", "top", "bottom"]}"#, "m²/s", 0.0),
    ("p", r#"{kind="pressure", point=[1, 0.37]}"#, "Pa", 2.4),
    ("p_fluid", r#"{kind="pressure", point=[1.3, 0.37], region="fluid"}"#, "Pa", 2.16),
    ("p_left", r#"{kind="pressure", on="left", take="mean"}"#, "Pa", 3.2),
    ("p_force", r#"{kind="pressure", on="top", take="integral"}"#, "N/m", 6.4),
    ("p_max", r#"{kind="pressure", on=["top", "right"], take="max"}"#, "Pa", 3.2),
    ("p_min", r#"{kind="pressure", on="top", take="min"}"#, "Pa", 0.0),
    ("p_mean", r#"{kind="pressure", region="fluid", take="mean"}"#, "Pa", 1.6),
    ("p_all", r#"{kind="pressure", region="fluid", take="integral"}"#, "N", 6.4),
    ("p_top", r#"{kind="pressure", region="fluid", take="max"}"#, "Pa", 3.2),
    ("v", r#"{kind="velocity", component="x", point=[1.3, 0.25]}"#, "m/s", 0.75),
    ("v_across", r#"{kind="velocity", component="y", point=[1.3, 0.25]}"#, "m/s", 0.0),
    ("v_max", r#"{kind="velocity", component="magnitude", region="fluid", take="max"}"#, "m/s", 1.0),
    ("v_mean", r#"{kind="velocity", component="x", on="right", take="mean"}"#, "m/s", 2.0 / 3.0),
    (
        "v_all",
        r#"{kind="velocity", component="magnitude", region="fluid", take="integral"}"#,
        "m³/s",
        8.0 / 3.0,
    ),
    ("v_end", r#"{kind="velocity", component="x", on="left", take="max"}"#, "m/s", 1.0),
    ("floor", r#"{kind="wall-shear-stress", component="tangential", on="bottom", take="mean"}"#, "Pa", 0.4),
    ("roof", r#"{kind="wall-shear-stress", component="tangential", on="top", take="max"}"#, "Pa", -0.4),
    (
        "walls",
        r#"{kind="wall-shear-stress", component="magnitude", on=["top", "bottom"], take="mean"}"#,
        "Pa",
        0.4,
    ),
    (
        "drag",
        r#"{kind="wall-shear-stress", component="magnitude", on=["top", "bottom"], take="integral"}"#,
        "N/m",
        3.2,
    ),
    ("inlet", r#"{kind="wall-shear-stress", component="tangential", on="left", take="max"}"#, "Pa", 0.4),
    ("normal", r#"{kind="stress", component="xx", point=[1, 0.25]}"#, "Pa", -2.4),
    ("shear", r#"{kind="stress", component="xy", point=[1, 0.25]}"#, "Pa", 0.2),
    (
        "mises",
        r#"{kind="stress", component="von-mises", point=[1, 0.25], region="fluid"}"#,
        "Pa",
        0.346_410_161_513_775_4,
    ),
    ("most", r#"{kind="stress", component="principal-max", point=[1, 0.25]}"#, "Pa", -2.2),
    ("mean_xx", r#"{kind="stress", component="xx", region="fluid", take="mean"}"#, "Pa", -1.6),
    ("area", r#"{kind="volume", region="fluid"}"#, "m²", 4.0),
];

fn poiseuille() -> Vec<String> {
    POISEUILLE.iter().map(|(name, table, ..)| format!("functional.{name}={table}")).collect()
}

#[test]
fn fields_of_poiseuille_flow_are_exact() {
    let elements: [&[&str]; 4] = [
        &["fluid.density=2", "fluid.kinematic-viscosity=0.05"],
        &["space.velocity=Q3", "space.pressure=P2dc"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["space.velocity=P2-bubble", "space.pressure=P1dc"],
    ];
    for elements in elements {
        let functionals = poiseuille();
        let more: Vec<&str> =
            elements.iter().copied().chain(functionals.iter().map(String::as_str)).collect();
        let mut simulation = Simulation::new(channel("1", &more), 1).unwrap();
        let row = simulation.step().unwrap();
        let (names, units) = (simulation.names(), simulation.units());
        for (name, _, unit, right) in POISEUILLE {
            let found = row[name];
            assert!((found - right).abs() < 1e-9, "{elements:?}, {name}: {found} for {right}");
            let at = names.iter().position(|n| n == name).unwrap();
            assert_eq!(units[at], unit, "{name}");
        }
    }
}

/// A flow that grows like t: pressure and stress belong to the time of the forces, all else to the end of the step.
#[test]
fn each_field_has_its_time_in_every_scheme() {
    for scheme in SCHEMES {
        let functionals = poiseuille();
        let more = [
            scheme,
            "time.step=0.1",
            "time.end=0.5",
            "fluid.body-force=[\"4*y*(1-y)\",0]",
            "newton.linearization=newton",
        ];
        let more: Vec<&str> = more.into_iter().chain(functionals.iter().map(String::as_str)).collect();
        let mut simulation = Simulation::new(channel("t", &more), 1).unwrap();
        let mut row = simulation.step().unwrap();
        while !simulation.finished() {
            row = simulation.step().unwrap();
        }
        for (name, table, _, right) in POISEUILLE {
            let forces = table.contains("\"pressure\"") || table.contains("\"stress\"");
            let time = if forces { row.force_time } else { row.time };
            let right = if name == "area" { right } else { right * time };
            assert!((row[name] - right).abs() < 1e-8, "{scheme}, {name}: {} for {right}", row[name]);
        }
    }
}

#[test]
fn a_case_with_fields_is_read_back() {
    let functionals = poiseuille();
    let more: Vec<&str> = functionals.iter().map(String::as_str).collect();
    let case = channel("1", &more);
    let again = Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap();
    assert_eq!(again.functional, case.functional);
    assert_eq!(again.to_toml(), case.to_toml());
}

pub const NEO: Material = Material::NeoHookean { mu: 3.0, lambda: 4.0 };

pub fn physics(material: Material) -> Physics {
    Physics { solid: Some(Solid::elastic(2.1, material)), ..FSI }
}

/// The unit square, the middle of it solid, with u = (F − I) x, v = A x and p = 7 Pa.
pub fn homogeneous(
    pair: Pair,
    physics: &Physics,
    F: [[f64; 2]; 2],
    A: [[f64; 2]; 2],
) -> (FsiSpace<2>, State) {
    let space = pair.space(&square(4, Cells::Curved, Body::Inclusion), physics);
    let space = std::sync::Arc::unwrap_or_clone(space);
    let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
    for (node, x) in space.nodes.points.iter().enumerate().take(space.nodes.n_lagrange) {
        for i in 0..2 {
            state.v[2 * node + i] = A[i][0] * x[0] + A[i][1] * x[1];
            state.u[2 * node + i] = F[i][0] * x[0] + F[i][1] * x[1] - x[i];
        }
    }
    state.p.fill(7.0);
    (space, state)
}

/// The values of `functional` in the steady state `new`.
fn value(functional: &dyn Functional<2>, space: &FsiSpace<2>, physics: &Physics, new: &State) -> f64 {
    let rule = StepRule::STATIONARY;
    functional.evaluate(&Snapshot {
        space,
        physics,
        rule,
        new,
        old: new,
        fluid_residual: &[],
        system: None,
        volume: &[],
    })
}

/// Cauchy stress of the stretches a, b, 1 along the axes, and the third one.
pub fn stretched(material: Material, a: f64, b: f64) -> [f64; 3] {
    let J = a * b;
    let squares = [a * a, b * b, 1.0];
    match material {
        Material::Linear { mu, lambda } => {
            let strains = [a - 1.0, b - 1.0, 0.0];
            strains.map(|e| 2.0 * mu * e + lambda * (a + b - 2.0))
        }
        Material::StVenantKirchhoff { mu, lambda } => {
            let strains = squares.map(|c| 0.5 * (c - 1.0));
            let trace: f64 = strains.iter().sum();
            std::array::from_fn(|i| squares[i] / J * (2.0 * mu * strains[i] + lambda * trace))
        }
        Material::NeoHookean { mu, lambda } => squares.map(|c| mu / J * (c - 1.0) + lambda * (J - 1.0)),
        Material::MooneyRivlin { c1, c2, lambda } => {
            let first: f64 = squares.iter().sum();
            squares.map(|c| {
                2.0 / J * (c1 * c + c2 * (first * c - c * c) - c1 - 2.0 * c2)
                    + (lambda - 4.0 * c2) * (J - 1.0)
            })
        }
        Material::Incompressible { c1, .. } => squares.map(|c| 2.0 * c1 / J * (c - 1.0) - 7.0),
        _ => unreachable!("of other constants"),
    }
}

/// A body that is stretched and then turned has the stresses of the stretch, turned; every law, every place.
#[test]
fn stress_of_a_homogeneous_strain_is_that_of_the_law() {
    let laws = [
        Material::Linear { mu: 3.0, lambda: 4.0 },
        SOLID.material,
        NEO,
        Material::MooneyRivlin { c1: 1.1, c2: 0.4, lambda: 5.0 },
        Material::incompressible(1.5, 0.0, f64::INFINITY),
        Material::own(NEO),
    ];
    for material in laws {
        // Hooke's law knows no rotation.
        let angle = if matches!(material, Material::Linear { .. }) { 0.0f64 } else { 0.5 };
        let (a, b) = (1.3, if material.compliance().is_some() { 1.0 / 1.3 } else { 0.9 });
        let (c, s) = (angle.cos(), angle.sin());
        let F = [[c * a, -s * b], [s * a, c * b]];
        let physics = physics(material);
        let [x, y, z] = stretched(as_built_in(material), a, b);
        let expected = [
            (Component::Entry(0, 0), c * c * x + s * s * y),
            (Component::Entry(1, 1), s * s * x + c * c * y),
            (Component::Entry(0, 1), c * s * (x - y)),
            (Component::PrincipalMax, x.max(y)),
            (Component::PrincipalMin, x.min(y)),
            (Component::VonMises, (0.5 * ((x - y).powi(2) + (y - z).powi(2) + (z - x).powi(2))).sqrt()),
        ];
        for pair in [quadrilaterals(2, Continuous(1)), triangles(2, Continuous(1))] {
            let (space, state) = homogeneous(pair, &physics, F, [[0.0; 2]; 2]);
            for (component, right) in expected {
                let quantity = Quantity::Stress(component);
                // On the corner of four cells, within one, and at the interface.
                let mut found: Vec<f64> = [[0.5, 0.5], [0.43, 0.52], [0.3, 0.31]]
                    .map(|at| AtPoint::new(&space, at, Some(Region::Solid.into()), quantity).unwrap())
                    .iter()
                    .map(|at| value(at, &space, &physics, &state))
                    .collect();
                for take in [Take::Mean, Take::Max, Take::Min] {
                    found.push(value(
                        &InRegion::new(Region::Solid, quantity, take, 3),
                        &space,
                        &physics,
                        &state,
                    ));
                }
                for found in found {
                    assert!(
                        (found - right).abs() < 1e-11,
                        "{material:?}, {component:?}: {found} for {right}"
                    );
                }
            }
        }
    }
}

/// The built-in law whose energy a law of another program has here.
fn as_built_in(material: Material) -> Material {
    if matches!(material, Material::Own(_)) { NEO } else { material }
}

#[test]
fn volumes_are_those_of_the_deformed_bodies() {
    let F = [[1.2, 0.3], [-0.1, 0.8]];
    let J = 1.2 * 0.8 + 0.03;
    for pair in [quadrilaterals(2, Continuous(1)), triangles(3, Continuous(2)), BUBBLE] {
        let physics = physics(NEO);
        let (space, state) = homogeneous(pair, &physics, F, [[0.0; 2]; 2]);
        let rest = State { u: vec![0.0; state.u.len()], ..state.clone() };
        let area = |region, state: &State| {
            value(&InRegion::new(region, Quantity::One, Take::Integral, 4), &space, &physics, state)
        };
        let [fluid, solid] = [Region::Fluid, Region::Solid].map(|region| area(region, &state));
        assert!((fluid + solid - J).abs() < 1e-13, "{fluid} + {solid}");
        assert!((solid - J * area(Region::Solid, &rest)).abs() < 1e-13, "{solid}");
    }
}

/// v = A x on the domain F x: the flow through all boundaries is tr(A F⁻¹) times the area, parts add up, and the
/// interface has what comes out of the fluid.
#[test]
fn flows_through_moved_boundaries_are_those_of_the_divergence() {
    let F = Tensor([[1.2, 0.3], [-0.1, 0.8]]);
    let A = Tensor([[0.7, -0.2], [0.4, 0.5]]);
    let physics = physics(NEO);
    let divergence = (A * F.cofactor().t()).trace();
    let (space, state) = homogeneous(quadrilaterals(2, Continuous(1)), &physics, F.0, A.0);
    let conditions = vec![BoundaryCondition::Free; space.mesh.boundaries.len()];
    let surfaces = Surfaces::new(&space, &conditions, 4);
    let flux = |names: &[&str]| {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        value(
            &OnBoundary::new(&surfaces, &names, Quantity::NormalVelocity, Take::Integral),
            &space,
            &physics,
            &state,
        )
    };
    let outer = ["left", "right", "bottom", "top"];
    let rest = State { u: vec![0.0; state.u.len()], ..state.clone() };
    let solid =
        value(&InRegion::new(Region::Solid, Quantity::One, Take::Integral, 4), &space, &physics, &rest);
    assert!((flux(&outer) - divergence).abs() < 1e-13, "{} for {divergence}", flux(&outer));
    assert!((flux(&["interface"]) + divergence * solid).abs() < 1e-13, "{}", flux(&["interface"]));
    let parts: f64 = outer.iter().map(|name| flux(&[name])).sum();
    assert!((parts - divergence).abs() < 1e-13, "{parts}");
}

/// v = A x on the domain F x: −σ n along the moved boundary with σ = ρν (L + Lᵀ), L = A F⁻¹; a pressure adds nothing.
#[test]
fn wall_shear_stress_is_along_the_moved_boundary() {
    let F = Tensor([[1.2, 0.3], [-0.1, 0.8]]);
    let A = Tensor([[0.7, -0.2], [0.4, 0.5]]);
    let physics = physics(NEO);
    let (space, state) = homogeneous(quadrilaterals(2, Continuous(1)), &physics, F.0, A.0);
    let L = A * F.cofactor().t() * (1.0 / F.det());
    let sigma = AUXETIC.rho * AUXETIC.nu * (L + L.t());
    let conditions = vec![BoundaryCondition::Free; space.mesh.boundaries.len()];
    let surfaces = Surfaces::new(&space, &conditions, 3);
    for (name, side) in [("bottom", [1.0, 0.0]), ("right", [0.0, 1.0]), ("top", [-1.0, 0.0])] {
        // The tangent that has the fluid on its left is the image of that of the reference domain.
        let t = F * Vector(side);
        let length = t.dot(t).sqrt();
        let t = t * (1.0 / length);
        let n = Vector([t.0[1], -t.0[0]]);
        let right = -t.dot(sigma * n);
        let names = [name.to_string()];
        for (component, right) in [(Component::Tangential, right), (Component::Magnitude, right.abs())] {
            let quantity = Quantity::WallShear(component);
            let takes = [(Take::Mean, right), (Take::Max, right), (Take::Integral, right * length)];
            for (take, right) in takes {
                let on = OnBoundary::new(&surfaces, &names, quantity, take);
                let found = value(&on, &space, &physics, &state);
                assert!((found - right).abs() < 1e-13, "{name}, {component:?}: {found} for {right}");
            }
        }
    }
}

/// A smooth displacement at the nodes of Q2: stresses at points and their extremes are of order 2, their mean of order
/// 3 at least.
#[test]
fn stress_converges_with_the_mesh() {
    let physics = Physics { fluid: None, ..physics(NEO) };
    let u = |x: [f64; 2]| [0.1 * (2.0 * x[0] + x[1]).sin(), 0.08 * (x[0] - 3.0 * x[1]).cos()];
    let grad = |x: [f64; 2]| {
        let (c, s) = ((2.0 * x[0] + x[1]).cos(), (x[0] - 3.0 * x[1]).sin());
        [[0.2 * c, 0.1 * c], [-0.08 * s, 0.24 * s]]
    };
    let exact = |x: [f64; 2]| {
        let at = Fields { grad_u: Tensor(grad(x)), ..Fields::zero() };
        von_mises(&physics.solid.unwrap().cauchy::<2>(&Fabric::plain(), &at))
    };
    // Over the current region by a Gauss rule; the extreme at points that are the nodes of a fine mesh.
    let (points, weights) = gauss(40);
    let (mut sum, mut area, mut most) = (0.0, 0.0, 0.0f64);
    for (i, j) in (0..40).flat_map(|j| (0..40).map(move |i| (i, j))) {
        let x = [0.25 + 0.5 * points[i], 0.25 + 0.5 * points[j]];
        let weight = 0.25 * weights[i] * weights[j] * (Tensor::identity() + Tensor(grad(x))).det();
        (sum, area) = (sum + weight * exact(x), area + weight);
    }
    for (i, j) in (0..=400).flat_map(|j| (0..=400).map(move |i| (f64::from(i), f64::from(j)))) {
        most = most.max(exact([0.25 + i / 800.0, 0.25 + j / 800.0]));
    }
    let quantity = Quantity::Stress(Component::VonMises);
    let errors = [4, 8, 16, 32].map(|n| {
        let space = space(&square(n, Cells::Square, Body::Inclusion), &physics, 2, Continuous(1));
        let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
        state.u = space.nodes.points.iter().flat_map(|&x| u(x)).collect();
        let of = |functional: &dyn Functional<2>| value(functional, &space, &physics, &state);
        let in_region = |take| of(&InRegion::new(Region::Solid, quantity, take, 5));
        let points = (0..7).map(|i| [0.29 + 0.061 * f64::from(i), 0.71 - 0.053 * f64::from(i)]);
        let at_points =
            points.map(|x| (of(&AtPoint::new(&space, x, None, quantity).unwrap()) - exact(x)).abs());
        [
            at_points.fold(0.0, f64::max),
            (in_region(Take::Mean) - sum / area).abs(),
            (in_region(Take::Max) - most).abs(),
        ]
    });
    println!("{errors:?}");
    for (n, order) in [(0, 1.7), (1, 2.7), (2, 1.6)] {
        let found = (errors[0][n] / errors[3][n]).log2() / 3.0;
        assert!(found > order, "{n}: order {found}");
    }
}

#[test]
fn principal_stresses_are_eigenvalues() {
    let mut random = Random(3);
    for _ in 0..100 {
        let mut a = Tensor::<f64, 3>::zero();
        a.0.iter_mut().flatten().for_each(|x| *x = random.next());
        let sigma = a + a.t();
        let [least, between, most] = principal::<3>(&sigma);
        assert!(least <= between && between <= most);
        assert!((least + between + most - sigma.trace()).abs() < 1e-14);
        assert!((least * between * most - sigma.det()).abs() < 1e-14);
        for value in [least, between, most] {
            assert!((sigma - Tensor::identity() * value).det().abs() < 1e-14);
        }
        let [less, more] = principal::<2>(&sigma);
        let (mean, half) = (0.5 * (sigma.0[0][0] + sigma.0[1][1]), 0.5 * (sigma.0[0][0] - sigma.0[1][1]));
        let radius = half.hypot(sigma.0[0][1]);
        assert!((less - mean + radius).abs() < 1e-14 && (more - mean - radius).abs() < 1e-14);
    }
}

/// v = 4 y (1 − y) given at the inlet: what the inlet does, −power, is what viscosity dissipates, μ ∫ |∂_y v|² dx =
/// 32/15.
#[test]
fn power_of_poiseuille_flow_is_dissipated() {
    for element in ["space.velocity=Q2", "space.velocity=P2-bubble"] {
        let more = [
            element,
            "boundary.left={condition=\"velocity\", velocity=[\"4*y*(1-y)\", 0]}",
            r#"functional.power={kind="power", on=["left", "top", "bottom"]}"#,
            r#"functional.lid={kind="power", on="top"}"#,
            r#"functional.loss={kind="energy", term="dissipation"}"#,
        ];
        let mut simulation = Simulation::new(channel("1", &more), 1).unwrap();
        let row = simulation.step().unwrap();
        assert!((row["power"] + 32.0 / 15.0).abs() < 1e-9, "{element}: {}", row["power"]);
        assert!((row["loss"] - 32.0 / 15.0).abs() < 1e-9 && row["lid"].abs() < 1e-12, "{element}");
    }
}

/// What the fluid does to the beam of fsi3 is the change of the energy of the beam, to the order 2 of the scheme.
#[test]
fn power_on_a_body_is_the_change_of_its_energy() {
    let residuals = ["0.02", "0.01", "0.005"].map(|step| {
        let step = format!("time.step={step}");
        let more = [
            "mesh.refine=0",
            "time.scheme=crank-nicolson",
            "time.end=0.4",
            "newton.tolerance=1e-10",
            "boundary.inflow.velocity=[\"20*y*(0.41-y)*t^2*(1+y)\", 0]",
            step.as_str(),
            r#"functional.power={kind="power", on="interface"}"#,
            r#"functional.kinetic={kind="energy", term="solid-kinetic"}"#,
            r#"functional.elastic={kind="energy", term="elastic"}"#,
        ];
        let mut simulation = Simulation::new(crate::common::builtin("fsi3", &more), 1).unwrap();
        let (mut work, mut time, mut energy) = (0.0, 0.0, 0.0);
        while !simulation.finished() {
            let row = simulation.step().unwrap();
            work += (row.time - time) * row["power"];
            (time, energy) = (row.time, row["kinetic"] + row["elastic"]);
        }
        println!("work {work:e}, energy {energy:e}");
        (work - energy).abs() / energy
    });
    println!("{residuals:?}");
    let order = (residuals[0] / residuals[2]).log2() / 2.0;
    assert!(residuals[2] < 1e-2 && order > 1.8, "{residuals:?}: order {order}");
}

/// What the built-in case `name` says of a functional `f`.
fn told(name: &str, table: &str, more: &[&str]) -> String {
    let set = format!("functional.f={table}");
    let all: Vec<&str> = more.iter().copied().chain([set.as_str()]).collect();
    let case = match Case::builtin(name, &sets(&all)) {
        Ok(case) => case,
        Err(errors) => return errors.to_string(),
    };
    match Simulation::new(case, 1) {
        Ok(simulation) => format!("{:?} {:?}", simulation.names(), simulation.case.record.notes),
        Err(error) => error.to_string(),
    }
}

#[test]
fn combinations_without_sense_are_refused() {
    let small = ["mesh.refine=0"];
    for (table, expected) in [
        (r#"{kind="flux"}"#, "functional.f.on: missing: the boundaries"),
        (r#"{kind="flux", on="inlet"}"#, "functional.f.on: the mesh has no boundary `inlet`"),
        (r#"{kind="flux", on="inflow", take="mean"}"#, "unknown key; [functional.f] takes `kind`, `on`"),
        (r#"{kind="power", on="outflow"}"#, "the velocity on the boundary `outflow` is free"),
        (r#"{kind="pressure"}"#, "functional.f.on: missing: `point`, `on` or `region`"),
        (
            r#"{kind="pressure", on="inflow"}"#,
            "functional.f.take: missing: one of `mean`, `max`, `min`, `integral`",
        ),
        (r#"{kind="pressure", on="inflow", take="sum"}"#, "expected one of `mean`, `max`, `min`, `integral`"),
        (
            r#"{kind="pressure", on="inflow", region="fluid", take="mean"}"#,
            "expected either `on` or `region`",
        ),
        (
            r#"{kind="pressure", point=[0.3, 0.2], take="mean"}"#,
            "a point has one value: leave it out, or `point`",
        ),
        (
            r#"{kind="pressure", point=[0.3, 0.2], on="inflow"}"#,
            "a point has one value: leave it out, or `point`",
        ),
        (
            r#"{kind="pressure", region="solid", take="max"}"#,
            "a compressible solid has no pressure; `stress` has its components",
        ),
        (
            r#"{kind="pressure", point=[0.4, 0.2]}"#,
            "there is no pressure at [0.4, 0.2], inside a compressible solid",
        ),
        (
            r#"{kind="pressure", point=[0.4, 0.2], region="fluid"}"#,
            "functional.f.region: point [0.4, 0.2] lies in another region",
        ),
        (r#"{kind="pressure", point=[0.4, 0.9]}"#, "point [0.4, 0.9] lies in no cell"),
        (r#"{kind="velocity", component="xx", point=[0.4, 0.2]}"#, "expected one of `x`, `y`, `magnitude`"),
        (r#"{kind="velocity", point=[0.4, 0.2]}"#, "component: missing: one of `x`, `y`, `magnitude`"),
        (r#"{kind="stress", component="x", point=[0.4, 0.2]}"#, "expected one of `xx`, `xy`, `yy`"),
        (
            r#"{kind="stress", component="xx", on="inflow", take="max"}"#,
            "a stress is taken at a point or in a region",
        ),
        (
            r#"{kind="stress", component="xx", region="beam", take="max"}"#,
            "no body fills this region; there are `fluid`, `solid`",
        ),
        (
            r#"{kind="wall-shear-stress", component="magnitude", on="cylinder"}"#,
            "functional.f.take: missing: one of",
        ),
        (r#"{kind="volume"}"#, "functional.f.region: missing: the region"),
        (r#"{kind="force", on="cylinder", component="magnitude"}"#, "expected one of `x`, `y`"),
    ] {
        let found = told("fsi3", table, &small);
        assert!(found.contains(expected), "{table}: {found}");
    }
}

/// Without a body its functionals are left out, as others are; a name that the mesh does not have is a mistake.
#[test]
fn fields_of_absent_bodies_are_left_out() {
    let rigid = ["mesh.refine=0", "solid=none"];
    for table in [
        r#"{kind="stress", component="von-mises", region="solid", take="max"}"#,
        r#"{kind="stress", component="von-mises", point=[0.4, 0.2], region="solid"}"#,
        r#"{kind="volume", region="solid"}"#,
    ] {
        let found = told("fsi3", table, &rigid);
        assert!(found.contains("functional.f is left out") && !found.contains("\"f\""), "{table}: {found}");
    }
    let found = told("fsi3", r#"{kind="volume", region="fluidd"}"#, &rigid);
    assert!(found.contains("the mesh has no region `fluidd`; did you mean `fluid`?"), "{found}");
    // A body without fluid.
    let found = told("csm1", r#"{kind="pressure", on="inflow", take="mean"}"#, &["mesh.refine=0"]);
    assert!(found.contains("functional.f is left out: there is no [fluid]"), "{found}");
    // The hole of the beam is a boundary of the fluid.
    let found = told("fsi3", r#"{kind="flux", on="interface"}"#, &rigid);
    assert!(found.contains("\"f\""), "{found}");
}

/// An incompressible solid has a pressure of its own; where two bodies meet, `region` says which is meant.
#[test]
fn pressure_at_the_interface_is_that_of_the_region() {
    let physics = physics(Material::incompressible(1.5, 0.0, f64::INFINITY));
    let space = quadrilaterals(2, Continuous(1)).space(&square(4, Cells::Square, Body::Inclusion), &physics);
    let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
    for cell in 0..space.mesh.n_cells() {
        let value = if space.regions[cell] == Region::Fluid { 2.0 } else { 5.0 };
        space.pressure.cell(cell).iter().for_each(|&dof| state.p[dof as usize] = value);
    }
    let at = |region: Option<Region>, x| {
        let pressure =
            undula::functional::point::Pressure::new(&space, x, region.map(Into::into), 2).unwrap();
        value(&pressure, &space, &physics, &state)
    };
    for x in [[0.25, 0.5], [0.25, 0.56], [0.25, 0.25]] {
        for (region, right) in [(Some(Region::Fluid), 2.0), (Some(Region::Solid), 5.0)] {
            assert!((at(region, x) - right).abs() < 1e-12, "{x:?} {region:?}");
        }
    }
    assert!((at(None, [0.25, 0.5]) - 2.0).abs() < 1e-12);
    for (region, right) in [(Region::Fluid, 2.0), (Region::Solid, 5.0)] {
        let mean = InRegion::new(region, Quantity::Pressure, Take::Mean, 3);
        assert!((value(&mean, &space, &physics, &state) - right).abs() < 1e-12);
    }
}
