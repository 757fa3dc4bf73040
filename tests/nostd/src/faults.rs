//! What core must not do, for the build in which the checks must fail: an allocation, and a division that may panic.

extern crate alloc;

use alloc::boxed::Box;
use core::alloc::{GlobalAlloc, Layout};
use core::hint::black_box;

struct Nothing;

// SAFETY: it never gives memory, which every caller must expect.
unsafe impl GlobalAlloc for Nothing {
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        core::ptr::null_mut()
    }
    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static NOTHING: Nothing = Nothing;

/// Divides by what may be zero, and asks for a byte.
pub fn commit() {
    black_box(1 / black_box(1u8));
    black_box(Box::new(1u8));
}
