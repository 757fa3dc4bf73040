//! Areas of convex hulls: of few points exactly, of many by their extremes.

use crate::base::real::{cos, sin};
use crate::base::room::Room;
use crate::base::sort;
use core::f64::consts::TAU;
use glam::DVec2;

/// Points whose hull is found exactly, and directions in which the extremes of more are taken.
pub const MOST: usize = 32;

/// Area of the convex hull of points, from the extreme ones in [`MOST`] directions: low by less than 1 % where they are
/// on a circle.
pub fn hull_of(points: impl Iterator<Item = DVec2>) -> f64 {
    let directions: [DVec2; MOST] = core::array::from_fn(|i| {
        let angle = TAU * i as f64 / MOST as f64;
        DVec2::new(cos(angle), sin(angle))
    });
    let mut extreme = [(f64::NEG_INFINITY, DVec2::ZERO); MOST];
    for p in points {
        for (e, direction) in extreme.iter_mut().zip(directions) {
            let along = p.dot(direction);
            if along > e.0 {
                *e = (along, p);
            }
        }
    }
    hull_area(MOST, |i| extreme[i].1)
}

/// Area of the convex hull of at most [`MOST`] + 1 points (Andrew 1979).
pub fn hull_area(count: usize, point: impl Fn(usize) -> DVec2) -> f64 {
    let mut points = heapless::Vec::<DVec2, { MOST + 2 }>::new();
    for i in 0..count.min(MOST + 2) {
        points.put(point(i));
    }
    sort::by(&mut points, |a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut twice = 0.0;
    for side in [false, true] {
        let mut hull = heapless::Vec::<DVec2, { MOST + 2 }>::new();
        for k in 0..points.len() {
            let p = points[if side { points.len() - 1 - k } else { k }];
            while hull.len() > 1
                && (hull[hull.len() - 1] - hull[hull.len() - 2]).perp_dot(p - hull[hull.len() - 1]) <= 0.0
            {
                hull.pop();
            }
            hull.put(p);
        }
        twice += hull.windows(2).map(|e| e[0].perp_dot(e[1])).sum::<f64>();
    }
    0.5 * twice
}

/// Andrew's monotone chain: corners counter-clockwise into `hull`; the answer is their number. Sorts `points`.
pub fn convex_hull(hull: &mut [DVec2], points: &mut [DVec2]) -> usize {
    sort::by(points, |a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let n = points.len();
    let mut len = 0;
    let mut push = |p: DVec2, len: &mut usize, base: usize| {
        while *len >= base + 2 && (hull[*len - 1] - hull[*len - 2]).perp_dot(p - hull[*len - 1]) <= 0.0 {
            *len -= 1;
        }
        // n points need at most n places: the first one is never pushed again.
        if *len < hull.len() {
            hull[*len] = p;
            *len += 1;
        }
    };
    points.iter().for_each(|&p| push(p, &mut len, 0));
    let base = len.saturating_sub(1);
    (1..n.saturating_sub(1)).rev().for_each(|i| push(points[i], &mut len, base));
    len
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_hull_of_many_points_is_that_of_their_extremes() {
        let grid = (0..100).map(|i| DVec2::new(f64::from(i % 10), f64::from(i / 10)));
        assert_eq!(hull_of(grid), 81.0);
        assert_eq!(hull_of(core::iter::empty()), 0.0);
        // A polygon of n = 32 corners covers n / TAU sin(TAU / n) = .9936 of its circle.
        let circle = (0..3200).map(|i| DVec2::new(cos(TAU * f64::from(i) / 3200.0), sin(TAU * f64::from(i) / 3200.0)));
        let share = hull_of(circle) / (0.5 * TAU);
        assert_abs_diff_eq!(share, 0.9936, epsilon = 1e-3);
    }

    #[test]
    fn the_hull_of_a_square_and_its_middle_is_the_square() {
        let points = [(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y));
        assert_eq!(hull_area(5, |i| points[i]), 4.0);
        assert_eq!(hull_area(1, |i| points[i]), 0.0);
        assert_eq!(hull_area(2, |i| points[i]), 0.0);
    }
}
