//! Fans that ask where each ray first meets the mesh: packets as in `fan`, near boxes first, a limit a ray.
//!
//! Boxes and triangles only filter, as there; a hit is what `intersect::meet` says, and equal depths go to the lowest
//! face, so the answers are those of `Scene::closest` to the bit. A child of a wide node is entered in order of its near
//! side along the packet's axis.

use super::bvh::MAX_DEPTH;
use super::cast::{Hit, Scene};
use super::fan::{BLOCK, Frustum, PACKETS, Packet, SIDES, enters, may_meet, sort};
use super::intersect::{Aim, Meeting, RayStart, meet};
use super::lanes::{LANES, Lanes, Widest};
use super::wide::WideNode;
use crate::base::stack::Stack;
use glam::Vec3;

impl Scene<'_> {
    /// Calls `found(i, hit)` for each of at most [`BLOCK`] rays from `origin` along `directions` that meets a face, with
    /// what [`closest`](Self::closest) answers. Rays that follow one another should point in similar directions.
    pub fn closest_each(&self, origin: Vec3, directions: &[Vec3], mut found: impl FnMut(usize, Hit)) {
        debug_assert!(directions.len() <= BLOCK, "one block at a time");
        if self.nodes.is_empty() {
            return;
        }
        let (start, loose) = (RayStart::new(origin, self.reach()), RayStart::loose(origin, self.reach()));
        let mut packets = [Packet::EMPTY; PACKETS];
        let first = sort(&mut packets, directions);
        for side in 0..SIDES {
            for packet in &packets[first[side]..first[side + 1]] {
                let sign = if side % 2 == 0 { 1.0 } else { -1.0 };
                let best = match side / 2 {
                    0 => self.trace_nearest::<Widest, 0>(&start, &loose, sign, packet),
                    1 => self.trace_nearest::<Widest, 1>(&start, &loose, sign, packet),
                    _ => self.trace_nearest::<Widest, 2>(&start, &loose, sign, packet),
                };
                for (lane, best) in best.iter().enumerate() {
                    if let Some(Meeting { depth, face, weights }) = *best {
                        let ray = packet.ray[lane] as usize;
                        let length = directions[ray].to_array()[side / 2].abs();
                        found(ray, Hit { distance: depth / length, face, weights });
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn trace_nearest<L: Lanes, const AXIS: usize>(
        &self,
        start: &RayStart,
        loose: &RayStart,
        sign: f32,
        packet: &Packet,
    ) -> [Option<Meeting>; LANES] {
        let frustum = Frustum::<L>::around(packet);
        let (mut best, mut limit) = ([None; LANES], [f32::INFINITY; LANES]);
        let mut waiting = Stack::<(u32, u32), { MAX_DEPTH + 1 }>::new();
        let (mut at, mut children) = (0, frustum.enters::<AXIS>(&self.wide[0], loose, sign));
        loop {
            while children == 0 {
                match waiting.pop() {
                    Some(next) => (at, children) = next,
                    None => return best,
                }
            }
            let node = &self.wide[at as usize];
            let child = nearest_child::<AXIS>(node, children, sign);
            children &= !(1 << child);
            let (first, count) = (node.first[child], node.count[child]);
            if !enters::<L, AXIS>(&node.child(child), start, sign, packet, &limit) {
                continue;
            }
            if count == 0 {
                if children != 0 {
                    waiting.push((at, children));
                }
                at = first;
                children = frustum.enters::<AXIS>(&self.wide[at as usize], loose, sign);
                continue;
            }
            for triangle in &self.triangles[first as usize..][..count as usize] {
                let mut lanes = may_meet::<L, AXIS>(triangle, start, sign, packet);
                while lanes != 0 {
                    let i = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let pair = |of: &[[f32; LANES]; 2]| [of[0][i], of[1][i]];
                    let (slope, inverse) = (pair(&packet.slope), pair(&packet.inverse));
                    let aim = Aim { axis: AXIS, sign, length: 1.0, slope, inverse };
                    if let Some(meeting) = meet(triangle, start, &aim)
                        && best[i].is_none_or(|b: Meeting| (meeting.depth, meeting.face) < (b.depth, b.face))
                    {
                        (best[i], limit[i]) = (Some(meeting), meeting.depth);
                    }
                }
            }
        }
    }
}

/// Of the children in `bits`, the one whose box begins first along the axis; the first of equals.
#[inline(always)]
fn nearest_child<const AXIS: usize>(node: &WideNode, bits: u32, sign: f32) -> usize {
    let mut left = bits;
    let (mut best, mut least) = (bits.trailing_zeros() as usize, f32::INFINITY);
    while left != 0 {
        let i = left.trailing_zeros() as usize;
        left &= left - 1;
        let near = if sign > 0.0 { node.low[AXIS][i] } else { -node.high[AXIS][i] };
        if near < least {
            (best, least) = (i, near);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f32;
    use crate::rays::cast::Ray;
    use crate::rays::cast::tests::{rays, scene, terrain};
    use std::{vec, vec::Vec};

    #[test]
    fn a_fan_meets_first_what_its_rays_meet_first() {
        let (positions, faces) = terrain(20);
        let scene = scene(&positions, &faces);
        let mut hits = 0;
        for i in 0..150u64 {
            let origin = match i % 3 {
                0 => positions[i as usize] + Vec3::Z * 1e-4,
                1 => positions[i as usize],
                _ => Vec3::from_array([0, 1, 2].map(|k| unit_f32(9, k, i) * 2.0 - 0.5)),
            };
            let mut directions: Vec<_> = rays(&positions, &faces, 3 * i).iter().map(|r| r.direction).collect();
            directions.extend([Vec3::X, Vec3::NEG_Z, Vec3::ZERO, Vec3::NAN, Vec3::new(1.0, -1.0, 0.0)]);
            for block in directions.chunks(BLOCK) {
                let mut found = vec![None; block.len()];
                scene.closest_each(origin, block, |k, hit| found[k] = Some(hit));
                for (found, direction) in found.iter().zip(block) {
                    assert_eq!(*found, scene.closest(&Ray { origin, direction: *direction }), "{origin} {direction}");
                    hits += usize::from(found.is_some());
                }
            }
        }
        assert!(hits > 5_000, "{hits}");
    }

    #[test]
    fn an_empty_mesh_is_met_nowhere() {
        scene(&[], &[]).closest_each(Vec3::ZERO, &[Vec3::X; 3], |_, _| panic!("no face"));
    }
}
