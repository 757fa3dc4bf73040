//! The published training of a mesh's large pieces, side by side.
//!
//! Pieces share nothing: each steps on a worker of its own, and what comes out depends neither on how many go on at a time
//! nor on the threads. As many go on as memory is there for; the last one left has all workers to itself. After a step of each
//! the caller hears of it and may stop all: the maps are then the best so far, and pieces that had not begun have none.

use super::decimal::Decimal;
use super::learning::{LearnScene, Learning, MOST};
use super::report::UnwrapError;
use crate::base::progress::{Progress, Stage, Wish};
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::{Slices, take_first};
use crate::base::workers::{Serial, for_each_chunk};
use crate::learn::evaluate::evaluate_need;
use crate::learn::kernels::path::Path;
use crate::learn::losses::Loss;
use crate::learn::run::{Run, train_need};
use crate::learn::training::{Sample, TrainError, TrainInput, TrainOutput, TrainSettings};
use crate::mesh::normals::{NormalWeight, vertex_normals};
use core::fmt::Write;
use core::mem::take;
use glam::DVec3;

/// A piece of little more than no faces gets this share of the steps; one that is all of the mesh gets all.
const LEAST_STEPS: f64 = 0.125;
/// Steps between two notes of the losses.
const NOTE: usize = 25;

/// Scratch bytes for training `lanes` pieces side by side out of a mesh of so many triangles and vertices. With fewer, fewer
/// go on at a time, as long as there is enough for one.
pub(super) fn training_need(triangles: usize, vertices: usize, settings: &TrainSettings, lanes: usize) -> usize {
    let (whole, more) = (train_need(vertices, triangles, settings), lanes.clamp(1, MOST) - 1);
    // Without batches pieces take what their vertices take, and together no more than the mesh in one; with batches each
    // takes as much as the other.
    let further = if settings.batch == 0 { train_need(64, 64, settings) } else { whole };
    whole.max(evaluate_need(settings.widths)).saturating_add(further.saturating_mul(more))
}

/// Scratch bytes of a piece in training.
fn job_need(triangles: usize, vertices: usize, settings: &TrainSettings) -> usize {
    bytes_for::<f32>(3 * vertices)
        .saturating_mul(2)
        .saturating_add(bytes_for::<f32>(vertices))
        .saturating_add(bytes_for::<DVec3>(vertices).max(train_need(vertices, triangles, settings)))
}

/// One piece in training.
struct TrainingJob<'j> {
    run: Run<'j>,
    goes_on: Result<bool, ScratchTooSmall>,
}

/// Trains a map of each piece in `order`: UVs `q` (2 a vertex) and seam `scores` of their vertices, one piece's after the
/// other's. The summary says how many were trained.
#[allow(clippy::too_many_arguments)]
pub(super) fn train_pieces(
    mut q: &mut [f32],
    mut scores: &mut [f32],
    order: &[u32],
    scene: &LearnScene,
    learning: &mut Learning,
    mut scratch: Scratch,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let settings = |p: u32| settings_of(p as usize, scene, &learning.settings);
    let total = order.iter().map(|p| settings(*p).steps).sum();
    let width = learning.settings.widths.parameter_count();
    let (mut weights, mut curve) = (&mut *learning.weights, &mut *learning.curve);
    let (path, summary) = (Path::best(), &mut learning.summary);
    while summary.maps < order.len() && !summary.was_stopped {
        let mut wave = scratch.frame();
        let mut jobs = heapless::Vec::<TrainingJob, MOST>::new();
        while let Some(p) = order.get(summary.maps + jobs.len()) {
            let (piece, settings) = (*p as usize, settings(*p));
            let mesh = scene.pieces.bare_surface(piece).mesh;
            let n = mesh.positions.len();
            let need = job_need(mesh.faces.len(), n, &settings);
            if wave.remaining() < need && !jobs.is_empty() {
                break;
            }
            let memory = wave.split(need.min(wave.remaining()))?;
            let output = TrainOutput {
                q: take_first(&mut q, 2 * n),
                scores: take_first(&mut scores, n),
                weights: take_first(&mut weights, width),
                curve: take(&mut curve),
            };
            let run = begin(output, piece, &settings, scene, memory)?;
            jobs.put(TrainingJob { run, goes_on: Ok(true) });
        }
        let mut lead = 0;
        while jobs.iter().any(|job| job.goes_on == Ok(true)) {
            let alone = jobs.iter().filter(|job| job.goes_on == Ok(true)).count() == 1;
            let inner = if alone { scene.workers } else { &Serial };
            for_each_chunk(scene.workers, &mut jobs, 1, &|_, job| {
                if job[0].goes_on == Ok(true) {
                    job[0].goes_on = job[0].run.step(path, inner);
                }
            });
            while lead + 1 < jobs.len() && jobs[lead].goes_on == Ok(false) {
                lead += 1;
            }
            tell(&jobs[lead].run, progress);
            let steps = jobs.iter().map(|job| job.run.steps()).sum::<usize>();
            if progress.report(Stage::Learn, (summary.steps + steps).min(total), total) == Wish::Stop {
                jobs.iter_mut().for_each(|job| job.run.stop());
            }
        }
        for job in jobs {
            job.goes_on?;
            let done = job.run.finish(path, scene.workers)?;
            (summary.maps, summary.steps) = (summary.maps + 1, summary.steps + done.steps);
            summary.samples = summary.samples.max(done.samples);
            summary.was_stopped |= done.was_stopped;
        }
    }
    Ok(())
}

/// The settings for piece `p`: its share of the steps.
fn settings_of(p: usize, scene: &LearnScene, settings: &TrainSettings) -> TrainSettings {
    let mut settings = *settings;
    let share = scene.pieces.corners(p).len() as f64 / (3 * scene.pieces.rest().len()) as f64;
    settings.steps = ((settings.steps as f64 * share.max(LEAST_STEPS)) as usize).max(1);
    settings
}

/// Piece `p` before its first step; everything that its training needs lies in `scratch`.
fn begin<'j>(
    output: TrainOutput<'j>,
    p: usize,
    settings: &TrainSettings,
    scene: &LearnScene<'j>,
    mut scratch: Scratch<'j>,
) -> Result<Run<'j>, UnwrapError> {
    let mesh = scene.pieces.bare_surface(p).mesh;
    let n = mesh.positions.len();
    let positions = scratch.take::<f32>(3 * n)?;
    let normals = scratch.take::<f32>(3 * n)?;
    let exposure = scratch.take_filled::<f32>(n, 1.0)?;
    let faces = mesh.faces.as_flattened();
    let flat = |out: &mut [f32], from: &[DVec3]| {
        let rows = out.as_chunks_mut::<3>().0.iter_mut().zip(from);
        rows.for_each(|(out, p)| out.copy_from(&p.as_vec3().to_array()));
    };
    flat(positions, mesh.positions);
    {
        let mut frame = scratch.frame();
        let exact = frame.take::<DVec3>(n)?;
        vertex_normals(exact, mesh, NormalWeight::Angle);
        flat(normals, exact);
    }
    let corners = scene.pieces.corners(p);
    for c in 0..mesh.corner_count() as u32 {
        exposure[mesh.vertex(c) as usize] = (scene.open)(scene.pieces.source[corners.start + c as usize]);
    }
    let input = TrainInput { positions, normals, faces, exposure };
    Run::new(output, input, settings, scratch).map_err(|e| match e {
        TrainError::Scratch(e) => e.into(),
        // A piece has vertices, and its numbers come from a repaired mesh.
        _ => UnwrapError::NoTriangle,
    })
}

/// Tells people the losses of a run.
fn tell(run: &Run, progress: &mut dyn Progress) {
    let (Sample { step, losses }, settings) = (run.last(), run.settings());
    if step.is_multiple_of(NOTE) {
        let on = |loss: &&Loss| settings.weights.0[**loss as usize] != 0.0;
        let mut text = heapless::String::<256>::new();
        for loss in Loss::ALL.iter().filter(on) {
            // What does not fit is left out.
            let _ = write!(text, " {} {}", loss.name(), Decimal(losses[*loss as usize]));
        }
        progress.note(format_args!("step {step} of {}:{text}", settings.steps));
    }
}
