//! Decimation: a coarse mesh on a subset of the vertices, by half-edge collapses of least quadric error.
//!
//! Garland, Heckbert 1997, with planes across border edges; only vertices of the mesh are kept, where they are. Each
//! vertex stands in one heap with its cheapest allowed collapse; one whose surroundings have changed is looked at again
//! when it comes up. A collapse is allowed where the link condition holds on the surface with its holes capped (Dey et
//! al. 1999), no face turns over and no sliver arises.
//! Guarantee: an oriented manifold stays one, and so do its genus, its components and its border loops. The answer holds
//! the collapses in order, so that what is found on the coarse mesh can be carried back (`carry::transfer`).
//! Limits: a vertex that is the tip of two fans stays, and so do its neighbours' edges to it. Where no collapse is allowed
//! any more, the target is missed; the summary says so.

use super::collapse::{Collapse, CornerTable, fan};
use super::quadric::Quadric;
use super::ring::{MOST, Ring};
use super::view::{MeshView, NONE, next, prev};
use crate::base::heap::Heap;
use crate::base::real::sqrt;
use crate::base::room::Room;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use glam::DVec3;
use heapless::Vec;

/// Weight of a border plane against that of a face as large as the square of the edge.
const BORDER: f64 = 10.0;
/// Weight of squared edge length against squared distance. 1e-4 leaves long thin faces on cylinders, 1e-2 rounds off
/// ears and fingers.
const EVEN: f64 = 1e-3;

/// Edges of a line at a vertex that it passes.
const PASSING: usize = 2;

/// Where a vertex stands: not in the heap, in it with its best collapse, or in it with one that has to be found again.
const OUT: u8 = 0;
const FRESH: u8 = 1;
const STALE: u8 = 2;

/// What was reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Decimated {
    /// Faces of the coarse mesh.
    pub faces: usize,
    /// Its vertices.
    pub vertices: usize,
    /// Collapses in the history.
    pub collapses: usize,
}

/// Scratch bytes for [`decimate`]: about 70 a face.
pub const fn decimate_need(vertices: usize, faces: usize) -> usize {
    bytes_for::<u32>(3 * faces)
        .saturating_add(bytes_for::<u8>(faces))
        .saturating_add(bytes_for::<u8>(3 * faces))
        .saturating_add(bytes_for::<Quadric>(vertices))
        .saturating_add(4 * bytes_for::<u32>(vertices))
        .saturating_add(bytes_for::<Collapse>(vertices))
        .saturating_add(bytes_for::<f64>(vertices))
        .saturating_add(bytes_for::<u8>(vertices))
}

/// The alarm is looked at once in so many vertices and one, a power of two.
const LOOK: u32 = (1 << 12) - 1;

/// Collapses edges until at most `target` faces are left, or no collapse is allowed.
///
/// `mesh` is an oriented manifold in the unit box, `twin` its adjacency, `hard` a flag a half-edge, the same for twins. Of `faces` (as long as the mesh's), `vertex`
/// and `history` (one entry a vertex of the mesh) the leading entries hold the answer, as many as the summary says: the
/// coarse faces, in the order of the faces they were; for each coarse vertex the vertex it is, rising; the collapses.
/// Vertices without faces are left out. A point that is not a number stays where it is. Cost: O(n log n).
#[allow(clippy::too_many_arguments)]
pub fn decimate(
    faces: &mut [[u32; 3]],
    vertex: &mut [u32],
    history: &mut [Collapse],
    mesh: MeshView,
    twin: &[u32],
    hard: &[u8],
    target: usize,
    mut scratch: Scratch,
) -> Result<Decimated, ScratchTooSmall> {
    let n = mesh.positions.len();
    scratch.require(decimate_need(n, mesh.faces.len()))?;
    faces.copy_from(mesh.faces);
    let working_twin = scratch.take::<u32>(3 * faces.len())?;
    working_twin.copy_from(twin);
    let dead = scratch.take::<u8>(faces.len())?;
    let working_hard = scratch.take::<u8>(3 * faces.len())?;
    working_hard.copy_from(hard);
    let mut work = Collapsing {
        positions: mesh.positions,
        table: CornerTable { faces, twin: working_twin },
        hard: working_hard,
        corner: scratch.take_filled(n, NONE)?,
        quadric: scratch.take(n)?,
        stamp: scratch.take(n)?,
        stamps: 0,
        state: scratch.take(n)?,
        best: scratch.take(n)?,
    };
    work.find_fans();
    work.sum_quadrics();
    let mut heap = Heap::new(scratch.take(n)?, scratch.take(n)?, scratch.take(n)?);
    let mut ring = Ring::default();
    for v in 0..n as u32 {
        if v & LOOK == 0 {
            scratch.look_up()?;
        }
        work.refresh(v, &mut ring, &mut heap);
    }
    let (mut live, mut collapses) = (mesh.faces.len(), 0);
    while live > target
        && let Some((u, _)) = heap.pop()
    {
        if work.state[u as usize] == STALE {
            work.refresh(u, &mut ring, &mut heap);
            continue;
        }
        if collapses & LOOK as usize == 0 {
            scratch.look_up()?;
        }
        work.state[u as usize] = OUT;
        let collapse = work.best[u as usize];
        for side in collapse.sides(work.table.twin) {
            dead[(side.apex / 3) as usize] = 1;
            live -= 1;
        }
        history[collapses] = collapse;
        collapses += 1;
        let v = work.collapse(collapse);
        work.reconsider(v, &mut ring, &mut heap);
        let mut around = Around::new(work.corner[v as usize]);
        while let Some(w) = around.next(&work.table) {
            work.reconsider(w, &mut ring, &mut heap);
        }
    }
    let vertices = compact(work.table.faces, vertex, work.stamp, dead);
    Ok(Decimated { faces: live, vertices, collapses })
}

/// Moves the live faces to the front and numbers their vertices; returns how many there are.
fn compact(faces: &mut [[u32; 3]], vertex: &mut [u32], number: &mut [u32], dead: &[u8]) -> usize {
    number.fill(NONE);
    let mut live = 0;
    for f in 0..faces.len() {
        if dead[f] == 0 {
            faces[live] = faces[f];
            faces[f].iter().for_each(|v| number[*v as usize] = 0);
            live += 1;
        }
    }
    let mut count = 0;
    for (v, number) in number.iter_mut().enumerate() {
        if *number != NONE {
            *number = count as u32;
            vertex[count] = v as u32;
            count += 1;
        }
    }
    for face in &mut faces[..live] {
        *face = face.map(|v| number[v as usize]);
    }
    count
}

/// Neighbours of a vertex, one at a time, without holding the table.
struct Around {
    start: u32,
    at: u32,
    last: u32,
}

impl Around {
    /// From a vertex's own corner (on the border the one whose half-edge is the border).
    fn new(start: u32) -> Self {
        Self { start, at: start, last: NONE }
    }

    fn next(&mut self, table: &CornerTable) -> Option<u32> {
        if self.at == NONE {
            // Behind the last face of an open fan stands one neighbour more.
            let last = core::mem::replace(&mut self.last, NONE);
            return (last != NONE).then(|| table.vertex(prev(last)));
        }
        let c = self.at;
        self.at = table.twin[prev(c) as usize];
        if self.at == NONE {
            self.last = c;
        } else if self.at == self.start {
            self.at = NONE;
        }
        Some(table.vertex(next(c)))
    }
}

/// State of the collapses.
struct Collapsing<'a> {
    positions: &'a [DVec3], // (n)
    table: CornerTable<'a>,
    hard: &'a mut [u8],         // (3 f)
    corner: &'a mut [u32],      // (n) a corner; on the border the one whose half-edge is the border; NONE: locked
    quadric: &'a mut [Quadric], // (n)
    stamp: &'a mut [u32],       // (n)
    stamps: u32,
    state: &'a mut [u8],      // (n) whether the vertex stands in the heap
    best: &'a mut [Collapse], // (n) of those that do
}

impl Collapsing<'_> {
    fn position(&self, v: u32) -> DVec3 {
        self.positions[v as usize]
    }

    /// Finds each vertex's corner and locks the tips of several fans.
    fn find_fans(&mut self) {
        for c in 0..self.table.twin.len() as u32 {
            let at = &mut self.corner[self.table.vertex(c) as usize];
            if *at == NONE || self.table.twin[c as usize] == NONE {
                *at = c;
            }
            self.stamp[self.table.vertex(c) as usize] += 1;
        }
        for (corner, count) in self.corner.iter_mut().zip(self.stamp.iter_mut()) {
            if *corner != NONE && fan(self.table.twin, *corner).take(*count as usize + 1).count() != *count as usize {
                *corner = NONE;
            }
            *count = 0;
        }
    }

    /// Whether the half-edge of `c` is on a line that the coarse mesh keeps: the border or a hard edge.
    fn is_line(&self, c: u32) -> bool {
        self.table.twin[c as usize] == NONE || self.hard[c as usize] != 0
    }

    /// Lines at the vertex of corner `start`, [`PASSING`] where one passes.
    fn lines_at(&self, start: u32) -> usize {
        let of = |c: u32| {
            let into = prev(c);
            usize::from(self.is_line(c)) + usize::from(self.table.twin[into as usize] == NONE)
        };
        fan(self.table.twin, start).map(of).sum()
    }

    /// Sums the planes of the faces, by area, and those across the border and hard edges, at each vertex.
    fn sum_quadrics(&mut self) {
        for f in 0..self.table.faces.len() {
            let face = self.table.faces[f];
            let [a, b, c] = face.map(|v| self.position(v));
            let normal = (b - a).cross(c - a);
            let twice = sqrt(normal.dot(normal));
            if twice.is_nan() || twice <= f64::MIN_POSITIVE {
                continue;
            }
            let unit = normal / twice;
            for v in face {
                self.quadric[v as usize] += Quadric::plane(unit, a, 0.5 * twice);
            }
            for i in 0..3 {
                if !self.is_line((3 * f + i) as u32) {
                    continue;
                }
                let ends = [face[i], face[(i + 1) % 3]];
                let along = self.position(ends[1]) - self.position(ends[0]);
                let squared = along.dot(along);
                let across = along.cross(unit) / sqrt(squared);
                for v in ends {
                    self.quadric[v as usize] += Quadric::plane(across, self.position(ends[0]), BORDER * squared);
                }
            }
        }
    }

    /// What is around `u` has changed. Costs mostly rise, so one that stands in the heap waits until it comes up: that
    /// saves two of three evaluations.
    fn reconsider(&mut self, u: u32, ring: &mut Ring, heap: &mut Heap) {
        if self.state[u as usize] == OUT {
            self.refresh(u, ring, heap);
        } else {
            self.state[u as usize] = STALE;
        }
    }

    /// Finds the best collapse of `u` and puts it into the heap, where it does not stand now.
    fn refresh(&mut self, u: u32, ring: &mut Ring, heap: &mut Heap) {
        self.state[u as usize] = OUT;
        let start = self.corner[u as usize];
        if start == NONE {
            return;
        }
        let lines = self.lines_at(start);
        if ![0, PASSING].contains(&lines) || ring.read(self.positions, &self.table, start).is_none() {
            return;
        }
        self.stamps += 1;
        ring.vertex.iter().for_each(|w| self.stamp[*w as usize] = self.stamps);
        let (from, own) = (self.position(u), self.quadric[u as usize]);
        let mut bare = Vec::<f64, { MOST + 1 }>::new();
        for (v, to) in ring.vertex.iter().zip(&ring.point) {
            let error = own.at(*to) + self.quadric[*v as usize].at(*to);
            bare.put(error + EVEN * ring.area * (*to - from).dot(*to - from));
        }
        let (mut least, mut best) = (f64::INFINITY, Collapse::default());
        // Cheapest first: quality is 1 at the most, so no cost is below the bare one.
        while let Some(i) = least_below(&bare, least) {
            if let Some(collapse) = ring.collapse(i)
                && (lines == 0 || self.is_line(collapse.edge()))
                && let Some(quality) = ring.quality_at(i)
                && bare[i] / quality < least
                && self.keeps_topology(collapse, ring.vertex[i])
                && !ring.doubles(&self.table, i)
            {
                (least, best) = (bare[i] / quality, collapse);
            }
            bare[i] = f64::INFINITY;
        }
        if least < f64::INFINITY {
            self.state[u as usize] = FRESH;
            self.best[u as usize] = best;
            heap.push(u, least);
        }
    }

    /// Link condition of a collapse onto `v`, with the neighbours of the removed vertex stamped.
    fn keeps_topology(&self, collapse: Collapse, v: u32) -> bool {
        let twin = &*self.table.twin;
        if self.corner[v as usize] == NONE {
            return false;
        }
        let mut dying = 0;
        for side in collapse.sides(twin) {
            dying += 1;
            // The third vertex would lose its last face.
            if twin[side.kept_edge as usize] == NONE && twin[side.removed_edge as usize] == NONE {
                return false;
            }
        }
        let mut common = 0;
        let mut around = Around::new(self.corner[v as usize]);
        while let Some(w) = around.next(&self.table) {
            common += usize::from(self.stamp[w as usize] == self.stamps);
        }
        common == dying
    }

    /// Collapses and returns the kept vertex.
    fn collapse(&mut self, collapse: Collapse) -> u32 {
        let [u, v] = self.table.ends(collapse);
        // The two edges of a face that dies become one, hard where either was.
        for side in collapse.sides(self.table.twin) {
            let edges = [side.kept_edge, side.removed_edge].map(|e| e as usize);
            let mark = self.hard[edges[0]] | self.hard[edges[1]];
            for t in edges.map(|e| self.table.twin[e]).into_iter().filter(|t| *t != NONE) {
                self.hard[t as usize] |= mark;
            }
        }
        self.table.apply(collapse);
        let removed = self.quadric[u as usize];
        self.quadric[v as usize] += removed;
        self.corner[u as usize] = NONE;
        let twin = &*self.table.twin;
        let mut start = NONE;
        for side in collapse.sides(twin) {
            // Outside the dead face, both stand along one edge between the third vertex and the kept one.
            for edge in [side.kept_edge, side.removed_edge] {
                let t = twin[edge as usize];
                if t == NONE {
                    continue;
                }
                let apex = self.table.vertex(side.apex);
                let (at_apex, at_v) = if self.table.vertex(t) == apex { (t, next(t)) } else { (next(t), t) };
                start = at_v;
                let corner = &mut self.corner[apex as usize];
                if *corner != NONE {
                    *corner = first_of_fan(twin, at_apex);
                }
            }
        }
        self.corner[v as usize] = first_of_fan(twin, start);
        v
    }
}

/// The corner of a fan whose half-edge is the border; any, where the fan is closed.
fn first_of_fan(twin: &[u32], start: u32) -> u32 {
    fan(twin, start).find(|c| twin[*c as usize] == NONE).unwrap_or(start)
}

/// Place of the least value below `bound`; ties go to the first.
fn least_below(values: &[f64], bound: f64) -> Option<usize> {
    let mut least = bound;
    let mut found = None;
    for (i, value) in values.iter().enumerate() {
        if *value < least {
            (least, found) = (*value, Some(i));
        }
    }
    found
}
