//! Many cases on all cores: each thread takes the next case that nobody has, with one simulation at a time.
//!
//! `cargo run --release --features examples --example sweep`

use std::sync::Mutex;
use std::thread::{available_parallelism, scope};
use undula::{CaseBuilder, Error, Simulation};

/// How far the tip of the beam of `csm1` sinks \[m\] with the shear modulus `mu` \[Pa\], Poisson ratio 0.4.
fn tip(mu: f64, refine: u32) -> Result<f64, Error> {
    let case = CaseBuilder::load("csm1")?
        .set("mesh.refine", refine)
        .set("solid.mu", mu)
        .set("solid.lambda", 4.0 * mu)
        .build()?;
    Ok(-Simulation::new(case, 1)?.step()?["uy_A"])
}

/// The same for every modulus of `list`, in its order.
pub fn tips(list: &[f64], refine: u32) -> Result<Vec<f64>, Error> {
    let next = Mutex::new(list.iter().enumerate());
    let found = Mutex::new(vec![]);
    let threads = available_parallelism().map_or(1, usize::from);
    scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let take = || next.lock().expect("no thread has panicked").next();
                while let Some((n, &mu)) = take() {
                    let result = tip(mu, refine);
                    found.lock().expect("no thread has panicked").push((n, result));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no thread has panicked");
    found.sort_by_key(|(n, _)| *n);
    found.into_iter().map(|(_, result)| result).collect()
}

fn main() -> Result<(), Error> {
    let moduli: Vec<f64> = (1..=16).map(|n| 0.25e6 * f64::from(n)).collect();
    for (mu, tip) in moduli.iter().zip(tips(&moduli, 1)?) {
        println!("mu = {:.2} MPa: {:.3} mm", 1e-6 * mu, 1e3 * tip);
    }
    Ok(())
}
