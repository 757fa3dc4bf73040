//! The borders of an atlas on another mesh of the same shape: for each arc the path of edges that leaves the least area between
//! itself and the arc.
//!
//! An arc's ends go to the nearest vertices, and Dijkstra's search finds the path between them. An edge costs the area that it
//! sweeps beside the arc: the mean distance of its ends and middle, times its own length or the length of the arc
//! that it passes by, whichever is more (so that no path cuts off a bend), and a trifle for its length. Short arcs go
//! first. A path that meets another one, or the mesh's border, pays [`MEETING`] a vertex: the charts have the topology that they
//! had, wherever the mesh has room for them. Diagonals of polygons are no edges.
//! Limit: charts narrower than an edge may fall apart or vanish; the caller counts. Cost: O(n log n) an arc at the most, mostly
//! that of the vertices near it.

use super::arcs::Arcs;
use super::closest::{ClosestTree, closest_tree_need};
use super::source::SourceAtlas;
use crate::base::heap::Heap;
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::sort;
use crate::charts::surface::Surface;
use crate::mesh::view::{MeshView, NONE, next};
use crate::mesh::working::DIAGONAL;
use glam::DVec3;

/// What an edge costs for its length, over its length times the mean edge's.
const LENGTH: f64 = 1e-3;
/// What a vertex costs that a path has already, over the mean edge's squared length. With 30, a path that has no room goes round a leg
/// of the quarter of spot; with 0 charts fall apart that need not.
const MEETING: f64 = 4.0;

/// The mesh that the borders go to.
#[derive(Clone, Copy)]
pub struct Ground<'g> {
    /// The mesh, in the frame of the source.
    pub surface: &'g Surface<'g>,
    /// Marks of half-edges, see [`crate::mesh::working::Working::fixed`].
    pub fixed: &'g [u8], // (3 f)
    /// Finds closest points on it.
    pub tree: &'g ClosestTree<'g>,
    /// Component of the source that each face belongs to.
    pub component: &'g [u32], // (f)
}

/// Bytes that [`route`] takes: `edges` seams of the source.
pub const fn routes_need(vertices: usize, edges: usize) -> usize {
    bytes_for::<u8>(vertices)
        .saturating_add(bytes_for::<f64>(vertices).saturating_mul(7))
        .saturating_add(bytes_for::<[u32; 3]>(edges))
        .saturating_add(bytes_for::<[f64; 4]>(edges + 1))
        .saturating_add(bytes_for::<[u32; 3]>(edges))
        .saturating_add(closest_tree_need(edges))
}

/// Cuts the paths of all arcs into `cut` (one entry a half-edge).
pub fn route(
    cut: &mut [u8],
    ground: &Ground,
    source: &SourceAtlas,
    component: &[u32], // of each face of the source
    arcs: &Arcs,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = ground.surface.mesh.positions.len();
    let order = scratch.take::<u32>(arcs.count())?;
    order.iter_mut().enumerate().for_each(|(i, a)| *a = i as u32);
    sort::by_key(order, |a| (arcs.edges(*a as usize).len(), *a));
    let used = scratch.take::<u8>(n)?;
    for c in (0..cut.len() as u32).filter(|c| ground.surface.twin[*c as usize] == NONE) {
        used[ground.surface.mesh.vertex(c) as usize] = 1;
        used[ground.surface.far_end(c) as usize] = 1;
    }
    let mut search = Search {
        mean: mean_edge(ground.surface),
        ground,
        used,
        cost: scratch.take(n)?,
        via: scratch.take(n)?,
        near: scratch.take(n)?,
        heap_cost: scratch.take(n)?,
        heap_slot: scratch.take(n)?,
        heap_item: scratch.take(n)?,
    };
    let ends = scratch.take::<[u32; 2]>(arcs.count())?;
    for (arc, ends) in ends.iter_mut().enumerate() {
        let edges = arcs.edges(arc);
        let (first, last) = (edges[0], edges[edges.len() - 1]);
        let part = component[(first / 3) as usize];
        let of_source = [source.surface.mesh.vertex(first), source.surface.far_end(last)];
        *ends = of_source.map(|v| search.vertex_near(source, v, part));
    }
    ends.iter().flatten().filter(|v| **v != NONE).for_each(|v| search.used[*v as usize] = 1);
    for arc in order.iter() {
        let [from, to] = ends[*arc as usize];
        if from == to || from == NONE || to == NONE {
            continue;
        }
        let mut frame = scratch.frame();
        let line = Line::new(source, arcs.edges(*arc as usize), &mut frame)?;
        if search.run(&line, from, to) {
            search.cut_back(cut, to);
        }
    }
    Ok(())
}

/// Mean length of the edges.
pub fn mean_edge(surface: &Surface) -> f64 {
    let count = surface.mesh.corner_count();
    (0..count as u32).map(|c| surface.length(c)).sum::<f64>() / count.max(1) as f64
}

/// An arc in space.
struct Line<'a> {
    tree: ClosestTree<'a>,
    along: &'a [f64], // (points) length up to each
}

impl<'a> Line<'a> {
    fn new(source: &SourceAtlas, edges: &[u32], keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let positions = keep.take::<DVec3>(edges.len() + 1)?;
        let faces = keep.take::<[u32; 3]>(edges.len())?;
        let along = keep.take::<f64>(edges.len() + 1)?;
        for (i, c) in edges.iter().enumerate() {
            positions[i] = source.surface.mesh.position(*c);
            positions[i + 1] = source.surface.mesh.position(next(*c));
            along[i + 1] = along[i] + source.surface.length(*c);
            faces[i] = [i as u32, i as u32 + 1, i as u32 + 1];
        }
        Ok(Self { tree: ClosestTree::new(MeshView { positions, faces }, keep)?, along })
    }

    /// Distance of a point, and how far along the arc the nearest point is.
    fn near(&self, p: DVec3) -> [f64; 2] {
        let Some(at) = self.tree.find(p, |_| true) else { return [0.0; 2] };
        let [a, b] = [self.along[at.face as usize], self.along[at.face as usize + 1]];
        [sqrt(at.squared), a + (b - a) * (1.0 - at.weights[0])]
    }
}

struct Search<'s> {
    ground: &'s Ground<'s>,
    mean: f64,
    used: &'s mut [u8],       // (n) whether a path or the border is there
    cost: &'s mut [f64],      // (n)
    via: &'s mut [u32],       // (n) half-edge to each vertex
    near: &'s mut [[f64; 2]], // (n) what the arc says of each vertex; NaN: not asked yet
    heap_cost: &'s mut [f64], // (n)
    heap_slot: &'s mut [u32], // (n)
    heap_item: &'s mut [u32], // (n)
}

impl Search<'_> {
    /// The vertex for vertex `v` of the source, on the border where that is.
    fn vertex_near(&self, source: &SourceAtlas, v: u32, part: u32) -> u32 {
        let surface = self.ground.surface;
        let p = source.surface.mesh.positions[v as usize];
        let gap = |w: u32| surface.mesh.positions[w as usize].distance_squared(p);
        let nearer = |a: u32, b: u32| if b == NONE || gap(a) < gap(b) { a } else { b };
        if source.surface.is_on_border(v) {
            let border = (0..surface.twin.len() as u32).filter(|c| surface.twin[*c as usize] == NONE);
            let of_part = border.filter(|c| self.ground.component[(c / 3) as usize] == part);
            let best = of_part.map(|c| surface.mesh.vertex(c)).fold(NONE, |best, w| nearer(w, best));
            // A border that is closed here has no place for it.
            if best != NONE && gap(best) < 16.0 * self.mean * self.mean {
                return best;
            }
        }
        let accept = |f: u32| self.ground.component[f as usize] == part;
        let at = self.ground.tree.find(p, accept).or_else(|| self.ground.tree.find(p, |_| true));
        at.map_or(NONE, |at| surface.mesh.faces[at.face as usize].into_iter().fold(NONE, |best, w| nearer(w, best)))
    }

    /// Whether there is a path.
    fn run(&mut self, line: &Line, from: u32, to: u32) -> bool {
        let Ground { surface, fixed, .. } = *self.ground;
        let mean = self.mean;
        self.cost.fill(f64::INFINITY);
        self.via.fill(NONE);
        self.near.fill([f64::NAN; 2]);
        let mut heap = Heap::new(self.heap_cost, self.heap_slot, self.heap_item);
        self.cost[from as usize] = 0.0;
        heap.push(from, 0.0);
        while let Some((v, at)) = heap.pop() {
            if v == to {
                return true;
            }
            let p = surface.mesh.positions[v as usize];
            let here = ask(self.near, line, v, p);
            for (c, w) in surface.edges_at(v) {
                if fixed[c as usize] == DIAGONAL {
                    continue;
                }
                let q = surface.mesh.positions[w as usize];
                let (there, middle) = (ask(self.near, line, w, q), line.near((p + q) * 0.5));
                let length = sqrt(p.distance_squared(q));
                let sweep = |a: [f64; 2], b: [f64; 2]| 0.5 * (a[0] + b[0]) * f64::abs(a[1] - b[1]).max(0.5 * length);
                let mut sum = at + sweep(here, middle) + sweep(middle, there) + LENGTH * mean * length;
                if w != to && self.used[w as usize] != 0 {
                    sum += MEETING * mean * mean;
                }
                if sum < self.cost[w as usize] {
                    self.cost[w as usize] = sum;
                    self.via[w as usize] = c;
                    heap.push(w, sum);
                }
            }
        }
        false
    }

    /// Cuts the path to `v` and marks its vertices.
    fn cut_back(&mut self, cut: &mut [u8], mut v: u32) {
        let surface = self.ground.surface;
        self.used[v as usize] = 1;
        while self.via[v as usize] != NONE {
            let c = self.via[v as usize];
            if surface.twin[c as usize] != NONE {
                surface.set_cut(cut, c, true);
            }
            let (a, b) = (surface.mesh.vertex(c), surface.far_end(c));
            v = if a == v { b } else { a };
            self.used[v as usize] = 1;
        }
    }
}

/// What the arc says of a vertex.
fn ask(near: &mut [[f64; 2]], line: &Line, v: u32, p: DVec3) -> [f64; 2] {
    let known = &mut near[v as usize];
    if known[0].is_nan() {
        *known = line.near(p);
    }
    *known
}
