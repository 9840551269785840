//! Bodies of revolution in (r, z), against closed forms and against the plane.

use crate::common::{SCHEMES, builtin, sets, wrong, wrong_builtin};
use std::f64::consts::PI;
use undula::CaseBuilder;
use undula::case::Case;
use undula::math::Tensor;
use undula::physics::SolidLaw;
use undula::simulation::{Row, Simulation};
use undula::verification::jacobians::{At, compare};

fn finish(simulation: &mut Simulation) -> Row {
    let mut row = simulation.step().unwrap();
    while !simulation.finished() {
        row = simulation.step().unwrap();
    }
    row
}

fn case(text: &str, more: &[&str]) -> Case {
    Case::from_toml(text, "round.toml", &sets(more)).unwrap_or_else(|e| panic!("{more:?}\n{e}"))
}

/// A pipe of radius 1 m and length 4 m, ρ = 2, ν = 0.05, from 3.2 Pa to 0: v_z = Δp (R² − r²)/(4 μ L).
const PIPE: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 4]
cells = [2, 4]
coordinates = "axisymmetric"
[fluid]
density = 2
kinematic-viscosity = 0.05
[boundary.left]
condition = "symmetry"
[boundary.right]
condition = "no-slip"
[boundary.bottom]
condition = "pressure"
pressure = 10.2
[boundary.top]
condition = "pressure"
pressure = 7
[newton]
tolerance = 1e-12
[functional.flow]
kind = "flux"
on = ["top"]
[functional.wall]
kind = "force"
on = ["right"]
component = "y"
[functional.wall_by_surface]
kind = "force"
on = ["right"]
component = "y"
method = "surface-integral"
[functional.heat]
kind = "energy"
term = "dissipation"
[functional.kinetic]
kind = "energy"
term = "fluid-kinetic"
[functional.shear]
kind = "wall-shear-stress"
on = ["right"]
component = "magnitude"
take = "mean"
[functional.volume]
kind = "volume"
region = "fluid"
[functional.on_axis]
kind = "velocity"
on = ["left"]
component = "y"
take = "mean"
[functional.hoop]
kind = "stress"
region = "fluid"
component = "zz"
take = "mean"
[functional.mean_p]
kind = "pressure"
region = "fluid"
take = "mean"
"#;

#[test]
fn poiseuille_in_a_pipe_is_exact() {
    let elements: [&[&str]; 4] = [
        &[],
        &["space.velocity=Q3", "space.pressure=P2dc"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["space.pressure=Q1", "boundary.bottom.at=reference"],
    ];
    // Δp π R⁴/(8 μ L) with μ = 0.1.
    let q = 3.2 * PI / (8.0 * 0.1 * 4.0);
    for more in elements {
        let mut simulation = Simulation::new(case(PIPE, more), 1).unwrap();
        let row = simulation.step().unwrap();
        let fields = simulation.fields();
        for (x, v) in fields.coordinates().iter().zip(fields.velocity()) {
            let gap = (v[1] - 2.0 * (1.0 - x[0] * x[0])).abs().max(v[0].abs());
            // Rows near the axis weigh little.
            assert!(gap < 1e-9, "{more:?}: {v:?} at {x:?}");
        }
        let values = [
            ("flow", q),
            ("wall", 3.2 * PI),
            ("wall_by_surface", 3.2 * PI),
            ("heat", 3.2 * q),
            // ½ ρ ∫ v² = ρ π L v_m²/6.
            ("kinetic", 2.0 * PI * 4.0 * 4.0 / 6.0),
            ("shear", 0.4),
            ("volume", 4.0 * PI),
            ("mean_p", 8.6),
            ("hoop", -8.6),
            ("on_axis", 2.0),
        ];
        for (name, value) in values {
            assert!((row[name] / value - 1.0).abs() < 1e-9, "{more:?}: {name} {} for {value}", row[name]);
        }
    }
    let units = Simulation::new(case(PIPE, &[]), 1).unwrap().units();
    assert_eq!(units, ["m³/s", "N", "N", "W", "J", "Pa", "m³", "m/s", "Pa", "Pa"]);
}

/// A cylinder, or a hollow one, that is drawn by 30 %: F = diag(a, b) with P_rr = 0, homogeneous around the axis, too.
#[test]
fn a_cylinder_of_every_law_is_drawn() {
    let (mu, lambda, c2, stretch) = (3.0, 4.0, 0.4, 1.3f64);
    let laws = [
        SolidLaw::StVenantKirchhoff,
        SolidLaw::Linear,
        SolidLaw::NeoHookean,
        SolidLaw::MooneyRivlin,
        SolidLaw::IncompressibleNeoHookean,
        SolidLaw::IncompressibleMooneyRivlin,
    ];
    for (law, inner) in laws.into_iter().flat_map(|law| [(law, 0.0), (law, 0.5)]) {
        let stress = |a: f64| {
            let diagonal = [a - 1.0, stretch - 1.0, a - 1.0];
            let grad = Tensor(std::array::from_fn(|i| {
                std::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 })
            }));
            law.material(mu, lambda, c2).stress::<3>(&grad)
        };
        let (a, end) = if law.is_incompressible() {
            // σ_zz − σ_rr = 2 (λ² − λ⁻¹)(c₁ + c₂/λ), μ = 2 (c₁ + c₂).
            let c2 = if law.is_mooney_rivlin() { c2 } else { 0.0 };
            let sigma = 2.0 * (stretch.powi(2) - 1.0 / stretch) * (0.5 * mu - c2 + c2 / stretch);
            (stretch.powf(-0.5), sigma)
        } else {
            let (mut low, mut high) = (0.5, 1.5);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if stress(middle).0[0][0] < 0.0 { low = middle } else { high = middle }
            }
            let density = if law == SolidLaw::Linear { 1.0 } else { low * low };
            (low, stress(low).0[1][1] / density)
        };
        let side = if inner == 0.0 { "symmetry" } else { "traction-free" };
        let mut text = format!(
            "[mesh]\ngenerator = \"box\"\nlower = [{inner}, 0]\nupper = [1, 2]\ncells = [2, 2]\nregion.solid = \"1\"\n\
             coordinates = \"axisymmetric\"\n[solid]\ndensity = 1\nlaw = \"{}\"\nmu = {mu}\n[boundary.left]\n\
             condition = \"{side}\"\n[boundary.right]\ncondition = \"traction-free\"\n[boundary.bottom]\n\
             condition = \"symmetry\"\n[boundary.top]\ncondition = \"displacement\"\ndisplacement = [\"free\", {}]\n\
             [newton]\ntolerance = 1e-12\n[functional.sigma]\nkind = \"stress\"\nregion = \"solid\"\ncomponent = \"yy\"\n\
             take = \"mean\"\n[functional.volume]\nkind = \"volume\"\nregion = \"solid\"\n[functional.energy]\n\
             kind = \"energy\"\nterm = \"elastic\"\n",
            law.name(),
            2.0 * (stretch - 1.0)
        );
        if !law.is_incompressible() {
            text = text.replace("[boundary.left]", &format!("lambda = {lambda}\n[boundary.left]"));
        }
        if law.is_mooney_rivlin() {
            text = text.replace("[boundary.left]", &format!("c2 = {c2}\n[boundary.left]"));
        }
        for more in [&[][..], &["space.velocity=Q3", "space.pressure=P2dc"]] {
            let mut simulation = Simulation::new(case(&text, more), 1).unwrap();
            let row = simulation.step().unwrap();
            let u = simulation.fields().at([1.0, 1.3]).unwrap().displacement;
            assert!((u[0] - (a - 1.0)).abs() < 1e-9, "{}: {u:?}, {a}", law.name());
            assert!((u[1] - 1.3 * (stretch - 1.0)).abs() < 1e-9, "{}: {u:?}", law.name());
            assert!((row["sigma"] / end - 1.0).abs() < 1e-8, "{}: {} for {end}", law.name(), row["sigma"]);
            let volume = 2.0 * PI * (1.0 - inner * inner) * stretch * a * a;
            assert!((row["volume"] / volume - 1.0).abs() < 1e-9, "{}: {}", law.name(), row["volume"]);
        }
    }
}

/// The quarter of a hollow sphere between the radii 1 and 2, turned around the axis.
fn sphere(n: usize) -> Case {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [1, 0]\nupper = [2, 1]\n[solid]\ndensity = 1\nmu = 1\nlambda = 1\n";
    let sides = ["left", "right", "bottom", "top"].map(|side| format!("boundary.{side}.condition=clamped"));
    let cells = [format!("mesh.cells=[{n},{}]", 2 * n), "mesh.region.solid=1".into()];
    let mut mesh =
        Case::from_toml(text, "box.toml", &[&sides[..], &cells].concat()).unwrap().build_mesh().unwrap();
    for x in &mut mesh.nodes {
        *x = [x[0] * (0.5 * PI * x[1]).cos(), x[0] * (0.5 * PI * x[1]).sin()];
    }
    CaseBuilder::new("sphere")
        .mesh(mesh)
        .set("mesh.coordinates", "axisymmetric")
        .set("solid.density", 1.0)
        .set("solid.law", "linear")
        .set("solid.mu", 3.0)
        .set("solid.lambda", 4.0)
        .set("boundary.left.condition", "pressure")
        .set("boundary.left.pressure", 1e-6)
        .set("boundary.right.condition", "traction-free")
        .set("boundary.bottom.condition", "symmetry")
        .set("boundary.top.condition", "symmetry")
        .set("newton.tolerance", 1e-12)
        .build()
        .unwrap()
}

/// u = C R + D/R² with (3λ + 2μ) C = p a³/(b³ − a³) and 4 μ D = p a³ b³/(b³ − a³): all directions take part.
#[test]
fn a_hollow_sphere_is_that_of_lame() {
    let (mu, lambda, p) = (3.0, 4.0, 1e-6);
    let factor = p / 7.0;
    let exact = factor / (3.0 * lambda + 2.0 * mu) + factor * 8.0 / (4.0 * mu);
    let error = |n| {
        let mut simulation = Simulation::new(sphere(n), 1).unwrap();
        simulation.step().unwrap();
        let at = |x: [f64; 2]| simulation.fields().at(x).unwrap().displacement;
        let (pole, equator) = (at([0.0, 1.0]), at([1.0, 0.0]));
        assert!(pole[0].abs() < 1e-18 && equator[1].abs() < 1e-18, "{pole:?} {equator:?}");
        (pole[1] - exact).abs().max((equator[0] - exact).abs()) / exact
    };
    let errors = [error(2), error(4), error(8)];
    assert!((errors[0] / errors[1]).log2() > 3.0 && (errors[1] / errors[2]).log2() > 3.3, "{errors:?}");
    assert!(errors[2] < 3e-5, "{errors:?}");
}

/// A channel with an elastic wall, (left, right, bottom, top) = (plane of symmetry or axis, outside, ends).
pub fn walled(radius: f64, around: bool, more: &[&str]) -> Case {
    let text = format!(
        r#"
[mesh]
generator = "box"
lower = [{radius}, 0]
upper = [{}, 3]
cells = [3, 4]
coordinates = "{}"
region.solid = "x - {radius} - 0.8"
[fluid]
density = 2
kinematic-viscosity = 0.1
[solid]
density = 3
law = "neo-hookean"
young = 200
poisson = 0.3
[boundary.left]
condition = "symmetry"
[boundary.right]
condition = "traction-free"
[boundary.bottom]
condition = "pressure"
pressure = "8*sin(3*t)"
[boundary.top]
condition = "do-nothing"
[time]
step = 0.05
end = 0.25
[newton]
tolerance = 1e-11
[functional.flow]
kind = "flux"
on = ["top"]
[functional.push]
kind = "force"
on = ["interface"]
component = "x"
[functional.elastic]
kind = "energy"
term = "elastic"
[functional.p]
kind = "pressure"
point = [{}, 1.3]
[functional.u]
kind = "displacement"
point = [{}, 1.5]
component = "x"
"#,
        radius + 1.2,
        if around { "axisymmetric" } else { "cartesian" },
        radius + 0.3,
        radius + 0.8,
    );
    let ends = ["boundary.right.condition=traction-free"];
    case(&text, &[&ends, more].concat())
}

/// 1e5 m from the axis the ring is a plane channel; integrals are 2π r times as large.
#[test]
fn far_from_the_axis_is_the_plane() {
    let schemes = SCHEMES.iter().map(|scheme| vec![*scheme]);
    let others: [&[&str]; 5] = [
        &["motion.model=harmonic", "newton.linearization=newton"],
        &[
            "motion.model=jacobian-stiffened",
            "boundary.top.condition=resistance",
            "boundary.top.resistance=2",
        ],
        &[
            "boundary.top.condition=windkessel",
            "boundary.top.proximal=1",
            "boundary.top.distal=3",
            "boundary.top.capacitance=0.02",
        ],
        &["solid.law=incompressible-neo-hookean", "solid.young=none", "solid.poisson=none", "solid.mu=70"],
        &["space.velocity=P2", "space.pressure=P1", "newton.linearization=fixed-point"],
    ];
    for more in schemes.chain(others.iter().map(|more| more.to_vec())) {
        let radius = 1e5;
        let plane = walled(0.0, false, &more);
        // Resistances are those of the whole ring.
        let mut ring = more.clone();
        let circuit = [
            "boundary.top.resistance",
            "boundary.top.proximal",
            "boundary.top.distal",
            "boundary.top.capacitance",
        ];
        let scaled: Vec<String> = more
            .iter()
            .filter_map(|set| {
                let (key, value) = set.split_once('=')?;
                let value: f64 = value.parse().ok().filter(|_| circuit.contains(&key))?;
                let length = 2.0 * PI * radius;
                Some(format!(
                    "{key}={}",
                    if key.ends_with("capacitance") { value * length } else { value / length }
                ))
            })
            .collect();
        ring.extend(scaled.iter().map(String::as_str));
        let run = |case| finish(&mut Simulation::new(case, 1).unwrap());
        let (plane, ring) = (run(plane), run(walled(radius, true, &ring)));
        for (name, whole) in [("flow", true), ("push", true), ("elastic", true), ("p", false), ("u", false)] {
            let value = ring[name] / if whole { 2.0 * PI * radius } else { 1.0 };
            let gap = (value / plane[name] - 1.0).abs();
            assert!(gap < 1e-4, "{more:?}: {name} {value:e} for {:e}, {gap:e}", plane[name]);
            assert!(plane[name].abs() > 1e-7, "{name}");
        }
    }
}

#[test]
fn all_jacobians_agree_around_an_axis() {
    let cases: [&[&str]; 5] = [
        &[],
        &["motion.model=harmonic", "boundary.top.condition=resistance", "boundary.top.resistance=2"],
        &["motion.model=jacobian-stiffened", "motion.jacobian=implicit", "boundary.top.backflow=directional"],
        &[
            "space.velocity=P2",
            "space.pressure=P1",
            "boundary.right.condition=spring",
            "boundary.right.stiffness=3",
        ],
        &["solid.law=incompressible-neo-hookean", "solid.young=none", "solid.poisson=none", "solid.mu=70"],
    ];
    for (more, radius) in cases.iter().flat_map(|more| [(more, 0.0), (more, 0.5)]) {
        let cells = ["mesh.cells=[3,2]"];
        let mut simulation = Simulation::new(walled(radius, true, &[more, &cells[..]].concat()), 1).unwrap();
        let report = compare(&mut simulation, At::Random { seed: 3 }).unwrap();
        assert!(report.agrees(), "{more:?}, radius {radius}\n{report}");
    }
}

/// As much flows in as the volume grows by, on the moving ring as in the plane; threads change nothing.
#[test]
fn volume_and_flow_balance_around_an_axis() {
    let mut ends = vec![];
    for threads in [1, 2] {
        let more = ["time.scheme=crank-nicolson", "time.step=0.01"];
        let mut simulation = Simulation::new(walled(0.0, true, &more), threads).unwrap();
        finish(&mut simulation);
        let balance = simulation.balance.as_ref().unwrap();
        let (mass, swept) = (balance.mass().unwrap(), balance.swept().unwrap());
        assert!(mass < 1e-9 && swept < 1e-3, "{mass:e} {swept:e}");
        ends.push(simulation.stepper.new.v.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
    }
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn what_an_axis_cannot_have_is_refused() {
    let refused = |more: &[&str]| {
        let text = wrong(PIPE, more);
        assert!(text.starts_with("own.toml") || text.starts_with("--set"), "{text}");
        text
    };
    let said = refused(&["space.velocity=Q2", "space.pressure=Q2"]);
    assert!(said.contains("stabilization.pressure") && said.contains("axisymmetric"), "{said}");
    let said = refused(&["functional.wall.coefficient=[1,2]"]);
    assert!(said.contains("functional.wall.coefficient"), "{said}");
    let rotor = ["mesh.coordinates=axisymmetric", "motion.model=pseudo-elastic"];
    let said = wrong_builtin("rotor", &rotor);
    assert!(said.contains("rotation.kind"), "{said}");
    let moment = ["functional.flow.kind=moment", "functional.flow.point=[0,0]"];
    let said = refused(&moment);
    assert!(said.contains("functional.flow.kind") && said.contains("axis"), "{said}");
    let periodic =
        ["mesh.coordinates=cartesian", "boundary.top.condition=periodic", "boundary.top.with=bottom"];
    let ends = ["boundary.bottom.condition=periodic", "boundary.bottom.with=top"];
    let none = ["boundary.top.pressure=none", "boundary.bottom.pressure=none"];
    let said = refused(&[&moment[..], &periodic, &ends, &none].concat());
    assert!(said.contains("functional.flow.kind") && said.contains("periodic"), "{said}");
    let of_mesh = |more: &[&str]| match Simulation::new(case(PIPE, more), 1) {
        Ok(_) => panic!("{more:?}"),
        Err(e) => e.to_string(),
    };
    let said = of_mesh(&["mesh.lower=[-1,0]"]);
    assert!(said.contains("mesh") && said.contains("r = -1"), "{said}");
    let said = of_mesh(&["boundary.left.condition=do-nothing"]);
    assert!(said.contains("boundary.left.condition") && said.contains("symmetry"), "{said}");
    let tube = builtin("tube-2d", &["motion.model=pseudo-elastic"]);
    assert!(undula::modes::of_case(&tube, 2, 1).is_err_and(|e| e.to_string().contains("mesh.coordinates")));
}

/// A given flow with its profile, and a pipe that repeats along its axis and is driven by a force: v = 2 (1 − r²).
#[test]
fn profiles_and_periodic_ends_know_the_axis() {
    let flow = format!("boundary.bottom.flow-rate={}", -PI);
    let given = [
        "boundary.bottom.condition=flux",
        "boundary.bottom.pressure=none",
        flow.as_str(),
        "boundary.bottom.profile=parabolic",
    ];
    // Δp/L = 0.8 Pa/m is ρ f.
    let periodic = [
        "boundary.bottom.condition=periodic",
        "boundary.bottom.pressure=none",
        "boundary.bottom.with=top",
        "boundary.top.condition=periodic",
        "boundary.top.pressure=none",
        "boundary.top.with=bottom",
        "fluid.body-force=[0,0.4]",
    ];
    for more in [&given[..], &periodic] {
        let mut simulation = Simulation::new(case(PIPE, more), 1).unwrap();
        let row = simulation.step().unwrap();
        let fields = simulation.fields();
        for (x, v) in fields.coordinates().iter().zip(fields.velocity()) {
            let gap = (v[1] - 2.0 * (1.0 - x[0] * x[0])).abs().max(v[0].abs());
            assert!(gap < 1e-9, "{more:?}: {v:?} at {x:?}");
        }
        if more == given {
            assert!((row["on_axis"] - 2.0).abs() < 1e-9, "{row:?}");
        }
        assert!((row["flow"] - PI).abs() < 1e-9 && (row["wall"] - 3.2 * PI).abs() < 1e-8, "{row:?}");
    }
    // The velocity on the axis, whose node has no area.
    for (radius, cells) in [("1.1", "2"), ("1.1", "3"), ("0.3", "3"), ("0.7", "7")] {
        let sets = [format!("mesh.upper=[{radius},2]"), format!("mesh.cells=[{cells},2]")];
        let more: Vec<&str> = given.iter().copied().chain(sets.iter().map(String::as_str)).collect();
        let mut simulation = Simulation::new(case(PIPE, &more), 1).unwrap();
        simulation.step().unwrap();
        let on_axis = simulation.fields().at([0.0, 0.0]).unwrap().velocity;
        let expected = 2.0 / radius.parse::<f64>().unwrap().powi(2);
        assert!((on_axis[1] - expected).abs() < 1e-8 && on_axis[0] == 0.0, "{radius}, {cells}: {on_axis:?}");
    }
    let along_r = [
        "mesh.lower=[0.5,0]",
        "boundary.left.condition=periodic",
        "boundary.left.with=right",
        "boundary.right.condition=periodic",
        "boundary.right.with=left",
    ];
    let said = Simulation::new(case(PIPE, &along_r), 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(said.contains("along its axis"), "{said}");
}

/// Flows, resistances and capacitances are those of the whole body, with their units.
#[test]
fn units_are_those_of_space() {
    let outlet = |key: &str, value: &str| {
        let sets = ["boundary.top.pressure=none", key, value];
        Case::from_toml(PIPE, "own.toml", &sets.map(String::from)).map_err(|e| e.to_string())
    };
    let flux =
        |value: &str| outlet("boundary.top.condition=flux", &format!("boundary.top.flow-rate={value}"));
    let litres = flux("\"6 l/min\"").unwrap();
    assert_eq!(litres.boundary["top"], flux("1e-4").unwrap().boundary["top"]);
    let viscous =
        Case::from_toml(PIPE, "own.toml", &sets(&["fluid.kinematic-viscosity=\"50 cSt\""])).unwrap();
    assert_eq!(viscous.fluids[0].kinematic_viscosity, 50e-6);
    let said = flux("\"1 m^2/s\"").unwrap_err();
    assert!(said.contains("m³/s") && said.contains("boundary.top.flow-rate"), "{said}");
    let of = "boundary.top.condition=resistance";
    assert!(outlet(of, "boundary.top.resistance=\"3 Pa s/m^3\"").is_ok());
    assert!(outlet(of, "boundary.top.condition=windkessel").unwrap_err().contains("Pa s/m³"));
}

/// What a body gets is what it has, carries off and dissipates, to second order.
#[test]
fn energy_is_balanced_around_an_axis() {
    let parts = ["residual", "interface"].into_iter().flat_map(|part| [("fluid", part), ("solid", part)]);
    let sets: Vec<String> = parts
        .flat_map(|(body, part)| {
            let of = |key: &str, value: &str| format!("functional.{body}-{part}.{key}={value}");
            [of("kind", "balance"), of("region", body), of("part", part)]
        })
        .collect();
    let run = |step: f64| {
        let step = format!("time.step={step}");
        let more = [
            "time.scheme=crank-nicolson",
            &step,
            "boundary.top.condition=pressure",
            "boundary.top.pressure=0",
        ];
        let more: Vec<&str> = more.into_iter().chain(sets.iter().map(String::as_str)).collect();
        let mut simulation = Simulation::new(walled(0.0, true, &more), 1).unwrap();
        assert_eq!(simulation.units()[5], "W");
        let mut most = [0.0f64; 3];
        while !simulation.finished() {
            let row = simulation.step().unwrap();
            let all = ["fluid-residual", "solid-residual", "fluid-interface"].map(|name| row[name].abs());
            (0..3).for_each(|n| most[n] = most[n].max(all[n]));
        }
        most
    };
    let (coarse, fine) = (run(0.025), run(0.0125));
    for body in [0, 1] {
        let order = (coarse[body] / fine[body]).log2();
        assert!(order > 1.7 && fine[body] < 0.02 * fine[2], "{order}: {coarse:?} {fine:?}");
    }
}

/// A tube that is measured under the pressure of a fluid at rest does not move.
#[test]
fn a_measured_tube_rests_around_its_axis() {
    let laws: [&[&str]; 4] = [
        &[],
        &["solid.law=st-venant-kirchhoff", "time.scheme=bdf2"],
        &["solid.law=linear", "newton.linearization=newton"],
        &["solid.law=incompressible-neo-hookean", "solid.young=none", "solid.poisson=none", "solid.mu=70"],
    ];
    for law in laws {
        let more = [
            "solid.prestress=true",
            "boundary.bottom.condition=symmetry",
            "boundary.bottom.pressure=none",
            "boundary.top.condition=pressure",
            "boundary.top.pressure=4",
        ];
        let mut simulation = Simulation::new(walled(0.0, true, &[&more[..], law].concat()), 1).unwrap();
        let fabrics = &simulation.stepper.assembler.space.fabrics.unloading;
        let taken = fabrics.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        assert!(taken > 5e-3, "{law:?}: {taken}");
        finish(&mut simulation);
        let u = simulation.stepper.new.u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        assert!(u < 1e-8, "{law:?}: {u}");
        let report = compare(&mut simulation, At::Random { seed: 2 }).unwrap();
        assert!(report.agrees(), "{law:?}\n{report}");
    }
}
