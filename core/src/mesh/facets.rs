//! The triangles of the working copy, polygon after polygon, with their diagonals paired.
//!
//! Corners that repeat the vertex before them, and spikes (a, b, a), are left out of a polygon before it is
//! triangulated. A polygon that still meets a vertex twice is a hole joined to its outline by a slit, and stays whole if
//! triangles tile it; otherwise it is pinched, and falls into rings that meet each vertex once. One that names its vertices
//! again and again is damaged: the largest of its rings stays. Polygons that are [`idle`](super::idle) make no triangle.
//! So every triangle has three different vertices, and all triangles of one ring hang together by diagonals.

use super::draft::Draft;
use super::polygon::{link_diagonals, triangulate, triangulate_need};
use super::polygons::Polygons;
use super::unit_box::UnitBox;
use super::view::NONE;
use super::working::DIAGONAL;
use crate::base::random;
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use glam::DVec3;

/// Scratch bytes for [`facets`]: `n` vertices, polygons of at most `longest` corners.
pub(super) const fn facets_need(n: usize, longest: usize) -> usize {
    bytes_for::<u32>(n)
        .saturating_add(bytes_for::<u32>(longest).saturating_mul(3))
        .saturating_add(bytes_for::<DVec3>(longest))
        .saturating_add(bytes_for::<[u32; 3]>(longest))
        .saturating_add(triangulate_need(longest))
}

/// A pinched polygon is damaged if it names a vertex more often than this on the mean. Rings that touch and bridges between
/// them name theirs twice at the most.
const MOST_NAMED: usize = 2;

/// What [`facets`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FacetCounts {
    /// Triangles.
    pub triangles: usize,
    /// Polygons without any.
    pub dropped: usize,
    /// Polygons that are damaged.
    pub damaged: usize,
}

/// Fills `draft` with the triangles of all polygons that are not `idle` (none where the list is empty) and `signature` (one a
/// polygon) with a hash of its set of vertices.
#[allow(clippy::too_many_arguments)]
pub(super) fn facets(
    draft: &mut Draft,
    signature: &mut [u64],
    input: &Polygons,
    same: &[u32], // the lowest vertex at the place of each vertex
    idle: &[u8],  // (p), or nothing
    unit: &UnitBox,
    longest: usize,
    mut scratch: Scratch,
) -> Result<FacetCounts, ScratchTooSmall> {
    let seen = scratch.take_filled::<u32>(same.len(), NONE)?;
    let mut facets = Facets {
        input,
        same,
        unit,
        draft,
        count: 0,
        points: scratch.take(longest)?,
        triangles: scratch.take(longest)?,
        behind: scratch.take(longest)?,
    };
    let (ring, stack) = (scratch.take::<u32>(longest)?, scratch.take::<u32>(longest)?);
    let mut found = FacetCounts::default();
    for (p, corners) in input.polygons().enumerate() {
        if idle.get(p).is_some_and(|idle| *idle != 0) {
            found.dropped += 1;
            continue;
        }
        let before = facets.count;
        let length = facets.reduce(ring, corners);
        let ring = &ring[..length];
        signature[p] = ring.iter().fold(0, |sum, &c| sum.wrapping_add(random::hash(0, 0, facets.vertex(c).into())));
        if length >= 3 {
            let tiled = facets.triangulate(ring, &mut scratch)?;
            if !tiled && facets.meets_a_vertex_twice(ring, seen) {
                found.damaged += usize::from(facets.unpinch(p as u32, ring, stack, seen, &mut scratch)?);
            } else {
                facets.append(p as u32, ring);
            }
        }
        found.dropped += usize::from(facets.count == before);
    }
    found.triangles = facets.count;
    Ok(found)
}

/// A vertex that was met and is not on the stack.
const MET: u32 = NONE - 1;

struct Facets<'s, 'd> {
    input: &'s Polygons<'s>,
    same: &'s [u32],
    unit: &'s UnitBox,
    draft: &'s mut Draft<'d>,
    count: usize,
    points: &'s mut [DVec3],
    triangles: &'s mut [[u32; 3]],
    behind: &'s mut [u32],
}

impl Facets<'_, '_> {
    fn vertex(&self, corner: u32) -> u32 {
        self.same[self.input.corners[corner as usize] as usize]
    }

    /// Fills `ring` with the corners that stay after repeats and spikes are taken out, the first of each where there
    /// is a choice. Returns how many.
    fn reduce(&self, ring: &mut [u32], corners: core::ops::Range<u32>) -> usize {
        let mut end = 0;
        for corner in corners {
            let v = self.vertex(corner);
            if end >= 1 && self.vertex(ring[end - 1]) == v {
                continue;
            }
            if end >= 2 && self.vertex(ring[end - 2]) == v {
                end -= 1;
                continue;
            }
            ring[end] = corner;
            end += 1;
        }
        // The same where the end meets the beginning.
        let mut start = 0;
        loop {
            let at = |i: usize| self.vertex(ring[i]);
            if end - start >= 2 && at(end - 1) == at(start) {
                end -= 1;
            } else if end - start >= 3 && at(end - 2) == at(start) {
                end -= 2;
            } else if end - start >= 3 && at(end - 1) == at(start + 1) {
                start += 1;
                end -= 1;
            } else {
                break;
            }
        }
        (start..end).enumerate().for_each(|(to, from)| ring[to] = ring[from]);
        end - start
    }

    fn meets_a_vertex_twice(&self, ring: &[u32], seen: &mut [u32]) -> bool {
        if ring.len() < 6 {
            return false; // it would have a spike
        }
        let mut twice = false;
        for &c in ring {
            twice |= core::mem::replace(&mut seen[self.vertex(c) as usize], c) != NONE;
        }
        ring.iter().for_each(|&c| seen[self.vertex(c) as usize] = NONE);
        twice
    }

    fn triangulate(&mut self, ring: &[u32], scratch: &mut Scratch) -> Result<bool, ScratchTooSmall> {
        for (point, &c) in self.points.iter_mut().zip(ring) {
            *point = self.unit.place(self.input.positions[self.input.corners[c as usize] as usize]);
        }
        triangulate(&mut self.triangles[..ring.len() - 2], &self.points[..ring.len()], scratch.frame())
    }

    /// Cuts `ring` into rings that meet no vertex twice, and triangulates each, or of a damaged polygon the largest. Returns
    /// whether it is damaged.
    fn unpinch(
        &mut self,
        polygon: u32,
        ring: &[u32],
        stack: &mut [u32],
        seen: &mut [u32],
        scratch: &mut Scratch,
    ) -> Result<bool, ScratchTooSmall> {
        let (mut count, mut largest) = (0, (0.0, 0));
        let named = self.for_rings(ring, stack, seen, |facets, ring| {
            let area = facets.area(ring);
            largest = if area > largest.0 { (area, count) } else { largest };
            count += 1;
            Ok(())
        })?;
        let damaged = ring.len() > MOST_NAMED * named;
        count = 0;
        self.for_rings(ring, stack, seen, |facets, ring| {
            if ring.len() >= 3 && (!damaged || count == largest.1) {
                facets.triangulate(ring, scratch)?;
                facets.append(polygon, ring);
            }
            count += 1;
            Ok(())
        })?;
        Ok(damaged)
    }

    /// Takes each of the rings of `ring` that meet no vertex twice: each time a vertex is met again, the corners since it was
    /// met first are a ring, and its later corner stands in the rest. Returns how many vertices there are.
    fn for_rings(
        &mut self,
        ring: &[u32],
        stack: &mut [u32],
        seen: &mut [u32], // where on the stack a vertex stands
        mut take: impl FnMut(&mut Self, &[u32]) -> Result<(), ScratchTooSmall>,
    ) -> Result<usize, ScratchTooSmall> {
        let (mut height, mut named) = (0, 0);
        for &c in ring {
            let first = seen[self.vertex(c) as usize];
            if first == NONE || first == MET {
                named += usize::from(first == NONE);
            } else {
                let first = first as usize;
                take(self, &stack[first..height])?;
                stack[first + 1..height].iter().for_each(|&c| seen[self.vertex(c) as usize] = MET);
                height = first;
            }
            seen[self.vertex(c) as usize] = height as u32;
            stack[height] = c;
            height += 1;
        }
        take(self, &stack[..height])?;
        ring.iter().for_each(|&c| seen[self.vertex(c) as usize] = NONE);
        Ok(named)
    }

    /// Twice the area of a ring, squared.
    fn area(&self, ring: &[u32]) -> f64 {
        let at = |c: u32| self.unit.place(self.input.positions[self.input.corners[c as usize] as usize]);
        let Some(origin) = ring.first().map(|c| at(*c)) else { return 0.0 };
        let sum = ring.windows(2).fold(DVec3::ZERO, |sum, c| sum + (at(c[0]) - origin).cross(at(c[1]) - origin));
        sum.length_squared()
    }

    /// Puts the triangles of `ring` at the end of the draft.
    fn append(&mut self, polygon: u32, ring: &[u32]) {
        let triangles = &self.triangles[..ring.len() - 2];
        let halves = 3 * self.count..3 * (self.count + triangles.len());
        let twin = &mut self.draft.twin[halves.clone()];
        link_diagonals(twin, triangles, halves.start as u32, &mut self.behind[..ring.len()]);
        for (mark, twin) in self.draft.fixed[halves.clone()].iter_mut().zip(twin) {
            *mark = if *twin == NONE { 0 } else { DIAGONAL };
        }
        for (source, &i) in self.draft.corner_source[halves].iter_mut().zip(triangles.as_flattened()) {
            *source = ring[i as usize];
        }
        for t in triangles {
            self.draft.faces[self.count] = t.map(|i| self.vertex(ring[i as usize]));
            self.draft.polygon[self.count] = polygon;
            self.count += 1;
        }
    }
}
