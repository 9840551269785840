//! Choosing the vector width at run time.
//!
//! The build targets the baseline processor; a wider one is used through entry functions compiled for
//! it. Everything below an entry must be `#[inline(always)]`, because a call would fall back to the
//! baseline. Results are the same for every thread count and every run of one width; between widths they
//! differ in rounding, since fused multiply-add is used where it exists.
#![allow(unsafe_code)]

use crate::math::Lanes;
pub use crate::math::apart::Task;
use crate::math::apart::run;
#[cfg(target_arch = "x86_64")]
use std::sync::OnceLock;

/// Numbers of lanes that the kernels of the plane are compiled for; `build.rs` chooses.
const IN_PLANE: &[usize] = &[
    #[cfg(lanes_8)]
    8,
    #[cfg(lanes_4)]
    4,
    1,
];

/// The same in space.
const IN_SPACE: &[usize] = &[
    #[cfg(space_8)]
    8,
    #[cfg(space_4)]
    4,
    #[cfg(space_1)]
    1,
];

/// The number of lanes that is asked for, or else the largest, of those that are `compiled`, widest first, and that the
/// processor has.
fn nearest(asked: usize, compiled: &[usize], available: impl Fn(usize) -> bool) -> Option<usize> {
    let there = |lanes: usize| compiled.contains(&lanes) && available(lanes);
    if there(asked) { Some(asked) } else { compiled.iter().copied().find(|&lanes| available(lanes)) }
}

/// Lanes that suit this processor: 8 with AVX-512, 4 with AVX2 and FMA or on other architectures, else 1; of those
/// that are compiled.
pub fn best_lanes() -> usize {
    in_plane(8)
}

/// Lanes of the plane for this processor, `asked` if there are.
pub fn in_plane(asked: usize) -> usize {
    nearest(asked, IN_PLANE, available).unwrap_or(1)
}

/// The same in space; `None`: all that are compiled are those of other processors.
pub fn in_space(asked: usize) -> Option<usize> {
    nearest(asked, IN_SPACE, available)
}

/// What a processor must have that this build computes with in space.
pub fn needed_in_space() -> &'static str {
    if IN_SPACE.contains(&4) { "AVX2 and FMA" } else { "AVX-512" }
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

/// A number of lanes that kernels are compiled for.
pub trait Width {
    /// Run `task`, compiled for the processor that the width stands for.
    ///
    /// # Panics
    /// If it is not [`available`]; looking it up costs a nanosecond.
    fn dispatch(task: impl Task);
}

macro_rules! widths {
    ($($lanes:literal)*) => {$(
        impl Width for Lanes<$lanes> {
            #[inline(always)]
            fn dispatch(task: impl Task) {
                assert!(available($lanes), "this processor has no instructions for so many lanes");
                // SAFETY: the processor has the instructions.
                unsafe { run::<$lanes>(task) };
            }
        }
    )*};
}
widths!(1 4 8);

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn lanes_are_those_of_build_and_processor() {
        let widest = |most: usize| move |lanes: usize| lanes <= most;
        assert_eq!(nearest(4, &[8, 4, 1], widest(8)), Some(4));
        assert_eq!(nearest(8, &[8, 4, 1], widest(4)), Some(4));
        assert_eq!(nearest(2, &[8, 1], widest(8)), Some(8));
        assert_eq!(nearest(8, &[4], widest(4)), Some(4));
        // A program of another machine.
        assert_eq!(nearest(8, &[8], widest(4)), None);
    }
}
