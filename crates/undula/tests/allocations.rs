//! After the first step of a run, assembly allocates nothing.
#![allow(unsafe_code)]

mod common;

use common::builtin;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use undula::algebra::{Csr, Gmres, GmresSettings, Pattern};
use undula::simulation::Simulation;
use undula::system::{Borders, Matrix, StepView};
use undula::tangent::Tangent;

/// The allocator of the system, counting.
struct Counting;

static COUNT: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations while residual and Jacobians are assembled the second time.
fn second_assembly(threads: usize, sets: &[&str]) -> usize {
    let common = ["mesh.refine=0", "time.step=0.02", "time.end=0.04"];
    let case = builtin("fsi3", &[&common[..], sets].concat());
    let mut simulation = Simulation::new(case, threads).unwrap();
    simulation.step().unwrap();
    let (rule, new, old, assembler) = simulation.stepper.last_step();
    let view = StepView { rule, new, old };
    let mut residual = vec![0.0; assembler.n_unknowns()];
    let mut matrix = Csr::zeros(&assembler.pattern());
    let mut condensed = Csr::zeros(&assembler.condensed().pattern);
    let mut borders = Borders::default();
    let mut assemble = || {
        assembler.explicit(&view, &mut residual);
        assembler.residual(&view, &mut residual);
        assembler.jacobian(&view, Tangent::Automatic, &mut matrix);
        assembler.jacobian(&view, Tangent::Analytic, &mut matrix);
        assembler.condensed_matrix(&view, Tangent::Automatic, &mut condensed);
        assembler.eliminate_inner(&mut residual);
        assembler.recover_inner(&mut residual);
        assembler.borders(Matrix::Whole, &view, &mut borders);
        assembler.borders(Matrix::Condensed, &view, &mut borders);
    };
    let mut count = || {
        assemble();
        let before = COUNT.load(Ordering::Relaxed);
        assemble();
        COUNT.load(Ordering::Relaxed) - before
    };
    if threads == 1 {
        return count();
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    // The threads are up, and their queues have their size, once they have all worked.
    pool.broadcast(|_| ());
    pool.install(|| {
        count();
        count()
    })
}

/// Allocations of GMRES for another matrix, after it has had one.
fn second_gmres() -> usize {
    const N: usize = 3000;
    let row = |i: usize| [i, (i + 1) % N, (i + 7) % N].map(|j| j as u32);
    let pattern = Pattern::from_rows(&(0..N).map(row).collect::<Vec<_>>());
    let values = (0..pattern.nnz()).map(|at| (at as f64).sin()).collect();
    let a = Csr { pattern: pattern.into(), values };
    let (b, mut x, weights) = (vec![1.0; N], vec![0.0; N], vec![1.0; N]);
    let mut gmres = Gmres::new(GmresSettings { tolerance: 1e-12, size: 10 });
    let mut count = || {
        let before = COUNT.load(Ordering::Relaxed);
        gmres.clear();
        let copy = |r: &mut [f64], z: &mut [f64]| z.copy_from_slice(r);
        assert!(gmres.solve(&a, &weights, copy, &b, &mut x).is_err(), "too easy");
        COUNT.load(Ordering::Relaxed) - before
    };
    count();
    count()
}

/// One test alone in its process: the harness would be counted, too.
#[test]
fn second_assembly_allocates_nothing() {
    let gmres = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(gmres.install(second_gmres), 0, "GMRES");
    let equal_order = ["space.pressure=Q2", "stabilization.pressure=pspg", "stabilization.transport=lps"];
    let file = concat!(env!("CARGO_TARGET_TMPDIR"), "/allocations.csv");
    std::fs::write(file, "0,0\n0.05,1\n0.1,0\n").unwrap();
    let tables = format!(
        "boundary.outflow.traction=[\"table('{file}', t, 'cubic periodic')\", \"table('{file}', t)\"]"
    );
    let tables = ["boundary.outflow.condition=traction", &tables];
    let circuit = [
        "boundary.outflow.condition=windkessel",
        "boundary.outflow.proximal=1e3",
        "boundary.outflow.capacitance=1e-5",
        "boundary.outflow.distal=2e3",
    ];
    let measured = [
        "solid.prestress=true",
        "solid.law=guccione",
        "solid.mu=none",
        "solid.lambda=none",
        "solid.guccione-c=1e6",
        "solid.b-f=4",
        "solid.b-t=2",
        "solid.b-fs=3",
        "solid.fibre-direction=[\"1 + x\", \"y\"]",
    ];
    for sets in [&[][..], &circuit, &equal_order, &["space.velocity=Q3"], &tables, &measured] {
        assert_eq!(second_assembly(1, sets), 0, "{sets:?}");
        assert_eq!(second_assembly(2, sets), 0, "on two threads, {sets:?}");
    }
}
