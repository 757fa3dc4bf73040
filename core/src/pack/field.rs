//! A chart as a distance field and as points along its border: how deep do two charts lie in one another?
//!
//! The field holds the signed distance to the border (negative inside) at the nodes of a lattice around the chart:
//! exact beside the border, from the nearest segment of a neighbouring node farther off. The points stand at even
//! steps along the border, in runs of up to 8 under one circle, these in runs of 8 under a larger one; since distances change no faster than one moves, one
//! look-up at a run's centre settles most runs. All of it is f32: 1e-7 of the square, far below a texel.
//! Limits: between nodes the field is bilinear, so depth is right to a fraction of a lattice step at corners; the
//! exact check has the last word.

use super::outline::{BorderEdge, Outlines};
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
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
/// Points under one circle, and circles under a larger one: as many as a vector register of AVX2 holds.
const RUN: usize = 8;

/// A run of border points, or of such runs, and a circle around it.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct PointRun {
    pub centre: Vec2,
    pub radius: f32,
    pub first: u32,
    pub count: u32,
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
    first_group: u32,
    pub group_count: u32,
    pub radius: f32,
}

/// The fields and points of all charts.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    pub shapes: &'a [FieldShape], // (k)
    /// Runs of runs.
    groups: &'a [PointRun],
    pub runs: &'a [PointRun],
    pub points: &'a [Vec2],
    nodes: &'a [f32],
    /// Lattice steps a unit.
    scale: f32,
    /// Border length that a point stands for.
    pub spacing: f32,
}

fn points_bound(edge_count: usize, chart_count: usize) -> usize {
    // A loop rounds its number of points up, and has at least 3 edges.
    POINTS + (POINTS_LEAST + 1) * chart_count + edge_count
}

/// Bytes that [`Fields::new`] takes.
pub(super) fn need(edge_count: usize, chart_count: usize) -> usize {
    let points = points_bound(edge_count, chart_count);
    bytes_for::<FieldShape>(chart_count)
        + 2 * bytes_for::<PointRun>(points)
        + bytes_for::<Vec2>(points)
        + bytes_for::<f32>(NODES)
        + bytes_for::<u32>(NODES)
        + bytes_for::<i16>(NODES)
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
        let groups = scratch.take::<PointRun>(bound)?;
        let runs = scratch.take::<PointRun>(bound)?;
        let points = scratch.take::<Vec2>(bound)?;
        let nodes = scratch.take::<f32>(most)?;
        let mut frame = scratch.frame();
        let nearest = frame.take::<u32>(most)?;
        let winding = frame.take::<i16>(most)?;

        let step = lattice_step(outlines, margin, most);
        let length: f64 = outlines.edges.iter().map(|e| e[0].distance(e[1])).sum();
        let spacing = length / POINTS as f64;
        let (mut first_node, mut group_count, mut run_count, mut point_count) = (0, 0, 0, 0);
        for (chart, shape) in shapes.iter_mut().enumerate() {
            let edges = outlines.edges_of(chart);
            let [low, _] = outlines.turned_box(chart, DVec2::X);
            let [columns, rows] = lattice_size(outlines, chart, margin, step);
            let low = low - margin - step;
            let range = first_node..first_node + columns * rows;
            let lattice = Lattice { low, step, columns, rows };
            lattice.fill(&mut nodes[range.clone()], &mut nearest[range.clone()], &mut winding[range], edges);
            let first_run = run_count;
            walk(edges, spacing, runs, &mut run_count, points, &mut point_count);
            let first_group = group_count;
            for first in (first_run..run_count).step_by(RUN) {
                groups[group_count] = around(&runs[..run_count.min(first + RUN)], first);
                group_count += 1;
            }
            *shape = FieldShape {
                low: low.as_vec2(),
                columns: columns as u32,
                last: Vec2::new(columns as f32 - 1.001, rows as f32 - 1.001),
                first_node: first_node as u32,
                first_group: first_group as u32,
                group_count: (group_count - first_group) as u32,
                radius: outlines.radius[chart] as f32,
            };
            first_node += columns * rows;
        }
        let scale = (1.0 / step) as f32;
        Ok(Self { shapes, groups, runs, points, nodes, scale, spacing: spacing as f32 })
    }

    /// Runs of runs of a chart.
    #[inline]
    pub fn groups_of(&self, shape: &FieldShape) -> &'a [PointRun] {
        &self.groups[shape.first_group as usize..][..shape.group_count as usize]
    }

    /// Lattice coordinates of `p`, drawn into the lattice.
    #[inline(always)]
    fn locate(&self, shape: &FieldShape, p: Vec2) -> (Vec2, Vec2) {
        let q = (p - shape.low) * self.scale;
        (q, q.max(Vec2::ZERO).min(shape.last))
    }

    /// Signed distance of `p` from the chart's border, right where it is below the margin: outside the lattice stands
    /// what its rim holds.
    #[inline(always)]
    pub fn distance(&self, shape: &FieldShape, p: Vec2) -> f32 {
        let (_, q) = self.locate(shape, p);
        self.sample(shape, q)
    }

    /// A distance from the chart's border that is surely not more than the true one.
    #[inline(always)]
    pub fn distance_at_least(&self, shape: &FieldShape, p: Vec2) -> f32 {
        let (q, near) = self.locate(shape, p);
        let inside = self.sample(shape, near);
        let beyond = (q - near).abs().max_element() / self.scale;
        if beyond > 0.0 { beyond } else { inside }
    }

    /// How deep points, turned and shifted, lie in the chart grown by `gap`, summed in a fixed order. A full run is one
    /// stretch of plain loops, which `base::vector::wide` compiles for wider registers.
    #[inline(always)]
    pub fn depth(&self, shape: &FieldShape, points: &[Vec2], turn: Vec2, shift: Vec2, gap: f32) -> f32 {
        let Ok(points) = <&[Vec2; RUN]>::try_from(points) else {
            return points.iter().map(|p| (gap - self.distance(shape, turn.rotate(*p) + shift)).max(0.0)).sum();
        };
        let (mut x, mut y, mut at) = ([0.0f32; RUN], [0.0f32; RUN], [0i32; RUN]);
        for i in 0..RUN {
            let p = points[i];
            x[i] = ((turn.x * p.x - turn.y * p.y + shift.x - shape.low.x) * self.scale).max(0.0).min(shape.last.x);
            y[i] = ((turn.y * p.x + turn.x * p.y + shift.y - shape.low.y) * self.scale).max(0.0).min(shape.last.y);
        }
        for i in 0..RUN {
            let (column, row) = (x[i] as i32, y[i] as i32);
            (x[i], y[i]) = (x[i] - column as f32, y[i] - row as f32);
            at[i] = shape.first_node as i32 + row * shape.columns as i32 + column;
        }
        let mut corner = [[0.0f32; RUN]; 4];
        for i in 0..RUN {
            let first = at[i] as usize;
            let Some(cells) = self.nodes.get(first..first + shape.columns as usize + 2) else { continue };
            let [a, b, .., c, d] = cells else { continue };
            (corner[0][i], corner[1][i], corner[2][i], corner[3][i]) = (*a, *b, *c, *d);
        }
        let mut depth = [0.0f32; RUN];
        for i in 0..RUN {
            let low = corner[0][i] + (corner[1][i] - corner[0][i]) * x[i];
            let high = corner[2][i] + (corner[3][i] - corner[2][i]) * x[i];
            depth[i] = (gap - (low + (high - low) * y[i])).max(0.0);
        }
        depth.iter().sum()
    }

    #[inline(always)]
    fn sample(&self, shape: &FieldShape, q: Vec2) -> f32 {
        let Some(([a, b, c, d], fx, fy)) = self.cell(shape, q) else { return 0.0 };
        let (low, high) = (a + (b - a) * fx, c + (d - c) * fx);
        low + (high - low) * fy
    }

    /// The nodes around a place in the lattice, and where it is between them.
    #[inline(always)]
    fn cell(&self, shape: &FieldShape, q: Vec2) -> Option<([f32; 4], f32, f32)> {
        let (x, y) = (q.x as u32, q.y as u32);
        let at = (shape.first_node + y * shape.columns + x) as usize;
        let &[a, b] = self.nodes.get(at..)?.first_chunk()?;
        let &[c, d] = self.nodes.get(at + shape.columns as usize..)?.first_chunk()?;
        Some(([a, b, c, d], q.x - x as f32, q.y - y as f32))
    }
}

/// Walks the loops and leaves a point about every `spacing`: where each of even steps sticks out farthest.
fn walk(
    edges: &[BorderEdge],
    spacing: f64,
    runs: &mut [PointRun],
    run_count: &mut usize,
    points: &mut [Vec2],
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
                runs[*run_count] = PointRun { first: *point_count as u32, ..PointRun::default() };
                *run_count += 1;
            }
            points[*point_count] = tip.as_vec2();
            *point_count += 1;
            runs[*run_count - 1].count += 1;
        }
        at = next;
    }
    for run in runs[..*run_count].iter_mut().rev().take_while(|r| r.radius == 0.0 && r.count > 0) {
        let own = &points[run.first as usize..][..run.count as usize];
        let (low, high) = own.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        run.centre = (low + high) * 0.5;
        // Never quite 0, which marks a run without a circle.
        run.radius = own.iter().map(|p| p.distance(run.centre)).fold(1e-6, f32::max) * (1.0 + 1e-6);
    }
}

/// The runs from `first` on as one, with a circle around theirs.
fn around(runs: &[PointRun], first: usize) -> PointRun {
    let own = &runs[first..];
    let (low, high) =
        own.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), r| (l.min(r.centre), h.max(r.centre)));
    let centre = (low + high) * 0.5;
    let radius = own.iter().map(|r| r.centre.distance(centre) + r.radius).fold(0.0, f32::max) * (1.0 + 1e-6);
    PointRun { centre, radius, first: first as u32, count: own.len() as u32 }
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

    fn fill(&self, nodes: &mut [f32], nearest: &mut [u32], winding: &mut [i16], edges: &[BorderEdge]) {
        nodes.fill(f32::INFINITY);
        winding.fill(0);
        for (i, edge) in edges.iter().enumerate() {
            self.seed(nodes, nearest, edge, i as u32);
            self.cross(winding, edge);
        }
        self.spread(nodes, nearest, edges);
        for y in 0..self.rows {
            let mut turns = 0i16;
            for at in y * self.columns..(y + 1) * self.columns {
                turns = turns.wrapping_add(winding[at]);
                let distance = real::sqrt(nodes[at]);
                nodes[at] = if turns != 0 { -distance } else { distance };
            }
        }
    }

    /// Exact squared distances at the nodes next to a segment.
    fn seed(&self, nodes: &mut [f32], nearest: &mut [u32], edge: &BorderEdge, index: u32) {
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
                if distance < nodes[at] {
                    (nodes[at], nearest[at]) = (distance, index);
                }
            }
        }
    }

    /// Counts a segment's crossings of the lattice rows at the first node to their right.
    fn cross(&self, winding: &mut [i16], edge: &BorderEdge) {
        let [p, q] = edge.map(|p| (p - self.low) / self.step);
        let (low, high, sign) = if p.y <= q.y { (p, q, 1) } else { (q, p, -1) };
        for y in real::ceil(low.y).max(0.0) as usize..=(high.y.max(0.0) as usize).min(self.rows - 1) {
            if low.y <= y as f64 && (y as f64) < high.y {
                let x = low.x + (y as f64 - low.y) / (high.y - low.y) * (high.x - low.x);
                let column = real::ceil(x).max(0.0) as usize;
                if column < self.columns {
                    winding[y * self.columns + column] += sign;
                }
            }
        }
    }

    /// Carries nearest segments from node to node: four sweeps over eight neighbours.
    fn spread(&self, nodes: &mut [f32], nearest: &mut [u32], edges: &[BorderEdge]) {
        let (columns, rows) = (self.columns as isize, self.rows as isize);
        for sweep in 0..2 {
            let forward = sweep == 0;
            let near: [(isize, isize); 4] = [(-1, 0), (-1, -1), (0, -1), (1, -1)];
            for row in 0..rows {
                let y = if forward { row } else { rows - 1 - row };
                for (pass, column) in (0..2).flat_map(|pass| (0..columns).map(move |column| (pass, column))) {
                    let rightward = (pass == 0) == forward;
                    let x = if rightward { column } else { columns - 1 - column };
                    let at = (y * columns + x) as usize;
                    for (dx, dy) in near {
                        let flip = if forward { 1 } else { -1 };
                        let side = if dy == 0 && !rightward { 1 } else { -1 };
                        let (nx, ny) = (x + if dy == 0 { side } else { dx * flip }, y + dy * flip);
                        if (pass == 1 && dy != 0) || !(0..columns).contains(&nx) || !(0..rows).contains(&ny) {
                            continue;
                        }
                        let from = (ny * columns + nx) as usize;
                        if nodes[from] < nodes[at] && nodes[from].is_finite() {
                            let distance =
                                to_segment(self.node(x as usize, y as usize), edges[nearest[from] as usize]) as f32;
                            if distance < nodes[at] {
                                (nodes[at], nearest[at]) = (distance, nearest[from]);
                            }
                        }
                    }
                }
            }
        }
    }
}
