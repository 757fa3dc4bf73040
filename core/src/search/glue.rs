//! Gluing charts: a small chart is joined to a neighbour along a seam that they share, if it fits there.
//!
//! Splits against overlap leave small charts behind, and what did not fit on one side of an old cut often fits on the
//! other. The small chart is laid beside its neighbour by the best rigid motion of the shared seam, takes the neighbour's
//! points there, and is relaxed with those held; the neighbour does not move. It stays where no face overlaps and its own
//! distortion is within bounds.
//! Guarantee: two disks glued along one run of edges are one disk; no flip, no overlap. Cost: a pass over the neighbour's
//! faces a trial; trials are bounded.

use crate::base::real::for_decision;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::workers::Serial;
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};
use crate::plane::grid::{GridPoint, grid_bits, interiors_meet};
use crate::plane::motion::Motion;
use crate::solve::piece::{Piece, Stop};
use crate::solve::relax::{relax, relax_need};
use bytemuck::{Pod, Zeroable};
use core::num::NonZero;
use glam::{DVec2, DVec3};

/// Charts above this share of all area are not moved.
const LARGEST: f64 = 0.02;
/// Faces of a chart that is moved, at the most: bounds the cost of a trial.
const MOST_FACES: usize = 2000;
/// Seams that are tried a chart, dearest first.
const TRIES: usize = 4;
/// Faces of a chart that is moved at the most, and seams that are tried, where a piece should be one chart.
const MOST_FACES_FOR_ONE: usize = 20_000;
/// See [`MOST_FACES_FOR_ONE`].
const TRIES_FOR_ONE: usize = 16;
/// Newton steps of a trial.
const STOP: Stop = Stop { steps: 12, tolerance: 1e-4 };

/// A run of border half-edges of a chart with one neighbour across it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct SeamRun {
    first: u32, // place in the border
    count: u32,
    saved: f64, // cost of the seam
}

/// What gluing may cost.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Energy (over area) that may be added in all.
    pub spare: f64,
    /// Most mean energy of a glued chart: 4 is an isometry.
    pub own: f64,
    /// Most energy of a face of a glued chart.
    pub worst: f64,
    /// Whether charts of any size are glued: a piece should be one chart.
    pub one: bool,
}

/// Scratch bytes for [`glue_small`].
pub fn glue_need(faces: usize) -> usize {
    let small = faces.min(MOST_FACES_FOR_ONE);
    8 * bytes_for::<u32>(faces + 2) + 2 * bytes_for::<u32>(3 * faces) + small * 400 + relax_need(small + 2, small, 0)
}

/// Glues small charts to neighbours, the smallest first, within `limits`; returns how many. `changed` marks the faces of
/// charts that took one.
pub fn glue_small(
    uv: &mut [DVec2],
    cut: &mut [u8],
    changed: &mut [u8],
    surface: &Surface,
    limits: Limits,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let (largest, most_faces) = if limits.one { (1.0, MOST_FACES_FOR_ONE) } else { (LARGEST, MOST_FACES) };
    let faces = surface.mesh.faces.len();
    let mut limits = limits;
    let charts = ChartList::new(surface, cut, &mut scratch)?;
    let total: f64 = surface.rest.iter().map(|r| r.area).sum();
    let area = |k: usize| charts.faces_of(k).iter().map(|f| surface.rest[*f as usize].area).sum::<f64>();
    let order = scratch.take::<[u64; 2]>(charts.count())?;
    let mut len = 0;
    for k in 0..charts.count() {
        let a = for_decision(area(k));
        if a <= largest * total && charts.faces_of(k).len() <= most_faces {
            order[len] = [a.to_bits(), k as u64];
            len += 1;
        }
    }
    let order = &mut order[..len];
    sort::ascending(order);
    let mut homes = Homes::new(charts, &mut scratch)?;
    let local = scratch.take_filled::<u32>(3 * faces, NONE)?;
    let mut glued = 0;
    for [_, k] in order.iter() {
        let k = *k as usize;
        // A chart that has taken another is not small any more: it stays.
        if homes.first[k] != NONE {
            continue;
        }
        let into = try_chart(uv, cut, k, &homes, local, surface, limits, scratch.frame())?;
        if let Some((into, spent)) = into {
            homes.join(k, into);
            limits.spare -= spent;
            glued += 1;
            homes.charts.faces_of(k).iter().for_each(|f| changed[*f as usize] = 1);
        }
    }
    Ok(glued)
}

/// Charts that grow as others are glued to them. One that has taken others is not glued itself.
struct Homes<'h> {
    charts: ChartList<'h>,
    now: &'h mut [u32],   // (charts) the chart that each is part of: itself, or one that took it
    first: &'h mut [u32], // (charts) the last chart that each has taken, or `NONE`
    next: &'h mut [u32],  // (charts) the one that was taken before it by the same chart, or `NONE`
}

impl<'h> Homes<'h> {
    fn new(charts: ChartList<'h>, keep: &mut Scratch<'h>) -> Result<Self, ScratchTooSmall> {
        let now = keep.take::<u32>(charts.count())?;
        now.iter_mut().enumerate().for_each(|(k, n)| *n = k as u32);
        let (first, next) = (keep.take_filled(charts.count(), NONE)?, keep.take_filled(charts.count(), NONE)?);
        Ok(Self { charts, now, first, next })
    }

    /// The chart of a face.
    fn of_face(&self, face: u32) -> u32 {
        self.now[self.charts.of_face[face as usize] as usize]
    }

    /// Notes that chart `k` is part of chart `into`.
    fn join(&mut self, k: usize, into: u32) {
        self.now[k] = into;
        self.next[k] = self.first[into as usize];
        self.first[into as usize] = k as u32;
    }

    /// Faces of chart `k` and of those that it took.
    fn faces(&self, k: u32) -> impl Iterator<Item = u32> + '_ {
        let step = |k: u32| Some(k).filter(|k| *k != NONE);
        let taken = core::iter::successors(step(self.first[k as usize]), move |k| step(self.next[*k as usize]));
        core::iter::once(k).chain(taken).flat_map(|k| self.charts.faces_of(k as usize).iter().copied())
    }
}

/// Tries the seams of chart `k`; answers the chart that it became part of and the energy that was added.
#[allow(clippy::too_many_arguments)]
fn try_chart(
    uv: &mut [DVec2],
    cut: &mut [u8],
    k: usize,
    homes: &Homes,
    local: &mut [u32],
    surface: &Surface,
    limits: Limits,
    mut scratch: Scratch,
) -> Result<Option<(u32, f64)>, ScratchTooSmall> {
    let faces = homes.charts.faces_of(k);
    let Some(start) = surface.first_open(cut, faces) else {
        return Ok(None);
    };
    let border = scratch.fill::<u32>(|out| {
        let mut len = 0;
        for c in surface.border(cut, start) {
            *out.get_mut(len)? = c;
            len += 1;
        }
        Some(len)
    })?;
    let Some(around) = NonZero::new(border.len()) else { return Ok(None) };
    let runs = scratch.take::<SeamRun>(border.len())?;
    let count = find_runs(runs, border, around, cut, k as u32, homes, surface);
    let runs = &mut runs[..count];
    sort::by(runs, |a, b| b.saved.total_cmp(&a.saved).then(a.first.cmp(&b.first)));
    for run in runs.iter().take(if limits.one { TRIES_FOR_ONE } else { TRIES }) {
        let run: SeamRun = *run;
        let edge = |i: u32| border[(run.first + i) as usize % around];
        let into = homes.of_face(surface.twin[edge(0) as usize] / 3);
        let mut frame = scratch.frame();
        let mut trial = Trial::new(uv, cut, faces, local, surface, &mut frame)?;
        let before = trial.energy();
        trial.fit(uv, run.count, &edge, surface, frame.frame())?;
        let (after, area) = (trial.energy(), trial.rest.iter().map(|r| r.area).sum::<f64>());
        let cheap = after <= limits.own * area && after - before <= limits.spare && trial.worst() <= limits.worst;
        let fits = cheap && !trial.overlaps(uv, homes.faces(into));
        if fits {
            trial.write(uv);
            (0..run.count).for_each(|i| surface.set_cut(cut, edge(i), false));
        }
        faces.iter().flat_map(|f| 3 * f..3 * f + 3).for_each(|c| local[c as usize] = NONE);
        if fits {
            return Ok(Some((into, after - before)));
        }
    }
    Ok(None)
}

/// Longest stretches of the border with one neighbour across, whose border runs along without a branch.
fn find_runs(
    runs: &mut [SeamRun],
    border: &[u32],
    around: NonZero<usize>,
    cut: &[u8],
    own: u32,
    homes: &Homes,
    surface: &Surface,
) -> usize {
    let n = around.get();
    let at = |i: usize| border[i % around] as usize;
    let neighbour = |i: usize| {
        let t = surface.twin[at(i)];
        (t != NONE && surface.cost[at(i)].is_finite()).then(|| homes.of_face(t / 3)).filter(|h| *h != own)
    };
    let joined = |i: usize| {
        neighbour(i).is_some()
            && neighbour(i) == neighbour(i + 1)
            && surface.following(cut, surface.twin[at(i + 1)]) == surface.twin[at(i)]
    };
    let mut count = 0;
    let begin = (0..n).find(|i| !joined(*i)).map_or(0, |i| i + 1);
    let mut i = begin;
    while i < begin + n {
        let mut end = i;
        while end + 1 < begin + n && joined(end) {
            end += 1;
        }
        if neighbour(i).is_some() {
            // A run around the whole border would leave no border: it stops one edge short.
            let len = (end - i + 1).min(n - 1);
            let saved = (i..i + len).map(|j| surface.cost[at(j)]).sum();
            if len > 0 {
                runs[count] = SeamRun { first: (i % around) as u32, count: len as u32, saved };
                count += 1;
            }
        }
        i = end + 1;
    }
    count
}

/// A chart on its way to a neighbour.
struct Trial<'t> {
    faces: &'t [u32],
    triangles: &'t mut [[u32; 3]],
    rest: &'t mut [crate::solve::energy::Rest],
    x: &'t mut [DVec2],
    held: &'t mut [u8],
}

impl<'t> Trial<'t> {
    fn new<'s: 't>(
        uv: &[DVec2],
        cut: &[u8],
        faces: &'t [u32],
        local: &mut [u32],
        surface: &Surface,
        scratch: &mut Scratch<'s>,
    ) -> Result<Self, ScratchTooSmall> {
        let triangles = scratch.take::<[u32; 3]>(faces.len())?;
        let rest = scratch.take::<crate::solve::energy::Rest>(faces.len())?;
        let x = scratch.take::<DVec2>(3 * faces.len())?;
        let mut count = 0;
        for (k, f) in faces.iter().enumerate() {
            rest[k] = surface.rest[*f as usize];
            for i in 0..3 {
                let c = 3 * f + i;
                let start = surface.wedge_start(cut, c) as usize;
                if local[start] == NONE {
                    local[start] = count;
                    x[count as usize] = uv[c as usize];
                    count += 1;
                }
                triangles[k][i as usize] = local[start];
            }
        }
        let held = scratch.take::<u8>(count as usize)?;
        Ok(Self { faces, triangles, rest, x: &mut x[..count as usize], held })
    }

    /// Area and energy of each face.
    fn energies(&self) -> impl Iterator<Item = (f64, f64)> {
        let faces = self.triangles.iter().zip(self.rest.iter());
        faces.map(|(t, r)| (r.area, r.energy(t.map(|i| self.x[i as usize]))))
    }

    /// Energy of the chart, infinite where a face is flipped.
    fn energy(&self) -> f64 {
        self.energies().map(|(area, energy)| area * energy).sum()
    }

    /// Most energy of a face.
    fn worst(&self) -> f64 {
        self.energies().map(|(_, energy)| energy).fold(0.0, f64::max)
    }

    /// Lays the chart beside its neighbour and relaxes it there.
    fn fit(
        &mut self,
        uv: &[DVec2],
        count: u32,
        edge: &impl Fn(u32) -> u32,
        surface: &Surface,
        mut scratch: Scratch,
    ) -> Result<(), ScratchTooSmall> {
        // Nodes of the seam and where the neighbour has them.
        let seam = scratch.take::<u32>(count as usize + 1)?;
        let target = scratch.take::<DVec2>(count as usize + 1)?;
        for i in 0..count {
            let (c, t) = (edge(i), surface.twin[edge(i) as usize]);
            seam[i as usize] = self.node(c);
            target[i as usize] = uv[next(t) as usize];
            seam[i as usize + 1] = self.node(next(c));
            target[i as usize + 1] = uv[t as usize];
        }
        let motion = Motion::fit(|| seam.iter().zip(target.iter()).map(|(s, t)| (self.x[*s as usize], *t, 1.0)));
        self.x.iter_mut().for_each(|x| *x = motion.apply(*x));
        self.held.fill(0);
        for (s, t) in seam.iter().zip(target.iter()) {
            self.x[*s as usize] = *t;
            self.held[*s as usize] = 1;
        }
        // Free nodes first.
        let place = scratch.take::<u32>(self.x.len())?;
        let (mut free, mut last) = (0, self.held.iter().filter(|h| **h == 0).count() as u32);
        for (p, h) in place.iter_mut().zip(self.held.iter()) {
            let slot = if *h == 0 { &mut free } else { &mut last };
            *p = *slot;
            *slot += 1;
        }
        let y = scratch.take::<DVec2>(self.x.len())?;
        for (x, p) in self.x.iter().zip(place.iter()) {
            y[*p as usize] = *x;
        }
        let triangles = scratch.take::<[u32; 3]>(self.triangles.len())?;
        for (t, from) in triangles.iter_mut().zip(self.triangles.iter()) {
            *t = from.map(|i| place[i as usize]);
        }
        let at: &[DVec3] = &[];
        let piece = Piece { triangles, rest: self.rest, free: free as usize, at, springs: &[], walls: &[] };
        relax(y, &piece, STOP, scratch, &Serial)?;
        for (x, p) in self.x.iter_mut().zip(place.iter()) {
            *x = y[*p as usize];
        }
        Ok(())
    }

    /// Local node of a corner of the chart.
    fn node(&self, c: u32) -> u32 {
        let f = self.faces.partition_point(|f| *f < c / 3);
        self.triangles[f][(c % 3) as usize]
    }

    /// Whether a face of the chart lies on one of `others`, or on another of its own.
    fn overlaps(&self, uv: &[DVec2], others: impl Iterator<Item = u32>) -> bool {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for x in self.x.iter() {
            low = low.min(*x);
            high = high.max(*x);
        }
        let bits = grid_bits((high - low).max_element().max(1e-300) * 4.0);
        let snap = |t: [DVec2; 3]| t.map(|p| GridPoint::snap(p - low, bits));
        let own = |k: usize| snap(self.triangles[k].map(|i| self.x[i as usize]));
        let apart = |a: [DVec2; 3], b: [DVec2; 3]| {
            let (al, ah) = (a[0].min(a[1]).min(a[2]), a[0].max(a[1]).max(a[2]));
            let (bl, bh) = (b[0].min(b[1]).min(b[2]), b[0].max(b[1]).max(b[2]));
            al.cmpge(bh).any() || bl.cmpge(ah).any()
        };
        for f in others {
            let f = f as usize;
            let t = [uv[3 * f], uv[3 * f + 1], uv[3 * f + 2]];
            if apart(t, [low, high, high]) {
                continue;
            }
            let hit = (0..self.faces.len()).any(|k| {
                let s = self.triangles[k].map(|i| self.x[i as usize]);
                !apart(s, t) && interiors_meet(&own(k), &snap(t))
            });
            if hit {
                return true;
            }
        }
        (0..self.faces.len()).any(|j| {
            (0..j).any(|k| {
                let (s, t) = (self.triangles[j], self.triangles[k]);
                let (s, t) = (s.map(|i| self.x[i as usize]), t.map(|i| self.x[i as usize]));
                !apart(s, t) && interiors_meet(&own(j), &own(k))
            })
        })
    }

    /// Writes the chart's new UVs.
    fn write(&self, uv: &mut [DVec2]) {
        for (f, t) in self.faces.iter().zip(self.triangles.iter()) {
            for i in 0..3 {
                uv[3 * *f as usize + i] = self.x[t[i] as usize];
            }
        }
    }
}
