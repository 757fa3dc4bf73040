//! Training of a mesh's large pieces, side by side, each from the exact stages' charts of it.
//!
//! Pieces share nothing: each steps on a worker of its own, and what comes out depends neither on how many go on at a time
//! nor on the threads. As many go on as memory is there for; the last one left has all workers to itself. After a step of each
//! the caller hears of it and may stop all: the maps are then the best so far, and pieces that had not begun have none.

use super::learning::{LearnScene, Learning, MOST};
use super::report::UnwrapError;
use crate::base::progress::{Progress, Stage, Wish};
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::{Slices, take_first};
use crate::base::workers::{Serial, for_each_chunk};
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::learn::evaluate::evaluate_need;
use crate::learn::kernels::path::Path;
use crate::learn::losses::Loss;
use crate::learn::run::{Run, train_need};
use crate::learn::training::{Sample, TrainError, TrainInput, TrainOutput, TrainSettings};
use crate::mesh::normals::{NormalWeight, vertex_normals};
use crate::mesh::view::NONE;
use core::fmt::{self, Display, Formatter, Write};
use core::mem::take;
use glam::{DVec2, DVec3};

/// A piece of little more than no faces gets this share of the steps; one that is all of the mesh gets all.
const LEAST_STEPS: f64 = 0.125;
/// Gap between charts of the start, over the height of the tallest.
const GAP: f64 = 0.1;
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
    // The surface's lists, its charts, and what the start takes beside them.
    let start = bytes_for::<u32>(3 * triangles)
        .saturating_add(2 * bytes_for::<u32>(vertices + 2))
        .saturating_add(3 * bytes_for::<u32>(triangles + 2))
        .saturating_add(bytes_for::<DVec2>(triangles));
    bytes_for::<f32>(3 * vertices)
        .saturating_mul(2)
        .saturating_add(bytes_for::<f32>(vertices))
        .saturating_add(bytes_for::<f32>(2 * vertices))
        .saturating_add(bytes_for::<u32>(3 * triangles))
        .saturating_add(start.max(bytes_for::<DVec3>(vertices)).max(train_need(vertices, triangles, settings)))
}

/// One piece in training.
struct TrainingJob<'j> {
    run: Run<'j>,
    goes_on: Result<bool, ScratchTooSmall>,
}

/// Trains a map of each piece in `order`: UVs `q` (2 a vertex) and seam `scores` of their vertices, one piece's after the
/// other's. `began` holds charts to start from, one entry a corner of all pieces. The summary says how many were trained.
#[allow(clippy::too_many_arguments)]
pub(super) fn train_pieces(
    mut q: &mut [f32],
    mut scores: &mut [f32],
    order: &[u32],
    began: Option<(&[DVec2], &[u8])>,
    scene: &LearnScene,
    learning: &mut Learning,
    mut scratch: Scratch,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let began = began.filter(|_| learning.start);
    let settings = |p: u32| settings_of(p as usize, began.is_some(), scene, &learning.settings);
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
            let run = begin(output, piece, began, &settings, scene, memory)?;
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
            let inside = |p: DVec3| (p - DVec3::from(done.frame.centre.map(f64::from))) * f64::from(done.frame.scale);
            let from_input = |p: DVec3| inside((scene.place_of)(p));
            let zero = from_input(DVec3::ZERO);
            let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| (from_input(e) - zero).to_array());
            let row = |i: usize| [columns[0][i], columns[1][i], columns[2][i]];
            learning.frames[summary.maps] = [row(0), row(1), row(2), zero.to_array()];
            (summary.maps, summary.steps) = (summary.maps + 1, summary.steps + done.steps);
            summary.samples = summary.samples.max(done.samples);
            summary.was_stopped |= done.was_stopped;
        }
    }
    Ok(())
}

/// The settings for piece `p`: its share of the steps, and no way back to a start that is not there.
fn settings_of(p: usize, has_start: bool, scene: &LearnScene, settings: &TrainSettings) -> TrainSettings {
    let mut settings = *settings;
    let share = scene.pieces.corners(p).len() as f64 / (3 * scene.pieces.rest().len()) as f64;
    settings.steps = ((settings.steps as f64 * share.max(LEAST_STEPS)) as usize).max(1);
    if !has_start {
        settings.weights = settings.weights.with(Loss::Target, 0.0);
    }
    settings
}

/// Piece `p` before its first step; everything that its training needs lies in `scratch`.
fn begin<'j>(
    output: TrainOutput<'j>,
    p: usize,
    began: Option<(&[DVec2], &[u8])>,
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
    let target = scratch.take::<f32>(if began.is_some() { 2 * n } else { 0 })?;
    let smooth = scratch.take::<u32>(faces.len())?;
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
    let mut smooth_len = faces.len();
    smooth.copy_from(faces);
    if let Some((uv, cut)) = began {
        let mut frame = scratch.frame();
        let surface = scene.pieces.surface(p, &mut frame)?;
        smooth_len = start_from(target, smooth, &uv[corners.clone()], &cut[corners], &surface, frame)?;
    }
    let input = TrainInput { positions, normals, faces, smooth: &smooth[..smooth_len], target, exposure };
    Run::new(output, input, settings, scratch).map_err(|e| match e {
        TrainError::Scratch(e) => e.into(),
        // A piece has vertices, and its numbers come from a repaired mesh.
        _ => UnwrapError::NoTriangle,
    })
}

/// Writes the map to start from, charts side by side on [-1, 1]^2, and moves the faces it does not tear to the front of
/// `smooth`; returns the length of these.
fn start_from(
    target: &mut [f32],
    smooth: &mut [u32],
    uv: &[DVec2],
    cut: &[u8],
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let charts = ChartList::new(surface, cut, &mut scratch)?;
    let shift = scratch.take::<DVec2>(charts.count())?;
    let corners = |k: usize| charts.faces_of(k).iter().flat_map(|f| (3 * f)..(3 * f + 3));
    let bounds = |k: usize| {
        corners(k).fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), c| {
            (low.min(uv[c as usize]), high.max(uv[c as usize]))
        })
    };
    let tall = (0..charts.count()).fold(0.0, |tall, k| (bounds(k).1.y - bounds(k).0.y).max(tall));
    let mut along = 0.0;
    for (k, shift) in shift.iter_mut().enumerate() {
        let (low, high) = bounds(k);
        *shift = DVec2::new(along - low.x, -low.y);
        along += high.x - low.x + GAP * tall;
    }
    let size = DVec2::new(along - GAP * tall, tall);
    let scale = 2.0 / size.max_element().max(1e-300);
    let chosen = scratch.take_filled::<u32>(surface.mesh.positions.len(), NONE)?;
    for (v, chosen) in chosen.iter_mut().enumerate() {
        let mut widest = 0;
        for c in surface.corners_at(v as u32).iter().filter(|c| surface.wedge_start(cut, **c) == **c) {
            let width = surface.wedge(cut, *c).count();
            if width > widest {
                (*chosen, widest) = (*c, width);
            }
        }
        if *chosen != NONE {
            let place = uv[*chosen as usize] + shift[charts.of_face[(*chosen / 3) as usize] as usize];
            let place = (place - size * 0.5) * scale;
            target[2 * v..2 * v + 2].copy_from(&place.as_vec2().to_array());
        }
    }
    let mut len = 0;
    for (f, corners) in surface.mesh.faces.iter().enumerate() {
        let starts = |c: u32| surface.wedge_start(cut, c);
        if (0..3).all(|i| chosen[corners[i] as usize] == starts((3 * f + i) as u32)) {
            smooth[len..len + 3].copy_from(corners);
            len += 3;
        }
    }
    Ok(len)
}

/// A number with four decimals, written by integers: the standard library's own writing of floats holds paths that panic.
struct Decimal(f32);

impl Display for Decimal {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        if !self.0.is_finite() {
            return f.write_str("not finite");
        }
        let parts = (f64::from(self.0.abs()) * 1e4 + 0.5) as u64;
        write!(f, "{}{}.{:04}", if self.0 < 0.0 { "-" } else { "" }, parts / 10_000, parts % 10_000)
    }
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

#[cfg(test)]
mod tests {
    use super::Decimal;
    use std::format;

    #[test]
    fn a_decimal_reads_as_the_standard_library_would_write_it() {
        for x in [0.0f32, 1.0, 0.25, 0.123_46, 12.000_04, 3.999_96, 1e6, 7e-9, -2.5] {
            assert_eq!(format!("{}", Decimal(x)), format!("{x:.4}"));
        }
        assert_eq!(format!("{}", Decimal(f32::NAN)), "not finite");
    }
}
