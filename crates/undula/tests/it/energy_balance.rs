//! The balance of energy of single bodies: its parts, their sum, and what the time scheme adds.

use crate::common::{channel_between, sets};
use std::collections::BTreeMap;
use undula::case::Case;
use undula::simulation::Simulation;

const PARTS: [&str; 9] =
    ["kinetic", "stored", "rate", "carried", "dissipation", "force", "boundaries", "interface", "residual"];

/// Tables of all parts of the body of `region`.
fn parts(region: &str) -> String {
    let table = |part: &str| {
        format!(
            "[functional.{region}-{part}]\nkind = \"balance\"\nregion = \"{region}\"\npart = \"{part}\"\n"
        )
    };
    PARTS.map(table).concat()
}

/// Largest absolute value of every column over the run, and what the parts of `bodies` do not add up to.
fn run(case: Case, bodies: &[&str]) -> (BTreeMap<String, f64>, f64) {
    let mut simulation = Simulation::new(case, 2).unwrap();
    let (mut most, mut left) = (BTreeMap::new(), 0.0f64);
    while !simulation.finished() {
        let row = simulation.step().unwrap();
        for name in simulation.names() {
            let largest = most.entry(name.clone()).or_insert(0.0f64);
            *largest = largest.max(row[&name].abs());
        }
        for body in bodies {
            let of = |part: &str| row[&format!("{body}-{part}")];
            let sum = of("rate") + of("carried") + of("dissipation");
            let powers = of("force") + of("boundaries") + of("interface");
            left = left.max((sum - powers - of("residual")).abs());
            assert!(left <= 1e-10 * (1.0 + sum.abs() + powers.abs()), "{left}");
        }
        if bodies.len() > 1 {
            let both = bodies.iter().map(|body| row[&format!("{body}-interface")]);
            let (sum, size) = both.fold((0.0, 0.0), |(s, m): (f64, f64), p| (s + p, m.max(p.abs())));
            assert!(sum.abs() < 1e-7 * size + 1e-12, "powers {sum} of {size}");
        }
    }
    (most, left)
}

/// A beam that swings under its weight and a traction at its end.
fn beam(law: &str, scheme: &str, step: f64, more: &[&str]) -> Case {
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 0.2]\ncells = [5, 1]\nregion = {{ solid = \"1\" }}\n\
         [solid]\ndensity = 1\nlaw = \"{law}\"\nmu = 40\nlambda = 60\nbody-force = [0, -1]\n\
         [boundary.left]\ncondition = \"clamped\"\n[boundary.right]\ncondition = \"traction\"\n\
         traction = [\"0.5*sin(3*t)\", -0.3]\n\
         [boundary.bottom]\ncondition = \"traction-free\"\n[boundary.top]\ncondition = \"traction-free\"\n\
         [time]\nscheme = \"{scheme}\"\nstep = {step}\nend = 1\n[newton]\ntolerance = 1e-12\n{}",
        parts("solid")
    );
    Case::from_toml(&text, "beam.toml", &sets(more)).unwrap()
}

/// Crank and Nicolson conserve the energy of Hooke's law, cG(1) that of St. Venant and Kirchhoff; else what the scheme
/// adds falls with its order. Damping is in the balance.
#[test]
fn the_energy_of_a_beam_is_balanced() {
    let residual = |law: &str, scheme: &str, step: f64, more: &[&str]| {
        let (most, _) = run(beam(law, scheme, step, more), &["solid"]);
        assert!(most["solid-rate"] > 0.02 && most["solid-force"] > 0.02, "{most:?}");
        assert!(most["solid-boundaries"] > 0.01 && most["solid-interface"] == 0.0, "{most:?}");
        (most["solid-residual"], most)
    };
    let damped = ["solid.viscosity=0.5", "solid.damping-mass=0.3"];
    for more in [&[][..], &damped] {
        let (left, most) = residual("linear", "crank-nicolson", 0.05, more);
        assert!(left < 1e-9, "{more:?}: {left:e}");
        assert!((most["solid-dissipation"] > 1e-3) != more.is_empty(), "{most:?}");
    }
    let (left, _) = residual("st-venant-kirchhoff", "cg1", 0.05, &[]);
    assert!(left < 1e-9, "{left:e}");
    // From a measured shape, with the energy of its stress.
    let measured = beam("st-venant-kirchhoff", "cg1", 0.05, &["solid.prestress=true"]);
    let (most, _) = run(measured, &["solid"]);
    assert!(most["solid-residual"] < 1e-9 && most["solid-rate"] > 1e-4, "{most:?}");
    assert!(most["solid-stored"] > 1e-3 && most["solid-boundaries"] > 1e-4, "{most:?}");
    for (law, scheme, order) in [
        ("st-venant-kirchhoff", "crank-nicolson", 2.0),
        ("neo-hookean", "cg1", 2.0),
        ("neo-hookean", "backward-euler", 1.0),
        ("neo-hookean", "fractional-step-theta", 1.0),
    ] {
        let ((coarse, _), (fine, _)) =
            (residual(law, scheme, 0.005, &[]), residual(law, scheme, 0.0025, &[]));
        let found = (coarse / fine).log2();
        assert!(found > order - 0.3, "{law}, {scheme}: {coarse:e} {fine:e}, order {found}");
    }
}

/// Poiseuille's flow: the power of the pressure, or of the force, is dissipated: 3.2 Pa times 2/3 m²/s.
#[test]
fn the_energy_of_a_flow_is_balanced() {
    let pressure = |p: f64| format!("condition = \"pressure\"\npressure = {p}");
    let start = "[initial]\nvelocity = [\"4*y*(1-y)\", 0]\n[time]\nscheme = \"crank-nicolson\"\nstep = 0.1\nend = 0.2\n";
    let more = format!("{start}{}", parts("fluid"));
    for (p, force) in [(3.2, 0.0), (0.0, 0.8)] {
        let force = format!("fluid.body-force=[{force}, 0]");
        let case = channel_between([4, 2], [&pressure(p), &pressure(0.0)], &more, &[&force]);
        let (most, _) = run(case, &["fluid"]);
        let power = 3.2 * 2.0 / 3.0;
        assert!((most["fluid-dissipation"] - power).abs() < 1e-8, "{most:?}");
        let (by, other) = if p > 0.0 { ("boundaries", "force") } else { ("force", "boundaries") };
        assert!((most[&format!("fluid-{by}")] - power).abs() < 1e-8, "{most:?}");
        assert!(most[&format!("fluid-{other}")] < 1e-8 && most["fluid-residual"] < 1e-8, "{most:?}");
        // ½ ρ ∫ v² of 4 m: ∫ (4 y (1 − y))² = 8/15.
        assert!((most["fluid-kinetic"] - 2.0 * 8.0 / 15.0).abs() < 1e-8, "{most:?}");
    }
    // A vortex that decays between walls, and a flow that speeds up.
    let vortex = |step: f64| {
        let text = format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 1]\ncells = [4, 4]\n\
             [fluid]\ndensity = 2\nkinematic-viscosity = 0.01\n\
             [boundary.left]\ncondition = \"no-slip\"\n[boundary.right]\ncondition = \"no-slip\"\n\
             [boundary.bottom]\ncondition = \"no-slip\"\n[boundary.top]\ncondition = \"velocity\"\n\
             velocity = [\"16*x^2*(1-x)^2*sin(3*t)\", 0]\n\
             [initial]\nvelocity = [\"sin(pi*x)^2*sin(2*pi*y)\", \"-sin(2*pi*x)*sin(pi*y)^2\"]\n\
             [time]\nscheme = \"crank-nicolson\"\nstep = {step}\nend = 0.4\n[newton]\ntolerance = 1e-11\n{}",
            parts("fluid")
        );
        run(Case::from_toml(&text, "vortex.toml", &[]).unwrap(), &["fluid"]).0
    };
    let (coarse, fine) = (vortex(0.04), vortex(0.02));
    let order = (coarse["fluid-residual"] / fine["fluid-residual"]).log2();
    assert!(order > 1.8 && fine["fluid-residual"] < 1e-3 * fine["fluid-dissipation"], "{coarse:?} {fine:?}");
    assert!(fine["fluid-boundaries"] > 0.01 && fine["fluid-carried"] < 0.1, "{fine:?}");
}

/// A soft flap in a channel: what one body gets at the interface the other one gives, and each balance is of second order.
#[test]
fn the_energy_of_fluid_and_solid_is_balanced() {
    let vessel = |step: f64, more: &[&str]| {
        let text = format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [2, 1]\ncells = [10, 5]\n\
             region = {{ solid = \"min(y - 0.4, 0.2 - abs(x - 1))\" }}\n\
             [fluid]\ndensity = 1\nkinematic-viscosity = 0.05\n\
             [solid]\ndensity = 2\nlaw = \"st-venant-kirchhoff\"\nmu = 5\nlambda = 10\nviscosity = 0.01\n\
             [boundary.left]\ncondition = \"pressure\"\npressure = \"0.4*sin(4*t)^2\"\n\
             [boundary.right]\ncondition = \"pressure\"\npressure = 0\n\
             [boundary.bottom]\ncondition = \"no-slip\"\n[boundary.top]\ncondition = \"no-slip\"\n\
             [time]\nscheme = \"crank-nicolson\"\nstep = {step}\nend = 0.4\n[newton]\ntolerance = 1e-11\n{}{}",
            parts("fluid"),
            parts("solid")
        );
        run(Case::from_toml(&text, "vessel.toml", &sets(more)).unwrap(), &["fluid", "solid"]).0
    };
    let (coarse, fine) = (vessel(0.02, &[]), vessel(0.01, &[]));
    for body in ["fluid", "solid"] {
        let of = |run: &BTreeMap<String, f64>, part: &str| run[&format!("{body}-{part}")];
        let order = (of(&coarse, "residual") / of(&fine, "residual")).log2();
        let size = of(&fine, "interface");
        assert!(order > 1.7 && of(&fine, "residual") < 0.02 * size, "{body}: {order} {coarse:?} {fine:?}");
        assert!(size > 1e-4 && of(&fine, "dissipation") > 0.0, "{fine:?}");
    }
    let soft =
        ["solid.law=incompressible-neo-hookean", "solid.lambda=none", "time.scheme=shifted-crank-nicolson"];
    let run = vessel(0.02, &soft);
    assert!(run["solid-interface"] > 1e-4, "{run:?}");
}

#[test]
fn balances_are_refused_where_there_is_no_step() {
    let case = beam("linear", "crank-nicolson", 0.1, &[]);
    let message = |more: &[&str]| {
        Case::from_toml(&case.to_toml(), "beam.toml", &sets(more))
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default()
    };
    assert_eq!(Case::from_toml(&case.to_toml(), "beam.toml", &[]).unwrap().functional, case.functional);
    for (more, expected) in [
        (&["time=none", "boundary.right.traction=[0, 1]"][..], "only for a case in time"),
        (&["time.scheme=bdf2"], "bdf2 relates three solutions"),
        (&["time.scheme=esdirk4"], "a Runge-Kutta method has several stages"),
        (&["functional.solid-rate.region=none"], "functional.solid-rate.region: missing"),
        (&["functional.solid-rate.part=work"], "expected one of `kinetic`, `stored`, `rate`"),
    ] {
        let message = message(more);
        assert!(message.contains(expected), "{more:?}: {message}");
    }
}
