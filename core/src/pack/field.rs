//! A chart as a distance field and as points along its border: how deep do two charts lie in one another?
//!
//! The field holds the signed distance to the border (negative inside) at the nodes of a lattice around the chart:
//! exact beside the border, from the nearest segment of a neighbouring node farther off. The points stand at even
//! steps along the border, in runs of up to 8 under one circle, these in runs of 8 under a larger one; since distances change no faster than one moves, one
//! look-up at a run's centre settles most runs. All of it is f32: 1e-7 of the square, far below a texel.
//! Limits: between nodes the field is bilinear, so depth is right to a fraction of a lattice step at corners; the
//! exact check has the last word.

use super::outline::{BorderEdge, Outlines};
use crate::base::eight::{self, Eight};
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::plane::segment::to_segment;
use glam::{DVec2, Vec2};

/// Lattice nodes for all charts together; with 2^17 the step is about 1/250 of the square's side, four texels of 1024.
pub(super) const NODES: usize = 1 << 17;
/// And for a sketch.
pub(super) const SKETCH_NODES: usize = 1 << 15;
/// Border points for all charts together, and at least so many a chart. With 6144 a look-up budget fills 8 % less, with
/// 2048 1 % less, with 512 about the same.
pub(super) const POINTS: usize = 1024;
const POINTS_LEAST: usize = 24;
/// Points under one circle, and circles under a larger one: what is looked at together.
const RUN: usize = eight::COUNT;

/// One number for each of the points or circles that are looked at together.
type Octet = [f32; RUN];

/// A run of border points.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct PointRun {
    pub first: u32,
    pub count: u32,
}

/// Up to [`RUN`] circles: around runs of points, or around such circles.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Circles {
    x: Octet,
    y: Octet,
    radius: Octet,
    /// What the first is around; those behind it follow.
    pub first: u32,
    pub count: u32,
}

impl Circles {
    fn is_full(&self) -> bool {
        self.count as usize == RUN
    }

    /// Adds a circle, around what stands at `index`.
    fn put(&mut self, (centre, radius): (Vec2, f32), index: usize) {
        let i = self.count as usize;
        if i == 0 {
            self.first = index as u32;
        }
        (self.x[i], self.y[i], self.radius[i]) = (centre.x, centre.y, radius);
        self.count += 1;
    }

    /// A circle around all of them.
    fn around(&self) -> (Vec2, f32) {
        let own = || (0..self.count as usize).map(|i| Vec2::new(self.x[i], self.y[i]));
        let centre = middle(own());
        let radius = own().zip(self.radius).map(|(c, r)| c.distance(centre) + r).fold(0.0, f32::max) * (1.0 + 1e-6);
        (centre, radius)
    }
}

/// A circle around points.
fn around(points: impl Iterator<Item = Vec2> + Clone) -> (Vec2, f32) {
    let centre = middle(points.clone());
    (centre, points.map(|p| p.distance(centre)).fold(1e-6, f32::max) * (1.0 + 1e-6))
}

/// Middle of the box around points.
fn middle(points: impl Iterator<Item = Vec2>) -> Vec2 {
    let (low, high) = points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    (low + high) * 0.5
}

/// A chart's lattice and points.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct FieldShape {
    low: Vec2,
    /// Just below the last node's column and row.
    last: Vec2,
    columns: u32,
    first_node: u32,
    first_top: u32,
    /// 0 where the chart has no border.
    pub top_count: u32,
    pub radius: f32,
}

/// Room for [`NODES`] and one behind them: cells are then found without a look at their number.
type Nodes = [[f32; 2]; NODES + 1];

/// The fields and points of all charts.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    pub shapes: &'a [FieldShape], // (k)
    /// Circles around those of groups.
    tops: &'a [Circles],
    /// Circles around runs.
    pub groups: &'a [Circles],
    pub runs: &'a [PointRun],
    /// Where the points are, and RUN more, that runs can be read whole.
    x: &'a [f32],
    y: &'a [f32],
    /// Signed distance at a node and at the one above it: so a cell is four numbers side by side.
    nodes: &'a Nodes,
    /// Lattice steps a unit.
    scale: f32,
    /// Border length that a point stands for.
    pub spacing: f32,
}

fn points_bound(edge_count: usize, chart_count: usize) -> usize {
    // A loop rounds its number of points up, and has at least 3 edges.
    POINTS + (POINTS_LEAST + 1) * chart_count + edge_count
}

/// Groups of that many runs, and circles around groups: the last of a chart need not be full.
fn circles_bound(run_bound: usize, chart_count: usize) -> [usize; 2] {
    let groups = run_bound / RUN + chart_count;
    [groups, groups / RUN + chart_count]
}

/// Bytes that [`Fields::new`] takes.
pub(super) fn need(edge_count: usize, chart_count: usize) -> usize {
    let points = points_bound(edge_count, chart_count);
    let [groups, tops] = circles_bound(points, chart_count);
    bytes_for::<FieldShape>(chart_count)
        + bytes_for::<Circles>(tops)
        + bytes_for::<Circles>(groups)
        + bytes_for::<PointRun>(points)
        + 2 * bytes_for::<f32>(points + RUN)
        + bytes_for::<[f32; 2]>(NODES + 1)
}

impl<'a> Fields<'a> {
    /// Builds the fields of `most` nodes at the most; `margin` is the distance around a chart that they must cover.
    pub fn new(
        outlines: &Outlines,
        margin: f64,
        most: usize,
        scratch: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let count = outlines.count();
        let shapes = scratch.take::<FieldShape>(count)?;
        let bound = points_bound(outlines.edges.len(), count);
        let [group_bound, top_bound] = circles_bound(bound, count);
        let tops = scratch.take::<Circles>(top_bound)?;
        let groups = scratch.take::<Circles>(group_bound)?;
        let runs = scratch.take::<PointRun>(bound)?;
        let (x, y) = (scratch.take::<f32>(bound + RUN)?, scratch.take::<f32>(bound + RUN)?);
        let nodes = scratch.take_unset::<[f32; 2]>(NODES + 1)?;

        let step = lattice_step(outlines, margin, most);
        let length: f64 = outlines.edges.iter().map(|e| e[0].distance(e[1])).sum();
        let spacing = length / POINTS as f64;
        let (mut first_node, mut top_count, mut group_count, mut run_count, mut point_count) = (0, 0, 0, 0, 0);
        for (chart, shape) in shapes.iter_mut().enumerate() {
            let edges = outlines.edges_of(chart);
            let [low, _] = outlines.turned_box(chart, DVec2::X);
            let [columns, rows] = lattice_size(outlines, chart, margin, step);
            let low = low - margin - step;
            let lattice = Lattice { low, step, columns, rows };
            lattice.fill(&mut nodes[first_node..first_node + columns * rows], edges);
            let (first_top, first_group, first_run) = (top_count, group_count, run_count);
            walk(edges, spacing, runs, &mut run_count, [&mut *x, &mut *y], &mut point_count);
            for (run, index) in runs[first_run..run_count].iter().zip(first_run..) {
                if groups[first_group..group_count].last().is_none_or(Circles::is_full) {
                    group_count += 1;
                }
                let own = x[run.first as usize..].iter().zip(&y[run.first as usize..]).take(run.count as usize);
                groups[group_count - 1].put(around(own.map(|(x, y)| Vec2::new(*x, *y))), index);
            }
            for (group, index) in groups[first_group..group_count].iter().zip(first_group..) {
                if tops[first_top..top_count].last().is_none_or(Circles::is_full) {
                    top_count += 1;
                }
                tops[top_count - 1].put(group.around(), index);
            }
            *shape = FieldShape {
                low: low.as_vec2(),
                columns: columns as u32,
                last: Vec2::new(columns as f32 - 1.001, rows as f32 - 1.001),
                first_node: first_node as u32,
                first_top: first_top as u32,
                top_count: (top_count - first_top) as u32,
                radius: outlines.radius[chart] as f32,
            };
            first_node += columns * rows;
        }
        let scale = (1.0 / step) as f32;
        // As many as were taken.
        let nodes = nodes.first_chunk().ok_or(ScratchTooSmall { need: size_of::<Nodes>(), given: 0 })?;
        Ok(Self { shapes, tops, groups, runs, x, y, nodes, scale, spacing: spacing as f32 })
    }

    /// Circles around those of the groups of a chart.
    #[inline(always)]
    pub fn tops_of(&self, shape: &FieldShape) -> &'a [Circles] {
        &self.tops[shape.first_top as usize..][..shape.top_count as usize]
    }

    /// Which of the circles, moved to where they are beside the chart, may come closer to it than `gap`: a bit for each.
    #[inline(always)]
    pub fn near<E: Eight>(&self, shape: &FieldShape, circles: &Circles, motion: &FieldMotion, gap: f32) -> u32 {
        let (x, y) = self.locate(shape, E::of(&circles.x), E::of(&circles.y), motion);
        let (near_x, near_y) = into_lattice(shape, x, y);
        let inside = self.sample(shape, near_x, near_y);
        // Surely not more than the true distance from the border.
        let beyond = x.less(near_x).abs().max(y.less(near_y).abs()).over(E::all(self.scale));
        let near = beyond.positive_or(inside).below(E::all(gap).plus(E::of(&circles.radius)));
        near & ((1 << circles.count) - 1)
    }

    /// How deep the points of a run, so moved, lie in the chart grown by `gap`, summed in a fixed order: outside the lattice stands
    /// what its rim holds.
    #[inline(always)]
    pub fn depth<E: Eight>(&self, shape: &FieldShape, run: &PointRun, motion: &FieldMotion, gap: f32) -> f32 {
        let first = run.first as usize;
        let [x, y] = [self.x, self.y].map(|of| of.get(first..).and_then(<[f32]>::first_chunk::<RUN>));
        let (Some(x), Some(y)) = (x, y) else {
            return 0.0;
        };
        let (x, y) = self.locate(shape, E::of(x), E::of(y), motion);
        let (x, y) = into_lattice(shape, x, y);
        let depth = E::all(gap).less(self.sample(shape, x, y)).max(E::all(0.0));
        let mut sum = 0.0;
        for depth in depth.times(E::of(&OWN[run.count as usize])).array() {
            sum += depth;
        }
        sum
    }

    /// Lattice coordinates of points, moved.
    #[inline(always)]
    fn locate<E: Eight>(&self, shape: &FieldShape, x: E, y: E, FieldMotion { turn, shift }: &FieldMotion) -> (E, E) {
        let (cos, sin, scale) = (E::all(turn.x), E::all(turn.y), E::all(self.scale));
        let (to_x, to_y) = (cos.times(x).less(sin.times(y)), sin.times(x).plus(cos.times(y)));
        let x = to_x.plus(E::all(shift.x)).less(E::all(shape.low.x)).times(scale);
        let y = to_y.plus(E::all(shift.y)).less(E::all(shape.low.y)).times(scale);
        (x, y)
    }

    /// Signed distances from the chart's border at places in its lattice, right where they are below the margin.
    #[inline(always)]
    fn sample<E: Eight>(&self, shape: &FieldShape, x: E, y: E) -> E {
        let ([column, row], at) = x.cells(y, shape.first_node, shape.columns);
        let mut cells = [[0.0; 4]; RUN];
        for i in 0..RUN {
            let at = at[i] as usize % NODES;
            let ([a, c], [b, d]) = (self.nodes[at], self.nodes[at + 1]);
            cells[i] = [a, c, b, d];
        }
        let [a, c, b, d] = E::columns(cells);
        let (share_x, share_y) = (x.less(column), y.less(row));
        let (low, high) = (a.plus(b.less(a).times(share_x)), c.plus(d.less(c).times(share_x)));
        low.plus(high.less(low).times(share_y))
    }
}

/// Where a chart is, seen from another.
#[derive(Clone, Copy)]
pub(super) struct FieldMotion {
    /// Cosine and sine.
    pub turn: Vec2,
    pub shift: Vec2,
}

/// 1 for each point that a run of so many has.
const OWN: [Octet; RUN + 1] = {
    let mut own = [[0.0; RUN]; RUN + 1];
    let mut count = 1;
    while count <= RUN {
        own[count] = own[count - 1];
        own[count][count - 1] = 1.0;
        count += 1;
    }
    own
};

/// Lattice coordinates drawn into the lattice.
#[inline(always)]
fn into_lattice<E: Eight>(shape: &FieldShape, x: E, y: E) -> (E, E) {
    (x.max(E::all(0.0)).min(E::all(shape.last.x)), y.max(E::all(0.0)).min(E::all(shape.last.y)))
}

/// Walks the loops and leaves a point about every `spacing`: where each of even steps sticks out farthest.
fn walk(
    edges: &[BorderEdge],
    spacing: f64,
    runs: &mut [PointRun],
    run_count: &mut usize,
    [x, y]: [&mut [f32]; 2],
    point_count: &mut usize,
) {
    let total: f64 = edges.iter().map(|e| e[0].distance(e[1])).sum();
    let spacing = spacing.min(total / POINTS_LEAST as f64);
    let mut at = 0;
    while at < edges.len() {
        let next = at + 1 + edges[at..].windows(2).take_while(|w| w[0][1] == w[1][0]).count();
        let length: f64 = edges[at..next].iter().map(|e| e[0].distance(e[1])).sum();
        let steps = real::ceil(length / spacing).max(1.0);
        let step = length / steps;
        let (mut edge, mut walked) = (at, 0.0); // border length before `edge`
        for part in 0..steps as usize {
            let (from, to) = (part as f64 * step, (part + 1) as f64 * step);
            let (tip, after) = outermost(&edges[at..next], edge - at, walked, from, to);
            (edge, walked) = (at + after.0, after.1);
            if part.is_multiple_of(RUN) {
                runs[*run_count] = PointRun { first: *point_count as u32, count: 0 };
                *run_count += 1;
            }
            (x[*point_count], y[*point_count]) = tip.as_vec2().into();
            *point_count += 1;
            runs[*run_count - 1].count += 1;
        }
        at = next;
    }
}

/// The point of the border between lengths `from` and `to` that sticks out farthest; and the edge that holds `to`, with
/// the length before it. `edge` holds `from`, with length `walked` before it. The chart lies to the left, so out is right.
fn outermost(edges: &[BorderEdge], edge: usize, walked: f64, from: f64, to: f64) -> (DVec2, (usize, f64)) {
    let point = |edge: usize, walked: f64, due: f64| {
        let own = edges[edge][0].distance(edges[edge][1]);
        let share = if own > 0.0 { ((due - walked) / own).clamp(0.0, 1.0) } else { 0.0 };
        edges[edge][0].lerp(edges[edge][1], share)
    };
    let start = point(edge, walked, from);
    let (mut last, mut before) = (edge, walked);
    while last + 1 < edges.len() && before + edges[last][0].distance(edges[last][1]) < to {
        before += edges[last][0].distance(edges[last][1]);
        last += 1;
    }
    let end = point(last, before, to);
    let out = DVec2::new(end.y - start.y, start.x - end.x);
    // The middle, unless a corner is farther out than the chord.
    let mut best = (1e-9 * out.length_squared(), start.midpoint(end));
    for corner in edges[edge + 1..=last.max(edge)].iter().map(|e| e[0]) {
        let height = (corner - start).dot(out);
        if height > best.0 {
            best = (height, corner);
        }
    }
    (best.1, (last, before))
}

fn lattice_size(outlines: &Outlines, chart: usize, margin: f64, step: f64) -> [usize; 2] {
    let [low, high] = outlines.turned_box(chart, DVec2::X);
    let size = (high - low + 2.0 * margin) / step;
    [(size.x as usize).saturating_add(4), (size.y as usize).saturating_add(4)]
}

/// The smallest step, by tenths, with which all lattices fit their memory.
fn lattice_step(outlines: &Outlines, margin: f64, most: usize) -> f64 {
    let mut step = 1.0 / 1024.0;
    loop {
        let sizes = (0..outlines.count()).map(|chart| lattice_size(outlines, chart, margin, step));
        if sizes.map(|[c, r]| c.saturating_mul(r)).fold(0, usize::saturating_add) <= most {
            return step;
        }
        step *= 1.1;
    }
}

/// Where the nodes of one chart are.
struct Lattice {
    low: DVec2,
    step: f64,
    columns: usize,
    rows: usize,
}

impl Lattice {
    fn node(&self, x: usize, y: usize) -> DVec2 {
        self.low + DVec2::new(x as f64, y as f64) * self.step
    }

    /// Signed distances at the nodes, and those of the nodes above. On the way there, what is next to a node's squared distance says
    /// which edge that is from, then how often edges turn around the node.
    fn fill(&self, nodes: &mut [[f32; 2]], edges: &[BorderEdge]) {
        nodes.fill([f32::INFINITY, f32::from_bits(u32::MAX)]);
        for (i, edge) in edges.iter().enumerate() {
            self.seed(nodes, edge, i as u32);
        }
        self.spread(nodes, edges);
        nodes.iter_mut().for_each(|n| n[1] = 0.0);
        for edge in edges {
            self.cross(nodes, edge);
        }
        for row in nodes.rows_mut(self.columns) {
            let mut turns = 0.0;
            for node in row {
                turns += node[1];
                let distance = real::sqrt(node[0]);
                node[0] = if turns != 0.0 { -distance } else { distance };
            }
        }
        for at in 0..nodes.len().saturating_sub(self.columns) {
            nodes[at][1] = nodes[at + self.columns][0];
        }
    }

    /// Exact squared distances at the nodes next to a segment.
    fn seed(&self, nodes: &mut [[f32; 2]], edge: &BorderEdge, index: u32) {
        let [p, q] = edge.map(|p| (p - self.low) / self.step);
        let (low, high) = (p.min(q), p.max(q));
        for y in (low.y - 1.0).max(0.0) as usize..=((high.y + 2.0) as usize).min(self.rows - 1) {
            // The part of the segment within a step and a half of this row.
            let ends = if q.y == p.y {
                [p.x, q.x]
            } else {
                let share = |level: f64| ((level - p.y) / (q.y - p.y)).clamp(0.0, 1.0);
                [y as f64 - 1.5, y as f64 + 1.5].map(|level| p.x + (q.x - p.x) * share(level))
            };
            let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            for x in (from - 1.0).max(0.0) as usize..=((to + 2.0) as usize).min(self.columns - 1) {
                let at = y * self.columns + x;
                let distance = to_segment(self.node(x, y), *edge) as f32;
                if distance < nodes[at][0] {
                    nodes[at] = [distance, f32::from_bits(index)];
                }
            }
        }
    }

    /// Counts a segment's crossings of the lattice rows at the first node to their right.
    fn cross(&self, nodes: &mut [[f32; 2]], edge: &BorderEdge) {
        let [p, q] = edge.map(|p| (p - self.low) / self.step);
        let (low, high, sign) = if p.y <= q.y { (p, q, 1.0) } else { (q, p, -1.0) };
        for y in real::ceil(low.y).max(0.0) as usize..=(high.y.max(0.0) as usize).min(self.rows - 1) {
            if low.y <= y as f64 && (y as f64) < high.y {
                let x = low.x + (y as f64 - low.y) / (high.y - low.y) * (high.x - low.x);
                let column = real::ceil(x).max(0.0) as usize;
                if column < self.columns {
                    nodes[y * self.columns + column][1] += sign;
                }
            }
        }
    }

    /// Carries nearest segments from node to node: four sweeps over eight neighbours.
    fn spread(&self, nodes: &mut [[f32; 2]], edges: &[BorderEdge]) {
        let (columns, rows) = (self.columns, self.rows);
        for forward in [true, false] {
            let place = |i: usize, count: usize| if forward { i } else { count - 1 - i };
            for row in 0..rows {
                let y = place(row, rows);
                for column in 0..columns {
                    let at = [place(column, columns), y];
                    if column > 0 {
                        self.carry(nodes, edges, at, [place(column - 1, columns), y]);
                    }
                    if row > 0 {
                        let passed = place(row - 1, rows);
                        for beside in column.saturating_sub(1)..(column + 2).min(columns) {
                            self.carry(nodes, edges, at, [place(beside, columns), passed]);
                        }
                    }
                }
                for column in (1..columns).rev() {
                    self.carry(nodes, edges, [place(column - 1, columns), y], [place(column, columns), y]);
                }
            }
        }
    }

    /// Gives a node the nearest segment of one beside it where that is nearer than its own.
    #[inline(always)]
    fn carry(&self, nodes: &mut [[f32; 2]], edges: &[BorderEdge], [x, y]: [usize; 2], from: [usize; 2]) {
        let at = y * self.columns + x;
        let ([other, nearest], own) = (nodes[from[1] * self.columns + from[0]], nodes[at]);
        if other < own[0] && nearest.to_bits() != own[1].to_bits() {
            let distance = to_segment(self.node(x, y), edges[nearest.to_bits() as usize]) as f32;
            if distance < own[0] {
                nodes[at] = [distance, nearest];
            }
        }
    }
}
