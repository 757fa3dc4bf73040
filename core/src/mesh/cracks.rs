//! Cracks: borders that lie along one another within a tolerance become one, in the working copy.
//!
//! Exporters of CAD tessellate each patch by itself, so that two patches share an edge of which neither knows. A border edge
//! finds the border edge whose ends lie nearest to its own (`partners`); two that find one another are closed by welding their
//! ends (`joints`), the narrowest cracks first, round after round.
//! Guaranteed: only ends of border edges are welded, and each lies within the tolerance of the vertex that stands for it, and within
//! a share of the two edges' lengths; no polygon loses a corner or turns over, and no edge gets a third face.
//! Limits: a crack between different numbers of vertices stays open where they have no partner: no vertex is made.

use super::joints::{Joints, joints_need};
use super::open_side::{OpenSide, border};
use super::partners::{Partners, partners_need};
use super::polygons::{Counts, Polygons};
use super::unit_box::UnitBox;
use crate::base::real::{pow, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use glam::DVec3;

/// Which borders are welded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Weld {
    /// Those whose vertices are at equal places.
    #[default]
    Equal,
    /// Those within this share of the diagonal of the mesh's box, up to half of the shorter edge.
    Within(f64),
    /// Those within a tolerance that is found in the mesh: well below its edges, where the widths of its cracks end.
    Auto,
}

/// How much of the shorter of two edges the crack between them may be wide, under [`Weld::Within`].
const OF_LENGTH: f64 = 0.5;
/// The same under [`Weld::Auto`]. On a tessellated engine of 13,308 border edges 10^-6 to 10^-2 of the length hold 11,000, then there are
/// few up to .03; sheets with two sides and slots begin there.
const OF_LENGTH_AUTO: f64 = 0.02;
/// Widths that [`Weld::Auto`] chooses between, in diagonals. f32 coordinates are not exact to less than the least.
const NARROWEST: f64 = 1e-6;
/// See [`NARROWEST`]: the engine's cracks end at 4e-5.
const WIDEST: f64 = 1e-3;
/// Cracks end where this share of them is found in the next two octaves.
const FEW: f64 = 0.02;
/// More rounds close nothing on meshes as they occur: 3 to 5 do.
const ROUNDS: usize = 16;

/// What [`close_cracks`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Closed {
    /// Border edges before.
    pub border_edges: usize,
    /// The tolerance, over the diagonal.
    pub tolerance: f64,
    /// How wide the closed cracks are on the mean, over the largest side of the box.
    pub width: f64,
}

/// Scratch bytes for [`close_cracks`].
pub(super) fn close_cracks_need(counts: &Counts) -> usize {
    let &Counts { vertices, corners, .. } = counts;
    bytes_for::<[u32; 3]>(corners)
        .saturating_add(bytes_for::<OpenSide>(corners))
        .saturating_add(joints_need(vertices, corners))
        .saturating_add(partners_need(corners))
}

/// Lowers entries of `same` (the lowest vertex at the place of each) to the lowest vertex of those that are welded.
pub(super) fn close_cracks(
    same: &mut [u32],
    input: &Polygons,
    unit: &UnitBox,
    weld: Weld,
    mut scratch: Scratch,
) -> Result<Closed, ScratchTooSmall> {
    scratch.require(close_cracks_need(&input.counts()))?;
    let place = |v: u32| unit.place(input.positions.get(v as usize).copied().unwrap_or_default());
    let diagonal = diagonal(same, place);
    let sides = scratch.take::<[u32; 3]>(input.corners.len())?;
    let edges = scratch.take::<OpenSide>(input.corners.len())?;
    let count = border(edges, sides, same, input);
    let edges = &mut edges[..count];
    let none = Closed { border_edges: count, ..Closed::default() };
    let (share, of_length) = match weld {
        Weld::Equal => return Ok(none),
        Weld::Within(share) => (share.clamp(0.0, 1.0), OF_LENGTH),
        Weld::Auto => (WIDEST, OF_LENGTH_AUTO),
    };
    if count < 2 || share.is_nan() || share <= 0.0 {
        return Ok(none);
    }
    let mut joints = Joints::new(same, input, edges, &mut scratch)?;
    let mut partners = Partners::new(edges, place, share * diagonal, &mut scratch)?;
    let mut tolerance = share;
    if weld == Weld::Auto {
        partners.find(edges, place, &joints, OF_LENGTH);
        tolerance = ending(&partners, diagonal);
    }
    if tolerance > 0.0 {
        let widest = tolerance * diagonal;
        partners.narrow(widest);
        for _ in 0..ROUNDS {
            partners.find(edges, place, &joints, of_length);
            if !partners.each_pair(|e, f| joints.close(edges[e], edges[f], widest, place)) {
                break;
            }
        }
    }
    let width = joints.tell(same, place);
    Ok(Closed { border_edges: count, tolerance, width })
}

/// Of the box of all vertices that a corner names.
fn diagonal(same: &[u32], place: impl Fn(u32) -> DVec3) -> f64 {
    let named = (0..same.len() as u32).filter(|v| same[*v as usize] == *v).map(place);
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = named.fold(start, |(low, high), p| (low.min(p), high.max(p)));
    let d = high - low;
    sqrt(d.dot(d))
}

/// Where the widths of cracks end: the first octave after which few pairs are as far apart as it and the next. 0 where there
/// are none. Widths are counted over lengths up to [`OF_LENGTH`], so that what is no crack is seen too.
fn ending(partners: &Partners, diagonal: f64) -> f64 {
    let within = |share: f64| partners.pairs().filter(|(_, width)| *width <= share * diagonal).count();
    let mut best = (f64::INFINITY, 0.0);
    for octave in 0..10 {
        let share = NARROWEST * pow(2.0, f64::from(octave));
        let (narrow, wide) = (within(share), within(4.0 * share));
        if narrow == 0 || share > WIDEST {
            continue;
        }
        let beyond = (wide - narrow) as f64 / narrow as f64;
        if beyond <= FEW {
            return share;
        }
        if beyond < best.0 {
            best = (beyond, share);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    /// A strip of two rows of squares, the rows `width` apart along y; the third point of the upper row stands `step` aside.
    fn rows(width: f64, step: f64) -> (Vec<DVec3>, Vec<u32>, Vec<u32>) {
        let row = |y: f64, d: f64| (0..5).map(move |i| DVec3::new(f64::from(i) + if i == 2 { d } else { 0.0 }, y, 0.0));
        let points: Vec<DVec3> =
            row(0.0, 0.0).chain(row(1.0, 0.0)).chain(row(1.0 + width, step)).chain(row(2.0 + width, 0.0)).collect();
        let squares = |low: u32| (0..4).flat_map(move |i| [low + i, low + i + 1, low + i + 6, low + i + 5]);
        let corners: Vec<u32> = squares(0).chain(squares(10)).collect();
        (points, corners, (0..=8).map(|p| 4 * p).collect())
    }

    fn closed(points: &[DVec3], corners: &[u32], starts: &[u32], weld: Weld) -> (Vec<u32>, Closed) {
        let input = Polygons { positions: points, corners, polygon_start: starts, kept_uv: None };
        let mut same: Vec<u32> = (0..points.len() as u32).collect();
        let mut bytes = vec![0; close_cracks_need(&input.counts())];
        let unit = UnitBox::new(points.iter().copied());
        let found = close_cracks(&mut same, &input, &unit, weld, Scratch::new(&mut bytes)).unwrap();
        (same, found)
    }

    #[test]
    fn a_crack_within_the_tolerance_is_closed_and_a_wider_one_is_not() {
        let (points, corners, starts) = rows(1e-4, 2e-4);
        let whole: Vec<u32> = (0..10).chain(5..10).chain(15..20).collect();
        let (same, found) = closed(&points, &corners, &starts, Weld::Within(1e-4));
        assert_eq!((same, found.border_edges), (whole.clone(), 20));
        assert_eq!(closed(&points, &corners, &starts, Weld::Auto).0, whole);
        assert_eq!(closed(&points, &corners, &starts, Weld::Within(1e-6)).0, Vec::from_iter(0..20));
        assert_eq!(closed(&points, &corners, &starts, Weld::Equal).0, Vec::from_iter(0..20));
    }

    #[test]
    fn nothing_to_close_is_nothing() {
        let (points, corners, starts) = rows(0.3, 0.0);
        let (same, found) = closed(&points, &corners, &starts, Weld::Auto);
        assert_eq!((same, found.tolerance), (Vec::from_iter(0..20), 0.0));
        for share in [f64::NAN, -1.0, 0.0] {
            assert_eq!(closed(&points, &corners, &starts, Weld::Within(share)).0, Vec::from_iter(0..20));
        }
    }

    #[test]
    fn no_face_is_closed_upon_itself_whatever_the_tolerance() {
        // A strip that is thinner than the tolerance, and a triangle whose tip is.
        let points = [(0., 0.), (1., 0.), (1., 1e-5), (0., 1e-5), (2., 0.), (2., 1.), (2.00001, 1.)];
        let points = points.map(|(x, y)| DVec3::new(x, y, 0.0));
        let corners = [0, 1, 2, 3, 4, 5, 6];
        let (same, _) = closed(&points, &corners, &[0, 4, 7], Weld::Within(0.1));
        assert_eq!(same, [0, 1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn of_three_borders_in_one_place_two_are_joined() {
        // Three triangles fan out of nearly one edge.
        let mut points = vec![];
        for k in 0..3 {
            let (s, c) = [(0.0, 1.0), (0.9, -0.5), (-0.9, -0.5)][k];
            let off = 1e-5 * k as f64;
            points.extend([DVec3::new(0., 0., off), DVec3::new(0., off, 1.), DVec3::new(s, c, 0.5)]);
        }
        let (same, _) = closed(&points, &Vec::from_iter(0..9), &[0, 3, 6, 9], Weld::Within(1e-3));
        let welded = same.iter().enumerate().filter(|(v, s)| *v as u32 != **s).count();
        assert_eq!(welded, 2, "{same:?}");
    }

    #[test]
    fn one_byte_less_is_refused_with_nothing_written() {
        let (points, corners, starts) = rows(1e-4, 0.0);
        let input = Polygons { positions: &points, corners: &corners, polygon_start: &starts, kept_uv: None };
        let mut same = vec![7; points.len()];
        let mut bytes = vec![0; close_cracks_need(&input.counts()) - 1];
        let unit = UnitBox::new(points.iter().copied());
        assert!(close_cracks(&mut same, &input, &unit, Weld::Auto, Scratch::new(&mut bytes)).is_err());
        assert!(same.iter().all(|s| *s == 7));
    }
}
