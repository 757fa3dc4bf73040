//! UVs onto the grid on which they are written, without a flip.
//!
//! Rounding moves a point by half a step, which can turn a sliver over. A face that is not counter-clockwise on the grid
//! moves one of its nodes by the fewest steps that make every face around that node counter-clockwise.
//! The two sides of a slit that stay within [`CLOSED`] steps of each other are put on the same points, so that rounding cannot
//! lay one over the other: a slit that nothing holds open, as between the hole of a plate and its rim, is no seam of the atlas,
//! and the chart has a hole.
//! Limit: a sliver inside a knot of slivers may find no place; the caller counts what is left.

use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::plane::grid::{GRID_BITS, GridPoint, doubled_area};
use glam::DVec2;

/// Farthest that a node is moved, in steps.
const REACH: i32 = 6;
/// Places from 0 to here are inside the square.
const ROOM: i32 = 1 << GRID_BITS;
/// Rounds over all faces that are not counter-clockwise.
const ROUNDS: usize = 12;
/// Sides of a slit this near, in steps, are put together: what thin triangles leave of a slit in a flat face is below a millionth of the
/// square, and readers of six decimals see one place.
const CLOSED: i32 = 16;
/// Copies of a vertex this near, in steps, touch.
const TOGETHER: i32 = 4;

/// Steps along either axis by which copies of a vertex that touch are parted: no reader of six decimals takes them for one.
const PARTED: i32 = 20;

/// Scratch bytes for [`straighten`].
pub const fn straighten_need(nodes: usize, faces: usize) -> usize {
    bytes_for::<u32>(nodes + 2) + bytes_for::<u32>(3 * faces)
}

/// Step of the grid on which packing sees charts of this `area` on a texture of `size` texels: about a 16th of a texel, so
/// that what it finds does not hang on the last bits of a UV. A 64th is too fine for that after files of 9 digits, a 4th
/// shows in the padding. 0 where there is no area.
pub fn packing_step(area: f64, size: u32) -> f64 {
    let step = sqrt(area) / f64::from(size.max(1)) / 16.0;
    // The power of two below: scaling by it rounds nothing.
    if step.is_normal() { f64::from_bits(step.to_bits() & !((1 << (f64::MANTISSA_DIGITS - 1)) - 1)) } else { 0.0 }
}

/// Area of all faces in UV; `uv` stands at corners.
pub fn uv_area(uv: &[DVec2]) -> f64 {
    0.5 * uv.as_chunks::<3>().0.iter().map(|t| (t[1] - t[0]).perp_dot(t[2] - t[0]).max(0.0)).sum::<f64>()
}

/// Puts the two sides of an edge that is cut on the same points where they are parted by hardly anything. `slits` are the node
/// pairs at both ends of each such edge.
pub fn close_slits(points: &mut [GridPoint], slits: impl Iterator<Item = [(u32, u32); 2]>) {
    for ends in slits {
        let near = |(a, b): &(u32, u32)| {
            let (p, q) = (points[*a as usize], points[*b as usize]);
            (p.x() - q.x()).abs() <= CLOSED && (p.y() - q.y()).abs() <= CLOSED
        };
        // One end alone would make a hole's rim touch the border.
        if ends.iter().all(near) {
            ends.iter().for_each(|(a, b)| points[*a.max(b) as usize] = points[*a.min(b) as usize]);
        }
    }
}

/// Parts the copies of a vertex, whether cuts or repair made them, that lie within [`TOGETHER`] steps in one chart though no closed slit joins
/// them, as where both wedges beside a third chart are left of a flat face: a border that touches itself is no border to a reader. `vertex` has
/// that of each node, the same for all copies.
pub fn part_touching(
    points: &mut [GridPoint],
    faces: &[[u32; 3]],
    chart: &[u32],  // (f)
    vertex: &[u32], // (points)
    joined: impl Iterator<Item = [(u32, u32); 2]>,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let mut sets = UnionFind::new(scratch.take::<u32>(points.len())?);
    for (a, b) in joined.filter(|ends| ends.iter().all(|(a, b)| points[*a as usize] == points[*b as usize])).flatten() {
        sets.union(a, b);
    }
    let face = scratch.take::<u32>(points.len())?;
    faces.iter().enumerate().for_each(|(f, nodes)| nodes.iter().for_each(|n| face[*n as usize] = f as u32));
    let order = scratch.take::<u32>(points.len())?;
    order.iter_mut().enumerate().for_each(|(i, n)| *n = i as u32);
    let key = |n: u32| (vertex[n as usize], chart[face[n as usize] as usize]);
    sort::by_key(order, |n| (key(*n), points[*n as usize].x(), points[*n as usize].y(), *n));
    for (i, &b) in order.iter().enumerate() {
        let p = points[b as usize];
        let mut touches = |a: u32| {
            let q = points[a as usize];
            (p.x() - q.x()).abs().max((p.y() - q.y()).abs()) <= TOGETHER && sets.find(a) != sets.find(b)
        };
        // The row is in order of x but for what has been parted since.
        let in_reach = |a: u32| key(a) == key(b) && p.x() - points[a as usize].x() <= TOGETHER + PARTED;
        if order[..i].iter().rev().take_while(|a| in_reach(**a)).any(|a| touches(*a)) {
            // Into a face of its own: it leaves no other chart's place.
            let corners = faces[face[b as usize] as usize].map(|n| points[n as usize]);
            let middle = |of: fn(GridPoint) -> i32| corners.iter().map(|p| of(*p)).sum::<i32>() / 3;
            let step = |to: i32, from: i32| (to - from).clamp(-PARTED, PARTED);
            points[b as usize] =
                GridPoint::new(p.x() + step(middle(GridPoint::x), p.x()), p.y() + step(middle(GridPoint::y), p.y()));
        }
    }
    Ok(())
}

/// Moves nodes until every face is counter-clockwise; returns how many are not in the end.
pub fn straighten(
    points: &mut [GridPoint],
    faces: &[[u32; 3]],
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    let bad = |points: &[GridPoint], f: &[u32; 3]| doubled_area(&f.map(|i| points[i as usize])) <= 0;
    if !faces.iter().any(|f| bad(points, f)) {
        return Ok(0);
    }
    let start = scratch.take::<u32>(points.len() + 2)?;
    let around = scratch.take::<u32>(3 * faces.len())?;
    for n in faces.as_flattened() {
        start[*n as usize + 2] += 1;
    }
    for n in 2..start.len() {
        start[n] += start[n - 1];
    }
    for (c, n) in faces.as_flattened().iter().enumerate() {
        let at = &mut start[*n as usize + 1];
        around[*at as usize] = (c / 3) as u32;
        *at += 1;
    }
    for _ in 0..ROUNDS {
        let mut left = 0;
        for f in faces {
            if !bad(points, f) {
                continue;
            }
            let best = f.iter().filter_map(|n| {
                let range = start[*n as usize] as usize..start[*n as usize + 1] as usize;
                better_place(points, *n, faces, &around[range]).map(|(cost, p)| (cost, *n, p))
            });
            match best.min_by_key(|(cost, n, _)| (*cost, *n)) {
                Some((_, n, p)) => points[n as usize] = p,
                None => left += 1,
            }
        }
        if left == 0 && !faces.iter().any(|f| bad(points, f)) {
            return Ok(0);
        }
    }
    Ok(faces.iter().filter(|f| bad(points, f)).count())
}

/// The nearest place for node `n` at which all faces around it are counter-clockwise, with its squared distance.
fn better_place(points: &[GridPoint], n: u32, faces: &[[u32; 3]], around: &[u32]) -> Option<(i32, GridPoint)> {
    let old = points[n as usize];
    let mut best: Option<(i32, GridPoint)> = None;
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let cost = dx * dx + dy * dy;
            if best.is_some_and(|b| b.0 <= cost) {
                continue;
            }
            let place = GridPoint::new(old.x() + dx, old.y() + dy);
            let inside = (0..=ROOM).contains(&place.x()) && (0..=ROOM).contains(&place.y());
            let fits = inside
                && around.iter().all(|f| {
                    let corners = faces[*f as usize].map(|i| if i == n { place } else { points[i as usize] });
                    doubled_area(&corners) > 0
                });
            if fits {
                best = Some((cost, place));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    fn settled(points: &mut [GridPoint], faces: &[[u32; 3]]) -> usize {
        let mut bytes = vec![0u8; straighten_need(points.len(), faces.len())];
        straighten(points, faces, Scratch::new(&mut bytes)).unwrap()
    }

    #[test]
    fn a_sliver_that_rounding_has_turned_over_is_turned_back() {
        // Node 3 lies one step beyond the edge 0 1 of its sliver.
        let p = |x, y| GridPoint::new(x, y);
        let mut points = [p(0, 0), p(1000, 0), p(500, 800), p(500, -1)];
        let faces = [[0, 1, 3], [0, 3, 2], [3, 1, 2]];
        assert_eq!(settled(&mut points, &faces), 0);
        assert!(faces.iter().all(|f| doubled_area(&f.map(|i| points[i as usize])) > 0));
    }

    #[test]
    fn wedges_that_touch_are_parted_and_those_of_a_closed_slit_are_not() {
        // Two faces of one chart that meet at a point alone, as nodes 0 and 3, copies of one vertex; 0 a bit beside.
        let p = |x, y| GridPoint::new(x, y);
        let (faces, vertex) = ([[0, 1, 2], [3, 4, 5]], [7, 1, 2, 7, 4, 5]);
        let parted = |beside: GridPoint, chart: [u32; 2], joined: &[[(u32, u32); 2]]| {
            let mut points = [beside, p(900, 0), p(900, 900), p(0, 0), p(-900, 0), p(-900, -900)];
            let mut bytes = [0; 256];
            let joined = joined.iter().copied();
            part_touching(&mut points, &faces, &chart, &vertex, joined, Scratch::new(&mut bytes)).unwrap();
            [points[0], points[3]]
        };
        assert_eq!(parted(p(0, 0), [0, 0], &[]), [p(0, 0), p(-20, -20)]);
        assert_eq!(parted(p(0, 0), [0, 1], &[]), [p(0, 0), p(0, 0)]);
        assert_eq!(parted(p(0, 0), [0, 0], &[[(0, 3), (3, 0)]]), [p(0, 0), p(0, 0)]);
        assert_eq!(parted(p(-1, -4), [0, 0], &[]), [p(-1, -4), p(-20, -20)]);
        assert_eq!(parted(p(1, -4), [0, 0], &[]), [p(21, 16), p(0, 0)]); // the later of the row moves
        assert_eq!(parted(p(1, -5), [0, 0], &[]), [p(1, -5), p(0, 0)]);
    }

    #[test]
    fn packing_sees_a_power_of_two_near_a_16th_of_a_texel() {
        let square = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 0.0], [3.0, 3.0], [0.0, 3.0]].map(DVec2::from);
        assert_eq!((uv_area(&square), packing_step(9.0, 1024)), (9.0, 2.0 / 16384.0));
        assert_eq!(
            (packing_step(0.0, 1024), packing_step(f64::NAN, 7), packing_step(f64::INFINITY, 7)),
            (0.0, 0.0, 0.0)
        );
    }

    #[test]
    fn no_node_leaves_the_square() {
        // Flat on the lower edge: the middle node has to go below, or the others up.
        let p = |x, y| GridPoint::new(x, y);
        let mut points = [p(0, 0), p(500, 0), p(1000, 0)];
        assert_eq!(settled(&mut points, &[[0, 1, 2]]), 0);
        assert!(points.iter().all(|p| p.y() >= 0), "{points:?}");
    }

    #[test]
    fn what_cannot_be_straightened_is_counted() {
        let p = |x, y| GridPoint::new(x, y);
        let mut points = [p(0, 0), p(1000, 0), p(500, 800)];
        assert_eq!(settled(&mut points, &[[0, 1, 2], [0, 2, 1]]), 1);
    }

    #[test]
    fn slits_that_hardly_open_are_closed() {
        let mut points = [(5, 5), (90, 5), (6, 4), (91, 3), (5, 95), (6, 70)].map(|(x, y)| GridPoint::new(x, y));
        let before = points;
        close_slits(&mut points, [[(0, 2), (1, 3)], [(1, 3), (4, 5)]].into_iter());
        assert_eq!(points, [before[0], before[1], before[0], before[1], before[4], before[5]]);
        // Where one end stays open, both do.
        let mut points = before;
        close_slits(&mut points, [[(1, 3), (4, 5)]].into_iter());
        assert_eq!(points, before);
    }
}
