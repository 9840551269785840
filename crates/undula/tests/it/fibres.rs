//! Directions of fibres that change from place to place: a tube whose fibres go around it.

use crate::bars::fibres;
use crate::common::sets;
use crate::slip::mesh;
use std::f64::consts::PI;
use undula::case::Case;
use undula::simulation::Simulation;
use undula::verification::jacobians;
use undula::{CaseBuilder, Error};

/// A quarter of a tube with 1 < r < 2 m in plane strain under the inner pressure `p`, with fibres around it.
fn tube(n: usize, law: &[(&str, &str)], p: f64) -> CaseBuilder {
    let polar = |x: [f64; 2]| [x[0] * (0.5 * PI * x[1]).cos(), x[0] * (0.5 * PI * x[1]).sin()];
    let case = CaseBuilder::new("tube")
        .mesh(mesh([2.0, 1.0], [1.0, 0.0], [n, 2 * n], "1", polar))
        .set("solid.density", 1.0)
        .set("solid.fibre-direction", ["-y", "x"])
        .set("boundary.left.condition", "pressure")
        .set("boundary.left.pressure", p)
        .set("boundary.right.condition", "traction-free")
        .set("boundary.bottom.condition", "symmetry")
        .set("boundary.top.condition", "symmetry")
        .set("newton.tolerance", 1e-12);
    law.iter().fold(case, |case, (key, value)| match value.parse::<f64>() {
        Ok(number) => case.set(&format!("solid.{key}"), number),
        Err(_) => case.set(&format!("solid.{key}"), *value),
    })
}

const MUSCLE: [(&str, &str); 5] =
    [("law", "guccione"), ("guccione-c", "2"), ("b-f", "8"), ("b-t", "2"), ("b-fs", "4")];
const ARTERY: [(&str, &str); 6] = [
    ("law", "incompressible-holzapfel-gasser-ogden"),
    ("mu", "1.5"),
    ("k1", "0.8"),
    ("k2", "0.5"),
    ("dispersion", "0.1"),
    ("fibre-angle", "0.6"),
];

/// σ_θθ − σ_rr at the stretches λ_θ and 1/λ_θ.
fn muscle(a: f64) -> f64 {
    let (x, y) = (0.5 * (a * a - 1.0), 0.5 * (a.powi(-2) - 1.0));
    2.0 * (8.0 * x * x + 2.0 * y * y).exp() * (8.0 * x * a * a - 2.0 * y * a.powi(-2))
}

fn artery(a: f64) -> f64 {
    let [x, y] = fibres([0.8, 0.5, 0.1, 0.6], a, 1.0 / a);
    1.5 * (a * a - a.powi(-2)) + x * a - y / a
}

/// p = ∫ (σ_θθ − σ_rr) dr/r from the radius `from` to the outer one, for r² = R² + c.
fn pressure(c: f64, from: f64, difference: fn(f64) -> f64) -> f64 {
    let (n, b) = (20_000, (4.0 + c).sqrt());
    let h = (b - from) / f64::from(n);
    let slope = |r: f64| difference(r / (r * r - c).sqrt()) / r;
    (0..n).map(|i| slope(from + (f64::from(i) + 0.5) * h) * h).sum()
}

/// The inner radius, and the stress in the middle, of a tube that keeps its volume.
#[test]
fn a_tube_with_fibres_around_it_is_blown_up() {
    for (law, difference, c) in [(&MUSCLE[..], muscle as fn(f64) -> f64, 0.2f64), (&ARTERY, artery, 0.44)] {
        let inner = (1.0 + c).sqrt();
        let p = pressure(c, inner, difference);
        let of = |n: usize| {
            let stress = |component: &str, case: CaseBuilder| {
                let table = format!("functional.{component}");
                case.set(&format!("{table}.kind"), "stress")
                    .set(&format!("{table}.component"), component)
                    .set(&format!("{table}.point"), [1.5, 0.0])
            };
            let case = stress("yy", stress("xx", tube(n, law, p))).build().unwrap();
            let mut simulation = Simulation::new(case, 1).unwrap();
            let row = simulation.step().unwrap();
            let u = simulation.fields().at([1.0, 0.0]).unwrap().displacement;
            // σ_rr(r) = −p(r), what is outside of r bears.
            let r = (2.25 + c).sqrt();
            let radial = row["xx"] + pressure(c, r, difference);
            let around = row["yy"] - row["xx"] - difference(r / 1.5);
            [(u[0] + 1.0 - inner).abs(), radial.abs(), around.abs()]
        };
        let [coarse, fine] = [of(4), of(8)];
        let order = |i: usize| (coarse[i] / fine[i]).log2();
        assert!(order(0) > 3.0 && fine[0] < 2e-5, "{law:?}: {coarse:?} {fine:?}");
        assert!(order(1) > 1.5 && order(2) > 1.5 && fine[2] < 0.01 * p, "{law:?}: {coarse:?} {fine:?} {p}");
    }
}

/// A body that is sheared by its weight, with the direction `fibre` given as text.
fn swinging(fibre: &str, more: &[&str]) -> Simulation {
    let law = "law = \"holzapfel-gasser-ogden\"\nmu = 1.5\nlambda = 4\nk1 = 2\nk2 = 0.5\nfibre-angle = 0.4";
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [2, 1]\ncells = [4, 2]\nregion = {{ solid = \"1\" }}\n\
         [solid]\ndensity = 1\n{law}\nfibre-direction = {fibre}\nbody-force = [0.2, -0.1]\n\
         [boundary.left]\ncondition = \"clamped\"\n[boundary.right]\ncondition = \"traction-free\"\n\
         [boundary.bottom]\ncondition = \"traction-free\"\n[boundary.top]\ncondition = \"traction-free\"\n\
         [time]\nscheme = \"crank-nicolson\"\nstep = 0.1\nend = 0.5\n"
    );
    let mut simulation =
        Simulation::new(Case::from_toml(&text, "body.toml", &sets(more)).unwrap(), 2).unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    simulation
}

/// An angle is short for a field that is the same everywhere, bit for bit; length does not matter.
#[test]
fn an_angle_is_a_constant_field() {
    let guccione = ["solid.law=guccione", "solid.guccione-c=2", "solid.b-f=8", "solid.b-t=2", "solid.b-fs=4"];
    let without = ["mu", "lambda", "k1", "k2", "fibre-angle"].map(|key| format!("solid.{key}=none"));
    let guccione: Vec<&str> = guccione.into_iter().chain(without.iter().map(String::as_str)).collect();
    for more in [&[][..], &guccione, &["newton.linearization=newton", "newton.jacobian=analytic"]] {
        let of = |fibre: &str| swinging(fibre, more).stepper.new.clone();
        let angle = of("0.7");
        assert_eq!(of("[\"cos(0.7)\", \"sin(0.7)\"]"), angle, "{more:?}");
        assert!(angle.u.iter().any(|u| u.abs() > 1e-3));
        let long = of("[\"3*cos(0.7)*(1+x)\", \"3*sin(0.7)*(1+x)\"]");
        let gap = long.u.iter().zip(&angle.u).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        assert!(gap < 1e-9, "{more:?}: {gap}");
        let other = of("1.2");
        assert!(other.u.iter().zip(&angle.u).any(|(a, b)| (a - b).abs() > 1e-4), "{more:?}");
    }
}

#[test]
fn jacobians_know_the_direction_at_the_place() {
    for law in [&MUSCLE[..], &ARTERY] {
        for in_time in [false, true] {
            let case = tube(2, law, 0.1);
            let case = if in_time { case.set("time.step", 0.1).set("time.end", 1.0) } else { case };
            let mut simulation = Simulation::new(case.build().unwrap(), 1).unwrap();
            let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 4 }).unwrap();
            assert!(report.agrees(), "{law:?}\n{report}");
        }
    }
}

#[test]
fn directions_are_checked() {
    let of = |value: &str| {
        let case = tube(2, &MUSCLE, 0.1);
        let text = case.set("name", "tube").build().unwrap().to_toml();
        let mesh = "mesh = { generator = \"box\", lower = [0, 0], upper = [1, 1], cells = [2, 2], region = { solid = \"1\" } }";
        let tables = &text[text.find("[space]").unwrap()..];
        Case::from_toml(
            &format!("{mesh}\n{tables}"),
            "tube.toml",
            &sets(&[&format!("solid.fibre-direction={value}"), "boundary.left.condition=clamped"]),
        )
    };
    let again = Case::from_toml(&of("[\"-y\", \"x + 1\"]").unwrap().to_toml(), "again.toml", &[]).unwrap();
    assert_eq!(again.solids, of("[\"-y\", \"x + 1\"]").unwrap().solids);
    for (value, expected) in [
        ("[\"t\", \"1\"]", "cannot depend on t"),
        ("[\"1 m\", \"1\"]", "expected a component without unit"),
        ("[1]", "expected two expressions, as [\"-y\", \"x\"], not 1 values"),
        ("\"x\"", "expected an angle, or two expressions"),
        ("\"1 m\"", "solid.fibre-direction"),
    ] {
        let message = of(value).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(expected), "{value}: {message}");
    }
    let refused = |value: &str| match Simulation::new(of(value).unwrap(), 1) {
        Err(Error::Case(error)) => error.to_string(),
        _ => panic!("{value} should be refused"),
    };
    let message = refused("[\"max(x - 0.5, 0)\", \"0\"]");
    assert!(message.contains("expected a direction everywhere; it is (0, 0) at"), "{message}");
    let message = refused("[\"1/max(x - 0.5, 0)\", \"0\"]");
    assert!(message.contains("solid.fibre-direction") && message.contains("finite"), "{message}");
}
