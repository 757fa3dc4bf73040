//! Cuts that let charts pack, chosen by packing.
//!
//! With given charts the best packer leaves what the charts leave: two horseshoes fill .6 of a square whoever places them, and one
//! cut at the right place fills a tenth more. Cheapest paths between places on the borders of the largest charts are ranked by
//! what a formula expects of them (`crowding`); the best few are tried by packing with little effort, and the best of those stays
//! where what it fills outweighs what it costs. A chart without distortion is a face of the object, flat or unrolled, and one whose
//! border runs mostly along sharp edges is a part that people know: both stay whole, unless they are so long that the square is empty beside them: then one
//! cut is made that would hardly be noticed.
//! What is made of one piece is made of all that are alike.
//! Guarantee: a chart cut in two has no more distortion than before, so maps are not touched. Cost: [`TRIED`] packings a cut,
//! [`CUTS`] cuts.

use super::place::{Placing, pack_now};
use crate::base::real::sqrt;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::slices::{Slices, take_first};
use crate::base::sort;
use crate::base::workers::{Workers, for_each_chunk};
use crate::charts::list::ChartList;
use crate::charts::pieces::Pieces;
use crate::charts::surface::Surface;
use crate::charts::wedge_paths::{WedgePaths, wedge_paths_need};
use crate::mesh::view::{NONE, next};
use crate::pack::layout::pack_need;
use crate::plane::crowding::{Crowd, Outline, PLACES};
use crate::price::cost::{FILL_WORTH, FORBIDDEN};
use crate::price::turn::angle;
use crate::solve::bound::lie_flat;
use bytemuck::{Pod, Zeroable};
use core::num::NonZero;
use glam::DVec2;

/// Charts that are looked at: the largest, as long as they hold this share of the area.
const LARGEST: usize = 5;
/// See [`LARGEST`].
const LEAST: f64 = 0.05;
/// Cuts of one chart that are kept for trials.
const EACH: usize = 3;
/// Cuts that are tried by packing before each that is made.
const TRIED: usize = 4;
/// Square of the side that a chart needs, over the area of all, from which it may be cut once whatever it is, where that is hardly noticed:
/// the square is empty beside it.
const LONG: f64 = 1.6;
/// Cost of a unit of length that is hardly noticed: eight tenths of what an open seam in a smooth place costs.
const EASY: f64 = 2.2;
/// More pieces than so many that are alike pack well among one another as they are, and cuts would be made in all: eight cows fill .680
/// with cuts and .683 without, four crates and four tyres .710 and .745, eight rabbits .752 and .740.
const MOST_ALIKE: u32 = 3;
/// Turn, in degrees, from which an edge is sharp.
const SHARP: f64 = 40.0;
/// Cuts at the most.
const CUTS: usize = 3;
/// More charts than so many pack well as they are, and each trial would take long.
const MOST_CHARTS: f64 = 32.0;
/// Packing effort of a trial over that of the atlas.
const EFFORT: f64 = 0.03;
/// Bytes that trials side by side may take: more of them end sooner where there are threads for them.
const BESIDE: usize = 1 << 26;
/// Places from which paths are grown at the same time at the most.
const BESIDE_PLACES: usize = 4;
/// Bytes a corner that a trial takes beside packing, about.
const TRIAL: usize = 32;

/// A cut that may be made: the cheapest path between two places on the border of a chart.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct PackingCut {
    gain: f64, // expected, less what it costs
    cost: f64,
    piece: u64,
    ends: [u32; 2], // open half-edges at whose starts it begins and ends
}

/// Cuts charts where that fills the square; returns how many cuts it made.
pub fn cut_to_pack(
    uv: &[DVec2],
    cut: &mut [u8],
    placing: &Placing,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<usize, ScratchTooSmall> {
    let mut fill = None;
    for made in 0..CUTS {
        let mut candidates = heapless::Vec::<PackingCut, { LARGEST * EACH }>::new();
        find_cuts(&mut candidates, uv, cut, placing, made == 0, scratch.frame(), workers)?;
        if candidates.is_empty() {
            return Ok(made);
        }
        let mut trials = PackingTrials::new();
        if fill.is_none() {
            trials.put((None, 0.0));
        }
        candidates.iter().take(TRIED).for_each(|c| trials.put((Some(*c), 0.0)));
        try_all(&mut trials, uv, cut, placing, scratch.frame(), workers)?;
        let now = fill.unwrap_or(trials[0].1);
        let mut best: Option<(f64, PackingCut, f64)> = None;
        for (c, filled) in trials.into_iter().filter_map(|(c, filled)| Some((c?, filled))) {
            let value = FILL_WORTH * (filled - now) - c.cost;
            if value > best.map_or(0.0, |b| b.0) {
                best = Some((value, c, filled));
            }
        }
        let Some((_, c, filled)) = best else { return Ok(made) };
        make(cut, &c, placing, scratch.frame())?;
        fill = Some(filled);
    }
    Ok(CUTS)
}

/// Cuts to be tried, or none for the charts as they are, and what is filled with each.
type PackingTrials = heapless::Vec<(Option<PackingCut>, f64), { TRIED + 1 }>;

/// A trial that runs beside others.
struct PackingJob<'j> {
    trial: &'j mut (Option<PackingCut>, f64),
    scratch: Option<Scratch<'j>>,
    done: Result<(), ScratchTooSmall>,
}

/// Packs with each of the cuts, side by side where the memory allows that.
fn try_all(
    trials: &mut PackingTrials,
    uv: &[DVec2],
    cut: &[u8],
    placing: &Placing,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let need = pack_need(cut.len() / 3, MOST_CHARTS as usize, &placing.packing) + TRIAL * cut.len();
    let mut beside = (BESIDE.min(scratch.remaining()) / need.max(1)).min(trials.len());
    loop {
        match try_beside(trials, beside, uv, cut, placing, scratch.frame(), workers) {
            // What was foreseen was not enough: one by one it may be.
            Err(e) if beside > 1 && !e.is_alarm() => beside = 1,
            done => return done,
        }
    }
}

/// So many trials side by side, then as many of the others.
fn try_beside(
    trials: &mut PackingTrials,
    beside: usize,
    uv: &[DVec2],
    cut: &[u8],
    placing: &Placing,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    for trials in trials.chunks_mut(beside.max(1)) {
        let mut frame = scratch.frame();
        let share = frame.remaining() / trials.len().max(1);
        let mut jobs = heapless::Vec::<PackingJob, { TRIED + 1 }>::new();
        for trial in trials {
            jobs.put(PackingJob { trial, scratch: Some(frame.split(share)?), done: Ok(()) });
        }
        for_each_chunk(workers, &mut jobs, 1, &|_, jobs| {
            for PackingJob { trial: (c, filled), scratch, done } in jobs {
                *done = scratch
                    .take()
                    .map_or(Ok(0.0), |s| fill_with(c.as_ref(), uv, cut, placing, s, workers))
                    .map(|f| *filled = f);
            }
        });
        jobs.into_iter().try_for_each(|job| job.done)?;
    }
    Ok(())
}

/// Share of the square that is filled with one more cut, or as it is.
fn fill_with(
    c: Option<&PackingCut>,
    uv: &[DVec2],
    cut: &[u8],
    placing: &Placing,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<f64, ScratchTooSmall> {
    let Some(c) = c else { return pack_now(uv, cut, placing, EFFORT, scratch, workers) };
    let trial = scratch.take::<u8>(cut.len())?;
    trial.copy_from(cut);
    make(trial, c, placing, scratch.frame())?;
    pack_now(uv, trial, placing, EFFORT, scratch, workers)
}

/// Makes a cut, on all pieces that are alike.
fn make(cut: &mut [u8], c: &PackingCut, placing: &Placing, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let Placing { pieces, copies, .. } = placing;
    let mut frame = scratch.frame();
    let (surface, corners) = (pieces.surface(c.piece as usize, &mut frame)?, pieces.corners(c.piece as usize));
    let own = &mut cut[corners];
    let changed = frame.take::<u8>(own.len() / 3)?;
    let mut inside = Inside::new(own, &surface, c.ends[0], &mut frame)?;
    let end = inside.node[c.ends[1] as usize];
    let begin = inside.node[c.ends[0] as usize];
    inside.paths.grow_inside(&surface, own, inside.node, begin, inside.on_border, |n, _| n == end);
    inside.paths.cut_back(end, own, changed, inside.node, &surface);
    copies.spread_cuts(cut, pieces);
    Ok(())
}

/// Cheapest paths through the inside of one chart.
struct Inside<'a> {
    node: &'a [u32],         // (3 f) of the piece
    on_border: &'a mut [u8], // (nodes)
    paths: WedgePaths<'a>,
}

impl<'a> Inside<'a> {
    /// Of the chart whose border holds the open half-edge `start`.
    fn new(cut: &[u8], surface: &Surface, start: u32, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let node = keep.take::<u32>(cut.len())?;
        let nodes = surface.wedges(cut, node);
        let on_border = keep.take::<u8>(nodes)?;
        surface.border(cut, start).for_each(|c| on_border[node[c as usize] as usize] = 1);
        let paths = WedgePaths::new(node, nodes, keep)?;
        Ok(Self { node, on_border, paths })
    }
}

/// Costs of the cheapest paths through a chart between the places on its border: the first index is the lesser.
type Costs = [[f64; PLACES]; PLACES];

/// Some places, from which paths are grown beside others.
struct PlacesLane<'l> {
    first: usize,
    costs: &'l mut [[f64; PLACES]],
    rank: &'l [u8], // (nodes)
    paths: WedgePaths<'l>,
}

/// Writes the costs of paths between each two of `places` that have another between them; what costs more than `most` may be infinite, as
/// where there is no path.
#[allow(clippy::too_many_arguments)]
fn path_costs(
    costs: &mut Costs,
    places: &[u32],
    most: f64,
    inside: Inside,
    cut: &[u8],
    surface: &Surface,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    *costs = [[f64::INFINITY; PLACES]; PLACES];
    let Inside { node, on_border, paths } = inside;
    // The place of each node: the last where there are several.
    let rank = scratch.take::<u8>(on_border.len())?;
    for (node, at) in places.iter().zip(1..) {
        rank[*node as usize] = at;
    }
    let beside = scratch.remaining().checked_div(wedge_paths_need(on_border.len())).unwrap_or(0);
    let mut jobs = heapless::Vec::<PlacesLane, BESIDE_PLACES>::new();
    let mut rest = costs.get_mut(..places.len()).unwrap_or_default();
    let share = places.len().div_ceil(1 + beside.min(BESIDE_PLACES - 1));
    let mut kept = Some(paths);
    while !rest.is_empty() {
        let first = places.len() - rest.len();
        let own = take_first(&mut rest, share.min(places.len() - first));
        let paths = match kept.take() {
            Some(paths) => paths,
            None => WedgePaths::new(node, on_border.len(), &mut scratch)?,
        };
        jobs.put(PlacesLane { first, costs: own, rank, paths });
    }
    for_each_chunk(workers, &mut jobs, 1, &|_, jobs| {
        for PlacesLane { first, costs, rank, paths } in jobs {
            for (i, row) in (*first..).zip(costs.iter_mut()) {
                let from = places[i];
                let mut left = places.iter().zip(1..).skip(i + 2).filter(|(n, at)| rank[**n as usize] == *at).count();
                paths.grow_inside(surface, cut, node, from, on_border, |n, cost| {
                    left -= usize::from(usize::from(rank[n as usize]) > i + 2);
                    left == 0 || cost > most
                });
                for (to, cost) in places.iter().zip(row).skip(i + 2) {
                    let is_reached = paths.via[*to as usize] != NONE;
                    *cost = if is_reached { paths.cost[*to as usize] } else { f64::INFINITY };
                }
            }
        }
    });
    Ok(())
}

/// One of the largest charts.
#[derive(Clone, Copy)]
struct Large {
    area: f64,
    square: f64,
    piece: usize,
    start: u32,  // an open half-edge of its border
    whole: bool, // whether it stays so
    times: f64,  // pieces that are alike
}

/// Fills `candidates` with the cuts of the largest charts of which most is expected, best first.
fn find_cuts<const N: usize>(
    candidates: &mut heapless::Vec<PackingCut, N>,
    uv: &[DVec2],
    cut: &[u8],
    placing: &Placing,
    is_first: bool,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let pieces = placing.pieces;
    let (crowd, largest) = survey(uv, cut, placing, scratch.frame())?;
    if crowd.count > MOST_CHARTS {
        return Ok(());
    }
    let total: f64 = pieces.rest().iter().map(|r| r.area).sum();
    let may = |l: &Large| !l.whole || is_first && l.square * l.square >= LONG * crowd.area;
    for (rank, large) in largest.iter().enumerate().filter(|(_, l)| may(l) && l.times * l.area >= LEAST * crowd.area) {
        let others = largest.iter().enumerate().filter(|(r, _)| *r != rank).map(|(_, l)| l.square).fold(0.0, f64::max);
        let mut frame = scratch.frame();
        let mut own = cuts_of(large, others, &crowd, sqrt(total), uv, cut, pieces, frame.frame(), workers)?;
        sort::by(&mut own, |a, b| b.gain.total_cmp(&a.gain).then(a.ends.cmp(&b.ends)));
        for c in own.iter().take(EACH) {
            candidates.push(*c).ok();
        }
    }
    sort::by(candidates, |a, b| b.gain.total_cmp(&a.gain).then(a.piece.cmp(&b.piece)).then(a.ends.cmp(&b.ends)));
    Ok(())
}

/// What packing will see of all charts, and the largest of them, by falling area.
fn survey(
    uv: &[DVec2],
    cut: &[u8],
    placing: &Placing,
    mut scratch: Scratch,
) -> Result<(Crowd, heapless::Vec<Large, LARGEST>), ScratchTooSmall> {
    let pieces = placing.pieces;
    let times = placing.copies.counts(pieces.count(), &mut scratch)?;
    let mut crowd = Crowd::default();
    let mut largest = heapless::Vec::<Large, LARGEST>::new();
    for piece in 0..pieces.count() {
        let mut frame = scratch.frame();
        let (surface, corners) = (pieces.bare_surface(piece), pieces.corners(piece));
        let (cut, uv) = (&cut[corners.clone()], &uv[corners]);
        let charts = ChartList::new(&surface, cut, &mut frame)?;
        for k in 0..charts.count() {
            let faces = charts.faces_of(k);
            let area = faces.iter().map(|f| surface.rest[*f as usize].area).sum::<f64>();
            let Some(start) = surface.first_open(cut, faces) else { continue };
            let outline = crowd.add(area, || surface.border(cut, start).map(|c| uv[c as usize]));
            // An original stands for its copies.
            if !(1..=MOST_ALIKE).contains(&times[piece]) {
                continue;
            }
            if largest.is_full() && largest.last().is_some_and(|l| l.area < area) {
                largest.pop();
            }
            if !largest.is_full() {
                let whole = lie_flat(faces, uv, surface.rest) || has_sharp_border(cut, &surface, start);
                let times = times[piece].into();
                largest.push(Large { area, square: outline.square(), piece, start, whole, times }).ok();
                // Behind those of the same area, as it came.
                sort::by(&mut largest, |a, b| {
                    b.area.total_cmp(&a.area).then((a.piece, a.start).cmp(&(b.piece, b.start)))
                });
            }
        }
    }
    Ok((crowd, largest))
}

/// Whether half of the border of the chart of the open half-edge `start` or more, by length, is where the surface ends or sharp.
fn has_sharp_border(cut: &[u8], surface: &Surface, start: u32) -> bool {
    let (mut all, mut sharp) = (0.0, 0.0);
    for c in surface.border(cut, start) {
        let t = surface.twin[c as usize];
        let length = surface.mesh.position(c).distance(surface.mesh.position(next(c)));
        all += length;
        sharp += if t == NONE || angle(surface.mesh, c, t) >= SHARP { length } else { 0.0 };
    }
    sharp >= 0.5 * all
}

/// Cuts of one chart that differ from one another by more than a place, as many as are kept. `others` is the square that the other
/// large charts need, `unit` the square root of all area.
#[allow(clippy::too_many_arguments)]
fn cuts_of(
    large: &Large,
    others: f64,
    crowd: &Crowd,
    unit: f64,
    uv: &[DVec2],
    cut: &[u8],
    pieces: &Pieces,
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<heapless::Vec<PackingCut, { 2 * EACH }>, ScratchTooSmall> {
    let mut found = heapless::Vec::<PackingCut, { 2 * EACH }>::new();
    let mut frame = scratch.frame();
    let (surface, corners) = (pieces.surface(large.piece, &mut frame)?, pieces.corners(large.piece));
    let (cut, uv) = (&cut[corners.clone()], &uv[corners]);
    let border = frame.take::<u32>(surface.border(cut, large.start).count())?;
    border.iter_mut().zip(surface.border(cut, large.start)).for_each(|(to, c)| *to = c);
    let Some(round) = NonZero::new(PLACES.min(border.len())).filter(|round| round.get() >= 4) else {
        return Ok(found);
    };
    let count = round.get();
    let mut places = [0; PLACES];
    surface.places_on(cut, border, &mut places[..count]);
    let place = |i: usize| places[i % round];
    let point = |i: usize| uv[place(i) as usize];
    let whole = Outline::new((0..count).map(point)).hull().max(large.area);
    let before = crowd.fill();
    let inside = Inside::new(cut, &surface, large.start, &mut frame)?;
    let mut nodes = [0; PLACES];
    nodes.iter_mut().enumerate().for_each(|(i, n)| *n = inside.node[place(i) as usize]);
    let farthest = (0..count).flat_map(|i| (0..i).map(move |j| point(i).distance(point(j)))).fold(0.0, f64::max);
    let most = if large.whole { EASY * farthest } else { FORBIDDEN };
    let mut costs = [[0.0; PLACES]; PLACES];
    path_costs(&mut costs, &nodes[..count], most, inside, cut, &surface, frame, workers)?;
    let mut at = heapless::Vec::<[usize; 2], { 2 * EACH }>::new();
    for (i, costs) in costs.iter().enumerate().take(count) {
        for (j, cost) in costs.iter().copied().enumerate().take(count).skip(i + 2) {
            let is_easy = cost <= EASY * point(i).distance(point(j));
            if cost >= FORBIDDEN || large.whole && !is_easy {
                continue;
            }
            let cost = large.times * cost / unit;
            let sides = [i..j + 1, j..i + count + 1].map(|range| Outline::new(range.map(point)));
            let hulls = sides.iter().map(|s| s.hull()).sum::<f64>().max(large.area);
            let after = Crowd {
                largest: sides.iter().map(|s| s.square()).fold(others, f64::max),
                hulls: crowd.hulls - large.times * whole + large.times * hulls,
                count: crowd.count + large.times,
                border: crowd.border + large.times * 2.0 * point(i).distance(point(j)),
                ..*crowd
            };
            let gain = FILL_WORTH * (after.fill() - before) - cost;
            let c = PackingCut { gain, cost, piece: large.piece as u64, ends: [place(i), place(j)] };
            // What begins and ends beside another is much the same cut: the better one stays.
            let beside = |a: usize, b: usize| a.abs_diff(b).min(count - a.abs_diff(b)) <= 1;
            let slot = match at.iter().position(|p| beside(p[0], i) && beside(p[1], j)) {
                Some(same) => Some(same),
                None if found.is_full() => {
                    (0..found.len()).min_by(|a, b| found[*a].gain.total_cmp(&found[*b].gain).then(b.cmp(a)))
                }
                None => None,
            };
            match slot {
                Some(slot) if found[slot].gain < gain => (found[slot], at[slot]) = (c, [i, j]),
                Some(_) => {}
                None => {
                    found.push(c).ok();
                    at.push([i, j]).ok();
                }
            }
        }
    }
    Ok(found)
}
