//! What the published training is to learn, where it is kept, and what its steps share.

use super::report::UnwrapError;
use super::tears::Torn;
use crate::base::workers::Workers;
use crate::charts::pieces::Pieces;
use crate::learn::losses::Loss;
use crate::learn::training::{Sample, TrainSettings};
use crate::search::budget::Budget;

/// Pieces that are trained at the most.
pub const MOST: usize = 8;

/// What to learn, and where it is kept.
pub struct Learning<'a> {
    /// How to train.
    pub settings: TrainSettings,
    /// Weights of the maps, the largest piece's first.
    pub weights: &'a mut [f32], // (MOST, parameters)
    /// Samples of the losses of the largest piece; any length.
    pub curve: &'a mut [Sample],
    /// How it went.
    pub summary: LearnedSummary,
}

impl Learning<'_> {
    /// Whether there is room for all maps.
    pub(super) fn check(&self) -> Result<(), UnwrapError> {
        let room = self.weights.len() / self.settings.widths.parameter_count().max(1);
        if room >= MOST { Ok(()) } else { Err(UnwrapError::BadLength { expected: MOST, given: room }) }
    }

    /// Whether exposure plays no part.
    pub(super) fn is_blind(&self) -> bool {
        self.settings.weights.0[Loss::Visibility as usize] == 0.0
    }
}

/// What was learned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LearnedSummary {
    /// Maps.
    pub maps: usize,
    /// Steps of all maps together.
    pub steps: usize,
    /// Samples in the curve.
    pub samples: usize,
    /// Whether training was stopped before its end.
    pub was_stopped: bool,
    /// Faces that no map holds, laid down beside others.
    pub torn: Torn,
}

/// Everything that the steps of learning share.
pub(super) struct LearnScene<'s> {
    pub pieces: &'s Pieces<'s>,
    pub kept: &'s [u8],               // pieces for which there is nothing to do
    pub open: &'s dyn Fn(u32) -> f32, // exposure at a corner of the working mesh
    pub budget: Budget,
    pub workers: &'s dyn Workers,
}
