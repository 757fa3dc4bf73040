//! How maps were trained, for the report.

use crate::training::trainer::Trainer;
use seamwright_core::learn::losses::Loss;
use serde::Serialize;
use std::collections::BTreeMap;

/// How maps were trained.
#[derive(Debug, Serialize)]
pub struct LearningReport {
    /// Name of the preset; `given` where maps came from a file.
    pub preset: String,
    /// Width of hidden layers.
    pub width: usize,
    /// Width of codes.
    pub code: usize,
    /// Points of a batch; 0 is all.
    pub batch: usize,
    /// Whether training started from the exact stages' charts.
    pub start: bool,
    /// Weight of each loss.
    pub weights: BTreeMap<&'static str, f64>,
    /// Maps that were trained or given.
    pub maps: usize,
    /// Steps of all of them.
    pub steps: usize,
    /// Whether training was stopped before its end.
    pub was_stopped: bool,
    /// Faces that a map tears or folds and that were laid down beside others.
    pub torn_faces: usize,
    /// Faces that a map turns over.
    pub folded_faces: usize,
    /// Steps at which the losses of the largest piece were looked at.
    pub curve_steps: Vec<usize>,
    /// Its losses at these steps, unweighted, of those that were on; `visibility` is the exposure of seams.
    pub curves: BTreeMap<&'static str, Vec<f32>>,
}

impl LearningReport {
    /// What `trainer` was asked and did.
    pub fn new(trainer: &Trainer) -> Self {
        let (settings, summary) = (&trainer.settings, trainer.summary);
        let on = Loss::ALL.into_iter().filter(|loss| settings.weights.0[*loss as usize] != 0.0);
        let curve = |loss: Loss| trainer.samples().iter().map(|s| s.losses[loss as usize]).collect();
        Self {
            preset: trainer.preset.clone(),
            width: settings.widths.hidden,
            code: settings.widths.code,
            batch: settings.batch,
            start: trainer.start,
            weights: Loss::ALL.into_iter().map(|l| (l.name(), settings.weights.0[l as usize])).collect(),
            maps: summary.maps,
            steps: summary.steps,
            was_stopped: summary.was_stopped,
            torn_faces: summary.torn.faces,
            folded_faces: summary.torn.folded,
            curve_steps: trainer.samples().iter().map(|s| s.step).collect(),
            curves: on.map(|loss| (loss.name(), curve(loss))).collect(),
        }
    }
}
