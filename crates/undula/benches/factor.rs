//! Medians of factorisation, substitution (`apply`) and refined solve on matrices of the coupled
//! problem, in seconds of wall time; of factorisations also processor time of all threads where the
//! system tells (so that other programs do not count). No probe. `once` is ‖b − A x‖ / ‖b‖ after one
//! `apply`.
//!
//!     cargo bench --bench factor                        # generated matrices
//!     cargo bench --bench factor -- FILE.bin...         # stored systems
//!     cargo bench --bench factor -- 88x44               # generated ones of this name
//!     cargo bench --bench factor -- single faer         # these solvers; definite ones
//!                                               # (L D Lᵀ, in single precision) for extension.bin
//!     cargo bench --bench factor --features mumps -- single double mumps     # all orderings of MUMPS
//!     RAYON_NUM_THREADS=1 cargo bench --bench factor
//!
//! A stored system is, in little endian: u64 n, u64 nnz, row_ptr u64[n + 1], col u32[nnz],
//! values f64[nnz], right-hand side f64[n], node u32[n], kind u8[n] (0 v, 1 u, 2 p), xyz f64[3 n].

#[allow(dead_code)]
#[path = "../tests/solver/matrices.rs"]
mod matrices;

use matrices::{Pressure, Setup, System};
use std::{fs, sync::Arc, time::Instant};
use undula::algebra::{Csr, FaerLu, Kind, LinearSolver, MultifrontalLu, Options, Pattern, Unknown, norm_inf};

fn main() {
    // On a thread of the pool, as in the program: from outside, every call would wake one.
    rayon::scope(|_| measure_all());
}

fn measure_all() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let (files, words): (Vec<String>, Vec<String>) = arguments.into_iter().partition(|a| a.ends_with(".bin"));
    let (names, words): (Vec<String>, Vec<String>) =
        words.into_iter().partition(|a| SOLVERS.contains(&a.as_str()));
    let names = if names.is_empty() { vec!["single".into(), "double".into()] } else { names };
    println!(
        "{:<26} {:<19} {:>7} {:>9} | {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} | {:>9} {:>9} {:>7} {:>6} {:>2} {:>8} {:>8}",
        "matrix",
        "solver",
        "n",
        "nnz",
        "analyse",
        "factor",
        "wall",
        "apply",
        "least",
        "solve",
        "fill",
        "flops",
        "delayed",
        "MB",
        "ir",
        "error",
        "once"
    );
    if files.is_empty() {
        use Pressure::{P1dc, Q1};
        let setups = [
            ("v-p", Setup::flow(38, 19, P1dc)),
            ("v-p", Setup::flow(76, 38, P1dc)),
            ("v-p", Setup::flow(156, 78, P1dc)),
            ("v-p", Setup::flow(350, 175, P1dc)),
            ("extension", Setup::flow(38, 19, P1dc)),
            ("extension", Setup::flow(156, 78, P1dc)),
            ("flow Q2-P1dc", Setup::flow(52, 26, P1dc)),
            ("flow Q2-P1dc", Setup::flow(84, 42, P1dc)),
            ("fsi Q2-P1dc", Setup::fsi(39, 20, P1dc)),
            ("fsi Q2-Q1", Setup::fsi(39, 20, Q1)),
            ("fsi Q2-P1dc", Setup::fsi(88, 44, P1dc)),
            ("fsi Q2-Q1", Setup::fsi(88, 44, Q1)),
            ("fsi Q2-P1dc", Setup::fsi(156, 78, P1dc)),
            ("flow Q2-P1dc 3D", Setup { cells: [12, 8, 8], ..Setup::flow(0, 0, P1dc) }),
        ];
        for (kind, setup) in setups {
            let [x, y, z] = setup.cells;
            let name = format!("{kind} {x}x{y}x{z}");
            if !words.is_empty() && !words.iter().any(|w| name.contains(w)) {
                continue;
            }
            let system = match kind {
                "v-p" => setup.condensed(),
                "extension" => setup.velocities(),
                _ => setup.system(),
            };
            let mut b = vec![0.0; system.a.pattern.n];
            system.a.mul(&vec![1.0; b.len()], &mut b);
            run(&name, &system, &b, &names);
        }
    }
    for file in files {
        let (system, b) = read(&file);
        run(file.rsplit('/').next().unwrap_or(&file), &system, &b, &names);
    }
}

/// What can be measured.
const SOLVERS: [&str; 5] = ["single", "double", "definite", "faer", "mumps"];

fn run(name: &str, system: &System, b: &[f64], solvers: &[String]) {
    let times = (1_000_000 / b.len()).clamp(5, 101) | 1;
    let double = Options::unprobed();
    for solver in solvers {
        match solver.as_str() {
            "single" => {
                let options = Options { refinement: 30, ..double };
                measure(name, system, b, &mut MultifrontalLu::single(options), times);
            }
            "definite" => {
                let options = Options { refinement: 30, ..double };
                measure(name, system, b, &mut MultifrontalLu::single_definite(options), times);
            }
            "double" => measure(name, system, b, &mut MultifrontalLu::multifrontal(double), times),
            "faer" => measure(name, system, b, &mut FaerLu::faer(double), 1),
            #[cfg(feature = "mumps")]
            _ => {
                for ordering in undula::algebra::Ordering::ALL {
                    measure(name, system, b, &mut undula::algebra::MumpsLu::mumps(double, ordering), times);
                }
            }
            #[cfg(not(feature = "mumps"))]
            _ => println!("MUMPS is behind the feature `mumps`"),
        }
    }
}

fn measure(
    name: &str,
    System { a, unknowns }: &System,
    b: &[f64],
    solver: &mut dyn LinearSolver,
    times: usize,
) {
    let start = Instant::now();
    solver.analyse(&a.pattern, unknowns).unwrap();
    let analyse = start.elapsed().as_secs_f64();
    let mut x = vec![0.0; b.len()];
    let (mut factors, mut applies, mut solves, mut factor) = (vec![], vec![], vec![], None);
    for _ in 0..times {
        let start = Clock::now();
        match solver.factor(a) {
            Ok(report) => factor = Some(report),
            Err(e) => return println!("{name:<26} {:<19} {e}", solver.name()),
        }
        factors.push(start.elapsed());
    }
    let Some(factor) = factor else { return };
    for _ in 0..4 * times {
        let start = Clock::now();
        solver.apply(b, &mut x);
        applies.push(start.elapsed());
    }
    let once = residual(a, b, &x);
    let mut solve = None;
    for _ in 0..times {
        let start = Clock::now();
        solve = Some(solver.solve(a, b, &mut x));
        solves.push(start.elapsed());
    }
    let solve = match solve.unwrap() {
        Ok(solve) => solve,
        Err(e) => return println!("{name:<26} {:<19} {e}", solver.name()),
    };
    let ([factor_time, factor_wall], [_, solve_wall]) = (median(&factors), median(&solves));
    println!(
        "{name:<26} {:<19} {:>7} {:>9} | {analyse:8.4} {factor_time:8.4} {factor_wall:8.5} {:8.5} {:8.5} {solve_wall:8.5} | {:9.3e} {:9.3e} {:>7} {:6.1} {:>2} {:8.1e} {:8.1e}",
        solver.name(),
        b.len(),
        a.pattern.nnz(),
        median(&applies)[1],
        applies.iter().map(|t| t[1]).fold(f64::INFINITY, f64::min),
        factor.cost.fill.unwrap_or(0) as f64,
        factor.cost.flops.unwrap_or(0.0),
        factor.cost.delayed,
        factor.cost.bytes.unwrap_or(0) as f64 / 1e6,
        solve.refinements,
        solve.backward_error,
        once,
    );
}

/// ‖b − A x‖ / ‖b‖.
fn residual(a: &Csr, b: &[f64], x: &[f64]) -> f64 {
    let mut r = vec![0.0; b.len()];
    a.residual(b, x, &mut r);
    norm_inf(&r) / norm_inf(b)
}

struct Clock {
    wall: Instant,
    processor: f64,
}

impl Clock {
    fn now() -> Self {
        Self { wall: Instant::now(), processor: processor_time() }
    }

    /// Processor time and wall time.
    fn elapsed(&self) -> [f64; 2] {
        [processor_time() - self.processor, self.wall.elapsed().as_secs_f64()]
    }
}

/// Time that the threads of this process have run, from Linux's scheduler; 0 elsewhere.
fn processor_time() -> f64 {
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let ran = |path: std::path::PathBuf| -> Option<f64> {
        fs::read_to_string(path.join("schedstat")).ok()?.split(' ').next()?.parse().ok()
    };
    1e-9 * tasks.filter_map(|task| ran(task.path())).sum::<f64>()
}

fn median(times: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|i| {
        let mut times: Vec<f64> = times.iter().map(|t| t[i]).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    })
}

fn read(file: &str) -> (System, Vec<f64>) {
    let bytes = fs::read(file).unwrap();
    let mut at = 0;
    let mut take = |n: usize| {
        at += n;
        &bytes[at - n..at]
    };
    let u64s = |b: &[u8]| -> Vec<usize> {
        b.chunks(8).map(|c| u64::from_le_bytes(c.try_into().unwrap()) as usize).collect()
    };
    let u32s =
        |b: &[u8]| -> Vec<u32> { b.chunks(4).map(|c| u32::from_le_bytes(c.try_into().unwrap())).collect() };
    let f64s =
        |b: &[u8]| -> Vec<f64> { b.chunks(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect() };
    let sizes = u64s(take(16));
    let (n, nnz) = (sizes[0], sizes[1]);
    let (row_ptr, col) = (u64s(take(8 * (n + 1))), u32s(take(4 * nnz)));
    let (values, b, node) = (f64s(take(8 * nnz)), f64s(take(8 * n)), u32s(take(4 * n)));
    let kinds = [Kind::Velocity, Kind::Deformation, Kind::Pressure];
    let kind: Vec<Kind> = take(n).iter().map(|&k| kinds[k as usize]).collect();
    let xyz = f64s(take(24 * n));
    let at = |i: usize| [xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]];
    let unknowns = (0..n).map(|i| Unknown { node: node[i], kind: kind[i], at: at(i) }).collect();
    let pattern = Arc::new(Pattern::new(&row_ptr, &col));
    (System { a: Csr { pattern, values }, unknowns }, b)
}
