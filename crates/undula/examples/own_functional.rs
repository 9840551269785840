//! Functionals of one's own: an integral over the flow, and a value at a moving point.
//!
//! `cargo run --release --features examples --example own_functional`

use undula::{CaseBuilder, Error, Row, Simulation};

/// Computes `steps` steps of `fsi3` and returns their rows. Beside its built-in functionals they have
///
/// - `energy_own`, the kinetic energy of the flow ½ (ρ J v, v) \[J/m\], and `energy`, the built-in one;
/// - `speed_behind`, the speed 5 cm behind the beam \[m/s\].
pub fn rows(steps: usize, refine: u32) -> Result<Vec<Row>, Error> {
    let case = CaseBuilder::load("fsi3")?
        .set("mesh.refine", refine)
        .set("time.step", 0.02)
        .set("functional.energy.kind", "energy")
        .set("functional.energy.term", "fluid-kinetic")
        .build()?;
    let density = case.fluids.first().map_or(0.0, |fluid| fluid.density);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut simulation = Simulation::new(case, threads)?;
    simulation.record("energy_own", "J/m", move |fields| {
        fields.integrate(|point| {
            let [v_x, v_y] = point.velocity;
            let in_fluid = if point.is_solid { 0.0 } else { 1.0 };
            0.5 * in_fluid * density * point.jacobian() * (v_x * v_x + v_y * v_y)
        })
    });
    // The search for the point is done once.
    let behind = simulation.fields().locate([0.65, 0.2])?;
    simulation.record("speed_behind", "m/s", move |fields| {
        let [v_x, v_y] = fields.value(&behind).velocity;
        v_x.hypot(v_y)
    });
    (0..steps).map(|_| simulation.step()).collect()
}

fn main() -> Result<(), Error> {
    for row in rows(50, 1)? {
        let (energy, speed) = (row["energy_own"], row["speed_behind"]);
        println!("{:.2} s: {energy:.4} J/m, {speed:.3} m/s, drag {:.2} N/m", row.time, row["drag"]);
    }
    Ok(())
}
