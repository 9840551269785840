//! Rings of the generator `annulus`: tubes in cross-section.

use crate::common::sets;
use undula::case::Case;
use undula::simulation::Simulation;

/// Lamé's tube under a pressure inside, on a bed of springs outside: u = A r + B/r with σ_r = 2 (λ + μ) A − 2 μ B/r².
#[test]
fn a_tube_on_springs_is_that_of_lame() {
    let text = r#"
[mesh]
generator = "annulus"
radii = [1, 2]
cells = [16, 3]
region = { solid = "1" }
[solid]
density = 1
law = "linear"
mu = 3
lambda = 4
[boundary.inner]
condition = "pressure"
pressure = 0.01
at = "reference"
[boundary.outer]
condition = "spring"
stiffness = 5
[newton]
tolerance = 1e-12
"#;
    let (mu, both, k, p, outer) = (3.0, 7.0, 5.0, 0.01, 2.0f64);
    // 2 (λ + μ) A − 2 μ B = −P and 2 (λ + μ) A − 2 μ B/R² = −k (A R + B/R).
    let [[a, b], [c, d]] =
        [[2.0 * both, -2.0 * mu], [2.0 * both + k * outer, -2.0 * mu / (outer * outer) + k / outer]];
    let det = a * d - b * c;
    let (slope, inverse) = (-p * d / det, p * c / det);
    for direction in ["all", "normal"] {
        let error = |level: &str| {
            let direction = format!("boundary.outer.direction={direction}");
            let more = [direction.as_str(), level];
            let case = Case::from_toml(text, "tube.toml", &sets(&more)).unwrap();
            let mut simulation = Simulation::new(case, 1).ok()?;
            simulation.step().unwrap();
            let fields = simulation.fields();
            let gap = |(x, u): (&[f64; 2], [f64; 2])| {
                let r = x[0].hypot(x[1]);
                let radial = slope + inverse / (r * r);
                (u[0] - radial * x[0]).hypot(u[1] - radial * x[1])
            };
            Some(fields.coordinates().iter().zip(fields.displacement()).map(gap).fold(0.0, f64::max))
        };
        let errors = ["mesh.refine=0", "mesh.refine=1", "mesh.refine=2"].map(error);
        println!("{direction}: {errors:?} of {:.1e}", slope + inverse);
        if direction == "normal" {
            // Nothing holds the tube against a rotation: refused.
            assert_eq!(errors, [None; 3]);
            continue;
        }
        let [_, coarse, fine] = errors.map(Option::unwrap);
        assert!(fine < 1e-8 && (coarse / fine).log2() > 2.7, "{coarse:e} {fine:e}");
    }
}

/// Regions by an expression, here one half.
#[test]
fn a_ring_has_regions() {
    let text = r#"
[mesh]
generator = "annulus"
radii = [1, 2]
cells = [16, 4]
region = { solid = "x" }
[fluid]
density = 1
kinematic-viscosity = 1
[solid]
density = 1
mu = 1
lambda = 1
[boundary.inner]
condition = "no-slip"
[boundary.outer]
condition = "do-nothing"
"#;
    let case = Case::from_toml(text, "tube.toml", &[]).unwrap();
    let mesh = case.build_mesh().unwrap();
    let count = |name: &str| mesh.cell_region.iter().filter(|&&r| Some(r) == mesh.region(name)).count();
    assert_eq!([count("fluid"), count("solid")], [32, 32]);
    let again = Case::from_toml(&case.to_toml(), "again.toml", &[]).unwrap();
    assert_eq!(again.mesh, case.mesh);
}
