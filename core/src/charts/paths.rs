//! Cheapest paths over the vertices of a surface (Dijkstra): from many sources at once, and from places found on the way.
//!
//! Cuts do not stop them; `wedge_paths` has those that stay inside of charts. Cost: O(n log n) a search.

use super::surface::Surface;
use crate::base::heap::Heap;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::mesh::view::{NONE, next};

/// Cheapest paths over vertices.
pub struct Paths<'a> {
    /// Cost from the nearest source; infinite where not reached.
    pub cost: &'a mut [f64], // (n)
    /// Half-edge over which each vertex was reached, `NONE` at sources.
    pub via: &'a mut [u32], // (n)
    queue: PathQueue<'a>,
}

struct PathQueue<'a> {
    cost: &'a mut [f64],
    slot: &'a mut [u32],
    item: &'a mut [u32],
}

impl<'a> Paths<'a> {
    /// Memory for `n` vertices.
    pub fn new(n: usize, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        Ok(Self {
            cost: keep.take_filled(n, f64::INFINITY)?,
            via: keep.take_filled(n, NONE)?,
            queue: PathQueue { cost: keep.take(n)?, slot: keep.take(n)?, item: keep.take(n)? },
        })
    }

    /// Dijkstra from `sources` with `weight` for a half-edge. `reach(v, paths so far)` is called when v is settled and
    /// answers which vertices become sources from then on, through the given callback.
    pub fn grow(
        &mut self,
        surface: &Surface,
        sources: impl Iterator<Item = u32>,
        weight: impl Fn(u32) -> f64,
        mut reach: impl FnMut(u32, &mut Reached),
    ) {
        let Self { cost, via, queue } = self;
        cost.fill(f64::INFINITY);
        via.fill(NONE);
        let mut heap = Heap::new(queue.cost, queue.slot, queue.item);
        for v in sources {
            cost[v as usize] = 0.0;
            heap.push(v, 0.0);
        }
        while let Some((v, at)) = heap.pop() {
            if at > cost[v as usize] {
                continue;
            }
            let mut reached = Reached { cost, via, heap: &mut heap, stop: false };
            reach(v, &mut reached);
            if reached.stop {
                return;
            }
            let at = cost[v as usize];
            for (c, w) in surface.edges_at(v) {
                let sum = at + weight(c);
                if sum < cost[w as usize] {
                    cost[w as usize] = sum;
                    via[w as usize] = c;
                    heap.push(w, sum);
                }
            }
        }
    }

    /// The path from vertex `v` back to its source, as (half-edge, nearer vertex) pairs.
    pub fn trace<'s>(&'s self, surface: &'s Surface, v: u32) -> impl Iterator<Item = (u32, u32)> + 's {
        trace(self.via, surface, v)
    }
}

fn trace<'s>(via: &'s [u32], surface: &'s Surface, v: u32) -> impl Iterator<Item = (u32, u32)> + 's {
    let mut at = v;
    core::iter::from_fn(move || {
        let c = via[at as usize];
        if c == NONE {
            return None;
        }
        let (a, b) = (surface.mesh.vertex(c), surface.mesh.vertex(next(c)));
        at = if a == at { b } else { a };
        Some((c, at))
    })
}

/// What a visitor of [`Paths::grow`] may do.
pub struct Reached<'r, 'h> {
    /// Costs so far.
    pub cost: &'r mut [f64],
    /// Half-edges so far.
    pub via: &'r mut [u32],
    heap: &'r mut Heap<'h>,
    /// Set to end the search.
    pub stop: bool,
}

impl Reached<'_, '_> {
    /// Makes `v` a source from now on.
    pub fn source(&mut self, v: u32) {
        self.via[v as usize] = NONE;
        if self.cost[v as usize] > 0.0 {
            self.cost[v as usize] = 0.0;
            self.heap.push(v, 0.0);
        }
    }
}
