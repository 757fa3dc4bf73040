//! A ray hierarchy from the obvhs crate (PLOC with reinsertion), in core's node format.
//!
//! obvhs runs without its `parallel` feature and with glam's scalar arithmetic, so that its tree is the same on every
//! machine; hits are those of any tree in any case. Coordinates that are not finite, and trees that come out too deep,
//! go to core's own builder.

use glam::Vec3;
use obvhs::{BvhBuildParams, bvh2::Bvh2, bvh2::builder::build_bvh2_from_tris, triangle::Triangle};
use seamwright_core::base::scratch::{Scratch, ScratchTooSmall};
use seamwright_core::rays::binned::BinnedBuilder;
use seamwright_core::rays::bvh::{BuildBvh, MAX_DEPTH, Node};
use std::time::Duration;

/// The builder; it has no settings.
#[derive(Clone, Copy, Debug, Default)]
pub struct ObvhsBuilder;

impl BuildBvh for ObvhsBuilder {
    fn need(&self, face_count: usize) -> usize {
        BinnedBuilder.need(face_count)
    }

    fn build(
        &self,
        nodes: &mut [Node],
        order: &mut [u32],
        positions: &[Vec3],
        faces: &[[u32; 3]],
        scratch: Scratch,
    ) -> Result<usize, ScratchTooSmall> {
        let corners = |face: &[u32; 3]| face.map(|v| positions[v as usize]);
        if !faces.iter().flat_map(corners).all(|p| p.is_finite()) {
            return BinnedBuilder.build(nodes, order, positions, faces, scratch);
        }
        let triangles: Vec<_> = faces
            .iter()
            .map(|face| {
                let [v0, v1, v2] = corners(face).map(Into::into);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let tree = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        if tree.nodes.len() > nodes.len() || tree.primitive_indices.len() != order.len() || depth(&tree) > MAX_DEPTH {
            return BinnedBuilder.build(nodes, order, positions, faces, scratch);
        }
        for (node, from) in nodes.iter_mut().zip(&tree.nodes) {
            let (low, high) = (from.min.to_array(), from.max.to_array());
            *node = Node { low, first: from.first_index, high, count: from.prim_count };
        }
        order.copy_from_slice(&tree.primitive_indices);
        Ok(tree.nodes.len())
    }
}

/// Levels below the root.
fn depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut waiting = vec![(0, 0)];
    while let Some((node, depth)) = waiting.pop() {
        deepest = deepest.max(depth);
        match tree.nodes.get(node) {
            Some(node) if node.prim_count == 0 => {
                let first = node.first_index as usize;
                waiting.extend([(first, depth + 1), (first + 1, depth + 1)]);
            }
            _ => {}
        }
    }
    deepest
}
