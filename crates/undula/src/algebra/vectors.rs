//! The vectors of the processor.

use pulp::{Arch, WithSimd};

/// Run `work` with the widest vectors that the processor has and this build, see `build.rs`; never inlined, so that there
/// is one copy for each of them.
#[inline(never)]
pub(super) fn dispatch<W: WithSimd>(arch: Arch, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    match arch {
        #[cfg(solver_avx512)]
        Arch::V4(simd) => pulp::Simd::vectorize(simd, work),
        #[cfg(solver_avx2)]
        Arch::V3(simd) => pulp::Simd::vectorize(simd, work),
        _ => pulp::Simd::vectorize(pulp::Scalar, work),
    }
    #[cfg(not(target_arch = "x86_64"))]
    arch.dispatch(work)
}

/// The vectors of this processor, for loops that the compiler takes to them.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Vectors(Arch);

impl Vectors {
    /// Those that there are.
    pub fn new() -> Vectors {
        Vectors(Arch::new())
    }

    /// Run `work`, compiled for them; what it calls must be inlined.
    #[inline(always)]
    pub fn run<R>(self, work: impl FnOnce() -> R) -> R {
        dispatch(self.0, work)
    }
}
