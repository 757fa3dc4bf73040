//! Bottom-left fill of a raster square with the charts' masks at many turns, in the smallest square that takes them.
//!
//! Largest chart first (lane 0 by the hull's radius, lane 1 by area); each goes where its upper end comes to lie
//! lowest, over all its turns, holes included. Charts that are fixed beforehand leave their gaps to the others. What a
//! placed chart blocks is its mask grown by the padding, so that a later mask beside it keeps the distance. A map of
//! chessboard distances to the nearest blocked cell rejects most places by one look-up at the mask's deepest cell; few
//! pass on to the comparison of bits. The side is found by bisection; lanes try different orders of the charts.
//! Limits: a gap costs up to a cell more than the padding. Cost a trial: about linear in the charts for a given raster.

use super::board::Board;
use super::mask::Mask;
use super::outline::{self, Outlines, common_box};
use super::placement::{Gap, Pose};
use super::settings::is_sketch;
use crate::base::real;
use crate::base::room::Room;
use crate::base::scratch::{Alarm, Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::workers::{Workers, for_each_chunk};
use core::f64::consts::{FRAC_PI_2, PI};
use glam::DVec2;

/// Orders of the charts that are tried at the most.
const LANES: usize = 2;

/// How finely a number of charts is filled.
struct FillPlan {
    /// Up to so many charts.
    charts: usize,
    /// Cells a side, a multiple of 64.
    raster: usize,
    /// Turns a chart, a multiple of 4.
    turns: usize,
    lanes: usize,
}

/// Coarse where separation follows, fine where the raster's gaps stay. At 459 charts 16 turns fill .690 of the square
/// and 8 turns .685 in 0.7 of the time; at 4802 charts a lane takes 4 s of CPU time.
const PLANS: [FillPlan; 4] = [
    FillPlan { charts: 32, raster: 256, turns: 8, lanes: 2 },
    FillPlan { charts: 160, raster: 1024, turns: 16, lanes: 2 },
    FillPlan { charts: 1000, raster: 1024, turns: 16, lanes: 2 },
    FillPlan { charts: usize::MAX, raster: 1024, turns: 4, lanes: 1 },
];

/// For trials whose outcome is compared alone: 128 cells, 4 turns and one lane take a tenth of the time.
const SKETCH: FillPlan = FillPlan { charts: 32, raster: 128, turns: 4, lanes: 1 };

fn plan(chart_count: usize, effort: f64) -> &'static FillPlan {
    if chart_count <= SKETCH.charts && is_sketch(effort) {
        return &SKETCH;
    }
    PLANS.iter().find(|p| chart_count <= p.charts).unwrap_or(&PLANS[PLANS.len() - 1])
}

/// Bisection ends when the share of the square is known this well.
const CLOSE: f64 = 0.004;
/// Hulls with more corners are scanned at 90 turns instead of at each edge, for their smallest box.
const HULL_MAX: usize = 256;

/// Bytes that [`improve`] takes.
pub(super) fn need(chart_count: usize) -> usize {
    let &FillPlan { raster, lanes, .. } = plan(chart_count, f64::INFINITY);
    let lane = bytes_for::<u32>(chart_count)
        + bytes_for::<f64>(chart_count)
        + 2 * bytes_for::<Pose>(chart_count)
        + Mask::need(raster)
        + Board::need(raster);
    2 * bytes_for::<f64>(chart_count) + lanes * lane
}

/// Charts in their smallest boxes.
#[derive(Clone, Copy)]
struct Upright<'a> {
    angle: &'a [f64], // (k)
    /// Half the box's shorter side: no square inside the chart has a longer half side.
    half: &'a [f64], // (k)
}

/// One order of the charts: its own raster and best poses.
struct FillLane<'a> {
    index: usize,
    side: f64,
    fixed: usize,
    poses: &'a mut [Pose],
    trial: &'a mut [Pose],
    order: &'a mut [u32],
    deepest: &'a mut [f64], // (k): largest `half` from this place in the order on
    alarm: Alarm<'a>,
    mask: Mask<'a>,
    board: Board<'a>,
}

/// Charts that stay where they are.
#[derive(Clone, Copy)]
pub(super) struct Fixed {
    /// The first so many.
    pub charts: usize,
    /// Longest side of the square: the fixed charts are apart by its gap.
    pub room: f64,
}

impl Fixed {
    /// All charts are free.
    pub const NONE: Fixed = Fixed { charts: 0, room: f64::INFINITY };
}

/// Puts better poses and a smaller side in place where the fill finds them, and tells whether it did.
#[allow(clippy::too_many_arguments)]
pub(super) fn improve(
    poses: &mut [Pose],
    side: &mut f64,
    outlines: &Outlines,
    fixed: Fixed,
    gap: &Gap,
    effort: f64,
    scratch: &mut Scratch,
    workers: &dyn Workers,
) -> Result<bool, ScratchTooSmall> {
    let count = outlines.count();
    if (0..count).filter(|&i| !outlines.edges_of(i).is_empty()).count() < 2 {
        return Ok(false);
    }
    let &FillPlan { raster, turns, lanes: lane_count, .. } = plan(count, effort);
    let mut frame = scratch.frame();
    let alarm = frame.alarm();
    let upright = frame.take::<f64>(count)?;
    let half = frame.take::<f64>(count)?;
    for chart in 0..count {
        upright[chart] = if outlines.upright[chart] != 0 { 0.0 } else { upright_angle(outlines.hull_of(chart)) };
        let [low, high] = outlines.turned_box(chart, outline::turn(upright[chart]));
        half[chart] = 0.5 * (high - low).min_element();
    }
    let upright = Upright { angle: upright, half };
    let mut lanes = heapless::Vec::<FillLane, LANES>::new();
    for index in 0..lane_count {
        let lane = FillLane {
            index,
            side: side.min(fixed.room),
            fixed: fixed.charts,
            poses: frame.take(count)?,
            trial: frame.take(count)?,
            order: frame.take(count)?,
            deepest: frame.take(count)?,
            alarm,
            mask: Mask::new(raster, &mut frame)?,
            board: Board::new(raster, &mut frame)?,
        };
        lane.trial[..fixed.charts].copy_from(&poses[..fixed.charts]);
        lanes.put(lane);
    }
    for_each_chunk(workers, &mut lanes, 1, &|_, lane| {
        lane.iter_mut().for_each(|l| l.search(outlines, upright, gap, turns))
    });
    alarm.check()?;
    let mut found = false;
    for lane in &lanes {
        if lane.side < side.min(fixed.room) {
            found = true;
            *side = lane.side;
            poses.copy_from(lane.poses);
        }
    }
    Ok(found)
}

impl FillLane<'_> {
    /// Bisects the share of the square that charts cover.
    fn search(&mut self, outlines: &Outlines, upright: Upright, gap: &Gap, turns: usize) {
        self.sort(outlines);
        let mut deepest = 0.0;
        for (place, &chart) in self.deepest.iter_mut().zip(self.order.iter()).rev() {
            let moves = chart as usize >= self.fixed;
            deepest = f64::max(deepest, if moves { upright.half[chart as usize] } else { 0.0 });
            *place = deepest;
        }
        let total: f64 = outlines.area.iter().sum();
        let total = if total > 0.0 { total } else { 1.0 };
        let (mut low, mut high) = (total / (self.side * self.side), 1.0);
        let mut share = 0.74_f64.max(low + CLOSE);
        if self.fixed > 0 {
            // No smaller than what the fixed charts fill.
            let [_, corner] = common_box(&self.trial[..self.fixed], &outlines.leading(self.fixed));
            let least = corner.max_element();
            high = total / (least * least) * (1.0 + CLOSE);
            share = total / (least * least);
        }
        while high - low > CLOSE * high {
            let side = real::sqrt(total / share);
            if self.place_all(side, outlines, upright, gap, turns) {
                (low, self.side) = (share, side);
                self.poses.copy_from(self.trial);
                share = (0.5 * (low + high)).min(low + 0.03);
            } else {
                high = share;
                share = (0.5 * (low + high)).max(high - 0.05);
            }
        }
    }

    /// Lane 0 goes by the hull's diameter, lane 1 by area.
    fn sort(&mut self, outlines: &Outlines) {
        let lane = self.index;
        let size = |chart: u32| size(outlines, chart as usize, lane);
        self.order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
        sort::by(self.order, |&a, &b| size(b).total_cmp(&size(a)).then(a.cmp(&b)));
    }

    /// Places all charts in a square of this side; false if one finds no place.
    fn place_all(&mut self, side: f64, outlines: &Outlines, upright: Upright, gap: &Gap, turns: usize) -> bool {
        let grow = self.board.fit(gap);
        let (raster, cells) = (self.board.usable, self.board.usable as f64 / side);
        self.board.clear();
        let mut start = FillStart::default();
        if !(0..self.fixed).all(|chart| self.keep(chart, outlines, cells, grow)) {
            return false;
        }
        for (place, &chart) in self.order.iter().enumerate() {
            let chart = chart as usize;
            let edges = outlines.edges_of(chart);
            if edges.is_empty() || chart < self.fixed {
                continue;
            }
            if self.alarm.is_set() {
                return false;
            }
            let mut best: Option<(usize, usize, usize, f64)> = None; // upper end, x, y, angle
            let floor = start.row(size(outlines, chart, self.index));
            let turns = if outlines.upright[chart] != 0 { turns.min(4) } else { turns };
            for i in 0..turns {
                // Quarter turns first, then finer ones.
                let angle = upright.angle[chart] + FRAC_PI_2 * (i % 4) as f64 + FRAC_PI_2 * fraction(i / 4, turns / 4);
                let turn = outline::turn(angle);
                if self.mask.draw(edges, outlines.turned_box(chart, turn), turn, cells) {
                    let limit = best.map_or(raster, |b| b.0 - 1);
                    if let Some((x, y)) = self.board.lowest(&self.mask, floor, limit) {
                        best = Some((y + self.mask.height, x, y, angle));
                    }
                }
            }
            let Some((_, x, y, angle)) = best else { return false };
            let turn = outline::turn(angle);
            self.mask.draw(edges, outlines.turned_box(chart, turn), turn, cells);
            self.trial[chart] = Pose { angle, at: DVec2::new(x as f64, y as f64) / cells - self.mask.low };
            let depth = (self.deepest[place] * cells) as usize + 2;
            self.board.block(&self.mask, x, y, grow, depth);
            start.note(y);
        }
        true
    }

    /// Blocks a fixed chart's place; false if that is more than the square has.
    fn keep(&mut self, chart: usize, outlines: &Outlines, cells: f64, grow: f64) -> bool {
        let pose = self.trial[chart];
        let turn = outline::turn(pose.angle);
        let [low, high] = outlines.turned_box(chart, turn);
        // The mask's least corner stands on the raster.
        let corner = ((pose.at + low) * cells).floor().max(DVec2::ZERO);
        let depth = (self.deepest[0] * cells) as usize + 2;
        let fits = self.mask.draw(outlines.edges_of(chart), [corner / cells - pose.at, high], turn, cells);
        if fits {
            self.board.block(&self.mask, corner.x as usize, corner.y as usize, grow, depth);
        }
        fits
    }
}

/// What a lane sorts by: lane 0 the hull's radius, lane 1 the area.
fn size(outlines: &Outlines, chart: usize, lane: usize) -> f64 {
    real::for_decision(if lane == 1 { real::sqrt(outlines.area[chart]) } else { outlines.radius[chart] })
}

/// Turns between quarter turns in the order 0, 1/2, 1/4, 3/4, ...
fn fraction(index: usize, count: usize) -> f64 {
    let bits = count.max(1).next_power_of_two().trailing_zeros();
    if bits == 0 { 0.0 } else { (index.reverse_bits() >> (usize::BITS - bits)) as f64 / (1usize << bits) as f64 }
}

/// Where the scan may begin: charts of about the same size have filled what lies below.
///
/// A new size class (a tenth smaller) begins at the bottom again, since it may find holes.
#[derive(Default)]
struct FillStart {
    class: f64,
    row: usize,
    placed: usize,
    lowest: usize,
}

impl FillStart {
    fn row(&mut self, size: f64) -> usize {
        if size < 0.9 * self.class || self.class == 0.0 {
            (self.class, self.row, self.placed, self.lowest) = (size, 0, 0, usize::MAX);
        }
        self.row
    }

    fn note(&mut self, y: usize) {
        (self.placed, self.lowest) = (self.placed + 1, self.lowest.min(y));
        if self.placed == 8 {
            (self.row, self.placed, self.lowest) = (self.lowest, 0, usize::MAX);
        }
    }
}

/// The angle that stands the hull upright in its smallest box.
fn upright_angle(hull: &[DVec2]) -> f64 {
    let area = |angle: f64| {
        let turn = outline::turn(angle);
        let mut corners = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        for &p in hull {
            let q = turn.rotate(p);
            corners = [corners[0].min(q), corners[1].max(q)];
        }
        let size = corners[1] - corners[0];
        size.x * size.y
    };
    let scan = hull.len() > HULL_MAX;
    let mut best = (f64::INFINITY, 0.0);
    for i in 0..if scan { 90 } else { hull.len() } {
        let side = *hull.get(i + 1).unwrap_or(&hull[0]) - hull[i];
        let angle = if scan { PI / 180.0 * i as f64 } else { -real::atan2(side.y, side.x) };
        let area = area(angle);
        if area < best.0 {
            best = (area, angle);
        }
    }
    best.1
}
