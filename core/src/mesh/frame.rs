//! A frame of a mesh's own, so that what is decided does not hang on how the file places it.
//!
//! The origin is the mean of the vertices, the unit twice the distance to the farthest, and the axes point at vertices:
//! the first that is far out, and the first that is far from that axis. Nothing here has the degenerate cases of
//! principal axes (a cube, a sphere), and a mirror image gets another frame only where its vertices have another order.
//! Guarantee: moving, turning and scaling the input changes the result by rounding alone. Limit: the frame follows the
//! order of vertices, as every tie does that is broken by index.

use crate::base::real::sqrt;
use glam::DVec3;

/// A vertex is far out from this share of the largest distance on. No ratio of distances in a regular shape: at such a
/// ratio rounding would choose the vertex.
const FAR: f64 = 0.618;
/// All vertices are on a line where none is farther from it than this share of the unit.
const LINE: f64 = 1e-9;

/// Where a mesh's own frame lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnFrame {
    axes: [DVec3; 3],
    origin: DVec3,
    scale: f64,
}

impl OwnFrame {
    /// A point in the frame.
    pub fn place(&self, p: DVec3) -> DVec3 {
        let d = p - self.origin;
        DVec3::from(self.axes.map(|a| a.dot(d))) * self.scale
    }

    /// Length in the frame of a unit.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The point that [`OwnFrame::place`] takes to `p`, but for rounding.
    pub fn back(&self, p: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        self.origin + (x * p.x + y * p.y + z * p.z) / self.scale
    }
}

/// Fills `out` with `positions` in their own frame: within 1/2 of the origin. Positions that are all equal stay zero; on
/// a line, the two other axes are any. O(n), no scratch.
pub fn to_own_frame(out: &mut [DVec3], positions: &[DVec3]) -> OwnFrame {
    let mean = positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
    out.iter_mut().zip(positions).for_each(|(o, p)| *o = *p - mean);
    let Some((first, radius)) = first_far(out, |d| d) else {
        return OwnFrame { axes: [DVec3::X, DVec3::Y, DVec3::Z], origin: mean, scale: 1.0 };
    };
    let x = first / length(first);
    let aside = |d: DVec3| d - x * x.dot(d);
    let y = match first_far(out, aside) {
        Some((second, width)) if width > LINE * radius => {
            let y = aside(second / width);
            y / length(y)
        }
        _ => {
            let least =
                [DVec3::X, DVec3::Y, DVec3::Z].into_iter().min_by(|a, b| x.dot(*a).abs().total_cmp(&x.dot(*b).abs()));
            let y = aside(least.unwrap_or(DVec3::X));
            y / length(y)
        }
    };
    let z = x.cross(y);
    let scale = 0.5 / radius;
    out.iter_mut().for_each(|d| *d = DVec3::new(x.dot(*d), y.dot(*d), z.dot(*d)) * scale);
    OwnFrame { axes: [x, y, z], origin: mean, scale }
}

/// The first of the points whose `part` is far out, that part, and the largest length of a part; nothing where all are 0.
fn first_far(points: &[DVec3], part: impl Fn(DVec3) -> DVec3) -> Option<(DVec3, f64)> {
    let largest = points.iter().map(|p| length(part(*p))).fold(0.0, f64::max);
    let first = points.iter().map(|p| part(*p)).find(|p| length(*p) >= FAR * largest)?;
    (largest > 0.0).then_some((first, largest))
}

fn length(d: DVec3) -> f64 {
    sqrt(d.dot(d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::hash;
    use approx::assert_abs_diff_eq;
    use std::vec;
    use std::vec::Vec;

    fn framed(positions: &[DVec3]) -> Vec<DVec3> {
        let mut out = vec![DVec3::NAN; positions.len()];
        to_own_frame(&mut out, positions);
        out
    }

    fn cloud() -> Vec<DVec3> {
        let at = |i: u64, k: u64| (hash(3, i, k) % 1000) as f64 / 1000.0;
        (0..50).map(|i| DVec3::new(at(i, 0), 2.0 * at(i, 1), at(i, 2))).collect()
    }

    /// Some rotation: the product of two reflections.
    fn turn(p: DVec3) -> DVec3 {
        let mirror = |p: DVec3, n: DVec3| p - n * (2.0 * p.dot(n) / n.dot(n));
        mirror(mirror(p, DVec3::new(1.0, 2.0, -0.5)), DVec3::new(0.3, -1.0, 4.0))
    }

    #[test]
    fn moving_turning_and_scaling_change_rounding_alone() {
        let here = framed(&cloud());
        // Numbers up to 1e4 carry 1e-12; the axes are known to that over their length of about 1/3 of the unit.
        for (scale, by) in [(1.0, 0.0), (1000.0, 0.0), (1.0, 1e4), (1e-3, 5.0)] {
            let moved: Vec<DVec3> = cloud().iter().map(|p| turn(*p) * scale + by).collect();
            let rounding = 1e-15 * (1.0 + by / scale) * 10.0;
            assert!(framed(&moved).iter().zip(&here).all(|(a, b)| a.abs_diff_eq(*b, rounding)), "{scale} {by}");
        }
        let doubled: Vec<DVec3> = cloud().iter().map(|p| *p * 0.125).collect();
        assert_eq!(framed(&doubled), here);
    }

    #[test]
    fn distances_keep_their_ratio_and_the_farthest_is_a_half_away() {
        let (from, to) = (cloud(), framed(&cloud()));
        let ratio = (to[0] - to[1]).length() / (from[0] - from[1]).length();
        let far = to.iter().map(|p| p.length()).fold(0.0, f64::max);
        assert_abs_diff_eq!(far, 0.5, epsilon = 1e-15);
        assert!(
            (0..49).all(|i| ((to[i] - to[i + 1]).length() - ratio * (from[i] - from[i + 1]).length()).abs() < 1e-14)
        );
    }

    #[test]
    fn points_on_a_line_and_points_in_one_place_are_no_reason_to_fail() {
        let line: Vec<DVec3> = (0..5).map(|i| DVec3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
        let out = framed(&line);
        assert!(out.iter().all(|p| p.is_finite()) && (out[0] - DVec3::X * 0.5).length() < 1e-15, "{out:?}");
        assert_eq!(framed(&[DVec3::ONE; 3]), [DVec3::ZERO; 3]);
        assert_eq!(framed(&[]), []);
    }
}
