//! A surface with cuts: which corners share one UV, which faces one chart.
//!
//! A wedge is a largest run of corners around a vertex that no cut or border edge interrupts; its corners share one UV.
//! Cuts are flags on half-edges (set on both twins), UVs stand at corners: everything else follows from those two, so a
//! change touches only what it changes.

use crate::base::real::{for_cost, for_decision, sqrt};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::mesh::view::{MeshView, NONE, next, prev};
use crate::solve::energy::Rest;
use glam::DVec2;

/// A mesh that never changes, with what cuts cost on it.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Positions and faces of an oriented manifold.
    pub mesh: MeshView<'a>,
    /// The opposite half-edge of each corner's half-edge, or `NONE` on the border.
    pub twin: &'a [u32], // (3 f)
    /// Rest shape of each face.
    pub rest: &'a [Rest], // (f)
    /// Cost of cutting each half-edge, equal for twins; infinite where a cut is forbidden.
    pub cost: &'a [f64], // (3 f)
    /// First entry of each vertex in `corners`.
    pub start: &'a [u32], // (n + 1)
    /// The corners at each vertex.
    pub corners: &'a [u32], // (3 f)
    /// Whether charts stay whole: their borders are kept from running over themselves, and no path may part them.
    pub stays_whole: bool,
}

/// See [`Surface::edges_at`].
#[derive(Clone)]
pub struct EdgesAt<'s> {
    surface: &'s Surface<'s>,
    corners: core::slice::Iter<'s, u32>,
    border: Option<(u32, u32)>,
}

impl Iterator for EdgesAt<'_> {
    type Item = (u32, u32);

    #[inline]
    fn next(&mut self) -> Option<(u32, u32)> {
        if let Some(border) = self.border.take() {
            return Some(border);
        }
        let (c, Surface { mesh, twin, .. }) = (*self.corners.next()?, self.surface);
        let into = prev(c);
        self.border = (twin[into as usize] == NONE).then(|| (into, mesh.vertex(into)));
        Some((c, mesh.vertex(next(c))))
    }
}

/// Scratch bytes that [`Surface::new`] keeps.
pub const fn surface_need(faces: usize, vertices: usize) -> usize {
    bytes_for::<u32>(vertices + 2) + bytes_for::<u32>(3 * faces)
}

impl<'a> Surface<'a> {
    /// Lists the corners of each vertex and borrows the rest.
    pub fn new<'k: 'a>(
        mesh: MeshView<'a>,
        twin: &'a [u32],
        rest: &'a [Rest],
        cost: &'a [f64],
        keep: &mut Scratch<'k>,
    ) -> Result<Self, ScratchTooSmall> {
        let n = mesh.positions.len();
        let start = keep.take::<u32>(n + 2)?;
        let corners = keep.take::<u32>(mesh.corner_count())?;
        for c in 0..mesh.corner_count() as u32 {
            start[mesh.vertex(c) as usize + 2] += 1;
        }
        for v in 2..n + 2 {
            start[v] += start[v - 1];
        }
        for c in 0..mesh.corner_count() as u32 {
            let at = &mut start[mesh.vertex(c) as usize + 1];
            corners[*at as usize] = c;
            *at += 1;
        }
        Ok(Self { mesh, twin, rest, cost, start, corners, stays_whole: false })
    }

    /// Corners at vertex `v`.
    pub fn corners_at(&self, v: u32) -> &'a [u32] {
        &self.corners[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }

    /// The half-edges (named by one of their corners) and the far ends of the edges at vertex `v`.
    pub fn edges_at(&self, v: u32) -> EdgesAt<'_> {
        EdgesAt { surface: self, corners: self.corners_at(v).iter(), border: None }
    }

    /// The far end of the half-edge of `c`.
    pub fn far_end(&self, c: u32) -> u32 {
        self.mesh.vertex(next(c))
    }

    /// Whether vertex `v` is on the border.
    pub fn is_on_border(&self, v: u32) -> bool {
        self.corners_at(v).iter().any(|c| self.twin[*c as usize] == NONE)
    }

    /// Length of the half-edge of corner `c`, rounded for sums along paths.
    pub fn length(&self, c: u32) -> f64 {
        let d = self.mesh.position(next(c)) - self.mesh.position(c);
        for_cost(sqrt(d.dot(d)))
    }

    /// The corner across the edge of `c`, unless a cut or the border is there.
    #[inline]
    pub fn across(&self, cut: &[u8], c: u32) -> Option<u32> {
        let t = self.twin[c as usize];
        (t != NONE && cut[c as usize] == 0).then_some(t)
    }

    /// Whether the edge of `c` is a cut or the border.
    #[inline]
    pub fn is_open(&self, cut: &[u8], c: u32) -> bool {
        self.twin[c as usize] == NONE || cut[c as usize] != 0
    }

    /// The open half-edge that follows the open half-edge of `c` along the same border.
    pub fn following(&self, cut: &[u8], c: u32) -> u32 {
        let mut out = next(c);
        while let Some(t) = self.across(cut, out) {
            out = next(t);
        }
        out
    }

    /// The first open half-edge of a chart's `faces`; none where the chart is closed.
    pub fn first_open(&self, cut: &[u8], faces: &[u32]) -> Option<u32> {
        faces.iter().flat_map(|f| 3 * f..3 * f + 3).find(|c| self.is_open(cut, *c))
    }

    /// An open half-edge of the outer border of a chart's `faces`: the one that starts farthest to the left. None where the chart is closed.
    pub fn outer_open(&self, cut: &[u8], faces: &[u32], uv: &[DVec2]) -> Option<u32> {
        let open = faces.iter().flat_map(|f| 3 * f..3 * f + 3).filter(|c| self.is_open(cut, *c));
        open.min_by(|a, b| uv[*a as usize].x.total_cmp(&uv[*b as usize].x))
    }

    /// Whether the two sides of the edge of `c` lie on each other, so that a cut there is not seen.
    pub fn is_closed(&self, uv: &[DVec2], c: u32) -> bool {
        let t = self.twin[c as usize];
        t != NONE && uv[c as usize] == uv[next(t) as usize] && uv[next(c) as usize] == uv[t as usize]
    }

    /// Whether the edge of `c` is a cut that is seen.
    pub fn is_seen(&self, uv: &[DVec2], cut: &[u8], c: u32) -> bool {
        cut[c as usize] != 0 && !self.is_closed(uv, c)
    }

    /// What the cuts that are seen cost.
    pub fn cost_of(&self, uv: &[DVec2], cut: &[u8]) -> f64 {
        let seen = (0..cut.len() as u32).filter(|c| self.is_seen(uv, cut, *c));
        seen.map(|c| 0.5 * self.cost[c as usize]).sum()
    }

    /// The border that the open half-edge `first` is on, once round from there.
    pub fn border<'s>(&'s self, cut: &'s [u8], first: u32) -> impl Iterator<Item = u32> + 's {
        core::iter::successors(Some(first), move |c| Some(self.following(cut, *c)).filter(|c| *c != first))
    }

    /// Sets or clears the cut on both sides of the edge of `c`.
    pub fn set_cut(&self, cut: &mut [u8], c: u32, value: bool) {
        cut[c as usize] = u8::from(value);
        if self.twin[c as usize] != NONE {
            cut[self.twin[c as usize] as usize] = u8::from(value);
        }
    }

    /// First corner of the wedge of `c`: the clockwise end, or the smallest corner of a closed fan.
    pub fn wedge_start(&self, cut: &[u8], c: u32) -> u32 {
        let (mut at, mut least) = (c, c);
        while let Some(t) = self.across(cut, at) {
            at = next(t);
            if at == c {
                return least;
            }
            least = least.min(at);
        }
        at
    }

    /// Corners of the wedge that starts at `start`, counter-clockwise.
    pub fn wedge<'s>(&'s self, cut: &'s [u8], start: u32) -> impl Iterator<Item = u32> + 's {
        let mut at = Some(start);
        core::iter::from_fn(move || {
            let c = at?;
            at = self.across(cut, prev(c)).filter(|c| *c != start);
            Some(c)
        })
    }

    /// Numbers the wedges: `node` (one entry a corner) gets the wedge of each corner, in order of their first corners.
    /// Returns their count.
    pub fn wedges(&self, cut: &[u8], node: &mut [u32]) -> usize {
        node.fill(NONE);
        let mut count = 0;
        for c in 0..node.len() as u32 {
            if node[c as usize] == NONE {
                let start = self.wedge_start(cut, c);
                for d in self.wedge(cut, start) {
                    node[d as usize] = count;
                }
                count += 1;
            }
        }
        count as usize
    }

    /// Writes into `places` one half-edge of each of as many equal shares of `border`: where a cut inwards is the cheapest to begin.
    pub fn places_on(&self, cut: &[u8], border: &[u32], places: &mut [u32]) {
        let count = places.len().max(1);
        for (i, place) in places.iter_mut().enumerate() {
            let share = border.get(i * border.len() / count..(i + 1) * border.len() / count).unwrap_or_default();
            let cheapest = share.iter().map(|c| (self.ease(cut, *c), *c)).min_by(|a, b| a.0.total_cmp(&b.0));
            *place = cheapest.map_or(NONE, |(_, c)| c);
        }
    }

    /// Cost of a unit of length of the cheapest edge inwards from the start of the half-edge `c` of a border.
    fn ease(&self, cut: &[u8], c: u32) -> f64 {
        let inner = self.wedge(cut, self.wedge_start(cut, c)).filter(|d| !self.is_open(cut, *d));
        let ease = |d: u32| for_decision(self.cost[d as usize] / self.length(d).max(f64::MIN_POSITIVE));
        inner.map(ease).fold(f64::INFINITY, f64::min)
    }

    /// Numbers the charts: `chart` (one entry a face), in order of their first faces. `queue` has one entry a face.
    /// Returns their count.
    pub fn charts(&self, cut: &[u8], chart: &mut [u32], queue: &mut [u32]) -> usize {
        chart.fill(NONE);
        let mut count = 0;
        for seed in 0..chart.len() {
            if chart[seed] != NONE {
                continue;
            }
            chart[seed] = count;
            queue[0] = seed as u32;
            let (mut head, mut tail) = (0, 1);
            while head < tail {
                let f = queue[head];
                head += 1;
                for c in 3 * f..3 * f + 3 {
                    if let Some(t) = self.across(cut, c)
                        && chart[(t / 3) as usize] == NONE
                    {
                        chart[(t / 3) as usize] = count;
                        queue[tail] = t / 3;
                        tail += 1;
                    }
                }
            }
            count += 1;
        }
        count as usize
    }
}
