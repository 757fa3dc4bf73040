//! Exact overlaps of a UV map: which faces share interior points with another face.
//!
//! Broad phase: faces in Morton order of their middles under a tree of eight children a node, whose bounds are octagons
//! (x, y, x + y, x - y), so that slivers along a diagonal do not look like squares. Narrow phase: exact separating sides
//! on grid points ([`super::grid`]). A face asks the tree about the faces after it, until it has met one; if any has, those
//! that have not ask about the ones before: near-linear for a valid map and for one where everything lies on everything.
//! Faces ask side by side. Limits: faces are counted, not pairs (of which there can be f^2); long slivers at odd angles
//! side by side still cost their number squared in bound tests.

use super::grid::{GridTriangle, counter_clockwise, doubled_area, some_side_separates};
use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::base::stack::Stack;
use crate::base::workers::{Workers, for_each_chunk};
use crate::mesh::view::NONE;
use bytemuck::{Pod, Zeroable};
use core::ops::Range;

/// Children of a node, and faces of a leaf. A million faces of a valid lattice: 0.56 s; 4 children: 0.75 s; 16: slower
/// than 4. Boxes instead of octagons: as fast there, 3.3 times slower on slivers along a diagonal.
const CHILDREN: usize = 8;
/// Levels of the tree over up to 2^32 faces.
const LEVELS: usize = 11;

/// Faces that ask in one task.
const CHUNK: usize = 1024;

/// Bytes that [`overlaps`] needs: 45 a face.
pub const fn overlaps_need(faces: usize) -> usize {
    bytes_for::<u64>(faces)
        + bytes_for::<GridTriangle>(faces)
        + bytes_for::<Octagon>(node_capacity(faces))
        + 2 * bytes_for::<u32>(faces)
}

/// Writes, for each face, another face whose interior meets its own, or [`NONE`]; returns how many faces have one.
/// Faces without area have none. O(f log f) on maps as they occur; the outcome depends on the faces' order only.
pub fn overlaps(
    partner: &mut [u32],
    triangles: &[GridTriangle],
    mut scratch: Scratch,
    workers: &dyn Workers,
) -> Result<usize, ScratchTooSmall> {
    debug_assert_eq!(partner.len(), triangles.len(), "one partner a triangle");
    scratch.require(overlaps_need(triangles.len()))?;
    partner.fill(NONE);
    let order = morton_order(triangles, scratch.take::<u64>(triangles.len())?);
    let sorted = scratch.take::<GridTriangle>(order.len())?;
    order.iter().zip(sorted.iter_mut()).for_each(|(f, t)| *t = counter_clockwise(triangles[face(*f)]));
    let tree = BoxTree::new(sorted, scratch.take::<Octagon>(node_capacity(order.len()))?);
    let after = scratch.take::<u32>(order.len())?; // by place in the order, as the next
    let before = scratch.take::<u32>(order.len())?;
    for_each_chunk(workers, after, CHUNK, &|chunk, after| {
        for (slot, met) in (chunk * CHUNK..).zip(after) {
            *met = tree.first_met(slot, slot + 1..order.len(), |_| true);
        }
    });
    if after.iter().all(|met| *met == NONE) {
        return Ok(0);
    }
    let after = &*after;
    for_each_chunk(workers, before, CHUNK, &|chunk, before| {
        for (slot, met) in (chunk * CHUNK..).zip(before) {
            // An earlier face that met nothing has asked about this one already.
            *met = match after[slot] {
                NONE => tree.first_met(slot, 0..slot, |other| after[other] != NONE),
                met => met,
            };
        }
    });
    let mut count = 0;
    for (key, met) in order.iter().zip(before.iter()).filter(|(_, met)| **met != NONE) {
        partner[face(*key)] = face(order[*met as usize]) as u32;
        count += 1;
    }
    Ok(count)
}

/// How many triangles run clockwise, and how many have no area. A valid atlas has none of the first.
pub fn flips(triangles: &[GridTriangle]) -> (usize, usize) {
    triangles
        .iter()
        .map(doubled_area)
        .fold((0, 0), |(flipped, empty), area| (flipped + (area < 0) as usize, empty + (area == 0) as usize))
}

/// How a chart takes part in overlaps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChartOverlap {
    /// In none.
    #[default]
    Free,
    /// One of its faces was found on a face of another chart, and none on its own.
    Other,
    /// One of its faces was found on another of its own.
    Own,
}

/// Says for each chart how it takes part; `partner` from [`overlaps`], `chart` of each face (out of range: skipped).
/// A face names one partner only, so `Other` does not exclude overlaps inside the chart as well.
pub fn mark_charts(marks: &mut [ChartOverlap], partner: &[u32], chart: &[u32]) {
    marks.fill(ChartOverlap::Free);
    for (c, p) in chart.iter().zip(partner).filter(|(_, p)| **p != NONE) {
        let own = chart.get(*p as usize) == Some(c);
        if let Some(mark) = marks.get_mut(*c as usize) {
            match own {
                true => *mark = ChartOverlap::Own,
                false if *mark == ChartOverlap::Free => *mark = ChartOverlap::Other,
                false => {}
            }
        }
    }
}

/// A slice (low, high) of the plane along each of x, y, x + y, x - y.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Octagon {
    low: [i32; 4],
    high: [i32; 4],
}

impl Octagon {
    const EMPTY: Self = Self { low: [i32::MAX; 4], high: [i32::MIN; 4] };

    fn of(t: &GridTriangle) -> Self {
        t.iter().fold(Self::EMPTY, |b, p| {
            let along = [p.x(), p.y(), p.x().wrapping_add(p.y()), p.x().wrapping_sub(p.y())];
            b.join(&Self { low: along, high: along })
        })
    }

    fn join(&self, other: &Self) -> Self {
        Self {
            low: core::array::from_fn(|k| self.low[k].min(other.low[k])),
            high: core::array::from_fn(|k| self.high[k].max(other.high[k])),
        }
    }

    /// Whether the open octagons meet: interiors of what is inside cannot where only the borders do.
    #[inline]
    fn meets(&self, other: &Self) -> bool {
        (0..4).fold(true, |all, k| all & (self.low[k] < other.high[k]) & (other.low[k] < self.high[k]))
    }
}

/// The faces with area as (Morton code << 32 | face), sorted.
fn morton_order<'a>(triangles: &[GridTriangle], keys: &'a mut [u64]) -> &'a mut [u64] {
    let bounds = triangles.iter().fold(Octagon::EMPTY, |b, t| b.join(&Octagon::of(t)));
    let size = |k: usize| bounds.high[k].wrapping_sub(bounds.low[k]) as u32;
    let shift = 16u32.saturating_sub(size(0).max(size(1)).leading_zeros());
    let cell = |low: i32, high: i32, k: usize| {
        let middle = ((low as i64 + high as i64) / 2 - bounds.low[k] as i64).max(0) as u64;
        spread_bits((middle >> shift) & 0xFFFF)
    };
    let mut count = 0;
    for (f, t) in triangles.iter().enumerate().filter(|(_, t)| doubled_area(t) != 0) {
        let b = Octagon::of(t);
        let code = cell(b.low[0], b.high[0], 0) | cell(b.low[1], b.high[1], 1) << 1;
        keys[count] = code << 32 | f as u64;
        count += 1;
    }
    let keys = &mut keys[..count];
    sort::ascending(keys);
    keys
}

fn face(key: u64) -> usize {
    key as u32 as usize
}

/// Puts a zero between each two of the lower 16 bits.
fn spread_bits(x: u64) -> u64 {
    let x = (x | x << 8) & 0x00FF_00FF;
    let x = (x | x << 4) & 0x0F0F_0F0F;
    let x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

/// Nodes of all levels together: f/8 + f/64 + ... rounded up each.
const fn node_capacity(faces: usize) -> usize {
    faces / (CHILDREN - 1) + LEVELS
}

/// Node i of a level bounds nodes 8 i .. 8 i + 8 of the level below; below level 0 are the triangles.
struct BoxTree<'a> {
    triangles: &'a [GridTriangle],
    nodes: &'a [Octagon],
    start: [usize; LEVELS + 1], // of each level in `nodes`
    levels: usize,
}

impl<'a> BoxTree<'a> {
    fn new(triangles: &'a [GridTriangle], nodes: &'a mut [Octagon]) -> Self {
        let mut start = [0; LEVELS + 1];
        let mut levels = 0;
        for (i, leaf) in triangles.chunks(CHILDREN).enumerate() {
            nodes[i] = leaf.iter().fold(Octagon::EMPTY, |b, t| b.join(&Octagon::of(t)));
        }
        start[1] = triangles.len().div_ceil(CHILDREN);
        while start[levels + 1] - start[levels] > 1 {
            levels += 1;
            let (below, above) = nodes.parted_mut(start[levels]);
            let below = &below[start[levels - 1]..];
            start[levels + 1] = start[levels] + below.len().div_ceil(CHILDREN);
            for (i, c) in below.chunks(CHILDREN).enumerate() {
                above[i] = c.iter().fold(Octagon::EMPTY, |b, child| b.join(child));
            }
        }
        Self { triangles, nodes, start, levels: levels + 1 }
    }

    /// The first triangle of `window` that is `open` and meets triangle `slot`, or [`NONE`].
    fn first_met(&self, slot: usize, window: Range<usize>, open: impl Fn(usize) -> bool) -> u32 {
        let triangle = &self.triangles[slot];
        let bound = Octagon::of(triangle);
        // Each level leaves at most seven siblings behind.
        let mut stack = Stack::<(u8, u32), { (CHILDREN - 1) * LEVELS + 1 }>::new();
        let mut next = Some((self.levels as u8 - 1, 0));
        while let Some((level, index)) = next {
            let (level, index) = (level as usize, index as usize);
            if self.nodes[self.start[level] + index].meets(&bound) {
                // Children whose triangles are in the window.
                let bits = level as u32 * CHILDREN.ilog2();
                let first = (index * CHILDREN).max(window.start >> bits);
                let end = ((index + 1) * CHILDREN).min((window.end + (1 << bits) - 1) >> bits);
                if level > 0 {
                    for child in (first..end).rev() {
                        stack.push((level as u8 - 1, child as u32));
                    }
                } else {
                    let met = |other: &usize| {
                        let t = &self.triangles[*other];
                        open(*other)
                            && Octagon::of(t).meets(&bound)
                            && !some_side_separates(triangle, t)
                            && !some_side_separates(t, triangle)
                    };
                    if let Some(other) = (first..end).find(met) {
                        return other as u32;
                    }
                }
            }
            next = stack.pop();
        }
        NONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::hash;
    use crate::base::workers::Serial;
    use crate::base::workers::tests::Backwards;
    use crate::plane::grid::tests::{oracle_meets, random_triangle, triangle};
    use std::{vec, vec::Vec};

    fn partners(triangles: &[GridTriangle]) -> Vec<u32> {
        let mut bytes = vec![0; overlaps_need(triangles.len())];
        let mut partner = vec![7; triangles.len()];
        let count = overlaps(&mut partner, triangles, Scratch::new(&mut bytes), &Serial).unwrap();
        assert_eq!(count, partner.iter().filter(|p| **p != NONE).count());
        let mut again = vec![7; triangles.len()];
        overlaps(&mut again, triangles, Scratch::new(&mut bytes), &Backwards).unwrap();
        assert_eq!(partner, again, "threads change what is found");
        partner
    }

    /// Two faces a cell of a `side` x `side` lattice of unit squares of `step`, wrung by a seeded shift of its points
    /// small enough that nothing folds.
    fn lattice(side: i32, step: i32) -> Vec<GridTriangle> {
        let point = |x: i32, y: i32| {
            let shift = |k: u64| (hash(3, k, (x * 10_000 + y) as u64) % (step as u64 / 2)) as i32;
            [x * step + shift(0), y * step + shift(1)]
        };
        let mut faces = vec![];
        for (x, y) in (0..side * side).map(|i| (i % side, i / side)) {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| point(x + i, y + j));
            // The diagonal through the larger of two opposite angles keeps both faces counter-clockwise.
            let split = [[a, b, c], [a, c, d]].map(triangle);
            let other = [[a, b, d], [b, c, d]].map(triangle);
            faces.extend(if split.iter().all(|t| doubled_area(t) > 0) { split } else { other });
        }
        faces
    }

    #[test]
    fn two_squares_side_by_side_do_not_overlap_and_a_fold_does() {
        let square = |x: i32| [[[x, 0], [x + 9, 0], [x + 9, 9]], [[x, 0], [x + 9, 9], [x, 9]]].map(triangle);
        assert_eq!(partners(&[square(0), square(9)].concat()), [NONE; 4]);
        assert_eq!(partners(&[triangle([[0, 0], [9, 0], [0, 9]]), triangle([[9, 0], [0, 9], [1, 1]])]), [1, 0]);
        assert_eq!(partners(&[]), []);
    }

    #[test]
    fn a_lattice_is_valid_until_one_point_crosses() {
        let mut faces = lattice(60, 100);
        assert_eq!(flips(&faces), (0, 0));
        assert!(partners(&faces).iter().all(|p| *p == NONE));
        faces[3000][0] = faces[3010][1];
        assert!(partners(&faces)[3000] != NONE);
    }

    #[test]
    fn partners_are_right_and_complete_against_all_pairs() {
        // From sparse to piled up; small sides give many faces that only touch or have no area.
        for (seed, count, side, spread) in
            [(0, 300, 6, 100), (1, 300, 6, 30), (2, 400, 4, 12), (3, 500, 50, 1000), (4, 300, 9, 1)]
        {
            let faces: Vec<GridTriangle> = (0..count)
                .map(|i| {
                    let offset = [0, 1].map(|k| (hash(seed, i, k) % spread) as i32);
                    random_triangle(seed * 1000 + i, side, offset)
                })
                .collect();
            let found = partners(&faces);
            for (i, p) in found.iter().enumerate() {
                let meets = |j: usize| j != i && oracle_meets(&faces[i], &faces[j]);
                match *p {
                    NONE => assert!(!(0..faces.len()).any(meets), "seed {seed}: face {i} was missed"),
                    p => assert!(meets(p as usize), "seed {seed}: faces {i} and {p} do not meet"),
                }
            }
        }
    }

    #[test]
    fn a_pile_of_equal_faces_is_found_without_looking_at_all_pairs() {
        let pile = vec![triangle([[0, 0], [99, 0], [0, 99]]); 100_000];
        assert!(partners(&pile).iter().all(|p| *p != NONE));
    }

    #[test]
    fn charts_are_marked_by_what_their_faces_met() {
        let mut marks = [ChartOverlap::Own; 4];
        mark_charts(&mut marks, &[1, 0, 3, 0, NONE], &[0, 0, 1, 2, 3]);
        assert_eq!(marks, [ChartOverlap::Own, ChartOverlap::Other, ChartOverlap::Other, ChartOverlap::Free]);
        mark_charts(&mut [], &[1, 0], &[5, NONE]);
    }

    #[test]
    fn one_byte_less_is_refused_and_nothing_is_written() {
        let faces = [triangle([[0, 0], [9, 0], [0, 9]]); 3];
        let mut bytes = vec![0; overlaps_need(3) - 1];
        let mut partner = [5; 3];
        assert!(overlaps(&mut partner, &faces, Scratch::new(&mut bytes), &Serial).is_err());
        assert_eq!(partner, [5; 3]);
    }

    #[test]
    fn the_whole_grid_can_be_used() {
        use crate::plane::grid::LIMIT;
        let (l, h) = (-LIMIT, LIMIT);
        let faces = [[[l, l], [h, l], [h, h]], [[l, l], [h, h], [l, h]]].map(triangle);
        assert_eq!(partners(&faces), [NONE, NONE]);
        assert_eq!(partners(&[faces[0], faces[0]]), [1, 0]);
    }
}
