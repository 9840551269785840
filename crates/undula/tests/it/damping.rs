//! Damping of solids: vibrations that die out as the closed form says, and what has no damping.
#![allow(non_snake_case)]

use crate::common::{SCHEMES, sets, wrong};
use std::f64::consts::PI;
use undula::case::Case;
use undula::math::Tensor;
use undula::physics::{Damping, Fabric, Fields, Material, Solid};
use undula::simulation::Simulation;
use undula::verification::jacobians;

/// A bar of length 1 between planes of symmetry that vibrates along itself, pulled by f = A sin(πx/2) from t = 0 on.
fn bar(law: &str, size: f64, more: &[&str]) -> Case {
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 0.25]\ncells = [8, 2]\nregion = {{ solid = \"1\" }}\n\
         [solid]\nlaw = \"{law}\"\ndensity = 2\nmu = 3\nlambda = 4\nbody-force = [\"{size}*sin({PI}*x/2)\", \"0\"]\n\
         [boundary.left]\ncondition = \"symmetry\"\n[boundary.right]\ncondition = \"traction-free\"\n\
         [boundary.top]\ncondition = \"symmetry\"\n[boundary.bottom]\ncondition = \"symmetry\"\n\
         [time]\nscheme = \"crank-nicolson\"\nstep = 0.01\nend = 1.5\n[newton]\ntolerance = 1e-12\n"
    );
    Case::from_toml(&text, "bar.toml", &sets(more)).unwrap()
}

/// u_x of the end of the bar at the end of the run.
fn end(case: Case) -> f64 {
    let mut simulation = Simulation::new(case, 1).unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    let fields = simulation.fields();
    let places = fields.coordinates().into_iter().zip(fields.displacement());
    places.filter(|(x, _)| x[0] == 1.0 && x[1] == 0.0).map(|(_, u)| u[0]).next().unwrap()
}

/// u/A of the end at the time t: ü + 2 δ u̇ + ω² u = A from rest with ω² = (λ + 2 μ) κ²/ρ, κ = π/2, and
/// 2 δ = α + (η + β (λ + 2 μ)) κ²/ρ.
fn exact(t: f64, [eta, alpha, beta]: [f64; 3]) -> f64 {
    let (rho, modulus) = (2.0, 10.0);
    let square = PI * PI / 4.0 / rho;
    let (stiff, rate) = (modulus * square, 0.5 * (alpha + (eta + beta * modulus) * square));
    let omega = (stiff - rate * rate).sqrt();
    (1.0 - (-rate * t).exp() * ((omega * t).cos() + rate / omega * (omega * t).sin())) / stiff
}

/// Viscosity, α and β each damp as they should, to second order in time.
#[test]
fn vibrations_die_out_at_the_rate_of_the_closed_form() {
    for numbers in [[0.0; 3], [1.3, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.1], [0.4, 0.3, 0.05]] {
        let [eta, alpha, beta] = numbers;
        let keys = [
            format!("solid.viscosity={eta}"),
            format!("solid.damping-mass={alpha}"),
            format!("solid.damping-stiffness={beta}"),
        ];
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let expected = exact(1.5, numbers);
        let u = |step: &str| end(bar("linear", 1.0, &[&keys[..], &[step]].concat())) / expected;
        let (coarse, fine) = (u("time.step=0.02"), u("time.step=0.01"));
        let order = ((coarse - 1.0).abs() / (fine - 1.0).abs()).log2();
        assert!((order - 2.0).abs() < 0.05, "{numbers:?}: order {order}");
        // Without the error of second order.
        let limit = (4.0 * fine - coarse) / 3.0;
        assert!((limit - 1.0).abs() < 2e-5, "{numbers:?}: {limit}");
    }
}

/// At small strains all compressible laws are damped alike.
#[test]
fn small_vibrations_are_damped_alike_by_all_laws() {
    let damping = ["solid.viscosity=0.4", "solid.damping-mass=0.3", "solid.damping-stiffness=0.05"];
    let linear = end(bar("linear", 1.0, &damping));
    for law in ["st-venant-kirchhoff", "neo-hookean", "mooney-rivlin"] {
        let found = end(bar(law, 1e-7, &damping)) * 1e7;
        assert!((found - linear).abs() < 1e-5 * linear.abs(), "{law}: {found} and {linear}");
    }
}

/// Jacobians of damped bodies by all ways agree, in every scheme and linearisation; one of them keeps its volume.
#[test]
fn jacobians_know_the_damping() {
    let damping = ["solid.viscosity=0.4", "solid.damping-mass=0.3", "solid.damping-stiffness=0.05"];
    for scheme in SCHEMES {
        for law in ["st-venant-kirchhoff", "linear", "incompressible-neo-hookean"] {
            let more = if law.starts_with("inc") { &["solid.lambda=none"][..] } else { &[] };
            let case = bar(law, 0.1, &[&damping[..], &[scheme], more].concat());
            let mut simulation = Simulation::new(case, 1).unwrap();
            let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 3 }).unwrap();
            assert!(report.agrees(), "{scheme} {law}\n{report}");
        }
    }
}

/// A body that turns as a whole, whatever its strain, has no viscous stress; the power is positive else.
#[test]
fn rigid_motion_is_not_damped() {
    let solid = Solid {
        damping: Damping { mass: 0.0, shear: 2.0, volume: 3.0 },
        ..Solid::elastic(1.0, Material::NeoHookean { mu: 3.0, lambda: 4.0 })
    };
    let mut at = Fields::<f64, 2>::zero();
    at.grad_u = Tensor([[0.3, -0.2], [0.5, 0.1]]);
    let F = Tensor::identity() + at.grad_u;
    let still = solid.cauchy(&Fabric::plain(), &at);
    at.grad_v = Tensor([[0.0, -7.0], [7.0, 0.0]]) * F;
    let turning = solid.cauchy(&Fabric::plain(), &at) - still;
    assert!(turning.ddot(turning).sqrt() < 1e-12, "{turning:?}");
    at.grad_v = Tensor([[0.4, -1.0], [0.3, 0.2]]);
    let P = solid.damping.piola(false, &at.grad_v, &at.grad_u);
    let rate = 0.5 * (at.grad_v.t() * F + F.t() * at.grad_v);
    let power = 2.0 * rate.ddot(rate) + 3.0 * rate.trace() * rate.trace();
    assert!((P.ddot(at.grad_v) - power).abs() < 1e-12 && power > 0.0);
}

#[test]
fn damping_below_zero_and_of_a_body_at_rest() {
    let text =
        "[mesh]\ngenerator = \"turek-hron\"\n[solid]\ndensity = 1\nmu = 1\nlambda = 1\nviscosity = -1\n";
    let message = wrong(text, &[]);
    assert!(message.contains("solid.viscosity = -1: expected a number"), "{message}");
    let case = Case::builtin("csm1", &sets(&["solid.viscosity=1"])).unwrap();
    assert!(
        case.record.notes.iter().any(|n| n.contains("solid.viscosity has no effect")),
        "{:?}",
        case.record.notes
    );
}
