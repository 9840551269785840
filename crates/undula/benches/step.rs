//! Whole steps of fsi3 and their parts by size, from the start of the inflow; `undula bench` measures any case.
//!
//! `cargo bench --bench step [-- REFINE...]`. A plain program: no harness.

use undula::bench::{Options, measure};
use undula::case::Case;
use undula::simulation::Simulation;

fn main() {
    let mut sizes: Vec<u32> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![0, 1, 2];
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    for refine in sizes {
        let case = Case::builtin("fsi3", &[format!("mesh.refine={refine}")]).expect("a built-in case");
        let mut simulation = Simulation::new(case, threads).expect("it fits its mesh");
        let options = Options { steps: 50, repeat: 3, kernels: true };
        println!("{}", measure(&mut simulation, &options).expect("a solution"));
    }
}
