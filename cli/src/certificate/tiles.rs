//! The triangles of a polygon in UV, by cutting ears off. O(n^2) for polygons as they occur.
//!
//! Where they are found, they are counter-clockwise and their borders sum up to the polygon's. That they do not overlap one
//! another is for the search for overlaps to see.

use super::planar::{holds, turn};
use glam::DVec2;

/// Triangles that tile a ring, as places in it; `None` where there are none: it is clockwise, empty or crosses itself. Points on
/// a straight side belong to no triangle.
pub(super) fn tiles(ring: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut left: Vec<usize> = (0..ring.len()).collect();
    let mut found = Vec::with_capacity(ring.len());
    while left.len() > 3 {
        let n = left.len();
        let around = |k: usize| [(k + n - 1) % n, k, (k + 1) % n].map(|i| left[i]);
        let is_straight = |k: &usize| {
            let [a, b, c] = around(*k).map(|i| ring[i]);
            turn(a, b, c) == 0.0 && (a - b).dot(c - b) < 0.0
        };
        let is_ear = |k: usize, inside: &dyn Fn([DVec2; 3], DVec2) -> bool| {
            let t = around(k).map(|i| ring[i]);
            let holds_none = || left.iter().map(|i| ring[*i]).all(|p| t.contains(&p) || !inside(t, p));
            turn(t[0], t[1], t[2]) > 0.0 && holds_none()
        };
        let within =
            |[a, b, c]: [DVec2; 3], p: DVec2| turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0 && turn(c, a, p) > 0.0;
        // Where a slit joins a hole to the outline, points may lie on the sides of every ear.
        let ear = (0..n).find(|k| is_ear(*k, &holds)).or_else(|| (0..n).find(|k| is_ear(*k, &within)));
        match ear {
            Some(k) => {
                found.push(around(k));
                left.remove(k);
            }
            None => drop(left.remove((0..n).find(is_straight)?)),
        }
    }
    let [a, b, c] = left[..] else { return None };
    match turn(ring[a], ring[b], ring[c]) {
        sign if sign > 0.0 => found.push([a, b, c]),
        _ if found.is_empty() => return None,
        sign if sign < 0.0 => return None,
        // A point on the last side.
        _ => {}
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(points: &[[i32; 2]]) -> Option<usize> {
        let ring: Vec<DVec2> = points.iter().map(|[x, y]| DVec2::new(f64::from(*x), f64::from(*y))).collect();
        tiles(&ring).map(|tiles| tiles.len())
    }

    #[test]
    fn polygons_that_face_the_viewer_are_tiled_and_others_are_not() {
        assert_eq!(count(&[[0, 0], [2, 0], [2, 2], [0, 2]]), Some(2));
        assert_eq!(count(&[[0, 0], [2, 0], [1, 1], [0, 2]]), Some(2), "a dent, or a point on the diagonal");
        assert_eq!(count(&[[0, 0], [4, 0], [1, 1], [0, 4]]), Some(2));
        assert_eq!(count(&[[0, 0], [1, 0], [2, 0], [0, 2]]), Some(2), "a point on a side");
        assert_eq!(count(&[[0, 2], [2, 2], [2, 0], [0, 0]]), None, "clockwise");
        assert_eq!(count(&[[0, 0], [2, 2], [2, 0], [0, 2]]), None, "an hourglass");
        assert_eq!(count(&[[0, 0], [1, 1], [2, 2]]), None, "no area");
        assert_eq!(count(&[[0, 0], [1, 1], [2, 2], [3, 3]]), None, "no area");
        // A square with a square hole, joined by a slit.
        let hole = [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [3, 3], [3, 6], [6, 6], [6, 3], [3, 3]];
        assert_eq!(count(&hole), Some(8));
    }
}
