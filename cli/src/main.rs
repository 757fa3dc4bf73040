//! The seamwright command.

use clap::Parser;
use seamwright::{args::line::CommandLine, commands, run::stop};
use std::io::{Write, stderr};
use std::process::ExitCode;

fn main() -> ExitCode {
    let line = CommandLine::parse();
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
