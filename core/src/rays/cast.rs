//! Casting rays at a mesh, through a checked and re-boxed copy of any builder's tree.
//!
//! What a hit is, `intersect` says; the tree only finds it. Boxes of nodes are tested by the formula that also limits
//! hits to the triangle's own box, and each of its operations is monotone in the box, so a node's interval holds its
//! triangles' intervals to the last bit: no tree can lose or add a hit. Equal depths go to the lowest face.
//! Limits: positions of magnitude 2^-40 to 2^40 (callers scale to the unit box).

use super::bvh::{Bounds, BuildBvh, BvhError, MAX_DEPTH, Node, max};
use super::intersect::{Aim, Meeting, RayStart, Triangle, interval, meet};
use super::wide::{WideNode, collapse, wide_count};
use crate::base::scratch::{Scratch, bytes_for};
use crate::base::stack::Stack;
use glam::Vec3;

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
        let (start, aim) = (RayStart::new(ray.origin, self.reach), Aim::new(ray.direction)?);
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
        let start = RayStart::new(ray.origin, self.reach);
        let mut free = true;
        self.visit(&start, &aim, |triangle, _| {
            free = meet(triangle, &start, &aim).is_none();
            free
        });
        !free
    }

    /// Calls `see` on the triangles of every leaf that the ray enters at a depth up to `farthest`, near leaves first,
    /// until it answers false.
    fn visit(&self, start: &RayStart, aim: &Aim, mut see: impl FnMut(&Triangle, &mut f32) -> bool) {
        let mut farthest = f32::INFINITY;
        let mut waiting = Stack::<(u32, f32), { MAX_DEPTH + 1 }>::new();
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
                            waiting.push(second);
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
    let mut waiting = Stack::<(usize, usize, usize), { MAX_DEPTH + 1 }>::new();
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
            waiting.push((first + 1, used + 1, depth + 1));
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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::random::unit_f32;
    use crate::base::scratch::ScratchTooSmall;
    use crate::rays::binned::BinnedBuilder;
    use std::{boxed::Box, vec, vec::Vec};

    /// A scene over leaked memory: tests are short.
    pub fn scene_with(
        positions: &[Vec3],
        faces: &[[u32; 3]],
        builder: &dyn BuildBvh,
    ) -> Result<Scene<'static>, BvhError> {
        let bytes: &'static mut [u8] = Box::leak(vec![0u8; Scene::need(faces.len(), builder)].into_boxed_slice());
        Scene::new(positions, faces, builder, &mut Scratch::new(bytes))
    }

    pub fn scene(positions: &[Vec3], faces: &[[u32; 3]]) -> Scene<'static> {
        scene_with(positions, faces, &BinnedBuilder).unwrap()
    }

    /// A bumpy sheet of n x n quads over the unit square, two stray triangles and one without area.
    pub fn terrain(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut positions: Vec<_> = (0..(n + 1) * (n + 1))
            .map(|i| {
                Vec3::new(
                    (i % (n + 1)) as f32 / n as f32,
                    (i / (n + 1)) as f32 / n as f32,
                    0.2 * unit_f32(5, 0, i as u64),
                )
            })
            .collect();
        let mut faces: Vec<_> = (0..n * n)
            .flat_map(|q| {
                let a = q / n * (n + 1) + q % n;
                [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
            })
            .collect();
        positions.extend([Vec3::new(0.2, 0.2, 0.5), Vec3::new(0.9, 0.1, 0.6), Vec3::new(0.3, 0.8, 0.4)]);
        let k = (n + 1) * (n + 1);
        faces.extend([[k, k + 1, k + 2], [k, k + 1, k + 2], [k, k, k + 1]]);
        (positions, faces)
    }

    /// Rays at random, along the axes, and exactly at vertices and along edges' planes.
    pub fn rays(positions: &[Vec3], faces: &[[u32; 3]], count: u64) -> Vec<Ray> {
        let random = |stream: u64, i: u64| Vec3::from_array([0, 1, 2].map(|k| unit_f32(stream, k, i)));
        (0..count)
            .map(|i| {
                let face = faces[i as usize % faces.len()].map(|v| positions[v as usize]);
                let origin = random(1, i) * 2.0 - 0.5;
                let target = match i % 4 {
                    0 => random(2, i),
                    1 => face[0],
                    2 => (face[0] + face[1]) * 0.5,
                    _ => origin + [Vec3::X, Vec3::NEG_Z, Vec3::new(-1.0, 1.0, 0.0)][i as usize / 4 % 3],
                };
                Ray { origin, direction: target - origin }
            })
            .collect()
    }

    pub fn brute(scene: &Scene, ray: &Ray) -> Option<Hit> {
        let aim = Aim::new(ray.direction)?;
        let start = RayStart::new(ray.origin, scene.reach());
        let mut all: Vec<_> = scene.triangles.iter().filter_map(|t| meet(t, &start, &aim)).collect();
        all.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.face.cmp(&b.face)));
        all.first().map(|m| Hit { distance: m.depth / aim.length, face: m.face, weights: m.weights })
    }

    #[test]
    fn the_tree_finds_what_a_loop_over_all_triangles_finds() {
        let (positions, faces) = terrain(20);
        let scene = scene(&positions, &faces);
        let rays = rays(&positions, &faces, 6000);
        let hits = rays.iter().filter(|r| scene.closest(r).is_some()).count();
        assert!((1500..5500).contains(&hits), "{hits}");
        for ray in &rays {
            assert_eq!(scene.closest(ray), brute(&scene, ray), "{ray:?}");
            assert_eq!(scene.occluded(ray), brute(&scene, ray).is_some(), "{ray:?}");
        }
    }

    #[test]
    fn no_ray_slips_between_faces_that_share_an_edge() {
        // Straight down and aslant at every vertex and edge of the sheet's inside.
        let (positions, faces) = terrain(12);
        let scene = scene(&positions, &faces[..288]);
        for (i, face) in faces[..288].iter().enumerate() {
            let [a, b, _] = face.map(|v| positions[v as usize]);
            for target in [a, (a + b) * 0.5, a.lerp(b, 0.3)] {
                if target.x.min(target.y) > 0.0 && target.x.max(target.y) < 1.0 {
                    for side in [Vec3::ZERO, Vec3::new(0.1, 0.07, 0.0), Vec3::new(0.3, -0.2, 0.0)] {
                        let origin = target + Vec3::Z + side;
                        assert!(scene.occluded(&Ray { origin, direction: target - origin }), "face {i}");
                    }
                }
            }
        }
    }

    #[test]
    fn distances_and_weights_name_the_same_point() {
        let (positions, faces) = terrain(20);
        let scene = scene(&positions, &faces);
        for ray in rays(&positions, &faces, 1000).iter().filter(|r| r.direction.z.abs() > 0.5) {
            if let Some(hit) = scene.closest(ray) {
                let corners = faces[hit.face as usize].map(|v| positions[v as usize]);
                let point = corners[0] * hit.weights[0] + corners[1] * hit.weights[1] + corners[2] * hit.weights[2];
                // Coordinates up to 2 with some ten roundings, times the slant of steep faces.
                assert!(point.distance(ray.origin + ray.direction * hit.distance) < 2e-5, "{ray:?}");
            }
        }
    }

    #[test]
    fn of_two_equal_faces_the_lower_is_hit() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let scene = scene(&positions, &[[1, 1, 1], [0, 1, 2], [0, 1, 2]]);
        let hit = scene.closest(&Ray { origin: Vec3::new(0.2, 0.2, 2.0), direction: -Vec3::Z }).unwrap();
        assert_eq!((hit.face, hit.distance), (1, 2.0));
    }

    #[test]
    fn nothing_is_hit_in_an_empty_mesh_or_along_no_direction() {
        let ray = Ray { origin: Vec3::Z, direction: -Vec3::Z };
        assert_eq!(scene(&[], &[]).closest(&ray), None);
        let full = scene(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]]);
        for direction in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(full.closest(&Ray { direction, ..ray }), None);
            assert!(!full.occluded(&Ray { direction, ..ray }));
        }
    }

    #[test]
    fn coordinates_that_are_not_numbers_do_no_harm() {
        let positions = [Vec3::NAN, Vec3::X, Vec3::Y, Vec3::INFINITY];
        let scene = scene(&positions, &[[0, 1, 2], [3, 1, 2], [3, 0, 0]]);
        let ray = Ray { origin: Vec3::Z, direction: Vec3::new(0.1, 0.2, -1.0) };
        let _ = (scene.closest(&ray), scene.occluded_count(ray.origin, &[ray.direction; 9]));
    }

    /// A builder that hands out a given tree.
    struct Given(Vec<Node>, Vec<u32>);
    impl BuildBvh for Given {
        fn need(&self, _: usize) -> usize {
            0
        }
        fn build(
            &self,
            nodes: &mut [Node],
            order: &mut [u32],
            _: &[Vec3],
            _: &[[u32; 3]],
            _: Scratch,
        ) -> Result<usize, ScratchTooSmall> {
            nodes[..self.0.len()].copy_from_slice(&self.0);
            order.copy_from_slice(&self.1);
            Ok(self.0.len())
        }
    }

    #[test]
    fn a_broken_tree_is_refused() {
        let node = |first, count| Node { first, count, ..Node::default() };
        let try_tree = |nodes: &[Node], order: &[u32]| {
            let faces = vec![[0, 1, 2]; order.len()];
            scene_with(&[Vec3::ZERO, Vec3::X, Vec3::Y], &faces, &Given(nodes.into(), order.into())).map(|_| ())
        };
        assert_eq!(try_tree(&[node(1, 0), node(0, 1), node(1, 1)], &[1, 0]), Ok(()));
        assert_eq!(try_tree(&[node(0, 0)], &[0, 1]), Err(BvhError::BadNode { node: 0 })); // its own child
        assert_eq!(try_tree(&[node(1, 0), node(0, 3), node(1, 1)], &[0, 1]), Err(BvhError::BadNode { node: 1 }));
        assert_eq!(try_tree(&[node(7, 0)], &[0, 1]), Err(BvhError::BadNode { node: 7 }));
        assert_eq!(try_tree(&[node(0, 1)], &[0, 1]), Err(BvhError::BadOrder { face: 1 }));
        assert_eq!(try_tree(&[node(0, 2)], &[0, 0]), Err(BvhError::BadOrder { face: 0 }));
        assert_eq!(try_tree(&[node(0, 2)], &[0, 9]), Err(BvhError::BadOrder { face: 9 }));
        let chain: Vec<_> = (0..200).map(|i| if i % 2 == 0 { node(i + 1, 0) } else { node(i / 2, 1) }).collect();
        assert_eq!(try_tree(&chain, &(0..100).collect::<Vec<_>>()), Err(BvhError::TooDeep));
    }

    #[test]
    fn a_face_of_missing_vertices_and_too_little_scratch_are_refused() {
        let result = scene_with(&[Vec3::ZERO; 2], &[[0, 1, 0], [0, 1, 2]], &BinnedBuilder);
        assert_eq!(result.map(|_| ()), Err(BvhError::BadFace { face: 1 }));
        let mut bytes = vec![0u8; Scene::need(1, &BinnedBuilder) - 1];
        let result = Scene::new(&[Vec3::ZERO], &[[0, 0, 0]], &BinnedBuilder, &mut Scratch::new(&mut bytes));
        assert!(matches!(result, Err(BvhError::Scratch(_))));
    }
}
