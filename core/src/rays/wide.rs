//! Nodes of up to [`WIDE`] children, for packets: one instruction tests a frustum against many boxes.
//!
//! Made from the binary tree by pulling up the child of largest surface until a node is full (Wald, Benthin, Boulos
//! 2008). Boxes lie coordinate by coordinate, side by side.

use super::bvh::{Bounds, MAX_DEPTH, Node};
use super::lanes::LANES;
use crate::base::stack::Stack;
use bytemuck::{Pod, Zeroable};

/// Children of a node.
pub(super) const WIDE: usize = LANES;

/// One node. Child i is a leaf of triangles `first[i]..first[i] + count[i]`, or the wide node `first[i]` where
/// `count[i]` is 0. Places without a child hold NaN, which
/// no comparison passes.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct WideNode {
    pub low: [[f32; WIDE]; 3],
    pub high: [[f32; WIDE]; 3],
    pub first: [u32; WIDE],
    pub count: [u32; WIDE],
}

impl WideNode {
    /// The box of child `i`.
    pub fn child(&self, i: usize) -> Node {
        let pick = |of: &[[f32; WIDE]; 3]| [of[0][i], of[1][i], of[2][i]];
        Node { low: pick(&self.low), high: pick(&self.high), first: self.first[i], count: self.count[i] }
    }
}

/// Wide nodes that a tree over `face_count` faces has at the most: every node that is not full has only leaves.
pub(super) const fn wide_count(face_count: usize) -> usize {
    face_count / 2 + face_count / 6 + 2
}

/// Fills `wide` from a tree whose children stand after their parents; returns how many nodes it took.
pub(super) fn collapse(wide: &mut [WideNode], nodes: &[Node]) -> usize {
    if nodes.is_empty() {
        return 0;
    }
    let mut used = 1;
    let mut waiting = Stack::<(u32, u32), { (WIDE - 1) * (MAX_DEPTH + 1) }>::new();
    let mut at = Some((0, 0)); // (binary node, wide node)
    while let Some((from, to)) = at {
        let (mut children, mut count) = ([from; WIDE], 1);
        while count < WIDE
            && let Some(place) = widest_inner(&children[..count], nodes)
        {
            let first = nodes[children[place] as usize].first;
            (children[place], children[count]) = (first, first + 1);
            count += 1;
        }
        let out = &mut wide[to as usize];
        *out = WideNode { low: [[f32::NAN; WIDE]; 3], high: [[f32::NAN; WIDE]; 3], first: [0; WIDE], count: [0; WIDE] };
        for (i, &child) in children[..count].iter().enumerate() {
            let node = &nodes[child as usize];
            for k in 0..3 {
                (out.low[k][i], out.high[k][i]) = (node.low[k], node.high[k]);
            }
            (out.first[i], out.count[i]) = (node.first, node.count);
            if node.count == 0 {
                out.first[i] = used;
                waiting.push((child, used));
                used += 1;
            }
        }
        at = waiting.pop();
    }
    used as usize
}

/// The place of the inner node of largest surface, the first of equals.
fn widest_inner(children: &[u32], nodes: &[Node]) -> Option<usize> {
    let mut best: Option<(usize, f32)> = None;
    for (place, child) in children.iter().enumerate() {
        let node = &nodes[*child as usize];
        let area = Bounds { low: node.low, high: node.high }.half_area();
        if node.count == 0 && best.is_none_or(|b| area > b.1) {
            best = Some((place, area));
        }
    }
    best.map(|b| b.0)
}
