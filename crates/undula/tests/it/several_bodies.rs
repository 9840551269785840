//! Several solids and several fluids in one case, against closed forms and against one body with the same values.

use crate::common::{sets, wrong};
use undula::case::Case;
use undula::math::Tensor;
use undula::modes::of_case;
use undula::physics::Material;
use undula::physics::SolidLaw;
use undula::simulation::{Row, Simulation};

/// A bar (0, 3) × (0, 1) m between planes of symmetry, drawn at its right end: `soft` in x < 1, `hard` beyond.
const BAR: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [3, 1]
cells = [6, 2]
region = { soft = "x < 1", hard = "x > 1" }
[solid.soft]
law = "st-venant-kirchhoff"
density = 1
mu = 2
lambda = 3
[solid.hard]
law = "neo-hookean"
density = 2
mu = 30
lambda = 50
[boundary.left]
condition = "symmetry"
[boundary.bottom]
condition = "symmetry"
[boundary.top]
condition = "symmetry"
[boundary.right]
condition = "traction"
traction = [1.5, 0]
[functional.end]
kind = "displacement"
point = [3, 0.5]
component = "x"
[functional.bond]
kind = "displacement"
point = [1, 0.5]
component = "x"
[functional.energy]
kind = "energy"
term = "elastic"
[functional.soft]
kind = "volume"
region = "soft"
[functional.hard]
kind = "volume"
region = "hard"
[functional.across]
kind = "stress"
point = [1, 0.5]
region = "hard"
component = "yy"
[newton]
tolerance = 1e-13
"#;

fn finished(text: &str, overrides: &[&str]) -> Simulation {
    finished_on(text, overrides, 1)
}

fn finished_on(text: &str, overrides: &[&str], threads: usize) -> Simulation {
    let case = Case::from_toml(text, "own.toml", &sets(overrides)).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = Simulation::new(case, threads).unwrap_or_else(|e| panic!("{e}"));
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    simulation
}

fn last(simulation: &Simulation) -> &Row {
    simulation.history.last().unwrap()
}

fn stretch(e: f64) -> Tensor<f64, 2> {
    Tensor([[e, 0.0], [0.0, 0.0]])
}

/// The elongation at which a law that is kept from moving across has the stress `p`, by bisection.
fn elongation(material: &Material, p: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let e = 0.5 * (low + high);
        if material.stress::<2>(&stretch(e)).0[0][0] < p { low = e } else { high = e }
    }
    0.5 * (low + high)
}

/// Springs in series: P₁₁ = 1.5 Pa in both, u, volumes and energies of each law.
#[test]
fn a_bar_of_two_laws_is_two_springs_in_series() {
    let soft = SolidLaw::StVenantKirchhoff.material(2.0, 3.0, 0.0);
    let hard = SolidLaw::NeoHookean.material(30.0, 50.0, 0.0);
    let [e1, e2] = [&soft, &hard].map(|law| elongation(law, 1.5));
    for threads in [1, 2] {
        let simulation = finished_on(BAR, &[], threads);
        let row = last(&simulation);
        let energy = soft.energy(&stretch(e1)) + 2.0 * hard.energy(&stretch(e2));
        let piola = hard.stress::<2>(&stretch(e2)).0[1][1];
        println!("{row:?}, {e1} {e2} {energy} {piola}");
        for (name, right) in [
            ("bond", e1),
            ("end", e1 + 2.0 * e2),
            ("energy", energy),
            ("soft", 1.0 + e1),
            ("hard", 2.0 * (1.0 + e2)),
            // σ_yy = P_yy / (1 + e).
            ("across", piola / (1.0 + e2)),
        ] {
            assert!((row[name] - right).abs() < 1e-9 * right.abs(), "{name}: {} {right}", row[name]);
        }
    }
}

/// A part that keeps its volume cannot be drawn between planes of symmetry: the other one gives way.
#[test]
fn a_compressible_and_an_incompressible_solid_are_bonded() {
    let soft = SolidLaw::StVenantKirchhoff.material(2.0, 3.0, 0.0);
    let e = elongation(&soft, 1.5);
    for pressure in ["space.pressure=P1dc", "space.pressure=Q1"] {
        let set = ["solid.hard.law=incompressible-neo-hookean", "solid.hard.lambda=none", pressure];
        let simulation = finished(BAR, &set);
        let row = last(&simulation);
        assert!((row["bond"] - e).abs() < 1e-9 && (row["end"] - e).abs() < 1e-9, "{pressure}: {row:?}");
        assert!((row["hard"] - 2.0).abs() < 1e-9, "{row:?}");
    }
}

/// The layered beam of `modes` and its deflection under its weight: B = Σ E_i I_i, m = Σ ρ_i h_i.
const BEAM: &str = r#"
[mesh]
generator = "box"
lower = [0, -0.2]
upper = [8, 0.2]
cells = [80, 4]
region = { core = "0.1 - abs(y)", upper = "y - 0.1", lower = "-0.1 - y" }
[solid.core]
law = "linear"
density = 3
young = 1e6
poisson = 0
body-force = [0, -1e-3]
[solid.skin]
region = ["upper", "lower"]
law = "linear"
density = 1
young = 5e6
poisson = 0
body-force = [0, -1e-3]
[boundary.left]
condition = "clamped"
[boundary.right]
condition = "traction-free"
[boundary.top]
condition = "traction-free"
[boundary.bottom]
condition = "traction-free"
[functional.tip]
kind = "displacement"
point = [8, 0]
component = "y"
"#;

/// Euler and Bernoulli's beam, whose deviation is that of shear, of the order (h/L)² = 0.0025.
#[test]
fn a_layered_beam_bends_and_vibrates_by_its_composite_stiffness() {
    let (inner, outer) = (0.2f64.powi(3) / 12.0, 0.4f64.powi(3) / 12.0);
    let stiffness = 1e6 * inner + 5e6 * (outer - inner);
    let mass = 3.0 * 0.2 + 1.0 * 0.2;
    let deflection = -1e-3 * mass * 8f64.powi(4) / (8.0 * stiffness);
    let tip = last(&finished(BEAM, &[]))["tip"];
    let case = Case::from_toml(BEAM, "beam.toml", &[]).unwrap();
    let frequency = of_case(&case, 1, 1).unwrap().1.vacuum[0].frequency;
    let expected = 1.875_104f64.powi(2) / 64.0 * (stiffness / mass).sqrt() / (2.0 * std::f64::consts::PI);
    println!("{} {}", tip / deflection, frequency / expected);
    assert!((tip / deflection - 1.0).abs() < 0.01, "{tip} {deflection}");
    assert!((frequency / expected - 1.0).abs() < 0.01, "{frequency} {expected}");
}

/// A channel over an elastic wall of a lower and an upper layer, in time.
const WALL: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [2, 1]
cells = [8, 8]
region = { lower = "y < 0.25", upper = "(y > 0.25)*(y < 0.5)", fluid = "y > 0.5" }
[fluid]
density = 1
kinematic-viscosity = 0.1
[boundary.left]
condition = "velocity"
velocity = ["(y > 0.5)*(y - 0.5)*(1 - y)*t", 0]
[boundary.right]
condition = "do-nothing"
[boundary.top]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
[functional.force]
kind = "force"
on = ["interface"]
component = "y"
[functional.middle]
kind = "displacement"
point = [1, 0.5]
component = "y"
[functional.elastic]
kind = "energy"
term = "elastic"
[functional.kinetic]
kind = "energy"
term = "solid-kinetic"
"#;
const IN_TIME: &str = "[time]\nstep = 0.05\nend = 0.5\n";
const VALUES: &str = "density = 2\nmu = 5\nlambda = 5\nbody-force = [0, \"sin(3*x)\"]\n";

fn together() -> String {
    format!("{WALL}[solid]\nregion = [\"lower\", \"upper\"]\n{VALUES}")
}

fn apart() -> String {
    format!("{WALL}[solid.lower]\n{VALUES}[solid.upper]\n{VALUES}")
}

/// One region of both layers, the same under one table, and two tables: cells are numbered from below, so that sums over
/// them have one order.
#[test]
fn two_solids_of_the_same_values_are_one_bit_for_bit() {
    let whole = WALL.replace("lower = \"y < 0.25\", upper = \"(y > 0.25)*(y < 0.5)\"", "solid = \"y < 0.5\"");
    assert_ne!(whole, WALL);
    for [more, set] in [
        [IN_TIME, "newton.linearization=condensed"],
        [IN_TIME, "newton.linearization=newton"],
        ["[time]\nscheme = \"stationary\"\nend = 1\n", "newton.tolerance=1e-10"],
    ] {
        let one = finished(&format!("{whole}[solid]\n{VALUES}{more}"), &[set]);
        for text in [together(), apart()] {
            for threads in [1, 2] {
                let other = finished_on(&format!("{text}{more}"), &[set], threads);
                assert_eq!(one.history, other.history, "{set} {text}");
            }
        }
        assert!(last(&one)["middle"].abs() > 1e-4);
    }
}

/// Field files number the bodies, fluids first; one fluid and one solid are told by `solid`.
#[test]
fn field_files_have_the_number_of_the_body() {
    let cells = |text: &str| {
        let case = Case::from_toml(&format!("{text}{IN_TIME}"), "own.toml", &[]).unwrap();
        let simulation = Simulation::new(case, 1).unwrap();
        let (space, state) = (&simulation.stepper.assembler.space, &simulation.stepper.new);
        let snapshot = undula::run::snapshot(space, state, true);
        snapshot.in_cells("material").map(|field| field.values.clone())
    };
    assert_eq!(cells(&together()), None);
    let numbers = cells(&apart()).unwrap();
    let count = |number: f64| numbers.iter().filter(|n| **n == number).count();
    assert_eq!([0.0, 1.0, 2.0].map(count), [32, 16, 16]);
}

/// Layers of other values: no bit depends on the number of threads, `--set` reaches one of them, and `case.toml` is the
/// same case.
#[test]
fn several_solids_are_written_and_set_by_name() {
    let text = format!("{}{IN_TIME}", apart());
    let set = ["solid.upper.mu=50", "solid.lower.law=neo-hookean", "solid.lower.body-force=none"];
    let [one, two] = [1, 2].map(|threads| finished_on(&text, &set, threads));
    assert_eq!(one.history, two.history);
    let softer = finished(&text, &[]);
    assert_ne!(last(&one)["middle"], last(&softer)["middle"]);
    let case = Case::from_toml(&text, "own.toml", &sets(&set)).unwrap();
    assert_eq!(case.solids[1].mu, 50.0);
    let written = case.to_toml();
    assert!(written.contains("[solid.upper]\nregion = \"upper\""), "{written}");
    assert_eq!(Case::from_toml(&written, "case.toml", &[]).unwrap(), case);
    let several = Case::from_toml(&format!("{}{IN_TIME}", together()), "own.toml", &[]).unwrap();
    assert_eq!(Case::from_toml(&several.to_toml(), "case.toml", &[]).unwrap(), several);
}

/// Two fluids side by side may touch each other if they flow alike; both have the extension.
#[test]
fn two_fluids_of_the_same_values_are_one() {
    let split =
        WALL.replace("fluid = \"y > 0.5\"", "near = \"(y > 0.5)*(x < 1)\", far = \"(y > 0.5)*(x > 1)\"");
    let values = "density = 1\nkinematic-viscosity = 0.1\n";
    let apart = split.replace("[fluid]\n", &format!("[fluid.near]\n{values}[fluid.far]\n"));
    let together = split.replace("[fluid]\n", "[fluid]\nregion = [\"near\", \"far\"]\n");
    let solid = format!("[solid]\nregion = [\"lower\", \"upper\"]\n{VALUES}{IN_TIME}");
    for set in ["newton.linearization=condensed", "newton.linearization=newton"] {
        let set = [set, "newton.tolerance=1e-11"];
        let one = finished(&format!("{WALL}{solid}"), &set);
        assert_eq!(one.history, finished(&format!("{together}{solid}"), &set).history);
        let two = finished(&format!("{apart}{solid}"), &set);
        for (one, two) in one.history.iter().zip(&two.history) {
            for (a, b) in one.values.iter().zip(&two.values) {
                assert!((a - b).abs() < 1e-9 * a.abs().max(1e-6), "{set:?}: {one:?} {two:?}");
            }
        }
    }
}

/// Two chambers with a stiff wall between them: the pressure at the bottom is ρ g h of each fluid.
const CHAMBERS: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [3, 1]
cells = [6, 4]
region = { oil = "x < 1", wall = "(x > 1)*(x < 2)", water = "x > 2" }
[fluid.oil]
density = 800
kinematic-viscosity = 1e-4
body-force = [0, -10]
[fluid.water]
density = 1000
kinematic-viscosity = 1e-6
body-force = [0, -10]
[solid]
region = "wall"
density = 1000
mu = 1e12
lambda = 1e12
[boundary.left]
condition = "no-slip"
[boundary.right]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
[boundary.top]
condition = "do-nothing"
[functional.oil]
kind = "pressure"
point = [0.5, 0.25]
[functional.water]
kind = "pressure"
point = [2.5, 0.25]
[functional.push]
kind = "force"
on = ["interface"]
component = "x"
"#;

/// The force on the wall is that of both sides: (ρ₁ − ρ₂) g h²/2 to the right.
#[test]
fn two_fluids_behind_a_wall_have_pressures_of_their_own() {
    let simulation = finished(CHAMBERS, &["newton.tolerance=1e-12"]);
    let row = last(&simulation);
    for (name, right) in [("oil", 6000.0), ("water", 7500.0), ("push", -1000.0)] {
        assert!((row[name] - right).abs() < 1e-7 * right.abs(), "{name}: {row:?}");
    }
}

/// What is not a case: how it is told.
#[test]
fn tables_of_bodies_are_checked() {
    let told = |from: &str, to: &str, expected: &str| {
        assert!(BAR.contains(from), "{from}");
        let message = wrong(&BAR.replace(from, to), &[]);
        assert!(message.contains(expected), "{message}");
    };
    told("[solid.hard]", "[solid.hard]\nregion = \"soft\"", "[solid.soft] fills the region `soft` already");
    told("[solid.soft]", "[solid]\ndensity = 1\n[solid.soft]", "solid.density = 1: [solid] has tables");
    told("[solid.hard]\nlaw", "[solid.hard]\nregion = [\"hard\", \"hard\"]\nlaw", "`hard` is there twice");
    told("density = 2", "densty = 2", "solid.hard.densty");
    let both = format!("{BAR}[fluid]\nregion = \"hard\"\ndensity = 1\nkinematic-viscosity = 1\n");
    assert!(wrong(&both, &[]).contains("solid.hard.region: the fluid fills the region `hard` already"));
    let array = BAR.replace("[solid.soft]", "[[solid]]").replace("[solid.hard]", "[[solid]]");
    let message = wrong(&array, &[]);
    assert!(message.contains("write [solid.NAME] for [[solid]]"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");

    let refused = |text: &str, overrides: &[&str]| match Case::from_toml(text, "own.toml", &sets(overrides)) {
        Ok(case) => match Simulation::new(case, 1) {
            Ok(_) => panic!("should be refused: {text} {overrides:?}"),
            Err(error) => error.to_string(),
        },
        Err(error) => error.to_string(),
    };
    let message = refused(BAR, &["solid.hard.region=beam"]);
    assert!(message.contains("solid.hard.region=beam: the mesh has no region `beam`"), "{message}");
    let message = refused(BAR, &["solid.hard=none"]);
    assert!(message.contains("region `hard` of the mesh is used by no table"), "{message}");
    let message = refused(CHAMBERS, &["fluid.oil.region=wall", "solid.region=oil"]);
    assert!(message.contains("[fluid.water] touches [fluid.oil] of another density"), "{message}");
    let message = refused(CHAMBERS, &["space.velocity=Q1"]);
    assert!(message.contains("stabilisation is for one fluid"), "{message}");
}

/// A name that the mesh has between two solids needs no condition, and holds neither of them.
#[test]
fn a_bond_with_a_name_is_no_support() {
    let mut mesh = undula::mesh::generate::rectangle([0.0; 2], [3.0, 1.0], [6, 2], 0).unwrap();
    for (name, right) in [("soft", false), ("hard", true)] {
        mesh.assign_region(name, |x| if (x[0] > 1.0) == right { 1.0 } else { -1.0 }).unwrap();
    }
    mesh.boundaries.push("bond".into());
    let boundary = mesh.boundaries.len() as u16 - 1;
    let on_bond = |side: &undula::mesh::Side| {
        let nodes = mesh.facet_nodes(side.cell as usize, side.local as usize);
        nodes.iter().all(|&n| mesh.nodes[n as usize][0] == 1.0)
    };
    let inner = mesh.facets_of_cells().inner;
    let facets: Vec<_> = inner.iter().map(|pair| pair[0]).filter(on_bond).collect();
    assert_eq!(facets.len(), 2);
    mesh.facets.extend(facets.into_iter().map(|side| side.named(boundary)));
    let (start, end) = (BAR.find("[mesh]").unwrap(), BAR.find("[solid.soft]").unwrap());
    let text = BAR.replace(&BAR[start..end], "");
    let file = std::env::temp_dir().join(format!("undula-bond-{}.toml", std::process::id()));
    std::fs::write(&file, text).unwrap();
    let named = |set: &[(&str, &str)]| {
        let case = undula::CaseBuilder::load(file.to_str().unwrap()).unwrap().mesh(mesh.clone());
        let case = set.iter().fold(case, |case, (key, value)| case.set(key, *value)).build().unwrap();
        Simulation::new(case, 1)
    };
    let mut simulation = named(&[]).unwrap();
    let end = simulation.step().unwrap()["end"];
    assert!((end - last(&finished(BAR, &[]))["end"]).abs() < 1e-10, "{end}");
    let free = ["left", "bottom", "top"].map(|name| format!("boundary.{name}.condition"));
    let free = free.each_ref().map(|key| (key.as_str(), "traction-free"));
    let error = named(&free[..1]).err().unwrap().to_string();
    assert!(error.contains("nothing holds the solid against moving along (1, 0)"), "{error}");
    let error = named(&free).err().unwrap().to_string();
    assert!(error.contains("nothing holds the part of the solid in"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    std::fs::remove_file(file).unwrap();
}
