//! Splitting charts that overlap themselves, along the cheapest path that parts what overlaps.
//!
//! The faces that lie on others of their chart form regions X and Y. A path that parts them runs between the two arcs of
//! the chart's border that lie between X and Y; one Dijkstra from one arc to the other finds the cheapest. A region
//! inside the chart is first joined to the border by the shortest corridor of faces.
//! Guarantee: a disk that is split gives two disks. Limit: one split a chart a call; the caller repeats.

use crate::base::real::for_decision;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::base::workers::Workers;
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::charts::wedge_paths::{Go, WedgePaths};
use crate::first::disks::{disks_again, slit_holes};
use crate::first::halving::halve;
use crate::mesh::view::NONE;
use crate::plane::grid::{GridPoint, GridTriangle, grid_bits};
use crate::plane::overlap::overlaps;
use bytemuck::{Pod, Zeroable};
use core::num::NonZero;
use glam::DVec2;

/// Factor on the cost of a cut through an overlapping region: such a cut leaves an overlap behind.
const THROUGH: f64 = 1e3;

/// Which side of a split a face has to be on.
const FREE: u8 = 0;
const X: u8 = 1;
const Y: u8 = 2;

/// Finds for each face of a `wanted` chart another face of the same chart that it overlaps, or `NONE`; returns how many have one.
#[allow(clippy::too_many_arguments)]
pub fn self_overlaps(
    partner: &mut [u32],
    uv: &[DVec2],
    chart: &[u32],
    chart_count: usize,
    wanted: impl Fn(u32) -> bool,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<usize, ScratchTooSmall> {
    partner.fill(NONE);
    let faces = scratch.take::<u32>(chart.iter().filter(|k| wanted(**k)).count())?;
    let all = (0..chart.len() as u32).filter(|f| wanted(chart[*f as usize]));
    faces.iter_mut().zip(all).for_each(|(slot, f)| *slot = f);
    // Charts side by side, a gap between them.
    let low = scratch.take_filled::<DVec2>(chart_count, DVec2::INFINITY)?;
    let high = scratch.take_filled::<DVec2>(chart_count, DVec2::NEG_INFINITY)?;
    for c in faces.iter().flat_map(|f| 3 * f..3 * f + 3) {
        let (k, p) = (chart[(c / 3) as usize] as usize, uv[c as usize]);
        low[k] = low[k].min(p);
        high[k] = high[k].max(p);
    }
    let (mut along, mut tall) = (0.0, 0.0f64);
    for k in (0..chart_count).filter(|k| wanted(*k as u32)) {
        let size = high[k] - low[k];
        low[k] = DVec2::new(along - low[k].x, -low[k].y);
        along += size.x * 1.01;
        tall = tall.max(size.y);
    }
    let bits = grid_bits(along.max(tall).max(1e-300));
    let triangles = scratch.take::<GridTriangle>(faces.len())?;
    for (t, f) in triangles.iter_mut().zip(faces.iter()) {
        let shift = low[chart[*f as usize] as usize];
        *t = [0, 1, 2].map(|i| GridPoint::snap(uv[3 * *f as usize + i] + shift, bits));
    }
    let met = scratch.take::<u32>(faces.len())?;
    let found = overlaps(met, triangles, scratch, workers)?;
    for (f, met) in faces.iter().zip(met.iter()).filter(|(_, met)| **met != NONE) {
        partner[*f as usize] = faces[*met as usize];
    }
    Ok(found)
}

/// One overlapping pair of regions of a chart, with the area that overlaps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Clash {
    chart: u32,
    x: u32, // region of the lower number
    y: u32,
    face: u32,
    area: f64,
}

/// How an overlapping chart is parted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Along the cheapest path between what overlaps; where there is none, in halves.
    Cheapest,
    /// The smaller of two regions that lie on each other becomes a chart of its own: whatever it costs, all regions of a chart at once.
    Islands,
    /// In halves of about equal numbers of faces: ends after few rounds, whatever lies on what.
    Halves,
}

/// Splits each chart that overlaps itself once, of those with a face marked in `changed`, and marks faces of its parts there instead;
/// returns how many faces overlapped before.
/// A chart of one polygon stays as it is.
pub fn split_overlaps(
    cut: &mut [u8],
    changed: &mut [u8],
    uv: &[DVec2],
    surface: &Surface,
    how: Split,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<usize, ScratchTooSmall> {
    let faces = surface.mesh.faces.len();
    let charts = ChartList::new(surface, cut, &mut scratch)?;
    let queue = scratch.take::<u32>(faces)?;
    let partner = scratch.take::<u32>(faces)?;
    let wanted = scratch.take::<u8>(charts.count())?;
    for f in (0..faces).filter(|f| changed[*f] != 0) {
        wanted[charts.of_face[f] as usize] = 1;
    }
    changed.fill(0);
    let is_wanted = |k: u32| wanted[k as usize] != 0;
    let found = self_overlaps(partner, uv, charts.of_face, charts.count(), is_wanted, scratch.frame(), workers)?;
    if found == 0 {
        return Ok(0);
    }
    // Paths part disks.
    slit_holes(cut, surface, scratch.frame())?;
    if how == Split::Halves {
        halve(cut, changed, surface, |f| partner[f] != NONE, scratch.frame())?;
        disks_again(cut, surface, scratch)?;
        return Ok(found);
    }
    let region = scratch.take::<u32>(faces)?;
    regions(region, partner, cut, surface);
    if how == Split::Islands {
        cut_out(cut, changed, region, partner, &charts, surface, scratch.frame())?;
        disks_again(cut, surface, scratch)?;
        return Ok(found);
    }
    let stuck = scratch.take::<u8>(faces)?;
    let node = scratch.take::<u32>(3 * faces)?;
    let node_count = surface.wedges(cut, node);
    let side = scratch.take::<u8>(faces)?;
    let mut search = Splitting::new(node, node_count, faces, &mut scratch)?;
    for clash in clashes(region, partner, charts.of_face, surface, &mut scratch)? {
        let members = charts.faces_of(clash.chart as usize);
        if clash.x == clash.y {
            side[clash.face as usize] = X;
            side[partner[clash.face as usize] as usize] = Y;
        } else {
            for f in members {
                side[*f as usize] = match region[*f as usize] {
                    r if r == clash.x => X,
                    r if r == clash.y => Y,
                    _ => FREE,
                };
            }
        }
        if !search.split(cut, changed, side, members, node, queue, surface) {
            stuck[clash.face as usize] = 1;
        }
        members.iter().for_each(|f| side[*f as usize] = FREE);
    }
    if stuck.contains(&1) {
        halve(cut, changed, surface, |f| stuck[f] != 0, scratch.frame())?;
        disks_again(cut, surface, scratch)?;
    }
    Ok(found)
}

/// Numbers the connected regions of overlapping faces.
fn regions(region: &mut [u32], partner: &[u32], cut: &[u8], surface: &Surface) {
    let mut sets = UnionFind::new(region);
    for c in 0..surface.mesh.corner_count() as u32 {
        if let Some(t) = surface.across(cut, c)
            && partner[(c / 3) as usize] != NONE
            && partner[(t / 3) as usize] != NONE
        {
            sets.union(c / 3, t / 3);
        }
    }
    sets.number();
}

/// Cuts the smaller of each two regions that overlap out of its chart, and one that overlaps itself.
fn cut_out(
    cut: &mut [u8],
    changed: &mut [u8],
    region: &[u32],
    partner: &[u32],
    charts: &ChartList,
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let area = scratch.take::<f64>(region.len())?;
    let is_out = scratch.take::<u8>(region.len())?;
    let is_met = |f: usize| partner[f] != NONE;
    for f in (0..region.len()).filter(|f| is_met(*f)) {
        area[region[f] as usize] += surface.rest[f].area;
    }
    for f in (0..region.len()).filter(|f| is_met(*f)) {
        let (own, other) = (region[f], region[partner[f] as usize]);
        let size = |r: u32| (for_decision(area[r as usize]), r);
        is_out[if size(own) <= size(other) { own } else { other } as usize] = 1;
    }
    let island = |f: usize| if is_met(f) && is_out[region[f] as usize] != 0 { region[f] } else { NONE };
    for c in 0..cut.len() as u32 {
        if let Some(t) = surface.across(cut, c)
            && island((c / 3) as usize) != island((t / 3) as usize)
            && surface.cost[c as usize].is_finite()
        {
            surface.set_cut(cut, c, true);
        }
    }
    let touched = scratch.take::<u8>(charts.count())?;
    for f in (0..region.len()).filter(|f| is_met(*f)) {
        touched[charts.of_face[f] as usize] = 1;
    }
    changed.iter_mut().zip(charts.of_face).for_each(|(c, k)| *c = touched[*k as usize]);
    Ok(())
}

/// The largest clash of each chart.
fn clashes<'a>(
    region: &[u32],
    partner: &[u32],
    chart: &[u32],
    surface: &Surface,
    scratch: &mut Scratch<'a>,
) -> Result<&'a [Clash], ScratchTooSmall> {
    let count = partner.iter().filter(|p| **p != NONE).count();
    let list = scratch.take::<Clash>(count)?;
    let marked = (0..partner.len()).filter(|f| partner[*f] != NONE);
    for (clash, f) in list.iter_mut().zip(marked) {
        let (a, b) = (region[f], region[partner[f] as usize]);
        let area = surface.rest[f].area;
        *clash = Clash { chart: chart[f], x: a.min(b), y: a.max(b), face: f as u32, area };
    }
    sort::by_key(list, |c| (c.chart, c.x, c.y, c.face));
    let mut best = 0; // list[..best]: the largest of each chart so far
    let mut at = 0;
    while at < count {
        let first = list[at];
        let mut sum = first;
        sum.area = 0.0;
        while at < count && (list[at].chart, list[at].x, list[at].y) == (first.chart, first.x, first.y) {
            sum.area += list[at].area;
            at += 1;
        }
        if best > 0 && list[best - 1].chart == sum.chart {
            if for_decision(sum.area) > for_decision(list[best - 1].area) {
                list[best - 1] = sum;
            }
        } else {
            list[best] = sum;
            best += 1;
        }
    }
    Ok(&list[..best])
}

/// Memory of one split, reused.
struct Splitting<'a> {
    position: &'a mut [u32], // (nodes) place along the border; `NONE` between two splits
    paths: WedgePaths<'a>,
    border: &'a mut [u32], // half-edges of the chart's border in order
    parent: &'a mut [u32], // (faces) of a corridor search; `NONE` between two
}

impl<'a> Splitting<'a> {
    fn new(node: &[u32], nodes: usize, faces: usize, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self {
            position: keep.take_filled(nodes, NONE)?,
            paths: WedgePaths::new(node, nodes, keep)?,
            border: keep.take(nodes)?,
            parent: keep.take_filled(faces, NONE)?,
        })
    }

    /// Splits the chart of the faces `members`, of which `side` names X and Y; false where no path does.
    #[allow(clippy::too_many_arguments)]
    fn split(
        &mut self,
        cut: &mut [u8],
        changed: &mut [u8],
        side: &mut [u8],
        members: &[u32],
        node: &[u32],
        queue: &mut [u32],
        surface: &Surface,
    ) -> bool {
        for wanted in [X, Y] {
            self.corridor(side, wanted, members, cut, queue, surface);
        }
        let starts = |c: &u32| side[(c / 3) as usize] == X && surface.is_open(cut, *c);
        let Some(first) = members.iter().flat_map(|f| 3 * f..3 * f + 3).find(starts) else { return false };
        let mut len = 0;
        for c in surface.border(cut, first) {
            self.border[len] = c;
            self.position[node[c as usize] as usize] = len as u32;
            len += 1;
        }
        let parted = NonZero::new(len).is_some_and(|len| self.part(cut, changed, side, len, node, surface));
        for c in &self.border[..len] {
            self.position[node[*c as usize] as usize] = NONE;
        }
        parted
    }

    /// Cuts the cheapest path between the two arcs of the border (of `around` half-edges) that lie between X and Y, if there
    /// is one.
    fn part(
        &mut self,
        cut: &mut [u8],
        changed: &mut [u8],
        side: &[u8],
        around: NonZero<usize>,
        node: &[u32],
        surface: &Surface,
    ) -> bool {
        let len = around.get();
        let label = |i: usize| side[(self.border[i % around] / 3) as usize];
        let Some((x0, x1)) = longest_run(len, 0, len, label, X) else { return false };
        let Some((y0, y1)) = longest_run(len, x1 + 1, len - (x1 + 1 - x0), label, Y) else { return false };
        // Arc A: after X up to Y; arc B: after Y up to X (positions count on past the end of the list).
        let (a, b) = ((x1 + 1, y0), (y1 + 1, x0 + len));
        let (position, border) = (&*self.position, &*self.border);
        let target = |position: u32| (b.0..=b.1).any(|i| i % around == position as usize);
        let mut end = NONE;
        self.paths.grow(
            surface,
            cut,
            node,
            (a.0..=a.1).map(|i| node[border[i % around] as usize]),
            |edge, across| {
                let (s, o) = (side[(edge / 3) as usize], side[(across / 3) as usize]);
                surface.cost[edge as usize] * if s != FREE && s == o { THROUGH } else { 1.0 }
            },
            |n, at| match position[n as usize] {
                p if at == 0.0 || p == NONE => Go::On,
                p if target(p) => {
                    end = n;
                    Go::Home
                }
                _ => Go::Around,
            },
        );
        if end == NONE || self.paths.cost[end as usize] == f64::INFINITY {
            return false;
        }
        self.paths.cut_back(end, cut, changed, node, surface);
        true
    }

    /// Joins the faces of `wanted` to the chart's border through the fewest faces, where none is on it yet.
    fn corridor(
        &mut self,
        side: &mut [u8],
        wanted: u8,
        members: &[u32],
        cut: &[u8],
        queue: &mut [u32],
        surface: &Surface,
    ) {
        let mut tail = 0;
        for f in members.iter().filter(|f| side[**f as usize] == wanted) {
            self.parent[*f as usize] = *f;
            queue[tail] = *f;
            tail += 1;
        }
        let (mut head, mut reached) = (0, NONE);
        while head < tail && reached == NONE {
            let f = queue[head];
            head += 1;
            for c in 3 * f..3 * f + 3 {
                let Some(t) = surface.across(cut, c) else {
                    reached = f;
                    break;
                };
                let g = (t / 3) as usize;
                if self.parent[g] == NONE && side[g] == FREE {
                    self.parent[g] = f;
                    queue[tail] = g as u32;
                    tail += 1;
                }
            }
        }
        while reached != NONE {
            side[reached as usize] = wanted;
            let from = self.parent[reached as usize];
            reached = if from == reached { NONE } else { from };
        }
        queue[..tail].iter().for_each(|f| self.parent[*f as usize] = NONE);
    }
}

/// First and last place of the longest stretch of the cyclic list of `len` labels that starts and ends with `wanted` and
/// holds no other label than that and `FREE`, among the `count` places from `from` on. Places count past `len`.
fn longest_run(
    len: usize,
    from: usize,
    count: usize,
    label: impl Fn(usize) -> u8,
    wanted: u8,
) -> Option<(usize, usize)> {
    // Start behind a foreign label, so that no stretch is broken by the beginning of a full turn.
    let begin = if count == len {
        (from..from + len).find(|i| ![FREE, wanted].contains(&label(*i))).unwrap_or(from)
    } else {
        from
    };
    let mut best: Option<(usize, usize)> = None;
    let mut run: Option<(usize, usize)> = None;
    for i in begin..begin + count {
        match label(i) {
            l if l == wanted => {
                let start = run.map_or(i, |r| r.0);
                run = Some((start, i));
                if best.is_none_or(|b| i - start > b.1 - b.0) {
                    best = run;
                }
            }
            FREE => {}
            _ => run = None,
        }
    }
    best
}
