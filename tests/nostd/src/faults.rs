//! An allocation, for the run in which the check must fail.

extern crate alloc;

use alloc::boxed::Box;
use core::alloc::{GlobalAlloc, Layout};

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

/// Asks for a byte.
pub fn allocate() {
    core::hint::black_box(Box::new(1u8));
}
