//! Choosing the vector width at run time.
//!
//! The build targets the baseline processor; a wider one is used through entry functions compiled for
//! it. Everything below an entry must be `#[inline(always)]`, because a call would fall back to the
//! baseline. Results are the same for every thread count and every run of one width; between widths they
//! differ in rounding, since fused multiply-add is used where it exists.
#![allow(unsafe_code)]

use crate::math::Lanes;
pub use crate::math::apart::Task;
use crate::math::apart::run_baseline;
#[cfg(target_arch = "x86_64")]
use crate::math::apart::{run_avx2, run_avx512};
#[cfg(target_arch = "x86_64")]
use std::sync::OnceLock;

/// Lanes that suit this processor: 8 with AVX-512, 4 with AVX2 and FMA or on other architectures, else 1; of those
/// that are compiled.
pub fn best_lanes() -> usize {
    [8, 4].into_iter().find(|&lanes| compiled(lanes) && available(lanes)).unwrap_or(1)
}

/// Whether this build has kernels with `lanes` lanes; `build.rs` chooses.
pub fn compiled(lanes: usize) -> bool {
    match lanes {
        1 => true,
        4 => cfg!(lanes_4),
        8 => cfg!(lanes_8),
        _ => false,
    }
}

/// Whether this processor can compute with `lanes` lanes.
pub fn available(lanes: usize) -> bool {
    match lanes {
        1 => true,
        #[cfg(target_arch = "x86_64")]
        4 => has_avx2(),
        #[cfg(not(target_arch = "x86_64"))]
        4 => true,
        #[cfg(target_arch = "x86_64")]
        8 => has_avx512(),
        _ => false,
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    static HAS: OnceLock<bool> = OnceLock::new();
    *HAS.get_or_init(|| {
        is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && has_avx2()
    })
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    static HAS: OnceLock<bool> = OnceLock::new();
    *HAS.get_or_init(|| is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"))
}

/// A number of lanes with its entry. One entry each: a way round for processors without the
/// instructions would be compiled for minutes and never run.
pub trait Width {
    /// Run `task`, compiled for the processor that the width stands for.
    ///
    /// # Panics
    /// If it is not [`available`]; looking it up costs a nanosecond.
    fn dispatch(task: impl Task);
}

impl Width for Lanes<1> {
    #[inline(always)]
    fn dispatch(task: impl Task) {
        run_baseline(task);
    }
}

impl Width for Lanes<4> {
    #[inline(always)]
    fn dispatch(task: impl Task) {
        assert!(available(4), "four lanes need AVX2 and FMA");
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the processor has the instructions.
        unsafe {
            run_avx2(task);
        }
        #[cfg(not(target_arch = "x86_64"))]
        run_baseline(task);
    }
}

impl Width for Lanes<8> {
    #[inline(always)]
    fn dispatch(task: impl Task) {
        assert!(available(8), "eight lanes need AVX-512");
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the processor has the instructions.
        unsafe {
            run_avx512(task);
        }
        #[cfg(not(target_arch = "x86_64"))]
        run_baseline(task);
    }
}
