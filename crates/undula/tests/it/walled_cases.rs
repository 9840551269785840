//! Cases on walls that are grown from a surface.

use crate::common::sets;
use std::path::Path;
use undula::case::Case;
use undula::mesh::generate::tube;
use undula::mesh::gmsh::write;
use undula::simulation::Simulation;

const MESHES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes");

const SOLID: &str = r#"
[mesh]
file = "lumen_2.msh"
wall = { surface = "lumen", thickness = 1, layers = 2 }
leave-out = ["fluid"]
[solid]
region = "wall"
density = 1
law = "linear"
mu = 3
lambda = 4
[boundary.lumen]
condition = "pressure"
pressure = 0.01
at = "reference"
[boundary.outer]
condition = "spring"
stiffness = 5
direction = "all"
[boundary.wall-inflow]
condition = "symmetry"
[boundary.wall-outflow]
condition = "symmetry"
[newton]
tolerance = 1e-12
"#;

fn case(text: &str, overrides: &[&str]) -> Result<Case, String> {
    let path = format!("{MESHES}/case.toml");
    Case::from_toml(text, &path, &sets(overrides)).map_err(|e| e.to_string())
}

/// Lamé's thick tube on a bed of springs, plane strain: u = A r + B/r.
#[test]
#[ignore = "long"]
fn a_grown_wall_under_pressure_is_that_of_lame() {
    let (mu, both, k, p, outer) = (3.0, 7.0, 5.0, 0.01, 2.0f64);
    let [[a, b], [c, d]] =
        [[2.0 * both, -2.0 * mu], [2.0 * both + k * outer, -2.0 * mu / (outer * outer) + k / outer]];
    let det = a * d - b * c;
    let (slope, inverse) = (-p * d / det, p * c / det);
    let errors = ["mesh.refine=0", "mesh.refine=1"].map(|level| {
        let mut simulation = Simulation::in_space(case(SOLID, &[level]).unwrap(), 1).unwrap();
        simulation.step().unwrap();
        let fields = simulation.fields();
        let gap = |(x, u): (&[f64; 3], [f64; 3])| {
            let r = x[0].hypot(x[1]);
            let radial = slope + inverse / (r * r);
            (u[0] - radial * x[0]).hypot(u[1] - radial * x[1]).hypot(u[2])
        };
        fields.coordinates().iter().zip(fields.displacement()).map(gap).fold(0.0, f64::max)
    });
    println!("{errors:?} of {:e}", slope + inverse);
    assert!(errors[1] < 0.01 * (slope + inverse) && (errors[0] / errors[1]).log2() > 1.8, "{errors:?}");
}

/// The key in a case: written and read again, a thickness that depends on the place, and what is wrong with its line.
#[test]
fn a_case_has_a_wall() {
    let thick = case(SOLID, &["mesh.wall.thickness='1 + x/4'"]).unwrap();
    let text = thick.to_toml();
    for line in ["wall.surface = [\"lumen\"]", "wall.thickness = \"1 + x/4\"", "wall.layers = 2"] {
        assert!(text.contains(line), "{text}");
    }
    assert_eq!(case(&text, &[]).unwrap().to_toml(), text);
    let mesh = Simulation::in_space(thick, 1).unwrap().fields().coordinates().to_vec();
    let most =
        |x: f64| mesh.iter().filter(|at| at[0] * x > 0.0).map(|x| x[0].hypot(x[1])).fold(0.0, f64::max);
    assert!((most(1.0) - 2.25).abs() < 0.02 && most(-1.0) < 2.01, "{} {}", most(1.0), most(-1.0));
    for (change, expected) in [
        (
            "mesh.wall.surface=lumne",
            "--set mesh.wall.surface=lumne: the mesh has no boundary `lumne`; it has `lumen`",
        ),
        ("mesh.wall.thickness=0", "--set mesh.wall.thickness=0: expected a number above 0"),
        (
            "mesh.wall.thickness=x",
            "--set mesh.wall.thickness=x: it is -0.5 at (-0.5, 0.86603, 2): expected a number",
        ),
        ("mesh.wall.thickness=1e-12", "expected a thickness [m] that is not lost beside the 2 m of the mesh"),
        ("mesh.wall.thickness=t", "it is that of the undeformed wall and cannot depend on t"),
        ("mesh.wall.layers=0", "mesh.wall.layers=0: expected an integer from 1 to 1000"),
        ("mesh.wall.thickness=none", "case.toml:4:1: mesh.wall.thickness: missing: the thickness [m]"),
        ("mesh.wall.depth=1", "unknown key; [mesh.wall] takes `surface`, `thickness`, `layers`"),
    ] {
        let built = case(SOLID, &[change])
            .and_then(|case| Simulation::in_space(case, 1).map(drop).map_err(|e| e.to_string()));
        let message = built.expect_err(change);
        assert!(message.contains(expected), "{change}: {message}");
    }
    // A name that is misspelt is the one mistake: the region is not called unused.
    let wrong = case(SOLID, &["solid.region=wal"]).unwrap();
    let message = Simulation::in_space(wrong, 1).err().unwrap().to_string();
    assert!(
        message.ends_with("the mesh has no region `wal`; did you mean `wall`? There are `fluid`, `wall`"),
        "{message}"
    );
    // Without [fluid] its sides are free of traction unless it is left out by name.
    let absent = case(&SOLID.replace("leave-out = [\"fluid\"]", ""), &[]).unwrap();
    let message = Simulation::in_space(absent, 1).err().unwrap().to_string();
    assert!(
        message.contains("`lumen` is a part of the interface with region `fluid`, which is left out"),
        "{message}"
    );
    let plane = SOLID.replace("file = \"lumen_2.msh\"", "generator = \"cook\"");
    let message = case(&plane, &[]).unwrap_err();
    assert!(message.contains("only for meshes of space: this one is of the plane"), "{message}");
}

const WAVE: &str = r#"
[fluid]
density = 1
kinematic-viscosity = 0.01
[solid]
density = 1.2
law = "linear"
young = 100
poisson = 0.3
[boundary.inflow]
condition = "pressure"
pressure = 1
[boundary.outflow]
condition = "do-nothing"
[functional.in]
kind = "flux"
on = ["inflow"]
[functional.out]
kind = "flux"
on = ["outflow"]
[time]
step = 0.05
end = 0.3
"#;
const GROWN: &str = r#"
[mesh]
file = "lumen_2.msh"
wall = { surface = "lumen", thickness = 0.2, layers = 1 }
[boundary.wall-inflow]
condition = "clamped"
[boundary.wall-outflow]
condition = "clamped"
[boundary.outer]
condition = "traction-free"
"#;
const TUBE: &str = r#"
[mesh]
generator = "tube"
length = 2
radii = [1, 1.2]
cells = [3, 8, 1]
[boundary.clamp]
condition = "clamped"
[boundary.outside]
condition = "traction-free"
"#;

/// A pressure wave in the built-in tube, in its lumen with a grown wall, which are the same cells, and in that of Gmsh.
#[test]
fn a_wave_runs_through_a_grown_wall() {
    let mut lumen = tube([2.0, 1.0, 0.2], [3, 8, 1], 0).unwrap().restrict(&["fluid"]);
    lumen.boundaries.iter_mut().filter(|name| *name == "interface").for_each(|name| *name = "lumen".into());
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("lumen-of-tube.msh");
    std::fs::write(&file, write(&lumen)).unwrap();
    let hexahedra = format!("mesh.file={}", file.display());
    let flows = [
        (TUBE, &["solid.region=solid"][..]),
        (GROWN, &["solid.region=wall", &hexahedra]),
        (GROWN, &["solid.region=wall"]),
    ]
    .map(|(mesh, sets)| {
        let mut simulation = Simulation::in_space(case(&format!("{mesh}{WAVE}"), sets).unwrap(), 1).unwrap();
        let mut last = vec![];
        while !simulation.finished() {
            last = simulation.step().unwrap().values;
        }
        last
    });
    println!("{flows:?}");
    let off = |grown: &[f64], i: usize| (grown[i] / flows[0][i] - 1.0).abs();
    assert!(off(&flows[1], 0) < 1e-4 && off(&flows[1], 1) < 1e-4, "{flows:?}");
    // Other cells, as coarse as these.
    assert!(off(&flows[2], 0) < 0.06, "{flows:?}");
}
