//! Carries cuts from a decimated mesh to the mesh it came from.
//!
//! The collapses of the decimation (`mesh::decimate`) are undone one by one, the cut graph along with them. Undoing one
//! splits a vertex in two; the cuts there are shared out between both, and the new edge is cut where both sides need
//! it. Collapsing that edge again gives the coarser cut graph, so each step keeps the topology: no search, nothing to
//! clean up. What comes out is as jagged as the collapses were; `slide` then makes each path the cheapest nearby.
//! Guarantee: as many charts as on the coarse mesh, with the same topology; checked at the end and reported. A cut that
//! ends freely ends on the same vertex. One that ends on the border ends there too, unless other cuts are in between.
//! Cost: O(n) for the undoing; see `slide` for the rest.

use super::detour::is_forbidden;
use super::slide::{Slides, slide, slide_need};
use crate::base::real::sqrt;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::charts::surface::Surface;
use crate::mesh::collapse::{Collapse, CornerTable, Side, fan};
use crate::mesh::view::NONE;

/// What was carried over, and what could not be held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transferred {
    /// Charts on the coarse mesh.
    pub coarse_charts: usize,
    /// Charts on the fine mesh.
    pub charts: usize,
    /// Sum of the Euler characteristics of the coarse charts: as many as charts where all are disks.
    pub coarse_euler: i64,
    /// The same on the fine mesh.
    pub euler: i64,
    /// Edges that are cut although their cost is infinite.
    pub forbidden: usize,
    /// Cuts that end on another border vertex than the coarse ones do.
    pub strayed: usize,
}

impl Transferred {
    /// Whether charts and Euler characteristics are those of the coarse mesh.
    pub fn is_faithful(&self) -> bool {
        (self.coarse_charts, self.coarse_euler) == (self.charts, self.euler)
    }
}

/// Scratch bytes for [`transfer`] to a mesh of these counts.
pub const fn transfer_need(vertices: usize, faces: usize) -> usize {
    let unfold = bytes_for::<[u32; 3]>(faces)
        .saturating_add(bytes_for::<u32>(3 * faces))
        .saturating_add(bytes_for::<u32>(vertices))
        .saturating_add(bytes_for::<u8>(vertices))
        .saturating_add(bytes_for::<u8>(faces));
    let slides = slide_need(vertices, faces);
    let more = if unfold > slides { unfold } else { slides };
    bytes_for::<u32>(vertices).saturating_add(more)
}

/// Writes to `cut` (one entry a corner of `fine`) the cuts that `coarse_cut` holds on the mesh `coarse`, which came from
/// `fine` by the collapses of `history`. Paths are then slid towards lower `fine.cost`, with a reach that counts in mean
/// lengths of the coarse cut edges.
pub fn transfer(
    cut: &mut [u8],
    fine: &Surface,
    coarse: &Surface,
    coarse_cut: &[u8],
    history: &[Collapse],
    slides: Slides,
    mut scratch: Scratch,
) -> Result<Transferred, ScratchTooSmall> {
    let n = fine.mesh.positions.len();
    scratch.require(transfer_need(n, fine.mesh.faces.len()))?;
    let mut done = Transferred::default();
    (done.coarse_charts, done.coarse_euler) = count(coarse, coarse_cut, scratch.frame())?;
    let wanted = scratch.take::<u32>(n)?; // where a cut that ends at a border vertex should end
    unfold(cut, wanted, coarse_cut, history, fine, scratch.frame())?;
    let slides = Slides { reach: slides.reach * mean_length(coarse, coarse_cut), ..slides };
    slide(cut, wanted, fine, slides, scratch.frame())?;
    (done.charts, done.euler) = count(fine, cut, scratch.frame())?;
    for c in 0..cut.len() as u32 {
        if cut[c as usize] == 0 {
            continue;
        }
        done.forbidden += usize::from(is_forbidden(cut, fine, c));
        let v = fine.mesh.vertex(c);
        done.strayed += usize::from(wanted[v as usize] != v && fine.is_on_border(v));
    }
    Ok(done)
}

/// Charts and the sum of their Euler characteristics.
fn count(surface: &Surface, cut: &[u8], mut scratch: Scratch) -> Result<(usize, i64), ScratchTooSmall> {
    let faces = surface.mesh.faces.len();
    let wedges = {
        let mut frame = scratch.frame();
        surface.wedges(cut, frame.take(3 * faces)?)
    };
    let edges = (0..cut.len() as u32).filter(|c| surface.across(cut, *c).is_none_or(|t| *c < t)).count();
    let charts = surface.charts(cut, scratch.take(faces)?, scratch.take(faces)?);
    Ok((charts, wedges as i64 - edges as i64 + faces as i64))
}

/// Mean length of the cut edges.
fn mean_length(surface: &Surface, cut: &[u8]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0f64);
    for c in (0..cut.len() as u32).filter(|c| cut[*c as usize] != 0) {
        sum += surface.length(c);
        count += 1.0;
    }
    sum / count.max(1.0)
}

/// Collapses all of `history`, marks the cuts, and undoes it again with them.
fn unfold(
    cut: &mut [u8],
    wanted: &mut [u32],
    coarse_cut: &[u8],
    history: &[Collapse],
    fine: &Surface,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    let n = wanted.len();
    let faces = scratch.take::<[u32; 3]>(fine.mesh.faces.len())?;
    faces.copy_from(fine.mesh.faces);
    let twin = scratch.take::<u32>(3 * faces.len())?;
    twin.copy_from(fine.twin);
    let dead = scratch.take::<u8>(faces.len())?;
    let border = scratch.take::<u8>(n)?;
    for v in 0..n as u32 {
        wanted[v as usize] = v;
        border[v as usize] = u8::from(fine.is_on_border(v));
    }
    let table = CornerTable { faces, twin };
    let mut graph = CutGraph { fine, table, cut, degree: scratch.take(n)?, border, wanted };
    for collapse in history {
        for side in collapse.sides(graph.table.twin) {
            dead[(side.apex / 3) as usize] = 1;
        }
        graph.table.apply(*collapse);
    }
    graph.cut.fill(0);
    let live = (0..dead.len()).filter(|f| dead[*f] == 0);
    for (f, flags) in live.zip(coarse_cut.as_chunks::<3>().0.iter()) {
        for (i, flag) in flags.iter().enumerate().filter(|(_, flag)| **flag != 0) {
            graph.cut[3 * f + i] = *flag;
            graph.degree[graph.table.faces[f][i] as usize] += 1;
        }
    }
    for collapse in history.iter().rev() {
        graph.split(*collapse);
    }
    Ok(())
}

/// A cut graph on a mesh between coarse and fine.
struct CutGraph<'a> {
    fine: &'a Surface<'a>,
    table: CornerTable<'a>,
    cut: &'a mut [u8],     // (3 f)
    degree: &'a mut [u32], // (n) cut edges at each vertex
    border: &'a [u8],      // (n)
    wanted: &'a mut [u32], // (n)
}

/// One way to share out the cuts of a vertex that is split.
struct Share {
    cost: f64,
    to_removed: [bool; 2], // by side: whether the cut to the third vertex starts at the removed vertex
    bridge: bool,          // whether the edge between both is cut
    removed_degree: u32,
    kept_degree: u32,
}

impl CutGraph<'_> {
    /// Undoes one collapse.
    fn split(&mut self, collapse: Collapse) {
        let [u, v] = self.table.ends(collapse);
        let mut sides = [None; 2];
        for (slot, side) in sides.iter_mut().zip(collapse.sides(self.table.twin)) {
            // The edges from the third vertex to both ends are still one.
            let (a, b) = (self.table.twin[side.kept_edge as usize], self.table.twin[side.removed_edge as usize]);
            let shared = [a, b].into_iter().any(|c| c != NONE && self.cut[c as usize] != 0);
            for c in [a, b].into_iter().filter(|c| *c != NONE) {
                self.cut[c as usize] = 0;
            }
            *slot = Some((side, shared));
        }
        self.table.undo(collapse);
        let own = fan(self.table.twin, collapse.side().removed).map(|c| u32::from(self.cut[c as usize])).sum();
        let share = self.cheapest_share(u, v, own, &sides);
        for ((side, shared), to_removed) in sides.iter().flatten().zip(share.to_removed) {
            if *shared {
                self.set(if to_removed { side.removed_edge } else { side.kept_edge });
            }
        }
        if share.bridge {
            self.set(collapse.edge());
        }
        if sides[1].is_none() && share.removed_degree > 0 {
            // Both are on the border: the ends of cuts part without a cut between them.
            self.wanted[u as usize] = self.wanted[v as usize];
        }
        self.degree[u as usize] = share.removed_degree;
        self.degree[v as usize] = share.kept_degree;
    }

    /// The share of the shortest edges; ties leave cuts where they were. `own` cuts are the removed vertex's alone.
    fn cheapest_share(&self, u: u32, v: u32, own: u32, sides: &[Option<(Side, bool)>; 2]) -> Share {
        let length = |a: u32, b: u32| {
            let d = self.fine.mesh.positions[a as usize] - self.fine.mesh.positions[b as usize];
            sqrt(d.dot(d))
        };
        let shared = sides.map(|s| s.is_some_and(|(_, shared)| shared));
        let total = self.degree[v as usize];
        let rest = total - own - shared.iter().filter(|s| **s).count() as u32;
        let along_border = sides[1].is_none();
        let mut best = Share {
            cost: f64::INFINITY,
            to_removed: [false; 2],
            bridge: false,
            removed_degree: own,
            kept_degree: total - own,
        };
        for to_removed in [[false, false], [true, false], [false, true], [true, true]] {
            if (0..2).any(|i| to_removed[i] && (!shared[i] || along_border)) {
                continue;
            }
            let mut cost = 0.0;
            let (mut removed_degree, mut kept_degree) = (own, rest);
            for (i, side) in sides.iter().enumerate() {
                let Some((side, true)) = side else { continue };
                let apex = self.table.vertex(side.apex);
                if to_removed[i] {
                    removed_degree += 1;
                    cost += length(apex, u);
                } else {
                    kept_degree += 1;
                    cost += length(apex, v);
                }
            }
            // A cut that ends freely keeps its end; one at the border keeps its border.
            let held = kept_degree > 0 || self.border[v as usize] != 0 || total == 1;
            let bridge = !along_border && removed_degree > 0 && held;
            if bridge {
                removed_degree += 1;
                kept_degree += 1;
                cost += length(u, v);
            }
            if cost < best.cost {
                best = Share { cost, to_removed, bridge, removed_degree, kept_degree };
            }
        }
        best
    }

    /// Cuts an edge.
    fn set(&mut self, c: u32) {
        self.cut[c as usize] = 1;
        let t = self.table.twin[c as usize];
        if t != NONE {
            self.cut[t as usize] = 1;
        }
    }
}
