//! A module without imports: `run` does the work, and what it prints lies in memory from `text` on, `text_length` bytes.
//!
//! `unsafe` is here for the names of the exports and for the one static that they share.

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicUsize, Ordering};

static PLACE: AtomicUsize = AtomicUsize::new(0);
static LENGTH: AtomicUsize = AtomicUsize::new(0);
/// `text`, kept.
static mut KEPT: [u8; 1024] = [0; 1024];

/// Keeps `text` for the caller to read.
pub fn print(text: &[u8]) {
    // SAFETY: a module has one thread, and this is called once.
    let kept = unsafe { &mut *(&raw mut KEPT) };
    kept[..text.len()].copy_from_slice(text);
    PLACE.store(kept.as_ptr() as usize, Ordering::Relaxed);
    LENGTH.store(text.len(), Ordering::Relaxed);
}

/// Runs; the exit code of a program.
// SAFETY: no other export has this name.
#[unsafe(no_mangle)]
pub extern "C" fn run() -> i32 {
    crate::work()
}

/// Where the text lies.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> usize {
    PLACE.load(Ordering::Relaxed)
}

/// Bytes of the text.
// SAFETY: as above.
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> usize {
    LENGTH.load(Ordering::Relaxed)
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    core::arch::wasm32::unreachable()
}
