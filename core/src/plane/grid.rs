//! UVs on an integer grid, and the exact predicates that decide flips and overlaps there.
//!
//! A coordinate is a multiple of 2^-bits, 24 bits for an atlas, and stays within 2^30 steps, so that every orientation
//! fits an i64: differences are below 2^31, their products below 2^62. Two triangles with area have disjoint interiors
//! exactly where the line of one of their six sides has them on different sides (separating axes; the sides of the
//! Minkowski difference of two convex polygons are parallel to theirs). Nothing here rounds after [`GridPoint::snap`].

use crate::base::real::round;
use bytemuck::{Pod, Zeroable};
use glam::DVec2;

/// Grid steps a UV unit are 2^24: a 256th of a texel at 65,536 texels, and f32 holds each point of [0, 1] exactly.
pub const GRID_BITS: i32 = 24;

/// Coordinates stay within plus and minus this many steps; x + y and x - y then fit an i32 as well.
pub const LIMIT: i32 = (1 << 30) - 1;

/// A point of the grid.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct GridPoint {
    x: i32,
    y: i32,
}

/// A triangle of grid points.
pub type GridTriangle = [GridPoint; 3];

impl GridPoint {
    /// The point (x, y) in steps, each clamped to [`LIMIT`].
    pub const fn new(x: i32, y: i32) -> Self {
        const fn clamp(x: i32) -> i32 {
            if x > LIMIT {
                LIMIT
            } else if x < -LIMIT {
                -LIMIT
            } else {
                x
            }
        }
        Self { x: clamp(x), y: clamp(y) }
    }

    /// The grid point nearest to `uv` with 2^`bits` steps a unit, `bits` in -1000..=30; NaN gives 0.
    pub fn snap(uv: DVec2, bits: i32) -> Self {
        let steps = power_of_two(bits);
        Self::new(round(uv.x * steps) as i32, round(uv.y * steps) as i32)
    }

    /// The UV of this point; exact.
    pub fn uv(self, bits: i32) -> DVec2 {
        DVec2::new(self.x as f64, self.y as f64) * power_of_two(-bits)
    }

    /// Steps along x.
    pub const fn x(self) -> i32 {
        self.x
    }

    /// Steps along y.
    pub const fn y(self) -> i32 {
        self.y
    }
}

/// The finest grid of at most [`GRID_BITS`] on which coordinates up to `largest` in size fit: 24 up to 63 units.
pub fn grid_bits(largest: f64) -> i32 {
    let mut bits = GRID_BITS;
    while bits > -1000 && largest * power_of_two(bits) > LIMIT as f64 {
        bits -= 1;
    }
    bits
}

/// Twice the signed area: positive counter-clockwise, 0 where the three points are on a line.
pub fn doubled_area(t: &GridTriangle) -> i64 {
    orientation(t[0], t[1], t[2])
}

/// Whether the interiors of `a` and `b` have a point in common. Triangles that touch along a side or at a corner do
/// not; a triangle without area meets nothing; either may run clockwise.
pub fn interiors_meet(a: &GridTriangle, b: &GridTriangle) -> bool {
    let (a, b) = (counter_clockwise(*a), counter_clockwise(*b));
    doubled_area(&a) != 0 && doubled_area(&b) != 0 && !some_side_separates(&a, &b) && !some_side_separates(&b, &a)
}

/// Two corners swapped where the triangle runs clockwise.
pub(crate) fn counter_clockwise(t: GridTriangle) -> GridTriangle {
    if doubled_area(&t) < 0 { [t[0], t[2], t[1]] } else { t }
}

/// Whether all of `b` is on the outer side of one side of counter-clockwise `a`, or on its line.
#[inline]
pub(crate) fn some_side_separates(a: &GridTriangle, b: &GridTriangle) -> bool {
    [(0, 1), (1, 2), (2, 0)].iter().any(|&(i, j)| b.iter().all(|p| orientation(a[i], a[j], *p) <= 0))
}

/// Twice the area of (a, b, c). Wrapping only guards bytes cast into points beyond the limit.
#[inline]
fn orientation(a: GridPoint, b: GridPoint, c: GridPoint) -> i64 {
    let difference = |p: i32, q: i32| p as i64 - q as i64;
    let (ux, uy) = (difference(b.x, a.x), difference(b.y, a.y));
    let (vx, vy) = (difference(c.x, a.x), difference(c.y, a.y));
    ux.wrapping_mul(vy).wrapping_sub(uy.wrapping_mul(vx))
}

/// 2^bits, exact.
fn power_of_two(bits: i32) -> f64 {
    f64::from_bits(((bits + 1023) as u64) << 52)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::random::hash;

    pub(crate) fn triangle(points: [[i32; 2]; 3]) -> GridTriangle {
        points.map(|[x, y]| GridPoint::new(x, y))
    }

    /// A seeded triangle with coordinates in 0..side, moved by `offset`.
    pub(crate) fn random_triangle(index: u64, side: u64, offset: [i32; 2]) -> GridTriangle {
        let coordinate = |k: u64| (hash(7, index, k) % side) as i32;
        triangle([0, 2, 4].map(|k| [coordinate(k) + offset[0], coordinate(k + 1) + offset[1]]))
    }

    /// Clips `a` by the three half planes of `b` in i128 homogeneous coordinates (Sutherland, Hodgman 1974) and asks
    /// whether area is left: no separating axes, no shared code.
    pub(crate) fn oracle_meets(a: &GridTriangle, b: &GridTriangle) -> bool {
        type Point = [i128; 3]; // x, y, w > 0
        let area = |p: &Point, q: &Point, r: &Point| {
            p[0] * (q[1] * r[2] - r[1] * q[2]) - p[1] * (q[0] * r[2] - r[0] * q[2]) + p[2] * (q[0] * r[1] - r[0] * q[1])
        };
        let lift = |t: &GridTriangle| {
            let mut t = t.map(|p| [p.x as i128, p.y as i128, 1]);
            if area(&t[0], &t[1], &t[2]) < 0 {
                t.swap(1, 2);
            }
            t
        };
        let (a, b) = (lift(a), lift(b));
        if area(&a[0], &a[1], &a[2]) == 0 || area(&b[0], &b[1], &b[2]) == 0 {
            return false;
        }
        let mut polygon = a.to_vec();
        for i in 0..3 {
            let side: std::vec::Vec<i128> = polygon.iter().map(|p| area(&b[i], &b[(i + 1) % 3], p)).collect();
            let mut kept = std::vec![];
            for j in 0..polygon.len() {
                let k = (j + 1) % polygon.len();
                if side[j] >= 0 {
                    kept.push(polygon[j]);
                }
                // `side` carries the factor w of its point, so the crossing is P |s_Q| + Q |s_P| with weights as they are.
                if side[j].signum() * side[k].signum() < 0 {
                    let (s, t) = (side[j].abs(), side[k].abs());
                    let mut p: Point = core::array::from_fn(|d| polygon[j][d] * t + polygon[k][d] * s);
                    let gcd = |mut a: i128, mut b: i128| {
                        while b != 0 {
                            (a, b) = (b, a % b);
                        }
                        a.abs()
                    };
                    let g = gcd(gcd(p[0], p[1]), p[2]);
                    p.iter_mut().for_each(|x| *x /= g);
                    kept.push(p);
                }
            }
            polygon = kept;
            if polygon.is_empty() {
                return false;
            }
        }
        (1..polygon.len().max(2) - 1).any(|j| area(&polygon[0], &polygon[j], &polygon[j + 1]) != 0)
    }

    #[test]
    fn touching_triangles_do_not_overlap() {
        let a = triangle([[0, 0], [4, 0], [0, 4]]);
        for b in [
            [[4, 0], [4, 4], [0, 4]],   // a whole side
            [[1, 3], [3, 1], [4, 4]],   // part of a side
            [[0, 0], [-1, 0], [0, -1]], // a corner
            [[2, 2], [4, 4], [5, 1]],   // a corner on a side
            [[0, 0], [2, 2], [1, 1]],   // no area, inside
        ] {
            assert!(!interiors_meet(&a, &triangle(b)) && !interiors_meet(&triangle(b), &a), "{b:?}");
        }
    }

    #[test]
    fn equal_contained_crossing_and_folded_triangles_overlap() {
        let a = triangle([[0, 0], [4, 0], [0, 4]]);
        for b in [
            [[0, 0], [4, 0], [0, 4]],
            [[0, 0], [0, 4], [4, 0]],
            [[1, 1], [2, 1], [1, 2]],
            [[-9, 1], [9, 1], [9, 2]],
            [[4, 0], [0, 4], [1, 1]], // folded back over a shared side
            [[-100, -100], [100, -100], [0, 100]],
        ] {
            assert!(interiors_meet(&a, &triangle(b)) && interiors_meet(&triangle(b), &a), "{b:?}");
        }
    }

    #[test]
    fn the_test_agrees_with_exact_clipping() {
        // Small sides make touching, collinear and empty triangles common.
        for (side, count) in [(3, 60_000), (5, 60_000), (9, 40_000), (400, 40_000)] {
            let mut met = 0;
            for i in 0..count {
                let (a, b) = (random_triangle(2 * i, side, [0; 2]), random_triangle(2 * i + 1, side, [0; 2]));
                let meets = interiors_meet(&a, &b);
                assert_eq!(meets, oracle_meets(&a, &b), "{a:?} {b:?}");
                met += meets as u64;
            }
            assert!(met > count / 10 && met < count * 9 / 10, "{met} of {count}");
        }
    }

    #[test]
    fn the_corners_of_the_grid_do_not_overflow() {
        let wide = triangle([[i32::MIN, i32::MIN], [i32::MAX, i32::MIN], [i32::MAX, i32::MAX]]);
        assert_eq!(doubled_area(&wide), (2 * LIMIT as i64).pow(2));
        assert!(interiors_meet(&wide, &triangle([[LIMIT, 0], [LIMIT - 1, 1], [LIMIT - 1, 0]])));
        assert!(!interiors_meet(&wide, &triangle([[0, 0], [1, 1], [0, 1]])));
    }

    #[test]
    fn snapping_is_exact_on_the_grid_and_survives_anything() {
        let p = GridPoint::new(12_345_678, -7);
        assert_eq!(GridPoint::snap(p.uv(GRID_BITS), GRID_BITS), p);
        assert_eq!(GridPoint::snap(DVec2::new(f64::NAN, f64::INFINITY), GRID_BITS), GridPoint::new(0, LIMIT));
        assert_eq!((grid_bits(1.0), grid_bits(63.0), grid_bits(1000.0)), (24, 24, 20));
        assert_eq!(grid_bits(f64::MAX), -995);
    }
}
