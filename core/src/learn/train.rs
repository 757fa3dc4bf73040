//! Training a map for one mesh: from points, normals, faces and exposure to Q, seam scores and the networks' weights.
//!
//! **Contract.** [`train`] takes a mesh in any frame (it is put into the unit box; [`TrainSummary::frame`] says how) and fills
//! [`TrainOutput`]: UVs of all vertices, seam scores, weights for [`super::evaluate::evaluate`] at other points, and a sample
//! of the losses. The same input and settings give the same bits for any [`Workers`], [`Path`] and machine.
//! [`super::run::train_need`] says the bytes; one less is refused before any output is touched. [`Watch`] is told the losses of every
//! step and may stop the run; what comes out is the best map so far: weights are kept whenever the smoothed objective
//! is at its lowest, looked at every [`super::run::CHECK`] steps and at the end. A run that leaves the finite numbers stops there.
//! Losses that are looked at every fifth step weigh in at those steps alone, as published. A [`Run`] is the same training
//! made step by step, so that several can go on side by side.
//!
//! **More losses.** An operation on the tape (see [`super::tape`]), a variant of `Loss` with its weight, and its lines in
//! [`super::losses::LossGraph::record`]; this file does not change. `Loss::Fold` and `Loss::Distortion` are examples.
//!
//! Limits: memory is that of the batch, about 340 bytes x width a point (values and gradients of 42 layers' outputs):
//! 0.5 GB for all 2,930 points of Spot at width 512. Without batches that is the whole mesh.

use super::kernels::path::Path;
use super::run::Run;
use super::training::{TrainError, TrainInput, TrainOutput, TrainSettings, TrainSummary, Watch};
use crate::base::scratch::Scratch;
use crate::base::workers::Workers;

/// Trains a map of `input`; see the head of this file.
#[allow(clippy::too_many_arguments)]
pub fn train(
    output: TrainOutput,
    input: TrainInput,
    settings: &TrainSettings,
    path: Path,
    workers: &dyn Workers,
    watch: &mut dyn Watch,
    scratch: &mut Scratch,
) -> Result<TrainSummary, TrainError> {
    let mut run = Run::new(output, input, settings, scratch.frame())?;
    while run.step(path, workers)? {
        if watch.step(run.last(), settings.steps).is_break() {
            run.stop();
        }
    }
    Ok(run.finish(path, workers)?)
}
