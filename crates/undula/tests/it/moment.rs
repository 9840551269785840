//! The moment of the force of the fluid.

use crate::common::{SCHEMES, builtin, sets, wrong};
use std::f64::consts::PI;
use undula::case::Case;
use undula::simulation::Simulation;

/// A cylinder that turns in a ring at rest, Couette 1890: the moment per length is 4 π μ Ω r² R²/(R² − r²).
#[test]
fn a_turning_cylinder_has_the_moment_of_couette() {
    let text = r#"
[mesh]
generator = "annulus"
radii = [1, 2]
cells = [16, 3]
[fluid]
density = 3
kinematic-viscosity = 0.5
[boundary.inner]
condition = "velocity"
velocity = ["-0.1*y", "0.1*x"]
[boundary.outer]
condition = "no-slip"
[functional.inner]
kind = "moment"
on = ["inner"]
point = [0.3, -0.2]
[functional.outer]
kind = "moment"
on = ["outer"]
point = [0, 0]
"#;
    let exact = 4.0 * PI * 1.5 * 0.1 * 4.0 / 3.0;
    let error = |more: &[&str], gap: f64| {
        let mut simulation =
            Simulation::new(Case::from_toml(text, "ring.toml", &sets(more)).unwrap(), 1).unwrap();
        let row = simulation.step().unwrap();
        assert_eq!(simulation.units()[0], "N");
        let [inner, outer] = [row["inner"] / -exact - 1.0, row["outer"] / exact - 1.0];
        // In equilibrium the moments are opposite, about whatever point, as far as the flow has no divergence.
        assert!((inner - outer).abs() < gap, "{more:?}: {inner:e} {outer:e}");
        inner.abs()
    };
    let (coarse, fine) = (error(&[], 1e-8), error(&["mesh.refine=1"], 1e-8));
    println!("{coarse:.1e} {fine:.1e}");
    assert!(fine < 1e-4 && (coarse / fine).log2() > 3.5, "{coarse:e} {fine:e}");
    assert!(error(&["space.velocity=P2", "mesh.refine=1"], 1e-6) < 2e-4);
}

/// Moments of parts add up, and the point may be moved along with the force, in the motion of every scheme.
#[test]
fn moments_add_up_and_know_their_point() {
    let table = |name: &str, on: &str, point: &str| {
        let key = format!("functional.{name}");
        [format!("{key}.kind=moment"), format!("{key}.on={on}"), format!("{key}.point={point}")]
    };
    let force = |name: &str, component: &str| {
        let key = format!("functional.{name}");
        [
            format!("{key}.kind=force"),
            format!("{key}.on=[\"interface\",\"cylinder\"]"),
            format!("{key}.component={component}"),
        ]
    };
    for scheme in SCHEMES {
        let more = [
            table("both", "[\"interface\",\"cylinder\"]", "[0.2,0.2]"),
            table("beam", "interface", "[0.2,0.2]"),
            table("circle", "cylinder", "[0.2,0.2]"),
            table("other", "[\"interface\",\"cylinder\"]", "[0.7,-0.4]"),
            force("fx", "x"),
            force("fy", "y"),
        ]
        .concat();
        let mut more: Vec<&str> = more.iter().map(String::as_str).collect();
        more.extend([scheme, "mesh.refine=0", "time.step=0.05", "time.end=0.1"]);
        let mut simulation = Simulation::new(builtin("fsi3", &more), 1).unwrap();
        simulation.step().unwrap();
        let row = simulation.step().unwrap();
        let size = row["fx"].abs();
        let gap = row["both"] - row["beam"] - row["circle"];
        assert!(size > 0.1 && gap.abs() < 1e-9 * size, "{scheme}: {gap:e}");
        // M' = M − (c' − c) × F.
        let moved = row["both"] - (0.5 * row["fy"] + 0.6 * row["fx"]);
        assert!((row["other"] - moved).abs() < 1e-9 * size, "{scheme}: {} {moved}", row["other"]);
    }
}

#[test]
fn moments_are_checked() {
    let text = "[mesh]\ngenerator = \"annulus\"\nradii = [1, 2]\ncells = [16, 3]\n[fluid]\ndensity = 1\n\
                kinematic-viscosity = 1\n[functional.m]\nkind = \"moment\"\n";
    let message = wrong(text, &[]);
    assert!(message.contains("functional.m.on: missing"), "{message}");
    assert!(message.contains("functional.m.point: missing"), "{message}");
    let message = wrong(text, &["mesh.radii=[2,1]", "mesh.cells=[6,1]"]);
    assert!(
        message.contains("mesh.radii") && message.contains("larger one of the outer circle"),
        "{message}"
    );
    assert!(message.contains("mesh.cells") && message.contains("multiple of 4"), "{message}");
    let message = wrong(text, &["mesh.upper=[2,1]"]);
    assert!(message.contains("mesh.upper") && message.contains("only for generator = \"box\""), "{message}");
    let message = wrong(&text.replace("radii = [1, 2]\ncells = [16, 3]\n", ""), &[]);
    assert!(message.contains("mesh.radii: missing") && message.contains("mesh.cells: missing"), "{message}");
    let message = wrong(&text.replace("annulus", "cavity"), &[]);
    assert!(message.contains("mesh.radii") && message.contains("generator = \"annulus\""), "{message}");
}
