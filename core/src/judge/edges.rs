//! Edges of a UV map, seams and folds among them, and the charts that they leave.

use super::stacks::{find_stacks, find_stacks_need};
use crate::base::buckets::{Buckets, buckets_need};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::union_find::UnionFind;
use crate::mesh::view::NONE;
use bytemuck::{Pod, Zeroable};
use glam::DVec2;

/// An edge of the welded mesh between faces that have UV.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Edge {
    /// The end with the lower vertex number.
    pub low: u32,
    /// The other end; the same as `low` along a face that names one place twice.
    pub high: u32,
    /// Faces that have it as a side.
    pub face_count: u32,
    /// 1 where the map is cut along it, else 0.
    pub seam: u32,
    /// The first two of these faces; [`NONE`] where there is no second one.
    pub faces: [u32; 2],
}

impl Edge {
    /// Whether the map is cut along this edge.
    pub fn is_seam(&self) -> bool {
        self.seam != 0
    }
}

/// The ends of half-edges; half-edge `side * f + face` runs from corner `side` of `face` to the next corner.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    pub triangles: &'a [[u32; 3]],
    pub corner_uv: &'a [[DVec2; 3]],
    pub welded: &'a [u32],
    pub wedge: &'a [[u32; 3]],
}

impl Ends<'_> {
    pub fn face_side(&self, half_edge: u32) -> (usize, usize) {
        let (at, faces) = (half_edge as usize, self.triangles.len());
        let side = usize::from(at >= faces) + usize::from(at >= 2 * faces);
        (at - side * faces, side)
    }

    /// (low vertex, high vertex).
    fn vertices(&self, half_edge: u32) -> (u32, u32) {
        let (face, side) = self.face_side(half_edge);
        let [a, b] = [side, (side + 1) % 3].map(|i| self.welded[self.triangles[face][i] as usize]);
        (a.min(b), a.max(b))
    }

    /// (wedge at the low vertex, wedge at the high vertex).
    pub fn wedges(&self, half_edge: u32) -> (u32, u32) {
        let (face, side) = self.face_side(half_edge);
        let next = (side + 1) % 3;
        let [a, b] = [side, next].map(|i| self.welded[self.triangles[face][i] as usize]);
        let (p, q) = (self.wedge[face][side], self.wedge[face][next]);
        if a < b { (p, q) } else { (q, p) }
    }

    /// (vertex of the file at the low end, vertex of the file at the high end).
    fn own_vertices(&self, half_edge: u32) -> (u32, u32) {
        let (face, side) = self.face_side(half_edge);
        let [a, b] = [side, (side + 1) % 3].map(|i| self.triangles[face][i]);
        if self.welded[a as usize] <= self.welded[b as usize] { (a, b) } else { (b, a) }
    }

    /// Do the faces at one place each share the file's own vertices with another? Sorts them by these vertices if so.
    fn are_copies(&self, group: &mut [u32]) -> bool {
        let own = |h: &u32| self.own_vertices(*h);
        sort::by_key(group, |h| (own(h), *h));
        let copies = group.runs(|a, b| own(a) == own(b)).all(|g| g.len() > 1);
        if !copies {
            sort::by_key(group, |h| *h);
        }
        copies
    }

    /// On which side of a half-edge in UV, from its low vertex to its high one, its face lies: 1, -1, or 0 of one without area.
    fn lies_on(&self, half_edge: u32) -> i32 {
        let (face, side) = self.face_side(half_edge);
        let [p, q, tip] = [side, (side + 1) % 3, (side + 2) % 3].map(|i| self.corner_uv[face][i]);
        let [a, b] = [side, (side + 1) % 3].map(|i| self.welded[self.triangles[face][i] as usize]);
        let turn = (q - p).perp_dot(tip - p) * if a < b { 1.0 } else { -1.0 };
        i32::from(turn > 0.0) - i32::from(turn < 0.0)
    }

    /// Whether the faces of two half-edges, which have the same wedges, are on one side of them.
    fn are_folded(&self, a: u32, b: u32) -> bool {
        self.lies_on(a) * self.lies_on(b) > 0
    }

    pub fn has_uv(&self, half_edge: u32) -> bool {
        self.wedge[self.face_side(half_edge).0][0] != NONE
    }
}

/// Bytes that [`join`] needs.
pub(super) const fn join_need(vertices: usize, faces: usize) -> usize {
    let group = buckets_need(if vertices > 3 * faces { vertices } else { 3 * faces }, 3 * faces);
    let stacks = bytes_for::<u32>(faces) + find_stacks_need(faces);
    bytes_for::<u32>(faces) + bytes_for::<[u32; 2]>(3 * faces) + if group > stacks { group } else { stacks }
}

/// Lists edges and joins faces into charts; returns how many of both there are.
pub(super) fn join(
    edges: &mut [Edge],
    chart: &mut [u32],
    seam_sides: &mut [u8],
    ends: Ends,
    bits: i32,
    mut scratch: Scratch,
) -> Result<(usize, usize), ScratchTooSmall> {
    let faces = ends.triangles.len();
    let mut sets = UnionFind::new(scratch.take::<u32>(faces)?);
    let folds = scratch.take::<[u32; 2]>(3 * faces)?;
    let (edge_count, fold_count) = list_edges(edges, folds, seam_sides, &mut sets, ends, scratch.frame())?;
    let mut chart_count = number_charts(chart, ends, &mut sets);
    let folds = &folds[..fold_count];
    if !folds.is_empty() {
        let stack = scratch.take::<u32>(chart_count)?;
        find_stacks(stack, ends.corner_uv, chart, bits, scratch)?;
        for fold in folds {
            let [a, b] = fold.map(|f| stack[chart[f as usize] as usize]);
            if a != b || a == NONE {
                sets.union(fold[0], fold[1]);
            }
        }
        chart_count = number_charts(chart, ends, &mut sets);
    }
    Ok((edge_count, chart_count))
}

/// Lists edges, and joins faces across them but for those in `folds`, which may be folds; returns how many of both there are.
fn list_edges(
    edges: &mut [Edge],
    folds: &mut [[u32; 2]],
    seam_sides: &mut [u8],
    sets: &mut UnionFind,
    ends: Ends,
    mut scratch: Scratch,
) -> Result<(usize, usize), ScratchTooSmall> {
    let faces = ends.triangles.len();
    let key = |h: u32| ends.has_uv(h).then(|| ends.vertices(h).0);
    let mut half_edges = Buckets::new(ends.welded.len(), 3 * faces, key, &mut scratch)?;
    let (mut edge_count, mut fold_count) = (0, 0);
    for v in 0..half_edges.key_count() {
        let here = half_edges.get_mut(v);
        sort::by_key(here, |h| (ends.vertices(*h).1, *h));
        let mut rest = here;
        while let Some(first) = rest.first() {
            let high = ends.vertices(*first).1;
            let count = rest.iter().take_while(|h| ends.vertices(**h).1 == high).count();
            let (group, others) = rest.parted_mut(count);
            rest = others;
            let copies = group.len() > 2 && ends.are_copies(group);
            for group in group.runs(|a, b| !copies || ends.own_vertices(*a) == ends.own_vertices(*b)) {
                edges[edge_count] = join_edge(group, seam_sides, ends, sets, |pair| {
                    folds[fold_count] = pair;
                    fold_count += 1;
                });
                edge_count += 1;
            }
        }
    }
    Ok((edge_count, fold_count))
}

/// Joins the faces of one edge, given by their sides of it, where their wedges are the same; `fold` is given those that lie on one side.
fn join_edge(
    group: &[u32],
    seam_sides: &mut [u8],
    ends: Ends,
    sets: &mut UnionFind,
    mut fold: impl FnMut([u32; 2]),
) -> Edge {
    let face = |h: u32| ends.face_side(h).0 as u32;
    let mut seam = false;
    for (i, &h) in group.iter().enumerate() {
        // Of faces with the same wedges the first joins all; the square of an edge's faces is no matter.
        let mut same = group[..i].iter().filter(|other| ends.wedges(**other) == ends.wedges(h));
        match same.clone().next() {
            None => seam |= i > 0,
            Some(first) => match same.find(|other| !ends.are_folded(**other, h)) {
                Some(other) => drop(sets.union(face(*other), face(h))),
                None => fold([face(*first), face(h)]),
            },
        }
    }
    if seam {
        group.iter().map(|h| ends.face_side(*h)).for_each(|(face, side)| seam_sides[face] |= 1 << side);
    }
    let (low, high) = ends.vertices(group[0]);
    let faces = [0, 1].map(|i| group.get(i).map_or(NONE, |h| face(*h)));
    Edge { low, high, face_count: group.len() as u32, seam: seam as u32, faces }
}

/// A set's root is its smallest face, so it comes by before the set's other faces.
fn number_charts(chart: &mut [u32], ends: Ends, sets: &mut UnionFind) -> usize {
    let mut count = 0;
    for f in (0..chart.len()).filter(|f| ends.wedge[*f][0] != NONE) {
        let root = sets.find(f as u32) as usize;
        if root == f {
            chart[f] = count;
            count += 1;
        } else {
            chart[f] = chart[root];
        }
    }
    count as usize
}
