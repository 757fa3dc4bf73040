//! The wish to stop, as Ctrl-C or a termination signal says it.

use crate::base::failure::Failure;
use core::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C; asked at every report.
static STOP: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C (and a termination signal) asks the run to stop; a second one ends the program at once.
pub fn listen_for_stop() {
    // Without a handler Ctrl-C ends the program in the usual way, which leaves no output either.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(Failure::Stopped.code()));
        }
    });
}

/// Whether the user asked to stop.
pub fn stop_requested() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// Whether the user asked to stop, who is taken to have been answered then.
pub(super) fn take_stop() -> bool {
    STOP.swap(false, Ordering::Relaxed)
}
