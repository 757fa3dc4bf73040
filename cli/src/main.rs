//! The seamwright command.
//!
//! `unsafe`: the allocator, which hands every call on to the system's and ends the program where a piece of memory that
//! the rest cannot do without is not to be had.

use clap::{CommandFactory, FromArgMatches};
use seamwright::{args::line::CommandLine, commands, run::memory, run::stop};
use std::alloc::{self, GlobalAlloc, System};
use std::io::{Write, stderr};
use std::process::{ExitCode, exit};

/// The system's memory; exit code 5 where there is no more. Without it the program would be aborted, or wait for ever in what
/// prints why.
struct OrCodeFive;

#[global_allocator]
static MEMORY: OrCodeFive = OrCodeFive;

impl OrCodeFive {
    fn given(piece: *mut u8) -> *mut u8 {
        if piece.is_null() && !memory::can_do_without() {
            // Nothing here takes memory.
            let _ = stderr().write_all(memory::SPENT.as_bytes());
            exit(5);
        }
        piece
    }
}

// SAFETY: every call is System's, with the caller's own arguments; a null is handed on or ends the program.
unsafe impl GlobalAlloc for OrCodeFive {
    unsafe fn alloc(&self, layout: alloc::Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        Self::given(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: alloc::Layout) -> *mut u8 {
        // SAFETY: as the caller promises.
        Self::given(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, piece: *mut u8, layout: alloc::Layout, size: usize) -> *mut u8 {
        // SAFETY: as the caller promises.
        Self::given(unsafe { System.realloc(piece, layout, size) })
    }

    unsafe fn dealloc(&self, piece: *mut u8, layout: alloc::Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(piece, layout) }
    }
}

fn main() -> ExitCode {
    // So that `--padding -1` is a value that the flag refuses, and no flag of its own.
    let command =
        CommandLine::command().mut_subcommands(|command| command.mut_args(|arg| arg.allow_negative_numbers(true)));
    let line = CommandLine::from_arg_matches(&command.get_matches()).unwrap_or_else(|e| e.exit());
    stop::listen_for_stop();
    match commands::run(&line.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Nobody may be left to read it; the code still tells.
            let _ = writeln!(stderr(), "seamwright: {failure}");
            ExitCode::from(failure.code())
        }
    }
}
