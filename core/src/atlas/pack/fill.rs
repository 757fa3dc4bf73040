//! Bottom-left fill of a raster square with the charts' masks at many turns, in the smallest square that takes them.
//!
//! Largest chart first (lane 0 by the hull's radius, lane 1 by area); each goes where its upper end comes to lie lowest, over all its turns, holes included. What a
//! placed chart blocks is its mask grown by the padding, so that a later mask beside it keeps the distance. A map of
//! chessboard distances to the nearest blocked cell rejects most places by one look-up at the mask's deepest cell; few
//! pass on to the comparison of bits. The side is found by bisection; lanes try different orders of the charts.
//! Limits: a gap costs up to a cell more than the padding. Cost a trial: about linear in the charts for a given raster.

use super::layout::{Gap, Pose};
use super::mask::Mask;
use super::outline::{self, Outlines};
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::workers::{Workers, for_each_chunk};
use core::f64::consts::{FRAC_PI_2, PI};
use core::ops::Range;
use glam::DVec2;

/// Orders of the charts that are tried at the most.
const LANES: usize = 2;

/// How finely a number of charts is filled.
struct Plan {
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
const PLANS: [Plan; 4] = [
    Plan { charts: 32, raster: 256, turns: 8, lanes: 2 },
    Plan { charts: 160, raster: 1024, turns: 16, lanes: 2 },
    Plan { charts: 1000, raster: 1024, turns: 16, lanes: 2 },
    Plan { charts: usize::MAX, raster: 1024, turns: 4, lanes: 1 },
];

fn plan(chart_count: usize) -> &'static Plan {
    PLANS.iter().find(|p| chart_count <= p.charts).unwrap_or(&PLANS[PLANS.len() - 1])
}

/// Bisection ends when the share of the square is known this well.
const CLOSE: f64 = 0.004;
/// Hulls with more corners are scanned at 90 turns instead of at each edge, for their smallest box.
const HULL_MAX: usize = 256;

/// Bytes that [`improve`] takes.
pub(super) fn need(chart_count: usize) -> usize {
    let &Plan { raster, lanes, .. } = plan(chart_count);
    let lane = bytes_for::<u32>(chart_count)
        + bytes_for::<f64>(chart_count)
        + 2 * bytes_for::<Pose>(chart_count)
        + Mask::need(raster)
        + bytes_for::<u64>(raster * (raster / 64))
        + bytes_for::<u8>(raster * raster)
        + bytes_for::<u8>(raster * (raster / 64))
        + bytes_for::<u64>(raster / 64 + 2);
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
struct Lane<'a> {
    index: usize,
    side: f64,
    poses: &'a mut [Pose],
    trial: &'a mut [Pose],
    order: &'a mut [u32],
    deepest: &'a mut [f64], // (k): largest `half` from this place in the order on
    mask: Mask<'a>,
    board: Board<'a>,
}

/// Puts better poses and a smaller side in place where the fill finds them.
pub(super) fn improve(
    poses: &mut [Pose],
    side: &mut f64,
    outlines: &Outlines,
    gap: &Gap,
    scratch: &mut Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let count = outlines.count();
    if (0..count).filter(|&i| !outlines.edges_of(i).is_empty()).count() < 2 {
        return Ok(());
    }
    let &Plan { raster, turns, lanes: lane_count, .. } = plan(count);
    let mut frame = scratch.frame();
    let upright = frame.take::<f64>(count)?;
    let half = frame.take::<f64>(count)?;
    for chart in 0..count {
        upright[chart] = upright_angle(outlines.hull_of(chart));
        let [low, high] = outlines.turned_box(chart, outline::turn(upright[chart]));
        half[chart] = 0.5 * (high - low).min_element();
    }
    let upright = Upright { angle: upright, half };
    let mut lanes = heapless::Vec::<Lane, LANES>::new();
    for index in 0..lane_count {
        let lane = Lane {
            index,
            side: *side,
            poses: frame.take(count)?,
            trial: frame.take(count)?,
            order: frame.take(count)?,
            deepest: frame.take(count)?,
            mask: Mask::new(raster, &mut frame)?,
            board: Board::new(raster, &mut frame)?,
        };
        let _ = lanes.push(lane);
    }
    for_each_chunk(workers, &mut lanes, 1, &|_, lane| {
        lane.iter_mut().for_each(|l| l.search(outlines, upright, gap, turns))
    });
    for lane in &lanes {
        if lane.side < *side {
            *side = lane.side;
            poses.copy_from_slice(lane.poses);
        }
    }
    Ok(())
}

impl Lane<'_> {
    /// Bisects the share of the square that charts cover.
    fn search(&mut self, outlines: &Outlines, upright: Upright, gap: &Gap, turns: usize) {
        self.sort(outlines);
        let mut deepest = 0.0;
        for (place, &chart) in self.deepest.iter_mut().zip(self.order.iter()).rev() {
            deepest = f64::max(deepest, upright.half[chart as usize]);
            *place = deepest;
        }
        let total: f64 = outlines.area.iter().sum();
        let total = if total > 0.0 { total } else { 1.0 };
        let (mut low, mut high) = (total / (self.side * self.side), 1.0);
        let mut share = 0.74_f64.max(low + CLOSE);
        while high - low > CLOSE * high {
            let side = real::sqrt(total / share);
            if self.place_all(side, outlines, upright, gap, turns) {
                (low, self.side) = (share, side);
                self.poses.copy_from_slice(self.trial);
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
        self.order.sort_unstable_by(|&a, &b| size(b).total_cmp(&size(a)).then(a.cmp(&b)));
    }

    /// Places all charts in a square of this side; false if one finds no place.
    fn place_all(&mut self, side: f64, outlines: &Outlines, upright: Upright, gap: &Gap, turns: usize) -> bool {
        let grow = self.board.fit(gap);
        let (raster, cells) = (self.board.usable, self.board.usable as f64 / side);
        self.board.clear();
        let mut start = Start::default();
        for (place, &chart) in self.order.iter().enumerate() {
            let chart = chart as usize;
            let edges = outlines.edges_of(chart);
            if edges.is_empty() {
                continue;
            }
            let mut best: Option<(usize, usize, usize, f64)> = None; // upper end, x, y, angle
            let floor = start.row(size(outlines, chart, self.index));
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
}

/// What a lane sorts by: lane 0 the hull's radius, lane 1 the area.
fn size(outlines: &Outlines, chart: usize, lane: usize) -> f64 {
    if lane == 1 { real::sqrt(outlines.area[chart]) } else { outlines.radius[chart] }
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
struct Start {
    class: f64,
    row: usize,
    placed: usize,
    lowest: usize,
}

impl Start {
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
        let side = hull[(i + 1) % hull.len()] - hull[i];
        let angle = if scan { PI / 180.0 * i as f64 } else { -real::atan2(side.y, side.x) };
        let area = area(angle);
        if area < best.0 {
            best = (area, angle);
        }
    }
    best.1
}

/// The raster square: what is blocked, and how far each cell is from that.
struct Board<'a> {
    side: usize,
    usable: usize,          // cells a side that charts may take
    blocked: &'a mut [u64], // (side, side / 64)
    distance: &'a mut [u8], // (side, side): chessboard, up to 255
    farthest: &'a mut [u8], // (side, side / 64): largest distance in 64 cells
    buffer: &'a mut [u64],  // a row
}

impl<'a> Board<'a> {
    fn new(side: usize, scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self {
            side,
            usable: side,
            blocked: scratch.take(side * (side / 64))?,
            distance: scratch.take(side * side)?,
            farthest: scratch.take(side * (side / 64))?,
            buffer: scratch.take(side / 64 + 2)?,
        })
    }

    /// Leaves out the last cells where that saves a cell of padding; the padding in cells.
    fn fit(&mut self, gap: &Gap) -> f64 {
        let share = gap.texels / gap.size;
        let whole = real::floor(share * self.side as f64);
        let usable = if whole > 0.0 { real::floor(whole / share) as usize } else { 0 };
        self.usable = if usable * 64 > self.side * 63 { usable.min(self.side) } else { self.side };
        share * self.usable as f64
    }

    fn clear(&mut self) {
        self.blocked.fill(0);
        self.distance.fill(255);
        self.farthest.fill(255);
    }

    /// The lowest, then leftmost free place at or above row `floor` whose upper end is at most `limit`.
    fn lowest(&self, mask: &Mask, floor: usize, limit: usize) -> Option<(usize, usize)> {
        let (side, words) = (self.side, self.side / 64);
        let pole = mask.poles.first()?;
        let (px, py) = (pole.x as usize, pole.y as usize);
        if mask.width > self.usable {
            return None;
        }
        let (first, last) = (px, self.usable + px - mask.width);
        for y in floor..(limit + 1).checked_sub(mask.height)? {
            let row = &self.distance[(y + py) * side..][..side];
            let far = &self.farthest[(y + py) * words..][..words];
            for (block, _) in far.iter().enumerate().take(last / 64 + 1).skip(first / 64).filter(|f| *f.1 >= pole.depth)
            {
                let from = first.max(block * 64);
                let cells = &row[from..last.min(block * 64 + 63) + 1];
                for (i, _) in cells.iter().enumerate().filter(|c| *c.1 >= pole.depth) {
                    let x = from + i - px;
                    if self.poles_free(mask, x, y) && self.bits_free(mask, x, y) {
                        return Some((x, y));
                    }
                }
            }
        }
        None
    }

    #[inline]
    fn poles_free(&self, mask: &Mask, x: usize, y: usize) -> bool {
        let at = y * self.side + x;
        mask.poles.iter().skip(1).all(|p| self.distance[at + p.y as usize * self.side + p.x as usize] >= p.depth)
    }

    fn bits_free(&self, mask: &Mask, x: usize, y: usize) -> bool {
        let words = self.side / 64;
        let (word, shift) = (x / 64, x % 64);
        // Every seventh row first: neighbours tell much the same.
        for (first, step) in [(3, 7), (0, 1)] {
            for row in (first..mask.height).step_by(step) {
                let line = &self.blocked[(y + row) * words + word..(y + row + 1) * words];
                let mut carry = 0u64;
                for (i, &bits) in mask.row(row).iter().enumerate() {
                    let moved = bits << shift | carry;
                    carry = if shift == 0 { 0 } else { bits >> (64 - shift) };
                    if moved & line[i] != 0 {
                        return false;
                    }
                }
                if carry != 0 && line[mask.words] & carry != 0 {
                    return false;
                }
            }
        }
        true
    }

    /// Blocks the mask at (x, y) grown by `grow` cells, and brings distances up to `depth` cells up to date.
    fn block(&mut self, mask: &Mask, x: usize, y: usize, grow: f64, depth: usize) {
        let (side, words) = (self.side as isize, self.side / 64);
        let reach = real::ceil(grow) as isize + 1;
        for dy in -reach..=reach {
            // Cells dx apart leave |dx| - 1 cells between them: blocked if that gap is closer than `grow`.
            let between = (dy.abs() - 1).max(0) as f64;
            if between >= grow && dy != 0 {
                continue;
            }
            let across = real::sqrt((grow * grow - between * between).max(0.0));
            let spread = (real::ceil(across) as isize).min(self.side as isize);
            for row in 0..mask.height {
                let to = y as isize + row as isize + dy;
                if (0..side).contains(&to) {
                    shift_into(self.buffer, mask.row(row), x);
                    smear(self.buffer, spread as usize);
                    let line = &mut self.blocked[to as usize * words..][..words];
                    line.iter_mut().zip(self.buffer.iter()).for_each(|(l, b)| *l |= b);
                }
            }
        }
        let grown = reach as usize;
        let cap = depth.min(256);
        let rows = (y.saturating_sub(grown), (y + mask.height + grown).min(self.side));
        let columns = (x.saturating_sub(grown), (x + mask.width + grown).min(self.side));
        for row in rows.0..rows.1 {
            for column in columns.0..columns.1 {
                if self.blocked[row * words + column / 64] >> (column % 64) & 1 == 1 {
                    self.distance[row * self.side + column] = 0;
                }
            }
        }
        self.relax(
            (rows.0.saturating_sub(cap), (rows.1 + cap).min(self.side)),
            (columns.0.saturating_sub(cap), (columns.1 + cap).min(self.side)),
        );
    }

    /// Lowers distances in a window after cells in it were set to 0; two passes, cells outside stay.
    fn relax(&mut self, rows: (usize, usize), columns: (usize, usize)) {
        let (side, words) = (self.side, self.side / 64);
        let window = columns.0..columns.1;
        for y in rows.0.max(1)..rows.1 {
            let (above, here) = self.distance.split_at_mut(y * side);
            relax_row(&mut here[..side], &above[(y - 1) * side..], window.clone(), false);
        }
        for y in (rows.0..rows.1).rev() {
            let (here, below) = self.distance.split_at_mut((y + 1) * side);
            let row = &mut here[y * side..];
            if !below.is_empty() {
                relax_row(row, &below[..side], window.clone(), true);
            }
            for block in columns.0 / 64..columns.1.div_ceil(64) {
                let cells = &row[block * 64..][..64];
                self.farthest[y * words + block] = cells.iter().copied().max().unwrap_or(0);
            }
        }
    }
}

/// One row of a chessboard distance pass over a window of columns. The board's border blocks nothing.
fn relax_row(row: &mut [u8], passed: &[u8], window: Range<usize>, backwards: bool) {
    let side = row.len();
    let inner = window.start.max(1)..window.end.min(side - 1);
    for (d, three) in row[inner.clone()].iter_mut().zip(passed[inner.start - 1..inner.end + 1].windows(3)) {
        *d = (*d).min(three[0].min(three[1]).min(three[2]).saturating_add(1));
    }
    for x in [0, side - 1].into_iter().filter(|x| window.contains(x)) {
        let beside = if x == 0 { 1 } else { side - 2 };
        row[x] = row[x].min(passed[x].min(passed[beside]).saturating_add(1));
    }
    let mut before = match backwards {
        true => row.get(window.end).copied().unwrap_or(255),
        false => window.start.checked_sub(1).map_or(255, |x| row[x]),
    };
    let step = |d: &mut u8| {
        *d = (*d).min(before.saturating_add(1));
        before = *d;
    };
    if backwards { row[window].iter_mut().rev().for_each(step) } else { row[window].iter_mut().for_each(step) }
}

/// `bits` moved up by `x` places into `row`; what leaves the row is lost.
fn shift_into(row: &mut [u64], bits: &[u64], x: usize) {
    row.fill(0);
    let (word, shift) = (x / 64, x % 64);
    for (i, &b) in bits.iter().enumerate() {
        if let Some(r) = row.get_mut(word + i) {
            *r |= b << shift;
        }
        if shift > 0
            && let Some(r) = row.get_mut(word + i + 1)
        {
            *r |= b >> (64 - shift);
        }
    }
}

/// Sets every bit within `spread` places of a set bit.
fn smear(row: &mut [u64], spread: usize) {
    let mut left = spread;
    let mut reach = 1;
    while left > 0 {
        let by = reach.min(left).min(63);
        let mut carry = 0;
        for r in row.iter_mut() {
            let before = *r;
            *r |= before << by | carry;
            carry = before >> (64 - by);
        }
        carry = 0;
        for r in row.iter_mut().rev() {
            let before = *r;
            *r |= before >> by | carry;
            carry = before << (64 - by);
        }
        left -= by;
        reach = 2 * by + 1;
    }
}
