//! Fans: many rays from one point that only ask whether they meet anything, traced as packets.
//!
//! Rays are sorted into the six sides of the cube around the point, so that a packet of [`LANES`] rays shares the axis
//! of its shear; one box or triangle is then tested against a packet in plain arrays that the compiler turns into vector
//! code. A lane whose triangle passes the packet's edge functions goes through `cast::meet`, the scalar definition of a
//! hit, so the answers are those of `Scene::occluded` to the bit.
//! Rays that follow one another in the input should point in similar directions (see `directions`): it costs time if
//! they do not, never correctness.

use super::bvh::{MAX_DEPTH, Node, max, min};
use super::cast::{Aim, NEXT, Scene, Start, Triangle, inverse_slope, main_axis, meet};
use glam::Vec3;

/// Rays in a packet. Of 4, 8 and 16, measured on spot and nefertiti.
pub const LANES: usize = 8;
/// Rays that are sorted at a time: 64 packets and one part-filled packet a cube side, on the stack.
pub const BLOCK: usize = 512;
const SIDES: usize = 6;
const PACKETS: usize = BLOCK / LANES + SIDES;

/// Rays of one cube side.
#[derive(Clone, Copy)]
struct Packet {
    slope: [[f32; LANES]; 2],
    inverse: [[f32; LANES]; 2],
    active: [u32; LANES],   // all ones for a ray that is still free
    ray: [u16; LANES],      // place in the block
}

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
        let start = Start::new(origin, self.reach());
        let empty = Packet {
            slope: [[0.0; LANES]; 2],
            inverse: [[1.0; LANES]; 2],
            active: [0; LANES],
            ray: [0; LANES],
        };
        let mut packets = [empty; PACKETS];
        let first = sort(&mut packets, directions);
        for side in 0..SIDES {
            for packet in &mut packets[first[side]..first[side + 1]] {
                let sign = if side % 2 == 0 { 1.0 } else { -1.0 };
                match side / 2 {
                    0 => self.trace::<0>(&start, sign, packet, &mut hit),
                    1 => self.trace::<1>(&start, sign, packet, &mut hit),
                    _ => self.trace::<2>(&start, sign, packet, &mut hit),
                }
            }
        }
        hit
    }

    fn trace<const AXIS: usize>(&self, start: &Start, sign: f32, packet: &mut Packet, hit: &mut [u64; BLOCK / 64]) {
        let mut waiting = heapless::Vec::<u32, { MAX_DEPTH + 1 }>::new();
        let mut at = Some(0);
        while let Some(node) = at {
            let node = &self.nodes[node as usize];
            at = None;
            if node.count > 0 {
                for triangle in &self.triangles[node.first as usize..][..node.count as usize] {
                    if may_meet::<AXIS>(triangle, start, sign, packet) && settle::<AXIS>(triangle, start, sign, packet, hit) {
                        return;
                    }
                }
            } else {
                let [a, b] = [0, 1].map(|i| &self.nodes[node.first as usize + i]);
                let (in_a, in_b) = (enters::<AXIS>(a, start, sign, packet), enters::<AXIS>(b, start, sign, packet));
                if in_a && in_b {
                    // The nearer along the axis first: near occluders are large.
                    let b_first = (b.low[AXIS] + b.high[AXIS]) * sign < (a.low[AXIS] + a.high[AXIS]) * sign;
                    waiting.push(node.first + !b_first as u32).unwrap_or_else(|_| unreachable!("one entry a level"));
                    at = Some(node.first + b_first as u32);
                } else if in_a || in_b {
                    at = Some(node.first + in_b as u32);
                }
            }
            at = at.or_else(|| waiting.pop());
        }
    }
}

/// Fills packets side by side of the cube, in the order of `directions`; returns each side's first packet. Rays without
/// a direction are left out.
fn sort(packets: &mut [Packet; PACKETS], directions: &[Vec3]) -> [usize; SIDES + 1] {
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
            for k in 0..2 {
                packet.slope[k][lane] = sides[k] / length;
                packet.inverse[k][lane] = inverse_slope(sides[k], length);
            }
            packet.active[lane] = !0;
            packet.ray[lane] = i as u16;
        }
    }
    first
}

/// Whether any active ray is inside the padded box at some depth: `cast::interval` over lanes.
#[inline(always)]
fn enters<const AXIS: usize>(node: &Node, start: &Start, sign: f32, packet: &Packet) -> bool {
    let (z, x) = (AXIS, NEXT[AXIS]);
    let y = NEXT[x];
    let low = |k: usize| node.low[k] - start.low[k];
    let high = |k: usize| node.high[k] - start.high[k];
    let (za, zb) = (low(z) * sign, high(z) * sign);
    let (z_near, z_far) = (max(min(za, zb), 0.0), max(za, zb));
    let (xa, xb, ya, yb) = (low(x), high(x), low(y), high(y));
    let mut any = 0;
    for i in 0..LANES {
        let (xa, xb) = (xa * packet.inverse[0][i], xb * packet.inverse[0][i]);
        let (ya, yb) = (ya * packet.inverse[1][i], yb * packet.inverse[1][i]);
        let near = max(max(z_near, min(xa, xb)), min(ya, yb));
        let far = min(min(z_far, max(xa, xb)), max(ya, yb));
        any |= if near <= far { packet.active[i] } else { 0 };
    }
    any != 0
}

/// Whether the edge functions of any active ray are not of both signs.
#[inline(always)]
fn may_meet<const AXIS: usize>(triangle: &Triangle, start: &Start, sign: f32, packet: &Packet) -> bool {
    let (z, x) = (AXIS, NEXT[AXIS]);
    let y = NEXT[x];
    let local = triangle.corners.map(|p| [p[x] - start.point[x], p[y] - start.point[y], (p[z] - start.point[z]) * sign]);
    let mut any = 0;
    for i in 0..LANES {
        let [a, b, c] =
            local.map(|p| [p[0] - packet.slope[0][i] * p[2], p[1] - packet.slope[1][i] * p[2]]);
        let (u, v, w) = (b_cross(b, c), b_cross(c, a), b_cross(a, b));
        let least = min(min(u, v), w);
        let most = max(max(u, v), w);
        any |= if least >= 0.0 || most <= 0.0 { packet.active[i] } else { 0 };
    }
    any != 0
}

#[inline(always)]
fn b_cross(p: [f32; 2], q: [f32; 2]) -> f32 {
    q[0] * p[1] - q[1] * p[0]
}

/// Gives the active rays to the scalar test; those that hit become inactive. True when none is left.
#[inline(never)]
fn settle<const AXIS: usize>(
    triangle: &Triangle,
    start: &Start,
    sign: f32,
    packet: &mut Packet,
    hit: &mut [u64; BLOCK / 64],
) -> bool {
    for i in 0..LANES {
        if packet.active[i] != 0 {
            let pair = |of: &[[f32; LANES]; 2]| [of[0][i], of[1][i]];
            let aim =
                Aim { axis: AXIS, sign, length: 1.0, slope: pair(&packet.slope), inverse: pair(&packet.inverse) };
            if meet(triangle, start, &aim).is_some() {
                packet.active[i] = 0;
                hit[packet.ray[i] as usize / 64] |= 1 << (packet.ray[i] % 64);
            }
        }
    }
    packet.active == [0; LANES]
}
