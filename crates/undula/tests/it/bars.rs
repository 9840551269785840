//! Bars of laws with many constants, drawn through the program: what the case says is what is computed.

use crate::common::{sets, wrong};
use undula::case::Case;
use undula::simulation::Simulation;
use undula::verification::jacobians;

/// A unit square between planes of symmetry that is drawn by the traction `end` at its right side.
fn bar(solid: &str, end: f64, more: &[&str]) -> Case {
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 1]\ncells = [2, 2]\nregion = {{ solid = \"1\" }}\n\
         [solid]\ndensity = 1\n{solid}\n\
         [boundary.left]\ncondition = \"symmetry\"\n[boundary.bottom]\ncondition = \"symmetry\"\n\
         [boundary.right]\ncondition = \"traction\"\ntraction = [{end}, 0]\n\
         [boundary.top]\ncondition = \"traction-free\"\n[newton]\ntolerance = 1e-12\n"
    );
    Case::from_toml(&text, "bar.toml", &sets(more)).unwrap()
}

/// Draws the bar to F = diag(a, b), where `stress` gives P₁₁ and P₂₂ without pressure, in steps so that Newton's method
/// converges; `kept`: b = 1/a.
fn draw(solid: &str, a: f64, kept: bool, stress: impl Fn(f64, f64) -> [f64; 2]) {
    let (b, end) = if kept {
        let [one, two] = stress(a, 1.0 / a);
        (1.0 / a, one - two / (a * a))
    } else {
        let (mut low, mut high) = (0.3, 1.7);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if stress(a, middle)[1] < 0.0 { low = middle } else { high = middle }
        }
        (low, stress(a, low)[0])
    };
    for linearization in ["newton", "fixed-point"] {
        let more = format!("newton.linearization={linearization}");
        let mut simulation = Simulation::new(bar(solid, end, &[&more]), 1).unwrap();
        simulation.step().unwrap();
        let fields = simulation.fields();
        for (x, u) in fields.coordinates().iter().zip(fields.displacement()) {
            let gap = (u[0] - (a - 1.0) * x[0]).abs().max((u[1] - (b - 1.0) * x[1]).abs());
            assert!(gap < 1e-8, "{solid}: {u:?} at {x:?}, expected {a} and {b}");
        }
    }
    let mut simulation = Simulation::new(bar(solid, end, &[]), 1).unwrap();
    let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 3 }).unwrap();
    assert!(report.agrees(), "{solid}\n{report}");
}

#[test]
fn bars_of_ogden_are_drawn() {
    let terms = [[1.2, 1.3], [0.3, 5.0], [-0.4, -2.0]];
    let keys = "ogden-mu = [1.2, 0.3, -0.4]\nogden-alpha = [1.3, 5, -2]\n";
    let sum = |x: f64| terms.iter().map(|[mu, alpha]| mu * (f64::powf(x, *alpha) - 1.0)).sum::<f64>() / x;
    draw(&format!("law = \"ogden\"\n{keys}lambda = 4"), 1.3, false, |a, b| {
        [sum(a) + 4.0 * (a * b - 1.0) * b, sum(b) + 4.0 * (a * b - 1.0) * a]
    });
    draw(&format!("law = \"incompressible-ogden\"\n{keys}"), 1.3, true, |a, b| [sum(a), sum(b)]);
}

/// λ by the Poisson ratio; what is written is what was read; mistakes are told.
#[test]
fn constants_of_ogden_are_checked() {
    let keys = "law = \"ogden\"\nogden-mu = [1.2, -0.4]\nogden-alpha = [1.5, -2]\n";
    let case = bar(&format!("{keys}poisson = 0.25"), 0.0, &[]);
    let solid = case.solid.as_ref().unwrap();
    assert!((solid.mu - 1.3).abs() < 1e-12 && (solid.lambda - 1.3).abs() < 1e-12);
    let again = Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap();
    assert_eq!(again.solid.unwrap(), *solid);
    let text = format!("[mesh]\ngenerator = \"turek-hron\"\n[solid]\ndensity = 1\n{keys}");
    for (more, expected) in [
        (&["solid.lambda=none"][..], "solid.lambda: missing: `lambda` [Pa] or `poisson`"),
        (&["solid.mu=1", "solid.lambda=1"], "not for the laws of Ogden"),
        (&["solid.lambda=1", "solid.ogden-alpha=[1]"], "expected 2 numbers"),
        (&["solid.lambda=1", "solid.ogden-alpha=[1, 2]"], "signs of those"),
        (&["solid.lambda=1", "solid.law=neo-hookean", "solid.mu=1"], "only for the laws `ogden`"),
        (&["solid.lambda=1", "solid.law=incompressible-ogden"], "expected `bulk` [Pa] or nothing"),
    ] {
        let message = wrong(&text, more);
        assert!(message.contains(expected), "{message}");
    }
}
