//! Cases of an extruded plane: the solution of the plane is the discrete one, so that everything is that of the plane per
//! depth, to rounding.

use super::Place;
use std::collections::BTreeMap;

/// Iterations end at rounding, so that results do not depend on how they came there.
pub const TIGHT: [&str; 2] = ["newton.rate-max=0", "newton.tolerance=1e-11"];

const EXTRUDE: &str = "mesh.extrude={ depth = 0.1, layers = 1 }";
pub const TWO_LAYERS: &str = "mesh.extrude={ depth = 0.1, layers = 2 }";
const DEPTH: f64 = 0.1;

/// A flap in a short channel, 12 cells.
pub const FLAP: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1.2, 0.4]
cells = [6, 2]
[mesh.region]
solid = "min(min(x - 0.4, 0.6 - x), 0.2 - y)"
[fluid]
density = 1000
kinematic-viscosity = 1e-3
[solid]
density = 1500
mu = 2e3
lambda = 4e3
[boundary.left]
condition = "velocity"
velocity = ["6*y*(0.4 - y)*ramp(t, 0.02)", 0]
[boundary.right]
condition = "do-nothing"
[boundary.top]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
[time]
step = 0.01
end = 0.02
[functional.per-force]
kind = "force"
on = ["interface"]
component = "x"
[functional.ux]
kind = "displacement"
point = [0.6, 0.2]
component = "x"
[functional.uy]
kind = "displacement"
point = [0.6, 0.2]
component = "y"
[functional.per-flux]
kind = "flux"
on = ["right"]
"#;

/// Functionals of every kind; the names of those per depth begin with `per`.
pub const FUNCTIONALS: &str = r#"
[functional]
per-surface = { kind = "force", on = ["interface"], component = "y", method = "surface-integral" }
per-bottom = { kind = "force", on = ["bottom"], component = "y" }
coefficient = { kind = "force", on = ["interface"], component = "x", coefficient = [0.1, 0.3] }
per-moment = { kind = "moment", on = ["bottom"], point = [0.4, 0.1] }
rotation = { kind = "rotation" }
per-power = { kind = "power", on = ["interface"] }
per-kinetic = { kind = "energy", term = "fluid-kinetic" }
per-elastic = { kind = "energy", term = "elastic" }
per-dissipation = { kind = "energy", term = "dissipation" }
per-volume = { kind = "volume", region = "solid" }
pressure = { kind = "pressure", region = "fluid", take = "mean" }
per-load = { kind = "pressure", on = ["interface"], take = "integral" }
speed = { kind = "velocity", region = "fluid", component = "magnitude", take = "max" }
shear = { kind = "wall-shear-stress", on = ["top"], component = "magnitude", take = "mean" }
xy = { kind = "stress", point = [0.45, 0.05], component = "xy" }
zz = { kind = "stress", region = "solid", component = "zz", take = "max" }
mises = { kind = "stress", region = "solid", component = "von-mises", take = "max" }
per-rate = { kind = "balance", region = "solid", part = "rate" }
per-carried = { kind = "balance", region = "fluid", part = "carried" }
per-boundaries = { kind = "balance", region = "fluid", part = "boundaries" }
"#;

pub type Row = BTreeMap<String, f64>;

impl Place {
    /// The rows that `case` with `sets` leaves.
    pub fn rows(&self, case: &str, sets: &[&str]) -> Vec<Row> {
        self.run(&format!("run {case} --threads 1 --quiet --force -o out"), sets).expect(0, &[]);
        self.rows_of("out")
    }

    /// The rows of the run in `directory`.
    pub fn rows_of(&self, directory: &str) -> Vec<Row> {
        let text = self.read(&format!("{directory}/history.csv"));
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let names = lines.next().unwrap();
        let row = |values: Vec<&str>| {
            names.iter().zip(values).map(|(name, value)| (name.to_string(), value.parse().unwrap())).collect()
        };
        lines.map(row).collect()
    }

    /// Asserts that `case` is in space what it is in the plane: each number up to 1e-9 of its largest value, 1e-14 of one
    /// that is 0, those whose names begin as in `per` by depth, and at most one iteration of Newton's method more or less.
    #[track_caller]
    fn is_of_the_plane(&self, case: &str, (sets, plane, space): (&[&str], &[&str], &[&str]), per: &[&str]) {
        let all = |own: &[&str]| self.rows(case, &[&TIGHT, sets, own].concat());
        let (plane, space) = (all(plane), all(space));
        assert_eq!(plane.len(), space.len());
        let counts = ["step", "jacobians", "linear_iterations"];
        for name in plane[0].keys().filter(|name| !counts.contains(&name.as_str())) {
            let depth = if per.iter().any(|start| name.starts_with(start)) { DEPTH } else { 1.0 };
            let largest = plane.iter().map(|row| row[name].abs()).fold(1e-5, f64::max);
            for (one, other) in plane.iter().zip(&space) {
                let gap = (one[name] - other[name] / depth).abs();
                let allowed = if name == "newton_steps" { 1.0 } else { 1e-9 * largest };
                assert!(gap <= allowed, "{name}: {} and {} by {depth}; {sets:?}", one[name], other[name]);
            }
        }
    }
}

fn flap(name: &str) -> Place {
    let here = Place::new(name);
    here.write("flap.toml", &format!("{FLAP}{FUNCTIONALS}"));
    here
}

/// Settings of a case, the same in the plane and in space.
fn both<'a>(sets: &'a [&'a str]) -> (&'a [&'a str], &'a [&'a str], &'a [&'a str]) {
    (sets, &[], &[EXTRUDE])
}

#[test]
#[ignore = "long"]
fn extruded_benchmarks_are_those_of_the_plane() {
    let here = Place::new("space-benchmarks");
    let coarse = ["mesh.refine=0", "mesh.grading=0"];
    here.is_of_the_plane("fsi1", both(&coarse), &["drag", "lift"]);
    here.is_of_the_plane("dfg-2d1", both(&coarse), &[]);
    let two_steps = ["mesh.refine=0", "time.step=0.01", "time.end=0.02"];
    here.is_of_the_plane("csm3", both(&two_steps), &[]);
}

#[test]
#[ignore = "long"]
fn extruded_steps_of_every_scheme_are_those_of_the_plane() {
    let here = flap("space-schemes");
    for sets in [
        &["time.scheme=theta", "time.theta=0.6", "newton.linearization=newton", "motion.model=harmonic"][..],
        &["time.scheme=bdf2", "newton.linearization=reduced", "motion.model=jacobian-stiffened"],
        &["time.scheme=fractional-step-theta", "newton.linearization=fixed-point", "newton.max-steps=60"],
        &["time.scheme=cg1", "motion.model=biharmonic", "linear.precision=double"],
        &["time.scheme=backward-euler", "space.pressure=Q1", "motion.model=stiffened-harmonic"],
        &["motion.walls=sliding", "solid.viscosity=10", "solid.damping-stiffness=0.01"],
        &["space.velocity=Q3", "space.pressure=P2dc", "time.end=0.01"],
        &["linear.krylov=gmres", "fluid.body-force=[\"x*y\", \"-9.81*x\"]", "fluid.body-force-at=current"],
    ] {
        let off = sets.iter().any(|set| set.ends_with("bdf2") || set.ends_with("theta"));
        let balance =
            ["functional.per-rate=none", "functional.per-carried=none", "functional.per-boundaries=none"];
        let sets = [sets, if off { &balance } else { &[] }].concat();
        here.is_of_the_plane("flap.toml", both(&sets), &["per"]);
    }
}

#[test]
fn extruded_stabilised_steps_are_those_of_the_plane_on_cubes() {
    let here = Place::new("space-stabilised");
    here.write("flap.toml", FLAP);
    // The size of a cell is that of the plane, and F does not change it.
    let cubes = ["mesh.extrude={ depth = 0.2, layers = 1 }"];
    for how in ["lps", "pspg"] {
        let pressure = format!("stabilization.pressure={how}");
        let sets = ["space.velocity=Q1", &pressure, "stabilization.map=none"];
        let all = |own: &[&str]| here.rows("flap.toml", &[&TIGHT[..], &sets, own].concat());
        let (plane, space) = (all(&[]), all(&cubes));
        let [one, other] = [&plane, &space].map(|rows| rows.last().unwrap());
        assert!((one["per-force"] - other["per-force"] / 0.2).abs() < 1e-9 * one["per-force"].abs());
        assert!((one["ux"] - other["ux"]).abs() < 1e-9 * one["ux"].abs());
    }
}

#[test]
fn extruded_conditions_are_those_of_the_plane() {
    let here = flap("space-conditions");
    let resistance = |r: f64| {
        format!("boundary.right={{ condition = \"resistance\", resistance = {r}, pressure = \"t\" }}")
    };
    let windkessel = |r: f64, c: f64| {
        format!(
            "boundary.right={{ condition = \"windkessel\", proximal = {r}, capacitance = {c}, distal = {}, initial = 3 }}",
            2.0 * r
        )
    };
    let flux = |q: f64, profile: &str| {
        format!("boundary.left={{ condition = \"flux\", flow-rate = \"{q}*t\", profile = \"{profile}\" }}")
    };
    let womersley = |q: f64| {
        format!(
            "boundary.left={{ condition = \"flux\", profile = \"womersley\", period = 0.1, \
             fourier = [[{q}, 0], [{}, {}]] }}",
            -q,
            -0.5 * q
        )
    };
    let pressure = "boundary.left={ condition = \"pressure\", pressure = \"100*t*(1 + y)\" }";
    let own = |condition: String| vec![condition, EXTRUDE.to_string()];
    for (sets, plane, space) in [
        (vec![pressure], windkessel(100.0, 1e-4), own(windkessel(1000.0, 1e-5))),
        (vec![], flux(-0.02, "free"), own(flux(-0.002, "free"))),
        (vec!["boundary.top.condition=slip"], resistance(200.0), own(resistance(2000.0))),
        (
            vec!["boundary.right.condition=traction-free"],
            flux(-0.02, "parabolic"),
            own(flux(-0.002, "parabolic")),
        ),
        (
            vec!["boundary.top={ condition = \"displacement\", displacement = [0, \"0.5*t*x*(1.2 - x)\"] }"],
            womersley(-0.02),
            own(womersley(-0.002)),
        ),
    ] {
        let space: Vec<&str> = space.iter().map(String::as_str).collect();
        here.is_of_the_plane("flap.toml", (&sets, &[&plane], &space), &["per"]);
    }
    let sides = "boundary.front={ condition = \"periodic\", with = \"back\" }";
    let no_moment = "functional.per-moment=none";
    here.is_of_the_plane("flap.toml", (&[no_moment], &[], &[TWO_LAYERS, sides]), &["per"]);
}

/// A bar that is held at its left end.
const BAR: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 0.2]
cells = [4, 1]
region = { solid = "1" }
[solid]
density = 1500
mu = 2e4
lambda = 4e4
body-force = ["x", -0.3]
[boundary]
left = { condition = "clamped" }
right = { condition = "traction", traction = [10, "-5*y"] }
top = { condition = "pressure", pressure = "50*x" }
bottom = { condition = "spring", stiffness = "1e4*(1 + x)", damping = 30, pressure = 4 }
[time]
step = 0.01
end = 0.02
[functional]
ux = { kind = "displacement", point = [1, 0.1], component = "x" }
uy = { kind = "displacement", point = [1, 0.1], component = "y" }
per-stored = { kind = "energy", term = "elastic" }
zz = { kind = "stress", region = "solid", component = "zz", take = "max" }
"#;

#[test]
fn extruded_solids_are_those_of_the_plane() {
    let here = Place::new("space-solids");
    here.write("bar.toml", BAR);
    let fibres = [
        "solid.k1=1e4",
        "solid.k2=2",
        "solid.fibre-angle=\"30 deg\"",
        "solid.fibre-direction=[\"-y\", \"x + 1\"]",
    ];
    let muscle = [
        "solid.mu=none",
        "solid.lambda=none",
        "solid.guccione-c=8e3",
        "solid.b-f=8",
        "solid.b-t=2",
        "solid.b-fs=4",
    ];
    let ogden = ["solid.mu=none", "solid.ogden-mu=[2e4, 100]", "solid.ogden-alpha=[1.3, 5]"];
    for (law, sets) in [
        ("linear", &["initial.static=true"][..]),
        ("neo-hookean", &["time=none", "boundary.bottom.direction=normal"]),
        ("mooney-rivlin", &["solid.c2=3e3", "initial.displacement=[\"0.01*x\", \"-0.05*x^2\"]"]),
        ("incompressible-neo-hookean", &["solid.lambda=none"]),
        ("ogden", &ogden),
        ("holzapfel-gasser-ogden", &fibres),
        ("guccione", &muscle),
        ("st-venant-kirchhoff", &["solid.prestress=true"]),
    ] {
        let law = format!("solid.law={law}");
        here.is_of_the_plane("bar.toml", both(&[&[&law[..]], sets].concat()), &["per"]);
    }
}

#[test]
fn pressure_at_points_is_that_of_the_plane_on_any_layers() {
    let here = Place::new("space-pressure");
    here.write("flap.toml", FLAP);
    // On one layer nothing tells z² from a constant.
    let sets = [
        "functional.p={ kind = \"pressure\", point = [0.8, 0.17] }",
        "functional.difference={ kind = \"pressure-difference\", a = [0.2, 0.2], b = [1, 0.2] }",
    ];
    for layers in [EXTRUDE, TWO_LAYERS] {
        here.is_of_the_plane("flap.toml", (&sets, &[], &[layers]), &["per"]);
    }
}

#[test]
fn runs_in_space_go_on_with_the_same_bits() {
    let here = Place::new("space-resume");
    here.write("flap.toml", FLAP);
    let every = ["output.checkpoint-every=1", TWO_LAYERS];
    let run = |rest: &str, end: &str| {
        here.run(&format!("run flap.toml --quiet -o {rest}"), &[&every[..], &[end]].concat()).expect(0, &[]);
    };
    run("whole --threads 1", "time.end=0.03");
    run("parts --threads 2", "time.end=0.02");
    here.run("run flap.toml -o parts --resume", &[every[0], EXTRUDE, "time.end=0.03"])
        .expect(2, &["mesh.extrude.layers was 2, now 1"]);
    run("parts --threads 2 --resume", "time.end=0.03");
    for file in ["history.csv", "fields/fields_000003.vtu"] {
        let found =
            ["whole", "parts"].map(|directory| std::fs::read(here.file(directory).join(file)).unwrap());
        assert!(found[0] == found[1], "{file}");
    }
    here.run("run flap.toml --quiet -o plane", &[]).expect(0, &[]);
    here.run("compare whole plane", &[]).expect(0, &["different units: per-flux in m³/s and m²/s", "ux"]);
    here.run("run flap.toml -o other", &["initial.from=\"whole\"", "time.end=0.1"])
        .expect(2, &["the mesh is one of space, and this is for meshes of the plane"]);
}

#[test]
fn jacobians_agree_in_space() {
    let here = Place::new("space-jacobian");
    here.write("flap.toml", FLAP);
    for sets in [
        &["motion.model=jacobian-stiffened"][..],
        &["time.scheme=cg1", "solid.law=incompressible-neo-hookean", "solid.lambda=none"],
    ] {
        let sets = [sets, &[EXTRUDE]].concat();
        let said = here.run("check flap.toml --jacobian", &sets).expect(0, &["all Jacobians agree"]);
        for block in ["NS x u", "NS+ES x v", "ES x u", "div x v", "ALE x u", "uv x v"] {
            assert!(said.out.contains(block), "{block}: {}", said.out);
        }
    }
}

/// The unit cube, bent inside, with the solid in its lower half.
const CUBE: &str = r#"
[mesh]
file = "cube.msh"
[fluid]
density = 1.3
kinematic-viscosity = 0.4
[solid]
density = 2.1
mu = 3
lambda = 4
[boundary]
left = { condition = "velocity", velocity = ["max(y - 0.5, 0)", "0.1*z*max(y - 0.5, 0)", "t*max(y - 0.5, 0)"] }
right = { condition = "no-slip" }
bottom = { condition = "spring", stiffness = "2 + x", damping = 0.3 }
top = { condition = "do-nothing", backflow = "directional" }
front = { condition = "no-slip" }
back = { condition = "pressure", pressure = "1 + x*y" }
[time]
step = 0.01
end = 0.02
"#;

/// Against differences of the assembled residual, on curved cells, with terms of every kind.
#[test]
fn jacobians_agree_on_curved_hexahedra() {
    let here = Place::new("space-jacobian-curved");
    let mut mesh = undula::mesh::generate::hexahedra([0.0; 3], [1.0; 3], [2, 2, 2], 0).unwrap();
    mesh.assign_region("solid", |[_, y, _]| 0.5 - y).unwrap();
    for node in &mut mesh.nodes {
        let bump: f64 = node.iter().map(|x| (std::f64::consts::PI * x).sin()).product();
        *node = std::array::from_fn(|d| node[d] + [0.08, -0.06, 0.05][d] * bump);
    }
    here.write("cube.msh", &undula::mesh::gmsh::write(&mesh));
    here.write("cube.toml", CUBE);
    for sets in [
        &["motion.model=biharmonic", "solid.law=neo-hookean"][..],
        &["space.pressure=Q1", "motion.model=jacobian-stiffened", "solid.law=mooney-rivlin", "solid.c2=0.3"],
        &["space.velocity=Q1", "stabilization.pressure=pspg", "stabilization.transport=supg"],
    ] {
        let said = here.run("check cube.toml --jacobian", sets).expect(0, &["all Jacobians agree"]);
        assert!(said.out.contains("whole residual, central"), "{}", said.out);
    }
}

/// With periodic sides modes of the plane are modes of space, and no other is less stable: the same constants on any layers.
#[test]
fn inf_sup_constants_of_an_extruded_plane_are_those_of_the_plane() {
    let here = Place::new("space-inf-sup");
    here.write("flap.toml", FLAP);
    let sides = "boundary.front={ condition = \"periodic\", with = \"back\" }";
    for pressure in ["space.pressure=P1dc", "space.pressure=Q1"] {
        let found = [&[][..], &[EXTRUDE, sides], &[TWO_LAYERS, sides]].map(|own| {
            let sets = [&["solid=none", "functional=none", pressure], own].concat();
            let said = here.run("check flap.toml --inf-sup", &sets).expect(0, &["(5.25)"]);
            let line = said.out.lines().find(|line| line.contains("(5.25)")).unwrap().to_string();
            line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
        });
        assert!(found[0] > 0.05, "{found:?}");
        assert!(found.iter().all(|x| (x / found[0] - 1.0).abs() < 1e-4), "{found:?}");
    }
}
