//! Work in functions of their own, compiled for the processor that a number of lanes stands for.
#![allow(unsafe_code)]

/// Work on one batch or at one point; `run` must be `#[inline(always)]`.
pub trait Task {
    /// Do it.
    fn run(self);
}

/// # Safety
/// The processor must have the instructions.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma")]
#[inline(never)]
pub(crate) unsafe fn run_avx512<T: Task>(task: T) {
    task.run();
}

/// # Safety
/// The processor must have the instructions.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
#[inline(never)]
pub(crate) unsafe fn run_avx2<T: Task>(task: T) {
    task.run();
}

#[inline(never)]
pub(crate) fn run_baseline<T: Task>(task: T) {
    task.run();
}
