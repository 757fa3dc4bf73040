//! What is to be learned, where it is kept, and what the steps of learning share.

use super::report::UnwrapError;
use super::tears::Torn;
use crate::base::workers::Workers;
use crate::charts::pieces::Pieces;
use crate::learn::losses::Loss;
use crate::learn::training::{Sample, TrainSettings};
use crate::search::budget::Budget;
use glam::DVec3;

/// Pieces that are trained at the most.
pub const MOST: usize = 8;
/// From the input's frame to that in which a piece's network was trained: the rows of a linear map, then what is added.
pub type Frame3 = [[f64; 3]; 4];

/// What to learn, and where it is kept.
pub struct Learning<'a> {
    /// How to train.
    pub settings: TrainSettings,
    /// Whether training starts from the exact stages' charts.
    pub start: bool,
    /// The frame of each map, the largest piece's first. Given maps are used as they are: nothing is trained.
    pub frames: &'a mut [Frame3], // (MOST)
    /// Their weights, one after the other.
    pub weights: &'a mut [f32], // (MOST, parameters)
    /// Samples of the losses of the largest piece; any length.
    pub curve: &'a mut [Sample],
    /// How it went; a count of maps that is not 0 says that maps are given.
    pub summary: LearnedSummary,
}

impl Learning<'_> {
    /// Whether there is room for all maps, and no more are given than that.
    pub(super) fn check(&self) -> Result<(), UnwrapError> {
        let parameters = self.settings.widths.parameter_count();
        let room = (self.weights.len() / parameters.max(1)).min(self.frames.len());
        if room >= MOST && self.summary.maps <= MOST {
            Ok(())
        } else {
            Err(UnwrapError::BadLength { expected: MOST, given: if room < MOST { room } else { self.summary.maps } })
        }
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
    pub kept: &'s [u8],                       // pieces for which there is nothing to do
    pub open: &'s dyn Fn(u32) -> f32,         // exposure at a corner of the working mesh
    pub place_of: &'s dyn Fn(DVec3) -> DVec3, // of a point of the input
    pub input_of: &'s dyn Fn(DVec3) -> DVec3, // and back
    pub budget: Budget,
    pub workers: &'s dyn Workers,
}
