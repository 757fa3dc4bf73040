//! Splitting charts that would leave much of the square empty: those far from their convex hull.
//!
//! A chart shaped like a horseshoe cannot be packed well, whatever the packer does. Of all cheapest paths between two
//! places on its border, where cuts inwards begin the cheapest, the one is taken that saves the most hull area for what it costs to be seen; as long as the area
//! is worth the cost. A chart without distortion is a face of the object, flat or unrolled, and stays whole. Cost: samples x O(n log n) a split.

use crate::base::real::{for_decision, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::charts::list::ChartList;
use crate::charts::surface::Surface;
use crate::charts::wedge_paths::WedgePaths;
use crate::mesh::view::NONE;
use crate::plane::hull::{self, hull_area};
use crate::solve::bound::lie_flat;
use core::num::NonZero;
use glam::DVec2;

/// Places on a border between which paths are tried. 16 misses necks; 64 gains 0.3 % of the square for 3 times the work.
const SAMPLES: usize = hull::MOST;
/// Empty hull area, over all area, from which a chart is looked at.
const EMPTY: f64 = 0.02;
/// Hull area, over all area, that one unit of seam cost (over the square root of all area) must save.
pub const PRICE: f64 = 0.12;

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
    let charts = ChartList::new(surface, cut, &mut scratch)?;
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
        let Some(start) = surface.outer_open(cut, faces, uv) else {
            continue;
        };
        let mut len = 0;
        for (slot, c) in border.iter_mut().zip(surface.border(cut, start)) {
            *slot = c;
            len += 1;
        }
        let border = &border[..len];
        let Some(round) = NonZero::new(SAMPLES.min(len)) else { continue };
        let count = round.get();
        let mut places = [0; SAMPLES];
        surface.places_on(cut, border, &mut places[..count]);
        let place = |i: usize| places[i % round];
        let point = |i: usize| uv[place(i) as usize];
        let whole = hull_area(count, point);
        if whole - area < EMPTY * total || count < 4 || lie_flat(faces, uv, surface.rest) {
            continue;
        }
        border.iter().for_each(|c| on_border[node[*c as usize] as usize] = 1);
        let price = |cost: f64| PRICE * cost / sqrt(total);
        // What a path of that cost gains at the most.
        let bound = |cost: f64| (whole - area) / total - price(cost);
        let mut best: Option<(f64, usize, usize)> = None;
        for i in 0..count {
            let from = node[place(i) as usize];
            let least = best.map_or(0.0, |b| b.0);
            paths.grow_inside(surface, cut, node, from, on_border, |_, cost| bound(cost) <= least);
            for j in i + 1..count {
                let cost = paths.cost[node[place(j) as usize] as usize];
                if bound(cost) <= best.map_or(0.0, |b| b.0) {
                    continue;
                }
                let (one, other) =
                    (hull_area(j - i + 1, |k| point(i + k)), hull_area(count - (j - i) + 1, |k| point(j + k)));
                let gain = for_decision((whole - one - other) / total - price(cost));
                if gain > best.map_or(0.0, |b| b.0) {
                    best = Some((gain, i, j));
                }
            }
        }
        if let Some((_, i, j)) = best {
            let end = node[place(j) as usize];
            paths.grow_inside(surface, cut, node, node[place(i) as usize], on_border, |n, _| n == end);
            if paths.via[end as usize] != NONE {
                paths.cut_back(end, cut, changed, node, surface);
                split += 1;
            }
        }
        border.iter().for_each(|c| on_border[node[*c as usize] as usize] = 0);
    }
    Ok(split)
}
