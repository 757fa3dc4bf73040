//! The borders of an atlas as arcs: runs of edges between branching points, free ends and the mesh's border.
//!
//! An arc whose ends are near each other for its length is parted in three, so that none is lost where a coarser mesh has one vertex
//! for both ends.
//! Cost: O(f).

use super::source::SourceAtlas;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::charts::seams::walk_seam;
use crate::charts::surface::Surface;
use crate::mesh::view::{NONE, next};

/// Distance of an arc's ends, over its length, from which it stays whole.
const STRAIGHT: f64 = 0.2;

/// All arcs.
pub struct Arcs<'a> {
    edges: &'a [u32], // half-edges, arc after arc, each in order
    start: &'a [u32], // (arcs + 1)
}

/// Bytes that [`Arcs::new`] takes.
pub const fn arcs_need(vertices: usize, faces: usize) -> usize {
    // An edge has two half-edges, and an arc an edge.
    bytes_for::<u32>(3 * faces)
        .saturating_add(bytes_for::<u32>(3 * faces + 1))
        .saturating_add(bytes_for::<u32>(vertices))
        .saturating_add(bytes_for::<u8>(3 * faces))
}

impl<'a> Arcs<'a> {
    /// Lists the arcs of an atlas.
    pub fn new(source: &SourceAtlas, keep: &mut Scratch<'a>) -> Result<Self, ScratchTooSmall> {
        let (surface, cut) = (&source.surface, source.cut);
        let is_seam = |c: u32| cut[c as usize] != 0 && surface.twin[c as usize] != NONE;
        let edges = keep.take::<u32>(cut.len())?;
        let start = keep.take::<u32>(cut.len() + 1)?;
        let mut frame = keep.frame();
        let degree = frame.take::<u32>(surface.mesh.positions.len())?;
        let seen = frame.take::<u8>(cut.len())?;
        for c in (0..cut.len() as u32).filter(|c| is_seam(*c)) {
            degree[surface.mesh.vertex(c) as usize] += 1;
        }
        let is_node = |v: u32| degree[v as usize] != 2 || surface.is_on_border(v);
        let (mut arcs, mut len) = (0, 0);
        // Arcs between nodes first; what is left are closed ones without a node.
        for closed in [false, true] {
            for first in (0..cut.len() as u32).filter(|c| is_seam(*c)) {
                if seen[first as usize] != 0 || (!closed && !is_node(surface.mesh.vertex(first))) {
                    continue;
                }
                let begin = len;
                len += walk_seam(&mut edges[begin..], seen, first, surface, is_seam, is_node);
                let parts = if is_bent(surface, &edges[begin..len]) { (len - begin).min(3) } else { 1 };
                for part in 0..parts {
                    start[arcs] = (begin + (len - begin) * part / parts) as u32;
                    arcs += 1;
                }
            }
        }
        start[arcs] = len as u32;
        Ok(Self { edges: &edges[..len], start: &start[..=arcs] })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.start.len() - 1
    }

    /// The half-edges of an arc, in order.
    pub fn edges(&self, arc: usize) -> &'a [u32] {
        &self.edges[self.start[arc] as usize..self.start[arc + 1] as usize]
    }
}

/// Whether an arc's ends are so near each other that they may be one vertex on a coarser mesh.
fn is_bent(surface: &Surface, edges: &[u32]) -> bool {
    let ends = [surface.mesh.position(edges[0]), surface.mesh.position(next(edges[edges.len() - 1]))];
    let length: f64 = edges.iter().map(|c| surface.length(*c)).sum();
    ends[0].distance_squared(ends[1]) < STRAIGHT * STRAIGHT * length * length
}
