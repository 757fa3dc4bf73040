//! Bounding volume hierarchies by obvhs (PLOC with reinsertion), handed to core as flat nodes.
//!
//! Guarantee: the tree is at most 60 deep. Where the library's is deeper (long rows of needles), a balanced tree
//! over the library's order of the faces takes its place. Hits do not depend on the tree, only the time does.

use glam::Vec3;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::{BvhBuildParams, triangle::Triangle};
use seamwright_core::base::scratch::{Scratch, ScratchTooSmall};
use seamwright_core::rays::bvh::{BuildBvh, Node};
use std::time::Duration;

/// Deepest tree that core's traversal takes.
const DEPTH: usize = 60;

/// Faces in a leaf of the balanced tree.
const BALANCED_LEAF: usize = 4;

/// Builds with obvhs.
pub struct Obvhs;

impl BuildBvh for Obvhs {
    fn need(&self, _: usize) -> usize {
        0
    }

    fn build(
        &self,
        nodes: &mut [Node],
        order: &mut [u32],
        positions: &[Vec3],
        faces: &[[u32; 3]],
        _: Scratch,
    ) -> Result<usize, ScratchTooSmall> {
        if faces.is_empty() {
            return Ok(0);
        }
        let triangles: Vec<Triangle> = faces
            .iter()
            .map(|face| {
                let [v0, v1, v2] = face.map(|v| positions[v as usize].into());
                Triangle { v0, v1, v2 }
            })
            .collect();
        let tree = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        order.copy_from_slice(&tree.primitive_indices);
        if depth(&tree) <= DEPTH {
            Ok(copy_nodes(nodes, &tree))
        } else {
            let mut count = 1;
            balance(nodes, &mut count, 0, 0..order.len(), &|i| bounds(positions, faces[order[i] as usize]));
            Ok(count)
        }
    }
}

fn copy_nodes(nodes: &mut [Node], tree: &Bvh2) -> usize {
    for (to, from) in nodes.iter_mut().zip(&tree.nodes) {
        let (low, high) = (Vec3::from(from.aabb().min), Vec3::from(from.aabb().max));
        *to = Node { low: low.into(), first: from.first_index, high: high.into(), count: from.prim_count };
    }
    tree.nodes.len()
}

/// Levels below the root, without recursion: the tree may be as deep as it has faces.
fn depth(tree: &Bvh2) -> usize {
    let mut stack = vec![(0, 0)];
    let mut deepest = 0;
    while let Some((node, level)) = stack.pop() {
        deepest = deepest.max(level);
        let node = &tree.nodes[node];
        if !node.is_leaf() {
            let first = node.first_index as usize;
            stack.extend([(first, level + 1), (first + 1, level + 1)]);
        }
    }
    deepest
}

/// Fills the subtree at `root` over the faces at `range` of the order by halves. Recursion is as deep as the tree: 32.
fn balance(
    nodes: &mut [Node],
    count: &mut usize,
    root: usize,
    range: core::ops::Range<usize>,
    bounds: &dyn Fn(usize) -> (Vec3, Vec3),
) {
    let around = |(low, high): (Vec3, Vec3), (l, h): (Vec3, Vec3)| (low.min(l), high.max(h));
    if range.len() <= BALANCED_LEAF {
        let (low, high) = range.clone().map(bounds).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), around);
        let (first, count) = (range.start as u32, range.len() as u32);
        nodes[root] = Node { low: low.into(), first, high: high.into(), count };
        return;
    }
    let (first, middle) = (*count, range.start + range.len() / 2);
    *count += 2;
    balance(nodes, count, first, range.start..middle, bounds);
    balance(nodes, count, first + 1, middle..range.end, bounds);
    let side = |n: &Node| (Vec3::from(n.low), Vec3::from(n.high));
    let (low, high) = around(side(&nodes[first]), side(&nodes[first + 1]));
    nodes[root] = Node { low: low.into(), first: first as u32, high: high.into(), count: 0 };
}

fn bounds(positions: &[Vec3], face: [u32; 3]) -> (Vec3, Vec3) {
    let [a, b, c] = face.map(|v| positions[v as usize]);
    (a.min(b).min(c), a.max(b).max(c))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(nodes: &mut [Node], order: &mut [u32], positions: &[Vec3], faces: &[[u32; 3]]) -> usize {
        Obvhs.build(nodes, order, positions, faces, Scratch::new(&mut [])).unwrap()
    }

    /// A strip of `count` triangles.
    fn strip(count: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let positions = (0..count + 2).map(|i| Vec3::new(i as f32, (i % 2) as f32, (i * i % 7) as f32)).collect();
        (positions, (0..count as u32).map(|i| [i, i + 1, i + 2]).collect())
    }

    /// Every face is in one leaf, and every box holds what is below it.
    fn check(nodes: &[Node], order: &[u32], positions: &[Vec3], faces: &[[u32; 3]]) {
        let mut seen = vec![0; faces.len()];
        let mut stack = vec![(0usize, 0usize)];
        while let Some((n, level)) = stack.pop() {
            assert!(level <= DEPTH);
            let node = nodes[n];
            let holds = |(low, high): (Vec3, Vec3)| {
                low.cmpge(Vec3::from(node.low)).all() && high.cmple(Vec3::from(node.high)).all()
            };
            let first = node.first as usize;
            if node.count == 0 {
                for child in [first, first + 1] {
                    assert!(holds((nodes[child].low.into(), nodes[child].high.into())));
                    stack.push((child, level + 1));
                }
            }
            for face in &order[first..first + node.count as usize] {
                seen[*face as usize] += 1;
                assert!(holds(bounds(positions, faces[*face as usize])));
            }
        }
        assert!(seen.iter().all(|n| *n == 1));
    }

    #[test]
    fn each_face_is_in_one_leaf_and_each_box_holds_its_faces() {
        for count in [1, 2, 3, 100, 5000] {
            let (positions, faces) = strip(count);
            let (mut nodes, mut order) = (vec![Node::default(); 2 * count], vec![0; count]);
            let used = build(&mut nodes, &mut order, &positions, &faces);
            assert!((1..2 * count).contains(&used));
            check(&nodes, &order, &positions, &faces);
        }
    }

    #[test]
    fn the_balanced_tree_holds_every_face_too() {
        for count in [1, 5, 1000] {
            let (positions, faces) = strip(count);
            let (mut nodes, mut used) = (vec![Node::default(); 2 * count], 1);
            let order: Vec<u32> = (0..count as u32).collect();
            balance(&mut nodes, &mut used, 0, 0..count, &|i| bounds(&positions, faces[i]));
            assert!(used <= 2 * count);
            check(&nodes, &order, &positions, &faces);
        }
    }

    #[test]
    fn a_thousand_equal_faces_stay_shallow() {
        let (positions, faces) = strip(1);
        let faces = vec![faces[0]; 1000];
        let (mut nodes, mut order) = (vec![Node::default(); 2000], vec![0; 1000]);
        build(&mut nodes, &mut order, &positions, &faces);
        check(&nodes, &order, &positions, &faces);
    }

    #[test]
    fn no_face_is_no_node() {
        assert_eq!(build(&mut [], &mut [], &[], &[]), 0);
    }
}
