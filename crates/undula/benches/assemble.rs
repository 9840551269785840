//! Residual and Jacobian of fsi3 by number of lanes and of threads.
//!
//! `cargo bench --bench assemble [-- REFINE]` prints medians per cell and, measured side by side in the
//! same run, how many times faster than one lane on one thread. A plain program: no harness.

use std::sync::Arc;
use std::time::Instant;
use undula::algebra::Csr;
use undula::case::Case;
use undula::physics::StepRule;
use undula::space::{BoundaryCondition, FsiSpace, State};
use undula::system::{Assembler, Options, StepView, available};
use undula::tangent::Tangent;

/// Measurements per configuration; they take turns, so that a slow minute hits all alike.
const ROUNDS: usize = 15;

struct Candidate {
    lanes: usize,
    threads: usize,
    assembler: Assembler<2>,
    pool: rayon::ThreadPool,
    matrix: Csr,
    seconds: [Vec<f64>; 3],
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A smooth motion of a few millimetres, so that no term vanishes.
fn state(space: &FsiSpace<2>, phase: f64) -> State {
    let mut s = State::zero(space.n_v(), space.n_u(), space.n_p());
    for (node, x) in space.nodes.points.iter().enumerate() {
        for i in 0..2 {
            s.v[2 * node + i] = (7.0 * x[0] + 9.0 * x[1] + phase + i as f64).sin();
            s.u[2 * node + i] = 2e-3 * (5.0 * x[0] - 8.0 * x[1] + phase + i as f64).cos();
        }
    }
    s
}

fn main() {
    let refine = std::env::args().skip(1).find_map(|a| a.parse::<u32>().ok()).unwrap_or(1);
    let case = Case::builtin("fsi3", &[format!("mesh.refine={refine}")]).expect("a built-in case");
    let space = Arc::new(case.build_space().expect("its own mesh"));
    let conditions = vec![BoundaryCondition::Fixed; space.mesh.boundaries.len()];
    let mut candidates: Vec<Candidate> = [(1, 1), (4, 1), (8, 1), (1, 2), (4, 2), (8, 2)]
        .into_iter()
        .filter(|(lanes, _)| available(*lanes))
        .map(|(lanes, threads)| {
            let options = Options { lanes, threads, quadrature: 3 };
            let mut assembler =
                Assembler::new(space.clone(), case.physics(), &conditions, &|_| 1.0, &options);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let matrix = Csr::zeros(&assembler.pattern());
            Candidate { lanes, threads, assembler, pool, matrix, seconds: [vec![], vec![], vec![]] }
        })
        .collect();
    let (new, old) = (state(&space, 0.0), state(&space, 0.1));
    let view = StepView { rule: StepRule::theta(0.005, 0.505), new: &new, old: &old };
    let mut out = vec![0.0; space.n_field_unknowns()];
    for _ in 0..=ROUNDS {
        for c in &mut candidates {
            let Candidate { assembler, pool, matrix, seconds, .. } = c;
            pool.install(|| {
                let start = Instant::now();
                assembler.residual(&view, &mut out);
                seconds[0].push(start.elapsed().as_secs_f64());
                for (n, tangent) in [Tangent::Automatic, Tangent::Analytic].into_iter().enumerate() {
                    let start = Instant::now();
                    assembler.jacobian(&view, tangent, matrix);
                    seconds[n + 1].push(start.elapsed().as_secs_f64());
                }
            });
        }
    }
    let cells = space.mesh.n_cells();
    println!("{cells} cells, {} unknowns, medians of {ROUNDS}", space.n_field_unknowns());
    println!("lanes threads | residual ms  µs/cell  times | Jacobian ms (dual)  times | by hand ms  times");
    let mut base = None;
    for c in &mut candidates {
        // The first round warms up.
        let t: [f64; 3] = std::array::from_fn(|i| median(&mut c.seconds[i][1..]));
        let base = *base.get_or_insert(t);
        println!(
            "{:5} {:7} | {:11.3} {:8.3} {:6.2} | {:18.3} {:6.2} | {:10.3} {:6.2}",
            c.lanes,
            c.threads,
            1e3 * t[0],
            1e6 * t[0] / cells as f64,
            base[0] / t[0],
            1e3 * t[1],
            base[1] / t[1],
            1e3 * t[2],
            base[2] / t[2],
        );
    }
}
