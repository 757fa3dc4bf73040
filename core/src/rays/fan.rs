//! Fans: many rays from one point that only ask whether they meet anything, traced as packets.
//!
//! Rays are sorted into the six sides of the cube around the point, so that a packet of eight shares the axis of its
//! shear. A pyramid around the packet is tested against eight boxes of a wide node at once, each box that it touches
//! against the eight rays, and so is each triangle of a leaf; a ray that passes a triangle's edge functions goes
//! through `intersect::meet`, the definition of a hit. All tests but that one only filter, and never lose what it accepts:
//! the answers are those of `Scene::occluded`.
//! Rays that follow one another in the input should point in similar directions (see `directions`): it costs time if
//! they do not, never correctness.
//!
//! Measured, seconds for 512 uniform and 512 cosine rays a vertex on (spot, nefertiti): this 0.22, 6.3; without the
//! rays' own box test 0.27, 22; binary nodes and no pyramid 0.36, 9.2; single rays go on alone where only one enters
//! a box 0.22, 5.9, not worth its second traversal.

use super::bvh::{MAX_DEPTH, Node, max, min};
use super::cast::Scene;
use super::intersect::{Aim, NEXT, RayStart, Triangle, inverse_slope, main_axis, meet};
use super::lanes::{LANES, Lanes, Widest};
use super::wide::WideNode;
use crate::base::stack::Stack;
use glam::Vec3;

/// Rays that are sorted at a time: up to 64 packets and one part-filled packet a cube side, on the stack.
pub const BLOCK: usize = 512;
pub(super) const SIDES: usize = 6;
pub(super) const PACKETS: usize = BLOCK / LANES + SIDES;

/// Rays of one cube side.
#[derive(Clone, Copy)]
pub(super) struct Packet {
    pub slope: [[f32; LANES]; 2],
    pub inverse: [[f32; LANES]; 2],
    pub active: u32,       // bit i: ray i is still free
    pub ray: [u16; LANES], // place in the block
}

impl Packet {
    /// No ray.
    pub const EMPTY: Packet =
        Packet { slope: [[0.0; LANES]; 2], inverse: [[1.0; LANES]; 2], active: 0, ray: [0; LANES] };
}

/// No limit on the depths of a packet's rays.
const FREE: [f32; LANES] = [f32::INFINITY; LANES];

impl Scene<'_> {
    /// How many of the rays from `origin` along `directions` meet a face: the sum of [`occluded`](Self::occluded).
    pub fn occluded_count(&self, origin: Vec3, directions: &[Vec3]) -> u32 {
        let mut count = 0;
        for block in directions.chunks(BLOCK) {
            count += self.occluded_block(origin, block).iter().map(|w| w.count_ones()).sum::<u32>();
        }
        count
    }

    /// One bit a ray of the block, set where it meets a face.
    fn occluded_block(&self, origin: Vec3, directions: &[Vec3]) -> [u64; BLOCK / 64] {
        let mut hit = [0; BLOCK / 64];
        if self.nodes.is_empty() {
            return hit;
        }
        let (start, loose) = (RayStart::new(origin, self.reach()), RayStart::loose(origin, self.reach()));
        let mut packets = [Packet::EMPTY; PACKETS];
        let first = sort(&mut packets, directions);
        for side in 0..SIDES {
            for packet in &mut packets[first[side]..first[side + 1]] {
                let sign = if side % 2 == 0 { 1.0 } else { -1.0 };
                match side / 2 {
                    0 => self.trace::<Widest, 0>(&start, &loose, sign, packet, &mut hit),
                    1 => self.trace::<Widest, 1>(&start, &loose, sign, packet, &mut hit),
                    _ => self.trace::<Widest, 2>(&start, &loose, sign, packet, &mut hit),
                }
            }
        }
        hit
    }

    #[inline(always)]
    fn trace<L: Lanes, const AXIS: usize>(
        &self,
        start: &RayStart,
        loose: &RayStart,
        sign: f32,
        packet: &mut Packet,
        hit: &mut [u64; BLOCK / 64],
    ) {
        let frustum = Frustum::<L>::around(packet);
        let mut waiting = Stack::<(u32, u32), { MAX_DEPTH + 1 }>::new();
        let (mut at, mut children) = (0, frustum.enters::<AXIS>(&self.wide[0], loose, sign));
        loop {
            while children == 0 {
                match waiting.pop() {
                    Some(next) => (at, children) = next,
                    None => return,
                }
            }
            let node = &self.wide[at as usize];
            let child = children.trailing_zeros() as usize;
            children &= children - 1;
            let (first, count) = (node.first[child], node.count[child]);
            if !enters::<L, AXIS>(&node.child(child), start, sign, packet, &FREE) {
                continue;
            }
            if count == 0 {
                if children != 0 {
                    waiting.push((at, children));
                }
                at = first;
                children = frustum.enters::<AXIS>(&self.wide[at as usize], loose, sign);
            } else {
                for triangle in &self.triangles[first as usize..][..count as usize] {
                    let lanes = may_meet::<L, AXIS>(triangle, start, sign, packet);
                    if lanes != 0 {
                        settle::<AXIS>(triangle, start, sign, lanes, packet, hit);
                        if packet.active == 0 {
                            return;
                        }
                    }
                }
            }
        }
    }
}

/// The pyramid around a packet: the least and the largest slope to both sides.
pub(super) struct Frustum<L> {
    least: [L; 2],
    most: [L; 2],
}

impl<L: Lanes> Frustum<L> {
    #[inline(always)]
    pub fn around(packet: &Packet) -> Self {
        let (mut least, mut most) = ([1.0f32; 2], [-1.0f32; 2]);
        for k in 0..2 {
            for i in 0..LANES {
                if packet.active & 1 << i != 0 {
                    least[k] = min(packet.slope[k][i], least[k]);
                    most[k] = max(packet.slope[k][i], most[k]);
                }
            }
        }
        let splat = |x: [f32; 2]| [L::splat(x[0]), L::splat(x[1])];
        Self { least: splat(least), most: splat(most) }
    }

    /// Bit i: the pyramid may touch the padded box of child i. Its four sides and its apex are tested alone.
    #[inline(always)]
    pub fn enters<const AXIS: usize>(&self, node: &WideNode, loose: &RayStart, sign: f32) -> u32 {
        let (z, x) = (AXIS, NEXT[AXIS]);
        let y = NEXT[x];
        let low = |k: usize| L::load(&node.low[k]).sub(L::splat(loose.low[k]));
        let high = |k: usize| L::load(&node.high[k]).sub(L::splat(loose.high[k]));
        let (za, zb) = (low(z).mul(L::splat(sign)), high(z).mul(L::splat(sign)));
        let (near, far) = (za.min(zb).max(L::splat(0.0)), za.max(zb));
        let mut bits = near.le(far);
        for (k, i) in [(x, 0), (y, 1)] {
            bits &= self.least[i].mul(near).min(self.least[i].mul(far)).le(high(k));
            bits &= low(k).le(self.most[i].mul(near).max(self.most[i].mul(far)));
        }
        bits
    }
}

/// Fills packets side by side of the cube, in the order of `directions`; returns each side's first packet. Rays without
/// a direction are left out.
pub(super) fn sort(packets: &mut [Packet; PACKETS], directions: &[Vec3]) -> [usize; SIDES + 1] {
    let side_of = |d: &Vec3| {
        let d = d.to_array();
        let axis = main_axis(d);
        let length = d[axis].abs();
        (length > 0.0 && length < f32::INFINITY).then_some((2 * axis + (d[axis] < 0.0) as usize, axis, length))
    };
    let mut count = [0; SIDES];
    directions.iter().filter_map(side_of).for_each(|s| count[s.0] += 1);
    let mut first = [0; SIDES + 1];
    for side in 0..SIDES {
        first[side + 1] = first[side] + usize::div_ceil(count[side], LANES);
    }
    let mut next: [usize; SIDES] = core::array::from_fn(|side| first[side] * LANES);
    for (i, d) in directions.iter().enumerate() {
        if let Some((side, axis, length)) = side_of(d) {
            let (packet, lane) = (&mut packets[next[side] / LANES], next[side] % LANES);
            next[side] += 1;
            let d = d.to_array();
            let sides = [d[NEXT[axis]], d[NEXT[NEXT[axis]]]];
            for (k, side) in sides.into_iter().enumerate() {
                packet.slope[k][lane] = side / length;
                packet.inverse[k][lane] = inverse_slope(side, length);
            }
            packet.active |= 1 << lane;
            packet.ray[lane] = i as u16;
        }
    }
    first
}

/// Whether any active ray is inside the padded box at some depth up to its limit: `intersect::interval` over lanes.
#[inline(always)]
pub(super) fn enters<L: Lanes, const AXIS: usize>(
    node: &Node,
    start: &RayStart,
    sign: f32,
    packet: &Packet,
    limit: &[f32; LANES],
) -> bool {
    let (z, x) = (AXIS, NEXT[AXIS]);
    let y = NEXT[x];
    let low = |k: usize| node.low[k] - start.low[k];
    let high = |k: usize| node.high[k] - start.high[k];
    let (za, zb) = (low(z) * sign, high(z) * sign);
    let (z_near, z_far) = (max(min(za, zb), 0.0), max(za, zb));
    let inverse = [L::load(&packet.inverse[0]), L::load(&packet.inverse[1])];
    let (xa, xb) = (L::splat(low(x)).mul(inverse[0]), L::splat(high(x)).mul(inverse[0]));
    let (ya, yb) = (L::splat(low(y)).mul(inverse[1]), L::splat(high(y)).mul(inverse[1]));
    let near = L::splat(z_near).max(xa.min(xb)).max(ya.min(yb));
    let far = L::splat(z_far).min(xa.max(xb)).min(ya.max(yb)).min(L::load(limit));
    near.le(far) & packet.active != 0
}

/// Whether the edge functions of any active ray are not of both signs.
#[inline(always)]
pub(super) fn may_meet<L: Lanes, const AXIS: usize>(
    triangle: &Triangle,
    start: &RayStart,
    sign: f32,
    packet: &Packet,
) -> u32 {
    let (z, x) = (AXIS, NEXT[AXIS]);
    let y = NEXT[x];
    let slope = [L::load(&packet.slope[0]), L::load(&packet.slope[1])];
    let corner = |p: &[f32; 3]| {
        let depth = L::splat((p[z] - start.point[z]) * sign);
        let side = |k: usize, slope: L| L::splat(p[k] - start.point[k]).sub(slope.mul(depth));
        [side(x, slope[0]), side(y, slope[1])]
    };
    let [a, b, c] = [corner(&triangle.corners[0]), corner(&triangle.corners[1]), corner(&triangle.corners[2])];
    let cross = |p: [L; 2], q: [L; 2]| q[0].mul(p[1]).sub(q[1].mul(p[0]));
    let (u, v, w) = (cross(b, c), cross(c, a), cross(a, b));
    let zero = L::splat(0.0);
    (zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero)) & packet.active
}

/// Gives the rays of `lanes` to the scalar test; those that hit become inactive.
fn settle<const AXIS: usize>(
    triangle: &Triangle,
    start: &RayStart,
    sign: f32,
    mut lanes: u32,
    packet: &mut Packet,
    hit: &mut [u64; BLOCK / 64],
) {
    while lanes != 0 {
        let i = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        let pair = |of: &[[f32; LANES]; 2]| [of[0][i], of[1][i]];
        let aim = Aim { axis: AXIS, sign, length: 1.0, slope: pair(&packet.slope), inverse: pair(&packet.inverse) };
        if meet(triangle, start, &aim).is_some() {
            packet.active &= !(1 << i);
            hit[packet.ray[i] as usize / 64] |= 1 << (packet.ray[i] % 64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f32;
    use crate::rays::cast::Ray;
    use crate::rays::cast::tests::{rays, scene, terrain};
    use std::vec::Vec;

    #[test]
    fn a_fan_hits_what_its_rays_hit_one_by_one() {
        let (positions, faces) = terrain(20);
        let scene = scene(&positions, &faces);
        let mut hits = 0;
        for i in 0..200u64 {
            let origin = match i % 3 {
                0 => positions[i as usize] + Vec3::Z * 1e-4,
                1 => positions[i as usize],
                _ => Vec3::from_array([0, 1, 2].map(|k| unit_f32(9, k, i) * 2.0 - 0.5)),
            };
            // Sorted or not, on axes, at vertices and edges, without direction.
            let mut directions: Vec<_> = rays(&positions, &faces, 300 + 3 * i).iter().map(|r| r.direction).collect();
            directions.extend(positions.iter().skip(i as usize).take(60).map(|p| *p - origin));
            directions.extend([Vec3::X, Vec3::NEG_Z, Vec3::ZERO, Vec3::NAN, Vec3::new(1.0, -1.0, 0.0)]);
            for block in directions.chunks(BLOCK) {
                let found = scene.occluded_block(origin, block);
                for (k, direction) in block.iter().enumerate() {
                    let bit = found[k / 64] >> (k % 64) & 1 == 1;
                    assert_eq!(bit, scene.occluded(&Ray { origin, direction: *direction }), "{origin} {direction}");
                    hits += bit as usize;
                }
            }
        }
        assert!(hits > 10_000);
    }

    #[test]
    fn counts_add_up_over_blocks() {
        let (positions, faces) = terrain(6);
        let scene = scene(&positions, &faces);
        let down = [Vec3::NEG_Z; BLOCK + 7];
        assert_eq!(scene.occluded_count(Vec3::new(0.5, 0.5, 2.0), &down), BLOCK as u32 + 7);
        assert_eq!(scene.occluded_count(Vec3::new(0.5, 0.5, 2.0), &[]), 0);
    }
}
