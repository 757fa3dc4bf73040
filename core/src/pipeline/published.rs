//! The published training: networks of position for each large piece, cut where their map tears.
//!
//! A piece is trained from its points, normals and exposure (see `learn::train`), from random weights. The trained map is evaluated at
//! every vertex, cut where it tears (`tears`) and packed. What then overlaps is counted, not mended.
//! Pieces are trained side by side (`super::training`). Those of few vertices, and all but the [`MOST`] largest, are made by the exact
//! stages. Without weight on visibility the method is blind to exposure.

use super::learning::{LearnScene, Learning, MOST};
use super::report::UnwrapError;
use super::tears::tear;
use super::training::{train_pieces, training_need};
use crate::base::pace::Pace;
use crate::base::progress::{Progress, Stage, Wish};
use crate::base::scratch::{Scratch, bytes_for};
use crate::charts::pieces::Pieces;
use crate::learn::training::TrainSettings;
use crate::search::budget::Budget;
use crate::search::seams::make_charts;
use glam::{DVec2, DVec3};

/// Vertices from which on a piece is trained: a map of fewer is as quickly made exactly.
pub const FEW: usize = 200;

/// Scratch bytes beyond those of the exact method, for training `lanes` pieces side by side ([`MOST`] at the most): as many as
/// there are threads are enough. A run with more memory trains more at a time, one with less fewer; no bit depends on it.
pub fn published_need(triangles: usize, vertices: usize, settings: &TrainSettings, lanes: usize) -> usize {
    let vertices = vertices.max(triangles).min(3 * triangles);
    let lists = bytes_for::<f32>(vertices)
        .saturating_mul(12)
        .saturating_add(bytes_for::<DVec3>(vertices).saturating_mul(2))
        .saturating_add(bytes_for::<u32>(triangles).saturating_mul(28))
        .saturating_add(bytes_for::<DVec2>(3 * triangles).saturating_mul(2));
    lists.saturating_add(training_need(triangles, vertices, settings, lanes))
}

/// Charts of every piece by maps; `uv` and `cut` have one entry a corner, in the order of the pieces.
pub(super) fn published(
    uv: &mut [DVec2],
    cut: &mut [u8],
    scene: &LearnScene,
    learning: &mut Learning,
    mut scratch: Scratch,
    progress: &mut dyn Progress,
) -> Result<(), UnwrapError> {
    let (order, count) = largest(scene.pieces, scene.kept);
    let budget = Budget { bulky: true, ..scene.budget };
    let is_exact = |p: &usize| scene.kept[*p] == 0 && !order[..count].contains(&(*p as u32));
    for p in (0..scene.pieces.count()).filter(is_exact) {
        let corners = scene.pieces.corners(p);
        exactly(&mut uv[corners.clone()], &mut cut[corners], p, scene, budget, scratch.frame(), progress)?;
    }
    let vertices = vertex_count(&order[..count], scene.pieces);
    let (q, scores) = (scratch.take::<f32>(2 * vertices)?, scratch.take::<f32>(vertices)?);
    train_pieces(q, scores, &order[..count], scene, learning, scratch.frame(), progress)?;
    let mut first = 0;
    for (k, p) in order[..count].iter().enumerate() {
        let corners = scene.pieces.corners(*p as usize);
        let (uv, cut) = (&mut uv[corners.clone()], &mut cut[corners.clone()]);
        let mut frame = scratch.frame();
        let surface = scene.pieces.surface(*p as usize, &mut frame)?;
        let n = surface.mesh.positions.len();
        let q = &q[2 * first..2 * (first + n)];
        first += n;
        if k >= learning.summary.maps {
            // Stopped before its turn.
            exactly(uv, cut, *p as usize, scene, budget, frame, progress)?;
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
