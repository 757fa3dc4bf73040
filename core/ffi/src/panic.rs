//! What a library needs that is no part of a Rust program: an end for the panics that only a fault of ours can cause.
//!
//! `unsafe` lives here for C's `abort`.

use core::panic::PanicInfo;

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    end()
}

#[cfg(any(unix, windows))]
fn end() -> ! {
    #[cfg_attr(unix, link(name = "c"))]
    unsafe extern "C" {
        fn abort() -> !;
    }
    // SAFETY: ends the process; nothing runs after it.
    unsafe { abort() }
}

#[cfg(target_arch = "wasm32")]
fn end() -> ! {
    core::arch::wasm32::unreachable()
}

/// A machine without an end to go to: stands still, for its watchdog.
#[cfg(not(any(unix, windows, target_arch = "wasm32")))]
fn end() -> ! {
    loop {
        core::hint::spin_loop();
    }
}
