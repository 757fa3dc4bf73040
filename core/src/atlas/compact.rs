//! Splitting charts that would leave much of the square empty: those far from their convex hull.
//!
//! A chart shaped like a horseshoe cannot be packed well, whatever the packer does. Of all cheapest paths between two
//! places on its border, the one is taken that saves the most hull area for what it costs to be seen; as long as the area
//! is worth the cost. Cost: samples x O(n log n) a split.

use super::charts::Charts;
use super::surface::Surface;
use super::wedge_paths::{Go, WedgePaths};
use crate::base::real::{cos, for_decision, sin, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::mesh::view::NONE;
use core::f64::consts::TAU;
use core::num::NonZero;
use glam::DVec2;

/// Places on a border between which paths are tried. 16 misses necks; 64 gains 0.3 % of the square for 3 times the work.
const SAMPLES: usize = 32;
/// Empty hull area, over all area, from which a chart is looked at.
const EMPTY: f64 = 0.02;
/// Hull area, over all area, that one unit of seam cost (over the square root of all area) must save.
pub const PRICE: f64 = 0.093;

/// Scratch bytes for [`split_bulky`].
pub fn compact_need(faces: usize) -> usize {
    let corners = 3 * faces;
    6 * bytes_for::<u32>(corners) + 3 * bytes_for::<f64>(corners) + 5 * bytes_for::<u32>(faces + 2)
}

/// Splits each chart once where that saves enough of its hull; marks the faces beside the cuts and returns how many.
pub fn split_bulky(
    cut: &mut [u8],
    changed: &mut [u8],
    uv: &[DVec2],
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let charts = Charts::new(surface, cut, &mut scratch)?;
    let node = scratch.take::<u32>(surface.mesh.corner_count())?;
    let nodes = surface.wedges(cut, node);
    let border = scratch.take::<u32>(surface.mesh.corner_count())?;
    let on_border = scratch.take::<u8>(nodes)?;
    let mut paths = WedgePaths::new(node, nodes, &mut scratch)?;
    let total: f64 = surface.rest.iter().map(|r| r.area).sum();
    let mut split = 0;
    for k in 0..charts.count() {
        let faces = charts.faces_of(k);
        let area: f64 = faces.iter().map(|f| surface.rest[*f as usize].area).sum();
        let Some(start) = faces.iter().flat_map(|f| 3 * f..3 * f + 3).find(|c| surface.is_open(cut, *c)) else {
            continue;
        };
        let mut len = 0;
        for (slot, c) in border.iter_mut().zip(surface.border(cut, start)) {
            *slot = c;
            len += 1;
        }
        let border = &border[..len];
        let Some(samples) = NonZero::new(SAMPLES.min(len)) else { continue };
        let count = samples.get();
        let place = |i: usize| border[i % samples * len / samples];
        let point = |i: usize| uv[place(i) as usize];
        let whole = hull_area(count, point);
        if whole - area < EMPTY * total || count < 4 {
            continue;
        }
        border.iter().for_each(|c| on_border[node[*c as usize] as usize] = 1);
        let mut best: Option<(f64, usize, usize)> = None;
        for i in 0..count {
            let from = node[place(i) as usize];
            grow(&mut paths, from, cut, node, on_border, surface);
            for j in i + 1..count {
                let cost = paths.cost[node[place(j) as usize] as usize];
                let price = PRICE * cost / sqrt(total);
                let bound = (whole - area) / total - price;
                if best.is_some_and(|b| bound <= b.0) || bound <= 0.0 {
                    continue;
                }
                let (one, other) =
                    (hull_area(j - i + 1, |k| point(i + k)), hull_area(count - (j - i) + 1, |k| point(j + k)));
                let gain = for_decision((whole - one - other) / total - price);
                if gain > best.map_or(0.0, |b| b.0) {
                    best = Some((gain, i, j));
                }
            }
        }
        if let Some((_, i, j)) = best {
            grow(&mut paths, node[place(i) as usize], cut, node, on_border, surface);
            let end = node[place(j) as usize];
            if paths.via[end as usize] != NONE {
                paths.cut_back(end, cut, changed, node, surface);
                split += 1;
            }
        }
        border.iter().for_each(|c| on_border[node[*c as usize] as usize] = 0);
    }
    Ok(split)
}

/// Area of the convex hull of points, from the extreme ones in [`SAMPLES`] directions: low by less than 1 % where they are
/// on a circle.
pub fn hull_of(points: impl Iterator<Item = DVec2>) -> f64 {
    let directions: [DVec2; SAMPLES] = core::array::from_fn(|i| {
        let angle = TAU * i as f64 / SAMPLES as f64;
        DVec2::new(cos(angle), sin(angle))
    });
    let mut extreme = [(f64::NEG_INFINITY, DVec2::ZERO); SAMPLES];
    for p in points {
        for (e, direction) in extreme.iter_mut().zip(directions) {
            let along = p.dot(direction);
            if along > e.0 {
                *e = (along, p);
            }
        }
    }
    hull_area(SAMPLES, |i| extreme[i].1)
}

/// Cheapest paths from one border node through the inside of its chart.
fn grow(paths: &mut WedgePaths, from: u32, cut: &[u8], node: &[u32], on_border: &mut [u8], surface: &Surface) {
    paths.grow(
        surface,
        cut,
        node,
        core::iter::once(from),
        |edge, _| surface.cost[edge as usize],
        |n, _| if n != from && on_border[n as usize] != 0 { Go::Around } else { Go::On },
    );
}

/// Area of the convex hull of at most [`SAMPLES`] + 1 points (Andrew 1979).
fn hull_area(count: usize, point: impl Fn(usize) -> DVec2) -> f64 {
    let mut points = heapless::Vec::<DVec2, { SAMPLES + 2 }>::new();
    for i in 0..count.min(SAMPLES + 2) {
        points.push(point(i)).ok();
    }
    sort::by(&mut points, |a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut twice = 0.0;
    for side in [false, true] {
        let mut hull = heapless::Vec::<DVec2, { SAMPLES + 2 }>::new();
        for k in 0..points.len() {
            let p = points[if side { points.len() - 1 - k } else { k }];
            while hull.len() > 1
                && (hull[hull.len() - 1] - hull[hull.len() - 2]).perp_dot(p - hull[hull.len() - 1]) <= 0.0
            {
                hull.pop();
            }
            hull.push(p).ok();
        }
        twice += hull.windows(2).map(|e| e[0].perp_dot(e[1])).sum::<f64>();
    }
    0.5 * twice
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_many_points_is_that_of_their_extremes() {
        let grid = (0..100).map(|i| DVec2::new(f64::from(i % 10), f64::from(i / 10)));
        assert_eq!(hull_of(grid), 81.0);
        assert_eq!(hull_of(core::iter::empty()), 0.0);
        // A polygon of n = 32 corners covers n / TAU sin(TAU / n) = .9936 of its circle.
        let circle = (0..3200).map(|i| DVec2::new(cos(TAU * f64::from(i) / 3200.0), sin(TAU * f64::from(i) / 3200.0)));
        let share = hull_of(circle) / (0.5 * TAU);
        assert!((share - 0.9936).abs() < 1e-3, "{share}");
    }

    #[test]
    fn the_hull_of_a_square_and_its_middle_is_the_square() {
        let points = [(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y));
        assert_eq!(hull_area(5, |i| points[i]), 4.0);
        assert_eq!(hull_area(1, |i| points[i]), 0.0);
        assert_eq!(hull_area(2, |i| points[i]), 0.0);
    }
}
