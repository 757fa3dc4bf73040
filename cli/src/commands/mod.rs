//! The commands: each takes its arguments, does its work and says how it went.

mod apply;
mod batch;
mod check;
mod demo;
mod measure;
mod render;
mod segment;
mod transfer;
mod unwrap;

use crate::args::line::Command;
use crate::base::failure::Failure;
use crate::run::stop::stop_at_once;

/// Runs `command`.
pub fn run(command: &Command) -> Result<(), Failure> {
    if !matches!(command, Command::Batch(_)) {
        stop_at_once();
    }
    match command {
        Command::Unwrap(args) => unwrap::unwrap(args),
        Command::Apply(args) => apply::apply(args),
        Command::Transfer(args) => transfer::transfer(args),
        Command::Segment(args) => segment::segment(args),
        Command::Measure(args) => measure::measure(args),
        Command::Render(args) => render::render(args),
        Command::Batch(args) => batch::batch(args),
        Command::Check(args) => check::check(args),
        Command::Demo(args) => demo::demo(args),
    }
}
