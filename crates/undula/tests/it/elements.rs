//! The benchmark with every element.

use crate::common::builtin;
use undula::simulation::Simulation;

/// Velocity and pressure as in a case.
const PAIRS: [[&str; 2]; 9] = [
    ["Q2", "P1dc"],
    ["Q2", "Q1"],
    ["Q3", "P2dc"],
    ["Q3", "Q2"],
    ["Q4", "P3dc"],
    ["P2", "P1"],
    ["P2-bubble", "P1dc"],
    ["P3", "P2"],
    ["P3", "P1dc"],
];

/// Drag and lift \[N/m\] and deflection \[m\] of FSI-1 (NGSolve, corners graded to 1e-6), and how far from them the
/// coarsest mesh may be: the corners of the tip decide lift and deflection.
const REFERENCE: [(&str, f64, f64); 3] =
    [("drag", 14.2940, 0.006), ("lift", 0.76475, 0.05), ("uy_A", 8.1859e-4, 0.07)];

fn run(case: &str, [velocity, pressure]: [&str; 2], more: &[&str]) -> Simulation {
    let space = [format!("space.velocity={velocity}"), format!("space.pressure={pressure}")];
    let sets = [&[space[0].as_str(), space[1].as_str(), "mesh.refine=0"], more].concat();
    let mut simulation = Simulation::new(builtin(case, &sets), 1).unwrap();
    while !simulation.finished() {
        simulation.step().unwrap_or_else(|e| panic!("{case} {velocity}-{pressure}: {e}"));
    }
    simulation
}

#[test]
#[ignore = "long"]
fn fsi1_comes_near_the_reference_with_every_element() {
    let mut failures = vec![];
    for pair in PAIRS {
        let simulation = run("fsi1", pair, &[]);
        let values = &simulation.history.last().unwrap().values;
        let mut line =
            format!("{pair:?}, {} unknowns:", simulation.stepper.assembler.space.n_field_unknowns());
        for (name, reference, tolerance) in REFERENCE {
            let at = simulation.names().iter().position(|n| *n == name).unwrap();
            let deviation = values[at] / reference - 1.0;
            line += &format!(" {name} {:.5e} ({:+.2} %)", values[at], 100.0 * deviation);
            if deviation.abs() > tolerance {
                failures.push(format!("{pair:?} {name}: {}", values[at]));
            }
        }
        println!("{line}");
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// The condensed system, with what it eliminates inside of cells, against the whole Jacobian in motion.
#[test]
fn condensed_and_whole_newton_agree_on_triangles_and_high_degrees() {
    let common = ["time.end=0.04", "time.step=0.01", "newton.tolerance=1e-10"];
    for pair in [["P2-bubble", "P1dc"], ["P3", "P1dc"], ["P2", "P1"], ["Q3", "P2dc"]] {
        let [condensed, whole] = ["condensed", "newton"].map(|kind| {
            let linearization = format!("newton.linearization={kind}");
            run("fsi3", pair, &[&common[..], &[linearization.as_str()]].concat())
        });
        let (a, b) = (&condensed.stepper.new, &whole.stepper.new);
        for (field, a, b) in [("v", &a.v, &b.v), ("u", &a.u, &b.u), ("p", &a.p, &b.p)] {
            let size = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let gap = a.iter().zip(b).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs())) / size;
            println!("{pair:?} {field}: {gap:.1e}");
            assert!(gap < 1e-6, "{pair:?} {field}: {gap:e}");
        }
    }
}
