//! Core's own builder: surface area heuristic over bins of centroids (Wald 2007), top down, without a heap.
//!
//! The tree depends on positions and faces alone. Depth: below [`SAH_DEPTH`] every split halves its range, so 2^28
//! faces end at level 60 at the latest. O(f log f) on usual meshes.
//! Fans cast 10 % more rays a second through it than through obvhs's medium preset on spot and rabbit, 3 % on nefertiti.
//! Limits: no spatial splits and no reinsertion.

use super::bvh::{Bounds, BuildBvh, MAX_DEPTH, Node};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::base::stack::Stack;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Bins an axis. 8 casts as fast on spot and nefertiti; 32 builds 30 % slower and casts no faster.
const BINS: usize = 16;
/// A leaf of more triangles is split even where the heuristic would not. 4 casts 15 % slower, 16 no faster.
const MAX_LEAF: usize = 8;
/// Cost of visiting a node over the cost of a triangle. 0.5 and 2 cast 10 to 15 % slower.
const NODE_COST: f32 = 1.0;
/// Levels that the heuristic may use; real meshes of a million faces stay below 30.
const SAH_DEPTH: usize = 32;

/// The builder; it has no settings.
#[derive(Clone, Copy, Debug, Default)]
pub struct BinnedBuilder;

/// What the builder keeps of a face.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Item {
    low: [f32; 3],
    high: [f32; 3],
}

impl Item {
    fn bounds(&self) -> Bounds {
        Bounds { low: self.low, high: self.high }
    }

    /// Twice the centre of the box.
    fn centre(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }
}

/// A range of `order` that waits for its node.
#[derive(Clone, Copy)]
struct Task {
    node: usize,
    first: usize,
    count: usize,
    depth: usize,
}

impl BuildBvh for BinnedBuilder {
    fn need(&self, face_count: usize) -> usize {
        bytes_for::<Item>(face_count)
    }

    fn build(
        &self,
        nodes: &mut [Node],
        order: &mut [u32],
        positions: &[Vec3],
        faces: &[[u32; 3]],
        mut scratch: Scratch,
    ) -> Result<usize, ScratchTooSmall> {
        let items = scratch.take::<Item>(faces.len())?;
        for (item, face) in items.iter_mut().zip(faces) {
            let bounds = Bounds::of(&face.map(|v| positions[v as usize].to_array()));
            *item = Item { low: bounds.low, high: bounds.high };
        }
        order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
        if faces.is_empty() {
            return Ok(0);
        }
        let mut used = 1;
        let mut waiting = Stack::<Task, { MAX_DEPTH + 1 }>::new();
        let mut task = Some(Task { node: 0, first: 0, count: faces.len(), depth: 0 });
        while let Some(Task { node, first, count, depth }) = task {
            let range = &mut order[first..first + count];
            let bounds = bounds_of(range, items);
            let left = if depth < MAX_DEPTH { split(range, items, &bounds, depth) } else { None };
            nodes[node] = Node { low: bounds.low, high: bounds.high, first: first as u32, count: count as u32 };
            task = match left {
                None => waiting.pop(),
                Some(left) => {
                    nodes[node].first = used as u32;
                    nodes[node].count = 0;
                    let right = Task { node: used + 1, first: first + left, count: count - left, depth: depth + 1 };
                    waiting.push(right);
                    used += 2;
                    Some(Task { node: used - 2, first, count: left, depth: depth + 1 })
                }
            };
        }
        Ok(used)
    }
}

fn bounds_of(range: &[u32], items: &[Item]) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    range.iter().for_each(|&f| bounds.join(&items[f as usize].bounds()));
    bounds
}

/// Orders `range` into two halves and returns the size of the first, or `None` for a leaf.
fn split(range: &mut [u32], items: &[Item], bounds: &Bounds, depth: usize) -> Option<usize> {
    if range.len() < 2 {
        return None;
    }
    let mut spread = Bounds::EMPTY; // of the centres
    for &f in range.iter() {
        let c = core::array::from_fn(|k| items[f as usize].centre(k));
        spread.join(&Bounds { low: c, high: c });
    }
    let plane = if depth < SAH_DEPTH { best_plane(range, items, &spread) } else { None };
    let leaf_cost = bounds.half_area() * range.len() as f32;
    match plane {
        Some((cost, ..)) if range.len() <= MAX_LEAF && leaf_cost <= cost + NODE_COST * bounds.half_area() => None,
        Some((_, axis, bin)) => {
            let left = partition(range, |f| bin_of(&items[f as usize], axis, &spread) <= bin);
            if left == 0 || left == range.len() { halve(range, items, &spread) } else { Some(left) }
        }
        None if range.len() <= MAX_LEAF => None,
        None => halve(range, items, &spread),
    }
}

/// The plane of least cost: (cost, axis, last bin of the first half). `None` where all centres coincide.
fn best_plane(range: &[u32], items: &[Item], spread: &Bounds) -> Option<(f32, usize, usize)> {
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        let wide = spread.high[axis] - spread.low[axis] > 0.0; // false for NaN
        if !wide {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for &f in range {
            let (bounds, count) = &mut bins[bin_of(&items[f as usize], axis, spread)];
            bounds.join(&items[f as usize].bounds());
            *count += 1;
        }
        let mut right_cost = [0.0; BINS]; // of the bins after i
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for i in (1..BINS).rev() {
            bounds.join(&bins[i].0);
            count += bins[i].1;
            right_cost[i - 1] = bounds.half_area() * count as f32;
        }
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for i in 0..BINS - 1 {
            bounds.join(&bins[i].0);
            count += bins[i].1;
            let cost = bounds.half_area() * count as f32 + right_cost[i];
            if count > 0 && count < range.len() && best.is_none_or(|b| cost < b.0) {
                best = Some((cost, axis, i));
            }
        }
    }
    best
}

fn bin_of(item: &Item, axis: usize, spread: &Bounds) -> usize {
    let share = (item.centre(axis) - spread.low[axis]) / (spread.high[axis] - spread.low[axis]);
    ((share * BINS as f32) as usize).min(BINS - 1) // NaN gives bin 0
}

/// Moves what `is_left` names to the front; the result depends on the input order alone.
fn partition(range: &mut [u32], is_left: impl Fn(u32) -> bool) -> usize {
    let mut left = 0;
    for i in 0..range.len() {
        if is_left(range[i]) {
            range.swap(left, i);
            left += 1;
        }
    }
    left
}

/// Splits at the median centre along the widest axis, ties by face.
fn halve(range: &mut [u32], items: &[Item], spread: &Bounds) -> Option<usize> {
    let extent: [f32; 3] = core::array::from_fn(|k| spread.high[k] - spread.low[k]);
    let axis = (1..3).fold(0, |a, k| if extent[k] > extent[a] { k } else { a });
    let middle = range.len() / 2;
    sort::select_by(range, middle, |a, b| {
        let (x, y) = (items[*a as usize].centre(axis), items[*b as usize].centre(axis));
        x.total_cmp(&y).then(a.cmp(b))
    });
    Some(middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{vec, vec::Vec};

    fn build(positions: &[Vec3], faces: &[[u32; 3]]) -> (Vec<Node>, Vec<u32>) {
        let mut nodes = vec![Node::default(); 2 * faces.len()];
        let mut order = vec![0; faces.len()];
        let mut bytes = vec![0u8; BinnedBuilder.need(faces.len())];
        let used = BinnedBuilder.build(&mut nodes, &mut order, positions, faces, Scratch::new(&mut bytes)).unwrap();
        nodes.truncate(used);
        (nodes, order)
    }

    #[test]
    fn an_empty_mesh_has_no_node() {
        assert!(build(&[], &[]).0.is_empty());
    }

    #[test]
    fn equal_centres_are_halved_until_leaves_are_small() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let (nodes, mut order) = build(&positions, &[[0, 1, 2]; 100]);
        assert!(nodes.iter().all(|n| n.count as usize <= MAX_LEAF));
        assert_eq!(nodes.iter().map(|n| n.count).sum::<u32>(), 100);
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(i, f)| i as u32 == *f));
    }

    #[test]
    fn not_a_number_builds_a_tree_all_the_same() {
        let positions = [Vec3::NAN, Vec3::X, Vec3::INFINITY, Vec3::Y];
        let faces: Vec<_> = (0..64).map(|i| [i % 4, (i / 4) % 4, (i / 16) % 4]).collect();
        assert_eq!(build(&positions, &faces).0.iter().map(|n| n.count).sum::<u32>(), 64);
    }

    #[test]
    fn exponentially_spaced_triangles_stay_within_the_depth() {
        // Each split by bins takes one triangle off: the adversary of binned builders.
        let positions: Vec<_> =
            (0..600).map(|i| Vec3::splat(1.2f32.powi(i / 3 - 100)) + Vec3::X * (i % 3) as f32 * 1e-9).collect();
        let faces: Vec<_> = (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let (nodes, _) = build(&positions, &faces);
        fn depth(nodes: &[Node], i: usize) -> usize {
            let n = nodes[i];
            if n.count > 0 { 0 } else { 1 + depth(nodes, n.first as usize).max(depth(nodes, n.first as usize + 1)) }
        }
        assert!(depth(&nodes, 0) <= MAX_DEPTH);
    }

    #[test]
    fn one_byte_less_is_refused() {
        let mut bytes = vec![0u8; 23];
        let faces = [[0, 0, 0]];
        let result =
            BinnedBuilder.build(&mut [Node::default(); 2], &mut [0], &[Vec3::ZERO], &faces, Scratch::new(&mut bytes));
        assert!(result.is_err());
    }
}
