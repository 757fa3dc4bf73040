//! Triangles of a polygon whose corners are points in space.
//!
//! A fan from corner 0 where every triangle of it looks the way of the polygon's Newell normal, or where the polygon is
//! bent so much that no plane tells its triangles: readers that know nothing better fan. Otherwise ears are clipped
//! (Meisters 1975) in the plane of that normal, testing only reflex corners against an ear (Held 2001).
//! Corners on a straight line are kept from making triangles of zero area for as long as another ear exists.
//! Guaranteed for any input, also for repeated corners, crossing sides, a zero normal or NaN: n - 2 triangles in
//! clipping order (before, ear, after), which [`link_diagonals`] relies on.
//! Limits: O(n r) with r reflex corners, so at the worst quadratic: 0.3 s for a comb of 10,000 corners. After
//! [`EFFORT`] point tests (about 12,000 corners, half of them reflex) ears are taken without looking for corners in
//! them: time stays bounded, triangles may overlap.

use super::view::NONE;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use glam::{DVec2, DVec3};

/// Point tests before ears are no longer checked. A comb of 10,000 corners takes 4.4e7, so 2^25 would give up on it;
/// with 2^28 a hostile polygon takes five seconds instead of one.
const EFFORT: usize = 1 << 26;

/// A polygon is bent where a corner is farther from its plane than this share of its farthest corner from corner 0. Scans
/// and models stay below 0.05; a quarter is a roof of 30 degrees over a square.
const BENT: f64 = 0.25;

/// Scratch bytes for [`triangulate`] with `n` corners.
pub const fn triangulate_need(n: usize) -> usize {
    bytes_for::<DVec2>(n).saturating_add(bytes_for::<u32>(n).saturating_mul(4))
}

/// Fills `triangles` (n - 2 entries, none for n < 3) with corners of the polygon whose corners lie at `points`.
///
/// The fan (0, i, i + 1) wherever all its triangles have positive area along the Newell normal, or there is no normal, or
/// the polygon is bent.
/// Returns whether the triangles tile the polygon as far as can be told: all have positive area, and none was clipped
/// off with another corner inside.
pub fn triangulate(
    triangles: &mut [[u32; 3]], // (n - 2)
    points: &[DVec3],           // (n)
    mut scratch: Scratch,
) -> Result<bool, ScratchTooSmall> {
    scratch.require(triangulate_need(points.len()))?;
    if points.len() < 3 {
        return Ok(false);
    }
    let normal = newell(points);
    let positive = fan_is_positive(points, normal);
    if positive || normal == DVec3::ZERO || is_bent(points, normal) {
        for (t, triangle) in triangles.iter_mut().enumerate() {
            *triangle = [0, t as u32 + 1, t as u32 + 2];
        }
        return Ok(positive);
    }
    let plane = scratch.take::<DVec2>(points.len())?;
    project(plane, points, normal);
    Ok(clip(triangles, EarRing::new(plane, &mut scratch)?))
}

/// Joins the sides that the `triangles` of one polygon share: `twin` (3 a triangle) is set to NONE on the polygon's
/// own sides and to `first` + half-edge on diagonals. The triangles stand in clipping order, as from [`triangulate`];
/// `behind` has one entry a corner of the polygon.
pub fn link_diagonals(twin: &mut [u32], triangles: &[[u32; 3]], first: u32, behind: &mut [u32]) {
    behind.fill(NONE); // the half-edge on the other side of the remaining ring's side that starts at a corner
    twin.fill(NONE);
    for (t, &[before, ear, after]) in triangles.iter().enumerate() {
        let h = 3 * t;
        let mut link = |side: usize, other: u32| {
            if other != NONE {
                twin[side] = other;
                twin[(other - first) as usize] = first + side as u32;
            }
        };
        link(h, behind[before as usize]);
        link(h + 1, behind[ear as usize]);
        if t + 1 == triangles.len() {
            link(h + 2, behind[after as usize]);
        }
        behind[before as usize] = first + h as u32 + 2;
    }
}

/// Twice the area of the polygon along its normal (Newell 1972), from the fan at corner 0.
fn newell(points: &[DVec3]) -> DVec3 {
    fan(points).fold(DVec3::ZERO, |sum, area| sum + area)
}

fn fan(points: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let a = points[0];
    points[1..].windows(2).map(move |p| (p[0] - a).cross(p[1] - a))
}

fn fan_is_positive(points: &[DVec3], normal: DVec3) -> bool {
    fan(points).all(|area| area.dot(normal) > 0.0)
}

/// Whether the corners lie far from the plane through their mean.
fn is_bent(points: &[DVec3], normal: DVec3) -> bool {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let reach = points.iter().map(|p| p.distance_squared(points[0])).fold(0.0, f64::max);
    let off = points.iter().map(|p| (*p - mean).dot(normal).abs()).fold(0.0, f64::max);
    off * off > BENT * BENT * reach * normal.length_squared()
}

/// Drops points along `normal` onto the coordinate plane that it crosses most steeply: an affine image of the
/// projection along the normal, and exact for polygons in a coordinate plane.
fn project(plane: &mut [DVec2], points: &[DVec3], normal: DVec3) {
    let size = normal.abs();
    for (out, &p) in plane.iter_mut().zip(points) {
        *out = if size.z >= size.x && size.z >= size.y {
            DVec2::new(p.x - normal.x / normal.z * p.z, p.y - normal.y / normal.z * p.z)
                * DVec2::new(normal.z.signum(), 1.)
        } else if size.x >= size.y {
            DVec2::new(p.y - normal.y / normal.x * p.x, p.z - normal.z / normal.x * p.x)
                * DVec2::new(normal.x.signum(), 1.)
        } else {
            DVec2::new(p.z - normal.z / normal.y * p.y, p.x - normal.x / normal.y * p.y)
                * DVec2::new(normal.y.signum(), 1.)
        };
    }
}

/// How much an ear must fulfil; looser from step to step, when a whole round finds none.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Rule {
    /// Positive area, no other corner in it or on its border.
    Clean,
    /// Positive area, no other corner strictly inside.
    Touching,
    /// No negative area.
    NotNegative,
    /// Anything.
    Any,
}

/// Returns whether the strictest rule was enough.
fn clip(triangles: &mut [[u32; 3]], mut ring: EarRing) -> bool {
    let Some((last, ears)) = triangles.split_last_mut() else { return false };
    let (mut at, mut clean) = (0, true);
    for (t, triangle) in ears.iter_mut().enumerate() {
        let left = ring.plane.len() - t;
        let mut rule = if ring.effort < EFFORT { Rule::Clean } else { Rule::NotNegative };
        let mut tried = 0;
        while !ring.is_ear(at, rule) {
            at = ring.next[at as usize];
            tried += 1;
            if tried == left {
                tried = 0;
                rule = match rule {
                    Rule::Clean => Rule::Touching,
                    Rule::Touching => Rule::NotNegative,
                    _ => Rule::Any,
                };
            }
        }
        clean &= rule == Rule::Clean;
        *triangle = ring.triangle(at);
        ring.remove(at);
        // One corner further than the neighbour: neighbouring ears one after the other would make a narrow fan.
        at = ring.next[triangle[2] as usize];
    }
    *last = ring.triangle(at);
    clean && ring.is_ear(at, Rule::Clean)
}

/// The corners that are left, linked both ways, and the ones among them that can lie inside an ear.
struct EarRing<'a> {
    plane: &'a [DVec2],
    next: &'a mut [u32],
    prev: &'a mut [u32],
    blocking: &'a mut [u32], // reflex and flat corners, any order
    slot: &'a mut [u32],     // where a corner stands among `blocking`, or NONE
    blocking_count: usize,
    effort: usize,
}

impl<'a> EarRing<'a> {
    fn new(plane: &'a [DVec2], scratch: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let n = plane.len();
        let (next, prev) = (scratch.take::<u32>(n)?, scratch.take::<u32>(n)?);
        let (blocking, slot) = (scratch.take::<u32>(n)?, scratch.take_filled::<u32>(n, NONE)?);
        for i in 0..n {
            next[i] = ((i + 1) % n) as u32;
            prev[i] = ((i + n - 1) % n) as u32;
        }
        let mut ring = Self { plane, next, prev, blocking, slot, blocking_count: 0, effort: 0 };
        (0..n as u32).for_each(|i| ring.classify(i));
        Ok(ring)
    }

    fn triangle(&self, ear: u32) -> [u32; 3] {
        [self.prev[ear as usize], ear, self.next[ear as usize]]
    }

    fn area(&self, ear: u32) -> f64 {
        let [a, b, c] = self.triangle(ear).map(|i| self.plane[i as usize]);
        (b - a).perp_dot(c - a)
    }

    /// Files corner `i` as blocking or not.
    fn classify(&mut self, i: u32) {
        let blocks = self.area(i).partial_cmp(&0.0) != Some(core::cmp::Ordering::Greater);
        match (blocks, self.slot[i as usize]) {
            (true, NONE) => {
                self.slot[i as usize] = self.blocking_count as u32;
                self.blocking[self.blocking_count] = i;
                self.blocking_count += 1;
            }
            (false, slot) if slot != NONE => self.unblock(i),
            _ => {}
        }
    }

    fn unblock(&mut self, i: u32) {
        let slot = core::mem::replace(&mut self.slot[i as usize], NONE);
        if slot != NONE {
            self.blocking_count -= 1;
            let moved = self.blocking[self.blocking_count];
            self.blocking[slot as usize] = moved;
            if moved != i {
                self.slot[moved as usize] = slot;
            }
        }
    }

    fn remove(&mut self, ear: u32) {
        let [before, _, after] = self.triangle(ear);
        self.next[before as usize] = after;
        self.prev[after as usize] = before;
        self.unblock(ear);
        self.classify(before);
        self.classify(after);
    }

    fn is_ear(&mut self, ear: u32, rule: Rule) -> bool {
        self.effort += 1;
        let area = self.area(ear);
        match rule {
            Rule::Any => true,
            Rule::NotNegative => area >= 0.0,
            Rule::Clean | Rule::Touching => area > 0.0 && !self.is_blocked(ear, rule == Rule::Clean),
        }
    }

    /// Does a corner lie in the ear's triangle? One at the same place as a corner of the ear does not: the two sides
    /// of the slit that joins a hole to the outline touch everywhere.
    fn is_blocked(&mut self, ear: u32, border_counts: bool) -> bool {
        let [a, b, c] = self.triangle(ear).map(|i| self.plane[i as usize]);
        let blocking = &self.blocking[..self.blocking_count];
        let found = blocking.iter().position(|&i| {
            let p = self.plane[i as usize];
            let sides = [(b - a).perp_dot(p - a), (c - b).perp_dot(p - b), (a - c).perp_dot(p - c)];
            let inside = if border_counts { sides.iter().all(|s| *s >= 0.0) } else { sides.iter().all(|s| *s > 0.0) };
            inside && p != a && p != b && p != c
        });
        self.effort += found.unwrap_or(blocking.len());
        found.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{random, real};
    use approx::assert_abs_diff_eq;
    use std::vec::Vec;
    use std::{assert, assert_eq, vec};

    fn triangulated(points: &[DVec3]) -> Vec<[u32; 3]> {
        tiled(points).0
    }

    fn tiled(points: &[DVec3]) -> (Vec<[u32; 3]>, bool) {
        let mut triangles = vec![[NONE; 3]; points.len().saturating_sub(2)];
        let mut bytes = vec![0u8; triangulate_need(points.len())];
        let clean = triangulate(&mut triangles, points, Scratch::new(&mut bytes)).unwrap();
        assert!(triangles.iter().flatten().all(|&i| (i as usize) < points.len()));
        (triangles, clean)
    }

    fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
        points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
    }

    fn areas(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
        let at = |i: u32| points[i as usize].truncate();
        triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).perp_dot(at(c) - at(a)) / 2.0).collect()
    }

    /// All triangles positive, and together as large as the polygon: with n - 2 of them over its own corners that is
    /// a triangulation.
    fn assert_tiles(points: &[DVec3]) {
        let (triangles, clean) = tiled(points);
        assert!(clean);
        let areas = areas(points, &triangles);
        let whole = newell(points).z / 2.0;
        assert!(areas.iter().all(|a| *a > 0.0), "{areas:?}");
        assert_abs_diff_eq!(areas.iter().sum::<f64>(), whole, epsilon = 1e-12 * whole);
    }

    #[test]
    fn a_bent_polygon_is_a_fan_as_other_readers_have_it() {
        // A square floor and a point far above its far side.
        let points = [(-1., 0., 1.), (1., 0., 1.), (1., 0., -1.), (-1., 0., -1.), (0., 1., -1.)];
        let points = points.map(|(x, y, z)| DVec3::new(x, y, z));
        assert_eq!(triangulated(&points), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        // The same point beside the floor: a plane tells the triangles.
        let flat = points.map(|p| DVec3::new(p.x, 0.01 * p.y, p.z - 0.5 * p.y * (p.x - 3.0)));
        assert!(tiled(&flat).1);
    }

    #[test]
    fn a_convex_polygon_is_the_fan_from_its_first_corner() {
        let n = 300;
        let angle = |i: usize| core::f64::consts::TAU * i as f64 / n as f64;
        let points: Vec<_> = (0..n).map(|i| DVec3::new(3.0, real::cos(angle(i)), real::sin(angle(i)))).collect();
        let fan: Vec<_> = (0..n as u32 - 2).map(|t| [0, t + 1, t + 2]).collect();
        assert_eq!(triangulated(&points), fan);
    }

    #[test]
    fn an_l_is_tiled_from_each_of_its_corners() {
        let mut l = flat(&[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)]);
        for _ in 0..l.len() {
            assert_tiles(&l);
            l.rotate_left(1);
        }
    }

    #[test]
    fn corners_on_a_straight_side_make_no_flat_triangle() {
        let mut sides =
            flat(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.), (3., 2.), (3., 3.), (1., 3.), (0., 3.), (0., 1.)]);
        for _ in 0..sides.len() {
            assert_tiles(&sides);
            sides.rotate_left(1);
        }
    }

    #[test]
    fn a_star_and_a_comb_of_many_teeth_are_tiled() {
        let star: Vec<_> = (0..20)
            .map(|i| (core::f64::consts::TAU * f64::from(i) / 20.0, if i % 2 == 0 { 1.0 } else { 0.3 }))
            .map(|(t, r)| (r * real::cos(t), r * real::sin(t)))
            .collect();
        assert_tiles(&flat(&star));
        let mut comb = vec![(0.0, -1.0), (1000.0, -1.0)];
        comb.extend((0..1000).rev().map(|i| (f64::from(i), f64::from(i % 2) * 50.0)));
        assert_tiles(&flat(&comb));
    }

    #[test]
    fn a_hole_joined_by_a_slit_stays_empty() {
        let points = flat(&[
            (0., 0.),
            (4., 0.),
            (4., 4.),
            (0., 4.),
            (0., 0.), // again the first corner, then in along the slit
            (1., 1.),
            (1., 3.),
            (3., 3.),
            (3., 1.),
            (1., 1.), // and out
        ]);
        let areas = areas(&points, &triangulated(&points));
        assert!(areas.iter().all(|a| *a > 0.0), "{areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 12.0);
    }

    #[test]
    fn random_star_shaped_polygons_in_space_are_tiled() {
        for seed in 0..200 {
            let n = 4 + (random::hash(seed, 0, 0) % 40) as usize;
            let planar: Vec<_> = (0..n)
                .map(|i| {
                    let t = core::f64::consts::TAU * (i as f64 + 0.8 * random::unit_f64(seed, 1, i as u64)) / n as f64;
                    let r = 0.1 + random::unit_f64(seed, 2, i as u64);
                    (r * real::cos(t), r * real::sin(t))
                })
                .collect();
            assert_tiles(&flat(&planar));
            // Seen from any side, the same polygon gives positive triangles along its normal.
            let [u, v] = [DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.48, 0.8, 0.36)];
            let [u, v] = if seed % 2 == 0 { [u, v] } else { [v, u] };
            let points: Vec<_> = planar.iter().map(|&(x, y)| u * x + v * y).collect();
            let normal = u.cross(v);
            for [a, b, c] in triangulated(&points).into_iter().map(|t| t.map(|i| points[i as usize])) {
                assert!((b - a).cross(c - a).dot(normal) > 0.0);
            }
        }
    }

    #[test]
    fn degenerate_polygons_still_give_all_their_triangles() {
        let bow = flat(&[(0., 0.), (2., 2.), (2., 0.), (0., 1.)]);
        let line = flat(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.), (1., 0.)]);
        let spike = flat(&[(0., 0.), (1., 0.), (9., 0.), (1., 0.), (1., 1.)]);
        let nan = vec![DVec3::NAN; 7];
        let huge = flat(&[(1e300, 0.), (0., 1e300), (-1e300, 0.), (0., -1e300), (0., 0.)]);
        for points in [bow, line, spike, nan, huge, vec![DVec3::ONE; 6]] {
            let mut twin = vec![0; 3 * (points.len() - 2)];
            let (triangles, clean) = tiled(&points);
            assert!(!clean);
            link_diagonals(&mut twin, &triangles, 0, &mut vec![0; points.len()]);
            assert_eq!(twin.iter().filter(|t| **t != NONE).count(), 2 * (points.len() - 3));
        }
        assert!(triangulated(&flat(&[(0., 0.), (1., 0.)])).is_empty() && triangulated(&[]).is_empty());
    }

    #[test]
    fn a_polygon_that_crosses_itself_thousands_of_times_ends_soon() {
        let points: Vec<_> = (0..10_000)
            .map(|i| DVec3::new(random::unit_f64(7, 0, i), random::unit_f64(7, 1, i), random::unit_f64(7, 2, i)))
            .collect();
        assert_eq!(triangulated(&points).len(), 9_998);
    }

    #[test]
    fn diagonals_pair_the_two_triangles_that_share_them() {
        let l = flat(&[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)]);
        let triangles = triangulated(&l);
        let mut twin = vec![0; 12];
        link_diagonals(&mut twin, &triangles, 100, &mut [0; 6]);
        let ends = |h: usize| (triangles[h / 3][h % 3], triangles[h / 3][(h + 1) % 3]);
        for (h, &t) in twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
            let t = t as usize - 100;
            assert_eq!((twin[t] as usize, ends(t)), (100 + h, (ends(h).1, ends(h).0)));
        }
        let sides = (0..12).filter(|h| twin[*h] == NONE).map(|h| (ends(h).0 + 1) % 6 == ends(h).1);
        assert_eq!(sides.collect::<Vec<_>>(), [true; 6]);
    }

    #[test]
    fn one_byte_less_is_refused_with_nothing_written() {
        let l = flat(&[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)]);
        let mut triangles = [[NONE; 3]; 4];
        let mut bytes = vec![0u8; triangulate_need(6) - 1];
        assert!(triangulate(&mut triangles, &l, Scratch::new(&mut bytes)).is_err());
        assert_eq!(triangles, [[NONE; 3]; 4]);
    }
}
