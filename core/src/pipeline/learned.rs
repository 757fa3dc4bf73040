//! Methods that learn: a network for each large piece, whose map becomes charts, or tells the exact stages where to cut.
//!
//! `neural`: a piece is trained from its points, normals and exposure (see `learn::train`), starting from a map that is one to
//! one: the exact stages' charts of the piece, side by side, of which each vertex takes the UV of its widest wedge. The trained
//! map is evaluated at every vertex, cut where it tears (`tears`) and packed. What then overlaps is counted, not mended.
//! `hybrid`: each piece is made by the exact stages; a network is trained from that start, and where its map has seams a cut
//! costs less: the exact stages run again on these costs. Of both results the one whose cuts cost less without the rebate is
//! kept, if it holds the bound as well. Every guarantee is that of the exact stages.
//! Pieces are trained side by side (`super::training`). Those of few vertices, and all but the [`MOST`] largest, are made by the exact stages.
//! Without weight on visibility, `neural` is blind to exposure from the start on.

use super::learning::{LearnScene, Learning, MOST};
use super::pieces::unwrap_pieces;
use super::report::UnwrapError;
use super::tears::tear;
use super::training::{train_pieces, training_need};
use crate::base::pace::Pace;
use crate::base::progress::{Progress, Stage, Wish};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::charts::pieces::Pieces;
use crate::charts::surface::Surface;
use crate::learn::evaluate::{Frame, evaluate};
use crate::learn::kernels::path::Path;
use crate::learn::training::TrainSettings;
use crate::mesh::view::next;
use crate::search::budget::Budget;
use crate::search::seams::make_charts;
use crate::solve::bound::distortion;
use glam::{DVec2, DVec3};

/// Vertices from which on a piece is trained: a map of fewer is as quickly made exactly.
const FEW: usize = 200;
/// Share of its cost that an edge on a learned seam saves (`hybrid`).
const SAVED: f64 = 0.8;

/// Scratch bytes beyond those of the exact method, for training `lanes` pieces side by side ([`MOST`] at the most): as many as
/// there are threads are enough. A run with more memory trains more at a time, one with less fewer; no bit depends on it.
pub fn learned_need(triangles: usize, vertices: usize, settings: &TrainSettings, lanes: usize) -> usize {
    let vertices = vertices.max(triangles).min(3 * triangles);
    let lists = bytes_for::<f32>(vertices)
        .saturating_mul(12)
        .saturating_add(bytes_for::<DVec3>(vertices).saturating_mul(2))
        .saturating_add(bytes_for::<u32>(triangles).saturating_mul(28))
        .saturating_add(bytes_for::<DVec2>(3 * triangles).saturating_mul(2));
    lists.saturating_add(training_need(triangles, vertices, settings, lanes))
}

/// Charts of every piece by maps; `uv` and `cut` have one entry a corner, in the order of the pieces.
pub(super) fn neural(
    uv: &mut [DVec2],
    cut: &mut [u8],
    scene: &LearnScene,
    learning: &mut Learning,
    mut scratch: Scratch,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let (order, count) = largest(scene.pieces, scene.kept);
    let given = learning.summary.maps;
    let budget = Budget { bulky: true, ..scene.budget };
    let total = scene.pieces.count();
    let from_charts = given == 0 && learning.start;
    if from_charts {
        unwrap_pieces(
            uv,
            cut,
            scene.kept,
            scene.pieces,
            budget,
            scratch.frame(),
            scene.workers,
            &mut pace(&mut Patient(progress), Stage::Flatten),
        )?;
    }
    let is_exact = |p: &usize| scene.kept[*p] == 0 && !order[..count].contains(&(*p as u32));
    for p in (0..total).filter(|p| !from_charts && is_exact(p)) {
        let corners = scene.pieces.corners(p);
        exactly(&mut uv[corners.clone()], &mut cut[corners], p, scene, budget, scratch.frame(), progress)?;
    }
    let vertices = vertex_count(&order[..count], scene.pieces);
    let (q, scores) = (scratch.take::<f32>(2 * vertices)?, scratch.take::<f32>(vertices)?);
    if given == 0 {
        let began = from_charts.then_some((&*uv, &*cut));
        train_pieces(q, scores, &order[..count], began, scene, learning, scratch.frame(), progress)?;
    }
    let mut first = 0;
    for (k, p) in order[..count].iter().enumerate() {
        let corners = scene.pieces.corners(*p as usize);
        let (uv, cut) = (&mut uv[corners.clone()], &mut cut[corners.clone()]);
        let mut frame = scratch.frame();
        let surface = scene.pieces.surface(*p as usize, &mut frame)?;
        let n = surface.mesh.positions.len();
        let q = &mut q[2 * first..2 * (first + n)];
        first += n;
        if given > 0 {
            given_map(q, &surface, scene, learning, given, frame.frame())?;
        } else if k >= learning.summary.maps {
            // Stopped before its turn.
            if !from_charts {
                exactly(uv, cut, *p as usize, scene, budget, frame, progress)?;
            }
            continue;
        }
        let points = frame.take::<DVec2>(n)?;
        points.iter_mut().zip(q.as_chunks::<2>().0.iter()).for_each(|(p, q)| *p = DVec2::new(q[0].into(), q[1].into()));
        let torn = frame.take::<u8>(surface.mesh.faces.len())?;
        let done = tear(uv, cut, torn, points, &surface, frame)?;
        learning.summary.torn.faces += done.faces;
        learning.summary.torn.folded += done.folded;
    }
    Ok(())
}

/// Charts of every piece by the exact stages, which large pieces' maps tell where to cut.
pub(super) fn hybrid(
    uv: &mut [DVec2],
    cut: &mut [u8],
    scene: &LearnScene,
    learning: &mut Learning,
    mut scratch: Scratch,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    unwrap_pieces(
        uv,
        cut,
        scene.kept,
        scene.pieces,
        scene.budget,
        scratch.frame(),
        scene.workers,
        &mut pace(&mut Patient(progress), Stage::Seams),
    )?;
    let (order, count) = largest(scene.pieces, scene.kept);
    let vertices = vertex_count(&order[..count], scene.pieces);
    let (q, scores) = (scratch.take::<f32>(2 * vertices)?, scratch.take::<f32>(vertices)?);
    train_pieces(q, scores, &order[..count], Some((&*uv, &*cut)), scene, learning, scratch.frame(), progress)?;
    let mut first = 0;
    for p in &order[..learning.summary.maps] {
        let corners = scene.pieces.corners(*p as usize);
        let (uv, cut) = (&mut uv[corners.clone()], &mut cut[corners.clone()]);
        let mut frame = scratch.frame();
        let surface = scene.pieces.surface(*p as usize, &mut frame)?;
        let scores = &scores[first..first + surface.mesh.positions.len()];
        first += scores.len();
        let cost = frame.take::<f64>(corners.len())?;
        for (c, out) in cost.iter_mut().enumerate() {
            let ends = [c as u32, next(c as u32)].map(|c| scores[surface.mesh.vertex(c) as usize]);
            let seam = f64::from(ends[0] + ends[1]) * 0.5;
            // A training that left the finite numbers has nothing to say.
            let seam = if seam.is_finite() { seam } else { 0.0 };
            *out = surface.cost[c] * (1.0 - SAVED * seam);
        }
        let other_uv = frame.take::<DVec2>(corners.len())?;
        let other_cut = frame.take::<u8>(corners.len())?;
        let guided = Surface { cost, ..surface };
        let mut patient = Patient(progress);
        let mut marks = pace(&mut patient, Stage::Seams);
        marks.at(*p as usize, scene.pieces.count());
        make_charts(other_uv, other_cut, &guided, scene.budget, frame.frame(), scene.workers, &mut marks)?;
        // Judged by what the exact method pays, not by the price that the guide has lowered.
        let paid = |cut: &[u8]| (0..cut.len()).filter(|c| cut[*c] != 0).map(|c| surface.cost[c]).sum::<f64>();
        let missed = |uv: &[DVec2]| {
            let over = distortion(uv, surface.rest) - scene.budget.distortion;
            if over.is_nan() { f64::INFINITY } else { over.max(0.0) }
        };
        let (before, after) = ([missed(uv), paid(cut)], [missed(other_uv), paid(other_cut)]);
        if after < before {
            uv.copy_from(other_uv);
            cut.copy_from(other_cut);
        }
    }
    Ok(())
}

/// Charts of piece `p` without a map.
fn exactly(
    uv: &mut [DVec2],
    cut: &mut [u8],
    p: usize,
    scene: &LearnScene,
    budget: Budget,
    mut scratch: Scratch,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let mut keep = scratch.frame();
    let surface = scene.pieces.surface(p, &mut keep)?;
    let mut patient = Patient(progress);
    let mut marks = pace(&mut patient, Stage::Flatten);
    marks.at(p, scene.pieces.count());
    Ok(make_charts(uv, cut, &surface, budget, keep, scene.workers, &mut marks)?)
}

/// Of stages whose result is half of what training needs: they do not end early.
struct Patient<'p>(&'p mut dyn Progress);

impl Progress for Patient<'_> {
    fn report(&mut self, stage: Stage, done: usize, total: usize) -> Wish {
        match self.0.report(stage, done, total) {
            Wish::Stop => Wish::Stop,
            Wish::GoOn | Wish::Finish => Wish::GoOn,
        }
    }
}

fn pace<'p>(patient: &'p mut Patient, stage: Stage) -> Pace<'p> {
    Pace::new(patient, stage, u64::MAX)
}

/// The pieces that are learned, the largest first, and how many.
fn largest(pieces: &Pieces, kept: &[u8]) -> ([u32; MOST], usize) {
    let size = |p: u32| pieces.bare_surface(p as usize).mesh.positions.len();
    let (mut order, mut count) = ([0; MOST], 0);
    for p in (0..pieces.count() as u32).filter(|p| size(*p) >= FEW && kept[*p as usize] == 0) {
        let at = order[..count].iter().position(|q| size(*q) < size(p)).unwrap_or(count);
        if at < MOST {
            count = (count + 1).min(MOST);
            (at + 1..count).rev().for_each(|i| order[i] = order[i - 1]);
            order[at] = p;
        }
    }
    (order, count)
}

fn vertex_count(order: &[u32], pieces: &Pieces) -> usize {
    order.iter().map(|p| pieces.bare_surface(*p as usize).mesh.positions.len()).sum()
}

/// Evaluates the given map in whose frame the piece fills the unit box best.
fn given_map(
    q: &mut [f32],
    surface: &Surface,
    scene: &LearnScene,
    learning: &Learning,
    given: usize,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let positions = scratch.take::<f32>(3 * surface.mesh.positions.len())?;
    let fill = |k: usize, positions: &mut [f32]| {
        let [x, y, z, add] = learning.frames[k].map(DVec3::from);
        for (out, p) in positions.as_chunks_mut::<3>().0.iter_mut().zip(surface.mesh.positions) {
            let p = (scene.input_of)(*p);
            let p = DVec3::new(x.dot(p), y.dot(p), z.dot(p)) + add;
            out.copy_from(&p.as_vec3().to_array());
        }
    };
    let mut best = (f32::INFINITY, 0);
    for k in 0..given {
        fill(k, positions);
        let here = Frame::of(positions);
        let size = 1.0 / here.scale - learning.settings.side as f32;
        let gap = here.centre.iter().map(|c| c * c).sum::<f32>() + size * size;
        if gap < best.0 {
            best = (gap, k);
        }
    }
    fill(best.1, positions);
    let widths = learning.settings.widths;
    let width = widths.parameter_count();
    let weights = &learning.weights[best.1 * width..(best.1 + 1) * width];
    let frame = Frame { centre: [0.0; 3], scale: 1.0 };
    evaluate(q, weights, widths, &frame, positions, Path::best(), scene.workers, &mut scratch)
}
