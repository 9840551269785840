//! Flows whose viscosity depends on the rate of shear.

use crate::common::{builtin, sets, wrong};
use undula::case::Case;
use undula::math::Tensor;
use undula::physics::CarreauYasuda;
use undula::simulation::Simulation;
use undula::verification::jacobians;

/// μ₀, μ_∞, λ, n, a of the tests.
type Law = [f64; 5];
const LAW: Law = [0.5, 0.05, 2.0, 0.4, 2.0];

/// The upper half of a channel of height 2 and length 1 between two pressures, 1 and 0.
fn channel([zero, infinity, time, index, transition]: Law, cells: usize, more: &[&str]) -> Case {
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 1]\ncells = [2, {cells}]\n\
         [fluid]\ndensity = 1.5\nlaw = \"carreau-yasuda\"\nviscosity-zero = {zero}\nviscosity-infinity = {infinity}\n\
         time-constant = {time}\npower-index = {index}\nyasuda-exponent = {transition}\n\
         [boundary.left]\ncondition = \"pressure\"\npressure = 1\n[boundary.right]\ncondition = \"do-nothing\"\n\
         [boundary.top]\ncondition = \"no-slip\"\n[boundary.bottom]\ncondition = \"symmetry\"\n\
         [functional.wall]\nkind = \"force\"\non = [\"top\"]\ncomponent = \"x\"\n\
         [newton]\ntolerance = 1e-12\nlinearization = \"newton\"\n"
    );
    Case::from_toml(&text, "channel.toml", &sets(more)).unwrap()
}

/// γ̇ at the height y, where the stress μ(γ̇) γ̇ is y: the pressure falls by 1 over the length 1.
fn shear([zero, infinity, time, index, transition]: Law, y: f64) -> f64 {
    let stress = |rate: f64| {
        let decay = (1.0 + (time * rate).powf(transition)).powf((index - 1.0) / transition);
        (infinity + (zero - infinity) * decay) * rate
    };
    let (mut low, mut high) = (0.0, 1.0);
    while stress(high) < y {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if stress(middle) < y { low = middle } else { high = middle }
    }
    low
}

/// The velocity at the height y, ∫ γ̇ from y to the wall, by Gauss's rule of two points on 400 intervals.
fn velocity(law: Law, y: f64) -> f64 {
    let h = (1.0 - y) / 400.0;
    let offsets = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
    let points = (0..400).flat_map(|i| offsets.map(|o| y + (f64::from(i) + o) * h));
    points.map(|y| 0.5 * h * shear(law, y)).sum()
}

/// Largest error of the velocity, and the force on the wall.
fn solve(law: Law, cells: usize, more: &[&str]) -> (f64, f64) {
    let mut simulation = Simulation::new(channel(law, cells, more), 1).unwrap();
    let row = simulation.step().unwrap();
    let fields = simulation.fields();
    let gap = |(x, v): (&[f64; 2], [f64; 2])| (v[0] - velocity(law, x[1])).abs().max(v[1].abs());
    let error = fields.coordinates().iter().zip(fields.velocity()).map(gap).fold(0.0, f64::max);
    (error, row["wall"])
}

/// Between two planes the velocity is a quadrature, and the force on the wall that of the drop of pressure. Open boundaries
/// take the viscosity of the flow: else it would not be the same along the channel.
#[test]
fn channel_flow_is_that_of_the_equation_in_one_dimension() {
    for law in [LAW, [0.5, 0.0, 5.0, 0.6, 0.8], [0.2, 0.0, 1.0, 1.4, 2.0]] {
        let [coarse, fine] = [4, 8].map(|cells| solve(law, cells, &[]));
        assert!((coarse.0 / fine.0).log2() > 2.7, "{law:?}: {coarse:?} {fine:?}");
        assert!(fine.0 < 2e-3 * velocity(law, 0.0), "{law:?}: {fine:?}");
        assert!((fine.1 - 1.0).abs() < 1e-9, "{law:?}: {fine:?}");
    }
}

/// λ γ̇ ≫ 1 and μ_∞ = 0: a power law, whose velocity on the axis is n/(n + 1) (G/K)^(1/n) with K = μ₀ λ^(n−1).
#[test]
fn high_rates_of_shear_are_a_power_law() {
    let (n, time) = (0.5, 1e4f64);
    let law = [0.4 * time.powf(1.0 - n), 0.0, time, n, 2.0];
    let closed = n / (n + 1.0) * (1.0f64 / 0.4).powf(1.0 / n);
    assert!((velocity(law, 0.0) / closed - 1.0).abs() < 1e-5, "{} {closed}", velocity(law, 0.0));
    let square = |rate: f64| Tensor([[0.0, rate], [rate, 0.0]]);
    let factor = CarreauYasuda { ratio: 0.0, time, index: n, transition: 2.0 }.factor(&square(3.0));
    assert!((factor * (3.0 * time).powf(1.0 - n) - 1.0).abs() < 1e-8);
}

/// n = 1 and μ_∞ = μ₀ are a constant viscosity, in the flow, its forces and what it dissipates.
#[test]
fn limits_are_newtonian() {
    for law in [[0.5, 0.1, 2.0, 1.0, 2.0], [0.5, 0.5, 2.0, 0.3, 2.0]] {
        let mut simulation = Simulation::new(channel(law, 2, &[]), 1).unwrap();
        simulation.step().unwrap();
        let fields = simulation.fields();
        for (x, v) in fields.coordinates().iter().zip(fields.velocity()) {
            assert!((v[0] - (1.0 - x[1] * x[1])).abs() < 1e-10, "{law:?}: {v:?} at {x:?}");
        }
    }
}

/// What is dissipated is the work of the pressure, ∫ μ γ̇² dy = ∫ y γ̇ dy.
#[test]
fn dissipation_has_the_viscosity_of_the_flow() {
    let case = channel(LAW, 8, &[r#"functional.loss={kind="energy", term="dissipation"}"#]);
    let mut simulation = Simulation::new(case, 1).unwrap();
    let row = simulation.step().unwrap();
    let n = 2000;
    let expected: f64 =
        (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n)).map(|y| y * shear(LAW, y) / f64::from(n)).sum();
    assert!((row["loss"] / expected - 1.0).abs() < 1e-4, "{} {expected}", row["loss"]);
}

#[test]
fn jacobians_know_the_viscosity() {
    for scheme in ["crank-nicolson", "cg1", "bdf2"] {
        let scheme = format!("time.scheme={scheme}");
        let more = [
            "fluid.law=carreau-yasuda",
            "fluid.kinematic-viscosity=none",
            "fluid.viscosity-zero=2",
            "fluid.viscosity-infinity=0.5",
            "fluid.time-constant=0.1",
            "fluid.power-index=0.4",
            "mesh.refine=0",
            &scheme,
        ];
        let mut simulation = Simulation::new(builtin("fsi3", &more), 1).unwrap();
        let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 1 }).unwrap();
        assert!(report.agrees(), "{scheme}: {report}");
    }
}

#[test]
fn laws_of_viscosity_are_checked() {
    let text = "[mesh]\ngenerator = \"schaefer-turek\"\n[fluid]\ndensity = 1\nlaw = \"carreau-yasuda\"\n";
    let message = wrong(text, &[]);
    for key in ["viscosity-zero", "viscosity-infinity", "time-constant", "power-index"] {
        assert!(message.contains(&format!("fluid.{key}: missing")), "{message}");
    }
    let all = [
        "fluid.viscosity-zero=1",
        "fluid.viscosity-infinity=2",
        "fluid.time-constant=1",
        "fluid.power-index=0.5",
        "fluid.kinematic-viscosity=1",
        "space.velocity=Q1",
        "space.pressure=Q1",
        "stabilization.pressure=pspg",
    ];
    let message = wrong(text, &all);
    assert!(message.contains("expected a number from 0 to viscosity-zero"), "{message}");
    assert!(message.contains("expected `viscosity-zero` [Pa s]"), "{message}");
    assert!(message.contains("constant viscosity"), "{message}");
    let message = wrong(crate::common::FLUID, &["fluid.power-index=0.5"]);
    assert!(message.contains("only for law = \"carreau-yasuda\""), "{message}");
}
