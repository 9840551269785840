//! Outlets whose pressure depends on their flow, and solids on springs, against closed forms.

use crate::common::{SCHEMES, channel_between, sets, wrong};
use undula::case::Case;
use undula::simulation::Simulation;
use undula::verification::jacobians;

/// A channel of 4 m × 1 m with ρ = 1 and μ = 0.1: p − p_out = 12 μ L Q/H³ = 4.8 Q.
fn channel(more: &[&str]) -> Case {
    let left = "condition = \"pressure\"\npressure = 3.2";
    let right = "condition = \"resistance\"\nresistance = 1.6\npressure = 0.1";
    let flow = "[functional.out]\nkind = \"flux\"\non = [\"right\"]\n\
                [functional.p]\nkind = \"pressure\"\non = [\"right\"]\ntake = \"mean\"\n";
    channel_between([4, 2], [left, right], flow, more)
}

fn last(case: Case) -> (undula::Row, Simulation) {
    let mut simulation = Simulation::new(case, 1).unwrap();
    let mut row = simulation.step().unwrap();
    while !simulation.finished() {
        row = simulation.step().unwrap();
    }
    (row, simulation)
}

#[test]
fn a_resistance_stands_behind_poiseuille_flow() {
    let q = 3.1 / 6.4;
    for more in
        [&[][..], &["newton.linearization=newton"], &["linear.krylov=gmres", "newton.linearization=newton"]]
    {
        let (row, _) = last(channel(more));
        assert!((row["out"] - q).abs() < 1e-9, "{more:?}: {} for {q}", row["out"]);
        assert!((row["p"] - (1.6 * q + 0.1)).abs() < 1e-8, "{more:?}: {}", row["p"]);
    }
    // In time it settles.
    for scheme in SCHEMES.iter().filter(|scheme| !scheme.contains("crank") && !scheme.contains("cg1")) {
        let more = [scheme, "time.step=0.5", "time.end=40", "fluid.kinematic-viscosity=0.1"];
        let (row, _) = last(channel(&more));
        assert!((row["out"] - q).abs() < 1e-7, "{scheme}: {} for {q}", row["out"]);
    }
}

/// A flow Q = t into an RCR circuit: P_c = R_d (t − τ (1 − e^{−t/τ})) + P₀ e^{−t/τ} + P (1 − e^{−t/τ}), τ = R_d C.
#[test]
fn a_windkessel_is_charged() {
    let (distal, capacitance, initial, behind, proximal) = (2.0, 0.3, 0.4, 0.25, 0.7);
    let tau: f64 = distal * capacitance;
    let end = 1.0f64;
    let decay = (-end / tau).exp();
    let exact = distal * (end - tau * (1.0 - decay)) + initial * decay + behind * (1.0 - decay);
    for (scheme, order) in [
        ("crank-nicolson", 2.0),
        ("shifted-crank-nicolson", 2.0),
        ("bdf2", 2.0),
        ("fractional-step-theta", 2.0),
        ("cg1", 2.0),
        ("backward-euler", 1.0),
        ("esdirk4", 4.0),
    ] {
        let steps = if order > 2.0 { [8, 16] } else { [40, 80] };
        let error = |steps: u32| {
            let (scheme, step) =
                (format!("time.scheme={scheme}"), format!("time.step={}", 1.0 / f64::from(steps)));
            let more = [
                "boundary.left.condition=velocity",
                "boundary.left.velocity=[\"6*y*(1-y)*t\", 0]",
                "boundary.right.condition=windkessel",
                "boundary.right.proximal=0.7",
                "boundary.right.capacitance=0.3",
                "boundary.right.distal=2",
                "boundary.right.pressure=0.25",
                "boundary.right.initial=0.4",
                "newton.tolerance=1e-11",
                "time.end=1",
                &scheme,
                &step,
            ];
            let (row, simulation) = last(channel(&more));
            assert!((row["out"] - 1.0).abs() < 1e-9, "{scheme}: {}", row["out"]);
            let capacitor = simulation.stepper.new.s[0];
            if order == 2.0 && steps == 80 {
                let p = proximal + capacitor;
                assert!((row["p"] - p).abs() < 0.05, "{scheme}: {} for {p}", row["p"]);
            }
            (capacitor - exact).abs()
        };
        let [coarse, fine] = steps.map(error);
        let found = (coarse / fine).log2();
        // With θ = ½ + k the error changes its sign near these steps.
        assert!(
            scheme.starts_with("shifted") || (found - order).abs() < 0.15,
            "{scheme}: {coarse:e}, {fine:e}, order {found}"
        );
        assert!(fine < if order > 1.0 { 1e-4 } else { 1e-2 }, "{scheme}: {fine:e}");
    }
}

/// A given flow comes in with one pressure, and leaves through a resistance.
#[test]
fn a_given_flow_has_the_pressure_that_it_needs() {
    let more = [
        "boundary.left.condition=flux",
        "boundary.left.flow-rate=-0.5",
        "functional.p.on=[\"left\"]",
        "boundary.right.pressure=0",
    ];
    let (row, simulation) = last(channel(&more));
    assert!((row["out"] - 0.5).abs() < 1e-9, "{}", row["out"]);
    assert!((row["p"] - 6.4 * 0.5).abs() < 1e-8, "{}", row["p"]);
    assert!((simulation.stepper.new.s[0] - 3.2).abs() < 1e-8, "{:?}", simulation.stepper.new.s);
    for scheme in SCHEMES {
        let more =
            [&more[..], &[scheme, "boundary.left.flow-rate=-0.5*t", "time.step=0.1", "time.end=1"]].concat();
        let (row, _) = last(channel(&more));
        assert!((row["out"] - 0.5).abs() < 1e-9, "{scheme}: {}", row["out"]);
    }
}

/// An elastic wall that ends at an outlet with a windkessel: Jacobians, threads, resume of its scalar unknown.
#[test]
fn outlets_in_motion_have_all_derivatives() {
    for condition in ["resistance", "windkessel", "flux"] {
        let condition = format!("boundary.outflow.condition={condition}");
        let more = [
            "mesh.refine=0",
            &condition,
            "boundary.outflow.resistance=3e3",
            "boundary.outflow.proximal=3e3",
            "boundary.outflow.capacitance=1e-4",
            "boundary.outflow.distal=2e3",
            // As much as comes in.
            "boundary.outflow.flow-rate=0.41*(1 - cos(pi*t/2))",
        ];
        let mut simulation = Simulation::new(crate::common::builtin("fsi3", &more), 1).unwrap();
        let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 1 }).unwrap();
        assert!(report.agrees(), "{condition}: {report}");
        let row = simulation.step().unwrap();
        assert!(row.newton_steps < 12, "{condition}: {}", row.newton_steps);
    }
}

/// Given flows alone leave the pressure open by a constant; an elastic wall that gives way determines it.
#[test]
fn flows_alone_do_not_determine_the_pressure() {
    let flows = [
        "boundary.left.condition=flux",
        "boundary.left.flow-rate=-0.5",
        "boundary.right.condition=flux",
        "boundary.right.flow-rate=0.5",
    ];
    let inflow = ["boundary.left.condition=velocity", "boundary.left.velocity=[\"3*y*(1-y)\", 0]"];
    for more in [flows, [inflow[0], inflow[1], flows[2], flows[3]]] {
        for time in [&[][..], &["time.step=0.1", "time.end=1"]] {
            let case = channel(&[&more[..], time].concat());
            let message = Simulation::new(case, 1).err().map(|e| e.to_string()).unwrap_or_default();
            assert!(message.contains("nothing determines the pressure"), "{more:?}: {message}");
        }
    }
    let beam = ["boundary.outflow.condition=flux", "boundary.outflow.flow-rate=0", "mesh.refine=0"];
    assert!(Simulation::new(crate::common::builtin("fsi3", &beam), 1).is_ok());
}

/// A resistance that becomes negative is told before anything is computed.
#[test]
fn circuits_stay_positive() {
    let windkessel = [
        "boundary.right.condition=windkessel",
        "boundary.right.proximal=1",
        "boundary.right.capacitance=1",
        "boundary.right.distal=0.3 - t",
        "time.step=0.1",
        "time.end=1",
    ];
    let message = Simulation::new(channel(&windkessel), 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(
        message.contains("boundary.right.distal") && message.contains("above 0 at all times"),
        "{message}"
    );
    let falling = ["boundary.right.resistance=0.3 - t", "time.step=0.1", "time.end=1"];
    let message = Simulation::new(channel(&falling), 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("boundary.right.resistance") && message.contains("0 or above"), "{message}");
}

/// A bar of length 2 m between planes of symmetry under P₁₁ = t on one end and a spring on the other one: u = −t/k there,
/// and (λ + 2 μ) u' = t.
fn bar(more: &[&str]) -> Case {
    let text = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [2, 1]
cells = [4, 2]
region = { solid = "1" }
[solid]
density = 1
law = "linear"
mu = 3
lambda = 4
[boundary.left]
condition = "spring"
stiffness = 5
[boundary.right]
condition = "traction"
traction = [0.2, 0]
[boundary.top]
condition = "symmetry"
[boundary.bottom]
condition = "symmetry"
[newton]
tolerance = 1e-12
"#;
    Case::from_toml(text, "bar.toml", &sets(more)).unwrap()
}

#[test]
fn a_bar_hangs_on_a_spring() {
    for more in [&[][..], &["boundary.left.direction=normal"], &["boundary.left.pressure=0.05"]] {
        let (_, simulation) = last(bar(more));
        let left = if more.iter().any(|set| set.contains("pressure")) { 0.25 } else { 0.2 };
        // A pressure on the left pushes to the right.
        let strain = 0.2 / 10.0;
        for (x, u) in simulation.fields().coordinates().iter().zip(simulation.fields().displacement()) {
            let expected = left / 5.0 + strain * x[0];
            assert!(
                (u[0] - expected).abs() < 1e-8 && u[1].abs() < 1e-10,
                "{more:?}: {u:?} for {expected} at {x:?}"
            );
        }
    }
}

/// Between dashpots a stiff bar moves at the speed t/c in the end; condensed, in time.
#[test]
fn a_bar_moves_against_a_dashpot() {
    let more = [
        "boundary.left.stiffness=0",
        "boundary.left.damping=4",
        "time.scheme=backward-euler",
        "time.step=0.5",
        "time.end=30",
    ];
    let (_, simulation) = last(bar(&more));
    assert!(simulation.fields().velocity().iter().all(|v| (v[0] - 0.05).abs() < 1e-6 && v[1].abs() < 1e-10));
    let mut simulation = Simulation::new(bar(&more), 1).unwrap();
    let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 1 }).unwrap();
    assert!(report.agrees(), "{report}");
}

#[test]
fn outlets_and_springs_are_checked() {
    let fluid = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [1,1]\n[fluid]\ndensity = 1\n\
                 kinematic-viscosity = 1\n[boundary.left]\n";
    let message = wrong(&format!("{fluid}condition = \"windkessel\"\n"), &[]);
    for key in ["proximal", "capacitance", "distal"] {
        assert!(message.contains(&format!("boundary.left.{key}: missing")), "{message}");
    }
    assert!(!message.contains("pressure"), "{message}");
    let message = wrong(&format!("{fluid}condition = \"resistance\"\nresistance = \"1 + x\"\n"), &[]);
    assert!(message.contains("boundary.left.resistance") && message.contains("depends on"), "{message}");
    let message = wrong(
        &format!("{fluid}condition = \"windkessel\"\nproximal = 1\ncapacitance = 1\ndistal = 0\n"),
        &[],
    );
    assert!(message.contains("boundary.left.distal") && message.contains("above 0"), "{message}");
    let case = bar(&["boundary.left.condition=resistance", "boundary.left.resistance=1"]);
    let message = Simulation::new(case, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("only the solid is here"), "{message}");
    let case = channel(&["boundary.right.condition=spring", "boundary.right.stiffness=1"]);
    let message = Simulation::new(case, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("boundary.right.condition") && message.contains("spring"), "{message}");
    let notes = bar(&["boundary.left.damping=2"]).notes().join("\n");
    assert!(notes.contains("boundary.left.damping has no effect: the case is stationary"), "{notes}");
    let slack = bar(&["boundary.left.stiffness=0"]);
    let message = Simulation::new(slack, 1).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("nothing holds"), "{message}");
    for case in [channel(&[]), bar(&[])] {
        assert_eq!(Case::from_toml(&case.to_toml(), "again.toml", &[]).unwrap().boundary, case.boundary);
    }
}
