//! The point of a mesh that is closest to a given one, among faces that a caller accepts.
//!
//! A tree whose every node holds one face and the box of all faces below it, in order of medians: no pointers, one box a
//! face. The closest point of a triangle by its Voronoi regions (Ericson, *Real-Time Collision Detection*, 2005, 5.1.5).
//! Equal distances go to the lower face, so the answer does not depend on the tree. A face without area counts as the segment or
//! point that it is. Cost: O(f log^2 f) to build, about O(log f) a question on surfaces.

use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::stack::Stack;
use crate::mesh::view::MeshView;
use glam::DVec3;

/// Ranges that wait at the most: two a level of 32.
const WAITING: usize = 66;

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The face.
    pub face: u32,
    /// Weights of its corners.
    pub weights: [f64; 3],
    /// Squared distance.
    pub squared: f64,
}

/// Faces in boxes.
pub struct ClosestTree<'a> {
    mesh: MeshView<'a>,
    face: &'a [u32],         // (f) by place; a range's face is its middle one
    boxes: &'a [[DVec3; 2]], // (f) of the whole range whose middle is at that place
}

/// Bytes that [`ClosestTree::new`] keeps.
pub const fn closest_tree_need(faces: usize) -> usize {
    bytes_for::<u32>(faces).saturating_add(bytes_for::<[DVec3; 2]>(faces))
}

impl<'a> ClosestTree<'a> {
    /// Builds the tree.
    pub fn new<'k: 'a>(mesh: MeshView<'a>, keep: &mut Scratch<'k>) -> Result<Self, ScratchTooSmall> {
        let count = mesh.faces.len();
        let face = keep.take::<u32>(count)?;
        let boxes = keep.take::<[DVec3; 2]>(count)?;
        face.iter_mut().enumerate().for_each(|(i, f)| *f = i as u32);
        let corners = |f: u32| mesh.faces[f as usize].map(|v| mesh.positions[v as usize]);
        let mut waiting = Stack::<[u32; 2], WAITING>::new();
        waiting.push([0, count as u32]);
        while let Some([low, high]) = waiting.pop() {
            if low >= high {
                continue;
            }
            let range = &mut face[low as usize..high as usize];
            let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for p in range.iter().flat_map(|f| corners(*f)) {
                (least, most) = (least.min(p), most.max(p));
            }
            let middle = low + (high - low) / 2;
            boxes[middle as usize] = [least, most];
            let side = (most - least).to_array();
            let axis = (1..3).fold(0, |best, k| if side[k] > side[best] { k } else { best });
            let along = |f: u32| corners(f).iter().map(|p| p.to_array()[axis]).sum::<f64>();
            sort::select_by(range, (middle - low) as usize, |a, b| along(*a).total_cmp(&along(*b)).then(a.cmp(b)));
            // The smaller half last, so that it is done first and the stack stays low.
            waiting.push([low, middle]);
            waiting.push([middle + 1, high]);
        }
        Ok(Self { mesh, face, boxes })
    }

    /// The closest point among the faces that `accept` answers true for; none where there is no such face.
    pub fn find(&self, p: DVec3, accept: impl Fn(u32) -> bool) -> Option<Closest> {
        self.find_within(p, f64::INFINITY, accept)
    }

    /// The same, nearer than the root of `squared`.
    pub fn find_within(&self, p: DVec3, squared: f64, accept: impl Fn(u32) -> bool) -> Option<Closest> {
        let mut best = None::<Closest>;
        let limit = |best: &Option<Closest>| best.map_or(squared, |b| b.squared);
        let mut waiting = Stack::<[u32; 2], WAITING>::new();
        waiting.push([0, self.face.len() as u32]);
        while let Some([low, high]) = waiting.pop() {
            if low >= high {
                continue;
            }
            let middle = low + (high - low) / 2;
            if self.gap(middle, p) > limit(&best) {
                continue;
            }
            let face = self.face[middle as usize];
            if accept(face) {
                let (weights, d) =
                    on_triangle(p, self.mesh.faces[face as usize].map(|v| self.mesh.positions[v as usize]));
                if d < limit(&best) || best.is_some_and(|b| d == b.squared && face < b.face) {
                    best = Some(Closest { face, weights, squared: d });
                }
            }
            let halves = [[low, middle], [middle + 1, high]];
            let gap = halves.map(|[a, b]| if a < b { self.gap(a + (b - a) / 2, p) } else { f64::INFINITY });
            let order = if gap[0] <= gap[1] { [1, 0] } else { [0, 1] };
            order.into_iter().filter(|i| gap[*i] <= limit(&best)).for_each(|i| waiting.push(halves[i]));
        }
        best
    }

    /// Squared distance from the box at `place`.
    fn gap(&self, place: u32, p: DVec3) -> f64 {
        let [low, high] = self.boxes[place as usize];
        (low - p).max(p - high).max(DVec3::ZERO).length_squared()
    }
}

/// Weights of the corners at the point of a triangle that is closest to `p`, and its squared distance.
pub fn on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> ([f64; 3], f64) {
    let weights = region(p, a, b, c);
    let at = a * weights[0] + b * weights[1] + c * weights[2];
    (weights, at.distance_squared(p))
}

fn region(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::unit_f64;
    use std::{vec, vec::Vec};

    fn point(seed: u64, i: u64) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|k| unit_f64(seed, k, i)))
    }

    #[test]
    fn the_tree_finds_what_looking_at_every_face_finds() {
        let positions: Vec<DVec3> = (0..300).map(|i| point(1, i)).collect();
        // Every seventh is a segment, every eleventh a point.
        let faces: Vec<[u32; 3]> = (0..100)
            .map(|f| [3 * f, if f % 11 == 0 { 3 * f } else { 3 * f + 1 }, 3 * f + if f % 7 == 0 { 1 } else { 2 }])
            .map(|f| if f[0] == f[1] { [f[0]; 3] } else { f })
            .collect();
        let mesh = MeshView { positions: &positions, faces: &faces };
        let mut bytes = vec![0; closest_tree_need(100)];
        let tree = ClosestTree::new(mesh, &mut Scratch::new(&mut bytes)).unwrap();
        for i in 0..400 {
            let p = point(2, i) * 1.4 - 0.2;
            let accept = |f: u32| !u64::from(f).is_multiple_of(1 + i % 4);
            let plain = (0..100u32).filter(|f| accept(*f)).map(|face| {
                let (weights, squared) = on_triangle(p, faces[face as usize].map(|v| positions[v as usize]));
                Closest { face, weights, squared }
            });
            let plain = plain.min_by(|a, b| a.squared.total_cmp(&b.squared).then(a.face.cmp(&b.face)));
            assert_eq!(tree.find(p, accept), plain, "{i}");
        }
        assert_eq!(tree.find(DVec3::ZERO, |_| false), None);
    }

    #[test]
    fn no_point_of_a_triangle_is_closer() {
        for i in 0..200 {
            let t = [0, 1, 2].map(|k| point(3, 3 * i + k));
            let p = point(4, i) * 2.0 - 0.5;
            let (weights, d) = on_triangle(p, t);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12 && weights.iter().all(|w| *w > -1e-12));
            for k in 0..400 {
                let (u, v) = (f64::from(k % 20) / 19.0, f64::from(k / 20) / 19.0);
                let other = t[0] * (1.0 - u) + (t[1] * (1.0 - v) + t[2] * v) * u;
                assert!(other.distance_squared(p) >= d - 1e-12);
            }
        }
    }

    #[test]
    fn one_byte_less_is_refused() {
        let (positions, faces) = ([DVec3::ZERO; 3], [[0, 1, 2]; 4]);
        let mut bytes = vec![0; 4 + 4 * 48];
        let mesh = MeshView { positions: &positions, faces: &faces };
        assert!(ClosestTree::new(mesh, &mut Scratch::new(&mut bytes)).is_err());
    }
}
