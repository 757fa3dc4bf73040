//! Borders, hulls and areas of the charts, in a common unit.
//!
//! A chart's border is every edge that its faces use more often one way than the other, so inner edges cancel, holes
//! stay, and the winding number about a point counts the faces above it. Edges stand in the order of a walk around
//! their loops. Coordinates are local: the chart's box is centred on the origin and all charts together have area 1.
//! A chart whose edges all cancel (a face folded on itself) keeps them all. Coordinates that are not finite count as 0.

use super::flat_charts::FlatCharts;
use super::placement::Pose;
use crate::base::real;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::plane::hull::convex_hull;
use core::f64::consts::FRAC_PI_2;
use glam::DVec2;

/// A chart longer than this, over the square root of all area, would decide the side of the square for many others: it may then lie
/// across. Of 118 charts of a rifle, the longest at 1.5, .63 of the square is filled where all stand and .83 where that one does not.
const LONG: f64 = 1.0;
/// Among few charts it decides the side for few: a gear's rim, 2.2 long beside its lid, would fill .21 of the square, and .33 across. A chart
/// alone stands however long it is: the side of a cylinder, a pipe, a belt.
const LONG_OF_FEW: f64 = 1.7;

/// So many charts are many.
const MANY: usize = 8;

/// A directed border edge; the chart lies to its left.
pub(super) type BorderEdge = [DVec2; 2];

/// What packing knows about the charts, in slots by decreasing area.
#[derive(Clone, Copy)]
pub(super) struct Outlines<'a> {
    /// First edge of each chart, and the number of edges.
    pub edge_start: &'a [u32], // (k + 1)
    pub edges: &'a [BorderEdge],
    /// Corners of each chart's hull.
    pub hull_len: &'a [u32], // (k)
    pub hull: &'a [DVec2], // hull of chart i begins at edge_start[i]
    /// Centre of the chart's box, in the caller's units.
    pub centre: &'a [DVec2], // (k)
    /// Largest distance of the border from the centre.
    pub radius: &'a [f64], // (k)
    /// Area of the chart's faces.
    pub area: &'a [f64], // (k)
    /// Whether the chart is turned by quarters only.
    pub upright: &'a [u8], // (k)
    /// Slot of each of the caller's charts.
    pub slot: &'a [u32], // (k)
    /// Local units per unit of the caller.
    pub unit: f64,
}

impl<'a> Outlines<'a> {
    /// Number of charts.
    pub fn count(&self) -> usize {
        self.radius.len()
    }

    /// The first `count` slots alone.
    pub fn leading(&self, count: usize) -> Outlines<'a> {
        Outlines {
            edge_start: &self.edge_start[..count + 1],
            edges: &self.edges[..self.edge_start[count] as usize],
            hull_len: &self.hull_len[..count],
            centre: &self.centre[..count],
            radius: &self.radius[..count],
            area: &self.area[..count],
            upright: &self.upright[..count],
            ..*self
        }
    }

    /// Border edges of a chart; empty where it has no face.
    pub fn edges_of(&self, chart: usize) -> &'a [BorderEdge] {
        &self.edges[self.edge_start[chart] as usize..self.edge_start[chart + 1] as usize]
    }

    /// Corners of the convex hull, counter-clockwise.
    pub fn hull_of(&self, chart: usize) -> &'a [DVec2] {
        let first = self.edge_start[chart] as usize;
        &self.hull[first..first + self.hull_len[chart] as usize]
    }

    /// The angle itself, or the quarter nearest to it where the chart stands upright.
    pub fn allowed(&self, chart: usize, angle: f64) -> f64 {
        if self.upright[chart] != 0 { quarters(angle) * FRAC_PI_2 } else { angle }
    }

    /// Least and largest corner of the chart's box after a turn by (cos, sin).
    pub fn turned_box(&self, chart: usize, turn: DVec2) -> [DVec2; 2] {
        let mut corners = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        for &p in self.hull_of(chart) {
            let q = turn.rotate(p);
            corners = [corners[0].min(q), corners[1].max(q)];
        }
        if corners[0].x <= corners[1].x { corners } else { [DVec2::ZERO; 2] }
    }
}

/// Least and largest corner of all charts together.
pub(super) fn common_box(poses: &[Pose], outlines: &Outlines) -> [DVec2; 2] {
    let mut corners = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    for (chart, pose) in poses.iter().enumerate().filter(|&(i, _)| !outlines.edges_of(i).is_empty()) {
        let [low, high] = outlines.turned_box(chart, turn(pose.angle));
        corners = [corners[0].min(pose.at + low), corners[1].max(pose.at + high)];
    }
    if corners[0].x <= corners[1].x { corners } else { [DVec2::ZERO; 2] }
}

/// Unit vector at `angle`, exact where that is a number of quarters.
pub(super) fn turn(angle: f64) -> DVec2 {
    let count = quarters(angle);
    if count * FRAC_PI_2 == angle {
        return match (count as i64).rem_euclid(4) {
            0 => DVec2::X,
            1 => DVec2::Y,
            2 => DVec2::NEG_X,
            _ => DVec2::NEG_Y,
        };
    }
    DVec2::new(real::cos(angle), real::sin(angle))
}

/// Quarters of a turn nearest to `angle`.
fn quarters(angle: f64) -> f64 {
    real::round(angle / FRAC_PI_2)
}

/// Bytes that [`trace`] takes.
pub(super) fn need(face_count: usize, chart_count: usize) -> usize {
    let edges = face_count * 3;
    kept_need(face_count, chart_count)
        + bytes_for::<[u32; 4]>(edges)
        + bytes_for::<u8>(edges)
        + bytes_for::<DVec2>(edges)
        + bytes_for::<u32>(chart_count)
        + bytes_for::<f64>(chart_count)
}

/// Bytes of the outlines themselves.
fn kept_need(face_count: usize, chart_count: usize) -> usize {
    let edges = face_count * 3;
    bytes_for::<u32>(chart_count + 1)
        + bytes_for::<BorderEdge>(edges)
        + bytes_for::<u32>(chart_count)
        + bytes_for::<DVec2>(edges)
        + bytes_for::<DVec2>(chart_count)
        + bytes_for::<u32>(chart_count)
        + bytes_for::<u8>(chart_count)
        + 2 * bytes_for::<f64>(chart_count)
}

/// Finds borders, hulls and areas. O(f log f).
pub(super) fn trace<'a>(charts: &FlatCharts, scratch: &mut Scratch<'a>) -> Result<Outlines<'a>, ScratchTooSmall> {
    let (edge_count, k) = (charts.faces.len() * 3, charts.count);
    let edge_start = scratch.take::<u32>(k + 1)?;
    let edges = scratch.take::<BorderEdge>(edge_count)?;
    let hull_len = scratch.take::<u32>(k)?;
    let hull = scratch.take::<DVec2>(edge_count)?;
    let centre = scratch.take::<DVec2>(k)?;
    let radius = scratch.take::<f64>(k)?;
    let area = scratch.take::<f64>(k)?;
    let slot = scratch.take::<u32>(k)?;
    let upright = scratch.take::<u8>(k)?;
    let mut frame = scratch.frame();
    let sides = frame.take::<[u32; 4]>(edge_count)?;
    let seen = frame.take::<u8>(edge_count)?;
    let points = frame.take::<DVec2>(edge_count)?;
    let order = frame.take::<u32>(k)?;
    let unsorted = frame.take::<f64>(k)?;

    measure_areas(unsorted, charts);
    order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
    let size = |k: u32| real::for_decision(unsorted[k as usize]);
    sort::by(order, |&a, &b| size(b).total_cmp(&size(a)).then(a.cmp(&b)));
    for (place, &chart) in order.iter().enumerate() {
        slot[chart as usize] = place as u32;
        area[place] = unsorted[chart as usize];
        upright[place] = charts.upright.get(chart as usize).copied().unwrap_or(0);
    }
    let border = cancel_inner(sides, slot, charts);
    walk_loops(edges, edge_start, &mut sides[..border], seen, charts);
    let unit = unit_of(area, &edges[..border]);
    for chart in 0..k {
        let range = edge_start[chart] as usize..edge_start[chart + 1] as usize;
        centre_on_box(&mut edges[range.clone()], &mut centre[chart], unit);
        area[chart] *= unit * unit;
        let points = &mut points[range.clone()];
        points.iter_mut().zip(&edges[range.clone()]).for_each(|(p, e)| *p = e[0]);
        radius[chart] = real::sqrt(points.iter().map(|p| p.length_squared()).fold(0.0, f64::max));
        hull_len[chart] = convex_hull(&mut hull[range.clone()], points) as u32;
        let hull = &hull[range][..hull_len[chart] as usize];
        let longest = match k {
            1 => f64::INFINITY,
            _ if k < MANY => LONG_OF_FEW,
            _ => LONG,
        };
        upright[chart] &= u8::from(hull.iter().all(|p| p.abs().max_element() <= 0.5 * longest));
    }
    Ok(Outlines { edge_start, edges, hull_len, hull, centre, radius, area, upright, slot, unit })
}

fn point(charts: &FlatCharts, vertex: u32) -> DVec2 {
    let p = charts.uv[vertex as usize];
    if p.is_finite() { p } else { DVec2::ZERO }
}

fn measure_areas(area: &mut [f64], charts: &FlatCharts) {
    for (face, &chart) in charts.faces.iter().zip(charts.chart) {
        let [a, b, c] = face.map(|v| point(charts, v));
        if let Some(sum) = area.get_mut(chart as usize) {
            *sum += 0.5 * (b - a).perp_dot(c - a).abs();
        }
    }
}

/// Puts [chart, from, to, 0] of every border edge to the front of `sides`; the answer is their number.
fn cancel_inner(sides: &mut [[u32; 4]], slot: &[u32], charts: &FlatCharts) -> usize {
    let mut count = 0;
    for (face, &chart) in charts.faces.iter().zip(charts.chart) {
        for i in 0..3 {
            let (from, to) = (face[i], face[(i + 1) % 3]);
            if let Some(&chart) = slot.get(chart as usize).filter(|_| from != to) {
                sides[count] = [chart, from.min(to), from.max(to), (from > to) as u32];
                count += 1;
            }
        }
    }
    let sides = &mut sides[..count];
    sort::ascending(sides);
    let (mut out, mut at) = (0, 0);
    while at < count {
        let chart = sides[at][0];
        let end = at + sides[at..].partition_point(|s| s[0] == chart);
        let first = out;
        let (begin, mut from) = (at, at);
        while from < end {
            let key = [sides[from][1], sides[from][2]];
            let to = from + sides[from..end].iter().take_while(|s| [s[1], s[2]] == key).count();
            let back = sides[from..to].iter().filter(|s| s[3] == 1).count();
            let forth = to - from - back;
            let pair = if forth > back { key } else { [key[1], key[0]] };
            for _ in 0..forth.abs_diff(back) {
                sides[out] = [chart, pair[0], pair[1], 0];
                out += 1;
            }
            from = to;
        }
        if out == first {
            // Every edge cancelled: keep them all. `out <= begin`, so nothing unread is overwritten.
            for s in begin..end {
                let [_, a, b, back] = sides[s];
                sides[out] = if back == 1 { [chart, b, a, 0] } else { [chart, a, b, 0] };
                out += 1;
            }
        }
        at = end;
    }
    out
}

/// Orders border edges chart by chart along their loops.
fn walk_loops(
    edges: &mut [BorderEdge],
    edge_start: &mut [u32],
    sides: &mut [[u32; 4]],
    seen: &mut [u8],
    charts: &FlatCharts,
) {
    sort::ascending(sides);
    let (mut count, mut at) = (0, 0);
    for (chart, start) in edge_start.iter_mut().enumerate() {
        *start = count as u32;
        let end = at + sides[at..].partition_point(|s| s[0] as usize == chart);
        let (own, own_seen) = (&sides[at..end], &mut seen[at..end]);
        for first in 0..own.len() {
            let mut here = Some(first);
            while let Some(e) = here.filter(|&e| own_seen[e] == 0) {
                own_seen[e] = 1;
                edges[count] = [point(charts, own[e][1]), point(charts, own[e][2])];
                count += 1;
                let next = own.partition_point(|s| s[1] < own[e][2]);
                here = (next..own.len()).take_while(|&n| own[n][1] == own[e][2]).find(|&n| own_seen[n] == 0);
            }
        }
        at = end;
    }
}

/// Local units per caller's unit: total area 1; where there is next to none, total squared box side 1.
fn unit_of(area: &[f64], edges: &[BorderEdge]) -> f64 {
    let total: f64 = area.iter().sum();
    let mut corners = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    edges.iter().for_each(|e| corners = [corners[0].min(e[0]), corners[1].max(e[0])]);
    let side = (corners[1] - corners[0]).max_element();
    // Needles: an area below 1e-9 of the squared extent would make the unit explode.
    let square = total.max(if side > 0.0 { side * side * 1e-9 } else { 0.0 });
    let unit = 1.0 / real::sqrt(square);
    if unit.is_finite() && unit > 0.0 { unit } else { 1.0 }
}

fn centre_on_box(edges: &mut [BorderEdge], centre: &mut DVec2, unit: f64) {
    let mut corners = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    edges.iter().for_each(|e| corners = [corners[0].min(e[0]), corners[1].max(e[0])]);
    *centre = if edges.is_empty() { DVec2::ZERO } else { 0.5 * (corners[0] + corners[1]) };
    let centre = *centre;
    edges.iter_mut().for_each(|e| *e = e.map(|p| (p - centre) * unit));
}
