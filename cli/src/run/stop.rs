//! The wish to stop, as Ctrl-C or a termination signal says it.

use crate::base::failure::Failure;
use core::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C; asked at every report.
static STOP: AtomicBool = AtomicBool::new(false);

/// Set in the environment of a process whose standard input is a pipe from the process that watches it.
pub const FOLLOWS: &str = "SEAMWRIGHT_FOLLOWS";

/// From now on Ctrl-C (and a termination signal) asks the run to stop; a second one ends the program at once.
pub fn listen_for_stop() {
    // Without a handler Ctrl-C ends the program in the usual way, which leaves no output either.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(Failure::Stopped.code()));
        }
    });
    if std::env::var_os(FOLLOWS).is_some() {
        // The pipe ends when the other process does, whatever ends it. What is half written lies where that one makes it.
        std::thread::spawn(|| {
            let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
            std::process::exit(i32::from(Failure::Stopped.code()));
        });
    }
}

/// Whether the user asked to stop.
pub fn stop_requested() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// Whether the user asked to stop, who is taken to have been answered then.
pub(super) fn take_stop() -> bool {
    STOP.swap(false, Ordering::Relaxed)
}
