//! Progress reports out of core, and the caller's wish to end into it.

/// What the run is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Welding, orienting and splitting the input.
    Repair,
    /// Finding the object's parts.
    Parts,
    /// Casting rays for exposure.
    Exposure,
    /// Training maps. The one stage that a wish to stop shortens: the run goes on with the best maps so far.
    Learn,
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
            Stage::Learn => "learn",
            Stage::Cut => "cut",
            Stage::Flatten => "flatten",
            Stage::Seams => "seams",
            Stage::Pack => "pack",
            Stage::Check => "check",
        }
    }
}

/// What the caller wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// All that there is to do.
    GoOn,
    /// What can be had of this stage by now, if it is one that can end early (exposure, seams, pack); the others go on.
    Finish,
    /// Nothing: the run ends without a result as soon as it can.
    Stop,
}

/// Receives reports; its answer can end the run.
///
/// A caller whose wish changes while core is busy sets the alarm that came with the [scratch](super::scratch::Scratch::with_alarm): core
/// then reports soon, and has to hear `Finish` or `Stop`. Before it answers `Finish`, the caller takes the alarm back, so that
/// what is there can be made an atlas.
pub trait Progress {
    /// `done` of `total` steps of `stage` are finished.
    fn report(&mut self, stage: Stage, done: usize, total: usize) -> Wish;

    /// Something that changes while a stage goes on, for people. Nobody has to listen.
    fn note(&mut self, _text: core::fmt::Arguments) {}
}

/// The caller wants the run to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// Tells the caller how far a stage is, who may stop the run.
pub fn tell(progress: &mut dyn Progress, stage: Stage, done: usize, total: usize) -> Result<(), Stopped> {
    if progress.report(stage, done, total) == Wish::Stop { Err(Stopped) } else { Ok(()) }
}

/// Nobody listens.
pub struct Silent;

impl Progress for Silent {
    fn report(&mut self, _: Stage, _: usize, _: usize) -> Wish {
        Wish::GoOn
    }
}
