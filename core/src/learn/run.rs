//! A training that goes on step by step: what is kept between steps, a step, and the end.
//!
//! [`super::train::train`] makes all steps of one run; whoever trains several meshes side by side steps each by itself. The
//! bits are the same either way. Its contract, with memory and outputs, is that of [`super::train`].

use super::adamw;
use super::backbone::{LAYERS, initialise};
use super::batch::{Mesh, Sampler, rings, rings_need, sampler_need, sizes};
use super::evaluate::{Frame, evaluate, evaluate_need, seam_scores, seam_scores_need};
use super::kernels::path::Path;
use super::losses::{Loss, LossGraph, PerLoss};
use super::tape::operation::Replay;
use super::tape::seam::NEIGHBOURS as SEAM_NEIGHBOURS;
use super::tape::var::Var;
use super::training::{Sample, TrainError, TrainInput, TrainOutput, TrainSettings, TrainSummary};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::workers::Workers;

/// Steps between two looks at whether the map is the best so far.
pub const CHECK: usize = 20;
/// Share of the past in the smoothed objective: about 20 steps. Batches of 1,000 points vary by a tenth.
const SMOOTH: f64 = 0.95;

/// Bytes of scratch memory that [`super::train::train`] or a [`Run`] takes.
pub fn train_need(vertices: usize, faces: usize, settings: &TrainSettings) -> usize {
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

fn record(vertices: usize, faces: usize, settings: &TrainSettings) -> LossGraph {
    let faces = if settings.weights.look_at_faces() { faces } else { 0 };
    LossGraph::record(settings.widths, sizes(vertices, faces, settings.batch), settings.spread, settings.margin)
}

/// A training under way.
pub struct Run<'a> {
    output: TrainOutput<'a>,
    given: &'a [f32], // positions as they came
    mesh: Mesh<'a>,
    settings: TrainSettings,
    graph: LossGraph,
    parameters: [[Var; 2]; LAYERS],
    sampler: Sampler<'a>,
    values: &'a mut [f32],
    gradients: &'a mut [f32],
    indices: &'a mut [u32],
    moments: &'a mut [f32],
    memory: Scratch<'a>,
    last: Sample,
    losses: PerLoss<f64>,
    smoothed: Option<f64>,
    is_over: bool,
    summary: TrainSummary,
}

impl<'a> Run<'a> {
    /// Before the first step. What is refused leaves the outputs untouched.
    pub fn new(
        output: TrainOutput<'a>,
        input: TrainInput<'a>,
        settings: &TrainSettings,
        mut memory: Scratch<'a>,
    ) -> Result<Self, TrainError> {
        check(&output, &input, settings)?;
        let (vertices, faces) = (input.exposure.len(), input.faces.len() / 3);
        memory.require(train_need(vertices, faces, settings))?;
        let mut frame = Frame::of(input.positions);
        frame.scale *= settings.side as f32;
        let positions = memory.take_unset::<f32>(input.positions.len())?;
        frame.apply(positions, input.positions);
        let ring = memory.take_unset::<u32>(vertices * SEAM_NEIGHBOURS)?;
        rings(ring, positions, input.faces, &mut memory)?;
        let TrainInput { normals, exposure, .. } = input;
        let faces = if settings.weights.look_at_faces() { input.faces } else { &[] };
        let mesh = Mesh { positions, normals, exposure, faces, ring };

        let graph = record(vertices, faces.len() / 3, settings);
        let sampler = Sampler::new(vertices, settings.seed, &mut memory)?;
        let values = memory.take::<f32>(graph.tape.value_count())?;
        let gradients = memory.take::<f32>(graph.tape.value_count())?;
        let indices = memory.take::<u32>(graph.tape.index_count())?;
        let moments = memory.take::<f32>(2 * output.weights.len())?;
        let parameters = graph.backbone.parameters();
        graph.fill_constants(values);
        let count = output.weights.len();
        initialise(&mut values[..count], &settings.widths.layers(), settings.seed);
        output.weights.copy_from(&values[..count]);
        let summary =
            TrainSummary { steps: 0, best_step: 0, objective: f64::INFINITY, was_stopped: false, samples: 0, frame };
        Ok(Self {
            output,
            given: input.positions,
            mesh,
            settings: *settings,
            graph,
            parameters,
            sampler,
            values,
            gradients,
            indices,
            moments,
            memory,
            last: Sample::default(),
            losses: [0.0; Loss::ALL.len()],
            smoothed: None,
            is_over: settings.steps == 0,
            summary,
        })
    }

    /// The losses of the last step.
    pub fn last(&self) -> &Sample {
        &self.last
    }

    /// What is trained, and how.
    pub fn settings(&self) -> &TrainSettings {
        &self.settings
    }

    /// Steps that were made.
    pub fn steps(&self) -> usize {
        self.summary.steps
    }

    /// Ends the run before its time: the best map so far is its result.
    pub fn stop(&mut self) {
        self.is_over = true;
        self.summary.was_stopped = true;
    }

    /// Makes a step; false, with nothing done, once the run is over.
    pub fn step(&mut self, path: Path, workers: &dyn Workers) -> Result<bool, ScratchTooSmall> {
        let (settings, graph, step) = (&self.settings, &self.graph, self.summary.steps);
        if self.is_over {
            return Ok(false);
        }
        let (values, gradients, indices) = (&mut *self.values, &mut *self.gradients, &mut *self.indices);
        let active = settings.weights.active(step);
        self.sampler.fill(graph, &self.mesh, step, values, indices);
        let mut replay = Replay { values, gradients, indices, scratch: self.memory.frame(), path, workers };
        graph.tape.forward(&mut replay, active)?;
        graph.tape.backward(
            &mut replay,
            &graph.seeds(&settings.weights, active),
            active,
            self.parameters.as_flattened(),
        )?;
        let now = graph.values(replay.values);
        let looked_at = |loss: &&Loss| loss.bit() & active != 0;
        for loss in Loss::ALL.iter().filter(looked_at) {
            self.losses[*loss as usize] = now[*loss as usize];
        }
        let steady = Loss::ALL.iter().filter(looked_at).filter(|loss| !loss.is_rare());
        let objective: f64 = steady.map(|loss| settings.weights.0[*loss as usize] * now[*loss as usize]).sum();
        if !objective.is_finite() {
            self.is_over = true;
            return Ok(false);
        }
        let smooth = self.smoothed.map_or(objective, |past: f64| SMOOTH * past + (1.0 - SMOOTH) * objective);
        self.smoothed = Some(smooth);
        let count = self.output.weights.len();
        let weights = &mut self.values[..count];
        // The gradient belongs to the weights before the step, so these are what the objective has judged.
        if (step.is_multiple_of(CHECK) || step + 1 == settings.steps) && smooth <= self.summary.objective {
            self.output.weights.copy_from(weights);
            (self.summary.best_step, self.summary.objective) = (step, smooth);
        }
        let rate = adamw::cosine_rate(settings.rate[0], settings.rate[1], step, settings.steps);
        adamw::update(weights, self.moments, &self.gradients[..count], rate, step + 1, workers);

        self.summary.steps = step + 1;
        self.is_over = step + 1 == settings.steps;
        self.last = Sample { step, losses: self.losses.map(|x| x as f32) };
        // Spread over the run; a curve that is longer than the run takes every step.
        let (curve, samples) = (&mut *self.output.curve, &mut self.summary.samples);
        if step * curve.len() >= *samples * settings.steps && *samples < curve.len() {
            curve[*samples] = self.last;
            *samples += 1;
        }
        Ok(true)
    }

    /// Evaluates the best map at every vertex.
    pub fn finish(mut self, path: Path, workers: &dyn Workers) -> Result<TrainSummary, ScratchTooSmall> {
        let TrainOutput { q, scores, weights, .. } = self.output;
        let (summary, settings) = (&mut self.summary, &self.settings);
        // The last step's weights have no objective of their own yet; a run that came to its end keeps them.
        if summary.steps == settings.steps && summary.best_step + 1 == settings.steps {
            weights.copy_from(&self.values[..weights.len()]);
            summary.best_step = settings.steps;
        }
        evaluate(q, weights, settings.widths, &summary.frame, self.given, path, workers, &mut self.memory)?;
        seam_scores(scores, q, self.mesh.ring, workers, &mut self.memory)?;
        Ok(*summary)
    }
}

/// Whether the slices have the lengths that belong to each other, and hold what can be learned from.
fn check(output: &TrainOutput, input: &TrainInput, settings: &TrainSettings) -> Result<(), TrainError> {
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
