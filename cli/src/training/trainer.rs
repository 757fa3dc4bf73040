//! What core needs to train maps, and what training leaves behind.

use seamwright_core::learn::losses::LossWeights;
use seamwright_core::learn::training::{Sample, TrainSettings};
use seamwright_core::pipeline::learning::{Frame3, LearnedSummary, Learning, MOST};

/// Points of the loss curves at the most.
const SAMPLES: usize = 200;
/// Widest network that a settings file or a map may ask for.
pub const WIDEST: usize = 1024;

/// How maps are trained, and where they are kept.
#[derive(Clone, Debug)]
pub struct Trainer {
    /// The preset's name.
    pub preset: String,
    /// Widths, steps, weights and the rest.
    pub settings: TrainSettings,
    /// Whether training starts from the exact stages' charts.
    pub start: bool,
    /// Maps that are given: nothing is trained.
    pub given: usize,
    /// Frames of the maps.
    pub frames: Vec<Frame3>, // (MOST)
    /// Weights of the maps.
    pub weights: Vec<f32>, // (MOST, parameters)
    /// Losses of the largest piece.
    pub curve: Vec<Sample>,
    /// How it went.
    pub summary: LearnedSummary,
}

impl Trainer {
    /// Room for maps of these settings.
    pub fn with(preset: String, settings: TrainSettings, start: bool) -> Self {
        let weights = vec![0.0; MOST * settings.widths.parameter_count()];
        let (frames, curve) = (vec![[[0.0; 3]; 4]; MOST], vec![Sample::default(); SAMPLES]);
        Self { preset, settings, start, given: 0, frames, weights, curve, summary: LearnedSummary::default() }
    }

    /// As core takes it, before a run.
    pub fn learning(&mut self) -> Learning<'_> {
        Learning {
            settings: self.settings,
            start: self.start,
            frames: &mut self.frames,
            weights: &mut self.weights,
            curve: &mut self.curve,
            summary: LearnedSummary { maps: self.given, ..LearnedSummary::default() },
        }
    }

    /// The losses over the steps.
    pub fn samples(&self) -> &[Sample] {
        &self.curve[..self.summary.samples]
    }

    /// Weight of each loss.
    pub fn loss_weights(&self) -> LossWeights {
        self.settings.weights
    }
}
