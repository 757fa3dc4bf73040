//! Zipping cuts that the bound does not need.
//!
//! Extension looks one round ahead, and splitting against overlap adds cuts that make older ones useless. So each path of the
//! cut graph whose absence leaves disks (a slit with a free end, or a path between two charts) or a hole (a slit between two
//! borders of its chart, as from a bore to the rim) may be taken out: its chart
//! is welded along it and relaxed, and the path stays out where nothing overlaps, the bound holds, and the hull grows by no more area
//! than splitting bulky charts would pay for it. What costs most to be seen comes first, over the energy that closing adds,
//! which goes with the squared gap between the two sides. Slivers, charts too small to paint on, are joined to a neighbour
//! wherever that holds, whatever the hull. What the bound leaves in the end closes slits in part, from their free ends.
//! Guarantee: disks stay disks but for holes, without flips, and overlap as much as before at the most; the distortion stays within the goal if it was.
//! Cost: at most [`TRIES`] relaxations of one chart.

use super::closing::{BESIDE, Closing, HULL_PRICE, border, facing};
use super::goal::{Goal, Which};
use crate::base::pace::StageError;
use crate::base::real::{for_decision, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::workers::Workers;
use crate::charts::seams::walk_seam;
use crate::charts::surface::Surface;
use crate::plane::hull::hull_of;
use crate::plane::motion::Motion;
use crate::solve::bound::{distortion, worst};
use bytemuck::{Pod, Zeroable};
use core::ops::Range;
use core::sync::atomic::AtomicBool;
use glam::DVec2;

/// Cost over the square root of all area below which an end is not tried.
const END_WORTH: f64 = 0.01;
/// Squared gap, over all area and the distortion that is left, above which a path is not tried. Closed paths added 0.3
/// to 1.5 of it.
const REACH: f64 = 4.0;
/// Share of the distortion that is left, below which energies count as equal: what is seen most goes first.
const CHEAP: f64 = 0.1;
/// A chart below this share of all area is a sliver: 32 texels square of 1024.
const SLIVER: f64 = 1e-3;

/// A path of the cut graph between two nodes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct SeamPath {
    score: f64, // cost saved over the energy expected
    saved: f64, // cost saved over the square root of all area
    first: u32, // place in the list
    count: u32,
    barred: u32, // the first of those that are not tried again where it fails
    bars: u32,
}

impl SeamPath {
    fn half_edges<'l>(&self, list: &'l [u32]) -> &'l [u32] {
        &list[self.first as usize..(self.first + self.count) as usize]
    }

    /// What is not tried again where it fails.
    fn barred<'l>(&self, list: &'l [u32]) -> &'l [u32] {
        &list[self.barred as usize..(self.barred + self.bars) as usize]
    }
}

/// Scratch bytes for [`zip`] beyond those for relaxing all charts.
pub const fn zip_need(faces: usize, vertices: usize) -> usize {
    8 * bytes_for::<u32>(3 * faces)
        + bytes_for::<DVec2>(3 * faces)
        + bytes_for::<u8>(3 * faces)
        + bytes_for::<SeamPath>(3 * faces)
        + 5 * bytes_for::<u32>(faces + 2)
        + bytes_for::<f64>(faces)
        + bytes_for::<u32>(vertices)
}

/// Passes a mark at which the maps are these: UVs and cuts.
pub type MarkMaps<'m> = dyn FnMut(&[DVec2], &[u8]) -> Result<(), StageError> + 'm;

/// Takes paths out within `goal`; returns how many. `mark` is passed before each trial.
pub fn zip(
    uv: &mut [DVec2],
    cut: &mut [u8],
    surface: &Surface,
    goal: Goal,
    mut scratch: Scratch,
    workers: &dyn Workers,
    mark: &mut MarkMaps,
) -> Result<usize, StageError> {
    let failed = scratch.take::<u8>(cut.len())?;
    let total: f64 = surface.rest.iter().map(|r| r.area).sum();
    let (mut zipped, mut tried) = (0, 0);
    loop {
        let distortion = distortion(uv, surface.rest);
        let spare = goal.distortion - distortion;
        if spare <= 0.0 {
            return Ok(zipped);
        }
        let mut frame = scratch.frame();
        let (list, paths) = find_paths(uv, cut, failed, surface, goal, spare * total, &mut frame)?;
        let paths = &paths[..paths.len().min(goal.which.tries().saturating_sub(tried))];
        let closing = Closing { surface, goal, total, distortion, cap: goal.worst.max(worst(uv, surface.rest)) };
        match close_first(uv, cut, failed, list, paths, &closing, frame, workers, mark)? {
            Some(place) => tried += place + 1,
            None => return Ok(zipped),
        }
        zipped += 1;
    }
}

/// Closes the first of `paths` that may be closed, and marks those before it as failed; its place, or nothing where there is none.
#[allow(clippy::too_many_arguments)]
fn close_first(
    uv: &mut [DVec2],
    cut: &mut [u8],
    failed: &mut [u8],
    list: &[u32],
    paths: &[SeamPath],
    closing: &Closing,
    mut scratch: Scratch,
    workers: &dyn Workers,
    mark: &mut MarkMaps,
) -> Result<Option<usize>, StageError> {
    let alarms = [const { AtomicBool::new(false) }; BESIDE];
    let (mut at, mut marked, mut beside) = (0, 0, BESIDE);
    while at < paths.len() {
        if marked == at {
            mark(uv, cut)?;
            marked += 1;
        }
        let now = paths[at..(at + beside).min(paths.len())].iter().map(|p| (p.half_edges(list), p.saved));
        let tried = closing.try_beside(now, uv, cut, &alarms, scratch.frame(), workers);
        let jobs = match tried {
            // What is there was not enough for so many: for fewer it may be.
            Err(e) if beside > 1 && !e.is_alarm() => {
                beside /= 2;
                continue;
            }
            tried => tried?,
        };
        for job in jobs {
            if marked == at {
                mark(uv, cut)?;
                marked += 1;
            }
            match job.found {
                Ok(Some(())) => {
                    uv.copy_from(job.uv);
                    cut.copy_from(job.cut);
                    return Ok(Some(at));
                }
                Ok(None) => paths[at].barred(list).iter().for_each(|c| failed[*c as usize] = 1),
                Err(e) if beside > 1 && !e.is_alarm() => {
                    beside /= 2;
                    break;
                }
                Err(e) => return Err(e.into()),
            }
            at += 1;
        }
    }
    Ok(None)
}

/// The paths that may go, best first, and the half-edges of all. `spare`: energy over 4 that is left.
fn find_paths<'a>(
    uv: &[DVec2],
    cut: &[u8],
    failed: &[u8],
    surface: &Surface,
    goal: Goal,
    spare: f64,
    keep: &mut Scratch<'a>,
) -> Result<(&'a [u32], &'a [SeamPath]), ScratchTooSmall> {
    let list = keep.take::<u32>(cut.iter().filter(|c| **c != 0).count() / 2)?;
    let paths = keep.take::<SeamPath>(list.len())?;
    let seams = SeamGraph::new(cut, surface, keep)?;
    let seen = keep.take::<u8>(cut.len())?;
    let (mut len, mut count) = (0, 0);
    for first in 0..cut.len() as u32 {
        if cut[first as usize] == 0 || seen[first as usize] != 0 || !seams.is_node(surface.mesh.vertex(first)) {
            continue;
        }
        let begin = len;
        let is_cut = |c: u32| cut[c as usize] != 0;
        len += walk_seam(&mut list[begin..], seen, first, surface, is_cut, |v| seams.is_node(v));
        let path = &list[begin..len];
        let is_failed = |c: &u32| failed[*c as usize] != 0 || failed[surface.twin[*c as usize] as usize] != 0;
        let wanted = match goal.which {
            Which::All => true,
            Which::Slivers => seams.joins_sliver(path),
            Which::Slits | Which::Ends => seams.is_slit(path),
        };
        if !seams.may_go(path) || !wanted {
            continue;
        }
        let (part, barred) = match goal.which {
            Which::Ends => seams.end_of(path, is_failed),
            _ if path.iter().any(is_failed) => (0..0, 0..0),
            _ => (0..path.len(), 0..path.len()),
        };
        let path = &path[part.clone()];
        if path.is_empty() {
            continue;
        }
        if let Some((score, saved)) = seams.score(path, uv, goal, spare)
            && (goal.which != Which::Ends || saved >= END_WORTH)
        {
            let [first, barred_first] = [&part, &barred].map(|range| (begin + range.start) as u32);
            let [all, bars] = [part, barred].map(|range| range.len() as u32);
            paths[count] = SeamPath { score, saved, first, count: all, barred: barred_first, bars };
            count += 1;
        }
    }
    let paths = &mut paths[..count];
    sort::by(paths, |a, b| b.score.total_cmp(&a.score).then(a.first.cmp(&b.first)));
    Ok((list, paths))
}

/// The cuts as a graph, between charts.
struct SeamGraph<'a> {
    cut: &'a [u8],
    surface: &'a Surface<'a>,
    chart: &'a [u32],  // (f)
    areas: &'a [f64],  // (charts)
    degree: &'a [u32], // (n) cut edges at each vertex
    total: f64,        // area
}

impl<'a> SeamGraph<'a> {
    fn new<'k: 'a>(cut: &'a [u8], surface: &'a Surface<'a>, keep: &mut Scratch<'k>) -> Result<Self, ScratchTooSmall> {
        let chart = keep.take::<u32>(surface.mesh.faces.len())?;
        let queue = keep.take::<u32>(surface.mesh.faces.len())?;
        let charts = surface.charts(cut, chart, queue);
        let areas = keep.take::<f64>(charts)?;
        for (k, r) in chart.iter().zip(surface.rest) {
            areas[*k as usize] += r.area;
        }
        let degree = keep.take::<u32>(surface.mesh.positions.len())?;
        for c in (0..cut.len() as u32).filter(|c| cut[*c as usize] != 0) {
            degree[surface.mesh.vertex(c) as usize] += 1;
        }
        let total: f64 = surface.rest.iter().map(|r| r.area).sum();
        Ok(Self { cut, surface, chart, areas, degree, total })
    }

    /// Whether paths end at vertex `v`.
    fn is_node(&self, v: u32) -> bool {
        self.degree[v as usize] != 2 || self.surface.is_on_border(v)
    }

    /// Whether a path that ends at vertex `v` ends freely.
    fn is_free(&self, v: u32) -> bool {
        self.degree[v as usize] == 1 && !self.surface.is_on_border(v)
    }

    /// The charts to the left and to the right of a path.
    fn sides(&self, path: &[u32]) -> [usize; 2] {
        [path[0], self.surface.twin[path[0] as usize]].map(|c| self.chart[(c / 3) as usize] as usize)
    }

    /// Whether the path lies inside one chart.
    fn is_slit(&self, path: &[u32]) -> bool {
        let [left, right] = self.sides(path);
        left == right
    }

    /// Whether disks stay disks without the path, or get a hole.
    fn may_go(&self, path: &[u32]) -> bool {
        let (from, to) = (self.surface.mesh.vertex(path[0]), self.surface.far_end(path[path.len() - 1]));
        if self.is_slit(path) {
            let free = [from, to].map(|v| self.is_free(v));
            // The walls that keep a chart whole stand on one border.
            from != to && (free[0] != free[1] || free == [false; 2] && !self.surface.stays_whole)
        } else {
            !self.is_free(from) && !self.is_free(to) && (from != to || encloses(path, self.cut, self.surface))
        }
    }

    /// Which of the half-edges of a path are the half at its free end, or the half of what comes before the first that has failed; and that at
    /// the inner end of them. None where the path has no free end, or nothing is left.
    fn end_of(&self, path: &[u32], is_failed: impl Fn(&u32) -> bool) -> (Range<usize>, Range<usize>) {
        let (from, to) = (self.surface.mesh.vertex(path[0]), self.surface.far_end(path[path.len() - 1]));
        let half = |open: Option<usize>| match open {
            None => path.len() / 2,
            Some(open) => open - open / 2,
        };
        match [from, to].map(|v| self.is_free(v)) {
            [true, false] => {
                let count = half(path.iter().position(is_failed));
                (0..count, count.saturating_sub(1)..count)
            }
            [false, true] => {
                let first = path.len() - half(path.iter().rev().position(is_failed));
                (first..path.len(), first..path.len().min(first + 1))
            }
            _ => (0..0, 0..0),
        }
    }

    /// Whether the path lies between a sliver and another chart.
    fn joins_sliver(&self, path: &[u32]) -> bool {
        !self.is_slit(path) && self.sides(path).iter().any(|k| self.areas[*k] < SLIVER * self.total)
    }

    /// What is saved without the path over the energy expected, and what is saved over the square root of all area; nothing
    /// where its two sides are too far from each other, or the hull would grow by too much.
    fn score(&self, path: &[u32], uv: &[DVec2], goal: Goal, spare: f64) -> Option<(f64, f64)> {
        let Self { cut, surface, total, .. } = *self;
        let cost: f64 = path.iter().map(|c| surface.cost[*c as usize]).sum();
        let saved = cost / sqrt(total);
        let slit = self.is_slit(path);
        let motion = if slit { Motion::NONE } else { Motion::fit(|| facing(path, uv, surface)) };
        let gap = motion.gap(facing(path, uv, surface));
        if gap > REACH * spare {
            return None;
        }
        if !slit && !goal.bulky {
            // What the hull will be is seen before anything is flattened.
            let left = || border(path[0], uv, cut, surface);
            let right = || border(surface.twin[path[0] as usize], uv, cut, surface);
            let whole = hull_of(left().map(|p| motion.apply(p)).chain(right()));
            let parts = hull_of(left()) + hull_of(right());
            if whole - parts > HULL_PRICE * saved * total {
                return None;
            }
        }
        Some((for_decision(saved / (gap + CHEAP * spare)), saved))
    }
}

/// Whether a path that ends where it begins is the whole border of the chart on one of its sides.
fn encloses(path: &[u32], cut: &[u8], surface: &Surface) -> bool {
    let (first, last) = (path[0], path[path.len() - 1]);
    let across = |c: u32| surface.twin[c as usize];
    surface.following(cut, last) == first || surface.following(cut, across(first)) == across(last)
}
