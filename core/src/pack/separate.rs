//! Overlap minimisation in a shrinking square.
//!
//! From a valid placement the square is made a little smaller, which pushes charts into one another, and the overlap is
//! worked off: each colliding chart in turn moves to the place and turn of least weighted overlap among many samples,
//! the best of which are refined by coordinate descent; pairs that keep colliding gain weight (guided local search).
//! When all overlap is gone the square shrinks again; when it does not go, the last valid placement is disrupted and
//! tried once more. After Gardeyn, Vanden Berghe, Wauters 2025 (Sparrow), with depths from distance fields; weights
//! after Egeblad, Nielsen, Odgaard 2007. The result counts only if the exact check confirms it.
//! Limits: a local search; work is bounded by look-ups, so more charts get fewer tries each.

use super::body::{Body, Encounter};
use super::clearance;
use super::field::{self, Fields};
use super::outline::{self, Outlines};
use super::placement::{Gap, Pose};
use super::settings::{PackSettings, is_sketch};
use crate::base::eight::widest;
use crate::base::room::Room;
use crate::base::scratch::{Alarm, Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::workers::{Workers, for_each_chunk};
use crate::base::{random, real};
use core::f64::consts::{PI, TAU};
use glam::{DVec2, Vec2};

/// Independent searches.
const LANES: usize = 2;
/// Look-ups a lane for effort 1: about 5 ns each.
const WORK: f64 = 3e7;
/// So few charts get [`FEW_WORK`] of that: the best place of two or three is found at once (0.15 of the work gives the same
/// bits of utilisation as 1.5 on both atlases of the bench that have so few).
const FEW: usize = 3;
/// See [`FEW`].
const FEW_WORK: f64 = 0.2;
/// Places that a colliding chart tries all over the square, and near its own. 40 and 16 fill 1 % less.
const GLOBAL: usize = 16;
const LOCAL: usize = 10;
/// Least share by which the square shrinks.
const LEAST_SHRINK: f64 = 0.0005;
/// Turns that a chart tries which is too long for the square at its own.
const TURNS: usize = 64;
/// Places that are refined. 4 fill 1 % less.
const REFINED: usize = 2;
/// Sweeps without 2 % less overlap before an attempt is given up. Over eight atlases of 3 to 39 charts, 12 fills .705 of
/// the square on the mean, 7 .693, 25 .692 and 60 .686.
const PATIENCE: usize = 12;
/// Share of the work after which steps become fine.
const EXPLORE: f64 = 0.7;
/// Share of the work without a smaller square after which they do so at once.
const STALE: f64 = 0.25;
/// Rounds of the exact check, each with wider gaps between the pairs that failed the last.
const CHECKS: usize = 40;
/// Look-ups a round.
const CHECK_WORK: f64 = 5e5;

/// Bytes that [`improve`] takes.
pub(super) fn need(edge_count: usize, chart_count: usize) -> usize {
    let count = chart_count;
    let lane = bytes_for::<Pose>(count)
        + bytes_for::<Body>(count)
        + bytes_for::<u32>(count)
        + 3 * bytes_for::<f32>(count * count);
    field::need(edge_count, count) + LANES * lane
}

/// Puts better poses and a smaller side in place where the search finds them and the exact check agrees.
pub(super) fn improve(
    poses: &mut [Pose],
    side: &mut f64,
    outlines: &Outlines,
    gap: &Gap,
    settings: &PackSettings,
    scratch: &mut Scratch,
    workers: &dyn Workers,
) -> Result<(), ScratchTooSmall> {
    let count = poses.len();
    let real_charts = (0..count).filter(|&i| !outlines.edges_of(i).is_empty()).count();
    if real_charts < 2 || settings.effort.is_nan() || settings.effort <= 0.0 {
        return Ok(());
    }
    let mut frame = scratch.frame();
    let alarm = frame.alarm();
    let nodes = if is_sketch(settings.effort) { field::SKETCH_NODES } else { field::NODES };
    let fields = Fields::new(outlines, 2.0 * gap.within(*side), nodes, &mut frame)?;
    let mut lanes = heapless::Vec::<SeparationLane, LANES>::new();
    for index in 0..LANES {
        let lane = SeparationLane {
            outlines,
            fields,
            gap: *gap,
            side: *side,
            best_side: *side,
            best: frame.take(count)?,
            bodies: frame.take(count)?,
            order: frame.take(count)?,
            weight: frame.take(count * count)?,
            overlap: frame.take(count * count)?,
            extra: frame.take(count * count)?,
            alarm,
            key: random::hash(settings.seed, 0x5e9a, index as u64),
            draws: 0,
            work: 0.0,
        };
        lane.best.copy_from(poses);
        lanes.put(lane);
    }
    let work = WORK * settings.effort * if real_charts <= FEW { FEW_WORK } else { 1.0 };
    for_each_chunk(workers, &mut lanes, 1, &|_, lane| lane.iter_mut().for_each(|l| l.search(work)));
    alarm.check()?;
    let mut order: [usize; LANES] = core::array::from_fn(|i| i);
    let key = |i: &usize| (lanes[*i].best_side, lanes[*i].key);
    sort::by(&mut order, |a, b| key(a).0.total_cmp(&key(b).0).then(key(a).1.cmp(&key(b).1)));
    for i in order {
        let lane = &mut lanes[i];
        if lane.best_side < *side && lane.confirm(*side, &mut frame)? {
            *side = lane.best_side;
            poses.copy_from(lane.best);
        }
    }
    Ok(())
}

/// One search.
struct SeparationLane<'a> {
    outlines: &'a Outlines<'a>,
    fields: Fields<'a>,
    gap: Gap,
    side: f64,
    best_side: f64,
    best: &'a mut [Pose],
    bodies: &'a mut [Body],
    order: &'a mut [u32],
    weight: &'a mut [f32],  // (k, k)
    overlap: &'a mut [f32], // (k, k)
    extra: &'a mut [f32],   // (k, k): gap beyond the common one
    alarm: Alarm<'a>,
    key: u64,
    draws: u64,
    work: f64,
}

impl SeparationLane<'_> {
    fn draw(&mut self) -> f64 {
        self.draws += 1;
        random::unit_f64(self.key, 0, self.draws)
    }

    fn count(&self) -> usize {
        self.bodies.len()
    }

    /// Explores with steps of a few percent, then compresses with finer ones, within `budget` look-ups. Where nothing better
    /// has been found for a while it goes on to the end at once.
    fn search(&mut self, budget: f64) {
        let mut shrink = f64::min(0.02, 0.06 / real::sqrt(self.count() as f64));
        let (mut fails, mut late, mut end, mut found) = (0, false, budget, 0.0);
        while self.work < end && !self.alarm.is_set() {
            if !late && (self.work > EXPLORE * budget || self.work - found > STALE * budget) {
                (late, end) = (true, self.work + (1.0 - EXPLORE) * budget);
                shrink = f64::min(shrink, 0.004);
            }
            if !self.load(self.best_side * (1.0 - shrink)) {
                if shrink <= LEAST_SHRINK {
                    break;
                }
                shrink = f64::max(shrink * 0.6, LEAST_SHRINK);
                continue;
            }
            if fails > 0 && !late {
                self.disrupt();
            }
            if self.resolve(end, PATIENCE) {
                self.keep();
                (fails, found) = (0, self.work);
            } else {
                fails += 1;
                if late || fails > 3 {
                    (shrink, fails) = (f64::max(shrink * 0.6, LEAST_SHRINK), if late { fails } else { 1 });
                }
            }
        }
    }

    /// Makes the poses exact: pairs that the exact check finds too close get a wider gap and are separated again.
    fn confirm(&mut self, limit: f64, scratch: &mut Scratch) -> Result<bool, ScratchTooSmall> {
        self.extra.fill(0.0);
        let count = self.count();
        for round in 0..CHECKS {
            // The room grows a little from round to round, so that the gaps find it.
            let fits = self.load(self.best_side * if round > 2 { 1.0005 } else { 1.0 });
            if self.side >= limit || !fits {
                return Ok(false);
            }
            if round > 0 {
                self.resolve(self.work + CHECK_WORK, 2 * PATIENCE);
            }
            self.keep();
            let bound = self.gap.within(self.side);
            let extra = &mut *self.extra;
            let clear = clearance::check(self.best, self.outlines, bound, scratch, &mut |a, b, distance| {
                let more = ((bound - distance) * 1.05) as f32 + 1e-6;
                extra[a * count + b] += more;
                extra[b * count + a] += more;
            })?;
            if clear {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Takes up the best poses, drawn together into a square of `side`; false if a chart fits into it at no turn.
    fn load(&mut self, side: f64) -> bool {
        let scale = side / self.best_side;
        self.side = side;
        for chart in 0..self.count() {
            let mut pose = self.best[chart];
            pose.at *= scale;
            let Some(body) = self.inside_at_some_turn(chart, &pose) else { return false };
            self.bodies[chart] = body;
        }
        true
    }

    /// The pose moved into the square, and turned as little as that needs.
    fn inside_at_some_turn(&self, chart: usize, pose: &Pose) -> Option<Body> {
        (0..2 * TURNS).find_map(|i| {
            let away = i.div_ceil(2) as f64 * PI / TURNS as f64;
            let angle = self.outlines.allowed(chart, pose.angle + if i % 2 == 0 { -away } else { away });
            self.inside(chart, Body::new(&Pose { angle, ..*pose }))
        })
    }

    fn keep(&mut self) {
        self.best_side = self.side;
        for (pose, body) in self.best.iter_mut().zip(self.bodies.iter()) {
            *pose = body.pose();
        }
    }

    /// Two charts of like size change places, and one takes a random turn.
    fn disrupt(&mut self) {
        let count = self.count();
        let a = ((self.draw() * count as f64) as usize).min(count - 1);
        let mut b = ((self.draw() * count as f64) as usize).min(count - 1);
        for _ in 0..4 {
            let other = ((self.draw() * count as f64) as usize).min(count - 1);
            let unlike = |x: usize| (self.outlines.radius[x] - self.outlines.radius[a]).abs();
            if b == a || (other != a && unlike(other) < unlike(b)) {
                b = other;
            }
        }
        let (at_a, at_b) = (self.bodies[a].at, self.bodies[b].at);
        let angle = self.draw() * TAU;
        let angle = self.outlines.allowed(a, angle);
        for (chart, at, angle) in [(a, at_b, angle), (b, at_a, self.bodies[b].angle)] {
            let body = Body { at, turn: outline::turn(angle).as_vec2(), angle };
            if let Some(body) = self.inside(chart, body) {
                self.bodies[chart] = body;
            }
        }
    }

    /// Works off all overlap; false when it stays or the budget is used up.
    fn resolve(&mut self, budget: f64, patience: usize) -> bool {
        let count = self.count();
        self.weight.fill(1.0);
        for chart in 0..count {
            self.measure(chart);
        }
        let (mut least, mut idle) = (f32::INFINITY, 0);
        loop {
            let total: f32 = self.overlap.iter().sum();
            if total == 0.0 {
                return true;
            }
            if total < 0.98 * least {
                (least, idle) = (total, 0);
            } else {
                idle += 1;
            }
            if idle > patience || self.work > budget || self.alarm.is_set() {
                return false;
            }
            self.shuffle();
            for rank in 0..count {
                let chart = self.order[rank] as usize;
                if self.overlap[chart * count..][..count].iter().any(|o| *o > 0.0) {
                    self.relocate(chart);
                }
            }
            self.reweigh();
        }
    }

    fn shuffle(&mut self) {
        let count = self.count();
        self.order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
        for i in (1..count).rev() {
            let j = ((self.draw() * (i + 1) as f64) as usize).min(i);
            self.order.swap(i, j);
        }
    }

    /// Pairs gain weight with their share of the largest overlap; others lose it slowly.
    fn reweigh(&mut self) {
        let most = self.overlap.iter().copied().fold(0.0, f32::max);
        for (weight, overlap) in self.weight.iter_mut().zip(self.overlap.iter()) {
            let grown = *weight * (1.2 + 0.8 * overlap / most.max(f32::MIN_POSITIVE));
            *weight = if *overlap > 0.0 { grown.min(1e12) } else { f32::max(1.0, *weight * 0.95) };
        }
    }

    /// Moves a chart to the least weighted overlap that samples and descent find, if that is less than now.
    fn relocate(&mut self, chart: usize) {
        let now = self.bodies[chart];
        let mut best = heapless::Vec::<(f32, Body), REFINED>::new();
        let loss = self.loss(chart, &now, f32::INFINITY);
        best.put((loss, now));
        for sample in 0..GLOBAL + LOCAL {
            let random = [self.draw(), self.draw(), self.draw()];
            let body = if sample < GLOBAL {
                // Anywhere, at any turn; every other one at a quarter turn from now.
                let angle = if sample % 2 == 0 {
                    random[2] * TAU
                } else {
                    now.angle + (random[2] * 4.0) as u32 as f64 * PI / 2.0
                };
                self.anywhere(chart, self.outlines.allowed(chart, angle), random[0], random[1])
            } else {
                let reach = 0.1 * self.outlines.radius[chart];
                let step = DVec2::new(random[0] - 0.5, random[1] - 0.5) * 2.0 * reach;
                let angle = self.outlines.allowed(chart, now.angle + (random[2] - 0.5) * 0.5);
                let turn = outline::turn(angle).as_vec2();
                self.inside(chart, Body { at: now.at + step.as_vec2(), turn, angle })
            };
            let Some(body) = body else { continue };
            let limit = if best.is_full() { best[REFINED - 1].0 } else { f32::INFINITY };
            let loss = self.loss(chart, &body, limit);
            if loss < limit {
                if best.is_full() {
                    best.pop();
                }
                best.put((loss, body));
                sort::by(&mut best, |a, b| a.0.total_cmp(&b.0).then(a.1.angle.total_cmp(&b.1.angle)));
            }
        }
        let mut found = (loss, now);
        for (loss, body) in best {
            let (loss, body) = self.descend(chart, loss, body);
            if loss < found.0 {
                found = (loss, body);
            }
            if loss == 0.0 {
                break;
            }
        }
        if found.0 < loss {
            self.bodies[chart] = found.1;
            self.measure(chart);
        }
    }

    /// A pose in the square for shares (u, v) of the room that is left at this angle.
    fn anywhere(&self, chart: usize, angle: f64, u: f64, v: f64) -> Option<Body> {
        let turn = outline::turn(angle);
        let [low, high] = self.outlines.turned_box(chart, turn);
        let room = DVec2::splat(self.side) - (high - low);
        let at = -low + room * DVec2::new(u, v);
        (room.min_element() >= 0.0).then(|| Body { at: at.as_vec2(), turn: turn.as_vec2(), angle })
    }

    /// The pose moved into the square; none if the chart is larger than that.
    fn inside(&self, chart: usize, body: Body) -> Option<Body> {
        let [low, high] = self.outlines.turned_box(chart, body.turn.as_dvec2());
        let (least, most) = (-low, DVec2::splat(self.side) - high);
        let at = body.at.as_dvec2().max(least).min(most);
        (at.x >= least.x && at.y >= least.y).then(|| Body { at: at.as_vec2(), ..body })
    }

    /// Coordinate descent in x, y, both diagonals and the angle: steps grow by success, halve by failure.
    fn descend(&mut self, chart: usize, mut loss: f32, mut body: Body) -> (f32, Body) {
        let radius = self.outlines.radius[chart];
        let (mut step, mut spin) = (0.03 * self.side, 0.03 * self.side / radius);
        let finest = 0.0004 * self.side;
        let ways = if self.outlines.upright[chart] != 0 { 4.0 } else { 6.0 };
        while step > finest && loss > 0.0 {
            let axis = (self.draw() * ways) as u32;
            let sign = if self.draw() < 0.5 { 1.0 } else { -1.0 };
            let mut better = false;
            for sign in [sign, -sign] {
                let mut next = body;
                match axis {
                    0 => next.at.x += (sign * step) as f32,
                    1 => next.at.y += (sign * step) as f32,
                    2 => next.at += Vec2::splat((sign * step * 0.7) as f32),
                    3 => next.at += Vec2::new((sign * step * 0.7) as f32, (-sign * step * 0.7) as f32),
                    _ => {
                        next.angle += sign * spin;
                        next.turn = outline::turn(next.angle).as_vec2();
                    }
                }
                let Some(next) = self.inside(chart, next) else { continue };
                let value = self.loss(chart, &next, loss);
                if value < loss {
                    (loss, body, better) = (value, next, true);
                    break;
                }
            }
            let factor = if better { 1.1 } else { 0.6 };
            if axis < 4 {
                step *= factor
            } else {
                spin *= factor
            }
            if spin * radius < finest {
                spin = finest / radius;
                step *= if better { 1.0 } else { 0.8 };
            }
        }
        (loss, body)
    }

    /// Weighted overlap of a chart at `body` with all others, or something above `limit` once it is above.
    fn loss(&mut self, chart: usize, body: &Body, limit: f32) -> f32 {
        let count = self.count();
        let mut sum = 0.0;
        for other in 0..count {
            if other != chart && sum <= limit {
                let weight = self.weight[chart * count + other];
                sum += weight * self.depth(chart, body, other, &self.bodies[other].clone(), (limit - sum) / weight);
            }
        }
        sum
    }

    /// Brings a chart's overlaps up to date.
    fn measure(&mut self, chart: usize) {
        let count = self.count();
        for other in 0..count {
            if other != chart {
                let (a, b) = (self.bodies[chart], self.bodies[other]);
                let depth = self.depth(chart, &a, other, &b, f32::INFINITY);
                self.overlap[chart * count + other] = depth;
                self.overlap[other * count + chart] = depth;
            }
        }
    }

    /// Depth of two charts in one another, summed along both borders.
    fn depth(&mut self, a: usize, body_a: &Body, b: usize, body_b: &Body, limit: f32) -> f32 {
        let (shape_a, shape_b) = (&self.fields.shapes[a], &self.fields.shapes[b]);
        let gap = self.gap.within(self.side) as f32 + self.extra[a * self.count() + b];
        let reach = shape_a.radius + shape_b.radius + gap;
        if shape_a.top_count == 0 || shape_b.top_count == 0 || body_a.at.distance_squared(body_b.at) >= reach * reach {
            self.work += 0.25;
            return 0.0;
        }
        let limit = limit / self.fields.spacing;
        let (shapes, bodies, fields) = ([shape_a, shape_b], [body_a, body_b], &self.fields);
        let (depth, work) = widest(Encounter { fields, shapes, bodies, gap, limit });
        self.work += work as f64;
        depth * self.fields.spacing
    }
}
