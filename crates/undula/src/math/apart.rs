//! Work in functions of their own, compiled for the processor that a number of lanes stands for.
#![allow(unsafe_code)]

/// Work on one batch or at one point; `run` must be `#[inline(always)]`.
pub trait Task {
    /// Do it.
    fn run(self);
}

/// Do `task` in a function of its own, compiled for the processor that `L` lanes stand for.
///
/// # Safety
/// The processor must have the instructions, [`crate::loops::width::available`].
#[inline(always)]
pub(crate) unsafe fn run<const L: usize>(task: impl Task) {
    // One function each: a way round for processors without the instructions would be compiled for minutes and never
    // run.
    #[cfg(target_arch = "x86_64")]
    // SAFETY: the processor has the instructions.
    unsafe {
        if const { L == 8 } {
            run_avx512(task);
        } else if const { L == 4 } {
            run_avx2(task);
        } else {
            run_baseline(task);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    run_baseline(task);
}

/// # Safety
/// The processor must have the instructions.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
#[inline(never)]
unsafe fn run_avx512<T: Task>(task: T) {
    task.run();
}

/// # Safety
/// The processor must have the instructions.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
#[inline(never)]
unsafe fn run_avx2<T: Task>(task: T) {
    task.run();
}

#[inline(never)]
pub(crate) fn run_baseline<T: Task>(task: T) {
    task.run();
}
