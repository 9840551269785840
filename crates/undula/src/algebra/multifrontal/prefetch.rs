//! Memory asked for before it is needed.
#![allow(unsafe_code)]

/// Ask for `data` to be brought into the second-level cache. Substitution reads every factor once, and fronts
/// are too short for the processor to see the next one coming.
#[inline(always)]
pub(super) fn prefetch<T>(data: &[T]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        const LINE: usize = 64;
        let bytes = data.as_ptr_range();
        let (mut at, end) = (bytes.start.cast::<i8>(), bytes.end.cast::<i8>());
        while at < end {
            // SAFETY: a hint; it reads nothing, and the address is within `data`.
            unsafe { _mm_prefetch::<_MM_HINT_T1>(at) };
            at = at.wrapping_add(LINE);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = data;
}
