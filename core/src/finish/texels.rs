//! Straight borders on the edges of texels.
//!
//! Where a border of a placed chart runs along an axis, its coordinate becomes that of the nearest texel edge; what lies between two such
//! borders is stretched or shrunk evenly along the axis, by less than a texel, and what lies beyond moves with the last. Where two borders
//! want the same edge the longer has it. A chart stays as it is where that turns a face over or breaks the bound that held.
//! Guarantee: no point moves by more than half a texel, so the gap between two charts closes by one at the most. Limit: edges are hit exactly
//! where the texture's side is a power of two, within a grid step elsewhere. Cost: O(n log n).

use crate::base::real::round;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::sort;
use crate::mesh::view::next;
use crate::solve::bound::{Strain, flat_area};
use crate::solve::energy::Rest;
use glam::DVec2;

/// A border edge within so much of a texel, from end to end, is straight; borders so near each other are one.
const STRAIGHT: f64 = 0.02;
/// A border is as long as so many texels at least.
const LEAST: f64 = 2.0;
/// Borders of a chart along one axis at the most, the longest.
const MOST: usize = 64;

/// What is laid on texels.
pub struct Texels<'t> {
    /// Texture side.
    pub size: u32,
    /// Bound on the mean symmetric Dirichlet energy over 4.
    pub bound: f64,
    /// Nodes of each face.
    pub node: &'t [[u32; 3]], // (f)
    /// Chart of each face.
    pub chart: &'t [u32], // (f)
    /// Shapes in space.
    pub rest: &'t [Rest], // (f)
}

/// A straight border: where it is, and where it goes.
#[derive(Clone, Copy, Debug, Default)]
struct Knot {
    from: f64,
    to: f64,
}

impl Texels<'_> {
    /// Moves `placed`, the nodes in the unit square; `is_open` says whether the edge of a corner is a border, `scale` how much larger than
    /// at its own area a chart was placed. Returns how many charts moved.
    pub fn lay(
        &self,
        placed: &mut [DVec2],
        charts: usize,
        is_open: impl Fn(usize) -> bool,
        scale: impl Fn(u32) -> f64,
        mut scratch: Scratch,
    ) -> Result<usize, ScratchTooSmall> {
        let faces = scratch.take::<u32>(self.chart.len())?;
        faces.iter_mut().enumerate().for_each(|(f, slot)| *slot = f as u32);
        sort::by_key(faces, |f| (self.chart[*f as usize], *f));
        let old = scratch.take::<DVec2>(placed.len())?;
        let moved = scratch.take::<u8>(placed.len())?;
        let borders = scratch.take::<[f64; 2]>(3 * self.chart.len())?;
        let flat = flat_area(self.rest);
        let touch = STRAIGHT / f64::from(self.size.max(1));
        let mut all = self.strain(faces, placed, flat, &scale);
        let (mut count, mut left) = (0, &*faces);
        for k in 0..charts as u32 {
            let own = left.partition_point(|f| self.chart[*f as usize] <= k);
            let (own, others) = left.split_at_checked(own).unwrap_or((left, &[]));
            left = others;
            let [across, up] = [0, 1].map(|axis| self.knots(own, axis, placed, borders, &is_open));
            if across.is_empty() && up.is_empty() {
                continue;
            }
            let before = self.strain(own, placed, flat, &scale);
            let nodes = || own.iter().flat_map(|f| self.node[*f as usize]).map(|n| n as usize);
            for n in nodes() {
                if moved[n] == 0 {
                    moved[n] = 1;
                    old[n] = placed[n];
                    placed[n] = DVec2::new(warp(&across, touch, placed[n].x), warp(&up, touch, placed[n].y));
                }
            }
            let now = self.strain(own, placed, flat, &scale);
            let after = Strain {
                stretch: all.stretch - before.stretch + now.stretch,
                shrink: all.shrink - before.shrink + now.shrink,
                area: all.area,
            };
            // Where nothing has area to speak of there is no mean, and no bound.
            let held = all.area <= 0.0 || after.mean() <= self.bound.max(all.mean());
            if held && own.iter().all(|f| self.area(*f, placed) > 0.0 || self.area(*f, old) <= 0.0) {
                all = after;
                count += 1;
            } else {
                nodes().for_each(|n| placed[n] = old[n]);
            }
        }
        Ok(count)
    }

    /// Twice the area of a face.
    fn area(&self, f: u32, placed: &[DVec2]) -> f64 {
        let [a, b, c] = self.node[f as usize].map(|n| placed[n as usize]);
        (b - a).perp_dot(c - a)
    }

    fn strain(&self, faces: &[u32], placed: &[DVec2], flat: f64, scale: impl Fn(u32) -> f64) -> Strain {
        let mut strain = Strain::default();
        for f in faces.iter().map(|f| *f as usize).filter(|f| self.rest[*f].area > flat) {
            let size = 1.0 / scale(self.chart[f]).max(f64::MIN_POSITIVE);
            strain.add(&self.rest[f], self.node[f].map(|n| placed[n as usize] * size));
        }
        strain
    }

    /// The straight borders of a chart across an axis (0: x), by rising place. `borders` is memory for one a corner.
    fn knots(
        &self,
        faces: &[u32],
        axis: usize,
        placed: &[DVec2],
        borders: &mut [[f64; 2]],
        is_open: impl Fn(usize) -> bool,
    ) -> heapless::Vec<Knot, MOST> {
        let texel = 1.0 / f64::from(self.size.max(1));
        let mut count = 0;
        for c in faces.iter().flat_map(|f| 3 * f..3 * f + 3).filter(|c| is_open(*c as usize)) {
            let at = |c: u32| placed[self.node.as_flattened()[c as usize] as usize].to_array();
            let (a, b) = (at(c), at(next(c)));
            let length = (a[1 - axis] - b[1 - axis]).abs();
            if (a[axis] - b[axis]).abs() <= STRAIGHT * texel {
                borders[count] = [0.5 * (a[axis] + b[axis]), length];
                count += 1;
            }
        }
        let borders = &mut borders[..count];
        sort::by(borders, |a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        // Edges of one border: its place is their mean.
        let mut runs = 0usize;
        for i in 0..count {
            let [place, length] = borders[i];
            match runs.checked_sub(1).map(|last| borders[last]) {
                Some([before, sum]) if place - before <= STRAIGHT * texel => {
                    let whole = (sum + length).max(f64::MIN_POSITIVE);
                    borders[runs - 1] = [before + (place - before) * (length / whole), whole];
                }
                _ => {
                    borders[runs] = [place, length];
                    runs += 1;
                }
            }
        }
        let borders = &mut borders[..runs];
        sort::by(borders, |a, b| b[1].total_cmp(&a[1]).then(a[0].total_cmp(&b[0])));
        let mut knots = heapless::Vec::<Knot, MOST>::new();
        for [from, _] in borders.iter().filter(|b| b[1] >= LEAST * texel).take(MOST) {
            let to = round(from / texel) * texel;
            let fits = |k: &Knot| if k.from < *from { k.to < to } else { k.to > to };
            if knots.iter().all(fits) {
                knots.put(Knot { from: *from, to });
            }
        }
        sort::by(&mut knots, |a, b| a.from.total_cmp(&b.from));
        knots
    }
}

/// Where a coordinate goes that lies among these borders, or within `touch` on one.
fn warp(knots: &[Knot], touch: f64, x: f64) -> f64 {
    let above = knots.partition_point(|k| k.from < x);
    let (low, high) = (above.checked_sub(1).and_then(|i| knots.get(i)), knots.get(above));
    if let Some(k) = [low, high].into_iter().flatten().find(|k| (k.from - x).abs() <= touch) {
        return k.to;
    }
    match (low, high) {
        (Some(low), Some(high)) => low.to + (x - low.from) * ((high.to - low.to) / (high.from - low.from)),
        (Some(k), None) | (None, Some(k)) => x + (k.to - k.from),
        (None, None) => x,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// Rectangles of two faces each, from corner to corner, laid on a texture of 16 texels.
    fn laid(rectangles: &[[DVec2; 2]], bound: f64) -> (Vec<DVec2>, usize) {
        let (mut placed, mut node, mut chart, mut rest) = (vec![], vec![], vec![], vec![]);
        for (k, [low, high]) in (0u32..).zip(rectangles) {
            let at = [*low, DVec2::new(high.x, low.y), *high, DVec2::new(low.x, high.y)];
            placed.extend(at);
            for t in [[0, 1, 2], [0, 2, 3]] {
                node.push(t.map(|i| 4 * k + i));
                chart.push(k);
                rest.push(Rest::new(t.map(|i| DVec3::from((at[i as usize], 0.0))), 0.0));
            }
        }
        let texels = Texels { size: 16, bound, node: &node, chart: &chart, rest: &rest };
        // All sides but the diagonals.
        let is_open = |c: usize| c % 6 != 2 && c % 6 != 3;
        let mut bytes = vec![0; 1 << 16];
        let scratch = Scratch::new(&mut bytes);
        let count = texels.lay(&mut placed, rectangles.len(), is_open, |_| 1.0, scratch).unwrap();
        (placed.iter().map(|p| *p * 16.0).collect(), count)
    }

    #[test]
    fn sides_go_to_the_nearest_edges_of_texels() {
        let at = |x: f64, y: f64| DVec2::new(x, y) / 16.0;
        let (placed, count) = laid(&[[at(1.2, 1.6), at(6.9, 9.4)]], 1.1);
        assert_eq!(count, 1);
        assert_abs_diff_eq!(placed[0].distance(DVec2::new(1.0, 2.0)), 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(placed[2].distance(DVec2::new(7.0, 9.0)), 0.0, epsilon = 1e-12);
    }

    #[test]
    fn a_chart_stays_where_the_bound_would_break_or_both_sides_want_one_edge() {
        let at = |x: f64, y: f64| DVec2::new(x, y) / 16.0;
        let strip = [at(1.5, 1.0), at(4.4, 14.0)]; // 2.9 texels wide, 2 on the edges
        assert_eq!(laid(&[strip], 1.001).1, 0);
        assert_eq!(laid(&[strip], 1.2).1, 1);
        let (placed, _) = laid(&[[at(1.6, 1.0), at(2.4, 14.0)]], 10.0);
        assert_abs_diff_eq!(placed[1].x - placed[0].x, 0.8, epsilon = 1e-12);
    }
}
