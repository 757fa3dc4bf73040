//! Distances of points and segments.

use crate::base::real::sqrt;
use glam::DVec2;

/// Distance of two segments; 0 where they cross.
pub fn segments_apart(a: [DVec2; 2], b: [DVec2; 2]) -> f64 {
    let side = |e: [DVec2; 2], p: DVec2| (e[1] - e[0]).perp_dot(p - e[0]);
    let crosses =
        |e: [DVec2; 2], f: [DVec2; 2]| side(e, f[0]) * side(e, f[1]) < 0.0 && side(f, e[0]) * side(f, e[1]) < 0.0;
    if crosses(a, b) {
        return 0.0;
    }
    let ends = [to_segment(a[0], b), to_segment(a[1], b), to_segment(b[0], a), to_segment(b[1], a)];
    sqrt(ends.into_iter().fold(f64::INFINITY, f64::min))
}

/// Squared distance of a point from a segment.
pub fn to_segment(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let (along, length) = (b - a, (b - a).length_squared());
    let t = if length > 0.0 { ((p - a).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (p - a - along * t).length_squared()
}
