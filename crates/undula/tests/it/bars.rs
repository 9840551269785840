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
    let solid = &case.solids[0];
    assert!((solid.mu - 1.3).abs() < 1e-12 && (solid.lambda - 1.3).abs() < 1e-12);
    let again = Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap();
    assert_eq!(again.solids[0], *solid);
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

/// k₁ E exp(k₂ E²) of both families, E = κ (a² + b² − 2) + (1 − 3 κ)(a² cos² + b² sin² − 1), times ∂E/∂a and ∂E/∂b.
pub fn fibres([k1, k2, kappa, angle]: [f64; 4], a: f64, b: f64) -> [f64; 2] {
    let (c, s) = (angle.cos().powi(2), angle.sin().powi(2));
    let strain = kappa * (a * a + b * b - 2.0) + (1.0 - 3.0 * kappa) * (a * a * c + b * b * s - 1.0);
    let tension = 2.0 * k1 * strain.max(0.0) * (k2 * strain * strain).exp();
    [2.0 * a * (kappa + (1.0 - 3.0 * kappa) * c), 2.0 * b * (kappa + (1.0 - 3.0 * kappa) * s)]
        .map(|x| x * tension)
}

#[test]
fn bars_with_fibres_are_drawn() {
    for (kappa, degrees) in [(0.0, 30.0f64), (0.1, 50.0), (1.0 / 3.0, 0.0)] {
        let numbers = [0.8, 0.5, kappa, degrees.to_radians()];
        let keys =
            format!("mu = 1.5\nk1 = 0.8\nk2 = 0.5\ndispersion = {kappa}\nfibre-angle = \"{degrees} deg\"\n");
        draw(&format!("law = \"holzapfel-gasser-ogden\"\n{keys}lambda = 4"), 1.2, false, |a, b| {
            let [x, y] = fibres(numbers, a, b);
            let volume = 4.0 * (a * b - 1.0);
            [1.5 * (a - 1.0 / a) + volume * b + x, 1.5 * (b - 1.0 / b) + volume * a + y]
        });
        draw(&format!("law = \"incompressible-holzapfel-gasser-ogden\"\n{keys}"), 1.2, true, |a, b| {
            let [x, y] = fibres(numbers, a, b);
            [1.5 * (a - 1.0 / a) + x, 1.5 * (b - 1.0 / b) + y]
        });
    }
}

#[test]
fn bars_of_muscle_are_drawn() {
    let stress = |[along, across]: [f64; 2]| {
        move |a: f64, b: f64| {
            let (x, y) = (0.5 * (a * a - 1.0), 0.5 * (b * b - 1.0));
            let factor = 2.0 * (along * x * x + across * y * y).exp();
            [factor * along * x * a, factor * across * y * b]
        }
    };
    let keys = "law = \"guccione\"\nguccione-c = 2\nb-f = 8\nb-t = 2\nb-fs = 4\n";
    draw(keys, 1.15, true, stress([8.0, 2.0]));
    draw(&format!("{keys}fibre-direction = \"90 deg\"\n"), 1.15, true, stress([2.0, 8.0]));
}

#[test]
fn constants_of_fibres_are_checked() {
    let keys = "law = \"holzapfel-gasser-ogden\"\nmu = 1\nlambda = 1\nk1 = 2\nk2 = 3\nfibre-angle = 0.5\n";
    let case = bar(&format!("{keys}dispersion = 0.2\nfibre-direction = 0.1"), 0.0, &[]);
    let again = Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap();
    assert_eq!(again.solids, case.solids);
    let muscle = "law = \"guccione\"\nguccione-c = 2\nb-f = 8\nb-t = 2\nb-fs = 4\nbulk = 100\n";
    let case = bar(muscle, 0.0, &[]);
    let again = Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap();
    assert_eq!(again.solids, case.solids);
    let text = |solid: &str| format!("[mesh]\ngenerator = \"turek-hron\"\n[solid]\ndensity = 1\n{solid}");
    for (solid, more, expected) in [
        (keys, "solid.dispersion=0.4", "from 0, aligned, to 1/3"),
        (keys, "solid.k1=none", "solid.k1: missing: the stiffness of the fibres"),
        (keys, "solid.law=neo-hookean", "only for the laws `holzapfel-gasser-ogden`"),
        (keys, "solid.b-f=1", "only for the law `guccione`"),
        (muscle, "solid.b-fs=none", "solid.b-fs: missing"),
        (muscle, "solid.mu=1", "not for the law of Guccione"),
        (muscle, "solid.b-t=-1", "expected a number above 0"),
    ] {
        let message = wrong(&text(solid), &[more]);
        assert!(message.contains(expected), "{message}");
    }
}
