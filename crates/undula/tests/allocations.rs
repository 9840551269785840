//! After the first step of a run, assembly allocates nothing.
#![allow(unsafe_code)]

mod common;

use common::builtin;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use undula::algebra::Csr;
use undula::assembly::StepView;
use undula::simulation::Simulation;
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
    let mut residual = vec![0.0; assembler.space.n_unknowns()];
    let mut matrix = Csr::zeros(&assembler.pattern());
    let mut condensed = Csr::zeros(&assembler.condensed().pattern);
    let mut assemble = || {
        assembler.explicit(&view, &mut residual);
        assembler.residual(&view, &mut residual);
        assembler.jacobian(&view, Tangent::Automatic, &mut matrix);
        assembler.jacobian(&view, Tangent::Analytic, &mut matrix);
        assembler.condensed_matrix(&view, Tangent::Automatic, &mut condensed);
        assembler.eliminate_inner(&mut residual);
        assembler.recover_inner(&mut residual);
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

/// One test alone in its process: the harness would be counted, too.
#[test]
fn second_assembly_allocates_nothing() {
    let equal_order = ["space.pressure=Q2", "stabilization.pressure=pspg", "stabilization.transport=lps"];
    for sets in [&[][..], &equal_order, &["space.velocity=Q3"]] {
        assert_eq!(second_assembly(1, sets), 0, "{sets:?}");
        assert_eq!(second_assembly(2, sets), 0, "on two threads, {sets:?}");
    }
}
