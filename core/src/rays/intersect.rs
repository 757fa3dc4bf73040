//! A ray against a triangle: watertight intersection (Woop, Benthin, Wald 2013).
//!
//! The ray is sheared onto its largest axis, where three edge functions decide; neighbours compute a shared edge from
//! the same numbers, so no ray passes between them. The depth is clamped to the interval in which the ray is inside the
//! triangle's own padded box, and a ray that misses that box misses the triangle.
//! Degenerate triangles are never hit; a ray of zero or non-finite direction hits nothing.
//! Limits: depth on a triangle seen edge-on is that of its box.

use super::bvh::{Bounds, Node, max, min};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Boxes are padded by this share of the coordinates met on the way: 16 roundings, where the intersection has about 6.
const PAD: f32 = 1.0 / (1 << 20) as f32;
/// Largest inverse slope: a ray steeper than this stays within 2^-38 of its axis, far inside the padding.
const STEEPEST: f32 = (1u64 << 40) as f32;

/// Three corners and the face that they came from.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Triangle {
    pub corners: [[f32; 3]; 3],
    pub face: u32,
}

/// A ray's origin, and the padding that goes with it: `low` is taken from a box's lower corner, `high` from its upper.
#[derive(Clone, Copy)]
pub(super) struct RayStart {
    pub point: [f32; 3],
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl RayStart {
    pub fn new(origin: Vec3, reach: f32) -> Self {
        Self::padded(origin, reach, PAD)
    }

    /// Twice the padding, for tests by other formulas that must not lose what [`interval`] keeps.
    pub fn loose(origin: Vec3, reach: f32) -> Self {
        Self::padded(origin, reach, 2.0 * PAD)
    }

    fn padded(origin: Vec3, reach: f32, pad: f32) -> Self {
        let point = origin.to_array();
        let pad = pad * point.iter().fold(reach, |r, x| max(x.abs(), r));
        Self { point, low: point.map(|x| x + pad), high: point.map(|x| x - pad) }
    }
}

/// A ray's direction, sheared: along `axis` (the largest component) the ray runs in steps of one, sideways by `slope`
/// a step. Depths are counted along the axis.
#[derive(Clone, Copy)]
pub(super) struct Aim {
    pub axis: usize,
    pub sign: f32,         // of the largest component
    pub length: f32,       // its magnitude
    pub slope: [f32; 2],   // of the components axis + 1, axis + 2 (mod 3); in [-1, 1]
    pub inverse: [f32; 2], // 1 / slope, at most STEEPEST
}

impl Aim {
    /// `None` where there is no direction.
    #[inline]
    pub fn new(direction: Vec3) -> Option<Self> {
        let d = direction.to_array();
        let axis = main_axis(d);
        let length = d[axis].abs();
        if !(length > 0.0 && length < f32::INFINITY) {
            return None;
        }
        let sides = [d[NEXT[axis]], d[NEXT[NEXT[axis]]]];
        Some(Self {
            axis,
            sign: if d[axis] < 0.0 { -1.0 } else { 1.0 },
            length,
            slope: sides.map(|x| x / length),
            inverse: sides.map(|x| inverse_slope(x, length)),
        })
    }
}

/// The axis after each.
pub(super) const NEXT: [usize; 3] = [1, 2, 0];

/// The axis of the largest component, the first of equals.
#[inline(always)]
pub(super) fn main_axis(d: [f32; 3]) -> usize {
    let [x, y, z] = d.map(f32::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// length / side, finite.
#[inline(always)]
pub(super) fn inverse_slope(side: f32, length: f32) -> f32 {
    let inverse = min(length / side.abs(), STEEPEST);
    if side < 0.0 { -inverse } else { inverse }
}

/// The depths at which the ray is inside the padded box, if it is; from 0.
#[inline(always)]
pub(super) fn interval(node: &Node, start: &RayStart, aim: &Aim) -> Option<(f32, f32)> {
    let (z, x) = (aim.axis, NEXT[aim.axis]);
    let y = NEXT[x];
    let side = |k: usize, scale: f32| {
        let (a, b) = ((node.low[k] - start.low[k]) * scale, (node.high[k] - start.high[k]) * scale);
        (min(a, b), max(a, b))
    };
    let (z, x, y) = (side(z, aim.sign), side(x, aim.inverse[0]), side(y, aim.inverse[1]));
    let (near, far) = (max(max(max(z.0, 0.0), x.0), y.0), min(min(z.1, x.1), y.1));
    (near <= far).then_some((near, far))
}

/// A hit in the ray's own depth.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    pub depth: f32,
    pub face: u32,
    pub weights: [f32; 3],
}

/// Where the ray meets the triangle. This function is the definition; packets only filter what they give to it.
#[inline(always)]
pub(super) fn meet(triangle: &Triangle, start: &RayStart, aim: &Aim) -> Option<Meeting> {
    let (z, x) = (aim.axis, NEXT[aim.axis]);
    let y = NEXT[x];
    let local = |p: &[f32; 3]| {
        let depth = (p[z] - start.point[z]) * aim.sign;
        [p[x] - start.point[x] - aim.slope[0] * depth, p[y] - start.point[y] - aim.slope[1] * depth, depth]
    };
    let (a, b, c) = (local(&triangle.corners[0]), local(&triangle.corners[1]), local(&triangle.corners[2]));
    let weights = [cross(b, c), cross(c, a), cross(a, b)];
    if of_both_signs(weights) { None } else { meet_inside(triangle, [a, b, c], weights, start, aim) }
}

#[inline(always)]
fn of_both_signs([u, v, w]: [f32; 3]) -> bool {
    min(min(u, v), w) < 0.0 && max(max(u, v), w) > 0.0
}

/// The rest of [`meet`], for few triangles. Where f32 gives an edge function of zero, f64 decides the sign: its
/// products are exact.
#[inline(never)]
fn meet_inside(
    triangle: &Triangle,
    [a, b, c]: [[f32; 3]; 3],
    mut weights: [f32; 3],
    start: &RayStart,
    aim: &Aim,
) -> Option<Meeting> {
    if weights.contains(&0.0) {
        weights = [exact(b, c), exact(c, a), exact(a, b)];
        if of_both_signs(weights) {
            return None;
        }
    }
    let area = weights[0] + weights[1] + weights[2];
    let depth = (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) / area;
    let ahead = depth > 0.0; // false for NaN, where the area is zero
    if !ahead {
        return None;
    }
    let bounds = Bounds::of(&triangle.corners);
    let own_box = Node { low: bounds.low, high: bounds.high, ..Node::default() };
    let (near, far) = interval(&own_box, start, aim)?;
    Some(Meeting {
        depth: min(max(depth, near), far),
        face: triangle.face,
        weights: [weights[0] / area, weights[1] / area, weights[2] / area],
    })
}

/// Twice the signed area between the ray and an edge.
#[inline(always)]
fn cross(p: [f32; 3], q: [f32; 3]) -> f32 {
    q[0] * p[1] - q[1] * p[0]
}

fn exact(p: [f32; 3], q: [f32; 3]) -> f32 {
    (q[0] as f64 * p[1] as f64 - q[1] as f64 * p[0] as f64) as f32
}
