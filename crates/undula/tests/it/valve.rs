//! The built-in case `valve`: leaflets in a pulsating flow, an RCR circuit behind.

use crate::common::builtin;
use undula::simulation::Simulation;

const PROXIMAL: f64 = 1e4;
const CAPACITANCE: f64 = 1e-5;
const DISTAL: f64 = 4e4;

/// What a run leaves step by step.
#[derive(Clone, Copy, Debug)]
struct Instant {
    tip: f64,
    inflow: f64,
    outflow: f64,
    /// Mean pressure of the outlet, at t⁻ + θ k.
    pressure: f64,
    /// P_c.
    circuit: f64,
}

/// All steps, the start before them, and θ.
fn run(more: &[&str]) -> (Vec<Instant>, f64, Simulation) {
    let case = builtin("valve", more);
    let theta = case.theta().unwrap();
    let mut simulation = Simulation::new(case, 1).unwrap();
    let start = simulation.stepper.new.s[0];
    let mut list = vec![Instant { tip: 0.0, inflow: 0.0, outflow: 0.0, pressure: start, circuit: start }];
    while !simulation.finished() {
        let row = simulation.step().unwrap();
        list.push(Instant {
            tip: row["uy_tip"],
            inflow: row["inflow"],
            outflow: row["outflow"],
            pressure: row["pressure"],
            circuit: simulation.stepper.new.s[0],
        });
    }
    (list, theta, simulation)
}

#[test]
#[ignore = "long"]
fn a_valve_opens_and_falls_back_in_every_period() {
    let (steps, k) = (50, 0.02);
    let (list, theta, simulation) = run(&["time.step=0.02", "time.end=1.6"]);
    assert_eq!(list.len(), 81);
    // Opening and closing repeat themselves, but for what the start leaves.
    let opening = |part: &[Instant]| part.iter().map(|at| -at.tip).fold(0.0, f64::max);
    let (first, second) = (opening(&list[..=steps]), opening(&list[steps..]));
    println!(
        "tips by {:.4} and {:.4} mm, back to {:.4} mm",
        1e3 * first,
        1e3 * second,
        1e3 * list[steps].tip
    );
    for (a, b) in list[..=30].iter().zip(&list[steps..]).skip(15) {
        assert!((a.tip - b.tip).abs() < 0.01 * second, "{a:?} {b:?}");
        assert!((a.pressure - b.pressure).abs() < 0.5, "{a:?} {b:?}");
    }
    assert!(list[steps].tip.abs() < 0.1 * second);
    // Converged: see validation/examples.md.
    assert!((second / CONVERGED - 1.0).abs() < 0.06, "{second}");
    // What comes in goes out, but for the fluid between the walls of the mesh that moves: nothing over a period.
    let balance = simulation.balance.as_ref().unwrap();
    assert!(balance.mass().unwrap() < 1e-6, "{:?}", balance.mass());
    let sum = |f: fn(&Instant) -> f64| k * list[31..].iter().map(f).sum::<f64>();
    let (come, gone) = (-sum(|at| at.inflow), sum(|at| at.outflow));
    assert!((come - 1e-3).abs() < 1e-9 && (gone / come - 1.0).abs() < 1e-3, "{come} {gone}");
    follows_its_circuit(&list, theta, k);
}

/// How far the tips go apart from where they are at rest \[m\].
const CONVERGED: f64 = 1.716e-3;

/// C dP_c/dt = Q − P_c/R_d by the scheme of the flow, step by step; p = R_p Q + P_c at the outlet.
fn follows_its_circuit(list: &[Instant], theta: f64, k: f64) {
    let rate = |at: &Instant| (at.outflow - at.circuit / DISTAL) / CAPACITANCE;
    let load = |at: &Instant| PROXIMAL * at.outflow + at.circuit;
    let mut exact = list[0].circuit;
    let tau = DISTAL * CAPACITANCE;
    let mut largest = [0.0f64; 3];
    for pair in list.windows(2) {
        let [old, new] = [pair[0], pair[1]];
        let mean = |f: &dyn Fn(&Instant) -> f64| theta * f(&new) + (1.0 - theta) * f(&old);
        let scheme = (new.circuit - old.circuit) / k - mean(&rate);
        largest[0] = largest[0].max(scheme.abs() * k / new.circuit);
        largest[1] = largest[1].max((new.pressure / mean(&load) - 1.0).abs());
        // Of a flow that is linear in each step, exactly.
        let (decay, slope) = ((-k / tau).exp(), (new.outflow - old.outflow) / k);
        let particular = |q: f64| DISTAL * (q - slope * tau);
        exact = (exact - particular(old.outflow)) * decay + particular(new.outflow);
        largest[2] = largest[2].max((new.circuit / exact - 1.0).abs());
    }
    println!("scheme {:.1e}, pressure {:.1e}, exact {:.1e}", largest[0], largest[1], largest[2]);
    assert!(largest[0] < 1e-7, "{largest:?}");
    assert!(largest[1] < 1e-2, "{largest:?}");
    assert!(largest[2] < 2e-3, "{largest:?}");
}

/// P_c against that of the circuit alone, driven by the flow that was computed: of second order.
#[test]
fn the_circuit_behind_a_valve_is_of_second_order() {
    let gap = |step: &str, k: f64| {
        let crank = "time.scheme=crank-nicolson";
        let (list, _, _) = run(&[step, "time.end=0.4", crank, "solid.young=1e6", "motion.model=harmonic"]);
        let tau = DISTAL * CAPACITANCE;
        let mut exact = list[0].circuit;
        for pair in list.windows(2) {
            let (decay, slope) = ((-k / tau).exp(), (pair[1].outflow - pair[0].outflow) / k);
            let particular = |q: f64| DISTAL * (q - slope * tau);
            exact = (exact - particular(pair[0].outflow)) * decay + particular(pair[1].outflow);
        }
        list[list.len() - 1].circuit - exact
    };
    let (coarse, fine) = (gap("time.step=0.04", 0.04), gap("time.step=0.02", 0.02));
    println!("{coarse:.2e} {fine:.2e}");
    assert!(((coarse / fine).log2() - 2.0).abs() < 0.2, "{coarse} {fine}");
}
