//! Vertices that are welded one by one, each weld looked at before it is done.
//!
//! A joint is a set of places that are one vertex, named by its lowest. A weld is refused where a vertex would move too far, a polygon
//! would name a joint twice, lose most of its area or turn over, or an edge would get a third face.

use super::open_side::OpenSide;
use super::polygons::Polygons;
use super::view::NONE;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use glam::DVec3;

/// Corners of a joint beyond which it takes no more in: a fan of them all is looked at for each weld.
const MOST_CORNERS: usize = 2048;
/// Corners of a polygon that are looked at around one that moves.
const WINDOW: u32 = 16;
/// Least share of its area, as it faces, that a polygon must keep when a corner moves.
const LEAST_AREA: f64 = 0.25;

/// The welds so far.
pub(super) struct Joints<'a, 'i> {
    input: &'i Polygons<'i>,
    same: &'a [u32],      // (n), as it was
    joint: &'a mut [u32], // (n), of places
    ring: &'a mut [u32],  // (n), the next place of the same joint
    fan: &'a mut [u32],   // corners at places on the border, by place
}

/// Scratch bytes for [`Joints::new`].
pub(super) const fn joints_need(vertices: usize, corners: usize) -> usize {
    bytes_for::<u32>(vertices).saturating_mul(3).saturating_add(bytes_for::<u32>(corners))
}

impl<'a, 'i> Joints<'a, 'i> {
    /// Nothing is welded but what `same` says.
    pub fn new(
        same: &[u32],
        input: &'i Polygons<'i>,
        edges: &[OpenSide],
        scratch: &mut Scratch<'a>,
    ) -> Result<Self, ScratchTooSmall> {
        let before = scratch.take::<u32>(same.len())?;
        before.copy_from(same);
        let before = &*before;
        let joint = scratch.take_filled::<u32>(same.len(), NONE)?;
        let ring = scratch.take::<u32>(same.len())?;
        for v in edges.iter().flat_map(|e| [e[0], e[1]]) {
            joint[v as usize] = v;
        }
        ring.iter_mut().enumerate().for_each(|(i, r)| *r = i as u32);
        let all = scratch.take::<u32>(input.corners.len())?;
        let at = |c: u32| before[input.corners[c as usize] as usize];
        let mut count = 0;
        for c in input.polygons().flatten().filter(|c| joint[at(*c) as usize] != NONE) {
            all[count] = c;
            count += 1;
        }
        let fan = &mut all[..count];
        sort::by_key(fan, |&c| (at(c), c));
        Ok(Self { input, same: before, joint, ring, fan })
    }

    /// The joint at a corner; inside the mesh, its place.
    fn at(&self, c: u32) -> u32 {
        let place = self.same[self.input.corners[c as usize] as usize];
        self.of(place)
    }

    fn of(&self, place: u32) -> u32 {
        match self.joint[place as usize] {
            NONE => place,
            joint => joint,
        }
    }

    /// How far the ends of two edges are apart, run along in opposite directions or, where that is nearer, in the same.
    pub fn width(&self, e: OpenSide, f: OpenSide, place: &impl Fn(u32) -> DVec3) -> f64 {
        let gap = |a: u32, b: u32| if self.of(a) == self.of(b) { 0.0 } else { place(a).distance(place(b)) };
        gap(e[0], f[1]).max(gap(e[1], f[0])).min(gap(e[0], f[0]).max(gap(e[1], f[1])))
    }

    /// Welds the ends of two edges, or nothing.
    pub fn close(&mut self, e: OpenSide, f: OpenSide, widest: f64, place: impl Fn(u32) -> DVec3) -> bool {
        let gap = |a: u32, b: u32| if self.of(a) == self.of(b) { 0.0 } else { place(a).distance(place(b)) };
        let crossed = gap(e[0], f[1]).max(gap(e[1], f[0])) <= gap(e[0], f[0]).max(gap(e[1], f[1]));
        let [first, second] = if crossed { [[e[0], f[1]], [e[1], f[0]]] } else { [[e[0], f[0]], [e[1], f[1]]] };
        let Some(welded) = self.weld(first, widest, &place) else { return false };
        if self.weld(second, widest, &place).is_some() {
            return true;
        }
        if let Some([kept, moved]) = welded {
            self.part(kept, moved);
        }
        false
    }

    /// Makes two places one: the joints that it was, `Some(None)` where they were one already; `None`: that must not be.
    fn weld(&mut self, [a, b]: [u32; 2], widest: f64, place: &impl Fn(u32) -> DVec3) -> Option<Option<[u32; 2]>> {
        let (kept, moved) = (self.of(a).min(self.of(b)), self.of(a).max(self.of(b)));
        if kept == moved {
            return Some(None);
        }
        let target = place(kept);
        let reached = self.places(moved).all(|v| place(v).distance(target) <= widest);
        let crowded = self.corners(kept).count().max(self.corners(moved).count()) > MOST_CORNERS;
        if !reached || crowded || !self.corners(moved).all(|c| self.stays_whole(c, kept, target, place)) {
            return None;
        }
        if self.neighbours(moved).any(|w| self.faces(moved, w) + self.faces(kept, w) > 2 && self.faces(kept, w) > 0) {
            return None;
        }
        self.name_ring(moved, kept);
        self.ring.swap(kept as usize, moved as usize);
        Some(Some([kept, moved]))
    }

    /// Undoes the last weld.
    fn part(&mut self, kept: u32, moved: u32) {
        self.ring.swap(kept as usize, moved as usize);
        self.name_ring(moved, moved);
    }

    /// Says that the places of the ring of `first` are those of `joint`.
    fn name_ring(&mut self, first: u32, joint: u32) {
        let mut v = first;
        loop {
            self.joint[v as usize] = joint;
            v = self.ring[v as usize];
            if v == first {
                return;
            }
        }
    }

    /// The places of a joint.
    fn places(&self, joint: u32) -> impl Iterator<Item = u32> {
        let mut at = Some(joint);
        core::iter::from_fn(move || {
            let v = at?;
            let next = self.ring[v as usize];
            at = Some(next).filter(|next| *next != joint);
            Some(v)
        })
    }

    /// The corners at a joint.
    fn corners(&self, joint: u32) -> impl Iterator<Item = u32> {
        let own = |c: u32| self.same[self.input.corners[c as usize] as usize];
        self.places(joint).flat_map(move |v| {
            let start = self.fan.partition_point(|c| own(*c) < v);
            self.fan[start..].iter().copied().take_while(move |c| own(*c) == v)
        })
    }

    /// The polygon of a corner, as a range of corners.
    fn polygon(&self, c: u32) -> [u32; 2] {
        let starts = self.input.polygon_start;
        let after = starts.partition_point(|start| *start <= c).clamp(1, starts.len().max(2) - 1);
        [starts[after - 1], starts[after]]
    }

    /// Where the corners before and after one stand.
    fn beside(&self, c: u32) -> [u32; 2] {
        let [first, end] = self.polygon(c);
        [if c == first { end - 1 } else { c - 1 }, if c + 1 == end { first } else { c + 1 }]
    }

    /// Whether the polygon of a corner that moves to the joint `kept` names that nowhere, and keeps facing as it does.
    fn stays_whole(&self, c: u32, kept: u32, target: DVec3, place: &impl Fn(u32) -> DVec3) -> bool {
        let [first, end] = self.polygon(c);
        let from = c.saturating_sub(WINDOW).max(first);
        let to = c.saturating_add(WINDOW).min(end);
        if (from..to).chain(self.beside(c)).any(|other| self.at(other) == kept) {
            return false;
        }
        if end - first > 2 * WINDOW {
            return true;
        }
        let own = place(self.at(c));
        let point = |c: u32| place(self.at(c)) - own;
        let pairs = (first..end).map(|a| (a, if a + 1 == end { first } else { a + 1 }));
        let area: DVec3 = pairs.map(|(a, b)| point(a).cross(point(b))).sum();
        let [before, after] = self.beside(c).map(point);
        let moved = area + (target - own).cross(after - before);
        moved.dot(area) >= LEAST_AREA * area.dot(area)
    }

    /// The joints at the other ends of a joint's edges, once for each side.
    fn neighbours(&self, joint: u32) -> impl Iterator<Item = u32> {
        self.corners(joint).flat_map(|c| self.beside(c)).map(|c| self.at(c)).filter(move |w| *w != joint)
    }

    /// Sides of polygons between two joints.
    fn faces(&self, joint: u32, other: u32) -> usize {
        self.neighbours(joint).filter(|w| *w == other).count()
    }

    /// Writes the joints to `same`; how far the places that are welded to another are from it on the mean.
    pub fn tell(&self, same: &mut [u32], place: impl Fn(u32) -> DVec3) -> f64 {
        let (mut sum, mut count) = (0.0, 0_usize);
        for v in (0..same.len() as u32).filter(|v| same[*v as usize] == *v && self.of(*v) != *v) {
            sum += place(v).distance(place(self.of(v)));
            count += 1;
        }
        same.iter_mut().filter(|s| **s != NONE).for_each(|s| *s = self.of(*s));
        sum / count.max(1) as f64
    }
}
