//! A time loop of one's own: stop at an event, look at the fields on the way.
//!
//! `cargo run --release --features examples --example step_by_step`

use undula::{CaseBuilder, Error, Simulation};

/// What the loop has found.
pub struct Found {
    /// When the tip of the beam was lower than `depth` for the first time \[s\].
    pub time: f64,
    /// Displacement of the tip at that time \[m\].
    pub tip: f64,
    /// Its largest speed on the way \[m/s\].
    pub fastest: f64,
    /// Lowest displacement of all nodes at that time \[m\].
    pub lowest: f64,
}

/// Lets the beam of `csm3` fall under its weight, in steps of `k` \[s\], until its tip is `depth` \[m\] below its place at
/// rest.
pub fn fall(depth: f64, k: f64, refine: u32) -> Result<Found, Error> {
    let case = CaseBuilder::load("csm3")?.set("mesh.refine", refine).set("time.step", k).build()?;
    let mut simulation = Simulation::new(case, 1)?;
    let tip = simulation.fields().locate([0.6, 0.2])?;
    let (mut fastest, mut displacement) = (0.0, 0.0);
    while displacement > -depth && !simulation.finished() {
        let row = simulation.step()?;
        displacement = row["uy_A"];
        let [v_x, v_y] = simulation.fields().value(&tip).velocity;
        fastest = f64::max(fastest, v_x.hypot(v_y));
    }
    let lowest = simulation.fields().displacement().iter().fold(0.0, |low, u| f64::min(low, u[1]));
    Ok(Found { time: simulation.time(), tip: displacement, fastest, lowest })
}

fn main() -> Result<(), Error> {
    let found = fall(0.05, 0.01, 1)?;
    println!("after {:.2} s the tip is {:.1} mm lower", found.time, -1e3 * found.tip);
    println!(
        "it moved at up to {:.3} m/s; the lowest node fell by {:.1} mm",
        found.fastest,
        -1e3 * found.lowest
    );
    Ok(())
}
