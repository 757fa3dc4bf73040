//! Exact predicates of points in the plane, by adaptive expansions (Shewchuk 1997); and an area, which is rounded.

use glam::DVec2;
use robust::{Coord, orient2d};

/// Positive where `c` lies to the left of the line from `a` to `b`, negative to the right, 0 on it. The sign is exact.
pub(super) fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
}

/// Whether two counter-clockwise triangles have an inner point in common. Exact: two convex shapes have none if and only if a
/// side of one of them has the whole of the other on its outer side.
pub(super) fn interiors_meet(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    let parts = |one: &[DVec2; 3], other: &[DVec2; 3]| {
        (0..3).any(|k| other.iter().all(|p| turn(one[k], one[(k + 1) % 3], *p) <= 0.0))
    };
    !parts(a, b) && !parts(b, a)
}

/// Whether `p` lies in a counter-clockwise triangle or on its border.
pub(super) fn holds([a, b, c]: [DVec2; 3], p: DVec2) -> bool {
    turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
}

/// Twice the area that a ring of points goes around, rounded.
pub(super) fn doubled_area(points: impl Iterator<Item = DVec2> + Clone) -> f64 {
    let next = points.clone().cycle().skip(1);
    points.zip(next).map(|(a, b)| a.perp_dot(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_that_share_a_side_or_a_point_do_not_overlap_and_a_last_bit_more_does() {
        let [o, x, y, xy] = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        assert!(!interiors_meet(&[o, x, y], &[x, xy, y]));
        assert!(!interiors_meet(&[o, x, y], &[x, x + DVec2::X, xy]));
        let inside = DVec2::new(0.5, 0.5f64.next_down());
        assert!(interiors_meet(&[o, x, y], &[inside, xy, y]));
        assert!(interiors_meet(&[o, x, y], &[o, x, y]));
        assert!(holds([o, x, y], o) && holds([o, x, y], DVec2::splat(0.5)) && !holds([o, x, y], xy));
    }
}
