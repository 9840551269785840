//! The rotor of section 5.3.5: a free bar turned by the flow until the mesh folds.

use undula::error::Error;
use undula::problem::case::Case;
use undula::simulation::Simulation;

fn rotor(overrides: &[&str]) -> Simulation {
    let overrides: Vec<String> = overrides.iter().map(|s| s.to_string()).collect();
    Simulation::new(Case::load("rotor", &overrides).unwrap(), 1).unwrap()
}

/// J(t) = (1/|S|) ∫_S x × u dx at 8.6, 9.0, 11.6, 14.0, 14.9 s, on 288 cells with k = 0.1 s. Under refinement the
/// deviations from the converged values become less than 0.3 %, see validation/rotor.md.
#[test]
fn rotation_follows_the_converged_curve() {
    let mut simulation = rotor(&["mesh.refine=1", "time.step=0.1"]);
    let mut expected = vec![(8.6, 0.03493), (9.0, 0.03783), (11.6, 0.05521), (14.0, 0.06793), (14.9, 0.07168)];
    while !simulation.finished() {
        let row = simulation.step().unwrap();
        if let Some(at) = expected.iter().position(|(t, _)| (row.time - t).abs() < 1e-6) {
            let (t, value) = expected.remove(at);
            println!("t = {t}: {} instead of {value}, min J {}", row.values[0], row.min_j);
            assert!((row.values[0] / value - 1.0).abs() < 8e-3, "t = {t}: {}", row.values[0]);
        }
    }
    assert!(expected.is_empty());
}

/// The step at which the mesh folds is tried in smaller parts; then all is as it was before, with the cells named.
#[test]
fn breakdown_leaves_the_last_solution() {
    let mut simulation =
        rotor(&["mesh.refine=0", "time.step=0.2", "time.end=30", "motion.model=harmonic", "time.max-halvings=3"]);
    let failure = loop {
        let before = simulation.stepper.new.clone();
        let time = simulation.stepper.time;
        match simulation.step() {
            Ok(row) => assert!(row.min_j > 0.0 && !simulation.finished(), "min J = {} at {}", row.min_j, row.time),
            Err(Error::Breakdown(failure)) => {
                assert!(simulation.stepper.new == before && simulation.stepper.time == time);
                break failure;
            }
            Err(other) => panic!("{other}"),
        }
    };
    println!("{failure}: {:?}", failure.worst);
    assert!(failure.time > 5.0 && failure.time < 20.0, "{failure}");
    assert!(failure.worst.min_j <= 0.0 && !failure.worst.cells.is_empty());
    assert!((failure.step - 0.2 / 8.0).abs() < 1e-12);
}
