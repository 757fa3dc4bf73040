//! What a search may spend, and why one ends without charts.

use crate::base::pace::Halt;
use crate::base::scratch::ScratchTooSmall;

/// Further searches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Draws {
    /// How many.
    pub count: u32,
    /// Seed of what leads them elsewhere.
    pub seed: u64,
}

/// What the search may spend.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Bound on the mean symmetric Dirichlet energy over 4.
    pub distortion: f64,
    /// Whether a chart may be bulky: where charts are parts, a part should be one.
    pub bulky: bool,
    /// Whether a piece stays one chart; larger ones than can be walled only become few.
    pub whole: bool,
    /// Further searches, of which the best is kept.
    pub draws: Draws,
    /// Whether the search may be told to end early: then it keeps a copy of its last mark.
    pub ends_early: bool,
}

/// Why the search ended without charts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeamError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// It was told to end before there was a map, or by a part of it that knows of none.
    Halted(Halt),
}

impl SeamError {
    /// Whether the alarm ended it ([`ScratchTooSmall::ALARM`]): why, the next mark says.
    pub fn is_alarm(&self) -> bool {
        matches!(self, SeamError::Scratch(e) if e.is_alarm())
    }
}

impl From<Halt> for SeamError {
    fn from(halt: Halt) -> Self {
        SeamError::Halted(halt)
    }
}

impl From<ScratchTooSmall> for SeamError {
    fn from(e: ScratchTooSmall) -> Self {
        SeamError::Scratch(e)
    }
}
