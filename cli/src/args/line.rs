//! The command line.

use super::apply::ApplyArgs;
use super::batch::BatchArgs;
use super::check::CheckArgs;
use super::demo::DemoArgs;
use super::measure::MeasureArgs;
use super::render::RenderArgs;
use super::segment::SegmentArgs;
use super::transfer::TransferArgs;
use super::unwrap::UnwrapArgs;
use clap::{Parser, Subcommand};

const AFTER_HELP: &str = "\
Exit codes: 0 done, 2 wrong command line, 3 input unreadable or not a mesh, 4 output not writable,
5 the run could not reach what was asked, 130 stopped by Ctrl-C or a signal (no output is written).
Outputs replace files of the same name, each whole or not at all. A report (--json) is written after 3 and 5 too.";

/// UV unwrapping with charts that are parts and seams that hide.
#[derive(Debug, Parser)]
#[command(name = "seamwright", version, after_help = AFTER_HELP)]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Give a mesh a UV atlas
    Unwrap(UnwrapArgs),
    /// Unwrap many files and print a line of JSON for each
    Batch(BatchArgs),
    /// Evaluate saved maps on a mesh, without training
    Apply(ApplyArgs),
    /// Put the atlas of a mesh on another mesh of the same shape, so that one texture serves both
    Transfer(TransferArgs),
    /// Find the parts of a mesh and write a label for each face
    Segment(SegmentArgs),
    /// Print the figures of UV-mapped files, whatever tool made them
    Measure(MeasureArgs),
    /// Decide exactly whether a UV-mapped file keeps the rules of an atlas
    Check(CheckArgs),
    /// Draw a UV-mapped file: views, seams, checkerboard, atlas
    Render(RenderArgs),
    /// Unwrap a built-in mesh, to see what the main job does
    Demo(DemoArgs),
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use seamwright_core::pipeline;

    #[test]
    fn the_definition_is_sound() {
        CommandLine::command().debug_assert();
    }

    #[test]
    fn the_defaults_are_those_of_core() {
        let line = CommandLine::parse_from(["seamwright", "unwrap", "a.obj", "-o", "b.obj"]);
        let Command::Unwrap(args) = line.command else { unreachable!("unwrap was parsed") };
        assert_eq!(format!("{:?}", args.settings.to_core()), format!("{:?}", pipeline::Settings::default()));
    }

    #[test]
    fn settings_become_the_words_that_they_came_from() {
        let words = "--distortion 1.07 --charts one --straighten off --snap off --stack mirrored --stack-offset 1 --packing grid --prefer fill --hard-edges off --size 2048 --padding 7 --rays 9 --search 4 --seed 3 --weld 0.001";
        let words: Vec<&str> = words.split(' ').collect();
        let line = CommandLine::parse_from(["seamwright", "batch", "a.obj", "-o", "b"].iter().chain(&words));
        let Command::Batch(args) = line.command else { unreachable!("batch was parsed") };
        assert_eq!(args.settings.words(), words);
    }
}
