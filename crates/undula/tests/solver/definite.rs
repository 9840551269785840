//! The symmetric factorisation L D Lᵀ, which stores L alone, against the general one.

use std::sync::Arc;
use undula::algebra::{
    Csr, Kind, LinearSolver, MultifrontalLu, Options, Pattern, SolverError, Unknown, norm_inf,
};

/// Different in every call, between −1 and 1.
fn random(i: usize) -> f64 {
    let mixed = (i as u64 + 1)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .rotate_left(29)
        .wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Sum of random positive semidefinite matrices of the cells of a grid with two unknowns in every node and a
/// stiffness that varies by a factor of 1000.
fn grid(nx: usize, ny: usize) -> (Csr, Vec<Unknown>) {
    let node = |i: usize, j: usize| j * (nx + 1) + i;
    let n = 2 * (nx + 1) * (ny + 1);
    let cells: Vec<Vec<usize>> = (0..nx * ny)
        .map(|c| {
            let (i, j) = (c % nx, c / nx);
            let nodes = [node(i, j), node(i + 1, j), node(i, j + 1), node(i + 1, j + 1)];
            nodes.iter().flat_map(|&a| [2 * a, 2 * a + 1]).collect()
        })
        .collect();
    let mut rows = vec![vec![]; n];
    for cell in &cells {
        cell.iter().for_each(|&r| rows[r].extend(cell.iter().map(|&c| c as u32)));
    }
    let pattern = Arc::new(Pattern::from_rows(&rows));
    let mut a = Csr::zeros(&pattern);
    for (c, cell) in cells.iter().enumerate() {
        let stiffness = 10.0_f64.powf(3.0 * (c % nx) as f64 / nx as f64);
        for q in 0..4 {
            let w = |m: usize| random(64 * c + 8 * q + m);
            for (l, &row) in cell.iter().enumerate() {
                for (m, &column) in cell.iter().enumerate() {
                    a.values[pattern.find(row, column).unwrap()] += stiffness * (w(l) * w(m));
                }
            }
        }
    }
    (0..n).for_each(|i| a.values[pattern.find(i, i).unwrap()] += 0.1);
    let at = |i: usize| [((i / 2) % (nx + 1)) as f64, ((i / 2) / (nx + 1)) as f64, 0.0];
    let unknowns =
        (0..n).map(|i| Unknown { node: i as u32 / 2, kind: Kind::Deformation, at: at(i) }).collect();
    (a, unknowns)
}

fn known(a: &Csr) -> (Vec<f64>, Vec<f64>) {
    let x: Vec<f64> = (0..a.pattern.n).map(|i| (i as f64 * 1.7).sin()).collect();
    let mut b = vec![0.0; x.len()];
    a.mul(&x, &mut b);
    (x, b)
}

fn error(x: &[f64], known: &[f64]) -> f64 {
    norm_inf(&x.iter().zip(known).map(|(a, b)| a - b).collect::<Vec<_>>())
}

#[test]
fn known_solutions_come_back_with_half_the_memory() {
    for (nx, ny) in [(1, 1), (7, 3), (40, 30), (120, 90)] {
        let (a, unknowns) = grid(nx, ny);
        let (known, b) = known(&a);
        let mut x = vec![0.0; b.len()];
        let mut bytes = vec![];
        let options = Options { target: 1e-15, ..Options::single() };
        let solvers: [Box<dyn LinearSolver>; 4] = [
            Box::new(MultifrontalLu::multifrontal(options)),
            Box::new(MultifrontalLu::definite(options)),
            Box::new(MultifrontalLu::single(options)),
            Box::new(MultifrontalLu::single_definite(options)),
        ];
        for mut solver in solvers {
            solver.analyse(&a.pattern, &unknowns).unwrap();
            let report = solver.factor(&a).unwrap();
            bytes.push(report.cost.bytes.unwrap() as f64);
            assert_eq!(report.cost.fill, solver.predicted().unwrap().fill);
            solver.apply(&b, &mut x);
            let once = error(&x, &known);
            solver.solve(&a, &b, &mut x).unwrap();
            let refined = error(&x, &known);
            println!("{nx} x {ny} {}: {once:e} {refined:e} {report:?}", solver.name());
            assert!(refined < 1e-9, "{nx} x {ny} {}: {refined:e}", solver.name());
            let allowed = if solver.name() == "multifrontal" { 1e-8 } else { 0.1 };
            assert!(once < allowed, "{nx} x {ny} {}: {once:e}", solver.name());
        }
        if nx > 7 {
            assert!(bytes[1] < 0.62 * bytes[0] && bytes[3] < 0.65 * bytes[2], "{bytes:?}");
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let (a, unknowns) = grid(200, 180);
    let (_, b) = known(&a);
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = MultifrontalLu::single_definite(Options::unprobed());
            let mut x = vec![0.0; b.len()];
            solver.analyse(&a.pattern, &unknowns).unwrap();
            solver.factor(&a).unwrap();
            solver.apply(&b, &mut x);
            x
        })
    };
    let one = solve(1);
    for threads in [2, 5] {
        assert!(solve(threads) == one, "{threads} threads");
    }
}

#[test]
fn other_matrices_are_refused() {
    let (a, unknowns) = grid(12, 9);
    let mut solver = MultifrontalLu::single_definite(Options::unprobed());
    solver.analyse(&a.pattern, &unknowns).unwrap();
    let place = |i: usize, j: usize| a.pattern.find(i, j).unwrap();
    let mut negative = a.clone();
    negative.values[place(31, 31)] = -1.0;
    let found = solver.factor(&negative);
    assert!(matches!(found, Err(SolverError::NotDefinite { index: 31, .. })), "{found:?}");
    // A positive diagonal alone does not make a matrix definite.
    let mut indefinite = a.clone();
    let size = 2.0 * (a.values[place(40, 40)] * a.values[place(41, 41)]).sqrt();
    (indefinite.values[place(40, 41)], indefinite.values[place(41, 40)]) = (size, size);
    let found = solver.factor(&indefinite);
    assert!(matches!(found, Err(SolverError::NotDefinite { .. })), "{found:?}");
    assert!(found.is_err_and(|e| e.to_string().contains("not positive definite")));
    solver.factor(&a).unwrap();
}

#[test]
fn symmetry_is_seen() {
    let (a, _) = grid(12, 9);
    assert!(a.is_symmetric(1e-14));
    let mut b = a.clone();
    b.values[a.pattern.find(40, 41).unwrap()] *= 1.0 + 1e-6;
    assert!(!b.is_symmetric(1e-10) && b.is_symmetric(1e-5));
    b.values[7] = f64::NAN;
    assert!(!b.is_symmetric(1.0));
    let of = |rows: &[&[u32]]| Csr::zeros(&Arc::new(Pattern::from_rows(rows)));
    assert!(of(&[&[0, 2], &[1], &[0, 2]]).is_symmetric(0.0));
    for rows in
        [[&[0, 2][..], &[1], &[2]], [&[0], &[1], &[0, 2]], [&[0, 1], &[1, 2], &[0, 2]], [&[0], &[0], &[2]]]
    {
        assert!(!of(&rows).is_symmetric(0.0), "{rows:?}");
    }
}
