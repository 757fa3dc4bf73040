//! Cheapest paths inside charts, from node to node: they cross no cut, and the two sides of a cut are different nodes.
//!
//! Cost: O(m log m) for a search that reaches m nodes, however large the mesh is.

use super::surface::Surface;
use crate::base::heap::Heap;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::mesh::view::{NONE, next, prev};

/// Memory of the searches.
pub struct WedgePaths<'a> {
    /// Cost from the nearest source; infinite where not reached.
    pub cost: &'a mut [f64], // (nodes)
    /// Half-edge over which each node was reached, `NONE` at sources.
    pub via: &'a mut [u32], // (nodes)
    first: &'a mut [u32],   // (nodes) a corner of each
    touched: &'a mut [u32], // (nodes) those that the last search reached, so that the next one clears no more
    touched_count: usize,
    heap_cost: &'a mut [f64],
    heap_slot: &'a mut [u32],
    heap_item: &'a mut [u32],
}

impl<'a> WedgePaths<'a> {
    /// Memory for the nodes that `node` (one entry a corner) names.
    pub fn new(node: &[u32], count: usize, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let first = keep.take_filled::<u32>(count, NONE)?;
        for (c, n) in node.iter().enumerate() {
            first[*n as usize] = c as u32;
        }
        Ok(Self {
            cost: keep.take_filled(count, f64::INFINITY)?,
            via: keep.take_filled(count, NONE)?,
            first,
            touched: keep.take(count)?,
            touched_count: 0,
            heap_cost: keep.take(count)?,
            heap_slot: keep.take(count)?,
            heap_item: keep.take(count)?,
        })
    }

    /// Cheapest paths from the border node `from` through the inside of its chart: what is `on_border` (a flag a node) ends them.
    pub fn grow_inside(&mut self, surface: &Surface, cut: &[u8], node: &[u32], from: u32, on_border: &[u8]) {
        self.grow_inside_until(surface, cut, node, from, on_border, |_, _| false);
    }

    /// The same as far as they are wanted: `is_last(node, cost)` is asked at each node that is reached, in the order of costs: what lies behind the last may be left out.
    pub fn grow_inside_until(
        &mut self,
        surface: &Surface,
        cut: &[u8],
        node: &[u32],
        from: u32,
        on_border: &[u8],
        mut is_last: impl FnMut(u32, f64) -> bool,
    ) {
        self.grow(
            surface,
            cut,
            node,
            core::iter::once(from),
            |edge, _| surface.cost[edge as usize],
            |n, at| match n != from && on_border[n as usize] != 0 {
                _ if is_last(n, at) => Go::Home,
                true => Go::Around,
                false => Go::On,
            },
        );
    }

    /// Dijkstra from `sources`. `step(half-edge, the one across)` is the cost of an edge; `settle(node)` says whether to
    /// go on from a node: through it, not through it, or not at all any more.
    pub fn grow(
        &mut self,
        surface: &Surface,
        cut: &[u8],
        node: &[u32],
        sources: impl Iterator<Item = u32>,
        step: impl Fn(u32, u32) -> f64,
        mut settle: impl FnMut(u32, f64) -> Go,
    ) {
        for n in &self.touched[..self.touched_count] {
            self.cost[*n as usize] = f64::INFINITY;
            self.via[*n as usize] = NONE;
        }
        self.touched_count = 0;
        let mut touch = |n: u32| {
            self.touched[self.touched_count] = n;
            self.touched_count += 1;
        };
        let mut heap = Heap::new(self.heap_cost, self.heap_slot, self.heap_item);
        for n in sources {
            if self.cost[n as usize] > 0.0 {
                touch(n);
                self.cost[n as usize] = 0.0;
                heap.push(n, 0.0);
            }
        }
        while let Some((n, at)) = heap.pop() {
            match settle(n, at) {
                Go::On => {}
                Go::Around => continue,
                Go::Home => return,
            }
            let start = surface.wedge_start(cut, self.first[n as usize]);
            for c in surface.wedge(cut, start) {
                for (edge, far) in [(c, next(c)), (prev(c), prev(c))] {
                    let Some(t) = surface.across(cut, edge) else { continue };
                    let sum = at + step(edge, t);
                    let m = node[far as usize] as usize;
                    if sum < self.cost[m] {
                        if self.cost[m] == f64::INFINITY {
                            touch(m as u32);
                        }
                        self.cost[m] = sum;
                        self.via[m] = edge;
                        heap.push(m as u32, sum);
                    }
                }
            }
        }
    }

    /// Cuts the path from node `n` back to its source and marks the faces beside it.
    pub fn cut_back(&self, mut n: u32, cut: &mut [u8], changed: &mut [u8], node: &[u32], surface: &Surface) {
        while self.via[n as usize] != NONE {
            let c = self.via[n as usize];
            surface.set_cut(cut, c, true);
            changed[(c / 3) as usize] = 1;
            changed[(surface.twin[c as usize] / 3) as usize] = 1;
            let (p, q) = (node[c as usize], node[next(c) as usize]);
            n = if p == n { q } else { p };
        }
    }
}

/// What to do at a settled node.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Go {
    /// Paths go on through it.
    On,
    /// Paths may end there but not pass.
    Around,
    /// The search is over.
    Home,
}
