//! Trials of closing paths of the cut graph, side by side, each on maps of its own.
//!
//! The chart beside a path is welded along it and relaxed; cheap questions come first, overlaps last.

use super::beside::{Tried, try_beside};
use super::compact::PRICE;
use super::goal::{Goal, Which};
use super::split::self_overlaps;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::workers::Workers;
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::charts::work::{Work, work_on};
use crate::mesh::view::next;
use crate::plane::hull::hull_of;
use crate::plane::motion::Motion;
use crate::price::cost::DISTORTION_WORTH;
use crate::solve::bound::{distortion, worst};
use crate::solve::piece::Stop;
use core::sync::atomic::AtomicBool;
use glam::DVec2;

/// Hull area, over all area, that a path may add for what it saves: less than a split would have to save. At the price
/// of splits 13 meshes fill .709 of the square.
pub const HULL_PRICE: f64 = 0.31 * PRICE;
/// Trials side by side at the most.
pub const BESIDE: usize = 4;
/// Newton steps of a trial.
const STOP: Stop = Stop { steps: 30, tolerance: 1e-3 };

/// Maps, and what may become of them.
#[derive(Clone, Copy)]
pub struct Closing<'c> {
    /// What is cut.
    pub surface: &'c Surface<'c>,
    /// What must hold without a path.
    pub goal: Goal,
    /// Area of the surface.
    pub total: f64,
    /// Distortion of the maps.
    pub distortion: f64,
    /// Energy of a face that may be there afterwards.
    pub cap: f64,
}

/// A path, and what is saved without it over the square root of all area.
pub type Candidate<'p> = (&'p [u32], f64);

/// Alarms of trials.
pub type Alarms = [AtomicBool; BESIDE];

impl Closing<'_> {
    /// Tries to close paths; no more than [`BESIDE`].
    pub fn try_beside<'j, 'p: 'j>(
        &self,
        paths: impl ExactSizeIterator<Item = Candidate<'p>>,
        uv: &[DVec2],
        cut: &[u8],
        alarms: &'j Alarms,
        scratch: Scratch<'j>,
        workers: &dyn Workers,
    ) -> Result<heapless::Vec<Tried<'j, Candidate<'p>, (), ScratchTooSmall>, BESIDE>, ScratchTooSmall> {
        try_beside(paths, uv, cut, alarms, scratch, workers, &|path, own_uv, own_cut, scratch| {
            self.close(*path, own_uv, own_cut, uv, scratch, workers)
        })
    }

    /// Takes a path out; something where it may stay out. `before`: the maps with it.
    fn close(
        &self,
        (path, saved): Candidate,
        uv: &mut [DVec2],
        cut: &mut [u8],
        before: &[DVec2],
        mut scratch: Scratch,
        workers: &dyn Workers,
    ) -> Result<Option<()>, ScratchTooSmall> {
        let Closing { surface, goal, total, distortion: was, cap } = *self;
        let ends = [path[0] / 3, surface.twin[path[0] as usize] / 3];
        let hulls = |charts: &ChartList, uv: &[DVec2], cut: &[u8]| match goal.bulky {
            true => 0.0,
            false => hulls(ends, uv, cut, charts, surface),
        };
        let hulls_before = {
            let mut frame = scratch.frame();
            let charts = ChartList::new(surface, cut, &mut frame)?;
            let area = hulls(&charts, uv, cut);
            lay_beside(path, uv, &charts, surface);
            area
        };
        path.iter().for_each(|c| surface.set_cut(cut, *c, false));
        let charts = ChartList::new(surface, cut, &mut scratch)?;
        let own = charts.of_face[ends[0] as usize];
        let is_own = |k: usize| k as u32 == own;
        let holds = work_on(uv, surface, cut, &charts, is_own, Work::Weld(STOP), scratch.frame(), workers)?
            && distortion(uv, surface.rest) <= goal.distortion.min(was + saved / DISTORTION_WORTH)
            && worst(uv, surface.rest) <= cap
            && hulls(&charts, uv, cut) - hulls_before <= HULL_PRICE * saved * total;
        if !holds {
            return Ok(None);
        }
        let overlaps = overlaps_of(ends[0], uv, &charts, scratch.frame(), workers)?;
        // A slit lies in one chart: the charts are those of before.
        let holds = overlaps == 0
            || goal.which == Which::Slits && overlaps <= overlaps_of(ends[0], before, &charts, scratch, workers)?;
        Ok(holds.then_some(()))
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

/// Area of the hulls of the charts that hold one of two faces.
fn hulls(ends: [u32; 2], uv: &[DVec2], cut: &[u8], charts: &ChartList, surface: &Surface) -> f64 {
    let [a, b] = ends.map(|f| charts.of_face[f as usize]);
    let hull = |k: u32| {
        surface.outer_open(cut, charts.faces_of(k as usize), uv).map_or(0.0, |c| hull_of(border(c, uv, cut, surface)))
    };
    hull(a) + if a == b { 0.0 } else { hull(b) }
}

/// Points of the border of the chart that the open half-edge `c` belongs to.
pub fn border<'b>(c: u32, uv: &'b [DVec2], cut: &'b [u8], surface: &'b Surface) -> impl Iterator<Item = DVec2> + 'b {
    surface.border(cut, c).map(|c| uv[c as usize])
}

/// Points that face each other across a path, to the left and to the right, with the length that they stand for.
pub fn facing<'s>(
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
