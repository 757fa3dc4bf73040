//! Slides the paths of a cut graph to cheaper edges nearby, without a change of topology.
//!
//! The graph is taken apart into pieces of paths between branching points, free ends, the border and joints a few lengths
//! apart. Each piece in turn is taken out and replaced by the cheapest path (Dijkstra) between its ends, which leaves
//! both in the gap that the piece leaves, meets no other cut and no border, and stays in a band around the piece. Joints
//! lie elsewhere in every round, so they slide too. Of the two charts that a piece parts, its absence makes one disk, and
//! any path across a disk leaves two; where it lies inside one chart, its absence makes an annulus, and any path from one
//! border to the other leaves a disk.
//! Guarantee: charts that are disks stay disks, and the cost never rises but where an end is brought to where it is wanted.
//! Cost: the bands' edges times log n.

use crate::base::heap::Heap;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::charts::seams::walk_seam;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next, prev};

/// Length of a piece, in band widths. Longer pieces find better ways, and their bands overlap less.
const PIECE: f64 = 4.0;
/// How much dearer an edge is at the rim of the band than in its middle, less one.
const RIM: f64 = 0.5;
/// Border edges that the end of a cut may move at the most.
const ALONG_BORDER: usize = 1000;

/// How far paths slide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slides {
    /// To either side in one round.
    pub reach: f64,
    /// Rounds.
    pub rounds: usize,
}

/// Scratch bytes for [`slide`].
pub const fn slide_need(vertices: usize, faces: usize) -> usize {
    let n = vertices;
    bytes_for::<u8>(n)
        .saturating_add(5 * bytes_for::<u32>(n))
        .saturating_add(3 * bytes_for::<f64>(n))
        .saturating_add(bytes_for::<u8>(3 * faces))
        .saturating_add(2 * bytes_for::<u32>(faces + faces / 2 + 2))
}

/// Slides all paths; the reach is a length. A path that ends at border vertex v is brought to end at
/// `wanted[v]`, where no other cut is in the way.
pub fn slide(
    cut: &mut [u8],
    wanted: &[u32],
    surface: &Surface,
    slides: Slides,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = surface.mesh.positions.len();
    let faces = surface.mesh.faces.len();
    scratch.require(slide_need(n, faces))?;
    let edges = faces + faces / 2 + 2; // at most 3 f / 2 edges have two faces
    let list = scratch.take::<u32>(edges)?;
    let start = scratch.take::<u32>(edges)?;
    let seen = scratch.take::<u8>(3 * faces)?;
    let border = scratch.take::<u8>(n)?;
    for v in 0..n as u32 {
        border[v as usize] = u8::from(surface.is_on_border(v));
    }
    let degree = scratch.take::<u32>(n)?;
    for c in 0..cut.len() as u32 {
        degree[surface.mesh.vertex(c) as usize] += u32::from(cut[c as usize] != 0);
    }
    let mut search = Replacing {
        surface,
        border,
        degree,
        near: scratch.take_filled(n, f64::INFINITY)?,
        cost: scratch.take(n)?,
        via: scratch.take(n)?,
        touched: scratch.take(n)?,
        heap: Heap::new(scratch.take(n)?, scratch.take(n)?, scratch.take(n)?),
    };
    let Slides { reach, rounds } = slides;
    for round in 0..rounds {
        // Joints of odd rounds lie in the middle between those of even ones.
        let offset = if round % 2 == 0 { 0.0 } else { 0.5 };
        let pieces = find_pieces(list, start, seen, cut, &search, PIECE * reach, offset);
        for window in start[..=pieces].windows(2) {
            let piece = &list[window[0] as usize..window[1] as usize];
            search.replace(cut, piece, wanted, reach);
        }
    }
    Ok(())
}

/// Lists the half-edges of all pieces one after another, each in order, and where each begins; returns their count.
fn find_pieces(
    list: &mut [u32],
    start: &mut [u32],
    seen: &mut [u8],
    cut: &[u8],
    search: &Replacing,
    size: f64,
    offset: f64,
) -> usize {
    let surface = search.surface;
    seen.fill(0);
    let (mut pieces, mut len) = (0, 0);
    // Paths between nodes first; what is left are closed paths without one.
    for closed in [false, true] {
        for first in 0..cut.len() as u32 {
            let fresh = cut[first as usize] != 0 && seen[first as usize] == 0;
            if !fresh || (!closed && !search.is_node(surface.mesh.vertex(first))) {
                continue;
            }
            let begin = len;
            let (is_cut, is_node) = (|c: u32| cut[c as usize] != 0, |v| search.is_node(v));
            len += walk_seam(&mut list[begin..], seen, first, surface, is_cut, is_node);
            let total = list[begin..len].iter().fold(0.0, |total, c| total + surface.length(*c));
            let is_loop = list[begin..len].last().is_some_and(|c| surface.mesh.vertex(first) == surface.far_end(*c));
            let least = if is_loop { 2.0 } else { 1.0 };
            let parts = crate::base::real::round(total / size).max(least);
            let (mut along, mut done) = (0.0, 0.0);
            start[pieces] = begin as u32;
            pieces += 1;
            for (i, c) in list[begin..len].iter().enumerate() {
                // The joints: at (k + 1 - offset) / parts of the length.
                if i > 0 && done < parts && along >= (done + 1.0 - offset) / parts * total {
                    done += 1.0;
                    start[pieces] = (begin + i) as u32;
                    pieces += 1;
                }
                along += surface.length(*c);
            }
            // A closed path with one piece would have no ends: halve it.
            if is_loop && start[pieces - 1] as usize == begin && len - begin > 1 {
                start[pieces] = (begin + (len - begin) / 2) as u32;
                pieces += 1;
            }
        }
    }
    start[pieces] = len as u32;
    pieces
}

/// Memory of one replacement, reused; between two, the heap is empty and every entry of `near` infinite.
struct Replacing<'a> {
    surface: &'a Surface<'a>,
    border: &'a [u8],
    degree: &'a mut [u32],  // (n) cut edges at each vertex
    near: &'a mut [f64],    // (n) distance from the piece
    cost: &'a mut [f64],    // (n) from the start of the new path
    via: &'a mut [u32],     // (n) half-edge to each vertex
    touched: &'a mut [u32], // (n) vertices of the band
    heap: Heap<'a>,
}

impl Replacing<'_> {
    /// Where paths end.
    fn is_node(&self, v: u32) -> bool {
        self.degree[v as usize] != 2 || self.border[v as usize] != 0
    }

    /// Replaces one piece by the cheapest path between its ends.
    fn replace(&mut self, cut: &mut [u8], piece: &[u32], wanted: &[u32], reach: f64) {
        let surface = self.surface;
        let (Some(first), Some(last)) = (piece.first(), piece.last()) else { return };
        for c in piece {
            self.mark(cut, *c, 0);
        }
        // A corner at each end, in the wedge that the piece leaves.
        let ends = [*first, surface.twin[*last as usize]];
        let better = ends.map(|c| self.wanted_corner(c, wanted));
        let band = self.grow_band(piece, better.map(|c| surface.mesh.vertex(c)), reach);
        let mut end = self.search(cut, better, band);
        if end.is_none() && better != ends {
            end = self.search(cut, ends, band);
        }
        match end {
            None => piece.iter().for_each(|c| self.mark(cut, *c, 1)),
            Some(end) => {
                let mut at = end;
                while self.via[at as usize] != NONE {
                    let c = self.via[at as usize];
                    self.mark(cut, c, 1);
                    at = surface.mesh.vertex(c);
                }
            }
        }
        for v in &self.touched[..band] {
            self.near[*v as usize] = f64::INFINITY;
        }
    }

    /// Sets or clears the cut at an edge, and counts it at its ends.
    fn mark(&mut self, cut: &mut [u8], c: u32, value: u8) {
        self.surface.set_cut(cut, c, value != 0);
        for v in [self.surface.mesh.vertex(c), self.surface.far_end(c)] {
            let degree = &mut self.degree[v as usize];
            *degree = if value == 0 { *degree - 1 } else { *degree + 1 };
        }
    }

    /// A corner where the path that ends at corner `c` should end: another one only along a free stretch of border.
    fn wanted_corner(&self, c: u32, wanted: &[u32]) -> u32 {
        let surface = self.surface;
        let v = surface.mesh.vertex(c);
        let goal = wanted[v as usize];
        if goal == v || self.border[v as usize] == 0 || self.degree[v as usize] != 0 {
            return c;
        }
        for forward in [true, false] {
            let mut at = v;
            for _ in 0..ALONG_BORDER {
                let step = surface.corners_at(at).iter().find_map(|c| {
                    let (edge, to) = if forward { (*c, next(*c)) } else { (prev(*c), prev(*c)) };
                    (surface.twin[edge as usize] == NONE).then_some(to)
                });
                let Some(corner) = step else { break };
                at = surface.mesh.vertex(corner);
                if at == v || self.degree[at as usize] != 0 {
                    break;
                }
                if at == goal {
                    return corner;
                }
            }
        }
        c
    }

    /// Distances from the piece up to `reach`, and from the vertices `more`; returns how many vertices have one.
    fn grow_band(&mut self, piece: &[u32], more: [u32; 2], reach: f64) -> usize {
        let Self { surface, near, touched, heap, .. } = self;
        let mut band = 0;
        let ends = piece.iter().flat_map(|c| [surface.mesh.vertex(*c), surface.far_end(*c)]);
        for v in ends.chain(more) {
            if near[v as usize] > 0.0 {
                near[v as usize] = 0.0;
                touched[band] = v;
                band += 1;
                heap.push(v, 0.0);
            }
        }
        while let Some((v, at)) = heap.pop() {
            for (c, w) in surface.edges_at(v) {
                let sum = at + surface.length(c);
                if sum <= reach && sum < near[w as usize] {
                    if near[w as usize] == f64::INFINITY {
                        touched[band] = w;
                        band += 1;
                    }
                    near[w as usize] = sum;
                    heap.push(w, sum);
                }
            }
        }
        // Without a reach, the band is the piece: distances are zero and weigh nothing.
        let scale = if reach > 0.0 { 1.0 / reach } else { 0.0 };
        for v in &touched[..band] {
            near[*v as usize] *= scale;
        }
        band
    }

    /// Cheapest path from the first corner's vertex to the second's, within the band and through their wedges; its last
    /// vertex, once found.
    fn search(&mut self, cut: &[u8], ends: [u32; 2], band: usize) -> Option<u32> {
        let Self { surface, border, degree, near, cost, via, touched, heap } = self;
        for v in &touched[..band] {
            cost[*v as usize] = f64::INFINITY;
            via[*v as usize] = NONE;
        }
        let [source, goal] = ends.map(|c| surface.mesh.vertex(c));
        let goal_wedge = surface.wedge_start(cut, ends[1]);
        let weight = |c: u32, w: u32| surface.cost[c as usize] * (1.0 + RIM * near[w as usize] * near[w as usize]);
        let mut relax = |at: f64, c: u32, w: u32, heap: &mut Heap| {
            let is_free = degree[w as usize] == 0 && border[w as usize] == 0;
            let enters = || {
                let t = surface.twin[c as usize];
                t != NONE && surface.wedge_start(cut, t) == goal_wedge
            };
            if near[w as usize] == f64::INFINITY || w == source || !(if w == goal { enters() } else { is_free }) {
                return;
            }
            let sum = at + weight(c, w);
            if sum < cost[w as usize] {
                cost[w as usize] = sum;
                via[w as usize] = c;
                heap.push(w, sum);
            }
        };
        let start = surface.wedge_start(cut, ends[0]);
        for c in surface.wedge(cut, start).filter(|c| surface.across(cut, *c).is_some()) {
            relax(0.0, c, surface.far_end(c), heap);
        }
        let mut found = None;
        while let Some((v, at)) = heap.pop() {
            if v == goal {
                found = Some(v);
            }
            if found.is_some() {
                // Only to leave the heap empty.
                continue;
            }
            for c in surface.corners_at(v) {
                relax(at, *c, surface.far_end(*c), heap);
            }
        }
        found
    }
}
