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
