//! The flat node array that rays are cast through, whoever built it.
//!
//! A builder only decides which triangles stand together: `cast::Scene` checks its tree, copies it in its own
//! order and computes every box again, so a box that a builder rounds differently cannot change a hit.

use crate::base::scratch::{Scratch, ScratchTooSmall};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Levels below the root that a tree may have: traversal keeps one entry a level on a fixed stack.
pub const MAX_DEPTH: usize = 60;

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
pub trait BuildBvh: Sync {
    /// Scratch bytes that [`build`](Self::build) asks for.
    fn need(&self, face_count: usize) -> usize;

    /// Fills `nodes` (at least 2 f) and `order` (f: the face at each place of the leaves' ranges); returns the number of
    /// nodes, root first. Every face stands in exactly one leaf; the tree is at most [`MAX_DEPTH`] deep.
    fn build(
        &self,
        nodes: &mut [Node],
        order: &mut [u32],
        positions: &[Vec3],
        faces: &[[u32; 3]],
        scratch: Scratch,
    ) -> Result<usize, ScratchTooSmall>;
}

/// Why a mesh or a tree cannot be cast against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BvhError {
    /// More memory is needed.
    Scratch(ScratchTooSmall),
    /// A corner of this face names a vertex that is not there.
    BadFace {
        /// The face.
        face: usize,
    },
    /// This node of the builder's tree has children or triangles out of range, or is met twice.
    BadNode {
        /// The node.
        node: usize,
    },
    /// A leaf lists this face a second time, or the leaves do not hold all faces (`face` is then their number).
    BadOrder {
        /// The face.
        face: usize,
    },
    /// The tree is deeper than [`MAX_DEPTH`].
    TooDeep,
}

impl From<ScratchTooSmall> for BvhError {
    fn from(e: ScratchTooSmall) -> Self {
        BvhError::Scratch(e)
    }
}

impl core::fmt::Display for BvhError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            BvhError::Scratch(e) => e.fmt(f),
            BvhError::BadFace { face } => write!(f, "face {face} names a vertex that does not exist"),
            BvhError::BadNode { node } => write!(f, "node {node} of the hierarchy points out of range"),
            BvhError::BadOrder { face } => write!(f, "the hierarchy does not hold each face once (at {face})"),
            BvhError::TooDeep => write!(f, "the hierarchy is deeper than {MAX_DEPTH} levels"),
        }
    }
}

impl core::error::Error for BvhError {}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Bounds {
    /// Holds nothing; the neutral element of [`join`](Self::join).
    pub const EMPTY: Bounds = Bounds { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// The box of three points. A NaN coordinate is left out.
    #[inline]
    pub fn of(corners: &[[f32; 3]; 3]) -> Self {
        let mut bounds = Self::EMPTY;
        for p in corners {
            bounds.join(&Bounds { low: *p, high: *p });
        }
        bounds
    }

    /// Grows to hold `other`.
    #[inline]
    pub fn join(&mut self, other: &Bounds) {
        for k in 0..3 {
            self.low[k] = min(other.low[k], self.low[k]);
            self.high[k] = max(other.high[k], self.high[k]);
        }
    }

    /// Half the surface; 0 for an empty box.
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = core::array::from_fn(|k| max(0.0, self.high[k] - self.low[k]));
        x * y + y * z + z * x
    }
}

/// The lesser; `b` where `a` is NaN. One machine instruction, unlike `f32::min`.
#[inline(always)]
pub(super) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater; `b` where `a` is NaN.
#[inline(always)]
pub(super) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
