//! Symmetric Dirichlet energy of one triangle: value, gradient, projected Hessian.
//!
//! psi(F) = |F|^2 + |F^-1|^2 = s1^2 + s2^2 + s1^-2 + s2^-2, F the 2x2 Jacobian from the triangle's rest shape to UV
//! (Smith, Schaefer 2015); 4 is an isometry. The eigenvalues of its Hessian over F are known in closed form
//! (Smith, de Goes, Kim 2019): the two stretch modes and the flip mode are positive wherever det F > 0, so only the
//! twist mode is clamped at zero. No singular value decomposition is needed: F = q R + r M with R a rotation and M a
//! reflection, s1 = q + r, s2 = q - r.
//! Guarantee: the returned Hessian is positive semi-definite. Limit: F must have a positive determinant.

use crate::base::real::{ln, sqrt};
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

/// Added to every edge length of a rest shape, in units of the mesh's largest side: gives flat faces a shape.
pub const MOLLIFY: f64 = 1e-9;

/// Weight of a triangle without area, over that of the shape it is given: enough to hold its orientation, too little to
/// bend its neighbours.
const FLAT_WEIGHT: f64 = 1e-3;

/// Weight of ln(det F)^2 in what relaxation lowers. At the bound 1.003, mean errors of angle and area are .023 and .028 with
/// 0, .025 and .022 with 1 (8 meshes).
const AREA: f64 = 0.4;
/// How far the weights of faces go from area to equal ones. With 0 small faces bear the worst
/// distortion: the mean area error at 1.025 is .095 with 0, .087 with 0.5 (12 meshes).
const EVEN: f64 = 0.5;
/// Most that a small face's weight may grow: slivers stay light.
const MOST_GAIN: f64 = 20.0;

/// A triangle's rest shape: corner 0 at the origin, corner 1 on the x axis; `inverse` is the inverse of its edge matrix
/// (upper triangular: a b / 0 d).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Rest {
    a: f64,
    b: f64,
    d: f64,
    /// Area of the triangle in space.
    pub area: f64,
    /// Its weight in an energy: the area, or a trifle for a triangle that has none.
    pub weight: f64,
}

/// Where a Hessian that [`Rest::derivatives`] gives has xx, xy and yy of each corner alone.
pub const OWN_BLOCK: [[usize; 3]; 3] = [[0, 1, 2], [5, 8, 9], [14, 19, 20]];

/// Moves the weights of faces with area half-way to equal ones. A reader of the atlas sees triangles as well as area, and
/// fine triangles lie where the shape is rich. The sum stays, but for faces that would gain more than [`MOST_GAIN`].
pub fn even_out(rest: &mut [Rest]) {
    let mean = rest.iter().map(|r| r.area).sum::<f64>() / rest.len().max(1) as f64;
    rest.iter_mut().for_each(|r| r.even_out(mean));
}

/// psi from which a face counts for more, so that none is far above the rest: without, single faces reach a psi of 20 at the
/// bound 1.025, and cutting towards those above 8 costs a tenth of the visible seams' length; with it, next to nothing.
const STEEP_FROM: f64 = 6.0;
/// Up to which psi above that the weight grows: beyond, relaxing a first map would take many steps.
const STEEP_OVER: f64 = 2.0;
/// How fast it grows: from 1 to 5.
const STEEP: f64 = 2.0;

impl Rest {
    /// The rest shape of a triangle in space. `tiny` is added to every edge length (intrinsic mollification: Sharp,
    /// Crane 2020), so that a triangle of zero area still has a shape.
    pub fn new([p, q, r]: [DVec3; 3], tiny: f64) -> Self {
        let (u, v) = (q - p, r - p);
        let (lu, lv, lw) = (sqrt(u.dot(u)) + tiny, sqrt(v.dot(v)) + tiny, sqrt((r - q).dot(r - q)) + tiny);
        // Corner 2 from the three lengths; its height from Heron's product in a stable order of factors.
        let x = (lu * lu + lv * lv - lw * lw) / (2.0 * lu);
        let twice = sqrt(
            ((lu + lv + lw) * (lu + lv - lw).max(0.0) * (lu - lv + lw).max(0.0) * (lv + lw - lu).max(0.0)).max(0.0),
        ) * 0.5;
        let exact = {
            let n = u.cross(v);
            sqrt(n.dot(n))
        };
        let held = twice.max(exact).max(tiny * tiny).max(f64::MIN_POSITIVE);
        let y = held / lu;
        let (area, weight) = (0.5 * exact, (0.5 * exact).max(0.5 * FLAT_WEIGHT * held));
        Self { a: 1.0 / lu, b: -x / (lu * y), d: 1.0 / y, area, weight }
    }

    /// Moves the weight half-way to that of a face of area `mean`, as [`even_out`] does.
    pub fn even_out(&mut self, mean: f64) {
        if self.area > 0.0 {
            self.weight = (1.0 - EVEN) * self.weight + EVEN * mean.min(MOST_GAIN * self.weight);
        }
    }

    /// Jacobian from the rest shape to the UV triangle, columns first: (dU/dx, dU/dy).
    #[inline]
    pub fn jacobian(&self, x: [DVec2; 3]) -> [DVec2; 2] {
        let (u, v) = (x[1] - x[0], x[2] - x[0]);
        [u * self.a, u * self.b + v * self.d]
    }

    /// The place of corner 2 over the edge from corner 0 at `p` to corner 1 at `q`, congruent to the rest shape but for the
    /// length of that edge.
    pub fn unfold(&self, p: DVec2, q: DVec2) -> DVec2 {
        let x = (q - p) * self.a; // the rest shape's x axis
        let (along, up) = (-self.b / (self.a * self.d), 1.0 / self.d);
        p + x * along + x.perp() * up
    }

    /// The same with its height over that edge times `scale`, whatever the length of the edge.
    pub fn unfold_at_scale(&self, p: DVec2, q: DVec2, scale: f64) -> DVec2 {
        let side = q - p;
        let length = sqrt(side.dot(side)).max(1e-300);
        p - side * (self.b / self.d) + side.perp() * (scale / (length * self.d))
    }

    /// Length of the rest shape's edge from corner 0 to corner 1.
    pub fn base(&self) -> f64 {
        1.0 / self.a
    }

    /// The same shape named from corner 1.
    pub fn turned(&self) -> Self {
        let (l, x, y) = (1.0 / self.a, -self.b / (self.a * self.d), 1.0 / self.d);
        // Corner 1 at the origin, corner 2 on the x axis.
        let (u, v) = (DVec2::new(x - l, y), DVec2::new(-l, 0.0));
        let length = sqrt(u.dot(u));
        let (along, up) = (u.dot(v) / length, u.perp_dot(v) / length);
        Self { a: 1.0 / length, b: -along / (length * up), d: 1.0 / up, ..*self }
    }

    /// Gradients of the three corners' hat functions in the rest frame.
    #[inline]
    fn gradients(&self) -> [DVec2; 3] {
        let g1 = DVec2::new(self.a, self.b);
        let g2 = DVec2::new(0.0, self.d);
        [-(g1 + g2), g1, g2]
    }

    /// psi, or infinity where the UV triangle is flipped or flat.
    #[inline]
    pub fn energy(&self, x: [DVec2; 3]) -> f64 {
        let [c0, c1] = self.jacobian(x);
        let det = c0.perp_dot(c1);
        if det > 0.0 {
            let norm = c0.dot(c0) + c1.dot(c1);
            norm * (1.0 + 1.0 / (det * det))
        } else {
            f64::INFINITY
        }
    }

    /// What relaxation lowers: psi, steeper where it is large, + AREA ln(det F)^2, infinite where the UV triangle is flipped or flat.
    #[inline]
    pub fn objective(&self, x: [DVec2; 3]) -> f64 {
        let [c0, c1] = self.jacobian(x);
        let det = c0.perp_dot(c1);
        if det > 0.0 {
            let norm = c0.dot(c0) + c1.dot(c1);
            let log = ln(det);
            steep(norm * (1.0 + 1.0 / (det * det))).0 + AREA * log * log
        } else {
            f64::INFINITY
        }
    }

    /// Largest step t in [0, limit] along `p` before the triangle becomes flat: the smallest positive root of
    /// det(F(x + t p)), a quadratic in t.
    #[inline]
    pub fn step_limit(&self, x: [DVec2; 3], p: [DVec2; 3], limit: f64) -> f64 {
        let (u, v) = (x[1] - x[0], x[2] - x[0]);
        let (du, dv) = (p[1] - p[0], p[2] - p[0]);
        let (a, b, c) = (du.perp_dot(dv), u.perp_dot(dv) + du.perp_dot(v), u.perp_dot(v));
        let disc = b * b - 4.0 * a * c;
        // c > 0. Without a real root the sign never changes.
        if disc < 0.0 {
            return limit;
        }
        let s = sqrt(disc);
        // Citardauq form: stable when a is tiny.
        let root = if b <= 0.0 {
            2.0 * c / (-b + s)
        } else if a < 0.0 {
            (b + s) / (-2.0 * a)
        } else {
            limit
        };
        if root > 0.0 { root.min(limit) } else { limit }
    }

    /// Gradient (6) of [`objective`](Self::objective) over the three corners, times the triangle's weight.
    #[inline]
    pub fn gradient(&self, x: [DVec2; 3]) -> [f64; 6] {
        let [c0, c1] = self.jacobian(x);
        let det = c0.perp_dot(c1);
        let norm = c0.dot(c0) + c1.dot(c1);
        let inverse = 1.0 / (det * det);
        let rise = self.weight * steep(norm * (1.0 + inverse)).1;
        // Over the Jacobian: of |F|^2, and of det F.
        let along = 2.0 * rise * (1.0 + inverse);
        let across = (2.0 * self.weight * AREA * ln(det) - 2.0 * rise * norm * inverse) / det;
        let d0 = c0 * along + DVec2::new(c1.y, -c1.x) * across;
        let d1 = c1 * along + DVec2::new(-c0.y, c0.x) * across;
        let mut gradient = [0.0; 6];
        for (pair, g) in gradient.as_chunks_mut::<2>().0.iter_mut().zip(self.gradients()) {
            *pair = (d0 * g.x + d1 * g.y).to_array();
        }
        gradient
    }

    /// Gradient (6) of [`objective`](Self::objective) and the lower triangle of its projected Hessian (6 x 6, row by row)
    /// over the three corners, both times the triangle's weight.
    #[inline]
    pub fn derivatives(&self, x: [DVec2; 3]) -> ([f64; 6], [f64; 21]) {
        let [c0, c1] = self.jacobian(x);
        let (a, b) = (0.5 * (c0.x + c1.y), 0.5 * (c0.y - c1.x));
        let (c, d) = (0.5 * (c0.x - c1.y), 0.5 * (c0.y + c1.x));
        let (q, r) = (sqrt(a * a + b * b), sqrt(c * c + d * d));
        let det = c0.perp_dot(c1);
        let s1 = q + r;
        let s2 = det / s1;
        let (ra, rb) = (a / q, b / q);
        let (mc, md) = if r > 1e-12 * q { (c / r, d / r) } else { (1.0, 0.0) };
        // Each mode as a 2x2 matrix by columns.
        let half = 0.5;
        let root = core::f64::consts::FRAC_1_SQRT_2;
        let stretch1 = [DVec2::new(ra + mc, rb + md) * half, DVec2::new(-rb + md, ra - mc) * half];
        let stretch2 = [DVec2::new(ra - mc, rb - md) * half, DVec2::new(-rb - md, ra + mc) * half];
        let twist = [DVec2::new(-rb, ra) * root, DVec2::new(-ra, -rb) * root];
        let flip = [DVec2::new(-md, mc) * root, DVec2::new(mc, md) * root];
        let (i1, i2) = (1.0 / s1, 1.0 / s2);
        let (i1c, i2c) = (i1 * i1 * i1, i2 * i2 * i2);
        let w = self.weight;
        let cubes = i1c * i2c;
        let lambda = [
            2.0 + 6.0 * i1c * i1,
            2.0 + 6.0 * i2c * i2,
            (2.0 - 2.0 * (s1 * s1 - s1 * s2 + s2 * s2) * cubes).max(0.0),
            2.0 + 2.0 * (s1 * s1 + s1 * s2 + s2 * s2) * cubes,
        ];
        let slope = [w * (2.0 * s1 - 2.0 * i1c), w * (2.0 * s2 - 2.0 * i2c)];
        let g = self.gradients();
        let (mut gradient, mut hessian) = ([0.0; 6], [0.0; 21]);
        for (k, mode) in [stretch1, stretch2, twist, flip].iter().enumerate() {
            let mut e = [0.0; 6];
            for i in 0..3 {
                let v = mode[0] * g[i].x + mode[1] * g[i].y;
                e[2 * i] = v.x;
                e[2 * i + 1] = v.y;
            }
            if k < 2 {
                for i in 0..6 {
                    gradient[i] += slope[k] * e[i];
                }
            }
            add_square(&mut hessian, w * lambda[k], &e);
        }
        let (_, rise, bend) = steep((s1 * s1 + s2 * s2) * (1.0 + i1 * i1 * i2 * i2));
        if rise > 1.0 {
            let mut at = 0;
            for i in 0..6 {
                for other in &gradient[..=i] {
                    hessian[at] = rise * hessian[at] + bend / w * gradient[i] * other;
                    at += 1;
                }
            }
            gradient.iter_mut().for_each(|g| *g *= rise);
        }
        // AREA ln(det)^2 by Gauss-Newton: gradient 2 AREA ln(det) e, Hessian 2 AREA e e^T, e the gradient of ln(det).
        let mut e = [0.0; 6];
        for i in 0..3 {
            let v = (DVec2::new(c1.y, -c1.x) * g[i].x + DVec2::new(-c0.y, c0.x) * g[i].y) / det;
            e[2 * i] = v.x;
            e[2 * i + 1] = v.y;
        }
        let (twice, log) = (2.0 * w * AREA, ln(det));
        for i in 0..6 {
            gradient[i] += twice * log * e[i];
        }
        add_square(&mut hessian, twice, &e);
        (gradient, hessian)
    }
}

/// psi with more weight above [`STEEP_FROM`]: value, derivative and second derivative.
#[inline]
fn steep(psi: f64) -> (f64, f64, f64) {
    let over = psi - STEEP_FROM;
    if over <= 0.0 {
        (psi, 1.0, 0.0)
    } else if over < STEEP_OVER {
        (psi + 0.5 * STEEP * over * over, 1.0 + STEEP * over, STEEP)
    } else {
        (psi + STEEP * STEEP_OVER * (over - 0.5 * STEEP_OVER), 1.0 + STEEP * STEEP_OVER, 0.0)
    }
}

/// Adds factor e e^T, the lower triangle row by row.
#[inline(always)]
fn add_square(hessian: &mut [f64; 21], factor: f64, e: &[f64; 6]) {
    let mut at = 0;
    for i in 0..6 {
        let f = factor * e[i];
        for entry in &e[..=i] {
            hessian[at] += f * entry;
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use approx::assert_abs_diff_eq;

    fn triangle(seed: u64) -> (Rest, [DVec2; 3]) {
        let r = |i| unit_f64(seed, 7, i);
        let rest = Rest::new([DVec3::ZERO, DVec3::new(1.0 + r(0), 0.1, r(1)), DVec3::new(r(2), 1.0 + r(3), -0.3)], 0.0);
        (rest, [DVec2::new(r(4), r(5)), DVec2::new(1.5 + r(6), r(7)), DVec2::new(r(8), 1.6 + r(9))])
    }

    #[test]
    fn an_isometry_has_energy_four_and_no_gradient() {
        let rest = Rest::new([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.0)], 0.0);
        let x = [DVec2::ZERO, DVec2::new(0.0, 1.0), DVec2::new(-0.8, 0.3)];
        // A few roundings of values near 1.
        assert_abs_diff_eq!(rest.energy(x), 4.0, epsilon = 1e-13);
        assert!(rest.derivatives(x).0.iter().all(|g| g.abs() < 1e-13));
    }

    #[test]
    fn the_gradient_alone_is_that_of_the_derivatives() {
        for seed in 0..50 {
            let (rest, x) = triangle(seed);
            if rest.energy(x) > 1e3 {
                continue;
            }
            let (all, alone) = (rest.derivatives(x).0, rest.gradient(x));
            let size = all.iter().map(|g| g.abs()).fold(1.0, f64::max);
            // Some twenty roundings of sums that cancel by up to psi.
            all.iter().zip(alone).for_each(|(a, b)| assert_abs_diff_eq!(*a, b, epsilon = 1e-11 * size));
        }
    }

    #[test]
    fn the_steep_part_joins_smoothly() {
        let ends = [STEEP_FROM, STEEP_FROM + STEEP_OVER];
        for x in [4.0, 6.7, 7.9, 30.0].into_iter().chain(ends) {
            let h = 1e-6;
            let (up, down) = (steep(x + h), steep(x - h));
            // Differences err by h times the jump of the second derivative at most.
            assert!(((up.0 - down.0) / (2.0 * h) - steep(x).1).abs() <= 2.0 * h * STEEP, "{x}");
            if !ends.contains(&x) {
                assert!(((up.1 - down.1) / (2.0 * h) - steep(x).2).abs() < 1e-6, "{x}");
            }
        }
    }

    #[test]
    fn the_gradient_matches_central_differences() {
        for seed in 0..50 {
            let (rest, x) = triangle(seed);
            if rest.energy(x) > 20.0 {
                continue; // nearly flat: the third derivative is too large for differences
            }
            let (gradient, _) = rest.derivatives(x);
            let h = 1e-6;
            for i in 0..6 {
                let mut ends = [0.0; 2];
                for (end, sign) in ends.iter_mut().zip([h, -h]) {
                    let mut y = x;
                    y[i / 2][i % 2] += sign;
                    *end = rest.objective(y) * rest.weight;
                }
                let difference = (ends[0] - ends[1]) / (2.0 * h);
                // Truncation h^2 psi''' and rounding eps psi / h, both below 1e-8 of the scale here.
                assert!((difference - gradient[i]).abs() < 1e-7 * (1.0 + gradient[i].abs()), "{seed} {i}");
            }
        }
    }

    #[test]
    fn where_nothing_is_clamped_the_hessian_matches_differences_of_the_gradient() {
        let mut compared = 0;
        for seed in 0..200 {
            let (rest, x) = triangle(seed);
            let [c0, c1] = rest.jacobian(x);
            let (n, det) = (c0.dot(c0) + c1.dot(c1), c0.perp_dot(c1));
            if det <= 0.0 || 2.0 - 2.0 * (n - det) / (det * det * det) < 0.0 {
                continue;
            }
            compared += 1;
            // What Gauss-Newton leaves out: 2 AREA ln(det) times the second derivatives of ln(det). The determinant is
            // quadratic in x, so that differences with any step are exact but for rounding.
            let det_at = |i: usize, di: f64, j: usize, dj: f64| {
                let mut y = x;
                y[i / 2][i % 2] += di;
                y[j / 2][j % 2] += dj;
                let [c0, c1] = rest.jacobian(y);
                c0.perp_dot(c1)
            };
            let slope = |i: usize| 0.5 * (det_at(i, 1.0, i, 0.0) - det_at(i, -1.0, i, 0.0)) / det;
            let left_out = |i: usize, j: usize| {
                let [ends, mixed] = [1.0, -1.0].map(|t| det_at(i, 1.0, j, t) + det_at(i, -1.0, j, -t));
                let second = 0.25 * (ends - mixed) / det - slope(i) * slope(j);
                2.0 * AREA * rest.weight * ln(det) * second
            };
            let (_, hessian) = rest.derivatives(x);
            let h = 1e-6;
            for i in 0..6 {
                let (mut up, mut down) = (x, x);
                up[i / 2][i % 2] += h;
                down[i / 2][i % 2] -= h;
                let (up, down) = (rest.derivatives(up).0, rest.derivatives(down).0);
                for j in 0..=i {
                    let difference = (up[j] - down[j]) / (2.0 * h);
                    let entry = hessian[i * (i + 1) / 2 + j] + left_out(i, j);
                    assert!((difference - entry).abs() < 1e-6 * (1.0 + entry.abs()), "{seed} {i} {j}");
                }
            }
        }
        assert!(compared > 50);
    }

    #[test]
    fn the_step_limit_stops_where_the_triangle_is_flat() {
        for seed in 0..100 {
            let (rest, x) = triangle(seed);
            let r = |i| unit_f64(seed, 8, i) * 4.0 - 2.0;
            let p = [DVec2::new(r(0), r(1)), DVec2::new(r(2), r(3)), DVec2::new(r(4), r(5))];
            let at = |t: f64| [0, 1, 2].map(|i| x[i] + p[i] * t);
            let t = rest.step_limit(x, p, 10.0);
            assert!(rest.energy(at(t * 0.999)) < f64::INFINITY);
            if t < 10.0 {
                assert!(rest.energy(at(t * 1.001)) == f64::INFINITY, "{seed} {t}");
            }
        }
    }

    #[test]
    fn a_triangle_of_no_area_gets_a_shape() {
        let rest = Rest::new([DVec3::ZERO, DVec3::X, DVec3::X * 0.5], 1e-6);
        assert!(rest.weight > 0.0 && rest.d.is_finite());
        let point = Rest::new([DVec3::ZERO; 3], 1e-6);
        assert!(point.weight > 0.0 && point.b.is_finite());
    }

    #[test]
    fn evening_out_goes_half_way_to_equal_weights_and_keeps_their_sum() {
        let triangle = |height| Rest::new([DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * height], 0.0);
        let mut rest = [triangle(1.0), triangle(3.0), triangle(0.0)];
        even_out(&mut rest[..2]);
        // Areas 1 and 3, their mean 2.
        assert_abs_diff_eq!(rest[0].weight, 1.5, epsilon = 1e-12);
        assert_abs_diff_eq!(rest[1].weight, 2.5, epsilon = 1e-12);
        let before = rest[2].weight;
        even_out(&mut rest[2..]);
        assert_eq!(rest[2].weight, before, "a face without area stays light");
    }
}
