//! Training a map for one mesh: from points, normals, faces and exposure to Q, seam scores and the networks' weights.
//!
//! **Contract.** [`train`] takes a mesh in any frame (it is put into the unit box; [`Summary::frame`] says how) and fills
//! [`Output`]: UVs of all vertices, seam scores, weights for [`super::evaluate::evaluate`] at other points, and a sample
//! of the losses. The same input and settings give the same bits for any [`Workers`], [`Path`] and machine.
//! [`train_need`] says the bytes; one less is refused before any output is touched. [`Watch`] is told the losses of every
//! step and may stop the run; what comes out is the best map so far: weights are kept whenever the smoothed objective
//! is at its lowest, looked at every [`super::run::CHECK`] steps and at the end. A run that leaves the finite numbers stops there.
//! Losses that are looked at every fifth step weigh in at those steps alone, as published. A [`Run`] is the same training
//! made step by step, so that several can go on side by side.
//!
//! **More losses.** An operation on the tape (see [`super::tape`]), a variant of [`Loss`] with its weight, and its lines in
//! [`super::losses::Graph::record`]; this file does not change. [`Loss::Fold`] and [`Loss::Distortion`] are examples.
//!
//! Limits: memory is that of the batch, about 340 bytes x width a point (values and gradients of 42 layers' outputs):
//! 0.5 GB for all 2,930 points of Spot at width 512. Without batches that is the whole mesh.

use super::backbone::Widths;
use super::batch::{rings_need, sampler_need, sizes};
use super::evaluate::{Frame, evaluate_need, seam_scores_need};
use super::kernels::Path;
use super::losses::{Graph, Loss, LossWeights, PerLoss};
use super::run::Run;
use super::tape::SEAM_NEIGHBOURS;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::Workers;
use core::ops::ControlFlow;

/// A mesh to learn: oriented triangles over vertices.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// Positions (vertices, 3), in any frame.
    pub positions: &'a [f32],
    /// Unit normals (vertices, 3).
    pub normals: &'a [f32],
    /// Corners (faces, 3).
    pub faces: &'a [u32],
    /// Those of the faces that the losses of triangles look at (any number, 3): all, or all but what is torn.
    pub smooth: &'a [u32],
    /// UVs that [`Loss::Target`] pulls to (vertices, 2), or nothing where it is off.
    pub target: &'a [f32],
    /// Exposure (vertices), 1 = open.
    pub exposure: &'a [f32],
}

/// What is trained, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
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
    /// Share of the mean area ratio that [`Loss::Fold`] wants every face to keep.
    pub margin: f64,
    /// Rate of the first step and of the last.
    pub rate: [f64; 2],
    /// Seed of weights and batches.
    pub seed: u64,
}

impl Settings {
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
    /// Width 64, batches of 1,024 points, [`LossWeights::FITTED`], a box of side 4: of cow and Spot it tears .32 and .21 of the
    /// faces in 1,000 steps; side 1 .41 and .25, 2 .34 and .25, 8 .34 and .20. On Spot, started from charts: rate 1e-3 leaves 1.6 times the
    /// distance from the start that 4e-3 leaves; with the published losses beside it, a step takes three times as long and the
    /// result is worse, as it is with folds or distortion (docs/RESULTS.md).
    pub const STANDARD: Self = Self {
        widths: Widths { hidden: 64, code: 16 },
        steps: 1500,
        batch: 1024,
        weights: LossWeights::FITTED,
        side: 4.0,
        rate: [4e-3, 1e-5],
        ..Self::PAPER
    };
    /// A look at what a map would be: width 32, batches of 512 points.
    pub const DRAFT: Self = Self { widths: Widths { hidden: 32, code: 8 }, steps: 600, batch: 512, ..Self::STANDARD };

    /// The preset of that name: `draft`, `standard` or `paper`.
    pub fn preset(name: &str) -> Option<Self> {
        match name {
            "draft" => Some(Self::DRAFT),
            "standard" => Some(Self::STANDARD),
            "paper" => Some(Self::PAPER),
            _ => None,
        }
    }
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
pub struct Output<'a> {
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
pub struct Summary {
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

/// Bytes of scratch memory that [`train`] or a [`Run`] takes.
pub fn train_need(vertices: usize, faces: usize, settings: &Settings) -> usize {
    let graph = record(vertices, faces, settings);
    let weights = settings.widths.parameter_count();
    let loop_need = sampler_need(vertices)
        .saturating_add(bytes_for::<f32>(graph.tape.value_count()).saturating_mul(2))
        .saturating_add(bytes_for::<u32>(graph.tape.index_count()))
        .saturating_add(bytes_for::<f32>(weights.saturating_mul(2)));
    let beside = graph.tape.scratch_need::<f32>().max(evaluate_need(settings.widths)).max(seam_scores_need(vertices));
    bytes_for::<f32>(vertices.saturating_mul(3))
        .saturating_add(bytes_for::<u32>(vertices.saturating_mul(SEAM_NEIGHBOURS)))
        .saturating_add(rings_need(vertices, faces).max(loop_need.saturating_add(beside)))
}

pub(super) fn record(vertices: usize, faces: usize, settings: &Settings) -> Graph {
    let faces = if settings.weights.look_at_faces() { faces } else { 0 };
    Graph::record(settings.widths, sizes(vertices, faces, settings.batch), settings.spread, settings.margin)
}

/// Trains a map of `input`; see the head of this file.
#[allow(clippy::too_many_arguments)]
pub fn train(
    output: Output,
    input: Input,
    settings: &Settings,
    path: Path,
    workers: &dyn Workers,
    watch: &mut dyn Watch,
    scratch: &mut Scratch,
) -> Result<Summary, TrainError> {
    let mut run = Run::new(output, input, settings, scratch.frame())?;
    while run.step(path, workers)? {
        if watch.step(run.last(), settings.steps).is_break() {
            run.stop();
        }
    }
    Ok(run.finish(path, workers)?)
}

pub(super) fn check(output: &Output, input: &Input, settings: &Settings) -> Result<(), TrainError> {
    let vertices = input.exposure.len();
    let is_whole = |what, given: usize, expected: usize| {
        if given == expected { Ok(()) } else { Err(TrainError::Length { what, expected, given }) }
    };
    is_whole("positions", input.positions.len(), 3 * vertices)?;
    is_whole("normals", input.normals.len(), 3 * vertices)?;
    is_whole("faces", input.faces.len(), input.faces.len() / 3 * 3)?;
    is_whole("UVs", output.q.len(), 2 * vertices)?;
    is_whole("seam scores", output.scores.len(), vertices)?;
    is_whole("weights", output.weights.len(), settings.widths.parameter_count())?;
    if vertices == 0 || settings.widths.hidden == 0 || settings.widths.code == 0 {
        return Err(TrainError::Empty);
    }
    if !input.target.is_empty() || settings.weights.0[Loss::Target as usize] != 0.0 {
        is_whole("target", input.target.len(), 2 * vertices)?;
    }
    if !input.smooth.len().is_multiple_of(3) || input.smooth.len() > input.faces.len() {
        return Err(TrainError::Length {
            what: "smooth faces",
            expected: input.faces.len(),
            given: input.smooth.len(),
        });
    }
    if let Some(vertex) = input.target.iter().position(|x| !x.is_finite()) {
        return Err(TrainError::NotFinite { vertex: vertex / 2 });
    }
    if let Some(corner) = input.smooth.iter().position(|i| *i as usize >= vertices) {
        return Err(TrainError::Corner { face: corner / 3 });
    }
    if let Some(corner) = input.faces.iter().position(|i| *i as usize >= vertices) {
        return Err(TrainError::Corner { face: corner / 3 });
    }
    let is_finite = |v: &usize| {
        let row = 3 * v..3 * v + 3;
        let all = input.positions[row.clone()].iter().chain(&input.normals[row]);
        all.chain([&input.exposure[*v]]).all(|x| x.is_finite())
    };
    match (0..vertices).find(|v| !is_finite(v)) {
        Some(vertex) => Err(TrainError::NotFinite { vertex }),
        None => Ok(()),
    }
}
