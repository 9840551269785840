//! Memory of the program: where there is no more, the program ends with a sentence and exit code 3 (as a breakdown)
//! instead of a signal. What a run has written stays, and it goes on from its last checkpoint.
// An allocator cannot be written otherwise.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;

/// The system's allocator, which tells of its end.
pub struct Told;

// SAFETY: every call is handed to the system's allocator with its own arguments; what it returns is returned, or the
// program ends.
unsafe impl GlobalAlloc for Told {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        told(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's.
        told(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller's.
        told(unsafe { System.realloc(memory, layout, size) }, size)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[inline]
fn told(memory: *mut u8, size: usize) -> *mut u8 {
    if memory.is_null() {
        end(size);
    }
    memory
}

/// Nothing here takes memory.
#[cold]
fn end(size: usize) -> ! {
    let mut out = std::io::stderr();
    // Nobody may listen.
    let _ = writeln!(
        out,
        "\nerror: out of memory: {size} bytes more are not to be had; `undula check` tells what a run needs, and a run \
         that has written a checkpoint goes on with --resume"
    );
    std::process::exit(3)
}
