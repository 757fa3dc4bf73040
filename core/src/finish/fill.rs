//! UVs for corners that no working face stands for: those of dropped faces, repeats and spikes.
//!
//! Such a corner takes a UV that is there already, in an order that adds no seam and no area: of a corner at the same
//! vertex in its own polygon; of the corner before it in its own polygon; for a polygon without any UV, of the two
//! ends of one of its edges in a mapped face; of its vertex elsewhere; of the first mapped corner. A polygon that was
//! dropped whole thus has two different UVs at the most, and no area. The one exception: of several triangles (a, b, a)
//! that double one vertex, all but the first have their second a elsewhere on the line of their edge, on the grid exactly, so
//! that they have no area either. With UVs of its own vertex it would share the edge (a, a) with the others, and V - E + F
//! of the chart would not be 1.

use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::mesh::polygons::{Counts, Polygons};
use crate::mesh::view::{NONE, next};
use crate::mesh::working::Working;
use crate::plane::grid::{GRID_BITS, GridPoint};
use glam::DVec2;

/// Scratch bytes for [`fill_dropped`].
pub const fn fill_dropped_need(counts: &Counts) -> usize {
    let Counts { corners, vertices, .. } = *counts;
    bytes_for::<u8>(corners)
        .saturating_add(bytes_for::<u32>(vertices).saturating_mul(3))
        .saturating_add(bytes_for::<[u32; 4]>(corners))
}

/// Fills the entries of `corner_uv` (one an input corner) that no entry of `working.corner_source` names, from the
/// others, which hold the atlas. Returns how many it filled. O(n + d log d) for d corners of dropped polygons.
pub fn fill_dropped(
    corner_uv: &mut [DVec2], // (c)
    input: &Polygons,
    working: &Working,
    mut scratch: Scratch,
) -> Result<usize, ScratchTooSmall> {
    scratch.require(fill_dropped_need(&input.counts()))?;
    let mapped = scratch.take::<u8>(input.corners.len())?;
    working.corner_source.iter().for_each(|c| mapped[*c as usize] = 1);
    let filled = mapped.iter().filter(|m| **m == 0).count();
    if filled == 0 {
        return Ok(0);
    }
    let at_vertex = scratch.take_filled::<u32>(input.positions.len(), NONE)?;
    for &c in working.corner_source.iter().rev() {
        at_vertex[vertex(input, working, c) as usize] = c;
    }
    let in_polygon = scratch.take_filled::<u32>(input.positions.len(), NONE)?;
    let doubled = scratch.take::<u32>(input.positions.len())?; // triangles so far that double a vertex
    let wanted = scratch.take::<[u32; 4]>(input.corners.len())?;
    let wanted = find_edges(wanted, mapped, input, working);

    let any = corner_uv[working.corner_source[0] as usize];
    let covered = input.polygons().next().map_or(0..0, |first| first.start as usize..last_corner(input));
    (0..input.corners.len()).filter(|c| mapped[*c] == 0 && !covered.contains(c)).for_each(|c| corner_uv[c] = any);
    for polygon in input.polygons() {
        let own = |c: &u32| mapped[*c as usize] == 1;
        if polygon.clone().all(|c| own(&c)) {
            continue;
        }
        if polygon.clone().any(|c| own(&c)) {
            complete(corner_uv, polygon, mapped, in_polygon, input, working);
        } else {
            collapse(corner_uv, polygon.clone(), wanted, at_vertex, any, input, working);
            part_doubles(corner_uv, polygon, doubled, input, working);
        }
    }
    Ok(filled)
}

fn last_corner(input: &Polygons) -> usize {
    input.polygon_start.last().map_or(0, |end| *end as usize)
}

fn vertex(input: &Polygons, working: &Working, corner: u32) -> u32 {
    working.welded[input.corners[corner as usize] as usize]
}

/// The ends of the side of a polygon that begins at `corner`.
fn side(input: &Polygons, working: &Working, polygon: &core::ops::Range<u32>, corner: u32) -> [u32; 2] {
    let after = if corner + 1 == polygon.end { polygon.start } else { corner + 1 };
    [corner, after].map(|c| vertex(input, working, c))
}

/// Fills `wanted` with the edges of polygons without any UV (low vertex, high vertex), sorted, and with the corners of
/// the lowest mapped face at each: at its low and its high vertex, or NONE.
fn find_edges<'a>(wanted: &'a mut [[u32; 4]], mapped: &[u8], input: &Polygons, working: &Working) -> &'a [[u32; 4]] {
    let mut count = 0;
    for polygon in input.polygons().filter(|p| p.clone().all(|c| mapped[c as usize] == 0)) {
        for corner in polygon.clone() {
            let [a, b] = side(input, working, &polygon, corner);
            wanted[count] = [a.min(b), a.max(b), NONE, NONE];
            count += 1;
        }
    }
    let wanted = &mut wanted[..count];
    sort::ascending(wanted);
    for h in (0..working.corner_source.len() as u32).filter(|_| count > 0) {
        let sources = [h, next(h)].map(|c| working.corner_source[c as usize]);
        let [a, b] = sources.map(|c| vertex(input, working, c));
        let low_first = if a < b { sources } else { [sources[1], sources[0]] };
        let key = [a.min(b), a.max(b)];
        if let Some(edge) = find(wanted, key)
            && wanted[edge][2] == NONE
        {
            wanted[edge][2..].copy_from(&low_first);
        }
    }
    wanted
}

/// The first entry with these ends.
fn find(wanted: &[[u32; 4]], ends: [u32; 2]) -> Option<usize> {
    let at = wanted.partition_point(|w| [w[0], w[1]] < ends);
    wanted.get(at).is_some_and(|w| [w[0], w[1]] == ends).then_some(at)
}

/// A polygon that has some UVs: a corner without takes that of a corner at its vertex, else of the one before it.
fn complete(
    corner_uv: &mut [DVec2],
    polygon: core::ops::Range<u32>,
    mapped: &[u8],
    in_polygon: &mut [u32], // NONE before and after: the polygon's mapped corner at each vertex
    input: &Polygons,
    working: &Working,
) {
    let own = |c: &u32| mapped[*c as usize] == 1;
    let vertex = |c: u32| vertex(input, working, c) as usize;
    polygon.clone().rev().filter(own).for_each(|c| in_polygon[vertex(c)] = c);
    let mut before = polygon.clone().rev().find(own).map_or(DVec2::ZERO, |c| corner_uv[c as usize]);
    for c in polygon.clone() {
        let same = in_polygon[vertex(c)];
        if !own(&c) {
            corner_uv[c as usize] = if same == NONE { before } else { corner_uv[same as usize] };
        }
        before = corner_uv[c as usize];
    }
    polygon.filter(own).for_each(|c| in_polygon[vertex(c)] = NONE);
}

/// A polygon without any UV: both ends of its first edge that a mapped face has, and the corner before for the rest.
fn collapse(
    corner_uv: &mut [DVec2],
    polygon: core::ops::Range<u32>,
    wanted: &[[u32; 4]],
    at_vertex: &[u32],
    any: DVec2,
    input: &Polygons,
    working: &Working,
) {
    let edge = polygon.clone().find_map(|c| {
        let [a, b] = side(input, working, &polygon, c);
        let found = wanted[find(wanted, [a.min(b), a.max(b)])?];
        (found[2] != NONE).then_some(found)
    });
    let fallback = polygon.clone().find_map(|c| match at_vertex[vertex(input, working, c) as usize] {
        NONE => None,
        c => Some(corner_uv[c as usize]),
    });
    let mut before = edge.map_or(fallback.unwrap_or(any), |e| corner_uv[e[2] as usize]);
    for c in polygon {
        let v = vertex(input, working, c);
        before = match edge {
            Some([low, _, corner, _]) if v == low => corner_uv[corner as usize],
            Some([_, high, _, corner]) if v == high => corner_uv[corner as usize],
            _ => before,
        };
        corner_uv[c as usize] = before;
    }
}

/// Moves the second of two corners at one vertex of a triangle along the line to the third, to another place each time that
/// the vertex is doubled.
fn part_doubles(
    corner_uv: &mut [DVec2],
    polygon: core::ops::Range<u32>,
    doubled: &mut [u32],
    input: &Polygons,
    working: &Working,
) {
    if polygon.len() != 3 {
        return;
    }
    let at = |i: u32| vertex(input, working, polygon.start + i);
    let uv = |i: u32| corner_uv[(polygon.start + i) as usize];
    let pairs = [(0, 1, 2), (0, 2, 1), (1, 2, 0)];
    let Some((i, j, k)) = pairs.into_iter().find(|(i, j, k)| at(*i) == at(*j) && at(*i) != at(*k)) else { return };
    let count = &mut doubled[at(i) as usize];
    *count += 1;
    if *count > 1 {
        let [from, to] = [i, k].map(|i| GridPoint::snap(uv(i), GRID_BITS));
        corner_uv[(polygon.start + j) as usize] = on_line(from, to, *count).uv(GRID_BITS);
    }
}

/// A point of the grid on the line of two others: the `nth` part of the way, or where the edge holds no other point of the
/// grid, so many of its lengths beyond its end or before its start, as the square allows; else its end.
fn on_line(from: GridPoint, to: GridPoint, nth: u32) -> GridPoint {
    let way = [to.x() - from.x(), to.y() - from.y()];
    let steps = greatest_common_divisor(way[0].unsigned_abs(), way[1].unsigned_abs());
    let at = |n: i64| {
        let [x, y] = way.map(|d| i64::from(d) / i64::from(steps.max(1)) * n);
        [i64::from(from.x()) + x, i64::from(from.y()) + y]
    };
    let is_inside = |n: &i64| at(*n).iter().all(|x| (0..=1 << GRID_BITS).contains(x));
    let (steps, nth) = (i64::from(steps), i64::from(nth));
    let n = match steps {
        0 => 0,
        1 => [nth, 1 - nth].into_iter().find(is_inside).unwrap_or(1),
        _ => ((steps + nth / 2) / nth).clamp(1, steps - 1),
    };
    let [x, y] = at(n);
    GridPoint::new(x as i32, y as i32)
}

/// Euclid's; that of 0 and 0 is 0.
fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    let (mut a, mut b) = (a, b);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::repair::{Facing, repair, repair_need};
    use crate::plane::grid::doubled_area;
    use glam::DVec3;
    use std::vec;
    use std::vec::Vec;

    /// Gives every mapped corner the x and y of its vertex plus its working vertex's number times 100, so that charts
    /// are told apart, and fills the rest.
    fn filled(positions: &[DVec3], corners: &[u32], polygon_start: &[u32]) -> (Vec<DVec2>, usize) {
        let input = Polygons { positions, corners, polygon_start, kept_uv: None };
        let mut bytes = vec![0u8; repair_need(&input.counts())];
        let (working, _) = repair(&input, Facing::Turned, &mut Scratch::new(&mut bytes)).unwrap();
        let mut uv = vec![DVec2::NAN; corners.len()];
        for (c, &source) in working.corner_source.iter().enumerate() {
            let here = positions[corners[source as usize] as usize].truncate();
            uv[source as usize] = here + 100.0 * f64::from(working.component[c / 3]);
        }
        let mut bytes = vec![0u8; fill_dropped_need(&input.counts())];
        let count = fill_dropped(&mut uv, &input, &working, Scratch::new(&mut bytes)).unwrap();
        assert!(uv.iter().all(|uv| uv.is_finite()));
        (uv, count)
    }

    fn points() -> Vec<DVec3> {
        [(0., 0.), (1., 0.), (1., 1.), (0., 1.), (5., 5.), (6., 5.), (5., 6.)]
            .map(|(x, y)| DVec3::new(x, y, 0.0))
            .into()
    }

    #[test]
    fn a_mesh_without_dropped_faces_is_left_alone() {
        assert_eq!(filled(&points(), &[0, 1, 2, 3], &[0, 4]).1, 0);
    }

    #[test]
    fn a_dropped_face_takes_both_uvs_from_the_face_at_its_edge() {
        // Triangles 4-5-6 and 0-1-2, and one that has vertex 2 twice, along 1-2.
        let (uv, count) = filled(&points(), &[4, 5, 6, 0, 1, 2, 2, 1, 2], &[0, 3, 6, 9]);
        assert_eq!((count, &uv[6..]), (3, &[uv[5], uv[4], uv[5]][..]));
    }

    #[test]
    fn of_triangles_that_double_one_vertex_only_the_first_has_an_edge_of_no_length() {
        // Vertex 1 is doubled along 1-2, then along 1-0, then along 1-2 again.
        let corners = [0, 1, 2, 1, 2, 1, 0, 1, 1, 2, 1, 1];
        let (uv, count) = filled(&points(), &corners, &[0, 3, 6, 9, 12]);
        let third = GridPoint::snap(uv[1].lerp(uv[2], 1.0 / 3.0), GRID_BITS).uv(GRID_BITS);
        assert_eq!(
            (count, &uv[3..]),
            (9, &[uv[1], uv[2], uv[1], uv[0], uv[1], (uv[0] + uv[1]) * 0.5, uv[2], uv[1], third][..])
        );
    }

    #[test]
    fn a_vertex_doubled_along_an_edge_without_another_point_of_the_grid_stays_on_its_line() {
        let place = |from: [i32; 2], to: [i32; 2], nth| {
            let [from, to] = [from, to].map(|[x, y]| GridPoint::new(x, y));
            let point = on_line(from, to, nth);
            assert_eq!(doubled_area(&[from, point, to]), 0);
            [point.x(), point.y()]
        };
        assert_eq!(place([10, 10], [16, 13], 2), [14, 12]);
        assert_eq!(place([10, 10], [13, 14], 2), [16, 18]);
        assert_eq!(place([10, 10], [13, 14], 4), [22, 26]);
        assert_eq!(place([10, 10], [3, 5], 2), [17, 15], "beyond the end is beyond the square");
        assert_eq!(place([0, 1], [1 << 24, 2], 2), [1 << 24, 2], "so is before the start");
        assert_eq!(place([7, 7], [7, 7], 2), [7, 7]);
    }

    #[test]
    fn a_face_between_two_charts_has_no_area() {
        // 1-4-1-5: an edge to the other chart and back.
        let (uv, count) = filled(&points(), &[0, 1, 2, 4, 5, 6, 1, 4, 1, 5, 4, 4, 4, 3, 3], &[0, 3, 6, 10, 13, 15]);
        assert_eq!((count, &uv[6..]), (9, &[uv[1], uv[1], uv[1], uv[1], uv[3], uv[3], uv[3], uv[0], uv[0]][..]));
    }

    #[test]
    fn a_repeated_corner_has_the_uv_of_its_vertex_and_a_spike_that_of_its_foot() {
        let (uv, count) = filled(&points(), &[0, 1, 1, 2, 4, 2, 3], &[0, 7]);
        assert_eq!((count, uv[2], uv[4], uv[5]), (3, uv[1], uv[3], uv[3]));
    }

    #[test]
    fn one_byte_less_is_refused_with_nothing_written() {
        let positions = points();
        let input =
            Polygons { positions: &positions, corners: &[0, 1, 2, 1, 1], polygon_start: &[0, 3, 5], kept_uv: None };
        let mut bytes = vec![0u8; repair_need(&input.counts())];
        let (working, _) = repair(&input, Facing::Turned, &mut Scratch::new(&mut bytes)).unwrap();
        let mut uv = [DVec2::ONE; 5];
        let mut bytes = vec![0u8; fill_dropped_need(&input.counts()) - 1];
        assert!(fill_dropped(&mut uv, &input, &working, Scratch::new(&mut bytes)).is_err());
        assert_eq!(uv, [DVec2::ONE; 5]);
    }
}
