//! What `undula bench` measures is what it says.

use crate::common::builtin;
use undula::bench::{Start, Timing, measure_kernels};
use undula::simulation::Simulation;

/// fsi3 in motion after some steps.
fn moving(steps: usize) -> Simulation {
    let case = builtin("fsi3", &["mesh.refine=0", "time.step=0.01", "solid.body-force=[0,-2]"]);
    let mut simulation = Simulation::new(case, 1).unwrap();
    (0..steps).for_each(|_| drop(simulation.step().unwrap()));
    simulation
}

#[test]
fn repetitions_have_the_same_bits() {
    let mut simulation = moving(4);
    let start = Start::of(&simulation);
    let mut repetition = || {
        start.restore(&mut simulation).unwrap();
        (0..6).map(|_| simulation.step().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(repetition(), repetition());
}

#[test]
fn differences_are_the_jacobian() {
    let mut simulation = moving(5);
    let kernels = simulation.install(|s| measure_kernels(s, 0.01)).unwrap();
    let deviation = kernels.difference_deviation.unwrap();
    assert!(deviation < 1e-6, "{deviation:e}");
    assert!(kernels.left_out.is_empty(), "{:?}", kernels.left_out);
    for (name, timing) in kernels.named() {
        let Timing { seconds, calls, .. } = timing.unwrap_or_else(|| panic!("{name}"));
        assert!(seconds > 0.0 && calls > 0, "{name}");
    }
    let bytes = |timing: Option<Timing>| timing.unwrap().bytes.unwrap();
    assert_eq!(bytes(kernels.apply_double), 2.0 * bytes(kernels.apply_single));
    assert!(kernels.factor_single.unwrap().flops > kernels.apply_single.unwrap().flops);
}
