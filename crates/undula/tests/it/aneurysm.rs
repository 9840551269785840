//! The case `examples/aneurysm.toml`: a wall grown around a lumen of tetrahedra, measured under pressure, with blood, tissue
//! and an RCR circuit.

use crate::common::sets;
use std::path::Path;
use undula::case::Case;
use undula::simulation::Simulation;

/// R_p, R_d \[Pa s/m³\] and C \[m³/Pa\] of the circuit.
const PROXIMAL: f64 = 4.5e8;
const DISTAL: f64 = 4.5e9;
const CAPACITANCE: f64 = 7e-11;
/// Flow at the start \[m³/s\], which is heartbeat.csv's.
const FLOW: f64 = 1.9e-6;

/// The beat begins with the equilibrium of the flow at its start, in which the measured wall rests; then the circuit takes
/// what flows out, and what stays behind is the growth of the lumen.
#[test]
#[ignore = "long"]
fn a_measured_aneurysm_rests_until_the_heart_beats() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/aneurysm.toml");
    let still = sets(&[
        "boundary.inflow.flow-rate=-1.9e-6",
        "time.end=0.02",
        "newton.tolerance=1e-9",
        "stabilization.transport=off",
    ]);
    let beats = sets(&["time.end=0.15", "time.step=0.03"]);
    let [still, beats] = [still, beats].map(|sets| Case::load(path.to_str().unwrap(), &sets).unwrap());
    let theta = beats.theta().unwrap();

    let mut simulation = Simulation::in_space(still, 1).unwrap();
    assert!(
        (simulation.stepper.new.s[0] / (DISTAL * FLOW) - 1.0).abs() < 1e-6,
        "{:?}",
        simulation.stepper.new.s
    );
    while !simulation.finished() {
        let row = simulation.step().unwrap();
        let u = simulation.stepper.new.u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        println!("{u:e} m, {} and {} Pa", row["pressure"], row["pressure-outlet"]);
        // Of a thickness of 4e-4 m.
        assert!(u < 1e-8 * 4e-4, "{u:e}");
        assert!(
            (row["pressure-outlet"] / ((PROXIMAL + DISTAL) * FLOW) - 1.0).abs() < 1e-3,
            "{}",
            row["pressure-outlet"]
        );
    }

    let mut simulation = Simulation::in_space(beats, 1).unwrap();
    let mut old = (FLOW, DISTAL * FLOW);
    let mut grown = 0.0;
    while !simulation.finished() {
        let row = simulation.step().unwrap();
        let new = (row["outflow"], simulation.stepper.new.s[0]);
        let mean = |old: f64, new: f64| theta * new + (1.0 - theta) * old;
        let stored = CAPACITANCE * (new.1 - old.1) / 0.03;
        let through = mean(old.0, new.0) - mean(old.1, new.1) / DISTAL;
        assert!((stored - through).abs() < 1e-6 * new.0, "{stored:e} {through:e}");
        let pressure = PROXIMAL * mean(old.0, new.0) + mean(old.1, new.1);
        assert!(
            (row["pressure-outlet"] / pressure - 1.0).abs() < 2e-3,
            "{} {pressure}",
            row["pressure-outlet"]
        );
        grown += -row["inflow"] - row["outflow"];
        old = new;
    }
    // The pressure rises, and the lumen with it: the top of the bulge moves away from the bend.
    let row = simulation.history.last().unwrap();
    println!("{:?}", row.values);
    assert!(row["pressure"] > 1.1e4 && row["ux_dome"] < -4e-6 && grown > 0.0, "{:?}", row.values);
    assert!(simulation.balance.as_ref().unwrap().mass().unwrap() < 1e-6);
}
