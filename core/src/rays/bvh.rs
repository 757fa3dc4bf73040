//! The flat node array that rays are cast through, whoever built it.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// One node, 32 bytes. `count` 0: an inner node whose children are `first` and `first + 1`; else a leaf with triangles
/// `first..first + count` of the builder's order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Lower corner of the box.
    pub low: [f32; 3],
    /// First child or first triangle.
    pub first: u32,
    /// Upper corner of the box.
    pub high: [f32; 3],
    /// Triangles in a leaf, 0 for an inner node.
    pub count: u32,
}

/// Builds the tree: core's own builder, or a library's where a heap exists.
pub trait BuildBvh {
    /// Fills `nodes` (at least 2 f) and `order` (f: the face at each place of the leaves' ranges); returns the number of
    /// nodes, root first. The tree is at most 60 deep.
    fn build(&self, nodes: &mut [Node], order: &mut [u32], positions: &[Vec3], faces: &[[u32; 3]]) -> usize;
}
