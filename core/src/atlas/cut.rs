//! First cuts: every component becomes disks, through its handles, border loops and far extremities.
//!
//! Handles: tree-cotree decomposition (Eppstein 2003; Erickson, Har-Peled 2004) over the surface with its holes capped: a
//! tree of cheapest paths, a dual tree over the other edges (dearest loops first), and for each edge in neither the loop
//! that it closes. Border loops and extremities are joined to that by growing cheapest paths (Takahashi, Matsuyama 1980).
//! Extremities are the local maxima of the mean distance to sample points (Hilaga et al. 2001): tips of limbs, where a
//! cut has to end if the limb is to be flat (Sheffer, Hart 2002).
//! Guarantee: afterwards every component is one disk. Cost: O(n log n).

use super::surface::Surface;
use crate::base::heap::Heap;
use crate::base::real::for_decision;
use crate::base::scratch::{Scratch, ScratchTooSmall};
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::mesh::loops::next_on_border;
use crate::mesh::view::{MeshView, NONE, next};
use glam::DVec3;

/// Sample points of the mean distance.
const SAMPLES: usize = 8;
/// A tip is the farthest point of all within this share of the largest mean distance.
const TIP_RADIUS: f64 = 0.22;

/// Cheapest paths over vertices.
pub struct Paths<'a> {
    /// Cost from the nearest source; infinite where not reached.
    pub cost: &'a mut [f64], // (n)
    /// Half-edge over which each vertex was reached, `NONE` at sources.
    pub via: &'a mut [u32], // (n)
    queue: Queue<'a>,
}

struct Queue<'a> {
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
            queue: Queue { cost: keep.take(n)?, slot: keep.take(n)?, item: keep.take(n)? },
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

/// Marks cuts so that every component becomes one disk whose border passes all tips.
pub fn cut_to_disks(cut: &mut [u8], surface: &Surface, scratch: Scratch) -> Result<(), ScratchTooSmall> {
    cut_where_not_disks(cut, surface, true, scratch)
}

/// As [`cut_to_disks`]; without `tips` only what the topology asks for.
fn cut_where_not_disks(
    cut: &mut [u8],
    surface: &Surface,
    tips: bool,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let component = scratch.take::<u32>(n)?;
    let count = components(component, surface);
    let loops = scratch.take_filled::<u32>(n, NONE)?; // border loop of each vertex
    let loop_count = border_loops(loops, surface);
    let tip = scratch.take::<u8>(n)?;
    if tips || loop_count < count {
        find_tips(tip, component, count, surface, scratch.frame())?;
    }
    let joined = scratch.take::<u8>(n)?; // vertices on the cut graph so far
    cut_handles(cut, joined, loops, loop_count, component, surface, scratch.frame())?;
    join(cut, joined, tip, loops, component, count, surface, scratch)?;
    lengthen_single_edges(cut, surface);
    Ok(())
}

/// Lengthens slits of one edge in closed components. Such a disk has a border of two corners, which no circle holds apart: a
/// map needs three that are not on one line.
fn lengthen_single_edges(cut: &mut [u8], surface: &Surface) {
    for c in 0..cut.len() as u32 {
        let t = surface.twin[c as usize];
        let is_single =
            cut[c as usize] != 0 && c < t && surface.following(cut, c) == t && surface.following(cut, t) == c;
        if !is_single {
            continue;
        }
        let ends = [surface.mesh.vertex(c), surface.mesh.vertex(next(c))];
        let beside = ends.into_iter().flat_map(|v| surface.edges_at(v)).filter(|(_, w)| !ends.contains(w));
        let cheapest = beside.min_by(|a, b| surface.cost[a.0 as usize].total_cmp(&surface.cost[b.0 as usize]));
        if let Some((edge, _)) = cheapest {
            surface.set_cut(cut, edge, true);
        }
    }
}

/// Cuts on where cuts have left charts that are not disks: each chart by itself, as a mesh whose border the cuts are.
pub fn disks_again(cut: &mut [u8], surface: &Surface, mut scratch: Scratch) -> Result<(), ScratchTooSmall> {
    let corners = surface.mesh.corner_count();
    let node = scratch.take::<[u32; 3]>(surface.mesh.faces.len())?;
    let count = surface.wedges(cut, node.as_flattened_mut());
    let positions = scratch.take::<DVec3>(count)?;
    let twin = scratch.take::<u32>(corners)?;
    for c in 0..corners {
        positions[node.as_flattened()[c] as usize] = surface.mesh.position(c as u32);
        twin[c] = surface.across(cut, c as u32).unwrap_or(NONE);
    }
    let mesh = MeshView { positions, faces: node };
    let parted = Surface::new(mesh, twin, surface.rest, surface.cost, &mut scratch)?;
    let more = scratch.take::<u8>(corners)?;
    cut_where_not_disks(more, &parted, false, scratch)?;
    for c in 0..corners as u32 {
        if more[c as usize] != 0 {
            surface.set_cut(cut, c, true);
        }
    }
    Ok(())
}

/// Component of each vertex; returns their count. Vertices without faces are components of their own.
fn components(component: &mut [u32], surface: &Surface) -> usize {
    let mut sets = UnionFind::new(component);
    for f in surface.mesh.faces {
        sets.union(f[0], f[1]);
        sets.union(f[1], f[2]);
    }
    sets.number()
}

/// Border loop of each vertex on the border; returns their count.
fn border_loops(loops: &mut [u32], surface: &Surface) -> usize {
    let mut count = 0;
    for c in 0..surface.mesh.corner_count() as u32 {
        if surface.twin[c as usize] != NONE || loops[surface.mesh.vertex(c) as usize] != NONE {
            continue;
        }
        let mut at = c;
        loop {
            loops[surface.mesh.vertex(at) as usize] = count;
            at = next_on_border(surface.twin, at);
            if at == c || loops[surface.mesh.vertex(at) as usize] == count {
                break;
            }
        }
        count += 1;
    }
    count as usize
}

/// Marks the tips of each component: at least two on a closed one.
fn find_tips(
    tip: &mut [u8],
    component: &[u32],
    count: usize,
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = tip.len();
    let mean = scratch.take::<f64>(n)?;
    let near = scratch.take_filled::<f64>(n, f64::INFINITY)?;
    let far = scratch.take_filled::<u32>(count, NONE)?;
    let mut paths = Paths::new(n, &mut scratch)?;
    for v in (0..n as u32).rev() {
        far[component[v as usize] as usize] = v;
    }
    for round in 0..=SAMPLES {
        paths.grow(surface, far.iter().copied(), |c| surface.length(c), |_, _| {});
        if round > 0 {
            for v in 0..n {
                mean[v] += paths.cost[v];
                near[v] = near[v].min(paths.cost[v]);
            }
        }
        // First round: only to start from an end of each component. Then the point farthest from all samples.
        let distance: &[f64] = if round == 0 { paths.cost } else { near };
        far.fill(NONE);
        for v in 0..n {
            let best = &mut far[component[v] as usize];
            let is_farther = |than: u32| for_decision(distance[v]) > for_decision(distance[than as usize]);
            if distance[v].is_finite() && (*best == NONE || is_farther(*best)) {
                *best = v as u32;
            }
        }
        far.iter_mut().for_each(|v| *v = if *v == NONE { 0 } else { *v });
        if round <= 1 {
            // The two ends of a long path.
            far.iter().for_each(|v| tip[*v as usize] = 1);
        }
    }
    mean.iter_mut().for_each(|m| *m = for_decision(*m));
    // A tip has the largest mean distance of all vertices within a radius.
    let largest = scratch.take::<f64>(count)?;
    let smallest = scratch.take_filled::<f64>(count, f64::INFINITY)?;
    for v in 0..n {
        let k = component[v] as usize;
        largest[k] = largest[k].max(mean[v]);
        smallest[k] = smallest[k].min(mean[v]);
    }
    let order = scratch.take::<u32>(n)?;
    order.iter_mut().enumerate().for_each(|(i, o)| *o = i as u32);
    sort::by(order, |a, b| mean[*b as usize].total_cmp(&mean[*a as usize]).then(a.cmp(b)));
    for v in order.iter() {
        let k = component[*v as usize] as usize;
        let m = mean[*v as usize];
        if m < 1.12 * smallest[k] {
            continue;
        }
        if surface.edges_at(*v).any(|(_, w)| mean[w as usize] > m)
            || surface.start[*v as usize] == surface.start[*v as usize + 1]
        {
            continue;
        }
        let radius = TIP_RADIUS * largest[k] / SAMPLES as f64;
        let mut best = true;
        paths.grow(
            surface,
            core::iter::once(*v),
            |c| surface.length(c),
            |w, reached| {
                if reached.cost[w as usize] > radius {
                    reached.stop = true;
                } else if mean[w as usize] > m || (w != *v && tip[w as usize] != 0) {
                    best = false;
                    reached.stop = true;
                }
            },
        );
        if best {
            tip[*v as usize] = 1;
        }
    }
    Ok(())
}

/// Cuts the loops of a tree-cotree decomposition of the capped surface and marks their vertices.
fn cut_handles(
    cut: &mut [u8],
    joined: &mut [u8],
    loops: &[u32],
    loop_count: usize,
    component: &[u32],
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = component.len();
    let faces = surface.mesh.faces.len();
    let mut paths = Paths::new(n, &mut scratch)?;
    let rooted = scratch.take::<u8>(n)?;
    let roots = (0..n as u32).filter(|v| {
        let first = &mut rooted[component[*v as usize] as usize];
        *first += u8::from(*first == 0) * 2;
        let is_first = *first == 2;
        *first = 1;
        is_first
    });
    // Border edges cost nothing: a path may follow them.
    let weight = |c: u32| if surface.twin[c as usize] == NONE { 0.0 } else { surface.cost[c as usize] };
    paths.grow(surface, roots, weight, |_, _| {});
    let in_tree = |c: u32| {
        let (a, b) = (surface.mesh.vertex(c), surface.mesh.vertex(next(c)));
        let same = |v: u32| {
            let via = paths.via[v as usize];
            via == c || (via != NONE && via == surface.twin[c as usize])
        };
        same(a) || same(b)
    };
    let list = scratch.take::<[u64; 2]>(surface.mesh.corner_count())?;
    let mut len = 0;
    for c in 0..surface.mesh.corner_count() as u32 {
        let t = surface.twin[c as usize];
        if (t == NONE || c < t) && !in_tree(c) {
            let (a, b) = (surface.mesh.vertex(c), surface.mesh.vertex(next(c)));
            let around = paths.cost[a as usize] + paths.cost[b as usize] + weight(c);
            // Dearest first: larger non-negative floats have larger bits.
            list[len] = [!around.max(0.0).to_bits(), u64::from(c)];
            len += 1;
        }
    }
    let list = &mut list[..len];
    sort::ascending(list);
    let parent = scratch.take::<u32>(faces + loop_count)?;
    let mut dual = UnionFind::new(parent);
    for [_, c] in list.iter() {
        let c = *c as u32;
        let t = surface.twin[c as usize];
        let other = if t == NONE { faces as u32 + loops[surface.mesh.vertex(c) as usize] } else { t / 3 };
        if dual.union(c / 3, other) || t == NONE {
            continue;
        }
        // In neither tree: the edge closes a loop around a handle.
        surface.set_cut(cut, c, true);
        for end in [surface.mesh.vertex(c), surface.mesh.vertex(next(c))] {
            for (e, _) in paths.trace(surface, end) {
                if surface.twin[e as usize] != NONE {
                    surface.set_cut(cut, e, true);
                }
            }
        }
    }
    prune(cut, surface, |_| false, scratch)?;
    for c in 0..surface.mesh.corner_count() as u32 {
        if cut[c as usize] != 0 {
            joined[surface.mesh.vertex(c) as usize] = 1;
            joined[surface.mesh.vertex(next(c)) as usize] = 1;
        }
    }
    Ok(())
}

/// Removes cut edges that end freely at a vertex which `keep` does not hold, until none is left.
pub fn prune(
    cut: &mut [u8],
    surface: &Surface,
    keep: impl Fn(u32) -> bool,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let degree = scratch.take::<u32>(n)?;
    for c in 0..surface.mesh.corner_count() as u32 {
        let t = surface.twin[c as usize];
        if t == NONE || (cut[c as usize] != 0 && c < t) {
            degree[surface.mesh.vertex(c) as usize] += 1;
            degree[surface.mesh.vertex(next(c)) as usize] += 1;
        }
    }
    for v in 0..n as u32 {
        let mut at = v;
        while degree[at as usize] == 1 && !keep(at) {
            let Some((c, w)) = surface.edges_at(at).find(|(c, _)| cut[*c as usize] != 0) else { break };
            surface.set_cut(cut, c, false);
            degree[at as usize] = 0;
            degree[w as usize] -= 1;
            at = w;
        }
    }
    Ok(())
}

/// Joins every border loop and tip of a component to its cut graph by cheapest paths.
#[allow(clippy::too_many_arguments)]
fn join(
    cut: &mut [u8],
    joined: &mut [u8],
    tip: &[u8],
    loops: &[u32],
    component: &[u32],
    count: usize,
    surface: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = joined.len();
    // A component without handles starts at its first border loop, or at its first tip.
    let started = scratch.take::<u8>(count)?;
    for v in 0..n {
        started[component[v] as usize] |= joined[v];
    }
    for pass in 0..2 {
        for v in 0..n {
            let start = &mut started[component[v] as usize];
            if *start == 0 && if pass == 0 { loops[v] != NONE } else { tip[v] != 0 } {
                *start = 1;
                joined[v] = 1;
            }
        }
    }
    let loop_next = scratch.take_filled::<u32>(n, NONE)?; // next vertex of the same loop
    let loop_first = scratch.take_filled::<u32>(n, NONE)?; // by loop
    for v in 0..n {
        if loops[v] != NONE {
            loop_next[v] = loop_first[loops[v] as usize];
            loop_first[loops[v] as usize] = v as u32;
        }
    }
    let mut paths = Paths::new(n, &mut scratch)?;
    let sources = scratch.take::<u32>(n)?;
    let mut len = 0;
    for v in 0..n as u32 {
        if joined[v as usize] != 0 {
            sources[len] = v;
            len += 1;
        }
    }
    let open_loop = scratch.take::<u8>(n)?; // by loop: joined already
    paths.grow(
        surface,
        sources[..len].iter().copied(),
        |c| if surface.twin[c as usize] == NONE { 0.0 } else { surface.cost[c as usize] },
        |v, reached| {
            let on_loop = loops[v as usize] != NONE && open_loop[loops[v as usize] as usize] == 0;
            let is_tip = tip[v as usize] != 0 && reached.via[v as usize] != NONE;
            if !on_loop && !is_tip {
                return;
            }
            let mut at = v;
            while reached.via[at as usize] != NONE {
                let c = reached.via[at as usize];
                let (a, b) = (surface.mesh.vertex(c), surface.mesh.vertex(next(c)));
                if surface.twin[c as usize] != NONE {
                    surface.set_cut(cut, c, true);
                }
                reached.source(at);
                at = if a == at { b } else { a };
            }
            if on_loop {
                let mut w = loop_first[loops[v as usize] as usize];
                open_loop[loops[v as usize] as usize] = 1;
                while w != NONE {
                    reached.source(w);
                    w = loop_next[w as usize];
                }
            }
        },
    );
    Ok(())
}
