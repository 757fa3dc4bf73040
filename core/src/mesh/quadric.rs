//! Error quadrics: the weighted sum of squared distances to planes, as one quadratic form (Garland, Heckbert 1997).
//!
//! E(x) = x A x + 2 b x + c with A symmetric. In f64 and the unit box the sum cancels to about 1e-16 of the weight, that
//! is a distance of 1e-8.

use bytemuck::{Pod, Zeroable};
use core::ops::AddAssign;
use glam::DVec3;

/// A sum of squared distances to planes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Quadric {
    diagonal: [f64; 3], // xx, yy, zz
    mixed: [f64; 3],    // yz, zx, xy
    linear: [f64; 3],
    constant: f64,
}

impl Quadric {
    /// `weight` times the squared distance from the plane through `point` with the unit normal `normal`.
    pub fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let [x, y, z] = normal.to_array();
        let d = -normal.dot(point);
        Self {
            diagonal: [weight * x * x, weight * y * y, weight * z * z],
            mixed: [weight * y * z, weight * z * x, weight * x * y],
            linear: [weight * d * x, weight * d * y, weight * d * z],
            constant: weight * d * d,
        }
    }

    /// The sum at `point`; rounding below zero is cut off.
    #[inline]
    pub fn at(&self, point: DVec3) -> f64 {
        let [x, y, z] = point.to_array();
        let (d, m, l) = (&self.diagonal, &self.mixed, &self.linear);
        let squares = d[0] * x * x + d[1] * y * y + d[2] * z * z;
        let products = m[0] * y * z + m[1] * z * x + m[2] * x * y;
        let lines = l[0] * x + l[1] * y + l[2] * z;
        (squares + 2.0 * (products + lines) + self.constant).max(0.0)
    }
}

impl AddAssign for Quadric {
    fn add_assign(&mut self, other: Self) {
        for i in 0..3 {
            self.diagonal[i] += other.diagonal[i];
            self.mixed[i] += other.mixed[i];
            self.linear[i] += other.linear[i];
        }
        self.constant += other.constant;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn two_planes_give_the_sum_of_their_squared_distances() {
        let mut q = Quadric::plane(DVec3::new(0.6, 0.8, 0.0), DVec3::new(1.0, 0.0, 0.0), 2.0);
        q += Quadric::plane(DVec3::Z, DVec3::new(5.0, 5.0, 1.0), 3.0);
        // Distances 0.6 * (2 - 1) + 0.8 * 1 = 1.4 and 2; a dozen roundings of numbers below 20: 1e-14.
        assert_abs_diff_eq!(q.at(DVec3::new(2.0, 1.0, 3.0)), 2.0 * 1.96 + 3.0 * 4.0, epsilon = 1e-14);
    }
}
