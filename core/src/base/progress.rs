//! Progress reports out of core, and the caller's wish to stop into it.

use core::ops::ControlFlow;

/// What the run is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Welding, orienting and splitting the input.
    Repair,
    /// Finding the object's parts.
    Parts,
    /// Casting rays for exposure.
    Exposure,
    /// Placing the first cuts.
    Cut,
    /// First valid flattening.
    Flatten,
    /// Moving, merging and shortening seams.
    Seams,
    /// Placing the charts in the unit square.
    Pack,
    /// Deciding flips and overlaps on the written UVs.
    Check,
}

impl Stage {
    /// A short lower-case name for people.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Repair => "repair",
            Stage::Parts => "parts",
            Stage::Exposure => "exposure",
            Stage::Cut => "cut",
            Stage::Flatten => "flatten",
            Stage::Seams => "seams",
            Stage::Pack => "pack",
            Stage::Check => "check",
        }
    }
}

/// Receives reports; its answer can stop the run.
pub trait Progress {
    /// `done` of `total` steps of `stage` are finished. `Break` asks the run to stop as soon as it can.
    fn report(&mut self, stage: Stage, done: usize, total: usize) -> ControlFlow<()>;
}

/// Nobody listens.
pub struct Silent;

impl Progress for Silent {
    fn report(&mut self, _: Stage, _: usize, _: usize) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
