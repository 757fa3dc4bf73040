//! What a training takes and gives: a mesh, settings, outputs, losses on the way, and why there may be nothing.

use super::backbone::Widths;
use super::evaluate::Frame;
use super::losses::{LossWeights, PerLoss};
use crate::base::scratch::ScratchTooSmall;
use core::ops::ControlFlow;

/// A mesh to learn: oriented triangles over vertices.
#[derive(Clone, Copy)]
pub struct TrainInput<'a> {
    /// Positions (vertices, 3), in any frame.
    pub positions: &'a [f32],
    /// Unit normals (vertices, 3).
    pub normals: &'a [f32],
    /// Corners (faces, 3).
    pub faces: &'a [u32],
    /// Exposure (vertices), 1 = open.
    pub exposure: &'a [f32],
}

/// What is trained, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainSettings {
    /// Widths of the networks.
    pub widths: Widths,
    /// Steps of the optimiser.
    pub steps: usize,
    /// Points of a batch; 0: all vertices.
    pub batch: usize,
    /// Weight of each loss.
    pub weights: LossWeights,
    /// Side of the box that the points fill; 1 in the published training. Larger ones let the map change faster over space.
    pub side: f64,
    /// Radius of repulsion in lattice steps.
    pub spread: f64,
    /// Share of the mean area ratio that [`super::losses::Loss::Fold`] wants every face to keep.
    pub margin: f64,
    /// Rate of the first step and of the last.
    pub rate: [f64; 2],
    /// Seed of weights and batches.
    pub seed: u64,
}

impl TrainSettings {
    /// The published training: width 512, all vertices, the published losses, the fewest of the published steps.
    pub const PAPER: Self = Self {
        widths: Widths { hidden: 512, code: 64 },
        steps: 2000,
        batch: 0,
        weights: LossWeights::PUBLISHED,
        side: 1.0,
        spread: 0.25,
        margin: 0.1,
        rate: [1e-3, 1e-5],
        seed: 0,
    };
}

/// The losses at one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Number of the step, from 0.
    pub step: usize,
    /// The losses, unweighted; one that was not looked at in this step has the value of its last look.
    pub losses: PerLoss<f32>,
}

/// Where results go.
pub struct TrainOutput<'a> {
    /// UVs (vertices, 2), as the network gives them.
    pub q: &'a mut [f32],
    /// Seam scores (vertices); above 0.5 is a seam.
    pub scores: &'a mut [f32],
    /// Weights ([`Widths::parameter_count`]).
    pub weights: &'a mut [f32],
    /// Samples of the losses at evenly spaced steps; any length.
    pub curve: &'a mut [Sample],
}

/// How the run went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainSummary {
    /// Steps that were made.
    pub steps: usize,
    /// The step after which the weights were kept; 0: those of the start.
    pub best_step: usize,
    /// The smoothed objective then, without the losses that are looked at every fifth step.
    pub objective: f64,
    /// Whether the watcher stopped the run.
    pub was_stopped: bool,
    /// Samples written to the curve.
    pub samples: usize,
    /// From the mesh's frame to the networks'.
    pub frame: Frame,
}

/// Why nothing was trained. No output was touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrainError {
    /// A slice has `given` values where `expected` belong.
    Length {
        /// Which slice.
        what: &'static str,
        /// Values that it should have.
        expected: usize,
        /// Values that it has.
        given: usize,
    },
    /// A corner of `face` names no vertex.
    Corner {
        /// The face.
        face: usize,
    },
    /// A number of the vertex is not finite.
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// There is nothing to learn: no vertex, or a width of 0.
    Empty,
    /// More memory is needed.
    Scratch(ScratchTooSmall),
}

impl From<ScratchTooSmall> for TrainError {
    fn from(error: ScratchTooSmall) -> Self {
        TrainError::Scratch(error)
    }
}

impl core::fmt::Display for TrainError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            TrainError::Length { what, expected, given } => write!(f, "{what}: {given} values, {expected} expected"),
            TrainError::Corner { face } => write!(f, "face {face} names a vertex that is not there"),
            TrainError::NotFinite { vertex } => write!(f, "vertex {vertex} has a number that is not finite"),
            TrainError::Empty => write!(f, "nothing to learn: no vertices, or networks of width 0"),
            TrainError::Scratch(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for TrainError {}

/// Is told of every step.
pub trait Watch {
    /// `sample` was step `sample.step` of `steps`; `Break` ends the run with the best map so far.
    fn step(&mut self, sample: &Sample, steps: usize) -> ControlFlow<()>;
}

/// Nobody watches.
pub struct Unwatched;

impl Watch for Unwatched {
    fn step(&mut self, _: &Sample, _: usize) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
