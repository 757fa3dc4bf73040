//! Which way charts stand: along their longest straight border, where straight borders are much of what they have.
//!
//! Edges of a chart's border are counted by their direction, a quarter turn taken for none. Where runs of edges within
//! a window of two and a half degrees are a share of the border's length, the chart stands with the longest run along an axis.
//! Sides of slits that nothing holds open are no border. Cost: O(n).

use crate::base::real::{atan2, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::charts::list::ChartList;
use crate::charts::pieces::Pieces;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};
use core::f64::consts::FRAC_PI_2;
use glam::DVec2;

/// Least share of the border's length in one direction or across it.
const LEAST: f64 = 0.2;
/// A straight run shorter than this share of the border's length is none: directions of small triangles agree by chance.
const SHORTEST: f64 = 0.05;
/// Bins of half a degree in a quarter turn.
const BINS: usize = 180;
/// Bins of a window, and what its edges are worth where windows are compared.
const WINDOW: usize = 5;
/// See [`WINDOW`].
const WORTH: [f64; WINDOW] = [1.0, 2.0, 3.0, 2.0, 1.0];
/// Sides of a slit so near each other, over its length, are not parted.
const TOGETHER: f64 = 1e-3;

/// Writes a unit vector along the longest straight border of each chart that has enough of them, zero for the others.
pub fn directions(
    along: &mut [DVec2], // (charts)
    uv: &[DVec2],
    cut: &[u8],
    chart: &[u32], // (f)
    pieces: &Pieces,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    along.fill(DVec2::ZERO);
    for p in 0..pieces.count() {
        let mut frame = scratch.frame();
        let corners = pieces.corners(p);
        let (surface, first) = (pieces.bare_surface(p), corners.start / 3);
        let (uv, cut) = (&uv[corners.clone()], &cut[corners]);
        let seen = frame.take::<u8>(cut.len())?;
        let charts = ChartList::new(&surface, cut, &mut frame)?;
        for k in 0..charts.count() {
            let faces = charts.faces_of(k);
            let border = BorderWalk { uv, cut, surface: &surface };
            if let (Some(face), Some(way)) = (faces.first(), border.straightest(faces)) {
                along[chart[first + *face as usize] as usize] = border.longest_run(faces, way, seen);
            }
        }
    }
    Ok(())
}

/// The borders of a piece's charts.
struct BorderWalk<'b> {
    uv: &'b [DVec2],
    cut: &'b [u8],
    surface: &'b Surface<'b>,
}

impl BorderWalk<'_> {
    /// The half-edge of `c` in the plane, if it is on a border.
    fn side(&self, c: u32) -> Option<DVec2> {
        if !self.surface.is_open(self.cut, c) {
            return None;
        }
        let [a, b] = [c, next(c)].map(|c| self.uv[c as usize]);
        let t = self.surface.twin[c as usize];
        if t != NONE {
            let [d, e] = [next(t), t].map(|c| self.uv[c as usize]);
            let near = TOGETHER * TOGETHER * (b - a).length_squared();
            if (d - a).length_squared() <= near && (e - b).length_squared() <= near {
                return None;
            }
        }
        Some(b - a)
    }

    /// First bin of the window that holds most of the border of `faces`, if that is enough; and the border's length.
    fn straightest(&self, faces: &[u32]) -> Option<Way> {
        let (mut length, mut total) = ([0.0; BINS], 0.0);
        for side in faces.iter().flat_map(|f| 3 * f..3 * f + 3).filter_map(|c| self.side(c)) {
            let l = sqrt(side.length_squared());
            total += l;
            length[bin(side)] += l;
        }
        let near = |way: usize, worth: &[f64; WINDOW]| {
            worth.iter().enumerate().map(|(i, w)| w * length[(way + i) % BINS]).sum::<f64>()
        };
        // The middle counts most, so that the window stands amid what it holds.
        let first = (0..BINS).max_by(|a, b| near(*a, &WORTH).total_cmp(&near(*b, &WORTH)).then(b.cmp(a)))?;
        (total > 0.0 && near(first, &[1.0; WINDOW]) >= LEAST * total).then_some(Way { first, total })
    }

    /// Unit vector from end to end of the longest run of border edges within the window, if such runs are much of the border.
    fn longest_run(&self, faces: &[u32], way: Way, seen: &mut [u8]) -> DVec2 {
        let within = |c: u32| self.side(c).filter(|s| (bin(*s) + BINS - way.first) % BINS < WINDOW);
        let (mut best, mut most, mut sum) = (DVec2::ZERO, 0.0, 0.0);
        for first in faces.iter().flat_map(|f| 3 * f..3 * f + 3) {
            if seen[first as usize] != 0 || !self.surface.is_open(self.cut, first) {
                continue;
            }
            let following = |c: u32| self.surface.following(self.cut, c);
            let ends = |c: u32| within(c).zip(within(following(c))).is_none_or(|(a, b)| !goes_on(a, b));
            let start = self.surface.border(self.cut, first).find(|c| ends(*c)).map_or(first, following);
            let mut run = DVec2::ZERO;
            for c in self.surface.border(self.cut, start) {
                seen[c as usize] = 1;
                run += within(c).unwrap_or(DVec2::ZERO);
                if !ends(c) {
                    continue;
                }
                let length = sqrt(run.length_squared());
                if length >= SHORTEST * way.total {
                    sum += length;
                }
                // Sides of the same length: the first of them.
                if length > most * (1.0 + 1e-9) {
                    (best, most) = (run, length);
                }
                run = DVec2::ZERO;
            }
        }
        if sum >= LEAST * way.total { best / most.max(f64::MIN_POSITIVE) } else { DVec2::ZERO }
    }
}

/// A window of directions, and the length of the border that it was chosen for.
#[derive(Clone, Copy)]
struct Way {
    first: usize,
    total: f64,
}

/// Whether the angle between two sides is less than 60 degrees.
fn goes_on(a: DVec2, b: DVec2) -> bool {
    let dot = a.dot(b);
    dot > 0.0 && 4.0 * dot * dot > a.length_squared() * b.length_squared()
}

/// Bin of the direction of `side`, a quarter turn taken for none.
fn bin(side: DVec2) -> usize {
    let quarters = atan2(side.y, side.x) / FRAC_PI_2 + 2.0;
    // A direction along an axis is amid a bin, not at its border.
    ((quarters * BINS as f64 + 0.5) as usize) % BINS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::topology::twins;
    use crate::mesh::view::MeshView;
    use core::f64::consts::TAU;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// The direction of one chart, a fan round its middle.
    fn direction_of(border: &[DVec2]) -> DVec2 {
        let count = border.len() as u32;
        let positions: Vec<DVec3> = [DVec2::ZERO].iter().chain(border).map(|p| p.extend(0.0)).collect();
        let faces: Vec<[u32; 3]> = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let corners = 3 * faces.len();
        let mut bytes = vec![0; 1 << 16];
        let mut scratch = Scratch::new(&mut bytes);
        let mut twin = vec![NONE; corners];
        twins(&mut twin, mesh, scratch.frame()).unwrap();
        let pieces = Pieces::new(mesh, &twin, &vec![0; corners], &vec![1.0; corners], &mut scratch).unwrap();
        let uv: Vec<DVec2> = (0..corners as u32).map(|c| mesh.position(c).truncate()).collect();
        let mut along = [DVec2::ONE];
        directions(&mut along, &uv, &vec![0; corners], &vec![0; faces.len()], &pieces, scratch).unwrap();
        along[0]
    }

    #[test]
    fn a_box_stands_along_its_longest_side_however_it_was_turned() {
        for degrees in [0.0, 0.3, 30.0, 44.9, 45.0, 89.9, 170.0] {
            let turn = DVec2::from_angle(f64::to_radians(degrees));
            let sides = [[-3.0, -1.0], [0.0, -1.0], [3.0, -1.0], [3.0, 1.0], [1.0, 1.0], [-3.0, 1.0]];
            let along = direction_of(&sides.map(|p| turn.rotate(DVec2::from(p))));
            assert!(along.perp_dot(turn).abs() < 1e-12 && (along.length() - 1.0).abs() < 1e-12, "{degrees}: {along}");
        }
    }

    #[test]
    fn a_round_chart_has_no_direction_and_one_with_a_straight_fifth_has() {
        let round = |count: usize| -> Vec<DVec2> {
            (0..count).map(|i| DVec2::from_angle(0.1 + TAU * i as f64 / count as f64)).collect()
        };
        assert_eq!(direction_of(&round(60)), DVec2::ZERO);
        // A chord over 90 degrees is .23 of what is left of the circle with it.
        let mut chord = round(60);
        chord.drain(1..15);
        let side = (chord[1] - chord[0]).normalize();
        assert!(direction_of(&chord).abs_diff_eq(side, 1e-12));
    }
}
