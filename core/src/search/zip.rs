//! Zipping cuts that the bound does not need.
//!
//! Extension looks one round ahead, and splitting against overlap adds cuts that make older ones useless. So each path of the
//! cut graph whose absence leaves disks (a slit with a free end, or a path between two charts) or a hole (a slit between two
//! borders of its chart, as from a bore to the rim) may be taken out: its chart
//! is welded along it and relaxed, and the path stays out where nothing overlaps, the bound holds, and the hull grows by no more area
//! than splitting bulky charts would pay for it. What costs most to be seen comes first, over the energy that closing adds,
//! which goes with the squared gap between the two sides. Slivers, charts too small to paint on, are joined to a neighbour
//! wherever that holds, whatever the hull.
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
use core::sync::atomic::AtomicBool;
use glam::DVec2;

/// Paths that are tried at the most; each costs a relaxation of its chart.
const TRIES: usize = 24;
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
}

impl SeamPath {
    fn half_edges<'l>(&self, list: &'l [u32]) -> &'l [u32] {
        &list[self.first as usize..(self.first + self.count) as usize]
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
        let spare = goal.distortion - distortion(uv, surface.rest);
        if spare <= 0.0 {
            return Ok(zipped);
        }
        let mut frame = scratch.frame();
        let (list, paths) = find_paths(uv, cut, failed, surface, goal, spare * total, &mut frame)?;
        let paths = &paths[..paths.len().min(TRIES - tried)];
        let closing = Closing { surface, goal, total, cap: goal.worst.max(worst(uv, surface.rest)) };
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
            match job.holds {
                Ok(true) => {
                    uv.copy_from(job.uv);
                    cut.copy_from(job.cut);
                    return Ok(Some(at));
                }
                Ok(false) => job.path.iter().for_each(|c| failed[*c as usize] = 1),
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
            Which::Slits => seams.is_slit(path),
        };
        if !seams.may_go(path) || !wanted || path.iter().any(is_failed) {
            continue;
        }
        if let Some((score, saved)) = seams.score(path, uv, goal, spare) {
            paths[count] = SeamPath { score, saved, first: begin as u32, count: (len - begin) as u32 };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::workers::Serial;
    use crate::base::workers::tests::Backwards;
    use crate::first::halving::flatten_all;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use crate::mesh::view::next;
    use crate::solve::energy::Rest;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// A square of cells whose middle vertex is lifted, cut along the middle line up to column `to` and flattened.
    #[derive(Clone, Copy)]
    struct Square {
        side: u32,
        lift: f64,
        to: u32,
        ring: bool,  // whether the cell above the middle line that begins at `to` is cut out
        notch: bool, // whether the cells beyond the middle on both axes are missing
        hole: bool,  // whether the four cells around the middle are missing
        cost: f64,   // of a cut, over its length
    }

    const PLANE: Square = Square { side: 4, lift: 0.0, to: 2, ring: false, notch: false, hole: false, cost: 1.0 };
    const LOOSE: Goal = Goal { distortion: 1.5, worst: f64::INFINITY, bulky: false, which: Which::All };

    /// What [`zip`] answers, and the cut edges before and after.
    fn zip_square(square: Square, goal: Goal, bytes: &mut [u8]) -> (Result<usize, StageError>, usize, usize) {
        let (done, maps) = zipped(square, goal, bytes, &Serial);
        let [before, after] = maps.map(|(_, cut)| cut.iter().filter(|c| **c != 0).count() / 2);
        (done, before, after)
    }

    /// What [`zip`] answers, and the maps before and after.
    #[allow(clippy::type_complexity)]
    fn zipped(
        square: Square,
        goal: Goal,
        bytes: &mut [u8],
        workers: &dyn Workers,
    ) -> (Result<usize, StageError>, [(Vec<DVec2>, Vec<u8>); 2]) {
        let (n, half) = (square.side + 1, square.side / 2);
        let at = |v: u32| {
            let z = if v == n * n / 2 { square.lift } else { 0.0 };
            DVec3::new(f64::from(v % n), f64::from(v / n), z)
        };
        let positions: Vec<DVec3> = (0..n * n).map(at).collect();
        let cells = (0..square.side * square.side)
            .filter(|i| !square.notch || i / square.side < half || i % square.side < half)
            .filter(|i| !square.hole || [i / square.side, i % square.side].iter().any(|x| *x + 1 < half || *x > half));
        let corners = cells.map(|i| i / square.side * n + i % square.side);
        let faces: Vec<[u32; 3]> = corners.flat_map(|v| [[v, v + 1, v + n + 1], [v, v + n + 1, v + n]]).collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let mut memory = vec![0; 1 << 22];
        let mut keep = Scratch::new(&mut memory);
        let mut twin = vec![0; 3 * faces.len()];
        twins(&mut twin, mesh, keep.frame()).unwrap();
        let rest: Vec<Rest> = faces.iter().map(|f| Rest::new(f.map(|v| positions[v as usize]), 0.0)).collect();
        let cost = vec![square.cost; 3 * faces.len()];
        let surface = Surface::new(mesh, &twin, &rest, &cost, &mut keep).unwrap();
        let mut uv: Vec<DVec2> = (0..3 * faces.len() as u32).map(|c| mesh.position(c).truncate()).collect();
        let mut cut = vec![0; 3 * faces.len()];
        for c in 0..cut.len() as u32 {
            let (p, q) = (mesh.position(c), mesh.position(next(c)));
            let (low, at) = (f64::from(half), f64::from(square.to));
            let on_line = p.y == low && q.y == low && p.x.max(q.x) <= at;
            let side =
                p.x.min(q.x) >= at && p.x.max(q.x) <= at + 1.0 && p.y.min(q.y) >= low && p.y.max(q.y) <= low + 1.0;
            if on_line || square.ring && side && (p.x == q.x || p.y == q.y) {
                surface.set_cut(&mut cut, c, true);
            }
        }
        flatten_all(&mut uv, &mut cut, &surface, keep.frame(), &Serial).unwrap();
        let before = (uv.clone(), cut.clone());
        let done = zip(&mut uv, &mut cut, &surface, goal, Scratch::new(bytes), workers, &mut |_, _| Ok(()));
        (done, [before, (uv, cut)])
    }

    #[test]
    fn trials_side_by_side_find_what_trials_one_by_one_find() {
        // The paths around the ring are tried until one of them may go.
        let goal = Goal { distortion: 1.02, ..LOOSE };
        for square in [PLANE, Square { ring: true, side: 8, lift: 0.5, ..PLANE }, Square { lift: 1.0, to: 4, ..PLANE }]
        {
            let outcome = |bytes: usize, workers: &dyn Workers| zipped(square, goal, &mut vec![0; bytes], workers);
            let expected = outcome(1 << 24, &Serial);
            assert!(expected.0.is_ok());
            assert!(expected == outcome(1 << 24, &Backwards));
            // Down to where there is memory for one.
            let mut bytes = 1 << 24;
            while bytes > 1 << 15 {
                bytes -= bytes / 8;
                let found = outcome(bytes, &Backwards);
                assert!(found == expected || found.0.is_err(), "{bytes}");
            }
        }
    }

    #[test]
    fn a_slit_and_a_path_between_two_charts_of_a_plane_close() {
        let mut bytes = vec![0; 1 << 22];
        assert_eq!(zip_square(PLANE, LOOSE, &mut bytes), (Ok(1), 2, 0));
        assert_eq!(zip_square(Square { to: 4, ..PLANE }, LOOSE, &mut bytes), (Ok(1), 4, 0));
    }

    #[test]
    fn a_tip_closes_only_where_the_mean_and_the_worst_face_allow_it() {
        // A pyramid whose top is as high as its base is wide from the middle.
        let tip = Square { lift: 1.0, ..PLANE };
        let mut bytes = vec![0; 1 << 22];
        assert_eq!(zip_square(tip, LOOSE, &mut bytes), (Ok(1), 2, 0));
        let (mean, worst) = (Goal { distortion: 1.0005, ..LOOSE }, Goal { worst: 4.02, ..LOOSE });
        assert_eq!(zip_square(tip, mean, &mut bytes), (Ok(0), 2, 2));
        assert_eq!(zip_square(tip, worst, &mut bytes), (Ok(0), 2, 2));
    }

    #[test]
    fn two_charts_stay_apart_where_their_common_hull_costs_more_than_the_path() {
        // Two arms of a corner: the hull of both is 14, the hulls of each 4 and 8.
        let arms = Square { notch: true, cost: 0.1, ..PLANE };
        let mut bytes = vec![0; 1 << 22];
        assert_eq!(zip_square(arms, LOOSE, &mut bytes), (Ok(0), 2, 2));
        assert_eq!(zip_square(arms, Goal { bulky: true, ..LOOSE }, &mut bytes), (Ok(1), 2, 0));
        assert_eq!(zip_square(Square { cost: 100.0, ..arms }, LOOSE, &mut bytes), (Ok(1), 2, 0));
    }

    #[test]
    fn a_sliver_at_the_end_of_a_slit_is_joined_and_the_slit_stays() {
        let (slivers, mut bytes) = (Goal { which: Which::Slivers, bulky: true, ..LOOSE }, vec![0; 1 << 25]);
        let square = Square { side: 34, to: 3, ring: true, ..PLANE };
        assert_eq!(zip_square(square, slivers, &mut bytes), (Ok(1), 7, 3));
        // A cell of 64 is none.
        assert_eq!(zip_square(Square { side: 8, ..square }, slivers, &mut bytes), (Ok(0), 7, 7));
        assert_eq!(zip_square(Square { ring: false, ..square }, slivers, &mut bytes), (Ok(0), 3, 3));
    }

    #[test]
    fn a_slit_from_a_hole_to_the_border_closes_and_leaves_the_hole() {
        let square = Square { side: 6, hole: true, ..PLANE };
        let (slits, mut bytes) = (Goal { which: Which::Slits, ..LOOSE }, vec![0; 1 << 22]);
        assert_eq!(zip_square(square, slits, &mut bytes), (Ok(1), 2, 0));
        // A path between two charts is no slit.
        assert_eq!(zip_square(Square { to: 4, ..PLANE }, slits, &mut bytes), (Ok(0), 4, 4));
    }

    #[test]
    fn without_cuts_nothing_is_done_and_too_little_memory_is_an_error() {
        assert_eq!(zip_square(Square { to: 0, ..PLANE }, LOOSE, &mut vec![0; 1 << 22]), (Ok(0), 0, 0));
        let (done, before, after) = zip_square(PLANE, LOOSE, &mut [0; 64]);
        assert!(done.is_err());
        assert_eq!(before, after);
    }
}
