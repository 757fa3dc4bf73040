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

use super::compact::PRICE;
use super::split::self_overlaps;
use crate::base::pace::StageError;
use crate::base::real::{for_decision, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::workers::Workers;
use crate::charts::list::ChartList;
use crate::charts::seams::walk_seam;
use crate::charts::surface::Surface;
use crate::charts::work::{Work, work_on};
use crate::mesh::view::next;
use crate::plane::hull::hull_of;
use crate::plane::motion::Motion;
use crate::solve::bound::{distortion, worst};
use crate::solve::piece::Stop;
use bytemuck::{Pod, Zeroable};
use core::ops::Range;
use glam::DVec2;

/// Hull area, over all area, that a path may add for what it saves: less than a split would have to save. At the price
/// of splits 13 meshes fill .709 of the square.
const HULL_PRICE: f64 = 0.4 * PRICE;
/// Paths that are tried at the most; each costs a relaxation of its chart.
const TRIES: usize = 24;
/// Of ends: 24 gain no more.
const END_TRIES: usize = 10;
/// Cost over the square root of all area below which an end is not tried.
const END_WORTH: f64 = 0.01;
/// Squared gap, over all area and the distortion that is left, above which a path is not tried. Closed paths added 0.3
/// to 1.5 of it.
const REACH: f64 = 4.0;
/// Share of the distortion that is left, below which energies count as equal: what is seen most goes first.
const CHEAP: f64 = 0.1;
/// Newton steps of a trial.
const STOP: Stop = Stop { steps: 30, tolerance: 1e-3 };
/// A chart below this share of all area is a sliver: 32 texels square of 1024.
const SLIVER: f64 = 1e-3;

/// Which paths may be taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// All.
    All,
    /// Those between a sliver and another chart.
    Slivers,
    /// Those inside a chart, at any time: overlaps may be there that are parted later.
    Slits,
    /// Of those with a free end half, from there on, and of what fails half again.
    Ends,
}

impl Which {
    /// How many are tried at the most.
    fn tries(self) -> usize {
        if self == Self::Ends { END_TRIES } else { TRIES }
    }
}

/// What zipping may do.
#[derive(Clone, Copy)]
pub struct Goal {
    /// Mean symmetric Dirichlet energy over 4 at the end.
    pub distortion: f64,
    /// Symmetric Dirichlet energy of a face that was below.
    pub worst: f64,
    /// Whether a chart may become bulky.
    pub bulky: bool,
    /// Which paths are tried.
    pub which: Which,
}

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

/// Scratch bytes for [`zip`] beyond those for relaxing all charts.
pub const fn zip_need(faces: usize, vertices: usize) -> usize {
    8 * bytes_for::<u32>(3 * faces)
        + bytes_for::<DVec2>(3 * faces)
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
    let old_uv = scratch.take::<DVec2>(uv.len())?;
    let total: f64 = surface.rest.iter().map(|r| r.area).sum();
    let (mut zipped, mut tried) = (0, 0);
    loop {
        let spare = goal.distortion - distortion(uv, surface.rest);
        if spare <= 0.0 {
            return Ok(zipped);
        }
        let mut frame = scratch.frame();
        let (list, paths) = find_paths(uv, cut, failed, surface, goal, spare * total, &mut frame)?;
        let mut better = false;
        for p in paths {
            if tried == goal.which.tries() {
                return Ok(zipped);
            }
            tried += 1;
            mark(uv, cut)?;
            let path = &list[p.first as usize..(p.first + p.count) as usize];
            let ends = [path[0] / 3, surface.twin[path[0] as usize] / 3];
            old_uv.copy_from(uv);
            let cap = goal.worst.max(worst(uv, surface.rest));
            let hulls = |charts: &ChartList, uv: &[DVec2], cut: &[u8]| match goal.bulky {
                true => 0.0,
                false => hulls(ends, uv, cut, charts, surface),
            };
            let (before, overlaps) = {
                let mut frame = frame.frame();
                let charts = ChartList::new(surface, cut, &mut frame)?;
                let before = hulls(&charts, uv, cut);
                let overlaps = match goal.which {
                    Which::Slits => overlaps_of(ends[0], uv, &charts, frame.frame(), workers)?,
                    _ => 0,
                };
                lay_beside(path, uv, &charts, surface);
                (before, overlaps)
            };
            path.iter().for_each(|c| surface.set_cut(cut, *c, false));
            let mut frame = frame.frame();
            let charts = ChartList::new(surface, cut, &mut frame)?;
            let sound = close(uv, cut, path[0] / 3, &charts, surface, frame.frame(), workers)?
                && overlaps_of(ends[0], uv, &charts, frame.frame(), workers)? <= overlaps;
            let compact = goal.bulky || hulls(&charts, uv, cut) - before <= HULL_PRICE * p.saved * total;
            let within = distortion(uv, surface.rest) <= goal.distortion && worst(uv, surface.rest) <= cap;
            if sound && compact && within {
                zipped += 1;
                better = true;
                break;
            }
            path.iter().for_each(|c| surface.set_cut(cut, *c, true));
            let barred = &list[p.barred as usize..(p.barred + p.bars) as usize];
            barred.iter().for_each(|c| failed[*c as usize] = 1);
            uv.copy_from(old_uv);
        }
        if !better {
            return Ok(zipped);
        }
    }
}

/// Moves the chart on the left of a path to where the sides of the path are nearest to each other.
fn lay_beside(path: &[u32], uv: &mut [DVec2], charts: &ChartList, surface: &Surface) {
    let [left, right] = [path[0], surface.twin[path[0] as usize]].map(|c| charts.of_face[(c / 3) as usize]);
    if left != right {
        let motion = Motion::fit(|| facing(path, uv, surface));
        let corners = charts.faces_of(left as usize).iter().flat_map(|f| 3 * f..3 * f + 3);
        corners.for_each(|c| uv[c as usize] = motion.apply(uv[c as usize]));
    }
}

/// Welds the chart of a face and relaxes it; whether nothing flips then.
fn close(
    uv: &mut [DVec2],
    cut: &[u8],
    face: u32,
    charts: &ChartList,
    surface: &Surface,
    scratch: Scratch,
    workers: &dyn Workers,
) -> Result<bool, ScratchTooSmall> {
    let own = charts.of_face[face as usize];
    work_on(uv, surface, cut, charts, |k| k as u32 == own, Work::Weld(STOP), scratch, workers)
}

/// How many faces of the chart of a face lie on others of it.
fn overlaps_of(
    face: u32,
    uv: &[DVec2],
    charts: &ChartList,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<usize, ScratchTooSmall> {
    let own = charts.of_face[face as usize];
    let partner = scratch.take::<u32>(charts.of_face.len())?;
    self_overlaps(partner, uv, charts.of_face, charts.count(), |k| k == own, scratch, workers)
}

/// Points of the border of the chart that the open half-edge `c` belongs to.
fn border<'b>(c: u32, uv: &'b [DVec2], cut: &'b [u8], surface: &'b Surface) -> impl Iterator<Item = DVec2> + 'b {
    surface.border(cut, c).map(|c| uv[c as usize])
}

/// Area of the hulls of the charts that hold one of two faces.
fn hulls(ends: [u32; 2], uv: &[DVec2], cut: &[u8], charts: &ChartList, surface: &Surface) -> f64 {
    let [a, b] = ends.map(|f| charts.of_face[f as usize]);
    let hull = |k: u32| {
        surface.outer_open(cut, charts.faces_of(k as usize), uv).map_or(0.0, |c| hull_of(border(c, uv, cut, surface)))
    };
    hull(a) + if a == b { 0.0 } else { hull(b) }
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

/// Points that face each other across a path, to the left and to the right, with the length that they stand for.
fn facing<'s>(
    path: &'s [u32],
    uv: &'s [DVec2],
    surface: &'s Surface,
) -> impl Iterator<Item = (DVec2, DVec2, f64)> + 's {
    path.iter().flat_map(|c| {
        let (t, half) = (surface.twin[*c as usize], 0.5 * surface.length(*c));
        let at = |c: u32| uv[c as usize];
        [(at(*c), at(next(t)), half), (at(next(*c)), at(t), half)]
    })
}
