//! Casting rays: watertight intersection (Woop, Benthin, Wald 2013) over a checked, re-boxed copy of any builder's tree.
//!
//! A hit is a property of the ray and the triangle alone: the signs of the three edge functions, and a depth clamped to
//! the interval in which the ray is inside the triangle's own padded box. Boxes of nodes are tested by the same
//! formula, whose every operation is monotone in the box, so a node's interval holds its triangles' intervals to the
//! last bit and no tree can lose or add a hit. Equal depths go to the lowest face.
//! Guaranteed: no ray passes between two triangles that share an edge. Degenerate triangles are never hit; a ray of
//! zero or non-finite direction hits nothing.
//! Limits: positions of magnitude 2^-40 to 2^40 (callers scale to the unit box); depth on a triangle seen edge-on is
//! that of its box.

use super::bvh::{Bounds, BuildBvh, BvhError, MAX_DEPTH, Node, max, min};
use super::wide::{WideNode, collapse, wide_count};
use crate::base::scratch::{Scratch, bytes_for};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Boxes are padded by this share of the coordinates met on the way: 16 roundings, where the intersection has about 6.
const PAD: f32 = 1.0 / (1 << 20) as f32;
/// Largest inverse slope: a ray steeper than this stays within 2^-38 of its axis, far inside the padding.
const STEEPEST: f32 = (1u64 << 40) as f32;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts; the start itself is not part of it.
    pub origin: Vec3,
    /// Where it goes; any length but zero.
    pub direction: Vec3,
}

/// Where a ray meets a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the ray's direction.
    pub distance: f32,
    /// The face.
    pub face: u32,
    /// Barycentric weights of the face's corners; they sum to 1.
    pub weights: [f32; 3],
}

/// Three corners and the face that they came from.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Triangle {
    pub corners: [[f32; 3]; 3],
    pub face: u32,
}

/// A mesh that rays can be cast at.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    pub(super) nodes: &'a [Node],         // children after their parents, siblings side by side
    pub(super) wide: &'a [WideNode],      // the same tree for packets
    pub(super) triangles: &'a [Triangle], // in the order of the leaves
    reach: f32,                           // largest coordinate
}

impl<'a> Scene<'a> {
    /// Scratch bytes that [`new`](Self::new) asks for; the scene itself keeps about 104 a face.
    pub fn need(face_count: usize, builder: &dyn BuildBvh) -> usize {
        2 * bytes_for::<Node>(2 * face_count)
            + bytes_for::<Triangle>(face_count)
            + bytes_for::<WideNode>(wide_count(face_count))
            + bytes_for::<u32>(face_count)
            + bytes_for::<u8>(face_count).max(builder.need(face_count))
    }

    /// Builds and checks the hierarchy of `faces`. O(f log f).
    pub fn new(
        positions: &[Vec3],
        faces: &[[u32; 3]],
        builder: &dyn BuildBvh,
        scratch: &mut Scratch<'a>,
    ) -> Result<Self, BvhError> {
        scratch.require(Self::need(faces.len(), builder))?;
        if let Some(face) = faces.iter().position(|f| f.iter().any(|v| *v as usize >= positions.len())) {
            return Err(BvhError::BadFace { face });
        }
        let nodes = scratch.take::<Node>(2 * faces.len())?;
        let triangles = scratch.take::<Triangle>(faces.len())?;
        let wide = scratch.take::<WideNode>(wide_count(faces.len()))?;
        let mut frame = scratch.frame();
        let built = frame.take::<Node>(2 * faces.len())?;
        let order = frame.take::<u32>(faces.len())?;
        let used = builder.build(built, order, positions, faces, frame.frame())?;
        let built = built.get(..used).ok_or(BvhError::BadNode { node: used })?;
        let node_count = copy_tree(nodes, triangles, built, order)?;
        let seen = frame.take::<u8>(faces.len())?;
        for triangle in triangles.iter_mut() {
            let face = triangle.face as usize;
            match seen.get_mut(face) {
                Some(seen) if *seen == 0 => *seen = 1,
                _ => return Err(BvhError::BadOrder { face }),
            }
            triangle.corners = faces[face].map(|v| positions[v as usize].to_array());
        }
        let nodes = &mut nodes[..node_count];
        refit(nodes, triangles);
        let wide_used = collapse(wide, nodes);
        let wide = &wide[..wide_used];
        let reach = triangles.iter().flat_map(|t| t.corners.as_flattened()).fold(0.0, |r, x| max(x.abs(), r));
        Ok(Self { nodes, wide, triangles, reach })
    }

    /// The largest magnitude of a coordinate.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// The first face along the ray, on either side; equal distances give the lowest face.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let (start, aim) = (Start::new(ray.origin, self.reach), Aim::new(ray.direction)?);
        let mut best: Option<Meeting> = None;
        self.visit(&start, &aim, |triangle, farthest| {
            if let Some(meeting) = meet(triangle, &start, &aim)
                && best.is_none_or(|b| (meeting.depth, meeting.face) < (b.depth, b.face))
            {
                best = Some(meeting);
                *farthest = meeting.depth;
            }
            true
        });
        best.map(|b| Hit { distance: b.depth / aim.length, face: b.face, weights: b.weights })
    }

    /// Whether the ray meets any face.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let Some(aim) = Aim::new(ray.direction) else { return false };
        let start = Start::new(ray.origin, self.reach);
        let mut free = true;
        self.visit(&start, &aim, |triangle, _| {
            free = meet(triangle, &start, &aim).is_none();
            free
        });
        !free
    }

    /// Calls `see` on the triangles of every leaf that the ray enters at a depth up to `farthest`, near leaves first,
    /// until it answers false.
    fn visit(&self, start: &Start, aim: &Aim, mut see: impl FnMut(&Triangle, &mut f32) -> bool) {
        let mut farthest = f32::INFINITY;
        let mut waiting = heapless::Vec::<(u32, f32), { MAX_DEPTH + 1 }>::new();
        let enter = |node: u32| interval(&self.nodes[node as usize], start, aim);
        let mut at = if self.nodes.is_empty() { None } else { enter(0).map(|i| (0, i.0)) };
        while let Some((node, near)) = at {
            at = None;
            if near <= farthest {
                let node = &self.nodes[node as usize];
                let (a, b) = (node.first, node.first + 1);
                if node.count > 0 {
                    for triangle in &self.triangles[node.first as usize..][..node.count as usize] {
                        if !see(triangle, &mut farthest) {
                            return;
                        }
                    }
                } else {
                    at = match (enter(a), enter(b)) {
                        (Some(i), Some(j)) => {
                            let (first, second) = if j.0 < i.0 { ((b, j.0), (a, i.0)) } else { ((a, i.0), (b, j.0)) };
                            waiting.push(second).unwrap_or_else(|_| unreachable!("one entry a level"));
                            Some(first)
                        }
                        (Some(i), None) => Some((a, i.0)),
                        (None, Some(j)) => Some((b, j.0)),
                        (None, None) => None,
                    };
                }
            }
            at = at.or_else(|| waiting.pop());
        }
    }
}

/// Copies a builder's tree depth first, siblings side by side and triangles in the order of the leaves, with checks;
/// returns the number of nodes. The caller checks that every face came along once.
fn copy_tree(nodes: &mut [Node], triangles: &mut [Triangle], built: &[Node], order: &[u32]) -> Result<usize, BvhError> {
    if order.is_empty() {
        return Ok(0);
    }
    let (mut placed, mut used) = (0, 1);
    let mut waiting = heapless::Vec::<(usize, usize, usize), { MAX_DEPTH + 1 }>::new();
    let mut at = Some((0, 0, 0)); // (built node, own node, depth)
    while let Some((from, to, depth)) = at {
        let node = built.get(from).ok_or(BvhError::BadNode { node: from })?;
        let (first, count) = (node.first as usize, node.count as usize);
        at = if count > 0 {
            let listed = order.get(first..first.saturating_add(count)).ok_or(BvhError::BadNode { node: from })?;
            let own = triangles.get_mut(placed..placed + count).ok_or(BvhError::BadNode { node: from })?;
            own.iter_mut().zip(listed).for_each(|(t, face)| t.face = *face);
            nodes[to] = Node { first: placed as u32, count: node.count, ..Node::default() };
            placed += count;
            waiting.pop()
        } else {
            // More nodes than a tree over the faces can have: some node is met twice.
            if used + 2 > nodes.len() {
                return Err(BvhError::BadNode { node: from });
            }
            if depth == MAX_DEPTH {
                return Err(BvhError::TooDeep);
            }
            nodes[to] = Node { first: used as u32, ..Node::default() };
            waiting.push((first + 1, used + 1, depth + 1)).map_err(|_| BvhError::TooDeep)?;
            used += 2;
            Some((first, used - 2, depth + 1))
        };
    }
    if placed == order.len() { Ok(used) } else { Err(BvhError::BadOrder { face: placed }) }
}

/// Boxes from the leaves up; children stand after their parents.
fn refit(nodes: &mut [Node], triangles: &[Triangle]) {
    for i in (0..nodes.len()).rev() {
        let (first, count) = (nodes[i].first as usize, nodes[i].count as usize);
        let mut bounds = Bounds::EMPTY;
        if count > 0 {
            triangles[first..first + count].iter().for_each(|t| bounds.join(&Bounds::of(&t.corners)));
        } else {
            nodes[first..first + 2].iter().for_each(|n| bounds.join(&Bounds { low: n.low, high: n.high }));
        }
        (nodes[i].low, nodes[i].high) = (bounds.low, bounds.high);
    }
}

/// A ray's origin, and the padding that goes with it: `low` is taken from a box's lower corner, `high` from its upper.
#[derive(Clone, Copy)]
pub(super) struct Start {
    pub point: [f32; 3],
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Start {
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
fn interval(node: &Node, start: &Start, aim: &Aim) -> Option<(f32, f32)> {
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
pub(super) fn meet(triangle: &Triangle, start: &Start, aim: &Aim) -> Option<Meeting> {
    let (z, x) = (aim.axis, NEXT[aim.axis]);
    let y = NEXT[x];
    let local = triangle.corners.map(|p| {
        let depth = (p[z] - start.point[z]) * aim.sign;
        [p[x] - start.point[x] - aim.slope[0] * depth, p[y] - start.point[y] - aim.slope[1] * depth, depth]
    });
    let [a, b, c] = local;
    let weights = edge_functions(a, b, c);
    if weights.iter().any(|w| *w < 0.0) && weights.iter().any(|w| *w > 0.0) {
        return None;
    }
    let area = weights[0] + weights[1] + weights[2];
    let depth = (weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2]) / area;
    // Also false where the area is zero.
    if !(depth > 0.0) {
        return None;
    }
    let bounds = Bounds::of(&triangle.corners);
    let own_box = Node { low: bounds.low, high: bounds.high, ..Node::default() };
    let (near, far) = interval(&own_box, start, aim)?;
    Some(Meeting { depth: min(max(depth, near), far), face: triangle.face, weights: weights.map(|w| w / area) })
}

/// Twice the signed areas of the three parts in which the ray cuts the sheared triangle. Where f32 gives a zero, f64
/// decides the sign: its products are exact.
#[inline(always)]
fn edge_functions(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let weights = [cross(b, c), cross(c, a), cross(a, b)];
    if weights.contains(&0.0) { [exact(b, c), exact(c, a), exact(a, b)] } else { weights }
}

#[inline(always)]
fn cross(p: [f32; 3], q: [f32; 3]) -> f32 {
    q[0] * p[1] - q[1] * p[0]
}

#[cold]
fn exact(p: [f32; 3], q: [f32; 3]) -> f32 {
    (q[0] as f64 * p[1] as f64 - q[1] as f64 * p[0] as f64) as f32
}
