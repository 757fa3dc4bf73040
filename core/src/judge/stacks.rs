//! Charts that lie on others on purpose: borders and vertices of the one have the same places in UV as those of the other.
//!
//! Copies and mirror images are laid over one another so that they share their texels; then whole charts coincide, whichever way they
//! face. Where quads are parted along other diagonals their triangles differ, but what has no flip and the same border covers the same
//! places, each once: a map that keeps orientation covers a point as often as its border winds around it. A chart that coincides with
//! another in part, or whose vertices lie elsewhere, overlaps it: that is a fault. O(f log f).

use crate::base::scratch::{Scratch, ScratchTooSmall, bytes_for};
use crate::base::slices::Slices;
use crate::base::sort;
use crate::mesh::view::NONE;
use crate::plane::grid::GridPoint;
use bytemuck::{Pod, Zeroable};
use core::cmp::Ordering;
use glam::DVec2;

/// What lies on others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stacked {
    /// Charts.
    pub charts: usize,
    /// Their faces.
    pub faces: usize,
}

/// A side of a face, or a corner where both ends are the same.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
struct ChartSide {
    chart: u32,
    low: GridPoint, // by x, then y
    high: GridPoint,
}

impl ChartSide {
    fn ends(&self) -> [(i32, i32); 2] {
        [self.low, self.high].map(|p| (p.x(), p.y()))
    }
}

/// Bytes that [`find_stacks`] needs.
pub const fn find_stacks_need(faces: usize) -> usize {
    bytes_for::<ChartSide>(6 * faces) + 2 * bytes_for::<u32>(faces + 1)
}

/// Writes to `stack` the first of the charts that coincide with each, `NONE` for one that lies alone, on a grid of 2^-`bits`.
/// `stack` has an entry a chart; `chart` has one a face, [`NONE`] without UV.
pub fn find_stacks(
    stack: &mut [u32],
    corner_uv: &[[DVec2; 3]], // (f)
    chart: &[u32],            // (f)
    bits: i32,
    mut scratch: Scratch,
) -> Result<(), ScratchTooSmall> {
    scratch.require(find_stacks_need(chart.len()))?;
    stack.fill(NONE);
    let sides = scratch.take::<ChartSide>(6 * chart.len())?;
    let mut count = 0;
    for (uv, chart) in corner_uv.iter().zip(chart).filter(|(_, chart)| **chart != NONE) {
        let p = uv.map(|uv| GridPoint::snap(uv, bits));
        for [a, b] in [[0, 1], [1, 2], [2, 0], [0, 0], [1, 1], [2, 2]].map(|ends| ends.map(|i: usize| p[i])) {
            let rises = (a.x(), a.y()) <= (b.x(), b.y());
            let [low, high] = if rises { [a, b] } else { [b, a] };
            sides[count] = ChartSide { chart: *chart, low, high };
            count += 1;
        }
    }
    let count = keep_outlines(&mut sides[..count]);
    let sides = &sides[..count];
    let start = scratch.take::<u32>(stack.len() + 1)?;
    sides.iter().for_each(|side| start[side.chart as usize + 1] += 1);
    for k in 0..stack.len() {
        start[k + 1] += start[k];
    }
    let outline = |k: u32| &sides[start[k as usize] as usize..start[k as usize + 1] as usize];
    let compare = |a: u32, b: u32| -> Ordering {
        let (a, b) = (outline(a), outline(b));
        a.len().cmp(&b.len()).then_with(|| a.iter().map(ChartSide::ends).cmp(b.iter().map(ChartSide::ends)))
    };
    let order = scratch.take::<u32>(stack.len())?;
    order.iter_mut().zip(0..).for_each(|(to, k)| *to = k);
    sort::by(order, |a, b| compare(*a, *b).then(a.cmp(b)));
    for alike in order.runs(|a, b| compare(*a, *b).is_eq()) {
        if let [first, _, ..] = alike
            && outline(*first).iter().any(|side| side.low != side.high)
        {
            alike.iter().for_each(|k| stack[*k as usize] = *first);
        }
    }
    Ok(())
}

/// Sorts sides and keeps those that a chart has on one side only, and one corner of each place; returns how many.
fn keep_outlines(sides: &mut [ChartSide]) -> usize {
    sort::by_key(sides, |side| (side.chart, side.ends()));
    let (mut kept, mut at) = (0, 0);
    while at < sides.len() {
        let side = sides[at];
        let same = sides[at..].iter().take_while(|other| **other == side).count();
        if same & 1 == 1 || side.low == side.high {
            sides[kept] = side;
            kept += 1;
        }
        at += same;
    }
    kept
}

/// Bytes that [`find_stacked`] needs.
pub const fn find_stacked_need(faces: usize) -> usize {
    bytes_for::<u32>(faces) + find_stacks_need(faces)
}

/// Marks in `stacked` the faces of all charts but the first of those that coincide; see [`find_stacks`].
pub fn find_stacked(
    stacked: &mut [u8], // (f)
    corner_uv: &[[DVec2; 3]],
    chart: &[u32],
    chart_count: usize,
    bits: i32,
    mut scratch: Scratch,
) -> Result<Stacked, ScratchTooSmall> {
    let stack = scratch.take::<u32>(chart_count)?;
    find_stacks(stack, corner_uv, chart, bits, scratch)?;
    let lies_on = |k: u32| stack.get(k as usize).is_some_and(|first| *first != NONE && *first != k);
    stacked.iter_mut().zip(chart).for_each(|(mark, k)| *mark = lies_on(*k).into());
    let faces = stacked.iter().filter(|mark| **mark != 0).count();
    Ok(Stacked { charts: (0..stack.len() as u32).filter(|k| lies_on(*k)).count(), faces })
}
