//! The wish to stop, as Ctrl-C or a termination signal says it.

use crate::base::failure::Failure;
use crate::files::drafts::abandon;
use core::sync::atomic::{AtomicBool, Ordering};
use std::io::{Write, stderr};
use std::time::Duration;

/// Set by Ctrl-C; asked at every report.
static STOP: AtomicBool = AtomicBool::new(false);

/// Core's alarm: what is under way is to be thrown away.
static ALARM: AtomicBool = AtomicBool::new(false);

/// Set while a wish to stop only shortens what is under way.
static SHORTENS: AtomicBool = AtomicBool::new(false);

/// Set in the environment of a process whose standard input is a pipe from the process that watches it.
pub const FOLLOWS: &str = "SEAMWRIGHT_FOLLOWS";

/// Set where a wish to stop is to be answered at once, whatever is under way.
static AT_ONCE: AtomicBool = AtomicBool::new(false);

/// Time in which a run that was asked to stop can end by itself.
const GRACE: Duration = Duration::from_millis(100);

/// From now on Ctrl-C (and a termination signal) asks the run to stop; a second one ends the program at once.
pub fn listen_for_stop() {
    // Without a handler Ctrl-C ends the program in the usual way, which leaves no output either.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(Failure::Stopped.code()));
        }
        if SHORTENS.load(Ordering::Relaxed) {
            return;
        }
        ALARM.store(true, Ordering::Relaxed);
        if AT_ONCE.load(Ordering::Relaxed) {
            // Long sorts, reading and writing look at no alarm.
            std::thread::sleep(GRACE);
            if abandon() {
                let _ = writeln!(stderr(), "seamwright: {}", Failure::Stopped);
                std::process::exit(i32::from(Failure::Stopped.code()));
            }
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

/// From now on a wish to stop ends the program within [`GRACE`], and what it would have written with it.
pub fn stop_at_once() {
    AT_ONCE.store(true, Ordering::Relaxed);
}

/// Whether the user asked to stop.
pub fn stop_requested() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// What core looks at ([`Scratch::with_alarm`](seamwright_core::base::scratch::Scratch::with_alarm)).
pub fn alarm() -> &'static AtomicBool {
    &ALARM
}

/// Whether the user wants nothing of what is under way.
pub(super) fn is_unwanted() -> bool {
    stop_requested() && !SHORTENS.load(Ordering::Relaxed)
}

/// Says whether a wish to stop only shortens what begins now.
pub(super) fn shorten(shortens: bool) {
    SHORTENS.store(shortens, Ordering::Relaxed);
}

/// Whether the user asked to stop, who is taken to have been answered then.
pub(super) fn take_stop() -> bool {
    STOP.swap(false, Ordering::Relaxed)
}
