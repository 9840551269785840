//! Solids whose measured shape is the loaded one: u = 0 under the loads of the start, and the right stiffness there.

use crate::common::{SCHEMES, sets};
use crate::slip::mesh;
use std::f64::consts::PI;
use undula::CaseBuilder;
use undula::case::Case;
use undula::math::Tensor;
use undula::physics::{Material, SolidLaw};
use undula::simulation::Simulation;
use undula::verification::jacobians;

/// A quarter of a tube with 1 < r < 2 m, measured under the inner pressure `p`, a function of t.
fn tube(n: usize, law: SolidLaw, p: &str) -> CaseBuilder {
    let polar = |x: [f64; 2]| [x[0] * (0.5 * PI * x[1]).cos(), x[0] * (0.5 * PI * x[1]).sin()];
    let case = CaseBuilder::new("tube")
        .mesh(mesh([2.0, 1.0], [1.0, 0.0], [n, 2 * n], "1", polar))
        .set("solid.density", 1.0)
        .set("solid.law", law.name())
        .set("solid.prestress", true)
        .set("boundary.left.condition", "pressure")
        .set("boundary.left.pressure", p)
        .set("boundary.right.condition", "traction-free")
        .set("boundary.bottom.condition", "symmetry")
        .set("boundary.top.condition", "symmetry")
        .set("time.step", 0.1)
        .set("time.end", 0.3)
        .set("newton.tolerance", 1e-10);
    constants(case, law)
}

/// Constants of a law with μ = 3 and λ = 4, or of about this size.
fn constants(case: CaseBuilder, law: SolidLaw) -> CaseBuilder {
    let case = match law {
        SolidLaw::Guccione => {
            return case
                .set("solid.guccione-c", 2.0)
                .set("solid.b-f", 3.0)
                .set("solid.b-t", 2.0)
                .set("solid.b-fs", 2.5)
                .set("solid.fibre-direction", ["-y", "x"]);
        }
        SolidLaw::Ogden | SolidLaw::IncompressibleOgden => {
            case.set("solid.ogden-mu", vec![1.5, -0.5]).set("solid.ogden-alpha", vec![3.0, -3.0])
        }
        _ => case.set("solid.mu", 3.0),
    };
    let case = if law.is_of_arteries() {
        case.set("solid.k1", 0.8)
            .set("solid.k2", 0.5)
            .set("solid.fibre-angle", 0.6)
            .set("solid.fibre-direction", ["-y", "x"])
    } else {
        case
    };
    let case = if law.is_mooney_rivlin() { case.set("solid.c2", 0.4) } else { case };
    if law.is_incompressible() { case } else { case.set("solid.lambda", 4.0) }
}

const ALL: [SolidLaw; 12] = [
    SolidLaw::IsochoricNeoHookean,
    SolidLaw::StVenantKirchhoff,
    SolidLaw::Linear,
    SolidLaw::NeoHookean,
    SolidLaw::MooneyRivlin,
    SolidLaw::IncompressibleNeoHookean,
    SolidLaw::IncompressibleMooneyRivlin,
    SolidLaw::Ogden,
    SolidLaw::IncompressibleOgden,
    SolidLaw::HolzapfelGasserOgden,
    SolidLaw::IncompressibleHolzapfelGasserOgden,
    SolidLaw::Guccione,
];

fn largest(simulation: &Simulation) -> f64 {
    simulation.stepper.new.u.iter().fold(0.0, |most: f64, u| most.max(u.abs()))
}

/// The measured tube does not move under its load: below 1e-8 of its thickness, with every law. Without prestress it does.
#[test]
fn a_measured_tube_of_every_law_rests() {
    for law in ALL {
        let case = tube(2, law, "0.4").build().unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        let u = &simulation.stepper.assembler.space.fabrics.unloading;
        let taken = u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        assert!(taken > 0.05, "{law:?}: {taken}");
        for _ in 0..2 {
            simulation.step().unwrap();
            assert!(largest(&simulation) < 1e-8, "{law:?}: {}", largest(&simulation));
        }
        let mut at = |seed| jacobians::compare(&mut simulation, jacobians::At::Random { seed }).unwrap();
        // The stress of fibres has a kink where they slacken, which differences see.
        let seeds = if law.is_of_arteries() { 8..13 } else { 8..9 };
        let report = seeds.map(&mut at).find(|report| report.agrees());
        assert!(report.is_some(), "{law:?}\n{}", at(8));
    }
    let case = tube(2, SolidLaw::NeoHookean, "0.4").set("solid.prestress", false).build().unwrap();
    let mut simulation = Simulation::new(case, 1).unwrap();
    simulation.step().unwrap();
    assert!(largest(&simulation) > 1e-3);
}

/// The same in every scheme and with every linearisation, nearly incompressible, of order one to four, on triangles.
#[test]
fn a_measured_tube_rests_in_every_scheme() {
    let rest = |case: CaseBuilder, what: &str| {
        let mut simulation = Simulation::new(case.build().unwrap(), 2).unwrap();
        while !simulation.finished() {
            simulation.step().unwrap();
        }
        assert!(largest(&simulation) < 1e-8, "{what}: {}", largest(&simulation));
    };
    for scheme in SCHEMES {
        let scheme = scheme.trim_start_matches("time.scheme=");
        for law in [SolidLaw::NeoHookean, SolidLaw::IncompressibleNeoHookean] {
            rest(tube(2, law, "0.4").set("time.scheme", scheme), scheme);
        }
    }
    for way in ["newton", "reduced", "fixed-point", "condensed"] {
        rest(tube(2, SolidLaw::IncompressibleMooneyRivlin, "0.3").set("newton.linearization", way), way);
    }
    for way in ["analytic", "finite-difference"] {
        rest(tube(2, SolidLaw::NeoHookean, "0.3").set("newton.jacobian", way), way);
    }
    let law = SolidLaw::IncompressibleMooneyRivlin;
    rest(tube(2, law, "0.3").set("solid.bulk", 40.0), "nearly incompressible");
    for element in ["Q1", "Q3", "Q4"] {
        rest(tube(2, SolidLaw::NeoHookean, "0.3").set("space.velocity", element), element);
    }
}

/// From the measured shape on: the tube that keeps its volume has r² = R² + c under the pressure p(c), so that from p₀ to
/// p₁ the square of each radius grows by c₁ − c₀.
#[test]
fn a_measured_tube_is_as_stiff_as_the_tube_that_it_was() {
    let mu = 3.0;
    // ∫ μ (λ² − 1/λ²) dr/r over the present tube a < r < b.
    let pressure = |c: f64, a: f64, b: f64| {
        let (n, slope) = (20_000, |r: f64| {
            let square = r * r / (r * r - c);
            mu * (square - 1.0 / square) / r
        });
        let h = (b - a) / f64::from(n);
        (0..n).map(|i| slope(a + (f64::from(i) + 0.5) * h) * h).sum::<f64>()
    };
    // Measured as 1 < r < 2 with c₀ = 0.4, then drawn to c₁ = 0.6.
    let (c, more) = (0.4, 0.2f64);
    let (p0, p1) = (pressure(c, 1.0, 2.0), pressure(c + more, (1.0 + more).sqrt(), (4.0 + more).sqrt()));
    let error = |n: usize| {
        let load = format!("if(t < 1, {p0}, {p1})");
        let case = tube(n, SolidLaw::IncompressibleNeoHookean, &load)
            .set("time.scheme", "backward-euler")
            .set("time.step", 1000.0)
            .set("time.end", 12000.0)
            .build()
            .unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        while !simulation.finished() {
            simulation.step().unwrap();
        }
        let u = simulation.fields().at([1.0, 0.0]).unwrap().displacement;
        (u[0] - ((1.0 + more).sqrt() - 1.0)).abs()
    };
    let errors = [error(4), error(8)];
    assert!((errors[0] / errors[1]).log2() > 3.0 && errors[1] < 1e-5, "{errors:?}");
}

/// A measured bar of every law that is drawn further: F = diag(a₀, b₀) under the Cauchy stress T, diag(a₁, b₁) under the
/// traction of the measured bar.
#[test]
fn a_measured_bar_is_drawn_further() {
    let (mu, lambda, a0, a1) = (3.0, 4.0, 1.2, 1.4);
    for law in [
        SolidLaw::StVenantKirchhoff,
        SolidLaw::Linear,
        SolidLaw::NeoHookean,
        SolidLaw::MooneyRivlin,
        SolidLaw::IncompressibleNeoHookean,
    ] {
        let material: Material = law.material(mu, lambda, 0.4);
        // P₁₁ per area of the bar without stress, where P₂₂ is 0.
        let drawn = |a: f64| {
            let stress = |b: f64| material.stress(&Tensor([[a - 1.0, 0.0], [0.0, b - 1.0]])).0;
            if law.is_incompressible() {
                let p = stress(1.0 / a);
                return (1.0 / a, p[0][0] - p[1][1] / (a * a));
            }
            let (mut low, mut high) = (0.5, 1.5);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if stress(middle)[1][1] < 0.0 { low = middle } else { high = middle }
            }
            (low, stress(low)[0][0])
        };
        let ((b0, t0), (b1, t1)) = (drawn(a0), drawn(a1));
        // Hooke's law does not distinguish the areas, and adds strains.
        let (area, u) = match law {
            SolidLaw::Linear => (1.0, [a1 - a0, b1 - b0]),
            _ => (b0, [a1 / a0 - 1.0, b1 / b0 - 1.0]),
        };
        let case = CaseBuilder::new("bar")
            .set("mesh.generator", "box")
            .set("mesh.lower", [0.0, 0.0])
            .set("mesh.upper", [1.0, 1.0])
            .set("mesh.cells", [2, 2])
            .set("mesh.region.solid", "1")
            .set("solid.density", 1.0)
            .set("solid.law", law.name())
            .set("solid.prestress", true)
            .set("boundary.left.condition", "symmetry")
            .set("boundary.bottom.condition", "symmetry")
            .set("boundary.right.condition", "traction")
            .set("boundary.right.traction", [format!("if(t < 1, {}, {})", t0 / area, t1 / area), "0".into()])
            .set("boundary.top.condition", "traction-free")
            .set("time.scheme", "backward-euler")
            .set("time.step", 1000.0)
            .set("time.end", 15000.0)
            .set("newton.tolerance", 1e-11);
        let mut simulation = Simulation::new(constants(case, law).build().unwrap(), 1).unwrap();
        while !simulation.finished() {
            simulation.step().unwrap();
        }
        let fields = simulation.fields();
        for (x, found) in fields.coordinates().iter().zip(fields.displacement()) {
            let gap = (found[0] - u[0] * x[0]).abs().max((found[1] - u[1] * x[1]).abs());
            assert!(gap < 1e-8, "{law:?}: {found:?} at {x:?} for {u:?}");
        }
    }
}

/// A channel with an elastic wall of 0.2 m and a flow through it, measured together.
fn vessel(more: &[&str]) -> Case {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [2, 1.2]\ncells = [8, 6]\n\
                region = { solid = \"y - 1\" }\n\
                [fluid]\ndensity = 1\nkinematic-viscosity = 0.1\n\
                [solid]\ndensity = 2\nlaw = \"neo-hookean\"\nmu = 30\nlambda = 60\nprestress = true\n\
                [boundary.left]\ncondition = \"pressure\"\npressure = 3\n\
                [boundary.right]\ncondition = \"pressure\"\npressure = 2.5\n\
                [boundary.bottom]\ncondition = \"no-slip\"\n[boundary.top]\ncondition = \"clamped\"\n\
                [time]\nscheme = \"crank-nicolson\"\nstep = 0.05\nend = 0.2\n\
                [newton]\ntolerance = 1e-10\n\
                [functional.u]\nkind = \"displacement\"\npoint = [1, 1]\ncomponent = \"y\"\n\
                [functional.mises]\nkind = \"stress\"\ncomponent = \"von-mises\"\npoint = [1, 1.1]\n";
    Case::from_toml(text, "vessel.toml", &sets(more)).unwrap()
}

/// Fluid and solid together stand still but for the flow, with every motion of the mesh and pressures of solids.
#[test]
fn a_measured_vessel_carries_its_flow() {
    let soft = ["solid.law=incompressible-neo-hookean", "solid.lambda=none"];
    let ways: [&[&str]; 8] = [
        &[],
        &["motion.model=harmonic"],
        &["motion.model=biharmonic"],
        &["newton.linearization=condensed"],
        &["newton.linearization=newton", "time.scheme=bdf2"],
        &["space.velocity=P2", "space.pressure=P1"],
        &soft,
        &[
            "boundary.right.condition=windkessel",
            "boundary.right.proximal=1",
            "boundary.right.distal=3",
            "boundary.right.capacitance=0.1",
            "boundary.right.pressure=1",
        ],
    ];
    for more in ways {
        let mut simulation = Simulation::new(vessel(more), 2).unwrap();
        let start = simulation.stepper.new.clone();
        assert!(start.u.iter().all(|u| *u == 0.0) && start.v.iter().any(|v| v.abs() > 0.1), "{more:?}");
        while !simulation.finished() {
            simulation.step().unwrap();
        }
        assert!(largest(&simulation) < 2e-9, "{more:?}: {}", largest(&simulation));
        let moved = start.v.iter().zip(&simulation.stepper.new.v).map(|(a, b)| (a - b).abs());
        assert!(moved.fold(0.0, f64::max) < 1e-7, "{more:?}");
    }
}

/// Two bonded bodies of other laws under their weight, one of them with fibres; all of them have prestress or none.
#[test]
fn measured_bodies_carry_each_other() {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [2, 1]\ncells = [4, 2]\n\
                region = { soft = \"1 - x\", hard = \"x - 1\" }\n\
                [solid.soft]\ndensity = 1\nlaw = \"incompressible-neo-hookean\"\nmu = 6\nprestress = true\n\
                body-force = [0, -0.3]\n\
                [solid.hard]\ndensity = 2\nlaw = \"holzapfel-gasser-ogden\"\nmu = 5\nlambda = 9\nk1 = 4\nk2 = 0.5\n\
                fibre-angle = 0.3\nfibre-direction = [\"x\", \"1 + y\"]\nprestress = true\nbody-force = [0.2, -0.2]\n\
                [boundary.left]\ncondition = \"clamped\"\n[boundary.right]\ncondition = \"traction-free\"\n\
                [boundary.bottom]\ncondition = \"traction-free\"\n[boundary.top]\ncondition = \"traction-free\"\n\
                [time]\nscheme = \"crank-nicolson\"\nstep = 0.1\nend = 0.5\n[newton]\ntolerance = 1e-10\n";
    let case = |more: &[&str]| Case::from_toml(text, "bodies.toml", &sets(more));
    let mut simulation = Simulation::new(case(&[]).unwrap(), 1).unwrap();
    let taken = simulation.stepper.assembler.space.fabrics.unloading.clone();
    assert!(taken.iter().any(|u| u.abs() > 0.1), "{taken:?}");
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    assert!(largest(&simulation) < 1e-8, "{}", largest(&simulation));
    let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 9 }).unwrap();
    assert!(report.agrees(), "{report}");
    let message = case(&["solid.hard.prestress=false"]).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("in all solids or in none; [solid.hard] has none"), "{message}");
}

/// What the run leaves: prestress in checkpoints, the same bits after going on and on two threads.
#[test]
fn a_prestress_is_kept() {
    let more = ["boundary.left.pressure=3 + t"];
    let run = |threads| {
        let mut simulation = Simulation::new(vessel(&more), threads).unwrap();
        simulation.step().unwrap();
        let kept = simulation.save();
        simulation.step().unwrap();
        (kept, simulation.stepper.new.clone(), simulation.history.last().unwrap().values.clone())
    };
    let (kept, state, values) = run(1);
    assert!(values[0] > 1e-6 && values[1] > 0.1, "{values:?}");
    let (other, same, _) = run(2);
    assert!(state == same && kept.unloading == other.unloading);
    let mut again: Simulation = Simulation::at_rest(vessel(&more), 1).unwrap();
    again.restore(kept).unwrap();
    let row = again.step().unwrap();
    assert!(again.stepper.new == state && row.values == values);
}

#[test]
fn prestress_is_refused_where_it_has_no_sense() {
    let message = |more: &[&str]| {
        let text = vessel(&[]).to_toml();
        match Case::from_toml(&text, "vessel.toml", &sets(more)) {
            Err(error) => error.to_string(),
            Ok(case) => match Simulation::new(case, 1) {
                Err(error) => error.to_string(),
                Ok(simulation) => simulation.case.notes().join("\n"),
            },
        }
    };
    for (more, expected) in [
        (&["time=none"][..], "solid.prestress = true: only for a case in time"),
        (&["initial.velocity=[0, 0]"], "with solid.prestress the start is the flow"),
        (&["initial.static=true"], "initial.static has no effect"),
        (&["boundary.left.pressure=0", "boundary.right.pressure=0"], "nothing loads the solid at the start"),
        (&["boundary.top.condition=traction-free"], "nothing holds"),
    ] {
        let message = message(more);
        assert!(message.contains(expected), "{more:?}: {message}");
    }
    let again = Case::from_toml(&vessel(&[]).to_toml(), "again.toml", &[]).unwrap();
    assert_eq!(again.solids, vessel(&[]).solids);
    let case = tube(2, SolidLaw::NeoHookean, "1").build().unwrap();
    let refused = undula::modes::of_case(&case, 1, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(refused.contains("without `prestress`"), "{refused}");
}

/// A channel under an elastic wall with a circuit at its end, whose regions have names of their own.
fn artery(start: &str, more: &[&str]) -> Case {
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [2, 1.2]\ncells = [4, 6]\n\
         region = {{ blood = \"1 - y\", tissue = \"y - 1\" }}\n\
         [fluid]\ndensity = 1\nkinematic-viscosity = 1\nregion = \"blood\"\n\
         [solid]\ndensity = 1\nyoung = 1e6\npoisson = 0.3\nregion = \"tissue\"\n\
         [boundary.left]\ncondition = \"flux\"\nprofile = \"parabolic\"\nflow-rate = -0.5\n\
         [boundary.right]\ncondition = \"windkessel\"\nproximal = 10\ncapacitance = 0.01\ndistal = 100\ninitial = 50\n\
         [boundary.bottom]\ncondition = \"symmetry\"\n[boundary.top]\ncondition = \"traction-free\"\n\
         [time]\nstep = 1e-4\nend = 3e-4\n[newton]\ntolerance = 1e-10\n{start}\n\
         [functional.p]\nkind = \"pressure\"\non = [\"right\"]\ntake = \"mean\"\n"
    );
    Case::from_toml(&text, "artery.toml", &sets(more)).unwrap()
}

/// A circuit whose pressure is given at the start has it there: the wall is measured under R_p Q + P_c, and rests until the
/// circuit changes. Without it the pressure is that of the equilibrium, (R_p + R_d) Q.
#[test]
fn a_start_has_the_pressure_that_a_circuit_is_given() {
    let prestress = |more: &[&str]| artery("", &[&["solid.prestress=true"], more].concat());
    let still = |more: &[&str]| artery("[initial]\nstatic = true", more);
    let zero = ["boundary.right.initial=0"];
    let cases = [(prestress(&[]), 55.0), (prestress(&zero), 55.0), (still(&[]), 55.0), (still(&zero), 55.0)];
    for (n, (case, expected)) in cases.into_iter().enumerate() {
        // The flow of 0.5 m²/s through R_p has 5 Pa, through both 55 Pa: the same here.
        let mut simulation = Simulation::new(case, 1).unwrap();
        let p = simulation.step().unwrap()["p"];
        assert!((p / expected - 1.0).abs() < 0.01, "{n}: {p}");
        if n < 2 {
            assert!(largest(&simulation) < 1e-6, "{n}: {}", largest(&simulation));
        }
    }
    for case in [prestress(&["boundary.right.initial=20"]), still(&["boundary.right.initial=20"])] {
        let mut simulation = Simulation::new(case, 1).unwrap();
        let p = simulation.step().unwrap()["p"];
        assert!((p / 25.0 - 1.0).abs() < 0.01, "{p}");
    }
}
